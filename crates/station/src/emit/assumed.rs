//! The assumptions of a controller with explicit states, as C functions.
//!
//! Its guards were put together over inputs that the assumptions exclude, so it has transitions for some of those, too. Whether a
//! step keeps the assumptions is therefore asked before any transition is looked for.

use super::component::{cite, unused, without_comments};
use super::expression;
use super::text::{comment, wrap};
use linewright_core::gr1::{Expr, Formula, Owner, Specification, Time, VarId};
use std::fmt::Write;

/// The assumptions that a step must keep.
pub(super) struct Assumptions<'a> {
    specification: &'a Specification,
    /// The place of each variable among the inputs or the outputs.
    places: Vec<usize>,
    /// The variables whose values in the last step are asked for.
    kept: Vec<VarId>,
    /// What is asked of step 0, as statements.
    first: String,
    /// What is asked of later steps.
    later: String,
}

impl<'a> Assumptions<'a> {
    /// Initial conditions and invariants for step 0, invariants and safety for later steps, in this order.
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
            first: String::new(),
            later: String::new(),
        };
        let side = &specification.assumptions;
        for formula in side.initial.iter().chain(&side.invariants) {
            found.first += &found.check(formula);
        }
        for formula in &side.invariants {
            found.later += &found.check(formula);
        }
        for formula in &side.safety {
            formula.expr.simplify().for_each_var(&mut |v, t| {
                if t == Time::Now && !found.kept.contains(&v) {
                    found.kept.push(v);
                }
            });
        }
        found.kept.sort_unstable();
        for formula in &side.safety {
            found.later += &found.check_of_two(formula);
        }
        found
    }

    /// A formula about the inputs of one step.
    fn check(&self, formula: &Formula) -> String {
        statement(formula, &|v, _| self.input(v))
    }

    /// A formula about the last step and the inputs of this one.
    fn check_of_two(&self, formula: &Formula) -> String {
        statement(formula, &|v, t| match t {
            Time::Now => {
                let place = self.kept.binary_search(&v);
                format!("last[{}]", place.expect("it is kept"))
            }
            Time::Next => self.input(v),
        })
    }

    fn input(&self, v: VarId) -> String {
        format!("values[{}]", self.places[v.index()])
    }

    /// What is kept of the last step, as fields of the state.
    pub fn fields(&self) -> String {
        if self.kept.is_empty() {
            return String::new();
        }
        let names = self.kept.iter();
        let names = names.map(|v| comment(&self.specification.variable(*v).name));
        let names: Vec<String> = names.collect();
        let about = format!(
            "    /* The last step's values that assumptions speak of: {}. */",
            names.join(", ")
        );
        let about = wrap(&about, "     * ");
        format!("{about}\n    int64_t last[{}];\n", self.kept.len())
    }

    /// Statements that forget the last step.
    pub fn reset(&self) -> String {
        let kept = 0..self.kept.len();
        kept.fold(String::new(), |mut out, place| {
            let _ = writeln!(out, "    state->last[{place}] = 0;");
            out
        })
    }

    /// The functions that tell whether a step keeps all of them, and the operators that they call.
    pub fn definitions(&self) -> String {
        let code = without_comments(&format!("{}{}", self.first, self.later));
        let mut out = expression::operators(&code);
        if !self.first.is_empty() {
            let _ = write!(
                out,
                "/* What is assumed of step 0. */\nstatic int assumed_first(const int64_t *values)\n{{\n{}{}    return 1;\n}}\n\n",
                unused(&self.first, &["values"]),
                self.first
            );
        }
        if !self.later.is_empty() {
            let _ = write!(
                out,
                "/* What is assumed of every later step. */\nstatic int assumed(const int64_t *last, const int64_t *values)\n{{\n{}{}    return 1;\n}}\n\n",
                unused(&self.later, &["last", "values"]),
                self.later
            );
        }
        out
    }

    /// Statements that refuse a step that breaks one.
    pub fn refuse(&self, code: &str) -> String {
        let last = if self.kept.is_empty() {
            "NULL"
        } else {
            "state->last"
        };
        let first = "!assumed_first(values)";
        let later = format!("!assumed({last}, values)");
        let broken = match (self.first.is_empty(), self.later.is_empty()) {
            (true, true) => return String::new(),
            (false, true) => format!("state->state < 0 && {first}"),
            (true, false) => format!("state->state >= 0 && {later}"),
            (false, false) => format!("state->state < 0 ? {first} : {later}"),
        };
        format!("    if ({broken}) {{\n        return {code};\n    }}\n")
    }

    /// Statements that keep what later steps ask for; `output` gives the text of an output's value.
    pub fn keep(&self, indent: &str, output: impl Fn(usize) -> String) -> String {
        let kept = self.kept.iter().enumerate();
        kept.fold(String::new(), |mut out, (place, v)| {
            let value = match self.specification.variable(*v).owner {
                Owner::Environment => self.input(*v),
                Owner::System => output(self.places[v.index()]),
            };
            let _ = writeln!(out, "{indent}state->last[{place}] = {value};");
            out
        })
    }
}

/// The statement that ends the function where a formula does not hold; none for one that always does.
fn statement(formula: &Formula, name: &impl Fn(VarId, Time) -> String) -> String {
    let expr = formula.expr.simplify();
    if expr == Expr::TRUE {
        return String::new();
    }
    format!(
        "    /* {} */\n    if (!({})) {{\n        return 0;\n    }}\n",
        cite(formula),
        wrap(&expression::truth(&expr, name), "          ")
    )
}
