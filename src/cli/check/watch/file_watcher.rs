//! Detects changes to the relevant files.
//!
//! There are two sources, since neither is sufficient. The system reports immediately that
//! something happened in a folder, but not always (network drives, folders that disappear and
//! return), and also when nothing relevant did. The files themselves show what has changed: their
//! contents are compared with those of the last scan, which also runs every second if the system
//! reports nothing.

use super::SLOWEST;
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

/// Interval between checks for termination while nothing happens.
const TICK: Duration = Duration::from_millis(50);

/// Time without a system event after which files are scanned.
const REST: Duration = Duration::from_secs(1);

/// A file that was just written may still be written: scans wait until nothing has happened for
/// this time.
const QUIET: Duration = Duration::from_millis(40);

/// Maximum time that scans wait.
const PATIENCE: Duration = Duration::from_millis(200);

/// A file read this soon after it was changed is read again, since its modification time may not
/// distinguish two changes.
const COARSE: Duration = Duration::from_secs(2);

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
    changed: Option<SystemTime>,
    bytes: u64,
    /// Whether time and size suffice to detect a change.
    settled: bool,
    text: u64,
}

/// Change events from the system.
struct Word {
    watcher: RecommendedWatcher,
    events: Receiver<notify::Result<Event>>,
    folders: BTreeMap<PathBuf, RecursiveMode>,
}

/// There will be no more events.
struct Silent;

/// Everything that is watched.
pub(super) struct FileWatcher {
    paths: Vec<String>,
    standard: StandardLibrary,
    /// Relevant files apart from those that the paths name: imports, existing or not.
    others: BTreeSet<PathBuf>,
    /// All relevant files that exist.
    seen: BTreeMap<PathBuf, FileState>,
    /// `None` if the system reports no events.
    word: Option<Word>,
}

impl FileWatcher {
    /// Watches everything that these command-line paths name.
    pub(super) fn new(paths: &[String], standard: StandardLibrary) -> Self {
        let (sender, events) = channel();
        let watcher = notify::recommended_watcher(move |event| {
            // Fails if the receiver is gone.
            let _ = sender.send(event);
        });
        let word = watcher.ok().map(|watcher| Word {
            watcher,
            events,
            folders: BTreeMap::new(),
        });
        Self {
            paths: paths.to_vec(),
            standard,
            others: BTreeSet::new(),
            seen: BTreeMap::new(),
            word,
        }
    }

    /// From now on also watches these files, and no others apart from those that the paths name.
    /// Each comes with the text that a check has read, `None` if there was none: changes during the
    /// check are reported by the next scan. The state of the last scan is kept.
    pub(super) fn also(&mut self, others: &[(PathBuf, Option<&str>)]) {
        let (_, named) = files::places(&self.paths, &self.standard);
        let named: BTreeSet<PathBuf> = named.iter().map(plain).collect();
        let paths = others.iter().map(|(path, _)| plain(path)).collect();
        let dropped = std::mem::replace(&mut self.others, paths);
        self.seen
            .retain(|p, _| !dropped.contains(p) || self.others.contains(p) || named.contains(p));
        for (path, text) in others {
            if let Some(text) = text {
                let read = FileState::read(text.as_bytes());
                self.seen.entry(plain(path)).or_insert(read);
            }
        }
    }

    /// Scans all files, and returns what has changed since the last scan.
    pub(super) fn look(&mut self) -> Vec<Change> {
        let (folders, files) = files::places(&self.paths, &self.standard);
        let mut files: BTreeSet<PathBuf> = files.iter().map(plain).collect();
        files.extend(self.others.iter().cloned());
        if let Some(word) = &mut self.word {
            word.listen(&folders, &files);
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
        // Files that no path names any more.
        let gone = std::mem::replace(&mut self.seen, seen);
        changes.extend(gone.keys().map(|path| change(path, FileChange::Gone)));
        changes
    }

    /// Waits for a change; `None` when it is to end.
    pub(super) fn wait(&mut self, ended: impl Fn() -> bool) -> Option<Vec<Change>> {
        let mut looked = Instant::now();
        // The first scan finds changes made during the check.
        let mut due = true;
        loop {
            if ended() {
                return None;
            }
            let rest = if self.word.is_some() { REST } else { SLOWEST };
            if due || looked.elapsed() >= rest {
                let changes = self.look();
                if !changes.is_empty() {
                    return Some(changes);
                }
                looked = Instant::now();
            }
            due = false;
            if let Some(word) = &mut self.word {
                match word.next() {
                    Ok(found) => due = found,
                    Err(Silent) => self.word = None,
                }
            } else {
                std::thread::sleep(TICK);
            }
        }
    }
}

impl Word {
    /// Whether something happens within a tick; if so, waits for the end of it.
    fn next(&mut self) -> Result<bool, Silent> {
        match self.events.recv_timeout(TICK) {
            Ok(event) => self.note(event),
            Err(RecvTimeoutError::Timeout) => return Ok(false),
            Err(RecvTimeoutError::Disconnected) => return Err(Silent),
        }
        let start = Instant::now();
        while start.elapsed() < PATIENCE
            && let Ok(event) = self.events.recv_timeout(QUIET)
        {
            self.note(event);
        }
        Ok(true)
    }

    /// A removed folder is watched again when it returns.
    fn note(&mut self, event: notify::Result<Event>) {
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
            wanted.insert(standing(file.parent()), RecursiveMode::NonRecursive);
        }
        for folder in folders {
            // Also its parent, since it may disappear and return.
            wanted
                .entry(standing(folder.parent()))
                .or_insert(RecursiveMode::NonRecursive);
            wanted.insert(folder.clone(), RecursiveMode::Recursive);
        }
        if wanted.is_empty() {
            wanted.insert(PathBuf::from("."), RecursiveMode::NonRecursive);
        }
        for folder in self.folders.keys().filter(|f| !wanted.contains_key(*f)) {
            // Fails if it is already gone.
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
    /// Current state of a file, read only if that can show a change; `None` if it cannot be read.
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
            settled: age.is_some_and(|age| age > COARSE),
            ..Self::read(&text)
        })
    }

    /// A file known only by its text.
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

/// `./a.lw` and `a.lw` are the same file.
fn plain(path: impl AsRef<Path>) -> PathBuf {
    let path = path.as_ref();
    path.strip_prefix(".").unwrap_or(path).to_owned()
}

/// The folder, or its closest existing parent.
fn standing(folder: Option<&Path>) -> PathBuf {
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
        watcher.look().into_iter().map(name).collect()
    }

    #[test]
    fn looks_tell_what_happened_to_files_in_a_folder_and_to_imports() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("in")).unwrap();
        std::fs::write(at("in/a.lw"), "one").unwrap();
        let paths = [at("in").to_string_lossy().into_owned()];
        let mut watcher = FileWatcher::new(&paths, StandardLibrary::default());
        assert_eq!(found(&mut watcher), [("a.lw".to_owned(), FileChange::New)]);
        assert_eq!(found(&mut watcher), []);

        // Rewriting the same text is no change, nor is another kind of file.
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

        // Imports, one of which does not exist yet. What a check has read is known.
        std::fs::write(at("other.lw"), "other").unwrap();
        watcher.also(&[(at("other.lw"), Some("other")), (at("missing.lw"), None)]);
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

        // They appear and change during the check that would have read them.
        std::fs::write(at("late.lw"), "late").unwrap();
        watcher.also(&[(at("late.lw"), None), (at("fast.lw"), Some("first"))]);
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
