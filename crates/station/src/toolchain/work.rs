//! Temporary folders for compilation, in the folder of the result.
//!
//! A killed process cannot remove its folder. Each folder therefore contains a file that its
//! process locks, and that the system unlocks whenever the process ends; the next build removes
//! folders whose file is not locked. A lock is more reliable than a process ID, which can be
//! reused.

use super::super::Error;
use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Prefix of the names of these folders.
const PREFIX: &str = ".build-";

/// Name of the file that is locked while its folder is in use.
const LOCK: &str = "in-use";

/// Age after which a folder without that file is considered abandoned. A younger folder can belong
/// to a process that is just creating the file.
const ABANDONED_AGE: Duration = Duration::from_hours(1);

/// A folder to compile in; removed when dropped.
#[derive(Debug)]
pub struct WorkFolder {
    /// Closed before the folder is removed, because Windows does not remove open files.
    lock: Option<File>,
    folder: tempfile::TempDir,
}

impl WorkFolder {
    /// Creates a work folder in `parent`, and removes work folders that were left by killed builds.
    pub fn new(parent: &Path) -> Result<Self, Error> {
        remove_stale(parent);
        let unwritable = |cause| Error::Unwritable {
            path: parent.to_owned(),
            cause,
        };
        let folder = tempfile::Builder::new()
            .prefix(PREFIX)
            .tempdir_in(parent)
            .map_err(unwritable)?;
        // The file gets its name only after it is locked, so that no other process finds it
        // unlocked and removes the folder.
        let unnamed = folder.path().join("in-use.new");
        let lock = File::create(&unnamed).map_err(unwritable)?;
        // If files cannot be locked, folders of killed builds stay.
        let lock = lock.try_lock().is_ok().then_some(lock);
        if lock.is_some() {
            std::fs::rename(&unnamed, folder.path().join(LOCK)).map_err(unwritable)?;
        }
        Ok(Self { lock, folder })
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        drop(self.lock.take());
    }
}

/// Removes work folders left by killed builds. Folders that cannot be removed are left.
fn remove_stale(parent: &Path) {
    let entries = std::fs::read_dir(parent).into_iter().flatten().flatten();
    for entry in entries {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if is_ours && entry.file_type().is_ok_and(|t| t.is_dir()) {
            let folder = entry.path();
            match File::options().write(true).open(folder.join(LOCK)) {
                Ok(file) => match file.try_lock() {
                    Ok(()) => {
                        // The lock keeps other builds from removing the folder at the same time.
                        let _ = std::fs::remove_dir_all(&folder);
                    }
                    Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
                },
                Err(_) if is_abandoned(&folder) => {
                    let _ = std::fs::remove_dir_all(&folder);
                }
                Err(_) => {}
            }
        }
    }
}

fn is_abandoned(folder: &Path) -> bool {
    let made = std::fs::metadata(folder).and_then(|m| m.modified());
    let now = SystemTime::now();
    made.is_ok_and(|made| {
        now.duration_since(made)
            .is_ok_and(|age| age > ABANDONED_AGE)
    }) && !folder.join(LOCK).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn only_unused_folders_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        let age = |name: &str, hours: u64| {
            let then = SystemTime::now() - Duration::from_hours(hours);
            File::open(at(name)).unwrap().set_modified(then).unwrap();
        };
        // A folder of a killed build, with its partial output.
        std::fs::create_dir_all(at(".build-killed/obj")).unwrap();
        std::fs::write(at(".build-killed/in-use"), "").unwrap();
        std::fs::write(at(".build-killed/obj/a.c"), "int a;").unwrap();
        // Two folders without a lock: one is being created, the other was abandoned long ago.
        std::fs::create_dir(at(".build-young")).unwrap();
        std::fs::create_dir(at(".build-old")).unwrap();
        age(".build-old", 2);
        // A file and a folder that are not work folders.
        std::fs::write(at(".build-file"), "").unwrap();
        std::fs::create_dir(at("build-other")).unwrap();
        let running = WorkFolder::new(place.path()).unwrap();
        let second = WorkFolder::new(place.path()).unwrap();
        assert!(running.path().is_dir() && second.path().is_dir());
        assert_ne!(running.path(), second.path());
        let name = |w: &WorkFolder| w.path().file_name().unwrap().to_string_lossy().into_owned();
        let mut wanted = [
            ".build-young",
            ".build-file",
            "build-other",
            &name(&running),
            &name(&second),
        ];
        wanted.sort_unstable();
        assert_eq!(names(place.path()), wanted);
        drop((running, second));
        assert_eq!(
            names(place.path()),
            [".build-file", ".build-young", "build-other"]
        );
    }
}
