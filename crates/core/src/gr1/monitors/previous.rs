//! `previous p`: p held in the step before; false in step 0.
//!
//! The monitor's update is p itself. Where some monitor already stores the last value of p, as that
//! of `once q` does for `previous (once q)`, it is taken.

use super::{Monitors, Origin};
use crate::gr1::{Domain, Expr};

impl Monitors {
    /// Whether `p` held in the step before; false in step 0.
    pub fn previous(&mut self, p: &Expr, origin: &Origin) -> Expr {
        let p = p.simplify();
        match self.delays.get(&p) {
            Some(id) => Expr::now(*id),
            None => {
                self.remember("previous", false, |_| p.clone(), origin)
                    .before
            }
        }
    }

    /// The value of `x` in the step before; `initial` in step 0. All values of `x` and the initial
    /// one are in `domain`.
    pub fn previous_value(
        &mut self,
        x: &Expr,
        domain: Domain,
        initial: i64,
        origin: &Origin,
    ) -> Expr {
        self.make("previous", domain, initial, &x.simplify(), origin)
    }
}
