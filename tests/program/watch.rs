//! `check --watch` as a process: its output when files change, appear, disappear, are imported, or
//! are half written, and its end.
//!
//! The deadlines only end a failing test; no time is measured.
#![cfg(unix)]

use crate::support;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

const DEADLINE: Duration = Duration::from_mins(2);

/// A contract that can be kept.
const SOUND: &str = "contract Sound {
    input request: bool
    output running: bool

    guarantee follows: always (request -> running)
}
";

/// A contract that cannot be kept.
const CLASH: &str = "contract Clash {
    input request: bool
    output running: bool

    guarantee follows: always (request -> running)
    guarantee rests: always (running -> not next running)
}
";

/// The running program.
struct Watching {
    child: Child,
    lines: Receiver<String>,
}

impl Watching {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(support::PROGRAM)
            .args(["check", "--watch"])
            .args(arguments)
            .current_dir(folder)
            .env_remove("CLICOLOR_FORCE")
            .env("LINEWRIGHT_CACHE", "off")
            .env("NO_COLOR", "1")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let out = BufReader::new(child.stdout.take().expect("its output"));
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self { child, lines }
    }

    /// The next matching line; earlier ones may come from checks in the middle of a change.
    fn line(&mut self, wanted: &str, is: impl Fn(&str) -> bool) -> String {
        let start = Instant::now();
        let mut others = String::new();
        while let Some(left) = DEADLINE.checked_sub(start.elapsed()) {
            match self.lines.recv_timeout(left) {
                Ok(line) if is(&line) => return line,
                Ok(line) => others = others + &line + "\n",
                Err(_) => break,
            }
        }
        panic!("{wanted} did not come; what came is\n{others}");
    }

    /// The next document with these verdicts, sorted by contract.
    fn verdicts(&mut self, wanted: &[(&str, &str)]) -> Value {
        let text = self.line(&format!("{wanted:?}"), |line| {
            let document: Value = serde_json::from_str(line).expect("one document a line");
            verdicts(&document) == wanted
        });
        support::documents::assert_valid(text.as_bytes()).remove(0)
    }

    /// Presses Ctrl-C, and returns the exit code.
    fn end(mut self) -> Option<i32> {
        let id = i32::try_from(self.child.id()).expect("a process id");
        kill(Pid::from_raw(id), Signal::SIGINT).expect("a signal");
        self.exit()
    }

    fn exit(&mut self) -> Option<i32> {
        let start = Instant::now();
        while start.elapsed() < DEADLINE {
            if let Some(status) = self.child.try_wait().expect("its state") {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("it does not end");
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        // Fails if it has already ended.
        let _ = self.child.kill();
    }
}

fn verdicts(document: &Value) -> Vec<(&str, &str)> {
    let entries = document["contracts"].as_array().expect("contracts");
    let entry = |e| (text(e, "name"), text(e, "verdict"));
    let mut verdicts: Vec<_> = entries.iter().map(entry).collect();
    verdicts.sort_unstable();
    verdicts
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().expect("a text")
}

/// The changes listed in a document.
fn changes(document: &Value) -> Vec<(&str, &str)> {
    let entries = document["changes"].as_array().expect("changes");
    entries
        .iter()
        .map(|e| (text(e, "file"), text(e, "what")))
        .collect()
}

/// Seconds that a contract took, which are repeated if it was not solved again.
fn seconds(document: &Value, name: &str) -> f64 {
    let entries = document["contracts"].as_array().expect("contracts");
    let entry = entries.iter().find(|e| e["name"] == name);
    entry.and_then(|e| e["seconds"].as_f64()).expect("seconds")
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("a file");
}

/// Creates a file with its content at once. After [`write`], a check may find the file empty, and
/// the next check may find that it has changed.
fn appear(folder: &Path, name: &str, text: &str) {
    write(folder, "unfinished", text);
    std::fs::rename(folder.join("unfinished"), folder.join(name)).expect("it is renamed");
}

#[test]
fn files_change_come_go_and_break() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::create_dir(folder.join("cell")).expect("a folder");
    write(folder, "cell/sound.lw", SOUND);
    write(folder, "cell/other.lw", &SOUND.replace("Sound", "Other"));
    let mut watching = Watching::start(folder, &["cell", "--format", "json"]);

    let (other, sound) = (("Other", "realizable"), ("Sound", "realizable"));
    let first = watching.verdicts(&[other, sound]);
    assert_eq!(first["schema"], "linewright/check/1");
    assert_eq!(changes(&first), []);
    assert!(first["unix_seconds"].is_f64());

    // Another verdict; the other contract is not solved again.
    write(folder, "cell/sound.lw", CLASH);
    let clash = ("Clash", "unrealizable");
    let second = watching.verdicts(&[clash, other]);
    assert_eq!(changes(&second), [("cell/sound.lw", "changed")]);
    let (before, after) = (seconds(&first, "Other"), seconds(&second, "Other"));
    assert!((before - after).abs() < f64::EPSILON, "{before} {after}");

    // A file appears between the two others, and disappears again.
    appear(folder, "cell/p.lw", &SOUND.replace("Sound", "More"));
    let third = watching.verdicts(&[clash, ("More", "realizable"), other]);
    assert_eq!(changes(&third), [("cell/p.lw", "new")]);
    std::fs::remove_file(folder.join("cell/p.lw")).expect("it goes");
    let fourth = watching.verdicts(&[clash, other]);
    assert_eq!(changes(&fourth), [("cell/p.lw", "gone")]);

    // Half a file, and the rest of it.
    write(folder, "cell/sound.lw", &SOUND[..SOUND.len() / 2]);
    watching.verdicts(&[other, ("Sound", "invalid")]);
    write(folder, "cell/sound.lw", SOUND);
    watching.verdicts(&[other, sound]);

    // Editors write a new file and rename it.
    write(folder, "cell/sound.lw.tmp", CLASH);
    let (from, to) = (
        folder.join("cell/sound.lw.tmp"),
        folder.join("cell/sound.lw"),
    );
    std::fs::rename(from, to).expect("it is renamed");
    watching.verdicts(&[clash, other]);

    // The whole folder disappears and returns.
    std::fs::rename(folder.join("cell"), folder.join("away")).expect("it goes");
    watching.verdicts(&[("cell", "invalid")]);
    std::fs::rename(folder.join("away"), folder.join("cell")).expect("it comes");
    watching.verdicts(&[clash, other]);
    write(folder, "cell/sound.lw", SOUND);
    watching.verdicts(&[other, sound]);

    assert_eq!(watching.end(), Some(0));
}

#[test]
fn imported_files_are_watched_there_or_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let main = "import \"sub/limits.lw\"\n\ncontract Belt {
    input request: bool
    output speed: 0..9

    guarantee slow: always (speed <= LIMIT)
    guarantee moves: always (request -> speed >= 5)
}
";
    write(folder, "main.lw", main);
    let mut watching = Watching::start(folder, &["main.lw", "--format", "json"]);
    watching.verdicts(&[("Belt", "invalid")]);
    std::fs::create_dir(folder.join("sub")).expect("a folder");
    write(folder, "sub/limits.lw", "const LIMIT = 7\n");
    let found = watching.verdicts(&[("Belt", "realizable")]);
    assert_eq!(changes(&found), [("sub/limits.lw", "new")]);
    write(folder, "sub/limits.lw", "const LIMIT = 3\n");
    watching.verdicts(&[("Belt", "unrealizable")]);
    assert_eq!(watching.end(), Some(1), "the exit code of the last check");
}

#[test]
fn what_a_spectra_file_imports_is_watched() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    std::fs::create_dir(folder.join("specs")).expect("a folder");
    let main = "import \"../rules/Rules.spectra\"\nspec Belt\nenv boolean request;\nsys boolean running;\ngar alw follows(request, running);\n";
    write(folder, "specs/belt.spectra", main);
    let mut watching = Watching::start(folder, &["specs/belt.spectra", "--format", "json"]);
    watching.verdicts(&[("belt", "invalid")]);
    std::fs::create_dir(folder.join("rules")).expect("a folder");
    let rules = |body: &str| {
        let text = format!("spec Rules\npredicate follows(boolean a, boolean b): {body};\n");
        write(folder, "rules/Rules.spectra", &text);
    };
    rules("a -> b");
    let found = watching.verdicts(&[("belt", "realizable")]);
    assert_eq!(changes(&found), [("rules/Rules.spectra", "new")]);
    rules("a <-> b & false");
    watching.verdicts(&[("belt", "unrealizable")]);
    rules("a <->");
    let found = watching.verdicts(&[("belt", "invalid")]);
    // Findings of an imported file are reported at its own place.
    assert!(found.to_string().contains("rules/Rules.spectra"), "{found}");
    watching.end();
}

#[test]
fn people_see_what_has_changed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    for (format, verdict) in [
        ("human", "✓ Sound"),
        ("short", "main.lw: contract Sound: realizable"),
    ] {
        write(folder, "main.lw", CLASH);
        let mut watching = Watching::start(folder, &["main.lw", "--format", format]);
        watching.line("the first verdict", |l| l.contains("unrealizable"));
        write(folder, "main.lw", SOUND);
        watching.line("what has changed", |l| {
            l.starts_with('[') && l.ends_with(" UTC] main.lw has changed")
        });
        watching.line("the second verdict", |l| l.starts_with(verdict));
        assert_eq!(watching.end(), Some(0), "{format}");
    }
}

/// If the output is no longer read, the next check is the last one.
#[test]
fn a_closed_pipe_ends_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write(folder, "main.lw", SOUND);
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = Command::new(support::PROGRAM)
        .args(["check", "--watch", "main.lw"])
        .current_dir(folder)
        .env("LINEWRIGHT_CACHE", "off")
        .stdout(writer)
        .output()
        .expect("it ends");
    assert_eq!(output.status.code(), Some(0));
}

/// A table belongs to the line that names it, also if it does not exist yet.
#[test]
fn a_table_is_watched() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let line = "line L {
    part P
    source s: P at \"data/orders.csv\" column due in min
    buffer b capacity 5
    sink e
    route P: s -> b -> e
}
";
    write(folder, "line.lw", line);
    std::fs::create_dir(folder.join("data")).expect("a folder");
    let mut watching = Watching::start(folder, &["line.lw", "--format", "json"]);
    let mut verdict = |wanted: &str| -> Value {
        let text = watching.line(wanted, |line| {
            let document: Value = serde_json::from_str(line).expect("one document a line");
            document["lines"][0]["verdict"] == wanted
        });
        serde_json::from_str(&text).expect("a document")
    };
    verdict("invalid");
    appear(folder, "data/orders.csv", "due\n1\n2\n");
    verdict("valid");
    write(folder, "data/orders.csv", "due\n2\n1\n");
    let document = verdict("invalid");
    assert_eq!(changes(&document), [("data/orders.csv", "changed")]);
    let finding = &document["findings"][0];
    assert_eq!(
        (text(finding, "code"), &finding["span"]["line"]),
        ("LW417", &3.into())
    );
}

#[test]
fn one_document_for_many_checks_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = support::linewright(folder.path(), &["check", "--watch", "--format", "sarif"]);
    assert_eq!(output.status.code(), Some(2));
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(words.contains("--format json"), "{words}");
    assert!(output.stdout.is_empty());
}
