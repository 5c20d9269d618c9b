//! Reads regular files only: reading a named pipe or a terminal might never end.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Reads a regular file.
///
/// # Errors
/// Returns the error of [`std::fs::read`], or an error that names the type of the file if it is not
/// a regular file.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    is_regular(path)?;
    std::fs::read(path)
}

/// Checks that a path leads to a regular file.
///
/// # Errors
/// Returns an error that names the type of the file if it is not a regular file.
pub fn is_regular(path: &Path) -> Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    let what = special(kind);
    Err(Error::other(format!("it is {what}, not a regular file")))
}

/// Names a file type other than file and folder.
#[cfg(unix)]
fn special(kind: std::fs::FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;
    if kind.is_fifo() {
        "a named pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn special(_: std::fs::FileType) -> &'static str {
    "a device"
}
