//! Whatever is written in another tool's format, or as a contract, is read again and proved to be
//! the same game.
//!
//! If a format cannot express something, [`lower`] first expresses it with helper variables. The
//! proof is then about the lowered specification; a separate test checks that lowering keeps the
//! verdict.

mod equivalence;
mod words;

use crate::support::games::{reload, specifications, verdict};
use crate::{random, support};
use equivalence::{Layout, prove};
use linewright::diagnostics::has_errors;
use linewright::gr1::{Formula, Specification, Timing};
use linewright::interchange::{Format, Target, contract, lower, read, write};
use linewright::source::FileId;
use proptest::prelude::*;
use rayon::prelude::*;
use std::path::PathBuf;

const TARGETS: [Target; 4] = [Target::Spc, Target::Slugsin, Target::Spectra, Target::Tlsf];

/// The format that a target is read as.
fn format(target: Target) -> Format {
    match target {
        Target::Spc => Format::Spc,
        Target::Slugsin => Format::Slugsin,
        Target::Spectra => Format::Spectra,
        Target::Tlsf => Format::Tlsf,
    }
}

/// The specification passed to a format, and its representation of numbers.
fn said(specification: &Specification, target: Target) -> (Specification, Layout) {
    let second = || lower::to_mealy(&lower::without_invariants(specification));
    match target {
        Target::Spc => {
            let lowered = lower::initial_to_transitions(&lower::goals_to_states(&second()));
            (lowered, Layout::FromZero)
        }
        Target::Slugsin => (second(), Layout::Bits),
        Target::Spectra if specification.timing == Timing::Moore => (second(), Layout::Same),
        Target::Spectra => (specification.clone(), Layout::Same),
        Target::Tlsf => (specification.clone(), Layout::Bits),
    }
}

/// Reads a written text, which must have no errors.
fn reread(target: Target, text: &str) -> Specification {
    let reading = read(format(target), "test", FileId(0), text);
    assert!(
        !has_errors(&reading.findings),
        "{text}\n{:#?}",
        reading.findings
    );
    reading.specification.expect("there is no error")
}

/// Writes, reads and proves.
fn there_and_back(specification: &Specification, target: Target) -> Specification {
    let text = write(specification, target).expect("it is small");
    let back = reread(target, &text);
    let (said, layout) = said(specification, target);
    if let Err(what) = prove(&said, &back, layout) {
        panic!("{target:?}: {what}\n{text}");
    }
    back
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn every_format_says_the_same(specification in random::specifications()) {
        let wanted = verdict(&specification);
        for target in TARGETS {
            let back = there_and_back(&specification, target);
            prop_assert_eq!(verdict(&back), wanted, "{:?}", target);
            // What was read can be written again.
            there_and_back(&back, target);
        }
    }

    #[test]
    fn a_printed_contract_says_the_same(specification in random::specifications()) {
        let text = contract::write(&specification, "a test");
        let proved = prove(&specification, &reload(&text), Layout::Same);
        prop_assert!(proved.is_ok(), "{}\n{}", proved.unwrap_err(), text);
    }
}

/// The proof detects every formula that is missing or negated, including one that keeps bits within
/// their domain.
#[test]
fn a_change_is_found() {
    let path = support::root().join("examples/other-tools/arbiter.structuredslugs");
    let text = std::fs::read_to_string(path).expect("a text");
    let reading = read(Format::StructuredSlugs, "arbiter", FileId(0), &text);
    let specification = reading.specification.expect("it can be read");
    let mut changes = 0;
    for target in TARGETS {
        let back = there_and_back(&specification, target);
        let (said, layout) = said(&specification, target);
        for list in 0..6 {
            for place in 0..formulas(&mut back.clone(), list).len() {
                let mut negated = back.clone();
                let formula = &mut formulas(&mut negated, list)[place];
                formula.expr = formula.expr.clone().not();
                let mut missing = back.clone();
                let removed = formulas(&mut missing, list).remove(place);
                for changed in [negated, missing] {
                    let what = format!("{target:?}: {}", removed.name);
                    assert!(prove(&said, &changed, layout).is_err(), "{what}");
                    changes += 1;
                }
            }
        }
    }
    assert!(changes > 60, "only {changes}");
}

fn formulas(specification: &mut Specification, list: usize) -> &mut Vec<Formula> {
    let side = match list % 2 {
        0 => &mut specification.assumptions,
        _ => &mut specification.guarantees,
    };
    match list / 2 {
        0 => &mut side.initial,
        1 => &mut side.safety,
        _ => &mut side.justice,
    }
}

/// Every public specification that can be read.
fn benchmarks() -> Option<Vec<(PathBuf, Specification)>> {
    let mut found = Vec::new();
    for (format, path) in specifications(&support::specs()?) {
        let text = std::fs::read_to_string(&path).expect("a text");
        if let Some(specification) = read(format, "test", FileId(0), &text).specification {
            found.push((path, specification));
        }
    }
    assert!(found.len() > 140, "only {} files", found.len());
    Some(found)
}

/// A contract printed from a public file is the same game: so it has the same verdict and the same
/// strategies.
#[test]
fn public_files_are_the_same_as_contracts() {
    let Some(files) = benchmarks() else { return };
    files.par_iter().for_each(|(path, specification)| {
        let back = reload(&contract::write(specification, "a benchmark"));
        if let Err(what) = prove(specification, &back, Layout::Same) {
            panic!("{}: {what}", path.display());
        }
    });
}

/// A public file is written in each format and read again.
#[test]
fn public_files_are_written_in_every_format() {
    let Some(files) = benchmarks() else { return };
    let written: usize = files
        .par_iter()
        .flat_map(|file| TARGETS.map(|target| (file, target)))
        .filter(
            |((path, specification), target)| match write(specification, *target) {
                Ok(text) => {
                    let back = reread(*target, &text);
                    let (said, layout) = said(specification, *target);
                    if let Err(what) = prove(&said, &back, layout) {
                        panic!("{} as {target:?}: {what}", path.display());
                    }
                    true
                }
                Err(findings) => {
                    let too_large = findings.iter().all(|f| f.code.id == "LW112");
                    assert!(too_large, "{}: {findings:#?}", path.display());
                    eprintln!("{}: too large for {target:?}", path.display());
                    false
                }
            },
        )
        .count();
    assert!(written > 500, "only {written}");
}
