//! Response: every p is answered by an s, in its step or later; with a bound of n steps, in its
//! step or one of the n after it.
//!
//! | scope | meaning |
//! |---|---|
//! | globally | `G (p -> F s)` |
//! | before r | `F r -> ((p -> (!r U (s & !r))) U r)` |
//! | after q | `G (q -> G (p -> F s))` |
//! | between q and r | `G ((q & !r & F r) -> ((p -> (!r U (s & !r))) U r))` |
//! | after q until r | `G ((q & !r) -> ((p -> (!r U (s & !r))) W r))` |
//!
//! With a bound, `F s` becomes `F<=n s`, and `!r U (s & !r)` becomes `!r U<=n (s & !r)`: the step
//! meant is at most n steps away. An s in the step of r comes too late, as it does without a bound.

use super::deadline::Deadline;
use super::{Expr, Monitors, Obligation, Origin, Scope};

pub(super) fn lower(
    monitors: &mut Monitors,
    trigger: &Expr,
    answer: &Expr,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    let inside = scope.inside(monitors, origin);
    let asked = inside.and(trigger.clone());
    // A request that is open when the scope closes has broken the pattern for good, so nothing is
    // cleared then.
    let open = |before: Expr| answer.clone().not().and(asked.clone().or(before));
    let open = monitors.remember("unanswered", false, open, origin);
    scope.some_day(&open)
}

pub(super) fn within(
    monitors: &mut Monitors,
    trigger: &Expr,
    answer: &Expr,
    steps: u32,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    let inside = scope.inside(monitors, origin);
    let deadline = Deadline {
        trigger: inside.and(trigger.clone()),
        answer,
        steps,
        from_start: false,
    };
    deadline.lower(monitors, scope, origin)
}
