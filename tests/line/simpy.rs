//! Random lines in the runner and in a second simulator, `oracle/simulate.py`, in Python on the
//! calendar of `SimPy`. It shares no code with the runner, and reads the lines from a description
//! of its own, not from what was resolved. It was written with the runner's rule of ties in view,
//! so it cannot find a fault in that rule, only in the runner that does not keep to it.
//!
//! # What is compared
//!
//! Every entry of the movement log, one by one: its time, its place, what happened, and the type
//! and number of the part. Times are equal to the last bit. The draws are therefore the same, too:
//! the oracle has its own generator and its own constant, uniform, exponential, discrete and
//! empirical times, defects and choices. Times from other distributions are drawn here by the
//! public sampler, one table for each stream.
//!
//! # Ties
//!
//! What happens at one instant is ordered by this rule, in both:
//!
//! 1. All consequences of an event at its instant come before the next event.
//! 2. Of events at one instant, those of stations, sources and conveyors come before the changes of
//!    shifts. Apart from that, the event that was planned first comes first.
//! 3. A place gives its room to the oldest request that it can grant. A part that comes waits while
//!    there is one. Requests are numbered as they begin; a part that overtakes takes the turn of
//!    the part that it overtakes.
//! 4. Places in which something may have changed are examined in the order in which this came up,
//!    at the start in the order of the file. A place first offers its next part, then joins, then
//!    gives its room.
//!
//! # What the lines have
//!
//! Sources of every kind, also from tables, with limits and with limits of parts in the line; one
//! to three part types with properties; buffers of every order; stations with times by type,
//! copies, setup, failures of every kind, new properties, defects, shifts with breaks and overtime;
//! plain conveyors; joins; lists of places with every choice; conditions, rework, overflow, rejects
//! and reorders. Stores, warm-ups, stations with machines and conveyors with contracts are left to
//! other tests.

pub mod lines;

use crate::models::{Logged, RunLogged};
use crate::support::{python_with, root};
use lines::RandomLine;
use linewright::contract::load;
use linewright::diagnostics::has_errors;
use linewright::line::log::EventKind;
use linewright::line::{End, Options, Plant};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

const LINES: u64 = 1000;

/// The number of lines: `LINEWRIGHT_SIMPY`, or 1000.
fn count() -> u64 {
    std::env::var("LINEWRIGHT_SIMPY").map_or(LINES, |count| {
        count.parse().expect("LINEWRIGHT_SIMPY is a number")
    })
}

/// An entry of a log: time, and the rest as text.
type Entry = (f64, String);

/// What the runner does, with the log as text.
fn run(line: &RandomLine) -> (Logged, Vec<Entry>) {
    let text = format!("line L {{\n{}}}\n", line.text);
    let files = [("line.lw".to_owned(), text)];
    let (mut library, findings) = load(&files, &|path, _| {
        let mut tables = line.tables.iter();
        let table = tables.find(|(name, _)| name == path);
        table.cloned().ok_or("there is no such table".to_owned())
    });
    assert!(!has_errors(&findings), "{}: {findings:?}", line.text);
    let options = Options {
        seed: line.seed,
        parts: line.parts,
        until: Some(line.until),
        ..Options::default()
    };
    let resolved = Arc::new(library.lines.remove(0));
    let mut plant = Plant::new(Arc::clone(&resolved), BTreeMap::new(), options)
        .unwrap_or_else(|findings| panic!("{}: {findings:?}", line.text));
    let logged = plant.run_logged();
    let log = logged.movements().map(|entry| {
        let place = &resolved.nodes[entry.node].name;
        let part = entry.part.map_or("- 0".to_owned(), |(number, kind)| {
            format!("{} {number}", resolved.parts[kind].name)
        });
        (entry.time, format!("{place} {:?} {part}", entry.what))
    });
    let log = log.collect();
    (logged, log)
}

/// Starts the oracle on lines; its answer goes to a file.
fn start(python: &Path, lines: &[RandomLine], folder: &Path) -> Child {
    let mut texts = String::new();
    for line in lines {
        let _ = writeln!(texts, "{}", line.json);
    }
    let file = folder.join("lines.json");
    std::fs::write(&file, texts).expect("a file");
    let answer = std::fs::File::create(folder.join("logs.txt")).expect("a file");
    Command::new(python)
        .arg("-B")
        .arg(root().join("tests/line/oracle/simulate.py"))
        .arg(file)
        .stdout(answer)
        .stderr(Stdio::piped())
        .spawn()
        .expect("Python starts")
}

/// The oracle's logs.
fn logs(answer: &str) -> Vec<Vec<Entry>> {
    let mut logs: Vec<Vec<Entry>> = Vec::new();
    for line in answer.lines() {
        if line.starts_with("line ") {
            logs.push(Vec::new());
        } else if let Some((time, rest)) = line.split_once(' ') {
            let time = time.parse().expect("a time");
            logs.last_mut()
                .expect("a log")
                .push((time, rest.to_owned()));
        }
    }
    logs
}

fn is_failure((_, entry): &Entry) -> bool {
    entry.ends_with(" Failed - 0") || entry.ends_with(" Repaired - 0")
}

/// The first difference between two logs, with what came before.
fn difference(ours: &[Entry], theirs: &[Entry]) -> Option<String> {
    let at = (0..ours.len().max(theirs.len())).find(|&at| ours.get(at) != theirs.get(at))?;
    let mut text = String::new();
    for (time, entry) in &ours[at.saturating_sub(5)..at] {
        let _ = writeln!(text, "  {time} {entry}");
    }
    let _ = writeln!(text, "  runner: {:?}", ours.get(at));
    let _ = writeln!(text, "  oracle: {:?}", theirs.get(at));
    Some(text)
}

#[test]
fn random_lines_agree_with_simpy() {
    let Some(python) = python_with("simpy", "simpy") else {
        return;
    };
    let lines: Vec<RandomLine> = (1..=count()).map(lines::line).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let oracle = start(&python, &lines, folder.path());
    let runs: Vec<(Logged, Vec<Entry>)> = lines.iter().map(run).collect();
    let output = oracle.wait_with_output().expect("Python ends");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the oracle fails: {words}");
    let answer = std::fs::read_to_string(folder.path().join("logs.txt")).expect("logs");
    let logs = logs(&answer);
    assert_eq!(logs.len(), lines.len(), "{words}");
    let (mut wrong, mut entries) = (Vec::new(), 0);
    for ((line, (trace, log)), theirs) in lines.iter().zip(&runs).zip(&logs) {
        let theirs = match theirs.get(log.len()..) {
            // A run in which nothing moves any more ends early, and does not show the failures
            // that the calendar still holds.
            Some(rest) if trace.end != End::Products && rest.iter().all(is_failure) => {
                &theirs[..log.len()]
            }
            _ => &theirs[..],
        };
        entries += log.len();
        if let Some(text) = difference(log, theirs) {
            wrong.push(format!("line {}\n{}{text}", line.seed, line.text));
        }
    }
    println!(
        "{} lines, {entries} entries; {} differ",
        lines.len(),
        wrong.len()
    );
    wrong.sort_by_key(String::len);
    assert!(wrong.is_empty(), "{} differ; {}", wrong.len(), wrong[0]);
    check_variety(&runs);
}

/// The lines show all that can happen.
fn check_variety(runs: &[(Logged, Vec<Entry>)]) {
    let mut ends = BTreeMap::new();
    let mut kinds = BTreeMap::new();
    for (trace, _) in runs {
        *ends.entry(format!("{:?}", trace.end)).or_insert(0) += 1;
        for entry in &trace.log {
            *kinds.entry(format!("{:?}", entry.what)).or_insert(0) += 1;
        }
    }
    println!("{ends:?} {kinds:?}");
    for kind in [
        EventKind::Consumed,
        EventKind::SetupStarted,
        EventKind::Rejected,
        EventKind::Finished,
        EventKind::Failed,
        EventKind::Repaired,
    ] {
        let count = kinds.get(&format!("{kind:?}")).copied().unwrap_or(0);
        assert!(count >= runs.len() / 4, "{kind:?}: {count}");
    }
}
