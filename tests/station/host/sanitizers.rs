//! The host and the libraries that it loads, both compiled with a sanitizer: no access out of
//! bounds, no undefined behavior, no race. A library without locks shows that races would be
//! detected.

use super::machines::{Subject, as_functions, fixtures, named};
use super::programs::{Host, PASSED, Prepared, cc};
use crate::support::programs::Finished;
use crate::support::skip;
use linewright::station::Toolchain;
use std::path::Path;
use std::process::Command;

/// Number of calls, each of which takes up to twenty times as long as usual.
const CALLS: u64 = 40_000;

/// The compiler's option, which contains the word used to skip each.
const SANITIZERS: [(&str, &str); 3] = [
    ("asan", "-fsanitize=address"),
    ("ubsan", "-fsanitize=undefined"),
    ("tsan", "-fsanitize=thread"),
];

/// Flags for compiling the library, beside the sanitizer.
const LIBRARY: [&str; 7] = [
    "-std=c99",
    "-shared",
    "-fPIC",
    "-O1",
    "-g",
    "-fvisibility=hidden",
    "-ffp-contract=off",
];

/// Any undefined behavior ends the program, in the library and in the host.
const STRICT: &str = "-fno-sanitize-recover=all";

/// A host with a sanitizer, whose libraries have it too; `None`, with a message, if a program with
/// it does not run.
pub fn host(name: &str, word: &str, further: &[&str]) -> Option<Host> {
    let found = SANITIZERS.into_iter().find(|(w, _)| *w == word);
    let (_, option) = found.expect("a sanitizer");
    if let Err(why) = works(option) {
        skip(word, &why);
        return None;
    }
    let flags: Vec<&str> = LIBRARY
        .into_iter()
        .chain([option, STRICT])
        .chain(further.iter().copied())
        .collect();
    let toolchain = Toolchain::host().with_flags(&flags);
    Some(Host::with_flags(
        name,
        toolchain,
        &["-O0", "-g", option, STRICT],
    ))
}

/// Tries the sanitizer on a program that does nothing.
fn works(option: &str) -> Result<(), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("nothing.c");
    let program = folder.path().join("nothing");
    std::fs::write(&source, "int main(void) { return 0; }\n").expect("a file");
    let output = cc()
        .arg(option)
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .output();
    let output = output.map_err(|e| format!("cc: {e}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let line = said.lines().last().unwrap_or_default();
        return Err(format!("cc {option}: {line}"));
    }
    let ran = start(&program).output().map_err(|e| e.to_string())?;
    if ran.status.success() {
        Ok(())
    } else {
        let said = String::from_utf8_lossy(&ran.stderr);
        Err(said.lines().next().unwrap_or("it does not run").to_owned())
    }
}

/// `ThreadSanitizer` needs its memory at addresses that randomization may occupy, so that is
/// disabled where possible.
pub fn start(program: &Path) -> Command {
    let plain = |command: &mut Command| {
        command.env("TSAN_OPTIONS", "halt_on_error=1");
        command.env("UBSAN_OPTIONS", "print_stacktrace=1");
    };
    let mut fixed = Command::new("setarch");
    fixed.arg("-R");
    let works = Command::new("setarch").args(["-R", "true"]).output();
    let mut command = if works.is_ok_and(|o| o.status.success()) {
        fixed.arg(program);
        fixed
    } else {
        Command::new(program)
    };
    plain(&mut command);
    command
}

fn run(host: &Host, subject: &Subject) -> Finished {
    let prepared = Prepared::new(subject);
    let library = prepared.library(&host.toolchain);
    host.run_through(&prepared, &library, CALLS, start)
}

/// Machines of all kinds: tables, functions, operations that do not end, a single Moore machine.
fn passes(name: &str, word: &str) {
    let Some(host) = host(name, word, &[]) else {
        return;
    };
    let mut subjects = vec![
        named("AssemblyCell"),
        named("Belt"),
        as_functions(&named("QualityCheck")),
    ];
    subjects.extend(fixtures().into_iter().filter(|s| s.name() == "Jammed"));
    for subject in subjects {
        let finished = run(&host, &subject);
        let what = format!("{word}, {}: {}", subject.name(), finished.all());
        assert_eq!(finished.last_line(), PASSED, "{what}");
        assert!(finished.success && finished.errors.is_empty(), "{what}");
    }
}

#[test]
fn address_sanitizer_finds_nothing() {
    passes("host-asan", "asan");
}

#[test]
fn undefined_behaviour_sanitizer_finds_nothing() {
    passes("host-ubsan", "ubsan");
}

#[test]
fn thread_sanitizer_finds_nothing() {
    passes("host-tsan", "tsan");
}

#[test]
fn thread_sanitizer_finds_that_there_are_no_locks() {
    let Some(host) = host("host-tsan-no-locks", "tsan", &["-DLW_NO_LOCKS"]) else {
        return;
    };
    let finished = run(&host, &named("Printer"));
    assert!(
        finished.errors.contains("ThreadSanitizer: data race"),
        "{}",
        finished.all()
    );
    assert!(!finished.success && finished.last_line() != PASSED);
}

/// The other two detect their faults: an element beyond an array, and a sum that is too large.
#[test]
fn the_other_sanitizers_find_what_is_wrong() {
    let wrong = [
        (
            "asan",
            "AddressSanitizer",
            "volatile int32_t own[2] = {0, 0}; return own[2 + handle % 2];",
        ),
        (
            "ubsan",
            "runtime error",
            "volatile int32_t large = INT32_MAX; return large + 1;",
        ),
    ];
    for (word, said, body) in wrong {
        let Some(host) = host(&format!("host-{word}-wrong"), word, &[]) else {
            continue;
        };
        let prepared = Prepared::new(&named("Belt"));
        // Another function gets the name of one that the host calls.
        let source = format!(
            "#define lw_reset lw_reset_of_another_name\n{}#undef lw_reset\n\
             LW_EXPORT int32_t lw_reset(lw_handle handle);\n\
             int32_t lw_reset(lw_handle handle) {{ {body} }}\n",
            prepared.package.c_source,
        );
        let library = prepared.changed(&host.toolchain, source, word);
        let finished = host.run_through(&prepared, &library, 0, start);
        assert!(finished.errors.contains(said), "{word}: {}", finished.all());
        assert!(
            !finished.success && finished.last_line() != PASSED,
            "{word}"
        );
    }
}
