//! The other player: the controller of a realizable contract, or the counterstrategy of one that is
//! not.

use linewright_core::gr1::{Owner, Timing};
use linewright_solver::mealy::functions::State;
use linewright_solver::mealy::{Controller, Machine};

/// The machine that plays against the person.
#[derive(Debug, Clone)]
pub enum Opponent {
    /// The person is the plant.
    Controller(Controller),
    /// The person is the machine. Inputs and outputs are swapped.
    Counterstrategy(Machine),
}

/// Position of the opponent between two steps.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// State of the machine; `None` before step 0.
    Machine(Option<usize>),
    /// State of the functions.
    Functions(State),
}

impl Opponent {
    /// The side that the person plays.
    pub fn person(&self) -> Owner {
        match self {
            Self::Controller(_) => Owner::Environment,
            Self::Counterstrategy(_) => Owner::System,
        }
    }

    /// Whether the opponent moves first in a step.
    pub(super) fn begins(&self) -> bool {
        let timing = match self {
            Self::Controller(controller) => controller.timing(),
            Self::Counterstrategy(machine) => machine.timing,
        };
        timing == Timing::Moore
    }

    pub(super) fn start(&self) -> Place {
        match self {
            Self::Controller(Controller::Functions(functions)) => {
                Place::Functions(functions.start())
            }
            _ => Place::Machine(None),
        }
    }

    /// The opponent's values for the upcoming step, if it moves first; `None` if the person has no
    /// way to go on.
    pub(super) fn given(&self, place: &Place) -> Option<Vec<i64>> {
        if let (Self::Controller(Controller::Functions(functions)), Place::Functions(state)) =
            (self, place)
        {
            return Some(functions.moore_output(state));
        }
        let first = self.machine()?.transitions(state_of(place)).first()?;
        Some(first.output.clone())
    }

    /// The opponent's values in a step with the person's values `moved`, and its next position.
    /// `None` if they break a rule.
    pub(super) fn answer(&self, place: &Place, moved: &[i64]) -> Option<(Vec<i64>, Place)> {
        if let (Self::Controller(Controller::Functions(functions)), Place::Functions(state)) =
            (self, place)
        {
            let mut state = state.clone();
            let values = functions.step(&mut state, moved).ok()?;
            return Some((values, Place::Functions(state)));
        }
        let taken = self.machine()?.step(state_of(place), moved)?;
        Some((taken.output.clone(), Place::Machine(Some(taken.to))))
    }

    fn machine(&self) -> Option<&Machine> {
        match self {
            Self::Controller(controller) => controller.machine(),
            Self::Counterstrategy(machine) => Some(machine),
        }
    }
}

fn state_of(place: &Place) -> Option<usize> {
    match place {
        Place::Machine(state) => *state,
        Place::Functions(_) => None,
    }
}
