//! `ffi/host.c`, the small host that users start from, on this computer and on Windows.

use super::machines::named;
use super::programs::{PASSED, PATIENCE, Prepared, cc, compile};
use crate::support::programs::{Finished, run};
use crate::support::wine::{windows_path, wine};
use crate::support::{root, skip};
use linewright::station::Toolchain;
use linewright::station::toolchain::Compiler;
use std::process::Command;

/// Operation 0 with these properties, as words.
const ARGUMENTS: [&str; 5] = ["0", "0", "0", "2", "1"];

fn check(finished: &Finished) {
    let output = &finished.output;
    assert_eq!(finished.last_line(), PASSED, "{}", finished.all());
    assert!(
        output.contains("\"machine\"") && output.contains(" steps"),
        "{output}"
    );
    assert!(
        output.contains("property 0: 2") && output.contains("property 1: 1"),
        "{output}"
    );
}

#[test]
fn the_example_host_runs() {
    let prepared = Prepared::new(&named("Printer"));
    let library = prepared.library(&Toolchain::shipping());
    let program = prepared.folder().join("host");
    let sources = [root().join("ffi/host.c")];
    compile(&mut cc(), &["-O2"], &sources, &program);
    let mut command = Command::new(&program);
    check(&run(command.arg(&library).args(ARGUMENTS), PATIENCE));
    // A refusal is printed with its code.
    let mut command = Command::new(&program);
    let refused = run(
        command.arg(&library).args(["1", "0", "0", "2", "1"]),
        PATIENCE,
    );
    assert!(
        refused.errors.contains("code -4: there is no operation 1"),
        "{refused:?}"
    );
    assert!(!refused.success && refused.last_line() != PASSED);
}

#[test]
fn the_example_host_runs_on_windows() {
    let (_, compiler) = match Compiler::windows() {
        Ok(found) => found,
        Err(error) => return skip("mingw", &error.to_string()),
    };
    let wine = match wine() {
        Ok(wine) => wine,
        Err(why) => return skip("wine", &why),
    };
    let prepared = Prepared::new(&named("Printer"));
    let toolchain = Toolchain::windows().expect("there is a compiler");
    let library = windows_path(&prepared.library(&toolchain));
    let program = prepared.folder().join("host.exe");
    let sources = [root().join("ffi/host.c")];
    compile(&mut compiler.command(), &["-O2"], &sources, &program);
    let arguments = [library.as_str()].into_iter().chain(ARGUMENTS);
    let arguments: Vec<String> = arguments.map(str::to_owned).collect();
    check(&wine.run(&program, &arguments, PATIENCE));
}
