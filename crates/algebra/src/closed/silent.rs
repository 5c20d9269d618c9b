//! Explains why a component that answers first has no outputs: its assumptions about a step
//! contradict each other.
//!
//! Assumptions do not read outputs of the step that they constrain. So whether any inputs satisfy
//! them depends only on the step before. If no inputs do, the table has no row for the step, and
//! therefore no outputs. To find the responsible assumptions, they are removed one by one as long
//! as the others still contradict each other.

use super::{ClosedComposition, StuckComponent};
use linewright_core::gr1::{Expr, Formula, FormulaKind, Owner, Time, VarId, eval};
use linewright_solver::game::{Limit, Limits, Rule, Runs, SafetyViolationQuery};

impl ClosedComposition<'_> {
    /// Returns a minimal set of contradictory assumptions of a silent component: no inputs satisfy
    /// all of them in the last step of the run. The set is empty if some inputs do, which cannot
    /// happen with a verified table.
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
        for (kind, _, formula) in specification.assumptions.formulas() {
            if let Some(expr) = in_step(kind, formula, before.as_deref()) {
                let kind = FormulaKind::Initial;
                rules.push(Rule { kind, expr });
                asked.push(formula);
            }
        }
        let kind = FormulaKind::Initial;
        let expr = Expr::FALSE;
        let broken = rules.len();
        rules.push(Rule { kind, expr });
        let mut runs = Runs::new(&specification.variables, rules, limits)?;
        let mut contradict = |kept: &[usize]| -> Result<bool, Limit> {
            let query = SafetyViolationQuery {
                before: Vec::new(),
                last: kept.to_vec(),
                broken,
            };
            Ok(!runs.has_violation(&query)?)
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
        let mut outputs = self.participants[component].first..;
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

/// Returns the condition that an assumption puts on the values of a step after the values `before`,
/// or of step 0 without them; `None` if it puts none.
fn in_step(kind: FormulaKind, formula: &Formula, before: Option<&[i64]>) -> Option<Expr> {
    match (kind, before) {
        (FormulaKind::Initial, None) | (FormulaKind::Invariant, _) => Some(formula.expr.clone()),
        (FormulaKind::Safety, Some(before)) => {
            Some(formula.expr.substitute(&mut |v: VarId, time| match time {
                Time::Now => Expr::Const(before[v.index()]),
                Time::Next => Expr::Var(v, Time::Now),
            }))
        }
        _ => None,
    }
}
