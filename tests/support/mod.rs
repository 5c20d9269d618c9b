//! Common support for tests: the built program, a folder to run it in, and a way to report skipped
//! tests.
#![allow(dead_code, unused_imports, reason = "each test file uses a part of it")]

pub mod assumed;
pub mod documents;
pub mod external;
pub mod games;
pub mod mesa;
pub mod programs;
pub mod wine;

pub use external::{python_with, skip};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The built program.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_linewright");

/// The top folder of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs the program in a folder, without colors.
pub fn linewright(folder: &Path, arguments: &[&str]) -> Output {
    linewright_with_cache(Path::new("off"), folder, arguments)
}

/// The same with a cache, for tests that do not depend on how controllers are found: `off`, or its
/// folder.
pub fn linewright_with_cache(cache: &Path, folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .env_remove("CLICOLOR_FORCE")
        .env("LINEWRIGHT_CACHE", cache)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts");
    documents::assert_valid(&output.stdout);
    output
}

/// A new folder with copies of `contracts` and `examples`, without build results.
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

/// The files with one of these extensions in a folder and its subfolders, in order.
pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    for entry in entries {
        let path = entry.expect("the folder can be read").path();
        let extension = path.extension().and_then(|e| e.to_str());
        if path.is_dir() {
            files.extend(files_below(&path, extensions));
        } else if extension.is_some_and(|e| extensions.contains(&e)) {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The Markdown files with a name in the repository, without sources and build results.
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

/// The public benchmark specifications, if they are in a folder beside the repository.
pub fn specs() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("LINEWRIGHT_SPECS")
        .map_or_else(|| root().join("../shared/bench/specs"), Into::into);
    if folder.is_dir() {
        return Some(folder);
    }
    skip(
        "specs",
        "the benchmark specifications are not beside the repository",
    );
    None
}

/// The files in which defects were found, if they exist: `LINEWRIGHT_FOUND`, or `../shared/found`
/// beside the repository.
pub fn found() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("LINEWRIGHT_FOUND")
        .map_or_else(|| root().join("../shared/found"), Into::into);
    if folder.is_dir() {
        return Some(folder);
    }
    skip(
        "found",
        "the folder of found defects is not beside the repository",
    );
    None
}
