//! Limits on the expansion of defines, quantifiers and arrays.

use super::findings::Findings;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;

/// Maximum number of instances of one quantifier or array.
pub(in crate::contract) const MAX_EXPANSION: i64 = 4096;
/// Maximum number of quantifier instances in one contract or machine.
const MAX_INSTANCES: i64 = MAX_EXPANSION * 64;
/// Maximum nesting depth of expressions, with defines expanded: later stages walk formulas by
/// recursion.
const MAX_NESTED: usize = 400;
/// Maximum depth of a formula's tree after arrays are expanded.
pub(super) const MAX_FORMULA_DEPTH: usize = 600;
/// Maximum cost of expanding one contract or machine: nodes created, copied or visited.
const MAX_WORK: usize = 1_000_000;

/// The expansion of one contract or machine so far, and its limits.
#[derive(Default)]
pub(in crate::contract) struct Expansion {
    /// Defines and counters being expanded, innermost last.
    pub(super) defining: Vec<String>,
    /// Outermost expression of the current expansion.
    root: Option<Span>,
    /// Number of expressions around the current one.
    nested: usize,
    /// Instances of quantifiers so far.
    instances: i64,
    /// Nodes so far.
    work: usize,
    /// Whether a limit was reported.
    exhausted: bool,
}

impl Expansion {
    /// Counts work; returns `None` and reports once if the limit is exceeded.
    pub fn spend(&mut self, span: Span, amount: usize, findings: &mut Findings) -> Option<()> {
        self.work = self.work.saturating_add(amount);
        if self.work > MAX_WORK {
            self.too_large(span, findings);
            return None;
        }
        Some(())
    }

    /// Counts instances of a quantifier; returns `None` and reports once if there are too many.
    pub(super) fn instantiate(
        &mut self,
        span: Span,
        instances: usize,
        findings: &mut Findings,
    ) -> Option<()> {
        self.instances += instances as i64;
        if self.instances > MAX_INSTANCES {
            self.too_large(span, findings);
            return None;
        }
        Some(())
    }

    /// Enters an expression, until [`Expansion::leave`]; returns `None` and reports once if it is
    /// nested too deep.
    pub(super) fn enter(&mut self, span: Span, findings: &mut Findings) -> Option<()> {
        if self.nested == MAX_NESTED {
            self.too_large(span, findings);
            return None;
        }
        if self.nested == 0 {
            self.root = Some(span);
        }
        self.nested += 1;
        Some(())
    }

    /// Leaves an expression.
    pub(super) fn leave(&mut self) {
        self.nested -= 1;
    }

    /// Reports that a formula grows too large, once.
    pub(super) fn too_large(&mut self, span: Span, findings: &mut Findings) {
        findings.tainted = true;
        if !std::mem::replace(&mut self.exhausted, true) {
            let span = self.root.filter(|_| self.nested > 0).unwrap_or(span);
            findings.error_with(
                codes::TOO_LARGE,
                span,
                "this becomes too large once defines, quantifiers and arrays are written out",
                "use smaller ranges and arrays, fewer nested quantifiers, or an internal variable that holds a value for reuse",
            );
        }
    }
}
