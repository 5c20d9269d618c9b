//! `p since q`: q holds in this step or held in an earlier one, and p has held in every step since
//! the last q, up to and including this step.
//!
//! By its expansion, `p since q` = q or (p and previous (p since q)). The monitor is
//! `previous (p since q)`.

use super::{Monitors, Origin};
use crate::gr1::Expr;

impl Monitors {
    /// Returns whether `q` holds now or held in an earlier step, and `p` held in every step after
    /// the last such step.
    pub fn since(&mut self, p: &Expr, q: &Expr, origin: &Origin) -> Expr {
        self.track_now(
            "since",
            false,
            |before| q.clone().or(p.clone().and(before)),
            origin,
        )
    }
}
