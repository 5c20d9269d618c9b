//! `FMPy` validates the units, simulates them as imported, and plays a thousand sequences on them.

use super::hosts::{Built, laboratory, record, run};
use super::tape::{Tape, compare};
use crate::support::{python_with, root};
use std::fmt::Write as _;
use std::process::Command;

const SEQUENCES: usize = 100;

#[test]
fn fmpy_finds_nothing_wrong() {
    let Some(python) = python_with("fmpy", "fmpy") else {
        return;
    };
    let mut command = Command::new(python);
    command
        .arg(root().join("tests/station/fmi/host.py"))
        .arg("validate");
    command.args(laboratory().iter().map(|b| &b.archive));
    assert_eq!(run(&mut command), "HOST PASSED\n");
}

#[test]
fn fmpy_steps_as_the_machines_do() {
    let Some(python) = python_with("fmpy", "fmpy") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let built = laboratory();
    assert_eq!(built.len() * SEQUENCES, 1200);
    let tapes: Vec<(&Built, Tape)> = (1000..)
        .zip(built)
        .map(|(seed, b)| (b, record(b, SEQUENCES, 60, seed)))
        .collect();
    let mut list = String::new();
    for (i, (built, tape)) in tapes.iter().enumerate() {
        let (input, output) = (
            folder.path().join(format!("{i}.tape")),
            folder.path().join(format!("{i}.out")),
        );
        std::fs::write(&input, &tape.text).unwrap();
        let _ = writeln!(
            list,
            "{}\t{}\t{}",
            built.archive.display(),
            input.display(),
            output.display()
        );
    }
    let path = folder.path().join("list");
    std::fs::write(&path, list).unwrap();
    let mut command = Command::new(python);
    command.arg(root().join("tests/station/fmi/host.py"));
    command.arg("play").arg(&path);
    let printed = run(&mut command);
    assert!(printed.ends_with("HOST PASSED\n"), "{printed}");
    for (i, (built, tape)) in tapes.iter().enumerate() {
        let printed = std::fs::read_to_string(folder.path().join(format!("{i}.out"))).unwrap();
        let name = format!("{} {:?}", built.machine.name, built.unit.version);
        compare(tape, &printed, false).unwrap_or_else(|e| panic!("{name}: {e}"));
        if !built.machine.operations.is_empty() {
            // Operations of one step are never seen unfinished.
            let instant = built.machine.step_seconds == 0.0;
            assert!(
                (instant || tape.completed > 50) && tape.compared > 20,
                "{name}"
            );
        }
    }
}
