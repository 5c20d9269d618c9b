//! Formatting rules of CONTRIBUTING.md that no tool checks.

use super::support::files_below;
use std::fmt::Write as _;
use std::path::Path;

/// Maximum width of a comment, in characters and with its indentation.
const WIDTH: usize = 100;

/// Lines of a source with a comment that is too wide, with their numbers. Tables, indented text and
/// fenced text are exempt.
fn wide_comments(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut wide = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let Some(comment) = line.trim_start().strip_prefix("//") else {
            fenced = false;
            continue;
        };
        let words = comment.trim_start_matches(['/', '!']);
        let fence = words.trim_start();
        if fence.starts_with("```") && !fence.starts_with("````") {
            fenced = !fenced;
        }
        let as_it_is = fenced || words.trim_start().starts_with('|') || words.starts_with("     ");
        if !as_it_is && line.chars().count() > WIDTH {
            wide.push((number, line));
        }
    }
    wide
}

/// Lines of a C source with a comment that is too wide, with their numbers. Indented text is
/// exempt.
fn wide_c_comments(text: &str) -> Vec<(usize, &str)> {
    let mut inside = false;
    let mut wide = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let opens = line.contains("/*");
        let as_it_is = inside && line.trim_start().starts_with("*    ");
        if (opens || inside) && !as_it_is && line.chars().count() > WIDTH {
            wide.push((number, line));
        }
        inside = match (line.rfind("/*"), line.rfind("*/")) {
            (Some(open), Some(close)) => open > close,
            (Some(_), None) => true,
            (None, Some(_)) => false,
            (None, None) => inside,
        };
    }
    wide
}

#[test]
fn comments_wrap() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wide = String::new();
    for folder in ["src", "crates", "tests", "examples"] {
        for path in files_below(&root.join(folder), &["rs", "pest"]) {
            let text = std::fs::read_to_string(&path).expect("sources can be read");
            for (number, line) in wide_comments(&text) {
                let place = path.strip_prefix(root).unwrap_or(&path).display();
                let _ = writeln!(wide, "{place}:{number}: {line}");
            }
        }
    }
    for path in files_below(&root.join("ffi"), &["c", "h"]) {
        let text = std::fs::read_to_string(&path).expect("sources can be read");
        for (number, line) in wide_c_comments(&text) {
            let place = path.strip_prefix(root).unwrap_or(&path).display();
            let _ = writeln!(wide, "{place}:{number}: {line}");
        }
    }
    assert!(
        wide.is_empty(),
        "comments of more than {WIDTH} columns:\n{wide}"
    );
}

/// Ways of speaking that say less than a noun: "Maximum number of states", not "so many states".
const MANNERED: [&str; 3] = ["told", "so many", "so much"];

/// The lines whose comment has one of these ways of speaking, with their numbers.
fn mannered_comments(text: &str) -> Vec<(usize, &str)> {
    let speaks = |line: &str| {
        let words: Vec<String> = line
            .split(|c: char| !c.is_alphanumeric())
            .map(str::to_lowercase)
            .collect();
        let spoken = format!(" {} ", words.join(" "));
        MANNERED
            .iter()
            .any(|phrase| spoken.contains(&format!(" {phrase} ")))
    };
    let lines = (1..).zip(text.lines());
    lines
        .filter(|(_, line)| line.trim_start().starts_with("//") && speaks(line))
        .collect()
}

#[test]
fn comments_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = String::new();
    for folder in ["src", "crates", "examples"] {
        for path in files_below(&root.join(folder), &["rs", "pest"]) {
            let text = std::fs::read_to_string(&path).expect("sources can be read");
            for (number, line) in mannered_comments(&text) {
                let place = path.strip_prefix(root).unwrap_or(&path).display();
                let _ = writeln!(found, "{place}:{number}: {line}");
            }
        }
    }
    assert!(found.is_empty(), "comments with {MANNERED:?}:\n{found}");
    assert_eq!(
        mannered_comments("// It may have so many.\nlet told = 1;\n").len(),
        1
    );
}

#[test]
fn wide_comments_are_found() {
    let long = "word ".repeat(30);
    let found = |text: &str| wide_comments(text).len();
    assert_eq!(found(&format!("    // {long}")), 1);
    assert_eq!(found(&format!("/// {long}\n//! {long}")), 2);
    assert_eq!(found(&format!("let a = \"{long}\";")), 0);
    assert_eq!(found(&format!("/// | {long} |")), 0);
    assert_eq!(found(&format!("/// ```text\n/// {long}\n/// ```")), 0);
    assert_eq!(found(&format!("/// ```\n/// a\n/// ```\n/// {long}")), 1);

    let found = |text: &str| wide_c_comments(text).len();
    assert_eq!(found(&format!("/* {long} */\nint a; /* {long} */")), 2);
    assert_eq!(found(&format!("/* a\n * {long}\n *     {long} */")), 1);
    assert_eq!(found(&format!("/* a */\ncall(\"{long}\");")), 0);
}

/// What the cache of solved contracts returns costs nothing, so a bench must not use it, except the
/// one that measures what it is worth.
#[test]
fn benches_do_not_use_the_cache() {
    let mut programs = 0;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench");
    for path in files_below(&folder, &["rs"]) {
        let text = std::fs::read_to_string(&path).expect("sources can be read");
        if !text.contains("CARGO_BIN_EXE_linewright") || path.ends_with("edits.rs") {
            continue;
        }
        programs += 1;
        let without =
            text.contains("\"LINEWRIGHT_CACHE\", \"off\"") || text.contains("\"--no-cache\"");
        assert!(without, "{} uses the cache", path.display());
    }
    assert!(programs > 2, "only {programs} benches start the program");
}
