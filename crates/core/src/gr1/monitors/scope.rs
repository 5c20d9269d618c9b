//! Scopes of patterns (Dwyer, Avrunin, Corbett: Patterns in Property Specifications for
//! Finite-State Verification, ICSE 1999).
//!
//! A scope defines in which steps a pattern has to hold. All scopes are closed on the left and open
//! on the right: the step of q belongs to the scope, the step of r does not; q and r in one step
//! open nothing.
//!
//! | scope | open in the steps | what is not done when the run goes on for ever |
//! |---|---|---|
//! | globally | all | breaks the pattern |
//! | before r | before the first r | is no matter: a scope that never closes does not count |
//! | after q | from the first q on | breaks the pattern |
//! | between q and r | from a q to the next r | is no matter, likewise |
//! | after q until r | from a q to the next r, or for ever | breaks the pattern |
//!
//! Dwyer's formulas for the last two are about *every* q: what has to happen in the scope has to
//! happen after the last q in it.
//!
//! With the five functions below, a pattern is one formula for all scopes. The only real difference
//! is whether a scope that never closes counts. If not, a mistake is remembered until r comes
//! ([`Scope::never`]).

use super::{BinaryOp, Expr, Kind, Monitors, Obligation, Origin, Remembered};

/// Steps in which a pattern has to hold. Operands are boolean expressions over current values.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Scope {
    /// In all steps.
    Globally,
    /// Before the first step in which the condition holds, if there is one.
    Before(Expr),
    /// From the first step in which the condition holds.
    After(Expr),
    /// From every step in which the first holds to the next in which the second holds, if there is
    /// one.
    Between(Expr, Expr),
    /// Like [`Between`](Self::Between), also if the second never holds again.
    AfterUntil(Expr, Expr),
}

impl Scope {
    /// Returns whether the scope is open in this step. False wherever [`end`](Self::end) holds.
    pub(super) fn inside(&self, monitors: &mut Monitors, origin: &Origin) -> Expr {
        match self {
            Self::Globally => Expr::TRUE,
            Self::Before(r) => {
                let open = |before| r.clone().not().and(before);
                monitors.follow("before", true, open, origin)
            }
            Self::After(q) => monitors.once(q, origin),
            Self::Between(q, r) | Self::AfterUntil(q, r) => {
                let open = |before| r.clone().not().and(q.clone().or(before));
                monitors.follow("inside", false, open, origin)
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

    /// Returns whether only scopes that eventually close count.
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

    /// Tracks whether the scope is open and `done` has not held since it was (last) opened.
    pub(super) fn waiting(
        &self,
        monitors: &mut Monitors,
        done: &Expr,
        origin: &Origin,
    ) -> Remembered {
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
        monitors.remember("waiting", opening.is_none(), waits, origin)
    }

    /// Returns the obligation that `mistake`, which is false outside the scope, never happens in a
    /// scope that counts. Nothing has to be cleared at r: if anything is remembered then, the
    /// pattern is broken for good.
    pub(super) fn never(
        &self,
        monitors: &mut Monitors,
        mistake: &Expr,
        origin: &Origin,
    ) -> Vec<Obligation> {
        match self.end() {
            Some(r) if self.counts_if_closed() => {
                let broken = |before: Expr| mistake.clone().or(before);
                let broken = monitors.remember("broken", false, broken, origin);
                invariant(&r.clone().implies(broken.before.not()))
            }
            _ => invariant(&mistake.clone().not()),
        }
    }

    /// Returns the obligation that what is `open` is done before the scope closes, and eventually
    /// in a scope that counts and never closes.
    pub(super) fn some_day(&self, open: &Remembered) -> Vec<Obligation> {
        let mut found = match self.end() {
            Some(r) => invariant(&r.clone().implies(open.before.clone().not())),
            None => Vec::new(),
        };
        if !self.counts_if_closed() {
            found.push(Obligation::new(Kind::Justice, &open.now.clone().not()));
        }
        found
    }
}

/// Returns a single invariant.
pub(super) fn invariant(expr: &Expr) -> Vec<Obligation> {
    vec![Obligation::new(Kind::Invariant, expr)]
}

/// Returns `a = value`.
pub(super) fn is(a: &Expr, value: i64) -> Expr {
    Expr::binary(BinaryOp::Eq, a.clone(), Expr::Const(value))
}
