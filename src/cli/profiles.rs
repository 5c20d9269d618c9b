//! Profiles of `UF_Value` as files: read for `build` and `doctor`, and what is said of one that is
//! unverified.

use crate::diagnostics::{Diagnostic, codes};
use crate::engine::files;
use crate::source::SourceMap;
use crate::station::profile::{Profile, read};
use std::io::Read;
use std::path::Path;

/// No profile is larger.
const LARGEST_FILE: u64 = 1 << 20;

/// The profile of a file, or the assumed one where none is given. The file's text is added to
/// `sources`.
pub fn load(path: Option<&Path>, sources: &mut SourceMap) -> Result<Profile, Vec<Diagnostic>> {
    let Some(path) = path else {
        return Ok(Profile::assumed());
    };
    let text = text(path, LARGEST_FILE).map_err(|finding| vec![*finding])?;
    let file = sources.add(path.display().to_string(), text.as_str());
    read::parse(file, &text)
}

/// The text of a file of bounded size; what is not UTF-8 becomes a mark that no reader takes.
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

/// What is said wherever a profile is used that is not verified.
pub fn caution(profile: &Profile) -> Option<Diagnostic> {
    (!profile.verified()).then(|| {
        let message = format!("the layout of UF_Value is {}", profile.shown());
        Diagnostic::note(codes::PROFILE_UNVERIFIED, None, message)
            .with_help("find the layout of your Plant Simulation with `build --probe`; `linewright explain LW541` says how")
    })
}
