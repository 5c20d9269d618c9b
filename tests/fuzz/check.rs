//! What holds for every text, whoever wrote it. The fuzz targets and the ordinary tests share this file.

use linewright::contract::{self as contracts, load};
use linewright::diagnostics::{Diagnostic, codes, has_errors};
use linewright::interchange::{Format, Target, contract, read, write};
use linewright::source::FileId;

/// Specifications of longer texts are not written: that may take as long as it likes, the reader may not.
const SHORT: usize = 400;

/// Reads a text: every finding lies within it, there is a specification exactly if no finding is an error, and what is written
/// from it can be read.
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
    ] {
        if let Ok(written) = write(&specification, target) {
            let again = read(format, "fuzz", FileId(0), &written);
            assert_sound(&again.findings, &written);
        }
    }
    let printed = contract::write(&specification, "a fuzzed text");
    let files = [("fuzz.lw".to_owned(), printed.clone())];
    let (_, findings) = load(&files, &|_, _| Err(String::new()));
    assert_sound(&findings, &printed);
}

/// Parses and resolves a text of the language itself.
pub fn language(text: &str) {
    let files = [("fuzz.lw".to_owned(), text.to_owned())];
    let (_, findings) = contracts::load(&files, &|_, _| Err(String::new()));
    within(&findings, text);
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

/// Only that something became too large is an excuse.
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
