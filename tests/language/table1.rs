//! Table I of the paper, as printed and in each of its readings, and sketches of the authors'
//! public demo: `tests/cases/table1`.
//!
//! The first line of a file states its expectation: `// expect: NAME VERDICT`, the verdict on its
//! contract of that name, or `// expect: LWxxx`, the finding for which it is rejected.
//! `// finds: LWxxx LWxxx` lists the codes of all findings, of any severity, in ascending order,
//! and `// says: TEXT` is a note of one of them. The contract's controller is extracted and
//! verified if there is one.

use crate::support;
use linewright::game::{Limits, Outcome, solve};
use linewright::mealy::{extract::extract, verify::verify};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The expectation stated in a file.
#[derive(Debug, PartialEq, Eq)]
enum Expected {
    Verdict { name: String, verdict: String },
    Refused(String),
}

fn expected(text: &str) -> Option<Expected> {
    let words = text.lines().next()?.strip_prefix("// expect: ")?;
    match words.split_whitespace().collect::<Vec<_>>().as_slice() {
        [name, verdict @ ("realizable" | "unrealizable")] => Some(Expected::Verdict {
            name: (*name).to_owned(),
            verdict: (*verdict).to_owned(),
        }),
        [code] if linewright::diagnostics::codes::find(code).is_some() => {
            Some(Expected::Refused((*code).to_owned()))
        }
        _ => None,
    }
}

/// The codes of all findings that a file states.
fn found(text: &str) -> Option<Vec<String>> {
    let codes = text.lines().find_map(|l| l.strip_prefix("// finds: "))?;
    Some(codes.split_whitespace().map(str::to_owned).collect())
}

/// The codes of findings, in ascending order.
fn codes(findings: &[Value]) -> Vec<String> {
    let code = |f: &Value| f["code"].as_str().expect("a code").to_owned();
    let mut codes: Vec<String> = findings.iter().map(code).collect();
    codes.sort();
    codes.dedup();
    codes
}

/// The cases, in alphabetic order.
fn cases() -> Vec<PathBuf> {
    let folder = support::root().join("tests/cases/table1");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "lw"));
    files.sort();
    files
}

fn check(file: &Path) -> (i32, Value) {
    let path = file.display().to_string();
    let arguments = ["check", "--format", "json", "--no-timing", &path];
    let output = support::linewright(support::root(), &arguments);
    let document = serde_json::from_slice(&output.stdout).expect("a document");
    (output.status.code().expect("an exit code"), document)
}

#[test]
fn every_reading_has_its_verdict() {
    let mut verdicts = Vec::new();
    for file in cases() {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(&file).expect("a text");
        let expected = expected(&text).unwrap_or_else(|| panic!("{name} says what to expect"));
        let (code, document) = check(&file);
        let contracts = document["contracts"].as_array().expect("a list");
        let [contract] = contracts.as_slice() else {
            panic!("{name} declares one contract: {document:#}");
        };
        let findings = contract["findings"].as_array().expect("a list");
        assert_eq!(Some(codes(findings)), found(&text), "{name}: {findings:#?}");
        for said in text.lines().filter_map(|l| l.strip_prefix("// says: ")) {
            let mut notes = findings.iter().filter_map(|f| f["notes"].as_array());
            let says = notes.any(|notes| {
                let mut texts = notes.iter().filter_map(Value::as_str);
                texts.any(|text| text.contains(said))
            });
            assert!(says, "{name}: {said}: {findings:#?}");
        }
        match &expected {
            Expected::Verdict { name: own, verdict } => {
                assert_eq!(contract["name"], own.as_str(), "{name}");
                assert_eq!(contract["verdict"], verdict.as_str(), "{name}");
                let realizable = verdict == "realizable";
                assert_eq!(code, i32::from(!realizable), "{name}");
                let core = contract["core"].as_array().expect("a list");
                assert_eq!(core.is_empty(), realizable, "{name}: {core:?}");
                let error = findings.iter().find(|f| f["severity"] == "error");
                let error = error.map(|f| f["code"].clone());
                let wanted = (!realizable).then(|| Value::from("LW203"));
                assert_eq!(error, wanted, "{name}");
            }
            Expected::Refused(wanted) => {
                assert_eq!(contract["verdict"], "invalid", "{name}");
                assert_eq!(code, 1, "{name}");
                assert_eq!(findings.len(), 1, "{name}: {findings:?}");
                assert_eq!(findings[0]["code"], wanted.as_str(), "{name}");
                // It points at the undeclared name.
                let line = findings[0]["span"]["line"].as_u64().expect("a line") as usize;
                let pointed = text.lines().nth(line - 1).expect("a line");
                assert!(pointed.contains("desired ∧"), "{name}: {pointed}");
                assert_eq!(findings[0]["help"], "did you mean `desired_angle`?");
            }
        }
        verdicts.push(format!("{name}: {expected:?}"));
    }
    // None may get lost: each contract of the table, in its distinguishable readings, and the
    // sketches.
    assert_eq!(verdicts.len(), 8, "{verdicts:#?}");
}

#[test]
fn with_its_prime_the_demo_is_unrealizable() {
    let file = support::root().join("tests/cases/table1/demo_move_prime.lw");
    let text = std::fs::read_to_string(file).expect("a text");
    let primed = text.replace("→ x = x)", "→ ○(x) = x)");
    assert_ne!(primed, text);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("primed.lw");
    std::fs::write(&file, primed).expect("a file");
    let (code, document) = check(&file);
    let contract = &document["contracts"][0];
    assert_eq!(contract["verdict"], "unrealizable");
    let findings = contract["findings"].as_array().expect("a list");
    assert_eq!((code, codes(findings)), (1, vec!["LW203".to_owned()]));
}

#[test]
fn every_realizable_reading_has_a_verified_controller() {
    let limits = Limits::default();
    let mut verified = 0;
    for file in cases() {
        let text = std::fs::read_to_string(&file).expect("a text");
        let Some(Expected::Verdict { name, verdict }) = expected(&text) else {
            continue;
        };
        let file = file.display().to_string();
        let none = |path: &str, _: &str| Err(format!("{path} is not needed"));
        let (library, findings) = linewright::contract::load(&[(file.clone(), text)], &none);
        let contract = library.contracts.iter().find(|c| c.name == name);
        let specification = &contract
            .unwrap_or_else(|| panic!("{findings:?}"))
            .specification;
        match solve(specification, &limits) {
            Outcome::Realizable(won) => {
                assert_eq!(verdict, "realizable", "{file}");
                let machine = extract(specification, &won, &limits).expect("no limit");
                assert_eq!(
                    verify(specification, &machine, &limits),
                    Ok(Ok(())),
                    "{file}"
                );
                verified += 1;
            }
            Outcome::Unrealizable(_) => assert_eq!(verdict, "unrealizable", "{file}"),
            Outcome::GaveUp(limit) => panic!("{file}: {limit}"),
        }
    }
    assert_eq!(verified, 5);
}

#[test]
fn expectations_are_read() {
    let verdict = |name: &str, verdict: &str| {
        let (name, verdict) = (name.to_owned(), verdict.to_owned());
        Some(Expected::Verdict { name, verdict })
    };
    assert_eq!(
        expected("// expect: Turn realizable\n"),
        verdict("Turn", "realizable")
    );
    assert_eq!(
        expected("// expect: LW101"),
        Some(Expected::Refused("LW101".to_owned()))
    );
    for wrong in [
        "",
        "// Turn realizable",
        "// expect: LW999",
        "// expect: Turn maybe",
        "\n// expect: LW101",
    ] {
        assert_eq!(expected(wrong), None, "{wrong}");
    }
    let two = "// expect: Turn realizable\n// finds: LW205 LW206\n";
    assert_eq!(
        found(two),
        Some(vec!["LW205".to_owned(), "LW206".to_owned()])
    );
    assert_eq!(found("// expect: LW101\n"), None);
}
