//! Universality: p always holds, which is the absence of `not p`.
//!
//! | scope | meaning |
//! |---|---|
//! | globally | `G p` |
//! | before r | `F r -> (p U r)` |
//! | after q | `G (q -> G p)` |
//! | between q and r | `G ((q & !r & F r) -> (p U r))` |
//! | after q until r | `G ((q & !r) -> (p W r))` |

use super::{Expr, Monitors, Obligation, Origin, Scope, absence};

pub(super) fn lower(
    monitors: &mut Monitors,
    p: &Expr,
    scope: &Scope,
    origin: &Origin,
) -> Vec<Obligation> {
    absence::lower(monitors, &p.clone().not(), scope, origin)
}
