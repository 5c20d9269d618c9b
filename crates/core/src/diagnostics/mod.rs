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
pub use nearest::{distance, nearest, related, words};

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// The contract, machine or line cannot be used as it is.
    Error,
    /// It can be used, but hardly means what its author meant.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// The word of INTERFACE: `error`, `warning` or `note`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// One finding: what is wrong, where, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The code, never reused for anything else.
    pub code: Code,
    /// How bad it is.
    pub severity: Severity,
    /// One sentence in the user's words.
    pub message: String,
    /// Where; `None` for what has no place in a file (a missing compiler).
    pub span: Option<Span>,
    /// Further places that matter, each with a few words.
    pub labels: Vec<(Span, String)>,
    /// What else there is to say, each as a text of its own that may have several lines.
    pub notes: Vec<String>,
    /// The next step.
    pub help: Option<String>,
    /// Whether something was not decided because the command reached a limit that it was given: its
    /// time or its memory, or Ctrl-C.
    pub gave_up: bool,
}

impl Diagnostic {
    /// An error.
    pub fn error(code: Code, span: impl Into<Option<Span>>, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, span.into(), message.into())
    }

    /// A warning.
    pub fn warning(code: Code, span: impl Into<Option<Span>>, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, span.into(), message.into())
    }

    /// A note.
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

    /// Says whether it is there because the command reached a limit.
    #[must_use]
    pub fn giving_up(mut self, gave_up: bool) -> Self {
        self.gave_up = gave_up;
        self
    }

    /// Adds the next step.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds something to say.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Adds a further place.
    #[must_use]
    pub fn with_label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push((span, text.into()));
        self
    }
}

/// Whether any of these findings is an error.
pub fn has_errors(findings: &[Diagnostic]) -> bool {
    findings.iter().any(|d| d.severity == Severity::Error)
}
