//! Writes results to files: under a temporary name first, then renamed, so that a killed run leaves no half file.

use crate::diagnostics::{Diagnostic, codes};
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file, and makes its folder where that is missing.
pub fn write(path: &Path, text: &str) -> Result<(), Box<Diagnostic>> {
    replace(path, text.as_bytes()).map_err(|e| {
        let message = format!("{} cannot be written: {e}", path.display());
        Box::new(
            Diagnostic::error(codes::OUTPUT_UNWRITABLE, None, message)
                .with_help("choose a folder that may be written with --out DIR"),
        )
    })
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    // A temporary file is private by default; a result is as readable as any other file the user makes.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.prefix(".linewright-").tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_and_folders_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.json");
        write(&path, "one").unwrap();
        write(&path, "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        let left: Vec<_> = std::fs::read_dir(path.parent().unwrap()).unwrap().collect();
        assert_eq!(left.len(), 1, "no temporary file stays behind");
    }

    #[test]
    fn an_unwritable_folder_is_a_finding() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a"), "a file, no folder").unwrap();
        let finding = write(&folder.path().join("a/b.json"), "text").unwrap_err();
        assert_eq!(finding.code, codes::OUTPUT_UNWRITABLE);
    }
}
