//! Detects changes to the relevant files.
//!
//! There are two sources, since neither is sufficient. The system reports events in a folder
//! immediately, but misses some (network drives, folders that disappear and return), and also
//! reports irrelevant ones. A scan shows what has changed: it compares the contents of the files
//! with those of the last scan. It runs after events, and every second if the system reports none.

use super::POLL_INTERVAL;
use crate::engine::files::{self, StandardLibrary};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher as _};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant, SystemTime};

/// Interval between checks for termination while there are no events.
const TICK: Duration = Duration::from_millis(50);

/// Time without a system event after which files are scanned.
const SCAN_INTERVAL: Duration = Duration::from_secs(1);

/// Scans wait until there was no event for this time, since a file can still be in the middle of
/// being written.
const QUIET_TIME: Duration = Duration::from_millis(40);

/// Maximum time for which a scan waits for events to end.
const MAX_WAIT: Duration = Duration::from_millis(200);

/// A file that was read within this time after its modification is read again: modification times
/// can be too coarse to distinguish two changes.
const TIME_RESOLUTION: Duration = Duration::from_secs(2);

/// Kind of change of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::cli::check) enum FileChange {
    /// The text differs.
    Changed,
    /// The file did not exist before.
    New,
    /// The file no longer exists.
    Gone,
}

/// A change of a file.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub(in crate::cli::check) struct Change {
    /// Name of the file in findings.
    pub(in crate::cli::check) file: String,
    /// Kind of change.
    pub(in crate::cli::check) what: FileChange,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.what {
            FileChange::Changed => "has changed",
            FileChange::New => "is new",
            FileChange::Gone => "is gone",
        };
        write!(f, "{} {what}", self.file)
    }
}

/// State of a file at the last scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FileState {
    /// Modification time.
    changed: Option<SystemTime>,
    /// Size in bytes.
    bytes: u64,
    /// Whether time and size suffice to detect a change.
    settled: bool,
    /// Hash of the text.
    text: u64,
}

/// Receives change events from the system.
struct EventSource {
    watcher: RecommendedWatcher,
    receiver: Receiver<notify::Result<Event>>,
    folders: BTreeMap<PathBuf, RecursiveMode>,
}

/// The source has ended: no more events follow.
struct SourceEnded;

/// Watches the files of a check.
pub(super) struct FileWatcher {
    paths: Vec<String>,
    standard: StandardLibrary,
    /// Watched files besides those that the paths name: imports, whether they exist or not.
    imports: BTreeSet<PathBuf>,
    /// States of the watched files that existed at the last scan.
    seen: BTreeMap<PathBuf, FileState>,
    /// `None` where the operating system cannot report file changes.
    events: Option<EventSource>,
}

impl FileWatcher {
    /// Watches the files and folders that these command-line paths name.
    pub(super) fn new(paths: &[String], standard: StandardLibrary) -> Self {
        let (sender, events) = channel();
        let watcher = notify::recommended_watcher(move |event| {
            // Fails if the receiver no longer exists.
            let _ = sender.send(event);
        });
        let events = watcher.ok().map(|watcher| EventSource {
            watcher,
            receiver: events,
            folders: BTreeMap::new(),
        });
        Self {
            paths: paths.to_vec(),
            standard,
            imports: BTreeSet::new(),
            seen: BTreeMap::new(),
            events,
        }
    }

    /// Replaces the files that are watched besides those that the paths name. Each file comes with
    /// the text that a check has read, or `None` if the file did not exist, so that the next scan
    /// also reports changes made during the check. States that are already known are kept.
    pub(super) fn set_imports(&mut self, imports: &[(PathBuf, Option<&str>)]) {
        let (_, named) = files::watched_paths(&self.paths, &self.standard);
        let named: BTreeSet<PathBuf> = named.iter().map(plain).collect();
        let paths = imports.iter().map(|(path, _)| plain(path)).collect();
        let dropped = std::mem::replace(&mut self.imports, paths);
        self.seen
            .retain(|p, _| !dropped.contains(p) || self.imports.contains(p) || named.contains(p));
        for (path, text) in imports {
            if let Some(text) = text {
                let read = FileState::read(text.as_bytes());
                self.seen.entry(plain(path)).or_insert(read);
            }
        }
    }

    /// Scans all watched files, and returns the changes since the last scan.
    pub(super) fn scan(&mut self) -> Vec<Change> {
        let (folders, files) = files::watched_paths(&self.paths, &self.standard);
        let mut files: BTreeSet<PathBuf> = files.iter().map(plain).collect();
        files.extend(self.imports.iter().cloned());
        if let Some(events) = &mut self.events {
            events.listen(&folders, &files);
        }
        let mut seen = BTreeMap::new();
        let mut changes = Vec::new();
        for path in files {
            let before = self.seen.remove(&path);
            let now = FileState::of(&path, before);
            let what = match (&before, &now) {
                (None, Some(_)) => Some(FileChange::New),
                (Some(_), None) => Some(FileChange::Gone),
                (Some(a), Some(b)) if a.text != b.text => Some(FileChange::Changed),
                _ => None,
            };
            changes.extend(what.map(|what| change(&path, what)));
            if let Some(now) = now {
                seen.insert(path, now);
            }
        }
        // The remaining files are no longer among the watched ones.
        let gone = std::mem::replace(&mut self.seen, seen);
        changes.extend(gone.keys().map(|path| change(path, FileChange::Gone)));
        changes
    }

    /// Waits for changes; returns `None` as soon as `ended` returns true.
    pub(super) fn wait(&mut self, ended: impl Fn() -> bool) -> Option<Vec<Change>> {
        let mut last_scan = Instant::now();
        // The first scan finds changes made during the check.
        let mut due = true;
        loop {
            if ended() {
                return None;
            }
            let interval = if self.events.is_some() {
                SCAN_INTERVAL
            } else {
                POLL_INTERVAL
            };
            if due || last_scan.elapsed() >= interval {
                let changes = self.scan();
                if !changes.is_empty() {
                    return Some(changes);
                }
                last_scan = Instant::now();
            }
            due = false;
            if let Some(events) = &mut self.events {
                match events.next() {
                    Ok(found) => due = found,
                    Err(SourceEnded) => self.events = None,
                }
            } else {
                std::thread::sleep(TICK);
            }
        }
    }
}

impl EventSource {
    /// Waits one tick for an event. If there is none, returns false. Otherwise waits until no more
    /// events come, or for [`MAX_WAIT`], and returns true.
    fn next(&mut self) -> Result<bool, SourceEnded> {
        match self.receiver.recv_timeout(TICK) {
            Ok(event) => self.process(event),
            Err(RecvTimeoutError::Timeout) => return Ok(false),
            Err(RecvTimeoutError::Disconnected) => return Err(SourceEnded),
        }
        let start = Instant::now();
        while start.elapsed() < MAX_WAIT
            && let Ok(event) = self.receiver.recv_timeout(QUIET_TIME)
        {
            self.process(event);
        }
        Ok(true)
    }

    /// Forgets a folder that was removed or renamed, so that it is watched again when it returns.
    fn process(&mut self, event: notify::Result<Event>) {
        if let Ok(event) = event
            && matches!(event.kind, EventKind::Remove(_) | EventKind::Modify(_))
        {
            let removed = matches!(event.kind, EventKind::Remove(_));
            for path in event.paths {
                self.folders.retain(|folder, _| {
                    let here = std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
                    here != path || (!removed && folder.is_dir())
                });
            }
        }
    }

    /// Listens to these folders with all subfolders, and to the folders of these files.
    fn listen(&mut self, folders: &[PathBuf], files: &BTreeSet<PathBuf>) {
        let mut wanted = BTreeMap::new();
        for file in files
            .iter()
            .filter(|f| !folders.iter().any(|d| f.starts_with(d)))
        {
            wanted.insert(nearest_existing(file.parent()), RecursiveMode::NonRecursive);
        }
        for folder in folders {
            // The folder's parent is also watched, since the folder can disappear and return.
            wanted
                .entry(nearest_existing(folder.parent()))
                .or_insert(RecursiveMode::NonRecursive);
            wanted.insert(folder.clone(), RecursiveMode::Recursive);
        }
        if wanted.is_empty() {
            wanted.insert(PathBuf::from("."), RecursiveMode::NonRecursive);
        }
        for folder in self.folders.keys().filter(|f| !wanted.contains_key(*f)) {
            // Fails if the folder no longer exists.
            let _ = self.watcher.unwatch(folder);
        }
        self.folders.retain(|folder, _| wanted.contains_key(folder));
        for (folder, mode) in wanted {
            if !self.folders.contains_key(&folder) && self.watcher.watch(&folder, mode).is_ok() {
                self.folders.insert(folder, mode);
            }
        }
    }
}

impl FileState {
    /// Current state of a file; `None` if it cannot be read. The text is read only if time and size
    /// do not rule out a change.
    fn of(path: &Path, before: Option<Self>) -> Option<Self> {
        let data = std::fs::metadata(path)
            .ok()
            .filter(std::fs::Metadata::is_file)?;
        let (changed, bytes) = (data.modified().ok(), data.len());
        if let Some(before) = before
            && before.settled
            && (before.changed, before.bytes) == (changed, bytes)
        {
            return Some(before);
        }
        let text = std::fs::read(path).ok()?;
        let age = changed.and_then(|c| c.elapsed().ok());
        Some(Self {
            changed,
            bytes,
            settled: age.is_some_and(|age| age > TIME_RESOLUTION),
            ..Self::read(&text)
        })
    }

    /// State of a file of which only the text is known.
    fn read(text: &[u8]) -> Self {
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        Self {
            changed: None,
            bytes: text.len() as u64,
            settled: false,
            text: hasher.finish(),
        }
    }
}

/// Removes a leading `./`, so that `./a.lw` and `a.lw` are the same file.
fn plain(path: impl AsRef<Path>) -> PathBuf {
    let path = path.as_ref();
    path.strip_prefix(".").unwrap_or(path).to_owned()
}

/// The folder, or its closest existing parent.
fn nearest_existing(folder: Option<&Path>) -> PathBuf {
    let mut folder = folder.unwrap_or(Path::new(""));
    while !folder.as_os_str().is_empty() && !folder.is_dir() {
        folder = folder.parent().unwrap_or(Path::new(""));
    }
    if folder.as_os_str().is_empty() {
        PathBuf::from(".")
    } else {
        folder.to_owned()
    }
}

fn change(path: &Path, what: FileChange) -> Change {
    Change {
        file: files::shown(path),
        what,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scans again; returns the changes without the folder's own path.
    fn found(watcher: &mut FileWatcher) -> Vec<(String, FileChange)> {
        let name = |c: Change| {
            (
                c.file.rsplit('/').next().unwrap_or_default().to_owned(),
                c.what,
            )
        };
        watcher.scan().into_iter().map(name).collect()
    }

    #[test]
    fn scans_report_changes_of_files_in_a_folder_and_of_imports() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("in")).unwrap();
        std::fs::write(at("in/a.lw"), "one").unwrap();
        let paths = [at("in").to_string_lossy().into_owned()];
        let mut watcher = FileWatcher::new(&paths, StandardLibrary::default());
        assert_eq!(found(&mut watcher), [("a.lw".to_owned(), FileChange::New)]);
        assert_eq!(found(&mut watcher), []);

        // Rewriting the same text is not a change; other kinds of files are not watched.
        std::fs::write(at("in/a.lw"), "one").unwrap();
        std::fs::write(at("in/notes.txt"), "notes").unwrap();
        assert_eq!(found(&mut watcher), []);
        std::fs::write(at("in/a.lw"), "two").unwrap();
        std::fs::write(at("in/b.lw"), "new").unwrap();
        assert_eq!(
            found(&mut watcher),
            [
                ("a.lw".to_owned(), FileChange::Changed),
                ("b.lw".to_owned(), FileChange::New)
            ]
        );

        // Imports, one of which does not exist yet, with the texts that a check has read.
        std::fs::write(at("other.lw"), "other").unwrap();
        watcher.set_imports(&[(at("other.lw"), Some("other")), (at("missing.lw"), None)]);
        assert_eq!(found(&mut watcher), []);
        std::fs::write(at("other.lw"), "changed").unwrap();
        std::fs::write(at("missing.lw"), "here").unwrap();
        std::fs::remove_file(at("in/b.lw")).unwrap();
        let mut changes = found(&mut watcher);
        changes.sort_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(
            changes,
            [
                ("b.lw".to_owned(), FileChange::Gone),
                ("missing.lw".to_owned(), FileChange::New),
                ("other.lw".to_owned(), FileChange::Changed)
            ]
        );

        // Imports appear and change during the check that reads them.
        std::fs::write(at("late.lw"), "late").unwrap();
        watcher.set_imports(&[(at("late.lw"), None), (at("fast.lw"), Some("first"))]);
        std::fs::write(at("fast.lw"), "second").unwrap();
        assert_eq!(
            found(&mut watcher),
            [
                ("fast.lw".to_owned(), FileChange::Changed),
                ("late.lw".to_owned(), FileChange::New)
            ]
        );

        // A folder disappears and returns.
        std::fs::remove_dir_all(at("in")).unwrap();
        assert_eq!(found(&mut watcher), [("a.lw".to_owned(), FileChange::Gone)]);
        std::fs::create_dir(at("in")).unwrap();
        std::fs::write(at("in/a.lw"), "three").unwrap();
        assert_eq!(found(&mut watcher), [("a.lw".to_owned(), FileChange::New)]);
    }
}
