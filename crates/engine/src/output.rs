//! Writes results to files: to a temporary name first, then renamed, so that a killed run leaves no
//! partial file.

use super::files;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_station::disk;
use std::collections::BTreeSet;
use std::fs::{File, Permissions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a file and creates its folder if necessary. If the path is a symbolic link, the link is
/// kept and its target is overwritten.
///
/// # Errors
/// The file cannot be written, is not a regular file (a device, a named pipe), or is one of the
/// `sources` of the command's result ([`LoadedFiles::places`](files::LoadedFiles::places)).
/// Existing content is then unchanged.
pub fn write(path: &Path, text: &str, sources: &BTreeSet<PathBuf>) -> Result<(), Box<Diagnostic>> {
    let target = target(path, sources)?;
    let written = replace(&target, text.as_bytes(), None);
    written.map_err(|e| Box::new(unwritable(path, &e, OTHER_PATH)))
}

/// A file that is written bit by bit, and takes its name when it is complete.
#[derive(Debug)]
pub struct PendingFile {
    file: NamedTempFile,
    path: PathBuf,
    target: PathBuf,
}

impl PendingFile {
    /// Begins a file. Its folder is created if necessary; links are kept.
    ///
    /// # Errors
    /// As for [`write()`].
    pub fn new(path: &Path, sources: &BTreeSet<PathBuf>) -> Result<Self, Box<Diagnostic>> {
        let target = target(path, sources)?;
        let file = temporary(&target).map_err(|e| Box::new(unwritable(path, &e, OTHER_PATH)))?;
        Ok(Self {
            file,
            path: path.to_owned(),
            target,
        })
    }

    /// The file, to be written.
    pub fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Gives the complete file its name, unless it could not be written.
    ///
    /// # Errors
    /// The file could not be written, or cannot take its name. What had this name is unchanged.
    pub fn keep(self, written: io::Result<()>) -> Result<(), Box<Diagnostic>> {
        let Self { file, path, target } = self;
        let kept = written.and_then(|()| file.persist(&target).map_err(|e| e.error));
        kept.map_err(|e| Box::new(unwritable(&path, &e, OTHER_PATH)))?;
        Ok(())
    }
}

const OTHER_PATH: &str = "name another path, or make this one writable";

/// The file that a result replaces: behind a link, its target.
fn target(path: &Path, sources: &BTreeSet<PathBuf>) -> Result<PathBuf, Box<Diagnostic>> {
    if std::fs::canonicalize(path).is_ok_and(|place| sources.contains(&place)) {
        let message = format!(
            "{} is not overwritten: it is a source of this result",
            path.display()
        );
        let help = "give the result another name, or write it into another folder";
        return Err(Box::new(
            Diagnostic::error(codes::OUTPUT_UNWRITABLE, None, message).with_help(help),
        ));
    }
    if !path.exists() {
        return Ok(path.to_owned());
    }
    let target = files::is_regular(path).map_err(io::Error::other);
    let target = target.and_then(|()| std::fs::canonicalize(path));
    target.map_err(|e| Box::new(unwritable(path, &e, OTHER_PATH)))
}

/// Writes a file that does not exist yet.
///
/// # Errors
/// The file exists with a different content (LW546), or cannot be written. An existing file is
/// never changed.
pub fn keep(path: &Path, text: &str, help: &str) -> Result<(), Box<Diagnostic>> {
    match disk::read(path) {
        Ok(old) if old == text.as_bytes() => Ok(()),
        Ok(_) => {
            let message = format!(
                "{} already exists, with a different content",
                path.display()
            );
            Err(Box::new(
                Diagnostic::error(codes::FILE_KEPT, None, message).with_help(help),
            ))
        }
        Err(_) => write(path, text, &BTreeSet::new()),
    }
}

/// Rewrites an existing file of the user; follows links and keeps the permissions.
///
/// # Errors
/// The file does not exist, is write-protected, or cannot be written. Its content is then
/// unchanged.
pub fn rewrite(path: &Path, text: &str) -> Result<(), Box<Diagnostic>> {
    let written = std::fs::canonicalize(path).and_then(|target| {
        let permissions = std::fs::metadata(&target)?.permissions();
        if permissions.readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        replace(&target, text.as_bytes(), Some(permissions))
    });
    written.map_err(|e| {
        Box::new(unwritable(
            path,
            &e,
            "give yourself permission to write this file",
        ))
    })
}

fn unwritable(path: &Path, error: &io::Error, help: &str) -> Diagnostic {
    let message = format!("{} cannot be written: {error}", path.display());
    Diagnostic::error(codes::OUTPUT_UNWRITABLE, None, message).with_help(help)
}

fn replace(path: &Path, bytes: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let mut file = temporary(path)?;
    file.write_all(bytes)?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    file.persist(path)?;
    Ok(())
}

/// A temporary file in the folder of `path`, which is created if necessary.
fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder)?;
    let mut builder = tempfile::Builder::new();
    // A temporary file is private by default; a result gets the permissions of an ordinary new
    // file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.prefix(".linewright-").tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_and_folders_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.json");
        let none = BTreeSet::new();
        write(&path, "one", &none).unwrap();
        write(&path, "two", &none).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        let left: Vec<_> = std::fs::read_dir(path.parent().unwrap()).unwrap().collect();
        assert_eq!(left.len(), 1, "a temporary file was left behind");
    }

    #[test]
    fn an_unwritable_folder_is_a_finding() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a"), "a file, no folder").unwrap();
        let finding = write(&folder.path().join("a/b.json"), "text", &BTreeSet::new()).unwrap_err();
        assert_eq!(finding.code, codes::OUTPUT_UNWRITABLE);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_written_anew_keeps_its_place_and_its_permissions() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a.lw"), folder.path().join("b.lw"));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, Permissions::from_mode(0o750)).unwrap();
        symlink(&file, &link).unwrap();
        rewrite(&link, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        let mode = std::fs::metadata(&file).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o750);
        std::fs::set_permissions(&file, Permissions::from_mode(0o440)).unwrap();
        assert!(rewrite(&file, "newer").is_err());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
    }
}
