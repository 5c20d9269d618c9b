//! Reads regular files only: reading a named pipe or a terminal might never end.

use linewright_core::deadline::{Deadline, StopReason};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;
use std::sync::OnceLock;

/// See [`keep_within`].
static LIMIT: OnceLock<Deadline> = OnceLock::new();

/// From now on, files that do not fit into what this deadline leaves of the memory are not read. A
/// file is read faster than memory can be watched. Only the first call counts.
pub fn keep_within(limit: Deadline) {
    let _ = LIMIT.set(limit);
}

/// Reads a regular file.
///
/// # Errors
/// Returns the error of [`std::fs::read`], or an error that names the type of the file if it is not
/// a regular file, or its size if it does not fit into the memory that the program may take.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    is_regular(path)?;
    if let Some(limit) = LIMIT.get() {
        limit.sample_memory();
        fits(std::fs::metadata(path)?.len(), limit.memory_left())?;
    }
    std::fs::read(path)
}

/// Checks that a file of this size may be read, given how much more memory the program may take.
fn fits(bytes: u64, left: u64) -> Result<()> {
    if bytes <= left {
        return Ok(());
    }
    Err(Error::other(format!(
        "it has {} MiB, and the memory limit leaves {} MiB; {}",
        bytes.div_ceil(1 << 20),
        left >> 20,
        StopReason::Memory.remedy()
    )))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_must_fit_into_the_memory_that_is_left() {
        assert!(fits(0, 0).is_ok());
        assert!(fits(1 << 30, u64::MAX).is_ok());
        let refused = fits((400 << 20) + 1, 95 << 20).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "it has 401 MiB, and the memory limit leaves 95 MiB; allow more memory with --memory MIB"
        );
    }
}
