//! Files with errors. Expectations are beside the code that causes them: `//~ LW103` says that a
//! finding with this code begins on this line (several codes for several findings, `//~^ LW103` for
//! the line above). A test requires exactly these, and that every finding has a help text; one
//! snapshot per file shows the messages as text.
//!
//! Folders named `shared` contain what the cases import.

use linewright::contract::{Library, load};
use linewright::diagnostics::{Diagnostic, codes, render};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Codes raised by the parser and the resolver, each of which needs a case.
const RAISED: &[&str] = &[
    "LW002", "LW003", "LW004", "LW101", "LW102", "LW103", "LW104", "LW105", "LW106", "LW107",
    "LW108", "LW109", "LW110", "LW111", "LW112", "LW113", "LW114", "LW115", "LW201", "LW202",
    "LW207", "LW210", "LW211", "LW301", "LW302", "LW306", "LW307", "LW308", "LW401", "LW402",
    "LW417", "LW601", "LW602", "LW603", "LW604", "LW605", "LW606",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases")
}

fn cases() -> Vec<String> {
    let mut names = Vec::new();
    for group in ["syntax", "resolve", "machine", "line", "recipe"] {
        for entry in std::fs::read_dir(folder().join(group)).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|e| e == "lw") {
                let name = path.file_name().expect("a name").to_string_lossy();
                names.push(format!("{group}/{name}"));
            }
        }
    }
    names.sort();
    names
}

/// Reads an import: the bundled library, or a path relative to the importing file.
fn read_import(wanted: &str, from: &str) -> Result<(String, String), String> {
    if let Some(inner) = wanted.strip_prefix("std.") {
        let inner = format!("{}.lw", inner.replace('.', "/"));
        let path = folder().join("../../contracts").join(&inner);
        let text = std::fs::read_to_string(path).map_err(|_| "there is none".to_owned())?;
        return Ok((format!("std/{inner}"), text));
    }
    let mut name = PathBuf::from(from);
    name.pop();
    for part in Path::new(wanted).components() {
        if part.as_os_str() == ".." {
            name.pop();
        } else {
            name.push(part);
        }
    }
    let name = name.to_string_lossy().into_owned();
    let path = match name.strip_prefix("std/") {
        Some(inner) => folder().join("../../contracts").join(inner),
        None => folder().join(&name),
    };
    let text = std::fs::read_to_string(path).map_err(|_| "there is no such file".to_owned())?;
    Ok((name, text))
}

fn check(name: &str) -> (Library, Vec<Diagnostic>) {
    let text = std::fs::read_to_string(folder().join(name)).expect("a case");
    load(&[(name.to_owned(), text)], &read_import)
}

/// File, line and code of each expected finding, sorted.
fn expected(library: &Library) -> Vec<(String, usize, String)> {
    let mut expected = Vec::new();
    for (_, file) in library.sources.files() {
        for (index, line) in file.text.lines().enumerate() {
            let Some((_, codes)) = line.split_once("//~") else {
                continue;
            };
            let above = codes.chars().take_while(|c| *c == '^').count();
            for code in codes.trim_start_matches('^').split_whitespace() {
                expected.push((file.name.clone(), index + 1 - above, code.to_owned()));
            }
        }
    }
    expected.sort();
    expected
}

fn found(library: &Library, findings: &[Diagnostic]) -> Vec<(String, usize, String)> {
    let mut found: Vec<_> = findings
        .iter()
        .map(|f| {
            let span = f.span.expect("a finding of a file has a place");
            (
                library.sources.file(span.file).name.clone(),
                library.sources.start(span).line,
                f.code.id.to_owned(),
            )
        })
        .collect();
    found.sort();
    found
}

#[test]
fn findings_stand_where_they_are_expected() {
    let mut report = String::new();
    for name in cases() {
        let (library, findings) = check(&name);
        let (expected, found) = (expected(&library), found(&library, &findings));
        if expected != found {
            let human = plain(&library, &findings);
            let _ = writeln!(
                report,
                "{name}:\n  missing {:?}\n  extra {:?}\n{human}",
                without(&expected, &found),
                without(&found, &expected)
            );
        }
    }
    assert!(report.is_empty(), "{report}");
}

/// What occurs in `a`, but not or less often in `b`.
fn without<T: PartialEq + Clone>(a: &[T], b: &[T]) -> Vec<T> {
    let mut rest = b.to_vec();
    a.iter()
        .filter(|x| match rest.iter().position(|y| y == *x) {
            Some(at) => {
                rest.remove(at);
                false
            }
            None => true,
        })
        .cloned()
        .collect()
}

#[test]
fn every_finding_names_a_next_step() {
    for name in cases() {
        let (library, findings) = check(&name);
        for finding in findings {
            assert!(
                finding.help.is_some(),
                "{name}: no next step: {}",
                plain(&library, &[finding])
            );
        }
    }
}

#[test]
fn every_code_of_the_resolver_is_shown() {
    let mut shown = BTreeSet::new();
    for name in cases() {
        shown.extend(check(&name).1.into_iter().map(|f| f.code.id));
    }
    let wanted: BTreeSet<_> = RAISED.iter().copied().collect();
    assert_eq!(shown, wanted);
    assert!(wanted.iter().all(|id| codes::find(id).is_some()));
}

fn plain(library: &Library, findings: &[Diagnostic]) -> String {
    anstream::adapter::strip_str(&render::human(&library.sources, findings)).to_string()
}

#[test]
fn messages_as_a_person_reads_them() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../cases/snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for name in cases() {
            let (library, findings) = check(&name);
            let mut text = String::new();
            for (_, file) in library
                .sources
                .files()
                .filter(|(_, f)| !f.name.starts_with("std/"))
            {
                let _ = writeln!(text, "--- {}\n{}", file.name, file.text);
            }
            let _ = write!(text, "--- findings\n{}", plain(&library, &findings));
            let snapshot = name.trim_end_matches(".lw").replace('/', "__");
            insta::assert_snapshot!(snapshot, text);
        }
    });
}
