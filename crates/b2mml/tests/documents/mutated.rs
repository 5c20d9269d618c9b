//! Mutated documents: no panic, and each is read correctly or has findings with places.

use crate::support::random::Random;
use crate::support::{cell, documents, pad, written};
use linewright_b2mml::{Document, Findings, Rule, WriteError, read};
use std::fmt::Write as _;

/// Pieces that break documents in ways of their own.
const PIECES: [&str; 32] = [
    "<",
    ">",
    "&",
    "\"",
    "'",
    "/",
    "=",
    ";",
    " ",
    "\n",
    "\r",
    "\t",
    "\0",
    "\u{feff}",
    "\u{ffff}",
    "ü",
    "&lt;",
    "&#0;",
    "&x;",
    "]]>",
    "<![CDATA[ ]]>",
    "<!-- -- -->",
    "<!-->",
    "<!--x-->",
    "<?xml version=\"1.0\"?>",
    "<?p?>",
    "<!DOCTYPE a [<!ENTITY x \"y\">]>",
    " xmlns=\"\"",
    " xmlns:p=\"q\"",
    " xsi:nil=\"true\"",
    " OtherValue=\"x\"",
    "<ID>1</ID>",
];

/// Small documents of each kind.
pub fn originals() -> Vec<String> {
    let mut originals = Vec::new();
    for seed in [3, 17, 40] {
        let (layout, recipe) = cell(seed);
        originals.extend(documents(&layout, &recipe));
    }
    let mut hinge = pad::hinge(true);
    hinge.transitions[0].steps.truncate(3);
    let mut schedule = documents(&pad::layout(6), &hinge);
    // The first and the last requests are enough.
    for text in schedule.drain(3..).collect::<Vec<_>>() {
        let element = if text.contains("<OperationsRequest>") {
            "</OperationsRequest>"
        } else {
            "</OperationsResponse>"
        };
        let pieces: Vec<&str> = text.split_inclusive(element).collect();
        let count = pieces.len();
        let few: Vec<&str> = pieces[..5]
            .iter()
            .chain(&pieces[count - 2..])
            .copied()
            .collect();
        originals.push(few.concat());
    }
    originals.extend(schedule);
    originals
}

/// Returns a document with one to three changes: of bytes, or of elements, which keep a document
/// well-formed.
pub fn mutant(originals: &[String], random: &mut Random) -> Vec<u8> {
    let original = &originals[random.below(originals.len())];
    if random.percent(35) {
        let mut bytes = original.clone().into_bytes();
        for _ in 0..=random.below(3) {
            change_bytes(&mut bytes, random);
        }
        return bytes;
    }
    let mut lines: Vec<String> = original.lines().map(str::to_owned).collect();
    for _ in 0..=random.below(2) {
        change_elements(&mut lines, random);
    }
    lines.join("\n").into_bytes()
}

fn change_bytes(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(20)).min(bytes.len());
    match random.below(5) {
        0 => drop(bytes.drain(at..end)),
        1 => {
            let copy = bytes[at..end].to_vec();
            bytes.splice(at..at, copy);
        }
        2 => bytes[at] = b"<>&\"'/=;:!-[]?aZ09 \xff\x00"[random.below(21)],
        3 => {
            let piece = PIECES[random.below(PIECES.len())];
            bytes.splice(at..at, piece.bytes());
        }
        _ => bytes.truncate(at),
    }
}

/// Returns the last line of the element that begins in a line.
fn end_of(lines: &[String], begin: usize) -> usize {
    let line = &lines[begin];
    let indentation = line.len() - line.trim_start().len();
    let end = format!("{}</", &line[..indentation]);
    if line.contains("</") || line.ends_with("/>") {
        return begin;
    }
    let after = lines[begin..].iter().position(|l| l.starts_with(&end));
    after.map_or(begin, |after| begin + after)
}

/// Changes a document of which each line is a tag or an element with text.
fn change_elements(lines: &mut Vec<String>, random: &mut Random) {
    /// Texts that are values of some types and not of others.
    const TEXTS: [&str; 14] = [
        "",
        "1",
        "0",
        "-1",
        "true",
        "s0",
        "PT1S",
        "Other",
        "Consumed",
        "2026-11-30T12:00:00Z",
        "AfterEnd",
        "1e999",
        "  a\tb ",
        "T1.S1.O1",
    ];
    let begins: Vec<usize> = (2..lines.len())
        .filter(|n| !lines[*n].trim_start().starts_with("</"))
        .collect();
    if begins.is_empty() {
        return;
    }
    let begin = begins[random.below(begins.len())];
    let end = end_of(lines, begin);
    let leaves: Vec<usize> = (begins.iter().copied())
        .filter(|n| lines[*n].contains("</") && lines[*n].contains('>'))
        .collect();
    match random.below(9) {
        0 => drop(lines.drain(begin..=end)),
        1 => {
            let copy = lines[begin..=end].to_vec();
            lines.splice(begin..begin, copy);
        }
        // To the next place, or to any.
        2 | 3 => {
            let block: Vec<String> = lines.drain(begin..=end).collect();
            let to = if random.percent(60) {
                begin + 1
            } else {
                2 + random.below(lines.len())
            };
            let to = to.min(lines.len() - 1);
            lines.splice(to..to, block);
        }
        4 if !leaves.is_empty() => {
            let leaf = leaves[random.below(leaves.len())];
            let (one, other) = (parts(&lines[leaf]), parts(&lines[begin]));
            let name = other
                .0
                .split([' ', '/'])
                .next()
                .unwrap_or_default()
                .to_owned();
            lines[leaf] = format!("<{name}>{}</{name}>", one.1);
        }
        _ if !leaves.is_empty() => {
            let leaf = leaves[random.below(leaves.len())];
            let (name, _) = parts(&lines[leaf]);
            let text = if random.percent(50) {
                parts(&lines[leaves[random.below(leaves.len())]])
                    .1
                    .to_owned()
            } else {
                TEXTS[random.below(TEXTS.len())].to_owned()
            };
            let end = name.split(' ').next().unwrap_or_default();
            lines[leaf] = format!("<{name}>{text}</{end}>");
        }
        _ => {}
    }
}

/// Returns the tag of a line without its brackets, and the text behind it.
fn parts(line: &str) -> (&str, &str) {
    let (tag, rest) = line.trim().split_once('>').unwrap_or_default();
    let text = rest.split("</").next().unwrap_or_default();
    (tag.trim_start_matches('<'), text)
}

/// Checks the reading of a mutant. Returns whether it was read.
fn check(bytes: &[u8]) -> Result<(), Findings> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    match read(bytes) {
        Ok(reading) => {
            assert!(reading.notes.list.iter().all(|n| n.rule == Rule::LeftOut));
            match written(&reading.document) {
                Ok(again) => {
                    let again = read(again.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
                    let first = first_only(reading.document);
                    assert_eq!(again.document, first, "{text}");
                }
                // Seconds after the start may lead beyond the year 9999.
                Err(error) => assert!(matches!(error, WriteError::Time(_)), "{error}\n{text}"),
            }
            Ok(())
        }
        Err(findings) => {
            assert!(!findings.list.is_empty(), "{text}");
            let lines: Vec<&str> = text.split('\n').collect();
            for finding in &findings.list {
                assert!(!finding.message.is_empty());
                let line = finding.line.checked_sub(1).and_then(|l| lines.get(l));
                let width = line.map(|l| l.chars().count() + 1);
                let is_there = width.is_some_and(|w| (1..=w).contains(&finding.column));
                assert!(is_there, "{finding}\n{text}");
            }
            Err(findings)
        }
    }
}

/// Keeps the first of several layouts or recipes, and what a schedule can write of its durations.
fn first_only(mut document: Document) -> Document {
    match &mut document {
        Document::Layouts(layouts) => layouts.truncate(1),
        Document::Recipes(recipes) => recipes.truncate(1),
        Document::Schedule(schedule) => {
            for request in &mut schedule.requests {
                request.seconds = request.seconds.filter(|s| *s < 1e9);
            }
        }
        Document::Performance(_) => {}
    }
    document
}

/// Checks mutants with consecutive numbers.
fn mutants(count: u64) {
    let originals = originals();
    assert!(originals.len() > 12, "{}", originals.len());
    for original in &originals {
        check(original.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{original}"));
    }
    let (mut read, mut rules) = (0_u64, std::collections::BTreeMap::new());
    for seed in 0..count {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9));
        match check(&mutant(&originals, &mut random)) {
            Ok(()) => read += 1,
            Err(findings) => *rules.entry(findings.list[0].rule.name()).or_insert(0) += 1,
        }
    }
    println!("{read} of {count} mutants were read; the others: {rules:?}");
    assert!(read * 20 > count && read * 2 < count, "{read}");
    assert!(rules.len() > 6, "{rules:?}");
}

#[test]
fn ten_thousand_mutants() {
    mutants(10_000);
}

#[test]
#[ignore = "long: cargo test --release -p linewright-b2mml a_million -- --ignored --nocapture"]
fn a_million_mutants() {
    mutants(1_000_000);
}

/// Bytes that have nothing to do with XML.
#[test]
fn random_bytes() {
    for seed in 0..2_000 {
        let mut random = Random(seed);
        let length = random.below(200);
        let alphabet = b"<>/!?-[]&;= \"'ab:xml\xc3\xa4\n";
        let bytes: Vec<u8> = (0..length)
            .map(|_| alphabet[random.below(alphabet.len())])
            .collect();
        assert!(check(&bytes).is_err());
    }
    let mut nested = String::new();
    for depth in 0..99 {
        let _ = write!(nested, "<a{depth}>");
    }
    assert!(check(nested.as_bytes()).is_err());
}
