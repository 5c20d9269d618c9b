//! Inputs that the fuzzers have found worth keeping, replayed with their checks for any text; see
//! tests/fuzz. Every case file and some random bytes are included.

use crate::check::Solved;
use crate::{check, program, support, uf_value};
use linewright::interchange::Format;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Every file below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let list = if path.is_dir() { &mut open } else { &mut found };
            list.push(path);
        }
    }
    found.sort();
    found
}

/// Initial inputs of a target: its corpus, and the files of the repository.
fn inputs(target: &str) -> Vec<Vec<u8>> {
    let folders = [
        &format!("tests/fuzz/corpus/{target}"),
        "tests/cases",
        "contracts",
        "examples",
    ];
    let paths = folders.map(|folder| files(&support::root().join(folder)));
    let texts = paths.iter().flatten().filter(|path| {
        let ending = path.extension().and_then(|e| e.to_str());
        matches!(
            ending,
            None | Some("lw" | "spc" | "slugsin" | "structuredslugs" | "spectra" | "tlsf")
        )
    });
    texts
        .map(|path| std::fs::read(path).expect("a file"))
        .collect()
}

/// The inputs that are text.
fn texts(target: &str) -> Vec<String> {
    let inputs = inputs(target).into_iter();
    inputs
        .filter_map(|bytes| String::from_utf8(bytes).ok())
        .collect()
}

#[test]
fn other_tools_formats() {
    for format in Format::ALL {
        let texts = texts(format.ending());
        assert!(texts.len() > 50);
        texts
            .par_iter()
            .for_each(|text| check::reader(format, text));
    }
}

/// Profiles of `UF_Value` and dumps of the probe: the corpus, the example, and every other text of
/// the repository, which is neither.
#[test]
fn layouts() {
    let example = support::root().join("examples/plant-simulation/mock.dump.txt");
    let example = std::fs::read_to_string(example).expect("a text");
    let both = [texts("profile"), vec![example]].concat();
    let profiles = both.iter().filter(|text| uf_value::profile(text)).count();
    let dumps = both.iter().filter(|text| uf_value::dump(text).0).count();
    assert!(profiles > 0 && dumps > 0, "{profiles} {dumps}");
}

/// Programs of calls: the corpus, and every other text of the repository, which is none.
#[test]
fn programs() {
    let texts = texts("program");
    let calls: usize = texts.iter().map(|text| program::program(text)).sum();
    assert!(calls > 5, "{calls}");
}

#[test]
fn the_language() {
    let texts = texts("lw");
    assert!(texts.len() > 50);
    texts.par_iter().for_each(|text| check::language(text));
}

#[test]
fn contracts() {
    let inputs = inputs("contract");
    assert!(inputs.len() > 50);
    let solved: Vec<Solved> = inputs
        .par_iter()
        .flat_map(|i| check::contract_of(i))
        .collect();
    println!("{} contracts", solved.len());
    assert!(solved.len() > 30);
}

/// The generator makes usable contracts of both verdicts.
#[test]
fn contracts_of_random_bytes() {
    const COUNT: u64 = 3_000;
    let solved: Vec<Solved> = (0..COUNT)
        .into_par_iter()
        .flat_map(|seed| {
            // Xorshift with a seed far from zero.
            let mut state = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let mut byte = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 24) as u8
            };
            let bytes: Vec<u8> = (0..50 + seed % 350).map(|_| byte()).collect();
            check::contract_of(&bytes)
        })
        .collect();
    let count = |wanted: Solved| solved.iter().filter(|s| **s == wanted).count() as u64;
    let (realizable, unrealizable) = (count(Solved::Realizable), count(Solved::Unrealizable));
    println!("{COUNT} byte strings: {realizable} realizable, {unrealizable} not");
    assert_eq!(count(Solved::GaveUp), 0);
    assert!(realizable * 5 > COUNT && unrealizable * 5 > COUNT);
}
