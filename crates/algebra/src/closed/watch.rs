//! Variables that check that each operation runs exactly the actions it names, and is done only
//! after the last one.
//!
//! Every step belongs to a call. A call begins in step 0, or in the step after one in which the
//! previous operation was done. An action begins in a step in which it is active if it was not
//! active in the step before, or if a call begins. If several actions are active in a step, the one
//! declared first counts.

use super::add_internal_variable;
use super::table::{any, conjunction};
use crate::system::System;
use linewright_core::gr1::{BinaryOp, Domain, Expr, FormulaKind, Time, VarId};
use linewright_language::contract::machine::{Machine, PlantSource};
use linewright_solver::game::Rule;

/// Variables that track the actions of operations.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Watch {
    /// Wire with the requested operation; `None` if operations are not requested by a wire.
    pub operation: Option<VarId>,
    /// Number of actions that have begun in this call; it stops counting at one more than the
    /// number of actions of the longest operation.
    pub begun: VarId,
}

impl Watch {
    /// Adds the variables for a machine to the system; `None` if the machine has no operations.
    pub(super) fn new(machine: &Machine, system: &mut System) -> Option<Self> {
        if machine.operations.is_empty() || machine.done.is_none() {
            return None;
        }
        let operation = machine
            .plant
            .iter()
            .position(|p| matches!(p.source, PlantSource::Operation))
            .map(|place| VarId(place as u32));
        let begun = Domain::Range {
            low: 0,
            high: longest(machine) + 1,
        };
        let name = system.fresh_name("actions begun");
        Some(Self {
            operation,
            begun: add_internal_variable(system, name, begun, machine.span),
        })
    }

    /// Returns the rules that define the values of the variables.
    pub(super) fn rules(&self, machine: &Machine) -> [Rule; 2] {
        let done = machine.done.clone().unwrap_or(Expr::FALSE);
        let begins = |time| active(machine, time).equals(Expr::Const(0)).not();
        let same = active(machine, Time::Next).equals(active(machine, Time::Now));
        let before = choose(done.clone(), Expr::Const(0), Expr::now(self.begun));
        let more = choose(
            begins(Time::Next).and(done.or(same.not())),
            Expr::binary(
                BinaryOp::Min,
                Expr::binary(BinaryOp::Add, before.clone(), Expr::Const(1)),
                Expr::Const(longest(machine) + 1),
            ),
            before,
        );
        let first = choose(begins(Time::Now), Expr::Const(1), Expr::Const(0));
        [
            Rule {
                kind: FormulaKind::Initial,
                expr: Expr::now(self.begun).equals(first).simplify(),
            },
            Rule {
                kind: FormulaKind::Safety,
                expr: Expr::next(self.begun).equals(more).simplify(),
            },
        ]
    }

    /// Returns the condition that an operation is running.
    pub(super) fn runs(&self, machine: &Machine, operation: usize) -> Expr {
        self.operation.map_or(Expr::TRUE, |wire| {
            Expr::now(wire).equals(Expr::Const(machine.operations[operation].value))
        })
    }

    /// Returns two rules: an initial one, that the first call is not for this operation, and a
    /// safety rule, that no later call is.
    pub(super) fn never_begins(&self, machine: &Machine, operation: usize) -> [Rule; 2] {
        let runs = self.runs(machine, operation);
        let next = runs.substitute(&mut |v, _| Expr::Var(v, Time::Next));
        let done = machine.done.clone().unwrap_or(Expr::FALSE);
        [
            Rule {
                kind: FormulaKind::Initial,
                expr: runs.not().simplify(),
            },
            Rule {
                kind: FormulaKind::Safety,
                expr: done.implies(next.not()).simplify(),
            },
        ]
    }

    /// Returns the condition that, while an operation runs, the actions run in the order that it
    /// names, and it is done only after the last one.
    ///
    /// It is a conjunction over the actions: the numbers of the active action and of the named one,
    /// as functions of all conditions of activity, would be far larger.
    pub(super) fn in_order(&self, machine: &Machine, operation: usize) -> Expr {
        let sequence = &machine.operations[operation].sequence;
        let begun = |count: usize| Expr::now(self.begun).equals(Expr::Const(count as i64));
        let mut right = Vec::new();
        let mut idle = Expr::TRUE;
        for (index, component) in machine.components.iter().enumerate() {
            let Some(active) = &component.active else {
                continue;
            };
            let places = sequence.iter().enumerate();
            let named = places.filter(|(_, action)| **action == index);
            let named = any(named.map(|(place, _)| begun(place + 1)).collect());
            right.push(idle.clone().and(active.clone()).implies(named));
            idle = idle.and(active.clone().not());
        }
        let done = machine.done.clone().unwrap_or(Expr::FALSE);
        right.push(done.implies(begun(sequence.len())));
        self.runs(machine, operation)
            .implies(conjunction(right))
            .simplify()
    }
}

fn longest(machine: &Machine) -> i64 {
    let lengths = machine.operations.iter().map(|o| o.sequence.len());
    lengths.max().unwrap_or(0) as i64
}

/// Returns the number of the active component that is declared first, counted from 1; 0 if no
/// component is active.
fn active(machine: &Machine, time: Time) -> Expr {
    let components = machine.components.iter().enumerate().rev();
    components.fold(Expr::Const(0), |rest, (i, component)| {
        match &component.active {
            Some(active) => {
                let active = active.substitute(&mut |v, _| Expr::Var(v, time));
                choose(active, Expr::Const(i as i64 + 1), rest)
            }
            None => rest,
        }
    })
}

fn choose(condition: Expr, then: Expr, otherwise: Expr) -> Expr {
    Expr::If(Box::new(condition), Box::new(then), Box::new(otherwise))
}
