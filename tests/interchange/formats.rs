//! Other tools' specifications: what the readers accept and reject, and the verdicts.
//! `round_trips.rs` proves that what is written is read again.

mod meaning;

use crate::support::games::{specifications, verdict};
use crate::{random, support};
use linewright::diagnostics::render;
use linewright::gr1::Timing;
use linewright::interchange::{Format, Reading, lower, read};
use linewright::source::{FileId, SourceMap};
use proptest::prelude::*;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn read_text(format: Format, text: &str) -> Reading {
    read(format, "test", FileId(0), text)
}

/// The findings as text.
fn shown(reading: &Reading, text: &str) -> String {
    let mut sources = SourceMap::new();
    sources.add(format!("test.{}", reading.format.ending()), text);
    anstream::adapter::strip_str(&render::human(&sources, &reading.findings)).to_string()
}

#[test]
fn every_benchmark_is_read_or_refused_for_the_known_reason() {
    let Some(folder) = support::specs() else {
        return;
    };
    let (mut count, mut refused, mut report) = (0, 0, String::new());
    for (format, path) in specifications(&folder) {
        let text = std::fs::read_to_string(&path).expect("a text");
        let start = std::time::Instant::now();
        let reading = read_text(format, &text);
        let spent = start.elapsed();
        count += 1;
        assert!(spent.as_secs_f64() < 2.0, "{}: {spent:?}", path.display());
        let found = |id| reading.findings.iter().any(|f| f.code.id == id);
        if found("LW209") {
            let folder = path.parent().and_then(Path::file_name).expect("a folder");
            assert_eq!(folder, "syntech15-unrealizable", "{}", path.display());
            refused += 1;
        } else if found("LW201") {
            // Streett pairs.
            assert!(
                path.ends_with("generalized_buffer.tlsf"),
                "{}",
                path.display()
            );
            refused += 1;
        } else if !reading.findings.is_empty() {
            let _ = writeln!(report, "{}\n{}", path.display(), shown(&reading, &text));
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(count > 120, "only {count} files");
    assert_eq!(refused, 7);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn lowering_keeps_the_verdict(specification in random::specifications()) {
        let wanted = verdict(&specification);
        let plain = lower::without_invariants(&specification);
        prop_assert_eq!(verdict(&plain), wanted);
        let second = lower::to_mealy(&plain);
        prop_assert_eq!(verdict(&second), wanted);
        let states = lower::goals_to_states(&second);
        prop_assert_eq!(verdict(&states), wanted);
        prop_assert_eq!(verdict(&lower::initial_to_transitions(&states)), wanted);
    }
}

/// The cases of `tests/cases/interchange`: expectations are in the comment at the end of the line
/// that causes them.
fn cases() -> Vec<(Format, PathBuf, String)> {
    specifications(&support::root().join("tests/cases/interchange"))
        .into_iter()
        .map(|(format, path)| {
            let text = std::fs::read_to_string(&path).expect("a text");
            (format, path, text)
        })
        .collect()
}

#[test]
fn findings_stand_where_they_are_expected() {
    let mut report = String::new();
    for (format, path, text) in cases() {
        let mut expected: Vec<(usize, &str)> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            if let Some((_, codes)) = line.split_once("#~^") {
                expected.extend(codes.split_whitespace().map(|c| (index, c)));
            }
        }
        let reading = read_text(format, &text);
        let line = |f: &linewright::diagnostics::Diagnostic| {
            let start = f.span.expect("a place").start as usize;
            text[..start].matches('\n').count() + 1
        };
        let mut found: Vec<(usize, &str)> = reading
            .findings
            .iter()
            .map(|f| (line(f), f.code.id))
            .collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert!(
            reading.findings.iter().all(|f| f.help.is_some()),
            "{}",
            path.display()
        );
        if found != expected {
            let missing: Vec<_> = expected.iter().filter(|e| !found.contains(e)).collect();
            let extra: Vec<_> = found.iter().filter(|f| !expected.contains(f)).collect();
            let _ = writeln!(
                report,
                "{}: missing {missing:?}, extra {extra:?}\n{}",
                path.display(),
                shown(&reading, &text)
            );
        }
    }
    assert!(report.is_empty(), "{report}");
}

#[test]
fn messages_as_a_person_reads_them() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../cases/snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for (format, path, text) in cases() {
            let reading = read_text(format, &text);
            let name = path
                .file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            let shown = format!(
                "--- {name}\n{text}\n--- findings\n{}",
                shown(&reading, &text)
            );
            insta::assert_snapshot!(format!("interchange__{name}"), shown);
        }
    });
}

/// Files that take more than two seconds in a release build: only tests ignored by default decide
/// them.
fn is_large(path: &Path) -> bool {
    let name = path.to_string_lossy();
    let large = [
        "amba7",
        "amba10",
        "genbuf60",
        "genbuf100",
        "synt15_12",
        "basicEvasion",
        "Unrealizable2-SelfParking",
    ];
    large.iter().any(|word| name.contains(word))
}

/// The verdict on a benchmark given by several tools: by folder, or for mixed folders as stated in
/// the files.
fn known_verdict(path: &Path) -> bool {
    let folder = path.parent().and_then(Path::file_name).expect("a folder");
    match folder.to_string_lossy().as_ref() {
        "anzu" | "syntech15" | "synt15" => true,
        "syntech15-unrealizable" => false,
        _ => ![
            "unrealizable",
            "unrealizability",
            "errorneous",
            "case_study_unreal",
            "baby_network",
            // Of Spectra's: `tests/interchange/spectra/bench.rs` has the reason.
            "AirportShuttle_208",
            "VehicleSpec_133",
            "ConvoyCarSpec_297",
        ]
        .iter()
        .any(|word| path.to_string_lossy().contains(word)),
    }
}

/// Decides the benchmarks for which `wanted` holds. `None` without benchmarks; otherwise the number
/// of both verdicts, and the number of files that are not read.
fn decide_benchmarks(wanted: impl Fn(&Path) -> bool + Sync) -> Option<[usize; 3]> {
    let files = specifications(&support::specs()?);
    let decided = files.par_iter().filter(|(_, path)| wanted(path));
    let decided = decided.map(|(format, path)| {
        let text = std::fs::read_to_string(path).expect("a text");
        let Some(specification) = read_text(*format, &text).specification else {
            return [0, 0, 1];
        };
        let known = known_verdict(path);
        let start = std::time::Instant::now();
        assert_eq!(verdict(&specification), known, "{}", path.display());
        eprintln!("{}: {:.1?}", path.display(), start.elapsed());
        [usize::from(!known), usize::from(known), 0]
    });
    Some(decided.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]))
}

#[test]
fn verdicts_on_the_benchmarks() {
    let Some(counts) = decide_benchmarks(|path| !is_large(path)) else {
        return;
    };
    let [unrealizable, realizable, refused] = counts;
    assert!(unrealizable >= 15 && realizable >= 100, "{counts:?}");
    assert_eq!(refused, 7);
}

/// The remaining ones: minutes, even in a release build.
#[test]
#[ignore = "takes minutes; see tests/README.md"]
fn verdicts_on_large_benchmarks() {
    let Some(counts) = decide_benchmarks(is_large) else {
        return;
    };
    let [unrealizable, realizable, refused] = counts;
    assert!(unrealizable >= 2 && realizable >= 6, "{counts:?}");
    assert_eq!(refused, 0);
}

/// The random specifications are useful: both verdicts are frequent, whatever the timing.
#[test]
fn random_specifications_have_both_verdicts() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut counts = [[0u32; 2]; 2];
    for _ in 0..300 {
        let tree = random::specifications()
            .new_tree(&mut runner)
            .expect("a value");
        let specification = proptest::strategy::ValueTree::current(&tree);
        let moore = usize::from(specification.timing == Timing::Moore);
        counts[moore][usize::from(verdict(&specification))] += 1;
    }
    for [unrealizable, realizable] in counts {
        let all = unrealizable + realizable;
        assert!(unrealizable * 8 > all && realizable * 8 > all, "{counts:?}");
    }
}
