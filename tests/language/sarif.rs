//! SARIF documents checked against the schema of the standard (OASIS, 2.1.0), by an independent
//! validator: Python's `jsonschema` (`sarif`). Documents come from `check` of every case file,
//! `check` of the library, and `explain`.

use crate::support;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// Prints every invalid document with the place; exits with 1 if there is one.
const VALIDATE: &str = "
import json, sys
from jsonschema import Draft7Validator, FormatChecker
with open(sys.argv[1], encoding='utf-8') as file:
    schema = json.load(file)
Draft7Validator.check_schema(schema)
validator = Draft7Validator(schema, format_checker=FormatChecker())
wrong = 0
for path in sys.argv[2:]:
    with open(path, encoding='utf-8') as file:
        document = json.load(file)
    for error in validator.iter_errors(document):
        wrong += 1
        print(path, error.json_path, error.message[:200])
sys.exit(1 if wrong else 0)
";

fn validate(python: &Path, documents: &[PathBuf]) -> Output {
    Command::new(python)
        .args(["-c", VALIDATE])
        .arg(support::root().join("tests/fixtures/sarif/sarif-schema-2.1.0.json"))
        .args(documents)
        .output()
        .expect("Python starts")
}

/// The files below a folder with extensions that `check` reads, without snapshots.
fn cases(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let ending = path.extension().and_then(|e| e.to_str());
        if path.is_dir() {
            cases(&path, found);
        } else if ending.is_some_and(|e| ["lw", "spc", "slugsin", "structuredslugs"].contains(&e)) {
            found.push(path);
        }
    }
    found.sort();
}

/// The program's SARIF output, whatever its exit code.
fn sarif(folder: &Path, arguments: &[&str]) -> String {
    let arguments = [arguments, &["--format", "sarif"]].concat();
    let output = support::linewright(folder, &arguments);
    let code = output.status.code();
    assert!(matches!(code, Some(0..=3)), "{arguments:?}: {code:?}");
    String::from_utf8(output.stdout).expect("a text")
}

/// All documents under test, by name.
static DOCUMENTS: LazyLock<Vec<(String, String)>> = LazyLock::new(|| {
    let folder = support::root().join("tests/cases");
    let mut files = Vec::new();
    cases(&folder, &mut files);
    assert!(files.len() > 40, "only {} cases", files.len());
    let mut documents = Vec::new();
    for file in &files {
        let name = file.strip_prefix(&folder).expect("it lies within");
        let name = name.to_str().expect("a name in UTF-8");
        // Nothing would ever end the case for limits.
        let text = sarif(&folder, &["check", name, "--timeout", "2"]);
        documents.push((name.replace('/', "__"), text));
    }
    // A clean library; a file without a place for its finding, in a folder whose name is not a
    // valid URI.
    documents.push((
        "library".to_owned(),
        sarif(support::root(), &["check", "contracts"]),
    ));
    let odd = tempfile::tempdir().expect("a folder");
    let name = "fräsen & bohren/a#b [1].lw";
    std::fs::create_dir(odd.path().join("fräsen & bohren")).expect("a folder");
    std::fs::write(odd.path().join(name), "contract A { output x: bool }\n").expect("a file");
    let text = sarif(odd.path(), &["check", name, "missing.lw"]);
    documents.push(("odd".to_owned(), text));
    documents.push((
        "rules".to_owned(),
        sarif(odd.path(), &["explain", "--list"]),
    ));
    documents
});

#[test]
fn documents_follow_the_schema() {
    let Some(python) = support::python_with("sarif", "jsonschema") else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let mut paths = Vec::new();
    for (name, text) in DOCUMENTS.iter() {
        let path = folder.path().join(format!("{name}.sarif"));
        std::fs::write(&path, text).expect("a file");
        paths.push(path);
    }
    let output = validate(&python, &paths);
    assert!(
        output.status.success(),
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );

    // The validator detects errors.
    let right = std::fs::read_to_string(&paths[0]).expect("a document");
    for (from, to) in [
        ("\"version\": \"2.1.0\"", "\"version\": \"2.2\""),
        ("\"startLine\": ", "\"startLine\": -"),
        ("\"ruleId\"", "\"rule\""),
        ("\"level\": \"error\"", "\"level\": \"fatal\""),
        ("\"markdown\"", "\"html\""),
    ] {
        assert!(right.contains(from), "{from}");
        std::fs::write(&paths[0], right.replacen(from, to, 1)).expect("a file");
        assert!(!validate(&python, &paths[..1]).status.success(), "{to}");
    }
}

/// What no schema checks: results belong to rules, and places are relative or complete URIs.
#[test]
fn results_point_at_rules_with_help() {
    for (name, text) in DOCUMENTS.iter() {
        let document: Value = serde_json::from_str(text).expect("a document");
        let run = &document["runs"][0];
        let rules = run["tool"]["driver"]["rules"].as_array().expect("rules");
        for rule in rules {
            for text in ["/fullDescription/text", "/help/text", "/help/markdown"] {
                let text = rule.pointer(text).and_then(Value::as_str);
                assert!(text.is_some_and(|t| t.len() > 20), "{name}: {rule}");
            }
        }
        for result in run["results"].as_array().expect("results") {
            let index = result["ruleIndex"].as_u64().expect("an index") as usize;
            assert_eq!(rules[index]["id"], result["ruleId"], "{name}");
            for key in ["locations", "relatedLocations"] {
                for location in result[key].as_array().into_iter().flatten() {
                    let uri = location.pointer("/physicalLocation/artifactLocation/uri");
                    let uri = uri.and_then(Value::as_str).expect("a URI");
                    let allowed = |c: char| c.is_ascii_alphanumeric() || "-._~/%:".contains(c);
                    assert!(uri.chars().all(allowed), "{name}: {uri}");
                }
            }
        }
    }
}
