//! The READMEs match the program: every `console` block of every README.md is run, and every
//! example in the help.
//!
//! A file's blocks run one after the other in one folder with copies of `contracts` and `examples`.
//! In a block, `$ ` begins a command (for `sh`; `> ` continues it), `? 2` gives the exit code if it
//! is not 0, and the rest is the output, both streams together. In the output `[..]` stands for any
//! text within a line, and a line `...` for any number of lines. `cargo run --release --` is the
//! built program; `cargo test` and installation commands are not run. A block fenced with a file's
//! name (```` ```lw cell.lw ````) is written to that file first. trycmd supports none of shells,
//! cargo, and files, hence this small runner.

use crate::support;
use crate::support::files_below;
use clap::CommandFactory as _;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A step of a page.
#[derive(Debug, PartialEq, Eq)]
enum Step {
    /// Writes a file.
    File { name: String, text: String },
    /// Checks a file in which nothing may be found.
    Example { line: usize, text: String },
    /// Runs a command and compares what it prints.
    Run {
        line: usize,
        command: String,
        code: i32,
        output: Vec<String>,
    },
}

/// The steps of a Markdown text.
fn steps(text: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((start, line)) = lines.next() {
        let Some(info) = line.trim_start().strip_prefix("```") else {
            continue;
        };
        let block: Vec<(usize, &str)> = lines
            .by_ref()
            .take_while(|(_, l)| l.trim() != "```")
            .collect();
        let words: Vec<&str> = info.split_whitespace().collect();
        let text = || block.iter().flat_map(|(_, l)| [*l, "\n"]).collect();
        match words.as_slice() {
            ["console"] => steps.extend(commands(&block)),
            ["lw"] => steps.push(Step::Example {
                line: start + 1,
                text: text(),
            }),
            [_, name] if name.contains('.') => steps.push(Step::File {
                name: (*name).to_owned(),
                text: text(),
            }),
            _ => {}
        }
    }
    steps
}

fn commands(block: &[(usize, &str)]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    // Whether the exit code was given or the output has begun: then `> ` is output like any other.
    let mut complete = false;
    for (number, line) in block {
        if let Some(command) = line.strip_prefix("$ ") {
            steps.push(Step::Run {
                line: number + 1,
                command: command.to_owned(),
                code: 0,
                output: Vec::new(),
            });
            complete = false;
            continue;
        }
        let Some(Step::Run {
            command,
            code,
            output,
            ..
        }) = steps.last_mut()
        else {
            panic!("line {}: output without a command", number + 1);
        };
        if let (Some(more), true) = (line.strip_prefix("> "), !complete) {
            let _ = write!(command, "\n{more}");
        } else if let (Some(wanted), true) = (line.strip_prefix("? "), output.is_empty()) {
            complete = true;
            *code = wanted.trim().parse().expect("a number behind `? `");
        } else {
            complete = true;
            output.push((*line).to_owned());
        }
    }
    steps
}

/// Whether a test cannot run a command.
fn left_out(command: &str) -> bool {
    [
        "cargo test",
        "cargo build",
        "cargo bench",
        "cargo install",
        "git ",
        "apt",
        ".ci/run",
    ]
    .iter()
    .any(|start| command.starts_with(start))
}

/// Runs a command; returns its exit code and output.
fn shell(folder: &Path, command: &str) -> (i32, String) {
    let command = command.replace("cargo run --release -- ", "linewright ");
    let program = Path::new(support::PROGRAM).parent().expect("a folder");
    let path = format!(
        "{}:{}",
        program.display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let output = Command::new("sh")
        .args(["-c", &format!("exec 2>&1\n{command}")])
        .current_dir(folder)
        .env("PATH", path)
        .env("HOME", folder)
        .env("LINEWRIGHT_CACHE", folder.join(".cache"))
        .env("NO_COLOR", "1")
        .env_remove("CLICOLOR_FORCE")
        .output()
        .expect("sh starts");
    support::documents::assert_valid(&output.stdout);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code().unwrap_or(-1), text)
}

/// Whether a line says what a command is doing: printed only where that takes a while.
fn is_announcement(line: &str) -> bool {
    line.contains("is unrealizable") && line.contains("; looking for ")
}

/// Whether lines match a pattern with `[..]` and `...`.
fn matches(pattern: &[String], lines: &[&str]) -> bool {
    match pattern.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first.trim() == "..." => {
            (0..=lines.len()).any(|skipped| matches(rest, &lines[skipped..]))
        }
        Some((first, rest)) => lines
            .split_first()
            .is_some_and(|(line, more)| line_matches(first, line) && matches(rest, more)),
    }
}

fn line_matches(pattern: &str, line: &str) -> bool {
    let (pattern, mut line) = (pattern.trim_end(), line.trim_end());
    let pieces: Vec<&str> = pattern.split("[..]").collect();
    let Some((last, before)) = pieces.split_last() else {
        return line.is_empty();
    };
    for (i, piece) in before.iter().enumerate() {
        let found = if i == 0 {
            line.starts_with(piece).then_some(0)
        } else {
            line.find(piece)
        };
        let Some(at) = found else {
            return false;
        };
        line = &line[at + piece.len()..];
    }
    if before.is_empty() {
        line == *last
    } else {
        line.ends_with(last)
    }
}

/// Faults in a README; empty if there are none.
fn run(text: &str, folder: &Path) -> (usize, String) {
    let (mut runs, mut report) = (0, String::new());
    for step in steps(text) {
        match step {
            Step::File { name, text } => {
                let path = folder.join(name);
                let parent = path.parent().expect("a file in a folder");
                std::fs::create_dir_all(parent).expect("a folder");
                std::fs::write(path, text).expect("a file");
            }
            Step::Example { line, text } => {
                runs += 1;
                std::fs::write(folder.join("example.lw"), text).expect("a file");
                let (code, found) = shell(folder, "linewright check example.lw --format short");
                if code != 0 || found.contains("warning[") || found.contains("note[") {
                    let _ = writeln!(report, "line {line}: the example has findings\n{found}");
                }
            }
            Step::Run {
                line,
                command,
                code,
                output,
            } => {
                if left_out(&command) {
                    continue;
                }
                runs += 1;
                let (got_code, got) = shell(folder, &command);
                let lines: Vec<&str> = got.lines().filter(|l| !is_announcement(l)).collect();
                let wanted: Vec<String> = trimmed(&output);
                if got_code != code || !matches(&wanted, trim_lines(&lines)) {
                    let _ = writeln!(
                        report,
                        "line {line}: $ {command}\n--- wanted (exit code {code})\n{}\n--- got (exit code {got_code})\n{got}",
                        output.join("\n")
                    );
                }
            }
        }
    }
    (runs, report)
}

fn trimmed(lines: &[String]) -> Vec<String> {
    let texts: Vec<&str> = lines.iter().map(String::as_str).collect();
    trim_lines(&texts).iter().map(|l| (*l).to_owned()).collect()
}

/// Removes empty lines at the beginning and the end.
fn trim_lines<'a, 'b>(lines: &'a [&'b str]) -> &'a [&'b str] {
    let start = lines.iter().position(|l| !l.trim().is_empty());
    let end = lines.iter().rposition(|l| !l.trim().is_empty());
    match (start, end) {
        (Some(start), Some(end)) => &lines[start..=end],
        _ => &[],
    }
}

/// All pages whose blocks are run. The examples of findings have a test of their own.
fn pages() -> Vec<PathBuf> {
    let mut pages = support::files_named("README.md");
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let findings = docs.join("reference/findings");
    let of_book = files_below(&docs, &["md"]).into_iter();
    pages.extend(of_book.filter(|page| !page.starts_with(&findings)));
    pages
}

#[test]
fn every_console_block_is_true() {
    let results: Vec<(usize, String)> = pages()
        .par_iter()
        .map(|file| {
            let text = std::fs::read_to_string(file).expect("a text");
            let sandbox = support::sandbox();
            let (count, wrong) = run(&text, sandbox.path());
            let report = if wrong.is_empty() {
                wrong
            } else {
                format!("{}\n{wrong}", file.display())
            };
            (count, report)
        })
        .collect();
    let report: String = results.iter().map(|(_, report)| report.as_str()).collect();
    assert!(report.is_empty(), "{report}");
    let runs: usize = results.iter().map(|(count, _)| count).sum();
    assert!(runs > 100, "the pages show {runs} commands");
}

#[test]
fn every_example_of_the_help_runs() {
    fn collect(command: &clap::Command, found: &mut Vec<String>) {
        let help = command.get_after_help().map(ToString::to_string);
        for line in help.unwrap_or_default().lines() {
            if let Some(example) = line.strip_prefix("    ")
                && example.starts_with("linewright ")
            {
                found.push(example.to_owned());
            }
        }
        command.get_subcommands().for_each(|c| collect(c, found));
    }
    let mut examples = Vec::new();
    collect(&linewright::cli::Arguments::command(), &mut examples);
    assert!(examples.len() >= 10, "{examples:?}");
    let sandbox = support::sandbox();
    for example in examples {
        let (code, text) = shell(sandbox.path(), &example);
        assert_eq!(code, 0, "{example}\n{text}");
    }
}

#[test]
fn steps_are_read() {
    let text = "text\n```lw a/b.lw\ncontract\n```\n```console\n$ one\nout\n\n$ two \\\n> more\n? 2\n> out\n```\n```lw\nno name\n```\n";
    let run = |line, command: &str, code, output: &[&str]| Step::Run {
        line,
        command: command.to_owned(),
        code,
        output: output.iter().map(|l| (*l).to_owned()).collect(),
    };
    let file = Step::File {
        name: "a/b.lw".to_owned(),
        text: "contract\n".to_owned(),
    };
    assert_eq!(
        steps(text),
        [
            file,
            run(6, "one", 0, &["out", ""]),
            run(9, "two \\\nmore", 2, &["> out"]),
            Step::Example {
                line: 14,
                text: "no name\n".to_owned()
            },
        ]
    );
}

#[test]
fn elisions_match_and_nothing_else() {
    for (pattern, line, wanted) in [
        ("a", "a", true),
        ("a", "ab", false),
        ("a [..] s", "a 0.01 s", true),
        ("a [..] s", "a 0.01 m", false),
        ("[..]b", "ab", true),
        ("a[..]", "ab", true),
        ("a[..]", "ba", false),
        ("a[..]a", "a", false),
    ] {
        assert_eq!(line_matches(pattern, line), wanted, "{pattern} {line}");
    }
    let all = |p: &[&str], l: &[&str]| {
        let p: Vec<String> = p.iter().map(|s| (*s).to_owned()).collect();
        matches(&p, l)
    };
    assert!(all(&["a", "...", "d"], &["a", "b", "c", "d"]));
    assert!(all(&["...", "d"], &["d"]));
    assert!(!all(&["a", "...", "d"], &["a", "b"]));
    assert!(!all(&[], &["a"]));
}

#[test]
fn a_wrong_readme_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "```console\n$ echo one\ntwo\n$ false\n$ echo right\nright\n```\n";
    let (runs, report) = run(text, folder.path());
    assert_eq!(runs, 3);
    assert!(report.contains("line 2: $ echo one"));
    assert!(report.contains("line 4: $ false"));
    assert!(!report.contains("line 5"));
}
