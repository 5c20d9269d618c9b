//! Findings of an elaborator.

use crate::contract::value::Type;
use linewright_core::diagnostics::{Code, Diagnostic, codes, has_errors};
use linewright_core::source::Span;
use linewright_syntax::ast;

/// Findings of one elaborator.
#[derive(Default)]
pub(in crate::contract) struct Findings {
    /// Findings reported here.
    pub list: Vec<Diagnostic>,
    /// Whether the elaborated text depends on a declaration whose error was reported elsewhere.
    pub tainted: bool,
}

impl Findings {
    /// Returns whether the result is unusable, because of an error here or in a declaration on
    /// which it depends.
    pub fn has_errors(&self) -> bool {
        self.tainted || has_errors(&self.list)
    }

    /// Records a finding.
    pub fn push(&mut self, finding: Diagnostic) {
        self.list.push(finding);
    }

    /// Moves the findings of another elaborator to this one.
    pub fn absorb(&mut self, other: &mut Self) {
        self.tainted |= other.tainted;
        self.list.append(&mut other.list);
    }

    /// Records an error with a help text.
    pub fn error_with(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.push(Diagnostic::error(code, span, message).with_help(help));
    }

    /// Records an error about a name, which is the subject of the message: `` `name` is no place``.
    pub fn error_about(
        &mut self,
        code: Code,
        name: &ast::Name,
        says: &str,
        help: impl Into<String>,
    ) {
        let message = format!("`{}` {says}", name.text);
        self.error_with(code, name.span, message, help);
    }

    /// Reports a value whose type differs from the expected one.
    pub fn mismatch(&mut self, span: Span, expected: &str, found: &Type) {
        let help = match found {
            Type::Int | Type::Number(_) | Type::Measured(_) if expected != "a truth value" => {
                "write a value of the expected type, or change the type of the declaration"
            }
            Type::Array(..) if expected.starts_with("an array") => {
                "use an array with this length and elements of this type"
            }
            Type::Bool => "convert a truth value to a number with `if ... then 1 else 0`",
            Type::Enum(_) => "compare a label with `=`, `!=` or `in {...}`",
            Type::Array(..) => {
                "select one element with `[i]`, or quantify with `forall i in 0..n-1`"
            }
            Type::Record(_) => "select one member, such as `target.x`",
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
