//! The examples of the explanation pages: `check` finds in each the code that its page explains, and nothing else. In one
//! that is marked `later` it finds nothing yet.

mod support;

use linewright::diagnostics::{codes, explanations};
use serde_json::Value;
use std::fmt::Write as _;

/// The findings of a document of `check`, wherever they stand in it.
fn findings(document: &Value, found: &mut Vec<(String, String, String)>) {
    match document {
        Value::Array(values) => values.iter().for_each(|v| findings(v, found)),
        Value::Object(fields) => {
            let text = |name: &str| fields.get(name).and_then(Value::as_str).map(str::to_owned);
            if let (Some(code), Some(severity), Some(message)) =
                (text("code"), text("severity"), text("message"))
            {
                found.push((code, severity, message));
            }
            fields.values().for_each(|v| findings(v, found));
        }
        _ => {}
    }
}

/// The findings in a file of this ending and text.
fn check(ending: &str, text: &str) -> Vec<(String, String, String)> {
    let folder = tempfile::tempdir().expect("a folder");
    let name = format!("example.{ending}");
    std::fs::write(folder.path().join(&name), text).expect("a file");
    let output = support::linewright(folder.path(), &["check", &name, "--format", "json"]);
    let document: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
    let mut found = Vec::new();
    findings(&document, &mut found);
    found
}

#[test]
fn examples_show_what_their_pages_explain() {
    let (mut report, mut count) = (String::new(), 0);
    for code in codes::ALL {
        let page = explanations::page(*code).unwrap_or_default();
        for example in explanations::examples(page) {
            count += 1;
            let found = check(&example.ending, &example.text);
            let shown = found.iter().any(|f| f.0 == example.code);
            let other = found.iter().any(|f| f.0 != example.code);
            if shown == example.later || other {
                let _ = writeln!(report, "{code}: the example gives {found:#?}");
            }
        }
    }
    assert!(count > 20, "only {count} examples");
    assert!(report.is_empty(), "{report}");
}

/// A plain ```` ```lw ```` block on a page is the repaired contract.
#[test]
fn repaired_contracts_have_no_findings() {
    let (mut report, mut count) = (String::new(), 0);
    for code in codes::ALL {
        let page = explanations::page(*code).unwrap_or_default();
        let mut lines = page.lines();
        while let Some(line) = lines.next() {
            if line != "```lw" {
                continue;
            }
            let block: String = lines
                .by_ref()
                .take_while(|l| *l != "```")
                .flat_map(|l| [l, "\n"])
                .collect();
            count += 1;
            let found = check("lw", &block);
            if !found.is_empty() {
                let _ = writeln!(report, "{code}: the repaired contract gives {found:#?}");
            }
        }
    }
    assert!(count > 5, "only {count} repaired contracts");
    assert!(report.is_empty(), "{report}");
}
