//! Checks the form of machines and counterstrategies, and collects the formulas about a step.

use super::Clause;
use super::residual::{Id, Pool};
use crate::mealy::{Machine, Port};
use linewright_core::gr1::{Formula, Specification, Time, Timing, VarId};

/// Returns the clause that the form of a machine violates, if any: ports, timing or transitions.
/// The machine reads the variables `reads` and sets the variables `gives`.
pub(super) fn malformed(
    machine: &Machine,
    specification: &Specification,
    [reads, gives]: [&[VarId]; 2],
    timing: Timing,
) -> Option<Clause> {
    let same = |ports: &[Port], ids: &[VarId]| {
        let variables = ids.iter().map(|v| specification.variable(*v));
        ports.len() == ids.len()
            && ports
                .iter()
                .zip(variables)
                .all(|(p, v)| p.name == v.name && p.domain == v.domain)
    };
    if !same(&machine.inputs, reads) || !same(&machine.outputs, gives) {
        return Some(Clause::Ports);
    }
    if machine.timing != timing {
        return Some(Clause::Timing);
    }
    for transitions in std::iter::once(&machine.initial).chain(&machine.states) {
        for transition in transitions {
            if transition.to >= machine.states.len() {
                return Some(Clause::MissingTarget);
            }
            if transition.output.len() != gives.len() {
                return Some(Clause::OutputCount);
            }
            for (port, value) in machine.outputs.iter().zip(&transition.output) {
                if !port.domain.contains(*value) {
                    return Some(Clause::Domain(port.name.clone()));
                }
            }
            let mut tests = transition.guard.0.iter().flat_map(|c| &c.0);
            if tests.any(|t| t.input >= reads.len()) {
                return Some(Clause::UnknownInput);
            }
            if timing == Timing::Moore && transition.output != transitions[0].output {
                return Some(Clause::FirstMover);
            }
        }
    }
    None
}

/// The formulas of a specification as conditions on the next step. They come in this order: initial
/// conditions, invariants and safety of the environment; the same of the machine; the justice of
/// both. Formulas about a single step refer to the next step.
pub(super) struct Rules {
    /// Conditions on step 0, where safety and justice do not apply.
    pub(super) start: Vec<Id>,
    /// Conditions on later steps, where initial conditions do not apply.
    pub(super) step: Vec<Id>,
    /// Numbers of conditions of the environment and of the machine, without justice.
    pub(super) counts: [usize; 2],
    /// Names of the formulas, without justice.
    pub(super) names: Vec<String>,
}

impl Rules {
    /// Collects the formulas of a specification.
    pub(super) fn of(specification: &Specification, pool: &mut Pool) -> Self {
        let sides = [&specification.assumptions, &specification.guarantees];
        let (mut start, mut step, mut names) = (Vec::new(), Vec::new(), Vec::new());
        let (no, yes) = (pool.constant(0), pool.constant(1));
        let counts = sides.map(|side| {
            let before = names.len();
            let mut list = |formulas: &[Formula], at_start: bool, at_step: bool| {
                for formula in formulas {
                    let to_come = pool.add(&formula.expr, &|_| Time::Next);
                    start.push(if at_start { to_come } else { yes });
                    step.push(match (at_start, at_step) {
                        (_, false) => yes,
                        (true, true) => to_come,
                        (false, true) => pool.add(&formula.expr, &|t| t),
                    });
                    names.push(formula.name.clone());
                }
            };
            list(&side.initial, true, false);
            list(&side.invariants, true, true);
            list(&side.safety, false, true);
            names.len() - before
        });
        for formula in sides.iter().flat_map(|side| &side.justice) {
            start.push(no);
            step.push(pool.add(&formula.expr, &|t| t));
        }
        Self {
            start,
            step,
            counts,
            names,
        }
    }
}
