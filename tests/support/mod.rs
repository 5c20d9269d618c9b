//! What several test files need: the built program, a folder to run it in, and a way to skip honestly.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The built program.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_linewright");

/// The top folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Says that a test cannot do its work because `what` is not there. It then counts as skipped in `.ci/run`; where
/// `LINEWRIGHT_REQUIRE` (a list with commas) names `what`, or `all`, it fails instead.
pub fn skip(what: &str, why: &str) {
    let required = std::env::var("LINEWRIGHT_REQUIRE").unwrap_or_default();
    let mut required = required.split(',').map(str::trim);
    assert!(
        !required.any(|r| r == what || r == "all"),
        "{what} is required, but {why}"
    );
    // Not `eprintln!`: the test runner would keep that to itself.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let _ = writeln!(std::io::stderr(), "\nskipped: {test}: {what}: {why}");
}

/// Runs the program in a folder, without colours.
pub fn linewright(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .env_remove("CLICOLOR_FORCE")
        .env("LINEWRIGHT_CACHE", "off")
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts")
}

/// A new folder with copies of `contracts` and `examples`, without what was built there.
pub fn sandbox() -> tempfile::TempDir {
    let sandbox = tempfile::tempdir().expect("a folder");
    for name in ["contracts", "examples"] {
        let from = root().join(name);
        if from.is_dir() {
            copy(&from, &sandbox.path().join(name));
        }
    }
    sandbox
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let (path, name) = (entry.path(), entry.file_name());
        if name.to_string_lossy().starts_with('.') {
            continue;
        }
        if path.is_dir() {
            copy(&path, &to.join(name));
        } else {
            std::fs::copy(&path, to.join(name)).expect("a copy");
        }
    }
}

/// The Markdown files of that name in the repository, sources and built files left out.
pub fn files_named(name: &str) -> Vec<PathBuf> {
    fn visit(folder: &Path, name: &str, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let own = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() {
                if !own.starts_with('.') && own != "target" && own != "src" {
                    visit(&path, name, found);
                }
            } else if own == name {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    visit(root(), name, &mut found);
    found.sort();
    found
}

/// Wine, with a prefix of its own.
pub struct Wine {
    program: PathBuf,
    prefix: PathBuf,
}

impl Wine {
    /// A Windows program under Wine. Its exit code is not to be trusted: what it prints is.
    pub fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command
            .arg(program)
            .env("WINEPREFIX", &self.prefix)
            .env("WINEDEBUG", "-all")
            .env_remove("DISPLAY");
        command
    }

    /// A file as Windows programs name it. Wine looks for relative ones in other places.
    pub fn path(file: &Path) -> String {
        format!("Z:{}", file.display().to_string().replace('/', "\\"))
    }
}

/// Wine for 64-bit programs, on the PATH or where Debian puts it; `None`, and a word about it, where it is not there.
pub fn wine() -> Option<Wine> {
    let on_path = std::env::var_os("PATH").unwrap_or_default();
    let places = std::env::split_paths(&on_path).map(|folder| folder.join("wine64"));
    let usual = ["/usr/lib/wine/wine64", "/opt/wine-stable/bin/wine64"].map(PathBuf::from);
    let Some(program) = places.chain(usual).find(|p| p.is_file()) else {
        skip(
            "wine",
            "there is no wine64 (Debian: apt-get install wine64)",
        );
        return None;
    };
    let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wine");
    std::fs::create_dir_all(&prefix).expect("a folder");
    Some(Wine { program, prefix })
}

/// MinGW's compiler for 64-bit Windows; `None`, and a word about it, where it is not there.
pub fn mingw() -> Option<String> {
    let compiler = "x86_64-w64-mingw32-gcc";
    if Command::new(compiler).arg("--version").output().is_ok() {
        return Some(compiler.to_owned());
    }
    skip(
        "mingw",
        "there is no x86_64-w64-mingw32-gcc (Debian: apt-get install gcc-mingw-w64-x86-64)",
    );
    None
}

/// A Python interpreter.
pub struct Python(String);

impl Python {
    /// A script of the repository.
    pub fn command(&self, script: &Path) -> Command {
        let mut command = Command::new(&self.0);
        command.arg(script).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    }
}

/// The Python that `LINEWRIGHT_PYTHON` names, else `python3`, if it has this package; `None`, and a word about it, where not.
pub fn python_with(package: &str) -> Option<Python> {
    let python = std::env::var("LINEWRIGHT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let trial = Command::new(&python)
        .args(["-c", &format!("import {package}")])
        .output();
    if trial.is_ok_and(|t| t.status.success()) {
        return Some(Python(python));
    }
    skip(
        package,
        &format!(
            "`{python}` has no package {package} (pip install {package}; LINEWRIGHT_PYTHON names another Python)"
        ),
    );
    None
}
