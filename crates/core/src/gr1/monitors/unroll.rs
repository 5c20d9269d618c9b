//! Formulas that read monitors, for places where they may not be read.
//!
//! A monitor is the machine's variable. An assumption about this step may mention inputs only, and
//! one about the next step next values of inputs only. But a monitor's value in step 0 is known,
//! and its next value is an expression over current values. So an invariant over inputs and
//! monitors is the same as an initial condition and a safety formula that mention no monitor where
//! none may be mentioned.

use super::{Kind, Monitors, Obligation};
use crate::gr1::{Expr, Time};

/// An invariant, taken apart: the first formula in step 0, the second from every step to the next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unrolled {
    /// Holds in step 0; mentions no monitor.
    pub initial: Expr,
    /// Holds from every step to the next; mentions current values of monitors, and next values of
    /// other variables.
    pub safety: Expr,
}

impl Monitors {
    /// Takes apart an expression over current values that has to hold in every step.
    pub fn unroll(&self, invariant: &Expr) -> Unrolled {
        debug_assert!(!invariant.mentions_next(), "an invariant of next values");
        Unrolled {
            initial: self.at_start(invariant),
            safety: self.one_step_later(invariant),
        }
    }

    /// What an expression over current values comes to in step 0.
    pub fn at_start(&self, expr: &Expr) -> Expr {
        let replaced = expr.substitute(&mut |v, time| match (self.get(v), time) {
            (Some(monitor), Time::Now) => Expr::Const(monitor.initial),
            _ => Expr::Var(v, time),
        });
        replaced.simplify()
    }

    /// The value an expression over current values will have in the next step.
    pub fn one_step_later(&self, expr: &Expr) -> Expr {
        debug_assert!(!expr.mentions_next(), "two steps later");
        let primed = expr.substitute(&mut |v, _| Expr::next(v));
        self.without_next_monitors(&primed)
    }

    /// The same with next values of monitors replaced by what they will be.
    pub fn without_next_monitors(&self, expr: &Expr) -> Expr {
        let replaced = expr.substitute(&mut |v, time| match (self.get(v), time) {
            (Some(monitor), Time::Next) => monitor.update.clone(),
            _ => Expr::Var(v, time),
        });
        replaced.simplify()
    }

    /// An obligation as assumptions may have it: what reads a monitor is taken apart, what is
    /// always true left out. Whether what is left speaks of outputs that an assumption may not
    /// speak of is for the caller to check.
    pub fn assumed(&self, obligation: &Obligation) -> Vec<Obligation> {
        let Obligation { kind, expr } = obligation;
        let parts = match kind {
            Kind::Initial => vec![(Kind::Initial, self.at_start(expr))],
            Kind::Invariant if self.occur_in(expr) => {
                let Unrolled { initial, safety } = self.unroll(expr);
                vec![(Kind::Initial, initial), (Kind::Safety, safety)]
            }
            Kind::Invariant => vec![(Kind::Invariant, expr.clone())],
            Kind::Safety | Kind::Justice => vec![(*kind, self.without_next_monitors(expr))],
        };
        let parts = parts.into_iter();
        parts
            .filter(|(_, expr)| *expr != Expr::TRUE)
            .map(|(kind, expr)| Obligation { kind, expr })
            .collect()
    }
}
