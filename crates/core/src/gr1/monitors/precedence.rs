//! Precedence: p does not hold before s has held. Both can hold for the first time in the same
//! step.
//!
//! | scope | meaning |
//! |---|---|
//! | globally | `!p W s` |
//! | before r | `F r -> (!p U (s or r))` |
//! | after q | `!q W (q & (!p W s))` |
//! | between q and r | `G ((q & !r & F r) -> (!p U (s or r)))` |
//! | after q until r | `G ((q & !r) -> (!p W (s or r)))` |
//!
//! After q, Dwyer's formula is `G !q or F (q & (!p W s))`: precedence has to hold after some q, not
//! necessarily the first. That differs from his description of the scope, and no GR(1) formula can
//! express it: if q always holds and s never does, it is `F G !p`, which no deterministic monitor
//! with justice recognises. We take the first q. Our formula implies Dwyer's, and is equivalent to
//! it if q holds only once.

use super::{Expr, Monitors, Obligation, Origin, Scope};

pub(super) fn lower(
    monitors: &mut Monitors,
    first: &Expr,
    then: &Expr,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    let waiting = scope.waiting(monitors, first, origin);
    scope.never(monitors, &waiting.now.and(then.clone()), origin)
}
