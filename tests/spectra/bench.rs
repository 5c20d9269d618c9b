//! The benchmark files: what is read, what is refused and why, and the verdicts.

use crate::support;
use linewright::diagnostics::{has_errors, render};
use linewright::game::{Limits, Options, Outcome, solve_with};
use linewright::gr1::Specification;
use linewright::interchange::{Format, Reading, read};
use linewright::source::{FileId, SourceMap};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The public benchmark specifications, where they lie beside the repository.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("LINEWRIGHT_SPECS").map_or_else(
        || support::root().join("../shared/bench/specs"),
        PathBuf::from,
    );
    if folder.is_dir() {
        return Some(folder);
    }
    support::skip(
        "specs",
        "the benchmark specifications are not beside the repository",
    );
    None
}

/// Every Spectra file, sorted.
fn files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open: Vec<PathBuf> = folder().into_iter().collect();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "spectra") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn read_file(path: &Path) -> (Reading, String) {
    let text = std::fs::read_to_string(path).expect("a text");
    let format = Format::of_path(&path.to_string_lossy()).expect("a format");
    (read(format, "test", FileId(0), &text), text)
}

fn shown(reading: &Reading, text: &str) -> String {
    let mut sources = SourceMap::new();
    sources.add("test.spectra", text);
    anstream::adapter::strip_str(&render::human(&sources, &reading.findings)).to_string()
}

#[test]
fn every_file_is_read() {
    let mut report = String::new();
    for path in files() {
        let start = Instant::now();
        let (reading, text) = read_file(&path);
        let spent = start.elapsed();
        assert!(spent.as_secs_f64() < 2.0, "{}: {spent:?}", path.display());
        if has_errors(&reading.findings) {
            let _ = writeln!(report, "{}\n{}", path.display(), shown(&reading, &text));
        }
    }
    assert!(report.is_empty(), "{report}");
}

fn verdict(specification: &Specification) -> Option<bool> {
    let limits = Limits {
        deadline: Some(Instant::now() + Duration::from_secs(20)),
        memory_mib: Some(1024),
        ..Limits::default()
    };
    let options = Options {
        limits,
        without_core: true,
        ..Options::default()
    };
    match solve_with(specification, &options).outcome {
        Outcome::Realizable(_) => Some(true),
        Outcome::Unrealizable(_) => Some(false),
        Outcome::GaveUp(_) => None,
    }
}

#[test]
fn verdicts_agree_with_folders_and_translations() {
    let reports: Vec<String> = files()
        .par_iter()
        .map(|path| {
            let (reading, _) = read_file(path);
            let Some(specification) = reading.specification else {
                return String::new();
            };
            let start = Instant::now();
            let ours = verdict(&specification);
            let spent = start.elapsed();
            let slugsin = path.with_extension("slugsin");
            let theirs = slugsin.exists().then(|| {
                let reading = read_file(&slugsin).0;
                reading.specification.map(|s| verdict(&s))
            });
            format!("{}: {ours:?} {theirs:?} {spent:?}", path.display())
        })
        .collect();
    panic!("{}", reports.join("\n"));
}
