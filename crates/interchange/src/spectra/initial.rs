//! Initial conditions that a side cannot ensure in the first step.
//!
//! Spectra's type checker rejects a formula that directly refers to what the side cannot control,
//! but accepts the reference in a definition that the formula uses. Then the condition has this
//! meaning:
//!
//! | | |
//! |---|---|
//! | `asm` about values that the system chooses | some values of the system's variables satisfy the formula |
//! | `next` | the formula holds for the transition from the first step to the second |

use super::reader::Reader;
use super::value::{Kind, Value};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{BinaryOp, Expr, Owner, Time, VarId};
use linewright_core::source::Span;
use std::collections::BTreeSet;

/// Maximum number of values of a variable that is eliminated from an assumption.
const MAX_VALUES: u64 = 1 << 12;

impl Reader {
    /// Turns an initial condition about the first two steps into a transition formula that applies
    /// to the first transition only.
    pub fn first_transition(&mut self, expr: Expr) -> Expr {
        let origin = self.origin.clone();
        let finding = Diagnostic::warning(
            codes::NOTATION,
            origin.span,
            "an initial condition refers to the next step: it applies only to the transition from the first step to the second",
        )
        .with_help("write `G` before it if it applies to all steps; otherwise describe only the first step");
        self.findings.push(finding);
        self.monitors.previous(&Expr::TRUE, &origin).or(expr)
    }

    /// Eliminates the system's variables from an initial assumption. The result requires that some
    /// values of these variables satisfy the assumption.
    ///
    /// `None` if the assumption itself refers to a variable of the system that is not a monitor or
    /// counter, or if the result is too large.
    pub fn without_outputs(&mut self, expr: &Expr) -> Option<Expr> {
        let mut outputs = BTreeSet::new();
        expr.for_each_var(&mut |v, time| {
            let output = self.monitors.get(v).is_none() && self.variable(v).owner == Owner::System;
            if output && time == Time::Now {
                outputs.insert(v);
            }
        });
        let around = self.origin.span;
        let is_direct = |v: VarId, span: Span| outputs.contains(&v) && around.contains(span);
        let mut mentions = self.mentions.iter();
        if mentions.any(|(v, span)| is_direct(*v, *span) && !self.watchers.contains(v)) {
            return None;
        }
        let first = *outputs.first()?;
        let mut left = expr.clone();
        for v in &outputs {
            left = self.for_some_value(&left, *v)?;
        }
        let name = self.variable(first).name.clone();
        self.note(
            codes::OWN_TOOL,
            around,
            format!("this assumption refers to `{name}`, which the system chooses after the environment: as in Spectra's tool, the assumption only requires that some values of the system's variables satisfy it"),
            "refer only to the environment's variables, and write guarantees about the system's initial values",
        );
        Some(left)
    }

    /// An expression that is true if `expr` is true for some value of `v`.
    fn for_some_value(&mut self, expr: &Expr, v: VarId) -> Option<Expr> {
        let domain = self.variable(v).domain.clone();
        let size = Value::of(expr.clone(), Kind::Bool).size;
        if domain.size() > MAX_VALUES {
            return None;
        }
        self.spend(size.saturating_mul(domain.size()), self.origin.span)?;
        let mut cases: Vec<Value> = Vec::new();
        for value in domain.low()..=domain.high() {
            let put = |w, time| {
                if w == v {
                    Expr::Const(value)
                } else {
                    Expr::Var(w, time)
                }
            };
            match expr.substitute(&mut |w, time| put(w, time)).simplify() {
                Expr::Const(0) => {}
                Expr::Const(_) => return Some(Expr::TRUE),
                case if cases.iter().any(|c| c.expr == case) => {}
                case => cases.push(Value::of(case, Kind::Bool)),
            }
        }
        let found = Value::chain(BinaryOp::Or, cases);
        Some(self.check_size(found, self.origin.span)?.expr)
    }
}
