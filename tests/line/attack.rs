//! Random machines and lines compared with what is proved of them: none that is proved has a run in
//! which a part is refused, stuck, lost or missing, unless a premise of the proof names it; and
//! enough of those not proved really fail. `tests/README.md` explains how to run this for long.

mod found;
mod judge;
mod lines;
mod machines;
mod runs;
mod stocks;
mod table;
pub mod text;

use crate::reduce;
use judge::{Judged, Report, judge};
use runs::{Failure, World};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use table::Table;
use text::Chance;

/// Machines, and lines per machine, in the gate.
const GATE: (usize, usize) = (12, 13);
/// Number of machines per file.
const MACHINES_A_BATCH: usize = 6;
/// Seeds of the runs.
const SEEDS: [u64; 3] = [1, 2, 3];
/// One in this many lines is also run with compiled libraries.
const SAMPLED: usize = 60;
/// Minimum percentage of unproved lines that must fail.
const LEAST_FAILING: usize = 30;
/// Maximum number of attempts to reduce a file.
const REDUCING: usize = 120;

/// `LINEWRIGHT_ATTACK=500x40`: machines, and lines per machine.
fn size() -> (usize, usize) {
    let Ok(text) = std::env::var("LINEWRIGHT_ATTACK") else {
        return GATE;
    };
    let numbers = text
        .split_once('x')
        .and_then(|(m, l)| Some((m.parse().ok()?, l.parse().ok()?)));
    numbers.expect("LINEWRIGHT_ATTACK is machines x lines a machine, such as 500x40")
}

fn seed() -> u64 {
    let given = std::env::var("LINEWRIGHT_ATTACK_SEED").ok();
    given.map_or(1, |text| text.parse().expect("a number"))
}

/// Folder of the generated files; they are kept if `LINEWRIGHT_ATTACK_FILES` names it.
fn files() -> Option<PathBuf> {
    std::env::var_os("LINEWRIGHT_ATTACK_FILES").map(PathBuf::from)
}

/// Folder for lines that fail although they are proved.
fn kept() -> Option<PathBuf> {
    std::env::var_os("LINEWRIGHT_ATTACK_REPORT").map(PathBuf::from)
}

#[test]
fn what_is_proved_holds_in_runs() {
    let (wanted, lines) = size();
    let temporary = tempfile::tempdir().expect("a folder");
    let folder = files().unwrap_or_else(|| temporary.path().to_owned());
    let mut table = Table::default();
    let mut batch = 0;
    while table.machines < wanted {
        let seed = seed().wrapping_mul(1_000_003).wrapping_add(batch);
        attack(seed, lines, &folder, &mut table);
        batch += 1;
        if kept().is_some() && batch % 10 == 0 {
            eprintln!("{table}");
        }
    }
    println!("{table}");
    println!(
        "{} products in long runs",
        runs::MADE_IN_LONG_RUNS.load(std::sync::atomic::Ordering::Relaxed)
    );
    assert!(table.broken.is_empty(), "{}", table.broken.join("\n"));
    assert!(
        table.without_reason.is_empty(),
        "no reason is given for {:?}",
        table.without_reason
    );
    let share = 100 * table.failing / table.unproved_that_ran().max(1);
    assert!(
        share >= LEAST_FAILING,
        "{share} % of the lines that are not proved fail"
    );
}

/// Generates machines, keeps the sound ones, and tests lines over these.
fn attack(seed: u64, lines_a_machine: usize, folder: &Path, table: &mut Table) {
    let chance = &mut Chance::new(seed);
    let mut batch = machines::batch(chance, MACHINES_A_BATCH);
    let cache = folder.join("cache");
    let file = folder.join(format!("attack-{seed}.lw"));
    std::fs::write(folder.join("arrivals.csv"), lines::ARRIVALS).expect("a file");
    let judged = |text: &str, table: &mut Table| -> Option<Report> {
        std::fs::write(&file, text).expect("a file");
        let report = judge(&file, &cache);
        if let Some(failure) = &report.failure {
            table.broken(seed, "check", failure, text, kept().as_deref());
            return None;
        }
        Some(report)
    };
    let Some(report) = judged(&batch.text(), table) else {
        return;
    };
    for codes in report.machines.values().filter(|codes| !codes.is_empty()) {
        table.refused(codes);
    }
    batch.keep(|name| report.machines.get(name).is_some_and(Vec::is_empty));
    if batch.machines.is_empty() {
        return;
    }
    table.machines += batch.machines.len();
    let texts: Vec<String> = (0..lines_a_machine * batch.machines.len())
        .map(|at| lines::line(chance, &format!("L{at}"), &batch))
        .collect();
    let text = batch.text() + &texts.concat();
    let Some(report) = judged(&text, table) else {
        return;
    };
    let world = World::new(&file.to_string_lossy(), &text);
    for (at, text) in texts.iter().enumerate() {
        let name = format!("L{at}");
        let Some(judged) = report.lines.get(&name) else {
            table.without_reason.push(format!("{seed} {name}"));
            continue;
        };
        let failures = world
            .line(&name)
            .and_then(|line| world.failures(line, &SEEDS));
        table.line(&format!("{seed} {name}"), judged, failures.as_ref());
        let whole = batch.text() + text;
        if table.lines % SAMPLED == 1
            && let Err(said) = agrees(&world, &name, judged, &whole, folder)
        {
            let small = if table.is_new("disagreement", &said) {
                reduced_disagreement(&whole, folder)
            } else {
                whole.clone()
            };
            table.broken(seed, "disagreement", &said, &small, kept().as_deref());
        }
        let Some(failures) = failures.filter(|_| judged.is_proved()) else {
            continue;
        };
        if let Some(first) = unnamed(judged, &failures).first() {
            let small = if table.is_new(first.kind, &first.said) {
                reduced(&whole, first, folder)
            } else {
                whole
            };
            table.broken(seed, first.kind, &first.said, &small, kept().as_deref());
        }
    }
    if files().is_none() {
        std::fs::remove_file(&file).expect("the file was there");
    }
}

/// `run` with compiled libraries finds the errors that `check` finds, rejects nothing else, and has
/// the same results as the interpreter.
fn agrees(
    world: &World,
    name: &str,
    judged: &Judged,
    text: &str,
    folder: &Path,
) -> Result<(), String> {
    // With a shift, the runs here last longer.
    if world.line(name).is_some_and(|line| line.calendar.is_some()) {
        return Ok(());
    }
    let file = folder.join("sample.lw");
    std::fs::write(&file, text).expect("a file");
    let ran = judge::run(
        &file,
        &folder.join("cache"),
        SEEDS[0],
        runs::PARTS,
        runs::SECONDS,
    );
    let Some(ran) = ran else {
        return if judged.errors.is_empty() {
            Err("check finds no error, and run refuses".to_owned())
        } else {
            Ok(())
        };
    };
    ran.agrees_with(judged)?;
    let (products, violations) = (ran.products, ran.violations);
    let trace = world
        .line(name)
        .and_then(|line| world.run(line, SEEDS[0], Some(runs::PARTS), runs::SECONDS))
        .ok_or("the program runs what cannot be run here")?;
    if (trace.products, trace.violation_count) == (products, violations) {
        Ok(())
    } else {
        Err(format!(
            "{products} products and {violations} violations with libraries, {} and {} with the interpreter",
            trace.products, trace.violation_count
        ))
    }
}

/// The failures that no premise of the proof names.
fn unnamed<'a>(judged: &Judged, failures: &'a BTreeSet<Failure>) -> Vec<&'a Failure> {
    let named = |failure: &Failure| {
        let mut premises = judged.premises.iter();
        premises.any(|premise| failure.names.iter().any(|name| has_word(premise, name)))
    };
    failures.iter().filter(|f| !named(f)).collect()
}

fn has_word(text: &str, word: &str) -> bool {
    let mut found = text.match_indices(word);
    let inside = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    found.any(|(at, _)| {
        !inside(text[..at].chars().next_back()) && !inside(text[at + word.len()..].chars().next())
    })
}

/// Splits a text into declarations.
fn declarations(text: &str) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for line in text.split_inclusive('\n') {
        if let Some(last) = pieces.last_mut() {
            last.push_str(line);
        }
        if line == "}\n" {
            pieces.push(String::new());
        }
    }
    pieces
}

/// A small file with one line that is proved and fails in the same way.
fn reduced(text: &str, failure: &Failure, folder: &Path) -> String {
    smaller(text, folder, |report, text, file| {
        let Some((name, judged)) = report.lines.first_key_value() else {
            return false;
        };
        if !judged.is_proved() {
            return false;
        }
        let world = World::new(&file.to_string_lossy(), text);
        let failures = world
            .line(name)
            .and_then(|line| world.failures(line, &SEEDS));
        let failures = failures.unwrap_or_default();
        let same = |f: &&Failure| f.kind == failure.kind;
        unnamed(judged, &failures).iter().any(same)
    })
}

/// A small file on whose line `check` and `run` disagree in the same way.
fn reduced_disagreement(text: &str, folder: &Path) -> String {
    smaller(text, folder, |report, text, file| {
        let Some((name, judged)) = report.lines.first_key_value() else {
            return false;
        };
        let world = World::new(&file.to_string_lossy(), text);
        world.line(name).is_some() && agrees(&world, name, judged, text, folder).is_err()
    })
}

/// The reduced form of a file whose machines are all sound: first by declarations, then by lines,
/// as long as `fails` holds.
fn smaller(text: &str, folder: &Path, fails: impl Fn(&Report, &str, &Path) -> bool) -> String {
    let cache = folder.join("cache");
    let file = folder.join("reduced.lw");
    let mut asked = |bytes: &[u8]| {
        std::fs::write(&file, bytes).expect("a file");
        let report = judge(&file, &cache);
        let sound = report.machines.values().all(Vec::is_empty);
        sound && fails(&report, &String::from_utf8_lossy(bytes), &file)
    };
    let small = reduce::reduced_by(declarations(text), REDUCING, &mut asked);
    let small = reduce::reduced_by_lines(&small, REDUCING, &mut asked);
    String::from_utf8_lossy(&small).into_owned()
}
