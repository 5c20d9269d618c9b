//! The files in which defects were found, each with its expected verdict and the results of its
//! runs. They are in `../shared/found` or where `LINEWRIGHT_FOUND` says; without them nothing is
//! tested.

use super::judge::{Judged, Report, judge, run};
use super::runs::{PARTS, SECONDS};
use crate::support::{self, linewright};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A found file, copied with its neighbors, so that build results stay out of the shared folder.
struct Found {
    folder: tempfile::TempDir,
    name: &'static str,
}

impl Found {
    fn new(name: &'static str) -> Option<Self> {
        let from = support::found()?;
        let folder = tempfile::tempdir().expect("a folder");
        for entry in std::fs::read_dir(from).expect("a folder") {
            let path = entry.expect("an entry").path();
            if let Some(file) = path.file_name().filter(|_| path.is_file()) {
                std::fs::copy(&path, folder.path().join(file)).expect("a copy");
            }
        }
        Some(Self { folder, name })
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(self.name)
    }

    fn report(&self) -> Report {
        let report = judge(&self.path(), &self.folder.path().join("cache"));
        assert_eq!(report.failure, None, "{} has no judgement", self.name);
        report
    }

    fn program(&self, words: &[&str]) -> Output {
        let words: Vec<&str> = words
            .iter()
            .map(|w| if *w == "FILE" { self.name } else { w })
            .collect();
        linewright(self.folder.path(), &words)
    }

    /// Numbers of products and violations; `None` if the program refuses the line.
    fn ran(&self) -> Option<(u64, u64)> {
        run(
            &self.path(),
            &self.folder.path().join("cache"),
            1,
            PARTS,
            SECONDS,
        )
        .map(|ran| (ran.products, ran.violations))
    }

    fn line(&self, line: &str) -> Judged {
        let mut report = self.report();
        report
            .lines
            .remove(line)
            .unwrap_or_else(|| panic!("{} has no {line}", self.name))
    }
}

fn said(output: &Output) -> String {
    let (out, err) = (&output.stdout, &output.stderr);
    String::from_utf8_lossy(out).into_owned() + &String::from_utf8_lossy(err)
}

/// A line that fails in its runs: `check` and `run` report the same errors.
fn is_reported(name: &'static str, line: &str) {
    let Some(found) = Found::new(name) else {
        return;
    };
    let judged = found.line(line);
    assert!(!judged.is_proved(), "{name}: {judged:?}");
    assert!(!judged.errors.is_empty(), "{name}: {judged:?}");
    let check = found.program(&["check", "FILE"]);
    assert_eq!(check.status.code(), Some(1), "{name}: {}", said(&check));
    let selected = format!("{name}::{line}");
    let run = found.program(&["run", &selected, "--parts", "5", "--until", "100"]);
    assert_eq!(run.status.code(), Some(1), "{name}: {}", said(&run));
    for code in &judged.errors {
        let shown = format!("[{code}]");
        assert!(said(&run).contains(&shown), "{name}: {}", said(&run));
    }
}

/// A line on which `check` and `run` must agree, whatever the verdict.
fn is_agreed_on(found: &Found, line: &str) {
    let judged = found.line(line);
    match found.ran() {
        None => assert!(
            !judged.errors.is_empty(),
            "{}: run refuses, check says {judged:?}",
            found.name
        ),
        Some((products, violations)) => {
            if judged.is_proved() && judged.premises.is_empty() {
                assert_eq!(
                    (products, violations),
                    (PARTS, 0),
                    "{} is proved",
                    found.name
                );
            }
        }
    }
}

/// A machine has a verdict without an internal error.
fn has_a_verdict(name: &'static str) {
    let Some(found) = Found::new(name) else {
        return;
    };
    for words in [
        &["check", "FILE"][..],
        &["build", "FILE", "--target", "source", "--out", "out"],
    ] {
        let output = found.program(words);
        let text = said(&output);
        assert!(
            !text.contains("panicked") && !text.contains("please report"),
            "{name}: {text}"
        );
        assert!(
            matches!(output.status.code(), Some(0..=3)),
            "{name}: {:?}",
            output.status
        );
    }
    found.report();
}

// Section 1: a line that is proved, and whose run refuses parts.

#[test]
fn a_constant_abstraction_that_breaks_an_assumption() {
    is_reported("u1.lw", "L");
}

#[test]
fn a_property_that_breaks_an_assumption() {
    is_reported("u3.lw", "L");
}

#[test]
fn a_parameter_that_breaks_an_assumption() {
    is_reported("u4.lw", "L");
}

#[test]
fn an_abstraction_that_leaves_its_domain() {
    is_reported("abs.lw", "L");
}

#[test]
fn a_written_value_that_leaves_its_domain() {
    is_reported("wide.lw", "L");
}

#[test]
fn a_defect_that_leaves_its_domain() {
    is_reported("def2.lw", "D");
}

#[test]
fn an_operation_that_needs_more_steps_than_the_limit() {
    is_reported("c2.lw", "L");
    let Some(found) = Found::new("c2.lw") else {
        return;
    };
    // The step limit is the cause, not the coordinator's assumption.
    let check = said(&found.program(&["check", "FILE"]));
    assert!(check.contains("limit"), "{check}");
}

#[test]
fn a_time_that_is_nothing() {
    is_reported("z1.lw", "L");
}

#[test]
fn a_time_without_end() {
    is_reported("z5.lw", "L");
}

#[test]
fn a_route_that_no_part_can_take() {
    is_reported("c1.lw", "L");
}

/// Nothing is wrong with the line before the change: it runs.
#[test]
fn a_plain_line_is_proved() {
    let Some(found) = Found::new("base.lw") else {
        return;
    };
    assert!(found.line("L").is_proved());
    assert_eq!(found.ran(), Some((PARTS, 0)));
}

/// Either the runner serves fairly, or the proof says that it assumes it.
#[test]
fn a_type_that_is_never_served() {
    let Some(found) = Found::new("starved.lw") else {
        return;
    };
    let judged = found.line("L");
    // With orders for five products the other type ends; without end it always comes first.
    let words = [
        "run",
        "FILE",
        "--until",
        "20000",
        "--format",
        "json",
        "--no-timing",
    ];
    let run = found.program(&words);
    let document: Value = serde_json::from_slice(&run.stdout).expect("a document");
    assert_eq!(document["violation_count"], 0);
    let products = document["products"].as_u64().expect("a count");
    let mut premises = judged.premises.iter();
    let fair = premises.any(|p| p.contains("st1") || p.contains("P1"));
    assert!(
        products > 0 || !judged.is_proved() || fair,
        "{products} products, {judged:?}"
    );
}

#[test]
fn a_machine_whose_assumptions_the_run_breaks() {
    for name in [
        "machine-777257.lw",
        "machine-777883.lw",
        "machine-777197.lw",
    ] {
        let Some(found) = Found::new(name) else {
            return;
        };
        let report = found.report();
        let judged = &report.lines["L"];
        assert!(!judged.is_proved(), "{name}: {judged:?}");
        let run = found.program(&["run", "FILE", "--parts", "5"]);
        assert!(
            !said(&run).contains("please report"),
            "{name}: {}",
            said(&run)
        );
    }
}

// Section 2: check, build and run agree.

#[test]
fn a_signal_that_breaks_an_assumption() {
    let Some(found) = Found::new("u6.lw") else {
        return;
    };
    is_agreed_on(&found, "L");
    let build = found.program(&["build", "FILE", "--target", "source", "--out", "out"]);
    let check = found.program(&["check", "FILE"]);
    assert_eq!(build.status.code(), check.status.code(), "{}", said(&build));
}

/// Its script starts again with each operation, and is correct in each of its steps.
#[test]
fn a_scripted_signal() {
    let Some(found) = Found::new("sg.lw") else {
        return;
    };
    let check = found.program(&["check", "FILE"]);
    assert_eq!(check.status.code(), Some(0), "{}", said(&check));
    let build = found.program(&["build", "FILE", "--target", "source", "--out", "out"]);
    assert_eq!(build.status.code(), Some(0), "{}", said(&build));
    is_agreed_on(&found, "L");
    assert_eq!(found.ran(), Some((PARTS, 0)));
}

// Section 3: contradictory assumptions of a Moore machine.

#[test]
fn contradictory_assumptions_have_a_verdict() {
    for name in ["p1.lw", "p8.lw", "machine-777014.lw", "machine-777193.lw"] {
        has_a_verdict(name);
    }
}

// Section 4: shifts and idle time.

/// Two shifts were once an error, because only one of them counted.
#[test]
fn two_shifts_count() {
    let Some(found) = Found::new("two-shifts.lw") else {
        return;
    };
    assert!(found.line("L").is_proved());
    let run = found.program(&["run", "FILE", "--until", "24h", "--format", "json"]);
    let document: Value = serde_json::from_slice(&run.stdout).expect("a document");
    // Sixteen hours of 60.2 s a part, without an interruption.
    assert_eq!(document["products"], 956, "{}", said(&run));
}

/// Eight of 24 hours are worked, and nothing comes: off shift is idle, not starved.
#[test]
fn off_shift_is_idle() {
    let Some(found) = Found::new("idle.lw") else {
        return;
    };
    let run = found.program(&[
        "run",
        "FILE",
        "--until",
        "24h",
        "--format",
        "json",
        "--no-timing",
    ]);
    let document: Value = serde_json::from_slice(&run.stdout).expect("a document");
    let idle = document["stations"][0]["idle"].as_f64().expect("a share");
    assert!(
        (idle - 2.0 / 3.0).abs() < 1e-3,
        "idle {idle}: {}",
        said(&run)
    );
}

/// Every file of the folder has a test.
#[test]
fn every_found_file_is_tried() {
    let Some(folder) = support::found() else {
        return;
    };
    let own = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file!()))
        .expect("this file");
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let name = entry.expect("an entry").file_name();
        let name = name.to_string_lossy();
        let imported = name == "lib.lw";
        assert!(
            imported || !name.ends_with(".lw") || own.contains(&format!("\"{name}\"")),
            "{name} has no test"
        );
    }
}
