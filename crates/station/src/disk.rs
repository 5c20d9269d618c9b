//! Reading files, and only files: whoever reads a named pipe or a terminal may wait for ever.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// The bytes of a regular file.
///
/// # Errors
/// As [`std::fs::read`], and when the path leads to something else: the error says what it is.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    is_regular(path)?;
    std::fs::read(path)
}

/// Whether a path leads to a regular file.
///
/// # Errors
/// What is there instead.
pub fn is_regular(path: &Path) -> Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    let what = special(kind);
    Err(Error::other(format!("it is {what}, and no regular file")))
}

/// What is neither a file nor a folder.
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
