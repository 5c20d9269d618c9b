//! Checks a machine's assumptions before its transitions.
//!
//! When a machine's guards were simplified, inputs that the assumptions exclude were treated as
//! don't-cares, so the machine also has transitions for some of these inputs. A step therefore
//! first evaluates the contract's assumptions one after the other. If an assumption is violated,
//! the step is refused, and the error names the first such assumption. For assumptions about two
//! steps, the block stores inputs of the previous step.
//!
//! Every assumption can be expressed in IEC 61131-3. An assumption whose condition would be longer
//! than [`MAX_CONDITION_CHARS`](super::expression::MAX_CONDITION_CHARS) is not checked. Inputs that
//! break it are then refused only if the machine has no transition for them, and the error does not
//! name the assumption.

use super::Variable;
use super::expression::Translator;
use super::interface::{BlockVariables, Interface, mentions};
use super::text::{indented, wrap_condition};
use linewright_core::gr1::{Expr, Formula, Specification, Time};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Assumptions as statements.
pub(super) struct Assumptions {
    no_step: String,
    state: String,
    first: String,
    later: String,
    /// Stored inputs of the previous step: the variable, the input that it copies, and its value
    /// before step 0.
    kept: Vec<(Variable, String, String)>,
}

impl Assumptions {
    /// Converts the assumptions of a machine. `state` is the variable that holds the machine's
    /// state, which is negative before step 0.
    pub fn new(interface: &mut Interface<'_>, specification: &Specification, state: &str) -> Self {
        let side = &specification.assumptions;
        let mut kept = BTreeMap::new();
        for formula in &side.safety {
            formula.expr.for_each_var(&mut |v, t| {
                let place = specification.inputs().position(|i| i == v);
                if let (Time::Now, Some(place)) = (t, place) {
                    kept.insert(place, String::new());
                }
            });
        }
        for (place, name) in &mut kept {
            *name = interface.fresh(&format!("last_{}", interface.inputs[*place].name));
        }
        let mut first = String::new();
        let mut later = String::new();
        let mut used = String::new();
        let mut check =
            |interface: &mut Interface<'_>, out: &mut String, formula: &Formula, safety: bool| {
                let translator = Translator {
                    specification,
                    inputs: &interface.inputs,
                    outputs: &interface.outputs,
                    kept: safety.then_some(&kept),
                };
                if formula.expr.simplify() == Expr::TRUE {
                    return;
                }
                let Some(condition) = translator.violation(&formula.expr) else {
                    return;
                };
                used.push_str(&condition);
                used.push('\n');
                let label = interface.assumption_error(&formula.name);
                let word = if out.is_empty() { "IF" } else { "ELSIF" };
                let line = wrap_condition(&format!("{word} {condition} THEN"), "        ");
                let _ = writeln!(out, "{line}\n    {} := {label};", interface.own().refused);
            };
        for formula in &side.initial {
            check(interface, &mut first, formula, false);
        }
        for formula in &side.invariants {
            check(interface, &mut first, formula, false);
            check(interface, &mut later, formula, false);
        }
        for formula in &side.safety {
            check(interface, &mut later, formula, true);
        }
        for out in [&mut first, &mut later] {
            if !out.is_empty() {
                out.push_str("END_IF;\n");
            }
        }
        let kept = kept
            .into_iter()
            .filter(|(_, name)| mentions(&used, name))
            .map(|(place, name)| {
                let input = interface.inputs[place].variable();
                let copy = Variable {
                    name,
                    description: format!("{} in the previous step", input.name),
                    ..input.clone()
                };
                (copy, input.name, interface.inputs[place].initial_value())
            });
        Self {
            kept: kept.collect(),
            no_step: interface.no_step(),
            state: state.to_owned(),
            first,
            later,
        }
    }

    /// Label of the error for a step without a transition.
    pub fn no_step(&self) -> &str {
        &self.no_step
    }

    /// Returns the statements of a machine's step: they check the assumptions, take the transition,
    /// and store the inputs that the next step reads.
    pub fn around(&self, own: &BlockVariables, transition: &str) -> String {
        let (refused, no_error) = (&own.refused, &own.no_error);
        let mut out = String::new();
        let state = &self.state;
        let (first, later) = (indented(&self.first, 1), indented(&self.later, 1));
        let checks = match (first.is_empty(), later.is_empty()) {
            (true, true) => String::new(),
            (false, true) => format!("IF {state} < 0 THEN\n{first}END_IF;\n"),
            (true, false) => format!("IF {state} >= 0 THEN\n{later}END_IF;\n"),
            (false, false) => format!("IF {state} < 0 THEN\n{first}ELSE\n{later}END_IF;\n"),
        };
        if checks.is_empty() {
            out.push_str(transition);
        } else {
            let transition = indented(transition, 1);
            let _ = write!(
                out,
                "(* Assumptions. *)\n{checks}IF {refused} = {no_error} THEN\n{transition}END_IF;\n"
            );
        }
        if !self.kept.is_empty() {
            let _ = writeln!(out, "IF {refused} = {no_error} THEN");
            for (copy, input, _) in &self.kept {
                let _ = writeln!(out, "    {} := {input};", copy.name);
            }
            out.push_str("END_IF;\n");
        }
        out
    }

    /// Statements that reset the stored inputs.
    pub fn reset(&self) -> String {
        let kept = self.kept.iter();
        kept.fold(String::new(), |mut out, (copy, _, initial)| {
            let _ = writeln!(out, "{} := {initial};", copy.name);
            out
        })
    }

    /// Variables that store the inputs.
    pub fn into_locals(self) -> impl Iterator<Item = Variable> {
        self.kept.into_iter().map(|(copy, ..)| copy)
    }
}
