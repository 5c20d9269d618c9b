//! Other tools' specifications: what the readers take and refuse, what the writers write, and that both mean the same.

mod support;

use linewright::diagnostics::render;
use linewright::interchange::{Format, Reading, read};
use linewright::source::{FileId, SourceMap};
use std::path::{Path, PathBuf};

/// The public benchmark specifications, where they lie beside the repository.
fn bench() -> Option<PathBuf> {
    let folder = std::env::var_os("LINEWRIGHT_SPECS")
        .map_or_else(|| support::root().join("../shared/bench/specs"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    support::skip("specs", "the benchmark specifications are not beside the repository");
    None
}

/// Every file below a folder in one of the formats, sorted.
fn specifications(folder: &Path) -> Vec<(Format, PathBuf)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else if let Some(format) = Format::of_path(&path.to_string_lossy()) {
                found.push((format, path));
            }
        }
    }
    found.sort_by(|a, b| a.1.cmp(&b.1));
    found
}

fn read_text(format: Format, text: &str) -> Reading {
    read(format, "test", FileId(0), text)
}

/// The findings as a person reads them.
fn shown(reading: &Reading, text: &str) -> String {
    let mut sources = SourceMap::new();
    sources.add(format!("test.{}", reading.format.ending()), text);
    anstream::adapter::strip_str(&render::human(&sources, &reading.findings)).to_string()
}

#[test]
fn every_benchmark_is_read_or_refused_for_the_known_reason() {
    let Some(folder) = bench() else { return };
    let (mut count, mut refused, mut report) = (0, Vec::new(), String::new());
    for (format, path) in specifications(&folder) {
        let text = std::fs::read_to_string(&path).expect("a text");
        let start = std::time::Instant::now();
        let reading = read_text(format, &text);
        let spent = start.elapsed();
        count += 1;
        assert!(spent.as_secs_f64() < 2.0, "{}: {spent:?}", path.display());
        if reading.findings.iter().any(|f| f.code.id == "LW209") {
            refused.push(path.file_stem().expect("a name").to_string_lossy().into_owned());
        } else if !reading.findings.is_empty() {
            report += &format!("{}\n{}", path.display(), shown(&reading, &text));
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(count > 100, "only {count} files");
    eprintln!("{count} {refused:?}");
}
