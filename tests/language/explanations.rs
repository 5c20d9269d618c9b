//! The explanation pages: every code has one, with an example in which `check` finds exactly that
//! code and gives a help text, and with a section on the repair; in the repaired example, `check`
//! finds nothing.

use crate::support;
use linewright::diagnostics::{codes, explanations};
use serde_json::Value;
use std::fmt::Write as _;

/// Codes that no contract shows: they need a running plant, a compiler, a damaged file, or a limit.
/// Their pages show a console.
const NOT_IN_A_CONTRACT: &[&str] = &[
    "LW001", "LW007", "LW204", "LW311", "LW312", "LW317", "LW403", "LW404", "LW405", "LW406",
    "LW407", "LW409", "LW501", "LW502", "LW503", "LW504", "LW505", "LW506", "LW507", "LW530",
    "LW540", "LW541", "LW542", "LW543", "LW544", "LW545", "LW546", "LW547", "LW620", "LW621",
];

/// A finding as in a document of `check`.
#[derive(Debug)]
struct Finding {
    code: String,
    #[expect(dead_code, reason = "a failed test prints it")]
    message: String,
    help: Option<String>,
}

/// The findings of a document, at any depth.
fn findings(document: &Value, found: &mut Vec<Finding>) {
    match document {
        Value::Array(values) => values.iter().for_each(|v| findings(v, found)),
        Value::Object(fields) => {
            let text = |name: &str| fields.get(name).and_then(Value::as_str).map(str::to_owned);
            if let (Some(code), Some(message)) = (text("code"), text("message")) {
                found.push(Finding {
                    code,
                    message,
                    help: text("help"),
                });
            }
            fields.values().for_each(|v| findings(v, found));
        }
        _ => {}
    }
}

/// The findings in a file with this extension and text.
fn check(ending: &str, text: &str) -> Vec<Finding> {
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

/// The blocks of a page fenced with plain ```` ```lw ````: repaired contracts.
fn repaired(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if line == "```lw" {
            let block = lines.by_ref().take_while(|l| *l != "```");
            blocks.push(block.flat_map(|l| [l, "\n"]).collect());
        }
    }
    blocks
}

/// The page of a code, which must exist.
fn page(code: codes::Code, report: &mut String) -> &'static str {
    explanations::page(code).unwrap_or_else(|| {
        let _ = writeln!(report, "{code} has no page");
        ""
    })
}

#[test]
fn every_code_has_a_page_with_an_example_and_a_repair() {
    let mut report = String::new();
    for code in codes::ALL {
        let page = page(*code, &mut report);
        if !page.contains("\n## How to repair it\n") {
            let _ = writeln!(report, "{code}: the page does not say how to repair it");
        }
        let examples = explanations::examples(page);
        if examples.iter().any(|e| e.code != code.id) {
            let _ = writeln!(report, "{code}: an example is of another code");
        }
        if NOT_IN_A_CONTRACT.contains(&code.id) {
            if !page.contains("\n```console\n") || !examples.is_empty() {
                let _ = writeln!(report, "{code}: a console has to show it");
            }
        } else if examples.is_empty() {
            let _ = writeln!(report, "{code}: no contract shows it");
        }
    }
    assert!(report.is_empty(), "{report}");
    assert!(NOT_IN_A_CONTRACT.iter().all(|id| codes::find(id).is_some()));
}

#[test]
fn examples_give_their_own_code_alone_and_a_next_step() {
    let mut report = String::new();
    for code in codes::ALL {
        for example in explanations::examples(page(*code, &mut report)) {
            let found = check(&example.extension, &example.text);
            if found.is_empty() || found.iter().any(|f| f.code != code.id) {
                let _ = writeln!(report, "{code}: the example gives {found:#?}");
            }
            let silent = |f: &&Finding| f.help.as_ref().is_none_or(|h| h.trim().is_empty());
            for finding in found.iter().filter(silent) {
                let _ = writeln!(report, "{code}: no next step: {finding:#?}");
            }
        }
    }
    assert!(report.is_empty(), "{report}");
}

#[test]
fn nothing_is_found_in_repaired_contracts() {
    let (mut report, mut count) = (String::new(), 0);
    for code in codes::ALL {
        for contract in repaired(page(*code, &mut report)) {
            count += 1;
            let found = check("lw", &contract);
            if !found.is_empty() {
                let _ = writeln!(report, "{code}: the repaired contract gives {found:#?}");
            }
        }
    }
    assert!(count > 5, "only {count} repaired contracts");
    assert!(report.is_empty(), "{report}");
}

#[test]
fn the_list_has_every_code_in_its_group() {
    let folder = tempfile::tempdir().expect("a folder");
    let explain = |more: &[&str]| {
        let arguments = [&["explain"], more].concat();
        let output = support::linewright(folder.path(), &arguments);
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).expect("a text")
    };
    let list = explain(&["--list"]);
    assert_eq!(list, explain(&[]));
    insta::assert_snapshot!("list", list);

    let document: Value =
        serde_json::from_str(&explain(&["--list", "--format", "json"])).expect("JSON");
    let entries = document["codes"].as_array().expect("codes");
    assert_eq!(entries.len(), codes::ALL.len());
    for (entry, code) in entries.iter().zip(codes::ALL) {
        assert_eq!(entry["code"], code.id);
        assert_eq!(entry["title"], code.title);
        assert_eq!(entry["group"], code.group().title);
        assert!(entry.get("page").is_none());
    }
    let one: Value = serde_json::from_str(&explain(&["LW203", "--format", "json"])).expect("JSON");
    assert_eq!(
        one["codes"][0]["page"],
        explanations::page(codes::UNREALIZABLE).expect("a page")
    );

    // In SARIF, codes are rules.
    let rules: Value =
        serde_json::from_str(&explain(&["--list", "--format", "sarif"])).expect("JSON");
    let run = &rules["runs"][0];
    assert_eq!(
        run["tool"]["driver"]["rules"].as_array().map(Vec::len),
        Some(codes::ALL.len())
    );
    assert_eq!(run["results"], Value::Array(Vec::new()));

    let both = support::linewright(folder.path(), &["explain", "--list", "LW203"]);
    assert_eq!(both.status.code(), Some(2));
}
