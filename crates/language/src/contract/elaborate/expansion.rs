//! How far defines, quantifiers and arrays are written out, and the limits.

use super::findings::Findings;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;

/// Quantifiers and arrays expand to at most so many instances.
pub(in crate::contract) const MAX_EXPANSION: i64 = 4096;
/// The quantifiers of one contract or machine expand to at most so many instances together.
const MAX_INSTANCES: i64 = MAX_EXPANSION * 64;
/// Expressions nest so deep at most, defines written out: later stages walk formulas by recursion.
const MAX_NESTED: usize = 400;
/// A formula's tree is at most so deep once arrays are written out.
pub(super) const MAX_FORMULA_DEPTH: usize = 600;
/// What one contract or machine may cost to write out: nodes that are made, copied or looked at.
const MAX_WORK: usize = 1_000_000;

/// The bound on what one contract or machine is written out to.
#[derive(Default)]
pub(in crate::contract) struct Expansion {
    /// The defines and counters that the expression at hand comes from, innermost last.
    pub(super) defining: Vec<String>,
    /// The expression that all those at hand stand within, where it was asked for.
    root: Option<Span>,
    /// Number of expressions around the one at hand.
    nested: usize,
    /// Instances of quantifiers so far.
    instances: i64,
    /// Nodes so far.
    work: usize,
    /// Whether a limit was reported.
    exhausted: bool,
}

impl Expansion {
    /// Counts work; `None` and one finding where there is too much of it.
    pub fn spend(&mut self, span: Span, amount: usize, findings: &mut Findings) -> Option<()> {
        self.work = self.work.saturating_add(amount);
        if self.work > MAX_WORK {
            self.too_large(span, findings);
            return None;
        }
        Some(())
    }

    /// Counts instances of a quantifier; `None` and one finding where there are too many of them.
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

    /// Goes into an expression, until [`Expansion::leave`]; `None` and one finding where it stands
    /// too deep.
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

    /// Comes back from an expression.
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
