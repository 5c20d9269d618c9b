//! TLSF: what the reader accepts and rejects, with places, and what the formulas become.

mod explained;
mod game;
mod imported;
mod lassos;
mod messages;

use crate::support;
use crate::support::games::{reload, verdict};
use linewright::diagnostics::render;
use linewright::gr1::Specification;
use linewright::interchange::{Format, Reading, contract, read};
use linewright::source::{FileId, SourceMap};
use std::path::PathBuf;

/// The public files, if they are in a folder beside the repository.
fn bench() -> Option<PathBuf> {
    Some(support::specs()?.join("tlsf"))
}

fn read_text(text: &str) -> Reading {
    read(Format::Tlsf, "test", FileId(0), text)
}

/// The findings as text.
fn shown(reading: &Reading, text: &str) -> String {
    let mut sources = SourceMap::new();
    sources.add("test.tlsf", text);
    anstream::adapter::strip_str(&render::human(&sources, &reading.findings)).to_string()
}

fn sound(text: &str) -> Specification {
    let reading = read_text(text);
    let findings = shown(&reading, text);
    reading
        .specification
        .unwrap_or_else(|| panic!("{text}\n{findings}"))
}

/// A file with a few signals and sections.
fn file(semantics: &str, target: &str, main: &str) -> String {
    format!(
        "INFO {{\n  TITLE: \"t\"\n  DESCRIPTION: \"d\"\n  SEMANTICS: {semantics}\n  TARGET: {target}\n}}\nMAIN {{\n{main}\n}}\n"
    )
}

/// The public files and their known verdicts, from the files themselves: the `STATUS` line at the
/// end of the decomposed ones; title and comment of `amba_case_study_unreal`, from which "removing
/// this assumption makes the specification unrealizable" is the only difference to
/// `amba_case_study`; the notes in the lift, which is "also realisable" without its assumptions.
/// `generalized_buffer` is a conjunction of Streett conditions, which GR(1) cannot express.
const KNOWN: [(&str, Option<bool>); 6] = [
    ("amba_case_study", Some(true)),
    ("amba_case_study_unreal", Some(false)),
    ("amba_decomposed_decode", Some(true)),
    ("amba_decomposed_shift", Some(true)),
    ("generalized_buffer", None),
    ("lift_gr1", Some(true)),
];

#[test]
fn public_files_have_their_known_verdicts() {
    let Some(folder) = bench() else { return };
    for (name, known) in KNOWN {
        let text = std::fs::read_to_string(folder.join(format!("{name}.tlsf"))).expect("a file");
        let start = std::time::Instant::now();
        let reading = read_text(&text);
        let spent = start.elapsed();
        assert!(spent.as_secs_f64() < 2.0, "{name}: {spent:?}");
        let Some(realizable) = known else {
            assert!(reading.findings.iter().all(|f| f.code.id == "LW201"));
            // The condition of the second part, in its definition: `G (req[i] -> X F ack[i])`.
            let span = reading.findings[0].span.expect("a place");
            let at = &text[span.start as usize..span.end as usize];
            assert_eq!(at, "G (req[i] -> X F ack[i])", "{}", shown(&reading, &text));
            continue;
        };
        let specification = sound(&text);
        let read = start.elapsed();
        assert_eq!(verdict(&specification), realizable, "{name}");
        println!("{name}: read {read:?}, decided {:?}", start.elapsed());
        // The output of `import` means the same.
        let printed = reload(&contract::write(&specification, name));
        assert_eq!(verdict(&printed), realizable, "{name}, imported");
    }
}
