//! Controllers as functions: certified independently, equivalent to machines and to the C made from
//! them.

mod certified;
mod compiled;
mod explicit;
mod preferences;

use crate::{fixtures, library, random, support};
use linewright::game::{KernelChoice, Limits, Options, Outcome, solve_with};
use linewright::gr1::Specification;
use linewright::interchange::{Format, read};
use linewright::mealy::functions::Functions;
use linewright::source::FileId;

/// The functions of a specification, if it is realizable.
fn functions(specification: &Specification, kernel: KernelChoice) -> Option<Functions> {
    let options = Options {
        kernel,
        without_core: true,
        ..Options::default()
    };
    match solve_with(specification, &options).outcome {
        Outcome::Realizable(won) => {
            let limits = Limits::default();
            Some(Functions::extract(specification, &won, &limits).expect("no limit"))
        }
        Outcome::Unrealizable(_) => None,
        Outcome::GaveUp(limit) => panic!("{}: {limit}", specification.name),
    }
}

/// A benchmark specification, if it is available.
fn benchmark(name: &str) -> Option<Specification> {
    let folder = std::env::var_os("LINEWRIGHT_SPECS").map_or_else(
        || support::root().join("../shared/bench/specs"),
        std::path::PathBuf::from,
    );
    let path = folder.join("anzu").join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        support::skip("specs", &format!("there is no {name}"));
        return None;
    };
    let stem = name.split('.').next().unwrap_or(name);
    let reading = read(Format::Slugsin, stem, FileId(0), &text);
    Some(reading.specification.expect("a benchmark can be read"))
}
