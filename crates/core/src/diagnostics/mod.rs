//! Findings as plain values.
//!
//! A stage collects [`Diagnostic`]s and never prints; [`render`](mod@render), [`json`] and
//! [`sarif`] turn them into text. Codes are listed in [`codes`], each with a page in
//! [`explanations`] that `linewright explain` shows.

pub mod codes;
pub mod explanations;
pub mod json;
mod nearest;
pub mod render;
#[cfg(test)]
mod sample;
pub mod sarif;

use crate::source::Span;
pub use codes::Code;
pub use nearest::{Spelling, edit_distance, nearest, word_similarity, words};

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// The contract, machine or line cannot be used as it is.
    Error,
    /// The contract, machine or line can be used, but probably does not mean what its author
    /// intended.
    Warning,
    /// Information for the user.
    Note,
}

impl Severity {
    /// Returns the severity's name in output: `error`, `warning` or `note`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// A finding: what is wrong, where, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Code; codes are never reused.
    pub code: Code,
    /// Severity.
    pub severity: Severity,
    /// Message: one sentence in the user's terms.
    pub message: String,
    /// Place; `None` if the finding has no place in a file (a missing compiler).
    pub span: Option<Span>,
    /// Related places, each with a few words.
    pub labels: Vec<(Span, String)>,
    /// Additional information; each text can have several lines.
    pub notes: Vec<String>,
    /// Suggested next step.
    pub help: Option<String>,
    /// Whether something was left undecided because the command reached a limit: time, memory,
    /// Ctrl-C or the number of runs.
    pub gave_up: bool,
}

impl Diagnostic {
    /// Creates an error.
    pub fn error(code: Code, span: impl Into<Option<Span>>, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, span.into(), message.into())
    }

    /// Creates a warning.
    pub fn warning(code: Code, span: impl Into<Option<Span>>, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, span.into(), message.into())
    }

    /// Creates a note.
    pub fn note(code: Code, span: impl Into<Option<Span>>, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, span.into(), message.into())
    }

    fn new(severity: Severity, code: Code, span: Option<Span>, message: String) -> Self {
        Self {
            code,
            severity,
            message,
            span,
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
            gave_up: false,
        }
    }

    /// Sets whether the finding exists because the command reached a limit.
    #[must_use]
    pub fn giving_up(mut self, gave_up: bool) -> Self {
        self.gave_up = gave_up;
        self
    }

    /// Adds a suggested next step.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds a note.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Adds a related place.
    #[must_use]
    pub fn with_label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push((span, text.into()));
        self
    }
}

/// Returns whether any of the findings is an error.
pub fn has_errors(findings: &[Diagnostic]) -> bool {
    findings.iter().any(|d| d.severity == Severity::Error)
}
