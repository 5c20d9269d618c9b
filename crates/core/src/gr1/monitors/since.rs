//! `p since q`: q holds in this step or held before, and p held in every step after the last such
//! step, this one included.
//!
//! By its expansion, `p since q` = q or (p and previous (p since q)), the monitor being that last
//! part.

use super::{Monitors, Origin};
use crate::gr1::Expr;

impl Monitors {
    /// Returns whether `q` held in this step or before, and `p` in every step since.
    pub fn since(&mut self, p: &Expr, q: &Expr, origin: &Origin) -> Expr {
        self.follow(
            "since",
            false,
            |before| q.clone().or(p.clone().and(before)),
            origin,
        )
    }
}
