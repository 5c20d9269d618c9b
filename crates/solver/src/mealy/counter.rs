//! Counterstrategies: machines of the environment that keep all assumptions and beat every
//! controller.
//!
//! A counterstrategy is a [`Machine`] with swapped roles: its inputs are the contract's outputs,
//! its outputs the contract's inputs. Against a Mealy contract the environment moves first, so it
//! is of Moore kind; against a Moore contract it answers and is of Mealy kind. Answers of the
//! controller that break a guarantee need no transition: the controller has lost then. If every
//! answer does, the single transition leads to a state that no longer matters.

use super::extract::{ports, transition};
use super::{Machine, Transition};
use crate::game::{Attack, Row};
use linewright_core::gr1::{Specification, Timing};

/// The machine of a counterstrategy, not yet verified.
pub fn machine(specification: &Specification, attack: &Attack) -> Machine {
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
    }
}
