//! Emits the assumptions of a controller with explicit states as C functions.
//!
//! When the guards of such a controller were simplified, inputs that the assumptions exclude were
//! treated as don't-cares. The controller therefore also has transitions for some of these inputs,
//! and a step checks the assumptions before it searches for a transition.

use super::component::{cite, unused};
use super::expression;
use super::text::{comment, wrap};
use linewright_core::gr1::{Expr, Formula, Owner, Specification, Time, VarId};
use serde::Serialize;

/// The assumptions that a step must keep.
pub(super) struct Assumptions<'a> {
    specification: &'a Specification,
    /// Index of each variable among the inputs or the outputs.
    places: Vec<usize>,
    /// Variables that the assumptions read from the last step.
    kept: Vec<VarId>,
    /// Checks of step 0.
    first: Vec<Check>,
    /// Checks of later steps.
    later: Vec<Check>,
}

/// A formula as a C condition.
#[derive(Serialize)]
pub(super) struct Check {
    /// Comment that cites the formula: `grips: command = turn -> grip`.
    pub about: String,
    /// C condition.
    pub holds: String,
}

/// The body of a C function that checks several formulas.
#[derive(Serialize)]
pub(super) struct Checks<'a> {
    /// The parameters that no formula reads.
    unused: Vec<&'static str>,
    checks: &'a [Check],
}

/// The values of the last step that the controller's state stores.
#[derive(Serialize)]
pub(super) struct StoredStep {
    /// Comment with the variables' names.
    about: String,
    count: usize,
}

impl<'a> Assumptions<'a> {
    /// Collects the initial conditions and invariants for step 0, and the invariants and safety
    /// formulas for later steps, in this order.
    pub fn new(specification: &'a Specification) -> Self {
        let mut places = vec![0; specification.variables.len()];
        for (place, id) in specification.inputs().enumerate() {
            places[id.index()] = place;
        }
        for (place, id) in specification.outputs().enumerate() {
            places[id.index()] = place;
        }
        let mut found = Self {
            specification,
            places,
            kept: Vec::new(),
            first: Vec::new(),
            later: Vec::new(),
        };
        let side = &specification.assumptions;
        let initial = side.initial.iter().chain(&side.invariants);
        found.first = initial.filter_map(|f| found.check(f)).collect();
        let invariants = side.invariants.iter();
        found.later = invariants.filter_map(|f| found.check(f)).collect();
        for formula in &side.safety {
            formula.expr.simplify().for_each_var(&mut |v, t| {
                if t == Time::Now && !found.kept.contains(&v) {
                    found.kept.push(v);
                }
            });
        }
        found.kept.sort_unstable();
        let safety: Vec<Check> = side
            .safety
            .iter()
            .filter_map(|f| found.check_two_steps(f))
            .collect();
        found.later.extend(safety);
        found
    }

    /// Returns the check of a formula about the inputs of one step.
    fn check(&self, formula: &Formula) -> Option<Check> {
        check(formula, &|v, _| self.input(v))
    }

    /// Returns the check of a formula about the last step and the inputs of this one.
    fn check_two_steps(&self, formula: &Formula) -> Option<Check> {
        check(formula, &|v, t| match t {
            Time::Now => {
                let place = self.kept.binary_search(&v);
                format!("last[{}]", place.expect("the variable is kept"))
            }
            Time::Next => self.input(v),
        })
    }

    fn input(&self, v: VarId) -> String {
        format!("values[{}]", self.places[v.index()])
    }

    /// Values of the last step that the state must store, if any.
    pub fn kept(&self) -> Option<StoredStep> {
        let names: Vec<String> = self
            .kept
            .iter()
            .map(|v| comment(&self.specification.variable(*v).name))
            .collect();
        let about = format!(
            "    /* Values of the last step that assumptions read: {}. */",
            names.join(", ")
        );
        (!names.is_empty()).then(|| StoredStep {
            about: wrap(&about, "     * ").trim_start().to_owned(),
            count: names.len(),
        })
    }

    /// Returns the C expressions of the values to store for the next step. `output` returns the
    /// expression of the output with the given index.
    pub fn kept_values(&self, output: impl Fn(usize) -> String) -> Vec<String> {
        let kept = self.kept.iter();
        let values = kept.map(|v| match self.specification.variable(*v).owner {
            Owner::Environment => self.input(*v),
            Owner::System => output(self.places[v.index()]),
        });
        values.collect()
    }

    /// Operators called by the conditions.
    pub fn operators(&self) -> Vec<String> {
        let code = self.first.iter().chain(&self.later);
        expression::operators(&code.map(|c| c.holds.as_str()).collect::<String>())
    }

    /// Checks of step 0, if any.
    pub fn first(&self) -> Option<Checks<'_>> {
        checks(&self.first, &["values"])
    }

    /// Checks of every later step, if any.
    pub fn later(&self) -> Option<Checks<'_>> {
        checks(&self.later, &["last", "values"])
    }

    /// C condition that is true if a step breaks an assumption; `None` if there are no assumptions
    /// to check.
    pub fn broken(&self) -> Option<String> {
        let last = if self.kept.is_empty() {
            "NULL"
        } else {
            "state->last"
        };
        let first = "!assumed_first(values)";
        let later = format!("!assumed({last}, values)");
        match (self.first.is_empty(), self.later.is_empty()) {
            (true, true) => None,
            (false, true) => Some(format!("state->state < 0 && {first}")),
            (true, false) => Some(format!("state->state >= 0 && {later}")),
            (false, false) => Some(format!("state->state < 0 ? {first} : {later}")),
        }
    }
}

fn checks<'a>(checks: &'a [Check], parameters: &[&'static str]) -> Option<Checks<'a>> {
    (!checks.is_empty()).then(|| Checks {
        unused: unused(checks.iter().map(|c| c.holds.as_str()), parameters),
        checks,
    })
}

/// Check of a formula; `None` if the formula always holds.
fn check(formula: &Formula, name: &impl Fn(VarId, Time) -> String) -> Option<Check> {
    let expr = formula.expr.simplify();
    (expr != Expr::TRUE).then(|| Check {
        about: cite(formula),
        holds: wrap(&expression::truth(&expr, name), "          "),
    })
}
