//! The other player: the controller of a realizable contract, or the counterstrategy of one that is
//! not.

use linewright_core::gr1::{Owner, Timing};
use linewright_solver::mealy::functions::State;
use linewright_solver::mealy::{Controller, Machine};

/// Who answers the person.
#[derive(Debug, Clone)]
pub enum Opponent {
    /// The person is the plant.
    Controller(Controller),
    /// The person is the machine. Inputs and outputs are the other way round.
    Counterstrategy(Machine),
}

/// Where the other player is between two steps.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// A state, or none before step 0.
    Machine(Option<usize>),
    /// The state of functions.
    Functions(State),
}

impl Opponent {
    /// Whose values the person gives.
    pub fn person(&self) -> Owner {
        match self {
            Self::Controller(_) => Owner::Environment,
            Self::Counterstrategy(_) => Owner::System,
        }
    }

    /// Whether it gives its values before it sees the person's.
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

    /// What it gives in the step to come, where it begins; nothing where the person has no way on.
    pub(super) fn given(&self, place: &Place) -> Option<Vec<i64>> {
        if let (Self::Controller(Controller::Functions(functions)), Place::Functions(state)) =
            (self, place)
        {
            return Some(functions.moore_output(state));
        }
        let first = self.machine()?.transitions(state_of(place)).first()?;
        Some(first.output.clone())
    }

    /// What it gives in a step in which the person gives these values, and where it is then. None
    /// where they break a rule.
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
