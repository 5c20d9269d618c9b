//! Checks whether the synthesized coordinator and actions fit together.
//!
//! Each contract was checked alone; this module checks their composition. The coordinator's machine
//! is small and explicit, so the check visits its reachable states. Everything else (action
//! outputs, properties, signals) can take every value that the machine's file allows. Whatever
//! holds under these conditions also holds in the composition. Whatever does not hold under them
//! might still hold in the composition, so it gives a warning.
//!
//! - **Safety assumptions.** In every reachable step of the coordinator, every assumption of every
//!   component must follow from the coordinator's outputs, from the guarantees of the actions, and
//!   from what stays constant during an operation. Circular reasoning about safety is sound,
//!   because it proceeds step by step and no step contains a loop (Abadi and Lamport, Conjoining
//!   Specifications, 1995).
//! - **Justice assumptions.** Whenever a justice assumption of the coordinator does not hold, it
//!   must hold in the next step, or one fixed action must have a justice guarantee that implies it,
//!   or a contract from which such a formula follows. A justice assumption of an action must follow
//!   from the step alone or from a signal's script. Any other assumption gives a warning, because
//!   it might hold for a more complex reason. The proofs are not circular (McMillan, Circular
//!   Compositional Reasoning about Liveness, 1999).
//! - **Operations.** From every state in which the coordinator accepts an operation, every fair run
//!   reaches `done` and executes exactly the actions that the operation names.
//!
//! Assumptions that depend only on the operation and the part that the line chooses are *exported*:
//! they are checked when the library is called. If all assumptions are discharged or exported, no
//! run gets stuck, because every component's machine answers every input that keeps its
//! assumptions.
//!
//! Several coordinators are first merged into one (`merged.rs`).
//!
//! Machines without a coordinator export all their assumptions.

mod diagrams;
mod merged;
mod operations;
mod query;
#[cfg(test)]
mod tests;
mod walk;

use linewright_algebra::machine;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::{Expr, Formula, Time, VarId};
use linewright_language::contract::machine::{Component, Machine, Role};
use linewright_solver::mealy;
use query::{Answer, Question};
use walk::{Node, Walk};

/// An assumption of a component, and what discharges it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Discharge {
    /// Name of the component.
    pub component: String,
    /// Name of the assumption.
    pub assumption: String,
    /// What discharges the assumption.
    pub by: Discharger,
}

/// What discharges an assumption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Discharger {
    /// A guarantee of another component, by its qualified name: `cell: pick_open`. A justice
    /// assumption can need several, separated by commas.
    Guarantee(String),
    /// The coordinator's behavior in all its reachable states, together with guarantees of actions.
    Coordinator,
    /// Values that the machine's file fixes: constant signals, scripts of signals, bindings.
    Plant,
    /// The line's choice of the operation and the part, which the library checks in every call.
    Line,
}

/// Result of checking a machine's composition.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Composition {
    /// The discharged assumptions, in component order.
    pub discharges: Vec<Discharge>,
    /// Findings: LW303, LW304, LW306.
    pub findings: Vec<Diagnostic>,
}

/// Checks the composition of a machine whose components have these verified controllers, in order.
///
/// If a coordinator's controller does not have explicit states, every assumption is reported as
/// undecided. Without a coordinator, or if there is not one controller per component, every
/// assumption is left to the line.
pub fn check(machine: &Machine, controllers: &[&mealy::Controller]) -> Composition {
    let mut result = Composition::default();
    if machine.coordinator().is_none() || controllers.len() != machine.components.len() {
        for component in &machine.components {
            for formula in component.specification.assumptions.all() {
                result.discharges.push(Discharge {
                    component: component.name.clone(),
                    assumption: formula.name.clone(),
                    by: Discharger::Line,
                });
            }
        }
        return result;
    }
    if merged::has_several(machine) {
        let Some(merged) = merged::merge(machine, controllers) else {
            return undecided(machine);
        };
        let mut result = examine(&merged.machine, &merged.coordinator);
        merged::attribute(&mut result, &merged.machine);
        return result;
    }
    match controllers[0].machine() {
        Some(coordinator) => examine(machine, coordinator),
        None => undecided(machine),
    }
}

/// Checks a machine with one coordinator.
fn examine(machine: &Machine, coordinator: &mealy::Machine) -> Composition {
    let mut result = Composition::default();
    let walk = Walk::new(machine, coordinator);
    for index in 0..machine.components.len() {
        safety(&walk, index, &mut result);
        justice(&walk, index, &mut result);
    }
    operations::check(&walk, &mut result.findings);
    result
}

/// Reports every assumption as undecided, because the coordinators of the machine cannot be
/// examined state by state.
fn undecided(machine: &Machine) -> Composition {
    let mut result = Composition::default();
    for component in &machine.components {
        let formulas = component.specification.assumptions.all();
        let unknown = formulas.map(|formula| unknown(component, formula));
        result.findings.extend(unknown);
    }
    result
}

/// Expresses a component's formula over wires: replaces inputs by their bindings, and outputs by
/// their wires.
pub(super) fn over_wires(machine: &Machine, index: usize, expr: &Expr) -> Expr {
    let component = &machine.components[index];
    let (specification, first) = (&component.specification, machine.first_wire(index));
    expr.substitute(&mut |v, time| {
        machine::over_wires(specification, &component.bindings, first, v, time)
    })
}

/// Checks the initial conditions, invariants and safety formulas that a component assumes.
fn safety(walk: &Walk<'_>, index: usize, result: &mut Composition) {
    let component = &walk.machine.components[index];
    let side = &component.specification.assumptions;
    for formula in &side.initial {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = vec![walk.question_at(Node::Start, &goal)];
        conclude(walk, index, formula, questions, result);
    }
    for formula in &side.invariants {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = walk.nodes().map(|n| walk.question_at(n, &goal)).collect();
        conclude(walk, index, formula, questions, result);
    }
    for formula in &side.safety {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = walk
            .steps()
            .flat_map(|s| walk.questions_for_step(s, &goal))
            .collect();
        conclude(walk, index, formula, questions, result);
    }
}

/// Answers the questions about a formula, and records the result.
fn conclude(
    walk: &Walk<'_>,
    index: usize,
    formula: &Formula,
    questions: Vec<Question>,
    result: &mut Composition,
) {
    let component = &walk.machine.components[index];
    let mut exported = false;
    for question in questions {
        match walk.ask(index, &question) {
            Answer::Holds => {}
            Answer::Fails(_) if walk.depends_only_on_line(&question) => exported = true,
            Answer::Fails(values) => {
                result
                    .findings
                    .push(undischarged(walk, component, formula, &values));
                return;
            }
            Answer::TooLarge => {
                result.findings.push(unknown(component, formula));
                return;
            }
        }
    }
    let by = if exported {
        Discharger::Line
    } else if walk.is_fixed(index, formula) {
        Discharger::Plant
    } else if let Some(name) = walk.single_guarantee(index, formula) {
        Discharger::Guarantee(name)
    } else {
        Discharger::Coordinator
    };
    result.discharges.push(Discharge {
        component: component.name.clone(),
        assumption: formula.name.clone(),
        by,
    });
}

/// Creates the finding for an assumption that these values violate.
fn undischarged(
    walk: &Walk<'_>,
    component: &Component,
    formula: &Formula,
    values: &query::Values,
) -> Diagnostic {
    Diagnostic::warning(
        codes::ASSUMPTION_UNDISCHARGED,
        component.span,
        format!(
            "the assumption `{}` of `{}` might not be discharged: {}",
            formula.name, component.name, formula.text
        ),
    )
    .with_label(formula.span, "this is assumed")
    .with_help(format!(
        "the coordinator allows that {}; add a guarantee that implies the assumption, bind the input to something else, or make the signal constant",
        values.show(walk.machine)
    ))
}

/// Creates the finding for an assumption that could not be decided.
fn unknown(component: &Component, formula: &Formula) -> Diagnostic {
    Diagnostic::warning(
        codes::ASSUMPTION_UNDISCHARGED,
        component.span,
        format!(
            "it was not decided whether the assumption `{}` of `{}` is discharged: too many values are involved",
            formula.name, component.name
        ),
    )
    .with_label(formula.span, "this is assumed")
    .with_help("use smaller domains so that it can be decided; the library checks it at run time in any case")
}

/// Checks the justice assumptions of a component.
fn justice(walk: &Walk<'_>, index: usize, result: &mut Composition) {
    let component = &walk.machine.components[index];
    for formula in &component.specification.assumptions.justice {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let met = if component.role == Role::Coordinator {
            walk.discharge_coordinator_justice(index, &goal)
        } else {
            walk.discharge_action_justice(index, &goal)
        };
        match met {
            Ok(by) => result.discharges.push(Discharge {
                component: component.name.clone(),
                assumption: formula.name.clone(),
                by,
            }),
            Err(values) => result.findings.push(
                Diagnostic::warning(
                    codes::ASSUMPTION_UNDISCHARGED,
                    component.span,
                    format!(
                        "it is not shown that the assumption `{}` of `{}` holds infinitely often: {}",
                        formula.name, component.name, formula.text
                    ),
                )
                .with_label(formula.span, "this is assumed")
                .with_help(match values {
                    Some(values) => format!(
                        "it can stay false with {}; add a guarantee `always eventually ...` that implies it to one action, or give a signal a script that makes it true",
                        values.show(walk.machine)
                    ),
                    None => "the coordinator can keep switching between the actions that it waits for; let it keep each request until the action is done".to_owned(),
                }),
            ),
        }
    }
}

/// Returns the wires that occur in an expression, each with its time, sorted.
fn support(expr: &Expr) -> Vec<(VarId, Time)> {
    let mut found = Vec::new();
    expr.for_each_var(&mut |v, t| {
        if !found.contains(&(v, t)) {
            found.push((v, t));
        }
    });
    found.sort_unstable();
    found
}
