//! Existence: p holds in some step; with a bound of n steps, in the step that opens the scope or
//! one of the n steps after it.
//!
//! | scope | meaning |
//! |---|---|
//! | globally | `F p` |
//! | before r | `!r W (p & !r)` |
//! | after q | `!q W (q & F p)` |
//! | between q and r | `G ((q & !r) -> (!r W (p & !r)))` |
//! | after q until r | `G ((q & !r) -> (!r U (p & !r)))` |
//!
//! Dwyer's formula for after q is `G !q or F (q & F p)`, which is equivalent. With a bound, `F` and
//! `U` become `F<=n` and `U<=n`: p holds at most n steps later. Before r, `W` becomes `U<=n` under
//! the condition `F r`: `F r -> (!r U<=n (p & !r))`. After q, steps are counted from the first q.

use super::deadline::Deadline;
use super::{Expr, Monitors, Obligation, Origin, Scope};
use crate::gr1::FormulaKind;

pub(super) fn lower(
    monitors: &mut Monitors,
    p: &Expr,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    let waiting = scope.waiting(monitors, p, origin);
    scope.eventually_done(&waiting)
}

pub(super) fn within(
    monitors: &mut Monitors,
    p: &Expr,
    steps: u32,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    if (scope, steps) == (&Scope::Globally, 0) {
        return vec![Obligation::new(FormulaKind::Initial, p)];
    }
    // If the scope is open from the beginning, the request is made in the step before step 0.
    let (trigger, steps, from_start) = match scope.opening(monitors, origin) {
        Some(opening) => (opening, steps, false),
        None => (Expr::FALSE, steps.saturating_add(1), true),
    };
    let deadline = Deadline {
        trigger,
        answer: p,
        steps,
        from_start,
    };
    deadline.lower(monitors, scope, origin)
}
