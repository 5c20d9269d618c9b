//! Findings as text for people: with source lines ([`human`]) or one line each ([`short`]).
//!
//! `human` uses annotate-snippets to produce the layout of rustc: readers know it, and editors
//! recognise the places in it. Its output is always coloured; the caller strips the colours where
//! necessary (anstream). `short` is for build logs and editors' problem matchers:
//! `file:line:column: severity[code]: message`.

use super::{Diagnostic, Severity};
use crate::source::{FileId, SourceMap, Span};
use annotate_snippets::{AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet};
use std::fmt::Write as _;
use std::ops::Range;

/// Line width in columns, wide enough for the contracts of the library. Longer lines are cut around
/// the marked part.
const WIDTH: usize = 120;
/// Maximum length of a displayed line, in bytes. The renderer searches the whole line for each
/// finding, so longer lines would be slow.
const MAX_LINE_LENGTH: usize = 4_000;

/// Sorts findings by file name and place. Findings without a place come last, in their original
/// order.
pub fn sorted<'a>(sources: &SourceMap, findings: &'a [Diagnostic]) -> Vec<&'a Diagnostic> {
    let mut sorted: Vec<&Diagnostic> = findings.iter().collect();
    sorted.sort_by_cached_key(|d| {
        let place = d
            .span
            .map(|s| (sources.file(s.file).name.clone(), s.start, s.end));
        (place.is_none(), place, d.span.map(|_| d.code))
    });
    sorted
}

/// Renders findings with their source lines, labels and next steps, in colour, each followed by an
/// empty line.
pub fn human(sources: &SourceMap, findings: &[Diagnostic]) -> String {
    let renderer = Renderer::styled().term_width(WIDTH);
    let mut text = String::new();
    for finding in sorted(sources, findings) {
        let report = [group(sources, finding)];
        text.push_str(&renderer.render(&report));
        text.push_str("\n\n");
    }
    text
}

/// Renders findings, one line each: `file:line:column: error[LW101]: message`.
pub fn short(sources: &SourceMap, findings: &[Diagnostic]) -> String {
    let mut text = String::new();
    for finding in sorted(sources, findings) {
        if let Some(span) = finding.span {
            let start = sources.start(span);
            let name = &sources.file(span.file).name;
            let _ = write!(text, "{name}:{}:{}: ", start.line, start.column);
        }
        let _ = writeln!(
            text,
            "{}[{}]: {}",
            finding.severity.word(),
            finding.code,
            one_line(&finding.message)
        );
    }
    text
}

/// Renders one finding: title, one snippet per file, help.
fn group<'a>(sources: &'a SourceMap, finding: &'a Diagnostic) -> Group<'a> {
    let level = match finding.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let mut group = level
        .primary_title(finding.message.as_str())
        .id(finding.code.id)
        .elements(snippets(sources, finding));
    for note in &finding.notes {
        group = group.element(Level::NOTE.message(note.as_str()));
    }
    if let Some(help) = &finding.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    group
}

/// Returns one snippet per file: first the file of the finding's own place, then the files of its
/// labels, in order. If a line is too long, the snippet shows only the file name and the position.
fn snippets<'a>(sources: &'a SourceMap, finding: &'a Diagnostic) -> Vec<Element<'a>> {
    let mut files: Vec<FileId> = Vec::new();
    let places = finding
        .span
        .iter()
        .chain(finding.labels.iter().map(|l| &l.0));
    for span in places {
        if !files.contains(&span.file) {
            files.push(span.file);
        }
    }
    files
        .into_iter()
        .map(|id| {
            let file = sources.file(id);
            let places = finding.span.into_iter();
            let places = places.chain(finding.labels.iter().map(|l| l.0));
            let places = places.filter(|s| s.file == id);
            let lines = sources.lines(places.clone());
            if longest(&file.text[lines.clone()]) > MAX_LINE_LENGTH {
                let origin = Origin::path(file.name.as_str());
                return match places.map(|s| sources.start(s)).next() {
                    Some(start) => origin.line(start.line).char_column(start.column).into(),
                    None => origin.into(),
                };
            }
            let range = |span| {
                let range = range(&file.text, span);
                range.start - lines.start..range.end - lines.start
            };
            let own = finding
                .span
                .filter(|s| s.file == id)
                .map(|s| AnnotationKind::Primary.span(range(s)));
            let labels = finding
                .labels
                .iter()
                .filter(|l| l.0.file == id)
                .map(|l| AnnotationKind::Context.span(range(l.0)).label(l.1.as_str()));
            Snippet::source(&file.text[lines.clone()])
                .line_start(sources.position(id, lines.start as u32).line)
                .path(file.name.as_str())
                .annotations(own.into_iter().chain(labels))
                .into()
        })
        .collect()
}

/// Returns the length of the longest line, in bytes.
fn longest(text: &str) -> usize {
    text.lines().map(str::len).max().unwrap_or_default()
}

/// Returns a span as a range within the text, on character boundaries; the renderer would panic on
/// other offsets. Trailing white space, which a grammar rule can include, is excluded.
fn range(text: &str, span: Span) -> Range<usize> {
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = boundary(span.start as usize);
    let end = boundary(span.end as usize).max(start);
    start..start + text[start..end].trim_end().len()
}

/// Joins a message into one line, for the formats with one line per finding.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::super::{codes, sample};
    use super::*;

    /// Renders findings with `human` and strips the colours.
    fn plain(sources: &SourceMap, findings: &[Diagnostic]) -> String {
        anstream::adapter::strip_str(&human(sources, findings)).to_string()
    }

    #[test]
    fn human_shows_source_labels_and_next_step() {
        let (sources, findings) = sample::findings();
        insta::assert_snapshot!(sample::with_sources(&sources, &plain(&sources, &findings)));
    }

    #[test]
    fn short_has_one_line_per_finding() {
        let (sources, findings) = sample::findings();
        insta::assert_snapshot!(sample::with_sources(&sources, &short(&sources, &findings)));
    }

    #[test]
    fn human_is_coloured_and_the_colours_can_be_stripped() {
        let (sources, findings) = sample::findings();
        assert!(human(&sources, &findings).contains('\u{1b}'));
        assert!(!plain(&sources, &findings).contains('\u{1b}'));
    }

    #[test]
    fn any_span_can_be_shown() {
        let mut sources = SourceMap::new();
        let empty = sources.add("empty.lw", "");
        let signs = sources.add("signs.lw", "□ x\n\n◇");
        for file in [empty, signs] {
            for start in 0..12 {
                for end in start..14 {
                    let finding =
                        Diagnostic::error(codes::SYNTAX, Span::new(file, start, end), "message")
                            .with_label(Span::new(file, end, end + 1), "label");
                    assert!(plain(&sources, &[finding]).contains("message"));
                }
            }
        }
    }

    #[test]
    fn a_message_of_several_lines_stays_one_line_in_short() {
        let finding = Diagnostic::error(codes::COMPILER_FAILED, None, "cc said\n  no such file");
        assert_eq!(
            short(&SourceMap::new(), &[finding]),
            "error[LW502]: cc said no such file\n"
        );
    }
}
