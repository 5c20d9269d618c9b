//! Reads profiles of `UF_Value` from files for `build` and `doctor`, and warns about unverified
//! profiles.

use crate::diagnostics::{Diagnostic, codes};
use crate::engine::files;
use crate::source::SourceMap;
use crate::station::profile::{Profile, read};
use std::io::Read;
use std::path::Path;

/// Maximum size of a profile file in bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Reads the profile in a file, or returns the assumed profile if no path is given. Adds the file's
/// text to `sources`.
pub fn load(path: Option<&Path>, sources: &mut SourceMap) -> Result<Profile, Vec<Diagnostic>> {
    let Some(path) = path else {
        return Ok(Profile::assumed());
    };
    let text = text(path, MAX_FILE_BYTES).map_err(|finding| vec![*finding])?;
    let file = sources.add(path.display().to_string(), text.as_str());
    read::parse(file, &text)
}

/// Reads a file of at most `max_bytes`; invalid UTF-8 becomes a character that no parser accepts.
pub fn text(path: &Path, max_bytes: u64) -> Result<String, Box<Diagnostic>> {
    let unreadable = |why: String| {
        let message = format!("{} cannot be read: {why}", path.display());
        Box::new(
            Diagnostic::error(codes::FILE_UNREADABLE, None, message)
                .with_help("check the path and the permissions of the file"),
        )
    };
    files::is_regular(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // Reads one byte more than allowed: the length can change while the file is read.
    std::fs::File::open(path)
        .and_then(|file| file.take(max_bytes + 1).read_to_end(&mut bytes))
        .map_err(|e| unreadable(e.to_string()))?;
    if bytes.len() as u64 > max_bytes {
        return Err(unreadable(format!("it has more than {max_bytes} bytes")));
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Note that a profile is not verified; `None` if it is.
pub fn note_if_unverified(profile: &Profile) -> Option<Diagnostic> {
    (!profile.is_verified()).then(|| {
        let message = format!("the layout of UF_Value is {}", profile.label());
        Diagnostic::note(codes::PROFILE_UNVERIFIED, None, message)
            .with_help("find the layout of your Plant Simulation with `build --probe`; `linewright explain LW541` says how")
    })
}
