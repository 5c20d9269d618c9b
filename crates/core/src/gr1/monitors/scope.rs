//! Scopes of patterns (Dwyer, Avrunin, Corbett: Patterns in Property Specifications for
//! Finite-State Verification, ICSE 1999).
//!
//! A scope defines in which steps a pattern has to hold. All scopes are closed on the left and open
//! on the right: the step of q belongs to the scope, the step of r does not. If q and r hold in the
//! same step, no scope opens.
//!
//! | scope | open in the steps | if the scope never closes |
//! |---|---|---|
//! | globally | all | the pattern has to hold |
//! | before r | before the first r | there is no obligation |
//! | after q | from the first q on | the pattern has to hold |
//! | between q and r | from a q to the next r | there is no obligation |
//! | after q until r | from a q to the next r, or for ever | the pattern has to hold |
//!
//! Dwyer's formulas for the last two scopes constrain *every* q: what has to happen in the scope
//! has to happen after the last q in it.
//!
//! With the functions of [`Scope`], a pattern is one formula for all scopes. The only remaining
//! difference is whether a scope counts if it never closes. If it does not count, a violation is
//! stored until r holds ([`Scope::never`]).

use super::{BinaryOp, Expr, Monitors, Obligation, Origin, TrackedFormula};
use crate::gr1::FormulaKind;

/// Steps in which a pattern has to hold. Operands are boolean expressions over current values.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Scope {
    /// In all steps.
    Globally,
    /// Before the first step in which the condition holds, if there is one.
    Before(Expr),
    /// From the first step in which the condition holds.
    After(Expr),
    /// From every step in which the first condition holds to the next step in which the second
    /// holds, if there is one.
    Between(Expr, Expr),
    /// Like [`Between`](Self::Between), but also if the second condition never holds again.
    AfterUntil(Expr, Expr),
}

impl Scope {
    /// Returns whether the scope is open in this step. False wherever [`end`](Self::end) holds.
    pub(super) fn inside(&self, monitors: &mut Monitors, origin: &Origin) -> Expr {
        match self {
            Self::Globally => Expr::TRUE,
            Self::Before(r) => {
                let open = |before| r.clone().not().and(before);
                monitors.track_now("before", true, open, origin)
            }
            Self::After(q) => monitors.once(q, origin),
            Self::Between(q, r) | Self::AfterUntil(q, r) => {
                let open = |before| r.clone().not().and(q.clone().or(before));
                monitors.track_now("inside", false, open, origin)
            }
        }
    }

    /// Returns the condition that closes the scope, if there is one.
    pub(super) fn end(&self) -> Option<&Expr> {
        match self {
            Self::Globally | Self::After(_) => None,
            Self::Before(r) | Self::Between(_, r) | Self::AfterUntil(_, r) => Some(r),
        }
    }

    /// Returns whether the scope counts only if it eventually closes.
    pub(super) fn counts_if_closed(&self) -> bool {
        matches!(self, Self::Before(_) | Self::Between(..))
    }

    /// Returns the condition that opens or reopens the scope in this step; `None` if it is open
    /// from the beginning.
    pub(super) fn opening(&self, monitors: &mut Monitors, origin: &Origin) -> Option<Expr> {
        match self {
            Self::Globally | Self::Before(_) => None,
            Self::After(q) => {
                let already = monitors.once(q, origin);
                let already = monitors.previous(&already, origin);
                Some(q.clone().and(already.not()))
            }
            Self::Between(q, r) | Self::AfterUntil(q, r) => Some(q.clone().and(r.clone().not())),
        }
    }

    /// Tracks whether the scope is open and `done` has not held since the scope was last opened.
    pub(super) fn waiting(
        &self,
        monitors: &mut Monitors,
        done: &Expr,
        origin: &Origin,
    ) -> TrackedFormula {
        let stop = match self.end() {
            Some(r) => done.clone().or(r.clone()),
            None => done.clone(),
        };
        let opening = self.opening(monitors, origin);
        let waits = |before: Expr| {
            let open = match &opening {
                Some(opens) => opens.clone().or(before),
                None => before,
            };
            stop.clone().not().and(open)
        };
        monitors.track("waiting", opening.is_none(), waits, origin)
    }

    /// Returns the obligation that `violation`, which is false outside the scope, never holds in a
    /// scope that counts. The monitor is not reset at r: if a violation is stored then, the pattern
    /// is violated permanently.
    pub(super) fn never(
        &self,
        monitors: &mut Monitors,
        violation: &Expr,
        origin: &Origin,
    ) -> Vec<Obligation> {
        match self.end() {
            Some(r) if self.counts_if_closed() => {
                let broken = |before: Expr| violation.clone().or(before);
                let broken = monitors.track("broken", false, broken, origin);
                invariant(&r.clone().implies(broken.before.not()))
            }
            _ => invariant(&violation.clone().not()),
        }
    }

    /// Returns the obligation that `open` becomes false before the scope closes, or eventually in a
    /// scope that never closes but counts.
    pub(super) fn eventually_done(&self, open: &TrackedFormula) -> Vec<Obligation> {
        let mut found = match self.end() {
            Some(r) => invariant(&r.clone().implies(open.before.clone().not())),
            None => Vec::new(),
        };
        if !self.counts_if_closed() {
            found.push(Obligation::new(
                FormulaKind::Justice,
                &open.now.clone().not(),
            ));
        }
        found
    }
}

/// Returns a single invariant.
pub(super) fn invariant(expr: &Expr) -> Vec<Obligation> {
    vec![Obligation::new(FormulaKind::Invariant, expr)]
}

/// Returns `a = value`.
pub(super) fn is(a: &Expr, value: i64) -> Expr {
    Expr::binary(BinaryOp::Eq, a.clone(), Expr::Const(value))
}
