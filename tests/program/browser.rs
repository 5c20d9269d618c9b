//! Pages in a headless Chromium: no request, no error, nothing that axe-core finds, and all
//! controls work. A walk through a controller gives the values that `step` gives.

use crate::support::programs::{self, page};
use crate::support::{PROGRAM, root, sandbox, skip};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// How long the browser may take for all pages of a test, also on a slow and busy computer.
const PATIENCE: Duration = Duration::from_mins(15);

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
    let run = ["run"].into_iter().chain(arguments.iter().copied());
    let run: Vec<&str> = run.chain(["--report"]).collect();
    page(folder, name, &run)
}

#[test]
fn reports_can_be_read_and_used_in_a_browser() {
    let Some(modules) = modules() else { return };
    let sandbox = sandbox();
    let folder = sandbox.path();
    let refused = root().join("tests/program/cli/refused_and_large.lw");
    std::fs::copy(refused, folder.join("refused.lw")).expect("a copy");
    let dated = std::fs::read_to_string(root().join("examples/bottling/line.lw"));
    let dated = dated
        .expect("a line")
        .replace("    limit 7 d", "    start 2026-11-30\n    limit 7 d");
    std::fs::write(folder.join("dated.lw"), dated).expect("a line");
    let (laboratory, bottling) = ("examples/ice-lab/line.lw", "examples/bottling/line.lw");
    let pages = [
        report(folder, "laboratory", &[laboratory, "--parts", "50"]),
        report(folder, "day", &[bottling, "--until", "1d"]),
        report(folder, "dates", &["dated.lw"]),
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
            "variants",
            &[
                bottling,
                "--until",
                "10h",
                "--replications",
                "3",
                "--what-if",
                "fast: filler=10%",
                "--what-if",
                "large: infeed.capacity=80",
            ],
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
        PATIENCE,
    );
    assert!(opened.success, "{}", opened.all());
    assert_eq!(opened.output, "", "{}", opened.errors);
}

#[test]
fn pages_of_checks_and_plays_can_be_read_in_a_browser() {
    let Some(modules) = modules() else { return };
    let sandbox = sandbox();
    let folder = sandbox.path();
    let turn = "contracts/handling/turn.lw";
    let pages = [
        page(folder, "library", &["check", "contracts", "--report"]),
        page(
            folder,
            "line",
            &["check", "examples/ice-lab/line.lw", "--report"],
        ),
        page(
            folder,
            "clash",
            &["check", "examples/repair-me", "--report"],
        ),
        page(
            folder,
            "play",
            &["step", turn, "--script", "examples/step/turn.txt", "--html"],
        ),
    ];
    let opened = programs::run(
        Command::new("node")
            .arg(root().join("tests/program/browser/open.mjs"))
            .arg(modules)
            .args(pages),
        PATIENCE,
    );
    assert!(opened.success, "{}", opened.all());
    assert_eq!(opened.output, "", "{}", opened.errors);
}

const ANSWER: &str = "contract Answer {
    input request: bool
    output running: bool

    guarantee at_once: always (request -> running)
    guarantee rest: always (running -> not next running)
}
";

/// The values and their product are beyond the numbers that a script has exactly.
const LARGE: &str = "contract Large {
    const base = 9007199254740992
    input number: base * 3 + 1 .. base * 3 + 8
    output copy: base * 3 + 1 .. base * 3 + 8
    output odd: bool

    define same = next number = number

    assume changes: always not same
    guarantee copies: always (copy = number)
    guarantee oddness: always (odd <-> (number * 3) mod 2 = 1)
}
";

/// A controller with listed states, one as functions, a Moore machine, and counterstrategies of
/// both endings: the walk in each page has the values that `step` has.
#[test]
fn a_walk_gives_the_values_of_step() {
    let Some(modules) = modules() else { return };
    let sandbox = sandbox();
    let folder = sandbox.path();
    let inspect = std::fs::read_to_string(root().join("contracts/handling/inspect.lw"));
    let large = inspect.expect("a contract").replace("= 4)", "= 16)");
    std::fs::write(folder.join("large.lw"), large).expect("a contract");
    std::fs::write(folder.join("answer.lw"), ANSWER).expect("a contract");
    std::fs::write(folder.join("numbers.lw"), LARGE).expect("a contract");
    let walked = [
        ("table", "contracts/handling/turn.lw", false, 120),
        ("functions", "large.lw", false, 60),
        ("numbers", "numbers.lw", false, 30),
        ("moore", "examples/ice-lab/coordinator.lw", false, 120),
        ("clash", "answer.lw", true, 5),
        ("starved", "examples/repair-me/2-hold.lw", true, 40),
    ];
    let mut arguments: Vec<PathBuf> = Vec::new();
    for (name, contract, is_counter, steps) in walked {
        let mut command = vec!["synth", contract];
        command.extend(is_counter.then_some("--counterstrategy"));
        command.push("--report");
        arguments.push(page(folder, name, &command));
        // Some moves of `step` are refused, so the last commands may give nothing.
        let mut script = String::new();
        for _ in 0..steps {
            let _ = writeln!(script, "random 1");
        }
        let script_file = folder.join(format!("{name}.txt"));
        std::fs::write(&script_file, script).expect("a script");
        let played = programs::run(
            Command::new(PROGRAM)
                .args(["step", contract, "--format", "json", "--script"])
                .arg(&script_file)
                .current_dir(folder),
            PATIENCE,
        );
        let steps = folder.join(format!("{name}.jsonl"));
        std::fs::write(&steps, &played.output).expect("the steps");
        arguments.push(steps);
    }
    let opened = programs::run(
        Command::new("node")
            .arg(root().join("tests/program/browser/walk.mjs"))
            .arg(modules)
            .args(arguments),
        PATIENCE,
    );
    assert!(opened.success, "{}", opened.all());
    assert_eq!(opened.output, "", "{}", opened.errors);
}
