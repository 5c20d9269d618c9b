//! The pages behind `linewright explain`: one Markdown file per code, embedded in the program.
//!
//! A page explains the finding to a reader who knows the plant but no temporal logic. It shows the
//! smallest contract with the finding and how to repair it. The example is a block fenced with
//! ```` ```lw LW103 ````; a test checks it and expects exactly that code. Findings that only occur
//! in other tools' files have an example in that format, fenced with the file extension:
//! ```` ```spc LW209 ````. A plain ```` ```lw ```` block is the repaired contract and must have no
//! findings. Examples that need a plant, a compiler or a folder are fenced as plain `console` text.

use super::Code;
use include_dir::{Dir, include_dir};

static PAGES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src/diagnostics/explanations");

/// Returns the page of a code, in Markdown.
pub fn page(code: Code) -> Option<&'static str> {
    PAGES
        .get_file(format!("{}.md", code.id))
        .and_then(|file| file.contents_utf8())
}

/// Returns the first paragraph of a page, after its title, as one line.
pub fn summary(page: &str) -> String {
    let mut paragraphs = page.split("\n\n").skip(1);
    let first = paragraphs.next().unwrap_or_default();
    first.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Renders a page for readers without Markdown: no title, examples indented.
pub fn plain(page: &str) -> String {
    let mut text = String::new();
    let mut example = false;
    for line in page.lines().skip(2) {
        if line.starts_with("```") {
            example = !example;
            continue;
        }
        let indent = if example && !line.is_empty() {
            "    "
        } else {
            ""
        };
        text.push_str(indent);
        text.push_str(if example {
            line
        } else {
            line.trim_start_matches("## ")
        });
        text.push('\n');
    }
    text
}

/// An example of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Example {
    /// File extension of the example, such as `lw`.
    pub extension: String,
    /// Code of the finding that the example has.
    pub code: String,
    /// Text of the contract.
    pub text: String,
}

/// Returns the examples of a page: its blocks fenced with a file extension and a code,
/// ```` ```lw CODE ````.
pub fn examples(page: &str) -> Vec<Example> {
    let mut examples = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some((extension, info)) = line.strip_prefix("```").and_then(|i| i.split_once(' '))
        else {
            continue;
        };
        let text: String = lines
            .by_ref()
            .take_while(|l| *l != "```")
            .flat_map(|l| [l, "\n"])
            .collect();
        examples.push(Example {
            extension: extension.to_owned(),
            code: info.trim().to_owned(),
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
                "{code}: the page does not begin with its title"
            );
        }
    }

    #[test]
    fn a_page_without_markdown() {
        let page = "# LW000: title\n\nOne `word`\nand more.\n\n```lw LW000\n# x\n\ny\n```\n\n## How to repair it\n\nSo.\n";
        assert_eq!(summary(page), "One `word` and more.");
        assert_eq!(
            plain(page),
            "One `word`\nand more.\n\n    # x\n\n    y\n\nHow to repair it\n\nSo.\n"
        );
    }

    #[test]
    fn every_page_has_a_code() {
        for file in PAGES.files() {
            let stem = file
                .path()
                .file_stem()
                .and_then(|s| s.to_str())
                .expect("names are UTF-8");
            assert!(codes::find(stem).is_some(), "there is no code {stem}");
        }
    }
}
