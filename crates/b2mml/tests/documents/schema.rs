//! libxml2 with the schemas of MESA: the table of types, the documents that are written, and those
//! that are read.

use crate::mutated::{mutant, originals};
use crate::support::mesa::Validator;
use crate::support::random::Random;
use crate::support::{self, cell, documents, pad, rename};
use linewright_b2mml::{Rule, read};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Derives the table of types from the schemas.
const TABLE: &str = include_str!("table.py");

fn validator() -> Option<Validator> {
    Validator::find(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
}

#[test]
fn the_table_is_that_of_the_schemas() {
    let Some(validator) = validator() else {
        return;
    };
    let derived = validator.python(TABLE, &[&validator.schemas]);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/schema/types.txt");
    let table = std::fs::read_to_string(path).expect("the table is there");
    let lines: Vec<&str> = table.lines().filter(|l| !l.starts_with('#')).collect();
    assert_eq!(lines, derived.lines().collect::<Vec<_>>());
    assert!(lines.len() > 300);
}

/// Writes documents into a folder and returns the names of those that libxml2 finds valid, with its
/// reasons for the others if they are asked for.
fn valid(documents: &[Vec<u8>], reasons: bool) -> Option<(BTreeSet<String>, String)> {
    let validator = validator()?;
    let folder = tempfile::tempdir().expect("a folder");
    for (number, document) in documents.iter().enumerate() {
        let name = folder.path().join(file(number));
        std::fs::write(name, document).expect("a file can be written");
    }
    Some(validator.valid(folder.path(), reasons))
}

fn file(number: usize) -> String {
    format!("{number:06}.xml")
}

#[test]
fn documents_are_valid() {
    let mut all: Vec<String> = Vec::new();
    for resources in [5, 6, 10] {
        all.extend(documents(
            &pad::layout(resources),
            &pad::hinge(resources > 5),
        ));
    }
    for seed in 0..250 {
        let (mut layout, mut recipe) = cell(seed);
        if seed % 2 == 0 {
            let kind = |name: &str| name.bytes().map(usize::from).sum::<usize>() + seed as usize;
            rename(&mut layout, &mut recipe, &|name| {
                support::odd(name, kind(name))
            });
        }
        all.extend(documents(&layout, &recipe));
    }
    let (recipe, schedule) = crate::round_trips::large();
    all.push(linewright_b2mml::write::definition(&recipe).expect("it is sound"));
    all.push(linewright_b2mml::write::workflow(&recipe).expect("it is sound"));
    all.push(linewright_b2mml::write::schedule(&schedule).expect("it has requests"));
    let run = support::performance(&schedule);
    all.push(linewright_b2mml::write::performance(&run).expect("it has records"));
    assert!(all.len() > 600, "{}", all.len());
    let mut bytes: Vec<Vec<u8>> = all.into_iter().map(String::into_bytes).collect();
    let right = bytes.len();
    // The validator does refuse something.
    bytes.push(b"<OperationsSchedule xmlns=\"http://www.mesa.org/xml/B2MML\"/>".to_vec());
    bytes.push(b"<x/>".to_vec());
    if let Some((found, reasons)) = valid(&bytes, true) {
        let wrong: Vec<usize> = (0..bytes.len())
            .filter(|n| !found.contains(&file(*n)))
            .collect();
        assert_eq!(wrong, [right, right + 1], "{reasons}");
    }
}

/// What is read is valid. What is valid and not read has a reason beyond the schema.
fn agreement(count: u64, offset: u64) {
    let originals = originals();
    let mutants: Vec<Vec<u8>> = (0..count)
        .map(|seed| {
            let mut random = Random((seed + offset).wrapping_mul(0x9e37_79b9));
            mutant(&originals, &mut random)
        })
        .collect();
    let Some((valid, _)) = valid(&mutants, false) else {
        return;
    };
    let (mut both, mut neither) = (0, 0);
    let mut stricter: BTreeMap<&str, usize> = BTreeMap::new();
    for (number, bytes) in mutants.iter().enumerate() {
        let text = String::from_utf8_lossy(bytes);
        match (read(bytes), valid.contains(&file(number))) {
            (Ok(_), true) => both += 1,
            (Ok(_), false) => panic!("it was read, but is not valid:\n{text}"),
            (Err(_), false) => neither += 1,
            (Err(findings), true) => {
                let rule = findings.list[0].rule;
                let message = &findings.list[0].message;
                let is_beyond = matches!(
                    rule,
                    Rule::Meaning | Rule::Reference | Rule::Size | Rule::DocumentType | Rule::Root
                );
                assert!(
                    is_beyond || is_exception(rule, message, &text),
                    "{findings}\n{text}"
                );
                *stricter.entry(rule.name()).or_default() += 1;
            }
        }
    }
    println!("{both} read and valid, {neither} neither; valid and not read: {stricter:?}");
    assert!(both * 20 > count && neither * 4 > count, "{both} {neither}");
}

/// Exceptions, where a valid document is refused: those that `schema/mod.rs` lists.
fn is_exception(rule: Rule, message: &str, text: &str) -> bool {
    match rule {
        // A section or a reference between elements.
        Rule::Structure => {
            message.ends_with("cannot have text")
                && (text.contains("<![CDATA[") || text.contains('&'))
        }
        // lxml goes on after errors of namespaces.
        Rule::Syntax => message.contains("declared without a namespace"),
        _ => false,
    }
}

#[test]
fn the_importer_agrees_with_libxml2() {
    agreement(2_500, 0);
}

#[test]
#[ignore = "long: cargo test --release -p linewright-b2mml agrees_at_length -- --ignored --nocapture"]
fn the_importer_agrees_at_length() {
    for part in 0..10 {
        agreement(10_000, part * 10_000);
    }
}
