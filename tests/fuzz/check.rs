//! Properties that hold for every text. Shared by the fuzz targets and the ordinary tests.

#[path = "solve.rs"]
mod solve;

#[path = "generate.rs"]
mod generate;

pub use solve::Solved;

use linewright::automata::eliminate;
use linewright::contract::{Library, load};
use linewright::deadline::Deadline;
use linewright::diagnostics::{Diagnostic, codes, has_errors};
use linewright::interchange::{Format, Target, contract, read, write};
use linewright::order::fsm::Fsm;
use linewright::order::supervisor::Options;
use linewright::order::{self, Skills};
use linewright::source::FileId;
use std::sync::Arc;

/// Maximum length of texts whose specifications are written: the writer may take arbitrarily long,
/// the reader may not.
const SHORT: usize = 400;

/// Maximum size of sets of skills that are examined.
const MAX_SKILLS: usize = 6;
const MOST_RULES: usize = 4;
const MOST_STATES: usize = 30;

/// Reads a text: every finding lies within it, there is a specification exactly if no finding is an
/// error, and whatever is written from it can be read.
pub fn reader(format: Format, text: &str) {
    let reading = read(format, "fuzz", FileId(0), text);
    assert_eq!(
        reading.specification.is_none(),
        has_errors(&reading.findings)
    );
    within(&reading.findings, text);
    let Some(specification) = reading.specification.filter(|_| text.len() <= SHORT) else {
        return;
    };
    for (target, format) in [
        (Target::Slugsin, Format::Slugsin),
        (Target::Spc, Format::Spc),
        (Target::Spectra, Format::Spectra),
        (Target::Tlsf, Format::Tlsf),
    ] {
        if let Ok(written) = write(&specification, target) {
            let again = read(format, "fuzz", FileId(0), &written);
            assert_sound(&again.findings, &written);
        }
    }
    let printed = contract::write(&specification, "a fuzzed text");
    let (_, findings) = alone(&printed);
    assert_sound(&findings, &printed);
}

/// Parses and resolves a text of Linewright's language.
pub fn language(text: &str) {
    let (library, findings) = alone(text);
    within(&findings, text);
    let small = |skills: &&Arc<Skills>| {
        skills.skills.len() <= MAX_SKILLS && skills.rules.len() <= MOST_RULES
    };
    for skills in library.skills.iter().filter(small) {
        within(&order::findings::examine(skills, Deadline::NONE), text);
        // An assertion in the code that makes the expression checks that it has the words of the
        // automaton.
        if let Ok(fsm) = Fsm::of_language(skills, Options::default(), 1)
            && fsm.states.len() <= MOST_STATES
        {
            let _ = eliminate::regex(&fsm.one_by_one(), Deadline::NONE);
        }
    }
}

/// Loads, checks and synthesizes small contracts: those in the text that the bytes are, or else one
/// generated from them. Returns the outcome of each.
pub fn contract_of(bytes: &[u8]) -> Vec<Solved> {
    let own = std::str::from_utf8(bytes).ok();
    if let Some(text) = own.filter(|text| text.contains("contract")) {
        let (library, findings) = alone(text);
        within(&findings, text);
        if let Some(solved) = solved(&library, text) {
            return solved;
        }
    }
    let text = generate::contract(bytes);
    let (library, findings) = alone(&text);
    let _shown = Shown(&text);
    within(&findings, &text);
    let syntax = findings.iter().find(|f| f.code == codes::SYNTAX);
    assert_eq!(syntax, None, "the generator does not know the grammar");
    assert_eq!(library.contracts.is_empty(), has_errors(&findings));
    solved(&library, &text).unwrap_or_default()
}

/// `None`: there is none, or a large one.
fn solved(library: &Library, text: &str) -> Option<Vec<Solved>> {
    let specifications = library.contracts.iter().map(|c| &c.specification);
    if library.contracts.is_empty() || !specifications.clone().all(|s| solve::is_small(s)) {
        return None;
    }
    let _shown = Shown(text);
    Some(specifications.map(|s| solve::solve(s)).collect())
}

/// A text that is printed if the test fails while examining it.
struct Shown<'t>(&'t str);

impl Drop for Shown<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}", self.0);
        }
    }
}

fn alone(text: &str) -> (Library, Vec<Diagnostic>) {
    let files = [("fuzz.lw".to_owned(), text.to_owned())];
    load(&files, &|_, _| Err(String::new()))
}

fn within(findings: &[Diagnostic], text: &str) {
    for finding in findings {
        let spans = finding
            .span
            .into_iter()
            .chain(finding.labels.iter().map(|l| l.0));
        for span in spans {
            assert!(
                text.get(span.start as usize..span.end as usize).is_some(),
                "{finding:?}"
            );
        }
        assert!(finding.help.is_some(), "{finding:?}");
    }
}

/// Only a size limit is an excuse.
fn assert_sound(findings: &[Diagnostic], text: &str) {
    let excuses = [codes::TOO_LARGE, codes::NUMBER_RANGE];
    let mut errors = findings
        .iter()
        .filter(|f| has_errors(std::slice::from_ref(*f)));
    assert!(
        errors.all(|f| excuses.contains(&f.code)),
        "{text}\n{findings:#?}"
    );
}
