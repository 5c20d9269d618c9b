//! What is written in Spectra's language and read again, and what a file becomes as a contract.

use super::bench::{files, read_file, verdict};
use super::random;
use linewright::contract::load;
use linewright::diagnostics::has_errors;
use linewright::gr1::eval::holds;
use linewright::gr1::{Formula, Side, Specification, Timing};
use linewright::interchange::{Format, Target, contract, lower, read, write};
use linewright::source::FileId;
use proptest::prelude::*;
use rayon::prelude::*;

fn reread(text: &str) -> Specification {
    let reading = read(Format::Spectra, "test", FileId(0), text);
    let findings = reading.findings;
    reading
        .specification
        .unwrap_or_else(|| panic!("{text}\n{findings:#?}"))
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

fn lists(side: &Side) -> [&[Formula]; 4] {
    [&side.initial, &side.invariants, &side.safety, &side.justice]
}

/// That all lists have the same values on random pairs of steps: so they have on all lassos through them.
fn same(a: &Specification, b: &Specification, seeds: &[u64], text: &str) {
    let domains = |s: &Specification| -> Vec<(i64, i64)> {
        let domains = s.variables.iter();
        domains.map(|v| (v.domain.low(), v.domain.high())).collect()
    };
    assert_eq!(domains(a), domains(b), "{text}");
    let draw = |seed: u64| -> Vec<i64> {
        let mut state = seed;
        let values = a.variables.iter().map(|v| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            v.domain.low() + ((state >> 33) % v.domain.size()) as i64
        });
        values.collect()
    };
    for (x, y) in [
        (&a.assumptions, &b.assumptions),
        (&a.guarantees, &b.guarantees),
    ] {
        for (f, g) in lists(x).into_iter().zip(lists(y)) {
            assert_eq!(f.len(), g.len(), "{text}");
            for (f, g) in f.iter().zip(g) {
                for seed in seeds {
                    let (now, next) = (draw(*seed), draw(seed.rotate_left(17) ^ 0x5bd1));
                    assert_eq!(
                        holds(&f.expr, &now, &next),
                        holds(&g.expr, &now, &next),
                        "{text}\n{} at {now:?}, {next:?}",
                        f.name
                    );
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn spectra_says_the_same(specification in random::specifications(), seeds in prop::collection::vec(any::<u64>(), 12)) {
        let text = write(&specification, Target::Spectra).expect("it is small");
        let back = reread(&text);
        prop_assert_eq!(verdict(&specification), verdict(&back), "{}", text);
        let lowered = match specification.timing {
            Timing::Mealy => specification,
            Timing::Moore => lower::answering_second(&lower::without_invariants(&specification)),
        };
        same(&lowered, &back, &seeds, &text);
    }
}

#[test]
fn benchmark_files_are_written_and_read_again() {
    let seeds: Vec<u64> = (1..200_u64)
        .map(|n| n.wrapping_mul(0x1234_5678_9abc_def1))
        .collect();
    let count = files()
        .par_iter()
        .filter(|path| {
            let (reading, text) = read_file(path);
            let Some(specification) = reading.specification.filter(|_| text.len() < 20_000) else {
                return false;
            };
            let written = write(&specification, Target::Spectra).expect("it can be written");
            same(&specification, &reread(&written), &seeds, &written);
            true
        })
        .count();
    assert!(count > 50 || files().is_empty(), "{count} files");
}

#[test]
fn small_files_are_the_same_as_contracts() {
    let count = files()
        .par_iter()
        .filter(|path| {
            let (reading, text) = read_file(path);
            let Some(specification) = reading.specification.filter(|_| text.len() < 5_000) else {
                return false;
            };
            let printed = contract::write(&specification, "a test");
            let back = reload(&printed);
            assert_eq!(
                verdict(&specification),
                verdict(&back),
                "{}",
                path.display()
            );
            true
        })
        .count();
    assert!(count > 15 || files().is_empty(), "{count} files");
}
