//! A counter of the steps in which a condition held since another condition last held.
//!
//! As with every monitor, its value in a step depends on earlier steps only. Resetting takes
//! precedence over counting. The counter stays at its maximum, so it never forbids a step.

use super::{Monitors, Origin, SELF_VALUE, choose};
use crate::gr1::{BinaryOp, Domain, Expr};

impl Monitors {
    /// Returns the number of earlier steps in which `counts` held since `resets` last held; the
    /// value `high` means `high` or more.
    pub fn counter(&mut self, counts: &Expr, resets: &Expr, high: u32, origin: &Origin) -> Expr {
        let high = i64::from(high);
        let more = Expr::binary(BinaryOp::Add, Expr::now(SELF_VALUE), Expr::Const(1));
        let more = Expr::binary(BinaryOp::Min, more, Expr::Const(high));
        let counted = choose(counts.clone(), more, Expr::now(SELF_VALUE));
        let update = choose(resets.clone(), Expr::Const(0), counted).simplify();
        self.make(
            "counter",
            Domain::Range { low: 0, high },
            0,
            &update,
            origin,
        )
    }
}
