//! The program from outside, on damaged files: no panic, no hang, limits kept, a meaningful exit
//! code, and no further damage to a file. `tests/README.md` explains how to run it for long.

mod attempt;
mod corpus;
mod mutate;
mod reduce;

use attempt::{Attempt, Fault, Names, Place};
use linewright::line::random::Stream;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Number of runs in the gate.
const RUNS: u64 = 120;
/// Maximum number of further runs to reduce a file.
const REDUCING: usize = 250;

fn number(variable: &str, default: u64) -> u64 {
    let given = std::env::var(variable).ok();
    given.map_or(default, |text| text.parse().expect("a number"))
}

#[test]
fn damaged_files_are_survived() {
    let runs = number("LINEWRIGHT_FUZZ_RUNS", RUNS);
    let seed = number("LINEWRIGHT_FUZZ_SEED", 1);
    let report = std::env::var_os("LINEWRIGHT_FUZZ_REPORT").map(PathBuf::from);
    let folder = tempfile::tempdir().expect("a folder");
    let tree = folder.path().join("tree");
    let seeds = corpus::copied_to(&tree);
    assert!(seeds.len() > 100, "{} files to begin with", seeds.len());
    let mut faults: BTreeMap<String, u64> = BTreeMap::new();
    let mut shown = String::new();
    let mut codes: BTreeMap<String, u64> = BTreeMap::new();
    for run in 0..runs {
        let mut stream = Stream::from_seed(seed.wrapping_mul(1_000_003).wrapping_add(run));
        let mut one = || &seeds[stream.below(seeds.len() as u64) as usize];
        let (file, other) = (one(), one());
        let bytes = mutate::damaged(&mut stream, &file.text, &other.text);
        let names = Names::of(&String::from_utf8_lossy(&bytes));
        let attempt = Attempt::any(&mut stream, file.is_foreign(), &names);
        *codes.entry(attempt.arguments[0].clone()).or_default() += 1;
        let ending = file.path.extension().unwrap_or_default();
        let name = tree.join(&file.path).with_file_name("damaged");
        let place = Place::new(folder.path(), name.with_extension(ending));
        if let Err(fault) = attempt.make(&place, &bytes) {
            let count = faults.entry(fault.key.clone()).or_default();
            *count += 1;
            if *count == 1 {
                let mut fails = |bytes: &[u8]| {
                    attempt
                        .make(&place, bytes)
                        .is_err_and(|f| f.key == fault.key)
                };
                let small = reduced(&bytes, &mut fails);
                let text = describe(run, &attempt, &fault, &file.path, &small);
                if let Some(report) = &report {
                    keep(report, &text, faults.len(), ending, &small);
                }
                shown.push_str(&text);
            }
        }
        std::fs::remove_file(&place.file).expect("the file was there");
        if run % 500 == 499 {
            // Build results and caches grow with each new file.
            let _ = std::fs::remove_dir_all(&place.out);
            let _ = std::fs::remove_dir_all(&place.cache);
            if report.is_some() {
                eprintln!(
                    "{} runs, {} kinds of faults: {faults:?}",
                    run + 1,
                    faults.len()
                );
            }
        }
    }
    println!(
        "{runs} runs over {} files: {codes:?}; {faults:#?}",
        seeds.len()
    );
    assert!(faults.is_empty(), "{shown}");
}

/// First by lines, then by words.
fn reduced(bytes: &[u8], fails: &mut dyn FnMut(&[u8]) -> bool) -> Vec<u8> {
    let lines = reduce::reduced_by_lines(bytes, REDUCING, fails);
    match std::str::from_utf8(&lines) {
        Ok(text) => reduce::reduced_by(mutate::tokens(text), REDUCING, fails),
        Err(_) => lines,
    }
}

fn describe(run: u64, attempt: &Attempt, fault: &Fault, path: &Path, small: &[u8]) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "== {}", fault.key);
    let _ = writeln!(
        text,
        "run {run}, from {}: linewright {}",
        path.display(),
        attempt.shown()
    );
    if !attempt.typed.is_empty() {
        let _ = writeln!(text, "typed: {}", attempt.typed.trim().replace('\n', "; "));
    }
    let said: String = fault.said.chars().take(600).collect();
    let _ = writeln!(
        text,
        "{}\n{}\n",
        String::from_utf8_lossy(small),
        said.trim()
    );
    text
}

/// Adds a fault to a folder: its description in `faults.txt`, and its file.
fn keep(folder: &Path, text: &str, number: usize, ending: &std::ffi::OsStr, small: &[u8]) {
    use std::io::Write as _;
    std::fs::create_dir_all(folder).expect("a folder");
    let file = format!("fault-{}-{number}", std::process::id());
    let path = folder.join(file).with_extension(ending);
    std::fs::write(&path, small).expect("a file");
    let mut list = std::fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(folder.join("faults.txt"))
        .expect("a list");
    write!(list, "{}\n{text}", path.display()).expect("a list");
}
