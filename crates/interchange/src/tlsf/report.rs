//! Collects the findings about a file.

use linewright_core::diagnostics::{Code, Diagnostic, codes};
use linewright_core::source::{FileId, Span};
use std::ops::Range;

/// Maximum number of findings that are reported.
const MAX_FINDINGS: usize = 200;

/// The findings about a file so far.
#[derive(Debug)]
pub(super) struct Report {
    file: FileId,
    pub findings: Vec<Diagnostic>,
}

impl Report {
    pub fn new(file: FileId) -> Self {
        Self {
            file,
            findings: Vec::new(),
        }
    }

    /// A report whose findings are discarded.
    pub fn silent() -> Self {
        Self::new(FileId::default())
    }

    pub fn span(&self, range: &Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end)
    }

    pub fn push(&mut self, finding: Diagnostic) {
        if self.findings.len() < MAX_FINDINGS && !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }

    pub fn error(
        &mut self,
        code: Code,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let finding = Diagnostic::error(code, self.span(&range), message).with_help(help);
        self.push(finding);
    }

    pub fn syntax(
        &mut self,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.error(codes::SYNTAX, range, message, help);
    }
}
