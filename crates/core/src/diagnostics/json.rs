//! Findings as serializable objects, the form that they have in every JSON document of this
//! program.

use super::{Diagnostic, render};
use crate::source::{SourceMap, Span};
use schemars::JsonSchema;
use serde::Serialize;

/// A finding in JSON. Lines and columns start at 1, columns count characters, and the end is one
/// past the last character.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Finding {
    /// Code, such as `LW101`.
    #[schemars(regex(pattern = "^LW[0-9]{3}$"))]
    pub code: &'static str,
    /// Severity: `error`, `warning` or `note`.
    #[schemars(extend("enum" = ["error", "warning", "note"]))]
    pub severity: &'static str,
    /// Message, one sentence.
    pub message: String,
    /// Place of the finding; omitted if it has no place in a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub span: Option<Place>,
    /// Related places.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<Label>,
    /// Additional information; each text may have several lines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Suggested next step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// A range of a file.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Place {
    /// File name.
    pub file: String,
    /// First line.
    #[schemars(range(min = 1))]
    pub line: usize,
    /// First column.
    #[schemars(range(min = 1))]
    pub column: usize,
    /// Last line.
    #[schemars(range(min = 1))]
    pub end_line: usize,
    /// One past the last column.
    #[schemars(range(min = 1))]
    pub end_column: usize,
}

/// A related place of a finding.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Label {
    /// Place.
    pub span: Place,
    /// Short description, a few words.
    pub text: String,
}

impl Place {
    /// Returns the place of a span.
    pub fn of(sources: &SourceMap, span: Span) -> Self {
        let (start, end) = (sources.start(span), sources.end(span));
        Self {
            file: sources.file(span.file).name.clone(),
            line: start.line,
            column: start.column,
            end_line: end.line,
            end_column: end.column,
        }
    }
}

/// Converts findings to objects, sorted by file and place.
pub fn findings(sources: &SourceMap, findings: &[Diagnostic]) -> Vec<Finding> {
    render::sorted(sources, findings)
        .into_iter()
        .map(|d| Finding {
            code: d.code.id,
            severity: d.severity.word(),
            message: d.message.clone(),
            span: d.span.map(|s| Place::of(sources, s)),
            labels: d
                .labels
                .iter()
                .map(|(span, text)| Label {
                    span: Place::of(sources, *span),
                    text: text.clone(),
                })
                .collect(),
            notes: d.notes.clone(),
            help: d.help.clone(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn objects_have_the_fields_of_the_interface() {
        let (sources, diagnostics) = sample::findings();
        let text = serde_json::to_string_pretty(&findings(&sources, &diagnostics)).unwrap();
        insta::assert_snapshot!(sample::with_sources(&sources, &text));
    }
}
