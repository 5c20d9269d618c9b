//! Other tools' specifications: what the readers take and refuse, what the writers write, and that both mean the same.

#[path = "interchange/meaning.rs"]
mod meaning;
#[path = "interchange/random.rs"]
mod random;
mod support;

use linewright::contract::load;
use linewright::diagnostics::{has_errors, render};
use linewright::game::{Limits, Options, Outcome, solve_with};
use linewright::gr1::eval::holds;
use linewright::gr1::{Formula, Owner, Specification, Timing};
use linewright::interchange::{Format, Reading, Target, contract, lower, read, write};
use linewright::source::{FileId, SourceMap};
use proptest::prelude::*;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

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
                // Those of TLSF have a test file of their own.
                if format != Format::Tlsf {
                    found.push((format, path));
                }
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
        if reading.findings.iter().any(|f| f.code.id == "LW209") {
            let folder = path.parent().and_then(Path::file_name).expect("a folder");
            assert_eq!(folder, "syntech15-unrealizable", "{}", path.display());
            refused += 1;
        } else if !reading.findings.is_empty() {
            let _ = writeln!(report, "{}\n{}", path.display(), shown(&reading, &text));
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(count > 120, "only {count} files");
    assert_eq!(refused, 6);
}

fn verdict(specification: &Specification) -> bool {
    let limits = Limits {
        deadline: None,
        memory_mib: Some(1024),
        ..Limits::default()
    };
    let options = Options {
        limits,
        without_core: true,
        ..Options::default()
    };
    match solve_with(specification, &options).outcome {
        Outcome::Realizable(_) => true,
        Outcome::Unrealizable(_) => false,
        Outcome::GaveUp(limit) => panic!("gave up: {limit}"),
    }
}

/// Reads what was written; nothing may be wrong with it.
fn reread(format: Format, text: &str) -> Specification {
    let reading = read_text(format, text);
    let findings = shown(&reading, text);
    reading
        .specification
        .unwrap_or_else(|| panic!("{text}\n{findings}"))
}

/// The contract that a printed text declares.
fn reload(text: &str) -> Specification {
    let files = [("test.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(!has_errors(&findings), "{text}\n{findings:#?}");
    let [contract] = library.contracts.as_slice() else {
        panic!("one contract in {text}");
    };
    (*contract.specification).clone()
}

/// Current and next values of all variables, as many as `seeds` asks for.
fn valuations(specification: &Specification, seeds: &[u64]) -> Vec<(Vec<i64>, Vec<i64>)> {
    let draw = |seed: u64| -> Vec<i64> {
        let mut state = seed;
        specification
            .variables
            .iter()
            .map(|v| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                v.domain.low() + ((state >> 33) % v.domain.size()) as i64
            })
            .collect()
    };
    seeds
        .iter()
        .map(|s| (draw(*s), draw(s.rotate_left(17) ^ 0x5bd1)))
        .collect()
}

/// That two lists of formulas have the same values in the same order, where `carry` turns valuations of the one specification
/// into such of the other.
fn same_values(
    what: &str,
    a: &[Formula],
    b: &[Formula],
    valuations: &[(Vec<i64>, Vec<i64>)],
    carry: &dyn Fn(&[i64]) -> Vec<i64>,
) {
    assert!(
        a.len() <= b.len(),
        "{what}: {} formulas became {}",
        a.len(),
        b.len()
    );
    for (f, g) in a.iter().zip(b) {
        for (now, next) in valuations {
            let other = (carry(now), carry(next));
            assert_eq!(
                holds(&f.expr, now, next),
                holds(&g.expr, &other.0, &other.1),
                "{what}: {:?} became {:?} at {now:?}, {next:?}",
                f.expr,
                g.expr
            );
        }
    }
}

/// All lists of two specifications.
fn same_formulas(
    a: &Specification,
    b: &Specification,
    seeds: &[u64],
    carry: &dyn Fn(&[i64]) -> Vec<i64>,
) {
    let valuations = valuations(a, seeds);
    for (a, b) in [
        (&a.assumptions, &b.assumptions),
        (&a.guarantees, &b.guarantees),
    ] {
        same_values("initial", &a.initial, &b.initial, &valuations, carry);
        same_values(
            "invariants",
            &a.invariants,
            &b.invariants,
            &valuations,
            carry,
        );
        same_values("safety", &a.safety, &b.safety, &valuations, carry);
        same_values("justice", &a.justice, &b.justice, &valuations, carry);
    }
}

/// A valuation with numbers as their bits, counted from the smallest value.
fn in_bits(specification: &Specification, written: &Specification, values: &[i64]) -> Vec<i64> {
    // The writer puts inputs before outputs.
    let mut bits = Vec::new();
    for owner in [Owner::Environment, Owner::System] {
        for (variable, value) in specification.variables.iter().zip(values) {
            if variable.owner == owner {
                let size = variable.domain.size();
                let width = u64::BITS - (size - 1).leading_zeros();
                bits.extend((0..width).map(|k| (value - variable.domain.low()) >> k & 1));
            }
        }
    }
    assert_eq!(bits.len(), written.variables.len());
    bits
}

/// A valuation counted from 0, inputs before outputs.
fn from_zero(specification: &Specification, written: &Specification, values: &[i64]) -> Vec<i64> {
    let mut found = Vec::new();
    for owner in [Owner::Environment, Owner::System] {
        for (variable, value) in specification.variables.iter().zip(values) {
            if variable.owner == owner {
                found.push(value - variable.domain.low());
            }
        }
    }
    // Helpers stand behind.
    found.resize(written.variables.len(), 0);
    found
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn slugsin_says_the_same(specification in random::specifications(), seeds in prop::collection::vec(any::<u64>(), 8)) {
        let text = write(&specification, Target::Slugsin).expect("it is small");
        let back = reread(Format::Slugsin, &text);
        prop_assert_eq!(verdict(&specification), verdict(&back), "{}", text);
        if specification.timing == Timing::Mealy {
            let plain = lower::without_invariants(&specification);
            // Domains become formulas behind those of the specification.
            same_formulas(&plain, &back, &seeds, &|v| in_bits(&plain, &back, v));
        }
        // What slugs' translator reads too: the same lines among structured ones.
        let again = reread(Format::Slugsin, &write(&back, Target::Slugsin).expect("it is small"));
        prop_assert_eq!(verdict(&again), verdict(&back));
    }

    #[test]
    fn spc_says_the_same(specification in random::specifications(), seeds in prop::collection::vec(any::<u64>(), 8)) {
        let text = write(&specification, Target::Spc).expect("it is small");
        let reading = read_text(Format::Spc, &text);
        prop_assert_eq!(shown(&reading, &text), "", "{}", text);
        let back = reading.specification.expect("nothing was found");
        prop_assert_eq!(verdict(&specification), verdict(&back), "{}", text);
        let plain = lower::without_invariants(&specification);
        let lowered = lower::starting_alone(&lower::goals_of_states(&plain));
        if specification.timing == Timing::Mealy && lowered == plain {
            // An initial condition that is a conjunction is read as several.
            let mut joined = back.clone();
            for side in [&mut joined.assumptions, &mut joined.guarantees] {
                side.initial.clear();
            }
            let mut others = plain.clone();
            for side in [&mut others.assumptions, &mut others.guarantees] {
                side.initial.clear();
            }
            same_formulas(&others, &joined, &seeds, &|v| from_zero(&plain, &back, v));
            for (a, b) in [(&plain.assumptions, &back.assumptions), (&plain.guarantees, &back.guarantees)] {
                for (now, _) in valuations(&plain, &seeds) {
                    let other = from_zero(&plain, &back, &now);
                    prop_assert_eq!(
                        a.initial.iter().all(|f| holds(&f.expr, &now, &[])),
                        b.initial.iter().all(|f| holds(&f.expr, &other, &[]))
                    );
                }
            }
        }
    }

    #[test]
    fn printed_contracts_say_the_same(specification in random::specifications(), seeds in prop::collection::vec(any::<u64>(), 8)) {
        let text = contract::write(&specification, "a test");
        let back = reload(&text);
        prop_assert_eq!(verdict(&specification), verdict(&back), "{}", text);
        prop_assert_eq!(specification.timing, back.timing);
        same_formulas(&specification, &back, &seeds, &<[i64]>::to_vec);
    }

    #[test]
    fn lowering_keeps_the_verdict(specification in random::specifications()) {
        let wanted = verdict(&specification);
        let plain = lower::without_invariants(&specification);
        prop_assert_eq!(verdict(&plain), wanted);
        let second = lower::answering_second(&plain);
        prop_assert_eq!(verdict(&second), wanted);
        let states = lower::goals_of_states(&second);
        prop_assert_eq!(verdict(&states), wanted);
        prop_assert_eq!(verdict(&lower::starting_alone(&states)), wanted);
    }
}

/// The cases of `tests/cases/interchange`: what is expected stands in the comment behind the line that causes it.
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
    settings.set_snapshot_path("cases/snapshots");
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

/// Files that take more than two seconds in a release build: only the tests that are left out by default decide them.
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

/// Files that are solved twice more, as what they were written as.
fn is_small(path: &Path, text: &str) -> bool {
    let name = path.to_string_lossy();
    let slow = [
        "ColorSort",
        "SelfParking",
        "synt15",
        "jcss12",
        "amba",
        "genbuf",
    ];
    text.len() < 3_000 && !is_large(path) && !slow.iter().any(|word| name.contains(word))
}

/// The verdict on a benchmark, as several tools have given it: by folder, or for the mixed folders as the files say of
/// themselves.
fn known_verdict(path: &Path) -> bool {
    let folder = path.parent().and_then(Path::file_name).expect("a folder");
    match folder.to_string_lossy().as_ref() {
        "anzu" | "syntech15" | "synt15" => true,
        "syntech15-unrealizable" => false,
        _ => ![
            "unrealizable",
            "unrealizability",
            "errorneous",
            "baby_network",
            // Of Spectra's: `tests/spectra/bench.rs` says why.
            "AirportShuttle_208",
            "VehicleSpec_133",
            "ConvoyCarSpec_297",
        ]
        .iter()
        .any(|word| path.to_string_lossy().contains(word)),
    }
}

/// Decides the benchmarks for which `wanted` holds, as they are and as the contracts they are imported as. `None` without
/// benchmarks; otherwise how many of both verdicts there were, and how many files are not read.
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
        let imported = reload(&contract::write(&specification, "a benchmark"));
        assert_eq!(verdict(&imported), known, "{} imported", path.display());
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
    assert_eq!(refused, 6);
}

/// The rest of them: minutes, even in a release build.
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

/// A contract printed from a file is a contract with the same formulas.
#[test]
fn imported_benchmarks_have_the_same_formulas() {
    let Some(folder) = support::specs() else {
        return;
    };
    let mut count = 0;
    for (format, path) in specifications(&folder) {
        let text = std::fs::read_to_string(&path).expect("a text");
        let Some(specification) = read_text(format, &text).specification else {
            continue;
        };
        let back = reload(&contract::write(&specification, "a benchmark"));
        count += 1;
        same_formulas(
            &specification,
            &back,
            &[1, 2, 3, 5, 8, 13, 21, 34],
            &<[i64]>::to_vec,
        );
    }
    assert!(count > 120, "only {count} files");
}

/// What is written for slugs and gr1c from a file can be read, and says the same.
#[test]
fn benchmarks_are_written_again() {
    let Some(folder) = support::specs() else {
        return;
    };
    let mut count = 0;
    for (format, path) in specifications(&folder) {
        let text = std::fs::read_to_string(&path).expect("a text");
        let Some(specification) = read_text(format, &text).specification else {
            continue;
        };
        for (target, other) in [
            (Target::Slugsin, Format::Slugsin),
            (Target::Spc, Format::Spc),
        ] {
            match write(&specification, target) {
                Ok(written) => {
                    let back = reread(other, &written);
                    if is_small(&path, &text) {
                        assert_eq!(
                            verdict(&specification),
                            verdict(&back),
                            "{}",
                            path.display()
                        );
                    }
                    count += 1;
                }
                Err(findings) => {
                    assert!(
                        findings.iter().all(|f| f.code.id == "LW112"),
                        "{findings:?}"
                    );
                    eprintln!("{}: too large for {other:?}", path.display());
                }
            }
        }
    }
    assert!(count > 200, "only {count} files");
}

/// The random specifications are worth their time: both verdicts are frequent, whatever the timing.
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
