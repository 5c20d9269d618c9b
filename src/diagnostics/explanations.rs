//! The pages behind `linewright explain`: one Markdown file a code, embedded in the program.
//!
//! A page says what the finding means to somebody who knows the plant and no temporal logic, shows the smallest
//! contract that has it, and how to repair that. The example is a block fenced with ```` ```lw LW103 ````: a test checks it and
//! wants that very code. What only other tools' files show stands in one of those, fenced with its ending: ```` ```spc LW209 ````. A block fenced with ```` ```lw LW103 later ```` is for a check that does not exist yet; the test wants it
//! to find nothing, so that the word goes when the check comes. What needs a plant, a compiler or a folder to happen is fenced as plain `console` text instead.

use super::Code;
use include_dir::{Dir, include_dir};

static PAGES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src/diagnostics/explanations");

/// The page of a code, in Markdown.
pub fn page(code: Code) -> Option<&'static str> {
    PAGES
        .get_file(format!("{}.md", code.id))
        .and_then(|file| file.contents_utf8())
}

/// An example of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Example {
    /// The ending of a file that holds it: `lw`.
    pub ending: String,
    /// The code it shows.
    pub code: String,
    /// Whether nothing looks for it yet.
    pub later: bool,
    /// The contract.
    pub text: String,
}

/// The examples of a page: its blocks fenced with the ending of a file and a code, ```` ```lw CODE ````.
pub fn examples(page: &str) -> Vec<Example> {
    let mut examples = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some((ending, info)) = line.strip_prefix("```").and_then(|i| i.split_once(' ')) else {
            continue;
        };
        let (code, later) = match info.trim().split_once(' ') {
            Some((code, word)) => (code, word == "later"),
            None => (info.trim(), false),
        };
        let text: String = lines
            .by_ref()
            .take_while(|l| *l != "```")
            .flat_map(|l| [l, "\n"])
            .collect();
        examples.push(Example {
            ending: ending.to_owned(),
            code: code.to_owned(),
            later,
            text,
        });
    }
    examples
}

#[cfg(test)]
mod tests {
    use super::super::codes;
    use super::*;

    #[test]
    fn every_code_has_a_page_that_opens_with_its_title() {
        for code in codes::ALL {
            let page = page(*code).unwrap_or_else(|| panic!("{code} has no page"));
            let heading = format!("# {code}: {}\n", code.title);
            assert!(
                page.starts_with(&heading),
                "{code}: the page opens otherwise"
            );
        }
    }

    #[test]
    fn every_page_has_a_code() {
        for file in PAGES.files() {
            let stem = file.path().file_stem().and_then(|s| s.to_str());
            let stem = stem.expect("names are UTF-8");
            assert!(codes::find(stem).is_some(), "{stem} is no code");
        }
    }

    #[test]
    fn every_page_says_how_to_repair_and_shows_an_example() {
        for code in codes::ALL {
            let page = page(*code).unwrap_or_default();
            assert!(page.contains("\n## How to repair it\n"), "{code}");
            let shown = examples(page);
            assert!(
                shown.iter().any(|e| e.code == code.id) || page.contains("\n```console\n"),
                "{code}: neither a contract nor a console shows it"
            );
            for example in shown {
                assert_eq!(example.code, code.id, "an example of another code");
            }
        }
    }
}
