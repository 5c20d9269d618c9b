//! `historically p`: p holds in this step and held in all earlier steps.
//!
//! The monitor stores whether p held in all earlier steps, which is true in step 0. With a bound it
//! counts down from the last step in which p did not hold, as `once` does from the last step in
//! which p held.

use super::{Monitors, Origin};
use crate::gr1::{BinaryOp, Expr};

impl Monitors {
    /// Returns whether `p` holds now and held in every earlier step.
    pub fn historically(&mut self, p: &Expr, origin: &Origin) -> Expr {
        self.track_now("historically", true, |before| p.clone().and(before), origin)
    }

    /// Returns whether `p` holds now and held in each of the previous `steps` steps, or in all
    /// earlier steps if there are fewer.
    pub fn historically_within(&mut self, p: &Expr, steps: u32, origin: &Origin) -> Expr {
        let p = p.simplify();
        match (steps, &p) {
            (0, _) | (_, Expr::Const(_)) => p,
            (1, _) => {
                let before = self.track("historically", true, |_| p.clone(), origin);
                p.and(before.before)
            }
            _ => {
                let left =
                    self.steps_left("historically", &p.clone().not().simplify(), steps, origin);
                p.and(Expr::binary(BinaryOp::Eq, left, Expr::Const(0)))
            }
        }
    }
}
