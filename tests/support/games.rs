//! Public specifications, verdicts, and contracts from printed text.

use linewright::contract::load;
use linewright::diagnostics::has_errors;
use linewright::game::{Limits, Options, Outcome, solve_with};
use linewright::gr1::Specification;
use linewright::interchange::Format;
use std::path::{Path, PathBuf};

/// Every file below a folder in another tool's format, sorted.
pub fn specifications(folder: &Path) -> Vec<(Format, PathBuf)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else if let Some(format) = Format::from_path(&path.to_string_lossy()) {
                found.push((format, path));
            }
        }
    }
    found.sort_by(|a, b| a.1.cmp(&b.1));
    found
}

/// Whether some controller keeps the guarantees; without a time limit, in a gibibyte.
pub fn verdict(specification: &Specification) -> bool {
    let options = Options {
        limits: Limits {
            deadline: linewright::deadline::Deadline::NONE,
            memory_mib: Some(1024),
            ..Limits::default()
        },
        without_core: true,
        ..Options::default()
    };
    match solve_with(specification, &options).outcome {
        Outcome::Realizable(_) => true,
        Outcome::Unrealizable(_) => false,
        Outcome::GaveUp(limit) => panic!("gave up: {limit}"),
    }
}

/// The contract that a printed text declares.
pub fn reload(text: &str) -> Specification {
    let files = [("test.lw".to_owned(), text.to_owned())];
    let (library, findings) = load(&files, &|_, _| Err("no imports".to_owned()));
    assert!(!has_errors(&findings), "{text}\n{findings:#?}");
    let [contract] = library.contracts.as_slice() else {
        panic!("one contract in {text}");
    };
    (*contract.specification).clone()
}
