//! The folder in which something is compiled: beside the place of the result, and removed
//! afterwards.
//!
//! A killed process cannot clean up. So each folder holds a file locked by its process, which the
//! system unlocks however the process ends; the next build removes adjacent folders whose file is
//! not locked. A lock is more reliable than a process ID, which may have been reused.

use super::super::Error;
use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Prefix of the names of these folders.
const PREFIX: &str = ".build-";

/// The file in it that is locked while the folder is in use.
const LOCK: &str = "in-use";

/// Age after which a folder without that file is considered abandoned: a younger one may belong to
/// a process that is just creating the file.
const FORGOTTEN: Duration = Duration::from_hours(1);

/// A folder to compile in; removed when dropped.
#[derive(Debug)]
pub struct WorkFolder {
    /// Unlocked before the folder is removed: Windows does not remove open files.
    lock: Option<File>,
    folder: tempfile::TempDir,
}

impl WorkFolder {
    /// Creates a folder in an existing one, and removes those left by killed builds.
    pub fn new(beside: &Path) -> Result<Self, Error> {
        remove_stale(beside);
        let unwritable = |cause| Error::Unwritable {
            path: beside.to_owned(),
            cause,
        };
        let folder = tempfile::Builder::new()
            .prefix(PREFIX)
            .tempdir_in(beside)
            .map_err(unwritable)?;
        // It gets its name only once it is locked: so nobody finds it unlocked and takes the folder
        // for a stale one.
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

/// Removes folders left by killed builds. Those that cannot be removed stay and do no harm.
fn remove_stale(beside: &Path) {
    let entries = std::fs::read_dir(beside).into_iter().flatten().flatten();
    for entry in entries {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if is_ours && entry.file_type().is_ok_and(|t| t.is_dir()) {
            let folder = entry.path();
            match File::options().write(true).open(folder.join(LOCK)) {
                Ok(file) => match file.try_lock() {
                    Ok(()) => {
                        // As long as it is locked here, no other build removes it as well.
                        let _ = std::fs::remove_dir_all(&folder);
                    }
                    Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
                },
                Err(_) if is_forgotten(&folder) => {
                    let _ = std::fs::remove_dir_all(&folder);
                }
                Err(_) => {}
            }
        }
    }
}

fn is_forgotten(folder: &Path) -> bool {
    let made = std::fs::metadata(folder).and_then(|m| m.modified());
    let now = SystemTime::now();
    made.is_ok_and(|made| now.duration_since(made).is_ok_and(|age| age > FORGOTTEN))
        && !folder.join(LOCK).exists()
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
    fn only_what_nobody_uses_is_removed() {
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
        // Two without a lock: one is just being created, the other was abandoned long ago.
        std::fs::create_dir(at(".build-young")).unwrap();
        std::fs::create_dir(at(".build-old")).unwrap();
        age(".build-old", 2);
        // Not one of these folders.
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
