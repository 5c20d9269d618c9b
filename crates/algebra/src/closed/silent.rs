//! Why a component that answers first has no outputs: its assumptions about a step contradict each
//! other.
//!
//! Assumptions read no output of the step they are about, so whether some inputs keep them depends
//! only on the step before. If no inputs do, a table has no row, and no outputs to begin the step
//! with. To find the assumptions responsible, they are removed one by one as long as the rest still
//! contradict each other.

use super::{Closed, StuckComponent};
use crate::system::formulas;
use linewright_core::gr1::{Expr, Formula, Owner, Time, VarId, eval};
use linewright_solver::game::{Limit, Limits, Rule, RuleKind, Runs, SafetyViolationQuery};

impl Closed<'_> {
    /// Returns a minimal set of contradictory assumptions of a silent component: no inputs keep all
    /// of them in the last step of the run. Empty if some inputs do, which cannot happen with a
    /// verified table.
    ///
    /// # Errors
    /// When a limit was reached.
    pub fn contradiction(
        &self,
        stuck: &StuckComponent,
        limits: &Limits,
    ) -> Result<Vec<&Formula>, Limit> {
        let specification = &*self.machine.components[stuck.component].specification;
        let before = stuck
            .trace
            .len()
            .checked_sub(2)
            .map(|at| self.own(stuck.component, &stuck.trace[at]));
        let mut asked: Vec<&Formula> = Vec::new();
        let mut rules = Vec::new();
        for (kind, _, formula) in formulas(&specification.assumptions) {
            if let Some(expr) = in_step(kind, formula, before.as_deref()) {
                let kind = RuleKind::Initial;
                rules.push(Rule { kind, expr });
                asked.push(formula);
            }
        }
        let kind = RuleKind::Initial;
        let expr = Expr::FALSE;
        let broken = rules.len();
        rules.push(Rule { kind, expr });
        let mut runs = Runs::new(&specification.variables, rules, limits)?;
        let mut contradict = |kept: &[usize]| -> Result<bool, Limit> {
            let slip = SafetyViolationQuery {
                before: Vec::new(),
                last: kept.to_vec(),
                broken,
            };
            Ok(runs.step(&slip)?.is_none())
        };
        let mut kept: Vec<usize> = (0..broken).collect();
        if !contradict(&kept)? {
            return Ok(Vec::new());
        }
        for rule in 0..broken {
            let fewer: Vec<usize> = kept.iter().copied().filter(|k| *k != rule).collect();
            if contradict(&fewer)? {
                kept = fewer;
            }
        }
        Ok(kept.into_iter().map(|k| asked[k]).collect())
    }

    /// Returns the values of a component's own variables in a step.
    fn own(&self, component: usize, wires: &[i64]) -> Vec<i64> {
        let placed = &self.machine.components[component];
        let mut bindings = placed.bindings.iter();
        let mut outputs = self.taking[component].first..;
        let values = placed.specification.variables.iter().map(|v| {
            let value = match v.owner {
                Owner::Environment => bindings.next().map(|b| eval::eval(b, wires, &[])),
                Owner::System => outputs.next().map(|wire| wires[wire]),
            };
            value.unwrap_or_else(|| v.domain.low())
        });
        values.collect()
    }
}

/// Returns what an assumption requires of a step after these values, or of step 0, as a condition
/// on the values of that step.
fn in_step(kind: RuleKind, formula: &Formula, before: Option<&[i64]>) -> Option<Expr> {
    match (kind, before) {
        (RuleKind::Initial, None) | (RuleKind::Invariant, _) => Some(formula.expr.clone()),
        (RuleKind::Safety, Some(before)) => {
            Some(formula.expr.substitute(&mut |v: VarId, time| match time {
                Time::Now => Expr::Const(before[v.index()]),
                Time::Next => Expr::Var(v, Time::Now),
            }))
        }
        _ => None,
    }
}
