//! `linewright doctor`: its output for a computer with and without compilers.
#![cfg(unix)]

use crate::support;
use serde_json::Value;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

fn doctor(arguments: &[&str], path: &Path) -> Output {
    let output = Command::new(support::PROGRAM)
        .arg("doctor")
        .args(arguments)
        .env("PATH", path)
        .env_remove("CC")
        .env_remove("CC_x86_64_pc_windows_gnu")
        .env("LINEWRIGHT_CACHE", "off")
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts");
    support::documents::assert_valid(&output.stdout);
    output
}

/// A folder with links to these programs only.
fn only(programs: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let places = std::env::var_os("PATH").expect("a path");
    for program in programs {
        let found = std::env::split_paths(&places)
            .map(|p| p.join(program))
            .find(|p| p.is_file());
        if let Some(found) = found {
            symlink(found, folder.path().join(program)).expect("a link");
        }
    }
    folder
}

#[test]
fn without_a_compiler_for_windows_there_is_a_way_out() {
    let folder = only(&["cc", "as", "ld"]);
    let output = doctor(&[], folder.path());
    let (text, said) = (
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr),
    );
    assert_eq!(output.status.code(), Some(0), "{text}{said}");
    assert!(
        text.contains("Windows libraries        cannot be built here"),
        "{text}"
    );
    assert!(said.contains("warning[LW506]"), "{said}");
    assert!(
        said.contains("gcc-mingw-w64-x86-64") && said.contains("pip install ziglang"),
        "{said}"
    );
    assert!(said.contains("note[LW541]"), "{said}");
    let output = doctor(&["--format", "json"], folder.path());
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(document["schema"], "linewright/doctor/1");
    assert_eq!(document["windows"], false);
    assert!(document["c_compiler"]["version"].is_string(), "{document}");
    assert_eq!(document["python"], Value::Null);
    assert_eq!(document["profile"]["verified"], false);
    // `build` reports the same.
    let output = Command::new(support::PROGRAM)
        .args(["build", "--probe", "--target", "windows", "--out"])
        .arg(folder.path().join("out"))
        .env("PATH", folder.path())
        .env_remove("CC_x86_64_pc_windows_gnu")
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("error[LW506]"), "{said}");
}

#[test]
fn without_any_compiler_it_cannot_run() {
    let folder = only(&[]);
    let output = doctor(&[], folder.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("error[LW501]"), "{said}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("not found"));
}

/// A program counts as a compiler only if it compiles.
#[test]
fn what_is_found_is_tried() {
    let folder = only(&["cc", "as", "ld"]);
    let program = |name: &str, script: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("a file");
        std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755))
            .expect("permissions");
    };
    program("x86_64-w64-mingw32-gcc", "echo MinGW of the test");
    let output = doctor(&[], folder.path());
    let text = String::from_utf8_lossy(&output.stdout);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("MinGW of the test"), "{text}");
    assert!(text.contains("which does not compile"), "{text}");
    assert!(text.contains("cannot be built here"), "{text}");
    assert!(
        said.contains("does not compile: it wrote no object file"),
        "{said}"
    );
    assert!(
        text.contains("zig cc                   not found"),
        "{text}"
    );
    assert!(text.contains("profile \"default\" (unverified)"), "{text}");
    let output = doctor(&["--format", "json"], folder.path());
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(document["windows"], false);
    // One that only compiles.
    program(
        "x86_64-w64-mingw32-gcc",
        "case $1 in --version) echo MinGW of the test;; *) exec cc \"$@\";; esac",
    );
    let output = doctor(&[], folder.path());
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("with x86_64-w64-mingw32-gcc"), "{text}");
    // The compiler for this computer is tried as well.
    std::fs::remove_file(folder.path().join("cc")).expect("it is there");
    program("cc", "echo no compiler of ours; exit 0");
    let output = doctor(&[], folder.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("error[LW501]"), "{said}");
}
