//! Findings, and whether the results can be trusted.

use crate::contract::value::Type;
use linewright_core::diagnostics::{Code, Diagnostic, codes, has_errors};
use linewright_core::source::Span;

/// Findings of one elaborator.
#[derive(Default)]
pub(in crate::contract) struct Findings {
    /// Findings reported here.
    pub list: Vec<Diagnostic>,
    /// Whether something was used that has an error reported elsewhere.
    pub tainted: bool,
}

impl Findings {
    /// Returns whether there is an error, here or in a name that was used.
    pub fn refused(&self) -> bool {
        self.tainted || has_errors(&self.list)
    }

    /// Records a finding.
    pub fn push(&mut self, finding: Diagnostic) {
        self.list.push(finding);
    }

    /// Takes over another elaborator's findings.
    pub fn absorb(&mut self, other: &mut Self) {
        self.tainted |= other.tainted;
        self.list.append(&mut other.list);
    }

    /// Records an error; every error has a next step.
    pub fn error_with(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push(Diagnostic::error(code, span, message).with_help(help));
    }

    /// Reports a value whose type differs from the expected one.
    pub fn mismatch(&mut self, span: Span, expected: &str, found: &Type) {
        let help = match found {
            Type::Int | Type::Number(_) | Type::Measured(_) if expected != "a truth value" => {
                "write a value of that kind, or give the declaration the other type"
            }
            Type::Array(..) if expected.starts_with("an array") => {
                "give it as many elements, and of the same kind"
            }
            Type::Bool => "a truth value counts as a number with `if ... then 1 else 0`",
            Type::Enum(_) => "a label is compared with `=`, `!=` or `in {...}`",
            Type::Array(..) => "name one element with `[i]`, or quantify over `forall i in 0..n-1`",
            Type::Record(_) => "name one member, such as `target.x`",
            Type::Int | Type::Number(_) | Type::Measured(_) => {
                "compare the number with something to get a truth value"
            }
        };
        self.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("expected {expected}, found {}", found.describe()),
            help,
        );
    }
}
