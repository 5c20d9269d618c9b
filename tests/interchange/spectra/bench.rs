//! The benchmark files: which are read, which are rejected and why, and the verdicts.

use crate::support;
use linewright::diagnostics::render;
use linewright::game::{Limits, Options, Outcome, solve_with};
use linewright::gr1::Specification;
use linewright::interchange::{Format, Reading, read};
use linewright::source::{FileId, SourceMap};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Every Spectra file, sorted.
pub fn files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open: Vec<PathBuf> = support::specs().into_iter().collect();
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

pub fn read_file(path: &Path) -> (Reading, String) {
    let text = std::fs::read_to_string(path).expect("a text");
    let format = Format::from_path(&path.to_string_lossy()).expect("a format");
    (read(format, "test", FileId(0), &text), text)
}

pub fn shown(reading: &Reading, text: &str) -> String {
    let mut sources = SourceMap::new();
    sources.add("test.spectra", text);
    anstream::adapter::strip_str(&render::human(&sources, &reading.findings)).to_string()
}

/// Rejected files and the reason: these assumptions promise the machine's own next values, which no
/// environment can. Their translations for slugs and gr1c are rejected for the same formulas.
const REFUSED: [(&str, &str); 2] = [
    ("HumanoidLTL_713_Humanoid_unrealizable", "LW209"),
    (
        "HumanoidLTL_NotRealizable2_884_Humanoid_unrealizable",
        "LW209",
    ),
];

/// Files of the mixed folder without a machine, and the reason. Spectra's collection has the same
/// bytes in `SYNTECH17/all_unrealizable`.
const UNREALIZABLE: [(&str, &str); 3] = [
    (
        "AirportShuttleProject_AirportShuttle1_AirportShuttle_208",
        "its monitor UturnAllowed has to be true and false when the shuttle enters a station without tasks ahead",
    ),
    (
        "SimpleVehicle_VehicleSpec_133",
        "while scanning beside a parallel place it has to go on scanning and to begin parking",
    ),
    (
        "V3_ConvoyCar_ConvoyCarSpec_297",
        "out of its lane it has to turn or to stop, and too close to slow down straight ahead by one",
    ),
];

#[test]
fn every_file_is_read_or_refused_for_the_known_reason() {
    let (mut report, mut refused) = (String::new(), 0);
    for path in files() {
        let start = Instant::now();
        let (reading, text) = read_file(&path);
        let spent = start.elapsed();
        assert!(spent.as_secs_f64() < 2.0, "{}: {spent:?}", path.display());
        let name = path.to_string_lossy();
        if let Some((_, code)) = REFUSED.iter().find(|(n, _)| name.contains(n)) {
            refused += 1;
            let codes: Vec<&str> = reading.findings.iter().map(|f| f.code.id).collect();
            assert_eq!(codes, [*code], "{name}");
        } else if !reading.findings.is_empty() {
            let _ = writeln!(report, "{name}\n{}", shown(&reading, &text));
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(refused == REFUSED.len() || files().is_empty());
}

pub fn verdict(specification: &Specification) -> Option<bool> {
    let limits = Limits {
        // Seconds on an idle computer.
        deadline: linewright::deadline::Deadline::from_now(Duration::from_mins(3)),
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
    let decided: Vec<bool> = files()
        .par_iter()
        .map(|path| {
            let (reading, _) = read_file(path);
            let Some(specification) = reading.specification else {
                return false;
            };
            let name = path.to_string_lossy();
            let known = !(name.contains("syntech15-unrealizable/")
                || UNREALIZABLE.iter().any(|(n, _)| name.contains(n)));
            assert_eq!(verdict(&specification), Some(known), "{name}");
            let translation = path.with_extension("slugsin");
            if translation.exists()
                && let Some(theirs) = read_file(&translation).0.specification
            {
                assert_eq!(verdict(&theirs), Some(known), "{}", translation.display());
            }
            true
        })
        .collect();
    let count = decided.iter().filter(|d| **d).count();
    assert!(count == 66 || decided.is_empty(), "{count} files");
}
