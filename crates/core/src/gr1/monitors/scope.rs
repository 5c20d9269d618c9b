//! Scopes of patterns (Dwyer, Avrunin, Corbett: Patterns in Property Specifications for
//! Finite-State Verification, ICSE 1999).
//!
//! A scope says in which steps a pattern has to hold. All of them are closed on the left and open
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
//! Dwyer's formulas for the last two speak of *every* q: what has to happen in the scope has to
//! happen after the last q in it.
//!
//! With the five pieces below, a pattern is one formula for all scopes. The one difference in kind
//! is whether a scope counts that never closes. Where it does not, a mistake is remembered until r
//! comes ([`Scope::never`]).

use super::{BinaryOp, Expr, Kind, Monitors, Obligation, Origin, Remembered};

/// When a pattern has to hold. Operands are boolean expressions over current values.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Scope {
    /// In all steps.
    Globally,
    /// Before the first step in which it holds, if there is one.
    Before(Expr),
    /// From the first step in which it holds on.
    After(Expr),
    /// From every step in which the first holds to the next in which the second does, if there is
    /// one.
    Between(Expr, Expr),
    /// The same, also if the second never holds again.
    AfterUntil(Expr, Expr),
}

impl Scope {
    /// Whether the scope is open in this step. False wherever [`end`](Self::end) holds.
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

    /// What closes the scope, if anything does.
    pub(super) fn end(&self) -> Option<&Expr> {
        match self {
            Self::Globally | Self::After(_) => None,
            Self::Before(r) | Self::Between(_, r) | Self::AfterUntil(_, r) => Some(r),
        }
    }

    /// Whether only scopes count that are closed some day.
    pub(super) fn counts_if_closed(&self) -> bool {
        matches!(self, Self::Before(_) | Self::Between(..))
    }

    /// What opens the scope in this step, or opens it anew; `None` if it is open from the
    /// beginning.
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

    /// The scope is open, and since it was opened (last) `done` has not held.
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

    /// `mistake`, which is false outside the scope, must not happen in a scope that counts. Nothing
    /// has to be forgotten at r: if there is something to forget, the pattern is broken for good.
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

    /// What is `open` must be done before the scope closes, and some day in a scope that counts and
    /// never closes.
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

/// A single invariant.
pub(super) fn invariant(expr: &Expr) -> Vec<Obligation> {
    vec![Obligation::new(Kind::Invariant, expr)]
}

/// `a = value`
pub(super) fn is(a: &Expr, value: i64) -> Expr {
    Expr::binary(BinaryOp::Eq, a.clone(), Expr::Const(value))
}
