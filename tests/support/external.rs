//! Tools that a test may lack: how it reports that it is skipped, and which Python it uses.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;

/// Reports that a test cannot run because `what` is missing. It then counts as skipped in
/// `.ci/run`; if `LINEWRIGHT_REQUIRE` (a comma-separated list) names `what`, or `all`, it fails
/// instead.
pub fn skip(what: &str, why: &str) {
    let required = std::env::var("LINEWRIGHT_REQUIRE").unwrap_or_default();
    let mut required = required.split(',').map(str::trim);
    assert!(
        !required.any(|r| r == what || r == "all"),
        "{what} is required, but {why}"
    );
    // Not `eprintln!`: the test runner would capture that.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let _ = writeln!(std::io::stderr(), "\nskipped: {test}: {what}: {why}");
}

/// The Python that has a module: `LINEWRIGHT_PYTHON`, or else `python3` on the PATH. Without one
/// the test is skipped because `what` is missing.
pub fn python_with(what: &str, module: &str) -> Option<PathBuf> {
    let python = std::env::var_os("LINEWRIGHT_PYTHON").unwrap_or_else(|| "python3".into());
    let python = PathBuf::from(python);
    let imported = Command::new(&python)
        .args(["-c", &format!("import {module}")])
        .output();
    match imported {
        Ok(output) if output.status.success() => Some(python),
        Ok(_) => {
            let why = format!("{} has no module {module}", python.display());
            skip(what, &why);
            None
        }
        Err(error) => {
            skip(
                what,
                &format!("{} does not start: {error}", python.display()),
            );
            None
        }
    }
}
