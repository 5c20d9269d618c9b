//! Initial conditions that say more than one side can keep in the first step.
//!
//! Spectra's type checker looks for that in a formula itself, not in the definitions that it uses.
//! What gets through has a meaning:
//!
//! | | |
//! |---|---|
//! | `asm` of what the machine chooses | the environment keeps what it can: some values of the machine would do |
//! | `next` | the formula holds in the first step, which refers to the second |

use super::reader::Reader;
use super::value::{Kind, Value};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{BinaryOp, Expr, Owner, Time, VarId};
use linewright_core::source::Span;
use std::collections::BTreeSet;

/// Maximum number of values of a variable that is eliminated from an assumption.
const MAX_VALUES: u64 = 1 << 12;

impl Reader {
    /// An initial condition over two steps, as a formula from each step to the next: it holds where
    /// no step was before.
    pub fn first_transition(&mut self, expr: Expr) -> Expr {
        let origin = self.origin.clone();
        let finding = Diagnostic::warning(
            codes::NOTATION,
            origin.span,
            "an initial condition refers to the next step: it is kept from the first step to the second, and no longer",
        )
        .with_help("write `G` before it if it is meant of all steps; else describe the first step alone");
        self.findings.push(finding);
        self.monitors.previous(&Expr::TRUE, &origin).or(expr)
    }

    /// What an initial assumption leaves to the environment, if the machine's variables are in it
    /// through definitions, monitors and counters only; nothing where it refers to them itself, or
    /// would become too large.
    pub fn left_to_environment(&mut self, expr: &Expr) -> Option<Expr> {
        let mut outputs = BTreeSet::new();
        expr.for_each_var(&mut |v, time| {
            let output = self.monitors.get(v).is_none() && self.variable(v).owner == Owner::System;
            if output && time == Time::Now {
                outputs.insert(v);
            }
        });
        let around = self.origin.span;
        let said = |v: VarId, span: Span| outputs.contains(&v) && around.holds(span);
        let mut mentions = self.mentions.iter();
        if mentions.any(|(v, span)| said(*v, *span) && !self.watchers.contains(v)) {
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
            format!("this assumption refers to `{name}`, which the system chooses after the environment: what is assumed is that some values of the system's variables would keep it, as in Spectra's tool"),
            "refer to the environment's variables only; what the system begins with is a guarantee",
        );
        Some(left)
    }

    /// Whether an expression is true for some value of a variable.
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
        Some(self.sized(found, self.origin.span)?.expr)
    }
}
