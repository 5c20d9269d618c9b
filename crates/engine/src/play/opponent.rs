//! The other player: the controller of a realizable contract, or the counterstrategy of an
//! unrealizable one.

use linewright_core::gr1::{Owner, Timing};
use linewright_solver::mealy::functions::State;
use linewright_solver::mealy::{Controller, Machine};

/// The machine that plays against the person.
#[derive(Debug, Clone)]
pub enum Opponent {
    /// A controller; the person plays the plant.
    Controller(Controller),
    /// A counterstrategy; the person plays the machine. Its inputs are the contract's outputs, and
    /// vice versa.
    Counterstrategy(Machine),
}

/// Position of the opponent between two steps.
#[derive(Debug, Clone)]
pub(super) enum Position {
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
    pub(super) fn moves_first(&self) -> bool {
        let timing = match self {
            Self::Controller(controller) => controller.timing(),
            Self::Counterstrategy(machine) => machine.timing,
        };
        timing == Timing::Moore
    }

    pub(super) fn start(&self) -> Position {
        match self {
            Self::Controller(Controller::Functions(functions)) => {
                Position::Functions(functions.initial_state())
            }
            _ => Position::Machine(None),
        }
    }

    /// The opponent's values for the upcoming step, if it moves first; `None` if the person has no
    /// legal move left.
    pub(super) fn first_values(&self, position: &Position) -> Option<Vec<i64>> {
        if let (Self::Controller(Controller::Functions(functions)), Position::Functions(state)) =
            (self, position)
        {
            return Some(functions.moore_output(state));
        }
        let first = self.machine()?.transitions(state_of(position)).first()?;
        Some(first.output.clone())
    }

    /// The opponent's values in a step with the person's values `moved`, and its next position.
    /// `None` if `moved` breaks a rule.
    pub(super) fn answer(
        &self,
        position: &Position,
        moved: &[i64],
    ) -> Option<(Vec<i64>, Position)> {
        if let (Self::Controller(Controller::Functions(functions)), Position::Functions(state)) =
            (self, position)
        {
            let mut state = state.clone();
            let values = functions.step(&mut state, moved).ok()?;
            return Some((values, Position::Functions(state)));
        }
        let taken = self.machine()?.step(state_of(position), moved)?;
        Some((taken.output.clone(), Position::Machine(Some(taken.to))))
    }

    fn machine(&self) -> Option<&Machine> {
        match self {
            Self::Controller(controller) => controller.machine(),
            Self::Counterstrategy(machine) => Some(machine),
        }
    }
}

fn state_of(position: &Position) -> Option<usize> {
    match position {
        Position::Machine(state) => *state,
        Position::Functions(_) => None,
    }
}
