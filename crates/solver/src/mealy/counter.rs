//! Counterstrategies: machines of the environment that keep all assumptions and win against every
//! controller.
//!
//! A counterstrategy is a [`Machine`] with swapped roles: its inputs are the contract's outputs,
//! its outputs are the contract's inputs. Against a Mealy contract, the environment moves first, so
//! the counterstrategy is a Moore machine. Against a Moore contract, the environment answers, so it
//! is a Mealy machine. Answers of the controller that break a guarantee need no transition, because
//! the controller has lost. If every answer breaks a guarantee, a single transition leads to an
//! arbitrary state.

use super::extract::{ports, transition};
use super::{Machine, Transition};
use crate::game::{Attack, Row};
use linewright_core::gr1::{Specification, Timing};

/// Converts a counterstrategy to a machine, which is not verified yet.
pub fn to_machine(specification: &Specification, attack: &Attack) -> Machine {
    let rows = |rows: &[Row]| -> Vec<Transition> { rows.iter().cloned().map(transition).collect() };
    Machine {
        name: format!("{} (counterstrategy)", specification.name),
        timing: match specification.timing {
            Timing::Mealy => Timing::Moore,
            Timing::Moore => Timing::Mealy,
        },
        inputs: ports(specification, specification.outputs()),
        outputs: ports(specification, specification.inputs()),
        initial: rows(&attack.explicit.initial),
        states: attack.explicit.states.iter().map(|s| rows(s)).collect(),
        goals: Vec::new(),
    }
}
