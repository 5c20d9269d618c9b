//! A counter of the steps in which a condition held since another condition last held.
//!
//! As with every monitor, its value in a step is about earlier steps. Resetting takes precedence
//! over counting. The counter stays at its maximum, so it never forbids a step.

use super::{ITSELF, Monitors, Origin, choose};
use crate::gr1::{BinaryOp, Domain, Expr};

impl Monitors {
    /// Returns the number of earlier steps with `counts` since the last step with `resets`; `high`
    /// means `high` or more.
    pub fn counter(&mut self, counts: &Expr, resets: &Expr, high: u32, origin: &Origin) -> Expr {
        let high = i64::from(high);
        let more = Expr::binary(BinaryOp::Add, Expr::now(ITSELF), Expr::Const(1));
        let more = Expr::binary(BinaryOp::Min, more, Expr::Const(high));
        let counted = choose(counts.clone(), more, Expr::now(ITSELF));
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
