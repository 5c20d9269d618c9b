//! Verdicts of the program on lines before they run. Everything else here uses only [`Judged`].

use crate::support::{PROGRAM, documents};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// The verdict on one line.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Judged {
    /// `proved`, `safe`, `open` or `gave_up`; none for an invalid line.
    pub proof: Option<String>,
    /// Unproved premises of a proof, as text.
    pub premises: Vec<String>,
    /// Codes of findings that are errors, including those of the line's machines.
    pub errors: Vec<String>,
    /// Codes of all other findings, and what was not decided.
    pub reasons: Vec<String>,
}

impl Judged {
    pub fn is_proved(&self) -> bool {
        self.proof.as_deref() == Some("proved") && self.errors.is_empty()
    }

    /// One word for a table: the first reason why it is not proved.
    pub fn reason(&self) -> String {
        let first = self.errors.first().or(self.reasons.first());
        first.cloned().unwrap_or_else(|| "none".to_owned())
    }
}

/// The verdicts on a file.
#[derive(Debug, Default)]
pub struct Report {
    /// Verdicts by name of the line.
    pub lines: BTreeMap<String, Judged>,
    /// By name of the machine: the codes of its errors, including those of its contracts.
    pub machines: BTreeMap<String, Vec<String>>,
    /// Output in place of a document.
    pub failure: Option<String>,
}

/// Work that a proof may do in the gate, where a single hard line would take minutes.
const EFFORT_IN_THE_GATE: &str = "0.1";

/// Judges every line of a file. What is in `cache` is not solved again.
pub fn judge(file: &Path, cache: &Path) -> Report {
    let effort = match std::env::var_os("LINEWRIGHT_ATTACK") {
        Some(_) => "1",
        None => EFFORT_IN_THE_GATE,
    };
    let output = Command::new(PROGRAM)
        .args(["check", "--format", "json", "--no-timing"])
        .args(["--effort", effort])
        .arg(file)
        .env("LINEWRIGHT_CACHE", cache)
        .env("RUST_BACKTRACE", "0")
        .output()
        .expect("the program starts");
    documents::assert_valid(&output.stdout);
    let Ok(document) = serde_json::from_slice::<Value>(&output.stdout) else {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        return Report {
            failure: Some(said),
            ..Report::default()
        };
    };
    let mut report = Report::default();
    let unkept: BTreeMap<&str, Vec<String>> = rows(&document, "contracts")
        .map(|row| (name(row), codes(row, true)))
        .collect();
    for row in rows(&document, "machines") {
        let mut errors = codes(row, true);
        for component in rows(row, "components") {
            let contract = component["contract"].as_str().unwrap_or_default();
            errors.extend(unkept.get(contract).into_iter().flatten().cloned());
            let verdict = component["verdict"].as_str().unwrap_or_default();
            if verdict != "realizable" {
                errors.push(verdict.to_owned());
            }
        }
        if row["verdict"] != "realizable" && errors.is_empty() {
            errors.push(row["verdict"].to_string());
        }
        report.machines.insert(name(row).to_owned(), errors);
    }
    for row in rows(&document, "lines") {
        let mut judged = Judged {
            proof: row["proof"].as_str().map(str::to_owned),
            premises: row["premises"]
                .as_array()
                .into_iter()
                .flatten()
                .map(text)
                .collect(),
            errors: codes(row, true),
            reasons: codes(row, false),
        };
        if row["verdict"] != "valid" && judged.errors.is_empty() {
            judged.errors.push("invalid".to_owned());
        }
        let undecided = row["undecided"].as_array().into_iter().flatten();
        judged.reasons.extend(undecided.map(text));
        report.lines.insert(name(row).to_owned(), judged);
    }
    report
}

/// Result of a run of the program.
pub struct Ran {
    pub products: u64,
    pub violations: u64,
    /// Codes of its findings.
    said: Vec<String>,
}

impl Ran {
    /// Checks that it reports the same about the line as `check`.
    pub fn agrees_with(&self, judged: &Judged) -> Result<(), String> {
        let mut codes = judged.errors.iter();
        match codes.find(|code| !self.said.contains(code)) {
            Some(code) => Err(format!(
                "check finds {code}, and run does not: {:?}",
                self.said
            )),
            None => Ok(()),
        }
    }
}

/// Runs the only line of a file: products and violations, or `None` if the program refuses it.
pub fn run(file: &Path, cache: &Path, seed: u64, parts: u64, seconds: f64) -> Option<Ran> {
    let output = Command::new(PROGRAM)
        .args(["run", "--format", "json", "--no-timing"])
        .args(["--seed", &seed.to_string(), "--parts", &parts.to_string()])
        .args(["--until", &seconds.to_string()])
        .arg("--out")
        .arg(cache.with_file_name("libraries"))
        .arg(file)
        .env("LINEWRIGHT_CACHE", cache)
        .output()
        .expect("the program starts");
    documents::assert_valid(&output.stdout);
    let document: Value = serde_json::from_slice(&output.stdout).ok()?;
    let count = |key: &str| match &document[key] {
        Value::Array(list) => Some(list.len() as u64),
        value => value.as_u64(),
    };
    Some(Ran {
        products: count("products")?,
        violations: count("violation_count").or(count("violations"))?,
        said: rows(&document, "findings")
            .map(|f| text(&f["code"]))
            .collect(),
    })
}

fn rows<'a>(document: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    document[key].as_array().into_iter().flatten()
}

fn name(row: &Value) -> &str {
    row["name"].as_str().unwrap_or_default()
}

fn text(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// The codes of a row's findings: of its errors, or of all others.
fn codes(row: &Value, errors: bool) -> Vec<String> {
    let of = |f: &&Value| (f["severity"] == "error") == errors;
    let found = rows(row, "findings").filter(of);
    found.map(|f| text(&f["code"])).collect()
}
