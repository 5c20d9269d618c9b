//! A counter: the steps in which something held since something else last held.
//!
//! Its value in a step is about the steps before, as with every monitor. Resetting wins over
//! counting, and at its end the counter stays, so that no step is ever forbidden by it.

use super::{ITSELF, Monitors, Origin, choose};
use crate::gr1::{BinaryOp, Domain, Expr};

impl Monitors {
    /// How many of the steps before this one, after the last in which `resets` held, had `counts`;
    /// `high` stands for `high` or more.
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
