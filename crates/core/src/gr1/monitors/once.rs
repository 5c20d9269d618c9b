//! `once p`: p holds in this step or held in some earlier step.
//!
//! The monitor stores whether p held before. With a bound of n steps it counts down instead: it is
//! n after a step in which p held, then one less in every step. A shift register would need n bits;
//! the counter 0..n never needs more.

use super::{Monitors, Origin, SELF_VALUE, choose};
use crate::gr1::{BinaryOp, Domain, Expr};

impl Monitors {
    /// Returns whether `p` holds now or held in an earlier step.
    pub fn once(&mut self, p: &Expr, origin: &Origin) -> Expr {
        self.track_now("once", false, |before| p.clone().or(before), origin)
    }

    /// Returns whether `p` holds now or held in one of the previous `steps` steps.
    pub fn once_within(&mut self, p: &Expr, steps: u32, origin: &Origin) -> Expr {
        let p = p.simplify();
        match (steps, &p) {
            (0, _) | (_, Expr::Const(_)) => p,
            (1, _) => {
                let before = self.previous(&p, origin);
                p.or(before)
            }
            _ => {
                let left = self.steps_left("once", &p, steps, origin);
                p.or(Expr::binary(BinaryOp::Gt, left, Expr::Const(0)))
            }
        }
    }

    /// Returns the number of steps, including this step, in which "`p` held in one of the previous
    /// `steps` steps" remains true if `p` never holds again.
    pub(super) fn steps_left(
        &mut self,
        stem: &'static str,
        p: &Expr,
        steps: u32,
        origin: &Origin,
    ) -> Expr {
        let high = i64::from(steps);
        let less = Expr::binary(BinaryOp::Sub, Expr::now(SELF_VALUE), Expr::Const(1));
        let left = Expr::binary(BinaryOp::Max, less, Expr::Const(0));
        let update = choose(p.clone(), Expr::Const(high), left);
        self.make(stem, Domain::Range { low: 0, high }, 0, &update, origin)
    }
}
