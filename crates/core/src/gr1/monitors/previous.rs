//! `previous p`: p held in the previous step; false in step 0.
//!
//! The monitor's update is p itself. If another monitor already stores the last value of p, it is
//! reused: `previous (once q)` is the monitor of `once q`.

use super::{Monitors, Origin};
use crate::gr1::{Domain, Expr};

impl Monitors {
    /// Returns whether `p` held in the previous step; false in step 0.
    pub fn previous(&mut self, p: &Expr, origin: &Origin) -> Expr {
        let p = p.simplify();
        match self.delays.get(&p) {
            Some(id) => Expr::now(*id),
            None => self.track("previous", false, |_| p.clone(), origin).before,
        }
    }

    /// Returns the value of `x` in the previous step; `initial` in step 0. `domain` must contain
    /// `initial` and all values of `x`.
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
