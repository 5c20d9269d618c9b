//! Rewriting of formulas that read monitors, for use as assumptions.
//!
//! A monitor is a variable of the machine. An assumed initial condition or invariant must mention
//! inputs only, and in an assumed safety formula, next values must be those of inputs. But a
//! monitor's value in step 0 is known, and its next value is an expression over current values. So
//! an invariant over inputs and monitors is equivalent to an initial condition without monitors and
//! a safety formula without next values of monitors.

use super::{Monitors, Obligation};
use crate::gr1::{Expr, FormulaKind, Time};

/// An invariant, split into an initial condition and a safety formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnrolledInvariant {
    /// Holds in step 0; mentions no monitor.
    pub initial: Expr,
    /// Holds from every step to the next; mentions current values of monitors, and next values of
    /// other variables.
    pub safety: Expr,
}

impl Monitors {
    /// Splits an invariant, which must be an expression over current values.
    pub fn unroll(&self, invariant: &Expr) -> UnrolledInvariant {
        debug_assert!(!invariant.mentions_next(), "the invariant has next values");
        UnrolledInvariant {
            initial: self.at_start(invariant),
            safety: self.one_step_later(invariant),
        }
    }

    /// Replaces monitors in an expression over current values by their initial values.
    pub fn at_start(&self, expr: &Expr) -> Expr {
        let replaced = expr.substitute(&mut |v, time| match (self.get(v), time) {
            (Some(monitor), Time::Now) => Expr::Const(monitor.initial),
            _ => Expr::Var(v, time),
        });
        replaced.simplify()
    }

    /// Returns the value that an expression over current values will have in the next step.
    pub fn one_step_later(&self, expr: &Expr) -> Expr {
        debug_assert!(!expr.mentions_next(), "the expression has next values");
        let primed = expr.substitute(&mut |v, _| Expr::next(v));
        self.without_next_monitors(&primed)
    }

    /// Replaces next values of monitors by their updates.
    pub fn without_next_monitors(&self, expr: &Expr) -> Expr {
        let replaced = expr.substitute(&mut |v, time| match (self.get(v), time) {
            (Some(monitor), Time::Next) => monitor.update.clone(),
            _ => Expr::Var(v, time),
        });
        replaced.simplify()
    }

    /// Converts an obligation to obligations that can be assumed: invariants that read a monitor
    /// are split, and formulas that are always true are dropped. The caller must check that the
    /// formulas mention only variables that are allowed in an assumption.
    pub fn as_assumptions(&self, obligation: &Obligation) -> Vec<Obligation> {
        let Obligation { kind, expr } = obligation;
        let parts = match kind {
            FormulaKind::Initial => vec![(FormulaKind::Initial, self.at_start(expr))],
            FormulaKind::Invariant if self.occur_in(expr) => {
                let UnrolledInvariant { initial, safety } = self.unroll(expr);
                vec![
                    (FormulaKind::Initial, initial),
                    (FormulaKind::Safety, safety),
                ]
            }
            FormulaKind::Invariant => vec![(FormulaKind::Invariant, expr.clone())],
            FormulaKind::Safety | FormulaKind::Justice => {
                vec![(*kind, self.without_next_monitors(expr))]
            }
        };
        let parts = parts.into_iter();
        parts
            .filter(|(_, expr)| *expr != Expr::TRUE)
            .map(|(kind, expr)| Obligation { kind, expr })
            .collect()
    }
}
