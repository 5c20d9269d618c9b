//! What pages have in common: sections, tables, tiles, pictures, and where a result comes from.

use super::numbers;
pub use super::numbers::{figure, time_marks};
use base64::Engine as _;
use linewright_core::diagnostics::Diagnostic;
use linewright_core::diagnostics::json::{self, Finding, Place};
use linewright_core::source::SourceMap;
use maud::{Markup, html};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// A count with groups of three digits: `1,632,096`.
pub fn figures(number: usize) -> String {
    numbers::count(number as u64)
}

/// A count of something: `1 state`, `1,632,096 states`.
pub fn count(number: usize, what: &str) -> String {
    format!(
        "{} {what}{}",
        figures(number),
        if number == 1 { "" } else { "s" }
    )
}

/// A section with its heading.
pub fn section(id: &str, heading: &str, inside: &Markup) -> Markup {
    section_of(id, heading, None, inside)
}

/// A section whose heading has a note: what it is about, where that is not the whole page.
pub fn section_of(id: &str, heading: &str, note: Option<&str>, inside: &Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby=(format!("{id}-heading")) {
            h2 id=(format!("{id}-heading")) { (heading) @if let Some(note) = note { " " span.of { (note) } } }
            (inside)
        }
    }
}

/// Links to the sections: id and name of each.
pub fn links<'a>(sections: impl IntoIterator<Item = (&'a str, &'a str)>) -> Markup {
    html! {
        nav aria-label="Sections" { @for (id, name) in sections {
            a href=(format!("#{id}")) { (name) }
        } }
    }
}

/// A figure with its name and a note.
pub fn tile(name: &str, value: &str, note: &str) -> Markup {
    html! {
        div.tile { dt { (name) } dd { (value) } dd.note { (note) } }
    }
}

/// A table that is shown on demand, such as the one behind a chart.
pub fn behind(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        details {
            summary { "Show as a table" }
            (table(headings, rows))
        }
    }
}

/// A table. The first column names the rows; others that hold numbers are aligned on the right.
pub fn table(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    let is_number = |column: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(column));
        cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
    };
    let class = |column: usize| (column > 0 && is_number(column)).then_some("number");
    html! {
        div.scroll tabindex="0" role="group" aria-label="Table" {
            table {
                thead { tr { @for (column, heading) in headings.iter().enumerate() {
                    th scope="col" class=[class(column)] { (heading) }
                } } }
                tbody { @for row in rows { tr { @for (column, cell) in row.iter().enumerate() {
                    @if column == 0 { th scope="row" { (cell) } } @else { td class=[class(column)] { (cell) } }
                } } } }
            }
        }
    }
}

/// A table whose rows are given as elements.
pub fn table_of(label: &str, headings: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll tabindex="0" role="group" aria-label=(label) {
            table {
                thead { tr { @for heading in headings { th scope="col" { (heading) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A drawing that is an SVG document, with a text for those who do not see it. It is not larger
/// than it was drawn, and can be scrolled if the page is narrow.
pub fn drawing(svg: &str, text: &str) -> Markup {
    let encoded = base64::engine::general_purpose::STANDARD.encode(svg);
    html! {
        div.scroll.drawing tabindex="0" role="group" aria-label="Drawing" {
            img src=(format!("data:image/svg+xml;base64,{encoded}")) alt=(text);
        }
    }
}

/// Where a result comes from, so that it can be had again.
#[derive(Debug, Clone, Copy)]
pub struct Origin<'a> {
    /// Command that makes the result again.
    pub command: &'a str,
    /// Version of the program.
    pub version: &'a str,
    /// All files that were read.
    pub sources: &'a SourceMap,
    /// The findings.
    pub findings: &'a [Diagnostic],
}

/// The section that tells how to get the result again: the command, the version, a hash, further
/// values by name, more elements, the findings, and the text of all files.
pub fn origin(heading: &str, of: &Origin<'_>, more: &[(&str, String)], inside: &Markup) -> Markup {
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![row("Version", format!("linewright {}", of.version))];
    rows.extend(more.iter().map(|(name, value)| row(name, value.clone())));
    rows.push(row("Hash of the files (SHA-256)", hash(of.sources)));
    let inside = html! {
        p { "The command that gives this result:" }
        pre tabindex="0" { code { (of.command) } }
        (table(&["What", "Value"], &rows))
        (inside)
        @if !of.findings.is_empty() {
            h3 { "Findings" }
            (findings(of.sources, &json::findings(of.sources, of.findings)))
        }
        h3 { "Files" }
        @for (_, file) in of.sources.files() {
            details {
                summary { (file.name) }
                pre tabindex="0" { code { (&*file.text) } }
            }
        }
    };
    section("model", heading, &inside)
}

/// Findings, each with the line that it is about.
pub fn findings(sources: &SourceMap, findings: &[Finding]) -> Markup {
    html! {
        @for finding in findings { div class=(format!("finding {}", finding.severity)) {
            p { strong { (finding.severity) " " (finding.code) } ": " (with_code(&finding.message)) }
            @if let Some(place) = &finding.span { (located(sources, place, "")) }
            @for label in &finding.labels { (located(sources, &label.span, &label.text)) }
            @for note in &finding.notes { pre tabindex="0" { (note) } }
            @if let Some(help) = &finding.help { (help_lines(help)) }
        } }
    }
}

/// Signs of formulas, of which those that contain others come first. A browser would break them.
const SIGNS: [&str; 5] = ["<->", "->", "<=", ">=", "!="];

/// A formula as code.
pub fn formula(text: &str) -> Markup {
    html! { code { (unbroken(text)) } }
}

/// A text in which no line ends within a sign such as `->`, which would read as `-` and `>`.
pub fn unbroken(text: &str) -> Markup {
    let mut pieces: Vec<(&str, &str)> = Vec::new();
    let mut rest = text;
    loop {
        let signs = SIGNS
            .iter()
            .filter_map(|sign| Some((rest.find(sign)?, sign)));
        // Of signs at the same place, the first.
        let Some((at, sign)) = signs.min_by_key(|(at, _)| *at) else {
            break;
        };
        let end = at + sign.len();
        pieces.push((&rest[..at], &rest[at..end]));
        rest = &rest[end..];
    }
    html! { @for (before, sign) in pieces { (before) span.sign { (sign) } } (rest) }
}

/// Names, of which long ones may be broken behind an underscore.
pub fn names(text: &str) -> Markup {
    /// Number of characters from which on a word is long.
    const LONG: usize = 20;
    html! {
        @for (number, word) in text.split(' ').enumerate() {
            @if number > 0 { " " }
            @if word.chars().count() < LONG { (word) } @else {
                @for piece in word.split_inclusive('_') { (piece) @if piece.ends_with('_') { wbr; } }
            }
        }
    }
}

/// A text in which what stands between backticks is code.
pub fn with_code(text: &str) -> Markup {
    let is_balanced = text.matches('`').count().is_multiple_of(2);
    html! {
        @if is_balanced {
            @for (index, piece) in text.split('`').enumerate() {
                @if index % 2 == 1 { (formula(piece)) } @else { (piece) }
            }
        } @else { (text) }
    }
}

/// The help of a finding, each line on its own. Lines to write into a file are indented.
fn help_lines(help: &str) -> Markup {
    html! {
        @for (number, line) in help.lines().enumerate() {
            p.help.indented[line.starts_with(' ')] {
                @if number == 0 { "Help: " }
                @if line.starts_with(' ') { (formula(line.trim())) } @else { (with_code(line)) }
            }
        }
    }
}

/// A place in a file with its first line, and a remark on it.
fn located(sources: &SourceMap, place: &Place, remark: &str) -> Markup {
    let file = sources.files().find(|(_, file)| file.name == place.file);
    let line = file.and_then(|(_, file)| file.text.lines().nth(place.line.checked_sub(1)?));
    html! {
        p.place {
            (place.file) ":" (place.line)
            @if !remark.is_empty() { ", " (with_code(remark)) }
            @if let Some(line) = line { br; (formula(line.trim())) }
        }
    }
}

/// SHA-256 of the names and texts of all files, in hexadecimal digits.
fn hash(sources: &SourceMap) -> String {
    let mut hash = Sha256::new();
    for (_, file) in sources.files() {
        // The lengths keep a name from running into a text.
        hash.update((file.name.len() as u64).to_le_bytes());
        hash.update(&file.name);
        hash.update((file.text.len() as u64).to_le_bytes());
        hash.update(file.text.as_bytes());
    }
    let digest = hash.finalize();
    digest.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_of_a_help_stands_on_its_own() {
        let mut sources = SourceMap::default();
        let file = sources.add("a.lw", "contract A {\n}\n");
        let span = linewright_core::source::Span::new(file, 9, 10);
        let code = linewright_core::diagnostics::codes::UNREALIZABLE;
        let finding = Diagnostic::error(code, span, "no controller keeps `A`")
            .with_help("add one of these:\n    assume p\n    assume q");
        let shown = findings(&sources, &json::findings(&sources, &[finding])).into_string();
        for wanted in [
            "no controller keeps <code>A</code>",
            "<p class=\"help\">Help: add one of these:</p>",
            "<p class=\"help indented\"><code>assume p</code></p>",
            "<p class=\"help indented\"><code>assume q</code></p>",
        ] {
            assert!(shown.contains(wanted), "{wanted} in {shown}");
        }
    }

    #[test]
    fn signs_are_not_broken() {
        let shown = formula("a -> b <-> (c >= d - 1)").into_string();
        let wanted = "<code>a <span class=\"sign\">-&gt;</span> b <span class=\"sign\">&lt;-&gt;</span> (c <span class=\"sign\">&gt;=</span> d - 1)</code>";
        assert_eq!(shown, wanted);
    }

    #[test]
    fn long_names_may_be_broken() {
        let shown = names("a_b: takes_what_is_offered, c").into_string();
        assert_eq!(shown, "a_b: takes_<wbr>what_<wbr>is_<wbr>offered, c");
    }

    #[test]
    fn counts_have_groups_of_digits() {
        assert_eq!(count(1_632_096, "state"), "1,632,096 states");
        assert_eq!(count(1, "state"), "1 state");
        assert_eq!(with_code("a ` b").into_string(), "a ` b");
    }
}
