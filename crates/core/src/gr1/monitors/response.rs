//! Response: every p is answered by an s, in the same step or later; with a bound of n steps, in
//! the same step or one of the n steps after it.
//!
//! | scope | meaning |
//! |---|---|
//! | globally | `G (p -> F s)` |
//! | before r | `F r -> ((p -> (!r U (s & !r))) U r)` |
//! | after q | `G (q -> G (p -> F s))` |
//! | between q and r | `G ((q & !r & F r) -> ((p -> (!r U (s & !r))) U r))` |
//! | after q until r | `G ((q & !r) -> ((p -> (!r U (s & !r))) W r))` |
//!
//! With a bound, `F s` becomes `F<=n s`, and `!r U (s & !r)` becomes `!r U<=n (s & !r)`: s holds at
//! most n steps later. With or without a bound, an s in the step of r is too late.

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
    let requested = inside.and(trigger.clone());
    // The monitor is not reset when the scope closes: if a request is open then, the pattern is
    // violated permanently.
    let open = |before: Expr| answer.clone().not().and(requested.clone().or(before));
    let open = monitors.track("unanswered", false, open, origin);
    scope.eventually_done(&open)
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
