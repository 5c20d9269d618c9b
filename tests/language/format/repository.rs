//! Every file of the repository.
//!
//! A case file may show exactly what the formatter would repair. So it is left as it is if it does
//! not parse, if its marker refers to the line above (`//~^`: it shows a finding that spans lines),
//! or if it spells an operator otherwise than in words (as the paper does). The rule is implemented
//! here from the text alone: a case with another layout for no such reason fails.

use super::{formatted, read};
use linewright::syntax::format;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file with this extension, as relative path and text.
fn files(ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = ["contracts", "examples", "tests", "docs", "src", "crates"]
        .iter()
        .map(|f| root().join(f))
        .collect();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path
                .strip_prefix(root())
                .expect("below")
                .to_string_lossy()
                .replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(ending) {
                found.push((name, std::fs::read_to_string(&path).expect("a text")));
            }
        }
    }
    found.sort();
    found
}

/// Whether an operator is not spelled in words.
fn other_spelling(text: &str) -> bool {
    let code: String = text
        .lines()
        .map(|l| l.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n");
    let signs = [
        '□', '◇', '◊', '○', '◯', '∧', '∨', '¬', '→', '↔', '⇒', '⇔', '≠', '≤', '≥', '&', '|', '~',
        '\'',
    ];
    let words = ["G", "F", "GF", "X", "O", "implies", "iff"];
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.contains(signs)
        || ["==", "=>", "<>", "[]"].iter().any(|s| code.contains(s))
        || code.replace("!=", "").contains('!')
        || code.split(|c| !is_word(c)).any(|w| words.contains(&w))
}

fn left_alone(name: &str, text: &str) -> bool {
    name.starts_with("tests/cases/") && (text.contains("//~^") || other_spelling(text))
}

/// A file that does not parse; only a case may.
fn broken(name: &str, text: &str) -> bool {
    let broken = !read(text).1.is_empty();
    assert!(
        !broken || name.starts_with("tests/"),
        "{name} does not parse"
    );
    broken
}

#[test]
fn every_file_is_formatted() {
    let mut report = Vec::new();
    let (mut looked_at, mut left) = (0, 0);
    for (name, text) in files(".lw") {
        if broken(&name, &text) {
            continue;
        }
        let formatted = formatted(&text);
        if left_alone(&name, &text) {
            left += 1;
        } else {
            looked_at += 1;
            if formatted != text {
                report.push(name);
            }
        }
    }
    assert!(
        report.is_empty(),
        "`linewright fmt` would change {report:#?}"
    );
    assert!(
        looked_at > 50 && left < 15,
        "{looked_at} looked at, {left} left alone"
    );
}

#[test]
fn every_example_in_the_texts_is_formatted() {
    let mut texts = files(".md");
    for name in ["README.md", "CHANGELOG.md", "ARCHITECTURE.md"] {
        let text = std::fs::read_to_string(root().join(name)).expect("a text");
        texts.push((name.to_owned(), text));
    }
    let (mut report, mut looked_at) = (Vec::new(), 0);
    for (name, text) in texts {
        for block in text.split("```lw").skip(1) {
            let (_, block) = block.split_once('\n').expect("a line");
            let block = block.split("```").next().unwrap_or_default();
            // An excerpt does not parse as a file, nor does the example of a syntax error.
            if !read(block).1.is_empty() || other_spelling(block) {
                continue;
            }
            looked_at += 1;
            let formatted = formatted(block);
            if formatted != block {
                report.push(format!("{name}:\n{block}\n-- becomes --\n{formatted}"));
            }
        }
    }
    assert!(report.is_empty(), "{}", report.join("\n"));
    assert!(looked_at > 20, "{looked_at} looked at");
}

/// The same files with their lines joined and split: the same tree and comments result, and lines
/// that fit.
#[test]
fn other_layouts_say_the_same() {
    for (name, text) in files(".lw") {
        if broken(&name, &text) {
            continue;
        }
        let joined: String = text
            .lines()
            .map(|l| {
                if l.contains("//") {
                    format!("{l}\n")
                } else {
                    format!("{} ", l.trim())
                }
            })
            .collect();
        let torn = text
            .lines()
            .map(|l| {
                if l.contains("//") || l.contains('"') || l.contains("import") {
                    l.to_owned()
                } else {
                    l.replace(' ', "\n")
                }
            })
            .collect::<Vec<_>>()
            .join("\n");
        for other in [joined, torn] {
            let (tree, findings) = read(&other);
            // A unit on the next line is no longer a unit.
            if !findings.is_empty() || tree != read(&text).0 {
                continue;
            }
            let formatted = formatted(&other);
            assert_eq!(read(&formatted).0, tree, "{name}");
            assert_eq!(
                format::comments(&formatted),
                format::comments(&text),
                "{name}"
            );
            let wide = formatted
                .lines()
                .find(|l| l.chars().count() > 135 && !l.contains("//"));
            assert_eq!(wide, None, "{name}");
        }
    }
}

/// Interesting inputs of the fuzzer are also formatted, if they parse.
#[test]
fn the_corpus_of_the_fuzzer_is_formatted() {
    let folder = root().join("tests/fuzz/corpus/lw");
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(path).unwrap_or_default();
        if read(&text).1.is_empty() {
            formatted(&text);
        }
    }
}
