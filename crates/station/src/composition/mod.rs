//! Checks whether the synthesized coordinator and actions fit together.
//!
//! Each contract was checked alone; this checks their composition. The coordinator's machine is
//! small and explicit, so its reachable states are walked, with everything else (action outputs,
//! properties, signals) as free as the machine's file leaves it. What holds then holds in the
//! composition. What does not may still hold, so it is a warning.
//!
//! - **Safety assumptions.** In every reachable step of the coordinator, every assumption of every
//!   component must follow from the coordinator's outputs, from the guarantees of the actions, and
//!   from what stays constant during an operation. Circles of safety are sound, step by step, since
//!   no step contains a loop (Abadi and Lamport, Conjoining Specifications, 1995).
//! - **Justice assumptions.** While an assumption of the coordinator waits, it must certainly come
//!   true in the next step, or one fixed action must have a justice guarantee that implies it; an
//!   action's own justice assumptions must follow from the step alone or from a signal's script.
//!   Anything else is a warning, since it may hold for a more complex reason. This is an order, not
//!   a circle (McMillan, Circular Compositional Reasoning about Liveness, 1999).
//! - **Operations.** From every state in which the coordinator accepts an operation, every fair run
//!   reaches `done`, and runs exactly the actions that the operation names.
//!
//! Assumptions that depend only on the choice of the operation and the part concern the line: they
//! are *exported*, and checked when the library is called. With all assumptions discharged or
//! exported nothing gets stuck, since every component's machine answers every input that keeps its
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

/// How an assumption of a component is met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Discharge {
    /// Name of the component.
    pub component: String,
    /// Name of the assumption.
    pub assumption: String,
    /// What meets it.
    pub by: Discharger,
}

/// What meets an assumption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Discharger {
    /// A guarantee of another component, by its qualified name: `cell: pick_open`.
    Guarantee(String),
    /// Several guarantees of the coordinator together, in all its reachable states.
    Coordinator,
    /// Values fixed by the machine's file: constant signals, values held during an operation.
    Plant,
    /// The line, by its choice of the operation and the part; checked at every call.
    Line,
}

/// Result of checking a machine's composition.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Composition {
    /// How each assumption is met, in component order.
    pub discharges: Vec<Discharge>,
    /// Problems: LW303, LW304, LW306.
    pub findings: Vec<Diagnostic>,
}

/// Checks the composition of a machine whose components have these verified controllers.
///
/// The coordinator's controller must be a machine (state by state); otherwise nothing is decided.
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
        merged::apart(&mut result, &merged.machine);
        return result;
    }
    match controllers[0].machine() {
        Some(coordinator) => examine(machine, coordinator),
        None => undecided(machine),
    }
}

/// Result for a machine with one coordinator.
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

/// Result for a machine whose coordinators cannot be walked.
fn undecided(machine: &Machine) -> Composition {
    let mut result = Composition::default();
    for component in &machine.components {
        let formulas = component.specification.assumptions.all();
        let unknown = formulas.map(|formula| unknown(component, formula));
        result.findings.extend(unknown);
    }
    result
}

/// A component's formula over wires: inputs are replaced by their bindings, outputs by their wires.
pub(super) fn over_wires(machine: &Machine, index: usize, expr: &Expr) -> Expr {
    let component = &machine.components[index];
    let (specification, first) = (&component.specification, machine.first_wire(index));
    expr.substitute(&mut |v, time| {
        machine::over_wires(specification, &component.bindings, first, v, time)
    })
}

/// Checks initial conditions, invariants and safety.
fn safety(walk: &Walk<'_>, index: usize, result: &mut Composition) {
    let component = &walk.machine.components[index];
    let side = &component.specification.assumptions;
    for formula in &side.initial {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = vec![walk.now(Node::Start, &goal)];
        conclude(walk, index, formula, questions, result);
    }
    for formula in &side.invariants {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = walk.nodes().map(|n| walk.now(n, &goal)).collect();
        conclude(walk, index, formula, questions, result);
    }
    for formula in &side.safety {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let questions = walk.steps().flat_map(|s| walk.step(s, &goal)).collect();
        conclude(walk, index, formula, questions, result);
    }
}

/// Answers all questions of a formula, and records the result.
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
            Answer::Fails(_) if walk.is_lines_choice(&question) => exported = true,
            Answer::Fails(values) => {
                result
                    .findings
                    .push(open(walk, component, formula, &values));
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

fn open(
    walk: &Walk<'_>,
    component: &Component,
    formula: &Formula,
    values: &query::Values,
) -> Diagnostic {
    Diagnostic::warning(
        codes::ASSUMPTION_OPEN,
        component.span,
        format!(
            "the assumption `{}` of `{}` may not be discharged: {}",
            formula.name, component.name, formula.text
        ),
    )
    .with_label(formula.span, "this is assumed")
    .with_help(format!(
        "the coordinator alone allows that {}; let it guarantee the assumption, bind the input to something else, or fix the signal",
        values.show(walk.machine)
    ))
}

fn unknown(component: &Component, formula: &Formula) -> Diagnostic {
    Diagnostic::warning(
        codes::ASSUMPTION_OPEN,
        component.span,
        format!(
            "whether the assumption `{}` of `{}` is discharged was not decided: too many values are involved",
            formula.name, component.name
        ),
    )
    .with_label(formula.span, "this is assumed")
    .with_help("it is checked when the library runs; smaller domains let it be decided beforehand")
}

/// Checks justice assumptions.
fn justice(walk: &Walk<'_>, index: usize, result: &mut Composition) {
    let component = &walk.machine.components[index];
    for formula in &component.specification.assumptions.justice {
        let goal = over_wires(walk.machine, index, &formula.expr);
        let met = if component.role == Role::Coordinator {
            walk.owed(index, &goal)
        } else {
            walk.comes_by_itself(index, &goal)
        };
        match met {
            Ok(by) => result.discharges.push(Discharge {
                component: component.name.clone(),
                assumption: formula.name.clone(),
                by,
            }),
            Err(values) => result.findings.push(
                Diagnostic::warning(
                    codes::ASSUMPTION_OPEN,
                    component.span,
                    format!(
                        "nothing makes the assumption `{}` of `{}` come true again and again: {}",
                        formula.name, component.name, formula.text
                    ),
                )
                .with_label(formula.span, "this is assumed")
                .with_help(match values {
                    Some(values) => format!(
                        "it may stay false where {}; give one action a guarantee `always eventually ...` that implies it, or a signal a script that makes it true",
                        values.show(walk.machine)
                    ),
                    None => "the coordinator passes from one action's wait to another's without an end; hold the request until it is done".to_owned(),
                }),
            ),
        }
    }
}

/// The wires of variables that occur in an expression.
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
