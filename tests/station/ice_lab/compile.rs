//! The generated C of every machine of the line, under strict compiler warnings.

use crate::laboratory::machines;
use linewright::station::Package;
use std::process::Command;

#[test]
fn no_machine_of_the_line_has_a_warning() {
    // If `cc` ignored the warnings, faults would not be detected.
    let folder = tempfile::tempdir().unwrap();
    let narrowing = folder.path().join("narrowing.c");
    std::fs::write(&narrowing, "int f(long a);\nint f(long a) { return a; }\n").unwrap();
    assert!(
        compile("cc", &narrowing, "-O0").is_err(),
        "the compiler warns"
    );
    let compilers = ["cc", "gcc", "clang"];
    let compilers = compilers
        .into_iter()
        .filter(|c| Command::new(c).arg("--version").output().is_ok());
    for compiler in compilers {
        for controlled in machines() {
            let package = Package::emit(&controlled.machine, &controlled.controllers);
            let file = package.write_source(folder.path()).unwrap();
            // The optimizer detects more: use of uninitialized values, and endless loops.
            for level in ["-O0", "-O2"] {
                if let Err(errors) = compile(compiler, &file, level) {
                    panic!("{} with {compiler} {level}:\n{errors}", package.name);
                }
            }
        }
    }
}

/// The tables of shipped machines are small: a whole machine's object code stays below a mebibyte,
/// without the space for instances.
#[test]
fn explicit_machines_are_small() {
    let folder = tempfile::tempdir().unwrap();
    for controlled in machines() {
        let package = Package::emit(&controlled.machine, &controlled.controllers);
        let file = package.write_source(folder.path()).unwrap();
        for level in ["-O0", "-O2"] {
            compile("cc", &file, level).unwrap_or_else(|e| panic!("{e}"));
            let object = std::fs::metadata(file.with_extension("o")).unwrap().len();
            println!("{} {level}: {object} bytes", package.name);
            assert!(object < 1 << 20, "{} {level}: {object} bytes", package.name);
        }
    }
}

fn compile(compiler: &str, file: &std::path::Path, level: &str) -> Result<(), String> {
    let output = Command::new(compiler)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror"])
        .args([level, "-fPIC", "-c"])
        .arg(file)
        .arg("-o")
        .arg(file.with_extension("o"))
        .output()
        .expect("the compiler starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    // `-Werror` makes each warning an error; no warning may remain that is not.
    if output.status.success() && text.is_empty() {
        Ok(())
    } else {
        Err(text)
    }
}
