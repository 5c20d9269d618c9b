//! Limits on the expansion of defines, quantifiers and arrays.

use super::findings::Findings;
use linewright_core::diagnostics::codes;
use linewright_core::source::Span;

/// Maximum number of instances of one quantifier or array.
pub(in crate::contract) const MAX_EXPANSION: i64 = 4096;
/// Maximum number of instances of all quantifiers in one contract or machine.
const MAX_INSTANCES: i64 = MAX_EXPANSION * 64;
/// Maximum nesting depth of expressions, with defines expanded. It limits the recursion of later
/// stages.
const MAX_NESTING: usize = 400;
/// Maximum depth of a formula's tree after arrays are expanded.
pub(super) const MAX_FORMULA_DEPTH: usize = 600;
/// Maximum cost of expanding one contract or machine: nodes created, copied or visited.
const MAX_WORK: usize = 1_000_000;

/// Tracks the cost of expanding one contract or machine, and reports the first limit that is
/// exceeded.
#[derive(Default)]
pub(in crate::contract) struct Expansion {
    /// Names of the defines and counters that are being expanded, innermost last.
    pub(super) defining: Vec<String>,
    /// Outermost expression that is being expanded.
    root: Option<Span>,
    /// Number of enclosing expressions.
    nested: usize,
    /// Instances of quantifiers so far.
    instances: i64,
    /// Nodes created, copied or visited so far.
    work: usize,
    /// Whether a limit was reported.
    exhausted: bool,
}

impl Expansion {
    /// Adds `amount` to the cost. Returns `None` if the limit is exceeded, which is reported only
    /// once.
    pub fn spend(&mut self, span: Span, amount: usize, findings: &mut Findings) -> Option<()> {
        self.work = self.work.saturating_add(amount);
        if self.work > MAX_WORK {
            self.too_large(span, findings);
            return None;
        }
        Some(())
    }

    /// Adds instances of a quantifier. Returns `None` if there are too many, which is reported only
    /// once.
    pub(super) fn add_instances(
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

    /// Enters an expression; [`Expansion::leave`] leaves it. Returns `None` if the nesting is too
    /// deep, which is reported only once.
    pub(super) fn enter(&mut self, span: Span, findings: &mut Findings) -> Option<()> {
        if self.nested == MAX_NESTING {
            self.too_large(span, findings);
            return None;
        }
        if self.nested == 0 {
            self.root = Some(span);
        }
        self.nested += 1;
        Some(())
    }

    /// Leaves the innermost expression that was entered.
    pub(super) fn leave(&mut self) {
        self.nested -= 1;
    }

    /// Reports that a formula is too large. Only the first call adds a finding.
    pub(super) fn too_large(&mut self, span: Span, findings: &mut Findings) {
        findings.tainted = true;
        if !std::mem::replace(&mut self.exhausted, true) {
            let span = self.root.filter(|_| self.nested > 0).unwrap_or(span);
            findings.error_with(
                codes::TOO_LARGE,
                span,
                "this becomes too large when defines, quantifiers and arrays are expanded",
                "use smaller ranges and arrays, fewer nested quantifiers, or an internal variable that holds a value for reuse",
            );
        }
    }
}
