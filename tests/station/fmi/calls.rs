//! The unit's own library under a plain C host: trajectories, wrong calls, and that the comparison
//! can fail.

use super::hosts::{
    arguments, build_package, host, laboratory, record, run, run_here, unpack, write,
};
use super::tape::compare;
use crate::support::skip;
use linewright::station::fmi::Version;
use std::process::Command;

#[test]
fn trajectories_are_the_machines() {
    let folder = tempfile::tempdir().unwrap();
    let mut refused = 0;
    let hosts = Version::ALL.map(|v| host(Command::new("cc"), v, folder.path()));
    for (seed, built) in (1..).zip(laboratory()) {
        let version = usize::from(built.unit.version == Version::Three);
        let tape = record(built, 60, 80, seed);
        let library = unpack(built, false, folder.path());
        let file = write(&tape, folder.path());
        let printed = run_here(&hosts[version], built, &library, Some(&file));
        let name = format!("{} {:?}", built.machine.name, built.unit.version);
        compare(&tape, &printed, true).unwrap_or_else(|e| panic!("{name}: {e}"));
        println!(
            "{name}: {} steps, {} operations, {} of them compared with simulate, {} refused",
            tape.expected.len(),
            tape.completed,
            tape.compared,
            tape.refused
        );
        if !built.machine.operations.is_empty() {
            // Operations of one step are never seen unfinished.
            let instant = built.machine.step_seconds == 0.0;
            assert!(
                (instant || tape.completed > 50) && tape.compared > 20,
                "{name}"
            );
        }
        assert!(tape.refused < tape.expected.len() / 2, "{name}");
        refused += tape.refused;
    }
    // The assumptions of some machines cannot be violated by their inputs; those of others can.
    assert!(refused > 100, "{refused}");
}

#[test]
fn wrong_calls_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    for built in laboratory()
        .iter()
        .filter(|b| b.machine.name == "AssemblyCell")
    {
        let host = host(Command::new("cc"), built.unit.version, folder.path());
        let library = unpack(built, false, folder.path());
        let printed = run_here(&host, built, &library, None);
        assert_eq!(printed, "HOST PASSED\n");
    }
}

/// A host that compares nothing would pass as well: so one number of one table is changed.
#[test]
fn a_damaged_table_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    for built in laboratory().iter().filter(|b| b.machine.name == "Printer") {
        let host = host(Command::new("cc"), built.unit.version, folder.path());
        let tape = record(built, 20, 60, 5);
        let played = |package: &linewright::station::Package| {
            let library = build_package(package, folder.path());
            let file = write(&tape, folder.path());
            compare(&tape, &run_here(&host, built, &library, Some(&file)), true)
        };
        let mut package = built.unit.package.clone();
        assert_eq!(played(&package), Ok(()), "the unit as it is");
        // The second leaf of the last table of leaves gets another answer.
        let at = package
            .c_source
            .rfind("_leaves[] = {")
            .expect("a table of leaves");
        let first = at + package.c_source[at..].find("    { ").expect("a leaf") + 6;
        let second = first + package.c_source[first..].find("    { ").expect("a leaf") + 6;
        let end = second + package.c_source[second..].find(',').expect("its answer");
        let changed = if &package.c_source[second..end] == "0" {
            "1"
        } else {
            "0"
        };
        package.c_source.replace_range(second..end, changed);
        let verdict = played(&package).expect_err("a damaged table is seen");
        println!("{verdict}");
    }
}

/// The same wrong calls with the address and undefined behavior sanitizers in the unit and in the
/// host.
#[test]
fn wrong_calls_under_sanitizers() {
    const SANITIZERS: &str = "-fsanitize=address,undefined";
    let folder = tempfile::tempdir().unwrap();
    let cell = |b: &&super::hosts::Built| b.machine.name == "AssemblyCell";
    for built in laboratory().iter().filter(cell) {
        let source = built.unit.package.write_source(folder.path()).unwrap();
        let library = folder.path().join("sanitized.so");
        let compiled = Command::new("cc")
            .args(["-std=c99", "-O1", "-fPIC", "-shared", SANITIZERS])
            .args(["-fno-sanitize-recover=all", "-fvisibility=hidden"])
            .arg(&source)
            .arg("-o")
            .arg(&library)
            .args(["-pthread", "-lm"])
            .output()
            .expect("the compiler starts");
        if !compiled.status.success() {
            return skip("asan", &String::from_utf8_lossy(&compiled.stderr));
        }
        let mut compiler = Command::new("cc");
        compiler.arg(SANITIZERS);
        let host = host(compiler, built.unit.version, folder.path());
        // With address space randomization, some sanitizers do not start.
        let mut command = Command::new("setarch");
        command.arg("-R").arg(&host);
        command.args(arguments(built, library.display().to_string(), None));
        command.env("ASAN_OPTIONS", "detect_leaks=0");
        assert_eq!(run(&mut command), "HOST PASSED\n");
    }
}
