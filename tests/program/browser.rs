//! Reports in a headless Chromium: no request, no error, nothing that axe-core finds, and all
//! controls work.

use crate::support::{PROGRAM, programs, root, sandbox, skip};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The folder of the Node packages that drive the browser: `LINEWRIGHT_BROWSER`. Without one, the
/// test is skipped.
fn modules() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LINEWRIGHT_BROWSER").map(PathBuf::from) else {
        skip(
            "browser",
            "LINEWRIGHT_BROWSER names no folder of Node packages",
        );
        return None;
    };
    let packages = ["puppeteer-core", "@sparticuz/chromium", "axe-core"];
    let missing = packages
        .iter()
        .find(|name| !folder.join("node_modules").join(name).is_dir());
    if let Some(name) = missing {
        let folder = folder.display();
        skip("browser", &format!("{folder} has no package {name}"));
        return None;
    }
    Some(folder)
}

/// Runs a line, and returns the path of its report.
fn report(folder: &Path, name: &str, arguments: &[&str]) -> PathBuf {
    let path = folder.join(format!("{name}.html"));
    let run = programs::run(
        Command::new(PROGRAM)
            .arg("run")
            .args(arguments)
            .arg("--report")
            .arg(&path)
            .current_dir(folder),
        Duration::from_mins(3),
    );
    assert!(path.is_file(), "{}", run.all());
    path
}

#[test]
fn reports_can_be_read_and_used_in_a_browser() {
    let Some(modules) = modules() else { return };
    let sandbox = sandbox();
    let folder = sandbox.path();
    let refused = root().join("tests/program/cli/refused_and_large.lw");
    std::fs::copy(refused, folder.join("refused.lw")).expect("a copy");
    let (laboratory, bottling) = ("examples/ice-lab/line.lw", "examples/bottling/line.lw");
    let pages = [
        report(folder, "laboratory", &[laboratory, "--parts", "50"]),
        report(folder, "day", &[bottling, "--until", "1d"]),
        report(folder, "violations", &["refused.lw", "--until", "1h"]),
        report(
            folder,
            "replications",
            &[
                bottling,
                "--until",
                "10h",
                "--warm-up",
                "7h",
                "--replications",
                "5",
            ],
        ),
        report(
            folder,
            "comparison",
            &[laboratory, "--parts", "20", "--what-if", "printer=10%"],
        ),
        report(
            folder,
            "batches",
            &[bottling, "--until", "2d", "--batches", "10"],
        ),
    ];
    let opened = programs::run(
        Command::new("node")
            .arg(root().join("tests/program/browser/open.mjs"))
            .arg(modules)
            .args(pages),
        Duration::from_mins(5),
    );
    assert!(opened.success, "{}", opened.all());
    assert_eq!(opened.output, "", "{}", opened.errors);
}
