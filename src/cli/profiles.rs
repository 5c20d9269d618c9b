//! Profiles of `UF_Value` as files: reading them for `build` and `doctor`, and the warning about an
//! unverified one.

use crate::diagnostics::{Diagnostic, codes};
use crate::engine::files;
use crate::source::SourceMap;
use crate::station::profile::{Profile, read};
use std::io::Read;
use std::path::Path;

/// Maximum size of a profile.
const LARGEST_FILE: u64 = 1 << 20;

/// The profile in a file, or the assumed one if none is given. The file's text is added to
/// `sources`.
pub fn load(path: Option<&Path>, sources: &mut SourceMap) -> Result<Profile, Vec<Diagnostic>> {
    let Some(path) = path else {
        return Ok(Profile::assumed());
    };
    let text = text(path, LARGEST_FILE).map_err(|finding| vec![*finding])?;
    let file = sources.add(path.display().to_string(), text.as_str());
    read::parse(file, &text)
}

/// The text of a file of bounded size; invalid UTF-8 becomes a character that no parser accepts.
pub fn text(path: &Path, largest: u64) -> Result<String, Box<Diagnostic>> {
    let unreadable = |why: String| {
        let message = format!("{} cannot be read: {why}", path.display());
        Box::new(
            Diagnostic::error(codes::FILE_UNREADABLE, None, message)
                .with_help("check the path, and that the file may be read"),
        )
    };
    files::is_regular(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // Its length may change while it is read.
    std::fs::File::open(path)
        .and_then(|file| file.take(largest + 1).read_to_end(&mut bytes))
        .map_err(|e| unreadable(e.to_string()))?;
    if bytes.len() as u64 > largest {
        return Err(unreadable(format!("it has more than {largest} bytes")));
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Warning wherever an unverified profile is used.
pub fn caution(profile: &Profile) -> Option<Diagnostic> {
    (!profile.verified()).then(|| {
        let message = format!("the layout of UF_Value is {}", profile.shown());
        Diagnostic::note(codes::PROFILE_UNVERIFIED, None, message)
            .with_help("find the layout of your Plant Simulation with `build --probe`; `linewright explain LW541` says how")
    })
}
