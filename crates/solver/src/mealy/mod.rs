//! Controllers: finite machines whose transitions carry guards over the inputs.
//!
//! A [`Machine`] starts *before* step 0. Step 0 takes one of the `initial` transitions; every later
//! step takes a transition of the current state. It is always the transition whose guard the inputs
//! of the step satisfy. The guards of a state are disjoint. They cover at least all inputs that
//! keep the assumptions; for other inputs, there can be no transition. In a `Moore` machine, all
//! transitions of a state have the same output, and so do all initial transitions.

pub mod certify;
mod controller;
pub mod counter;
mod diagram;
pub mod extract;
pub mod functions;
pub mod gr1c;
pub mod json;
pub mod minimise;
pub mod picture;
mod text;
pub mod verify;

pub use controller::Controller;

use linewright_core::gr1::{Domain, Timing, show_value};
use serde::{Deserialize, Serialize};

/// An input or output.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    /// Name of the variable.
    pub name: String,
    /// Domain of its values.
    pub domain: Domain,
    /// Unit, such as `mm`; empty for values without a unit.
    pub unit: String,
    /// Whether the port is an internal variable: an output that is not part of the interface.
    pub internal: bool,
}

/// A condition of a cube: the value of an input lies in `low..=high`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Test {
    /// Index into [`Machine::inputs`].
    pub input: usize,
    /// Smallest allowed value.
    pub low: i64,
    /// Largest allowed value.
    pub high: i64,
}

/// A conjunction of tests, at most one per input, in ascending order of inputs. The empty cube is
/// `true`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub struct Cube(pub Vec<Test>);

impl Cube {
    /// Whether the inputs satisfy every test.
    pub fn holds(&self, inputs: &[i64]) -> bool {
        self.0
            .iter()
            .all(|t| t.low <= inputs[t.input] && inputs[t.input] <= t.high)
    }
}

/// A disjunction of disjoint cubes. The empty guard is `false`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub struct Guard(pub Vec<Cube>);

impl Guard {
    /// Whether the inputs satisfy one of the cubes.
    pub fn holds(&self, inputs: &[i64]) -> bool {
        self.0.iter().any(|c| c.holds(inputs))
    }
}

/// A step of a machine for the inputs that satisfy its guard.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Transition {
    /// Condition on the inputs of the step.
    pub guard: Guard,
    /// The step's outputs, one per entry of [`Machine::outputs`].
    pub output: Vec<i64>,
    /// Index of the next state.
    pub to: usize,
}

/// A controller with explicit states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the contract.
    pub name: String,
    /// Which side moves first.
    pub timing: Timing,
    /// Inputs in the order of the specification.
    pub inputs: Vec<Port>,
    /// Outputs and internal variables in the order of the specification.
    pub outputs: Vec<Port>,
    /// Transitions of step 0.
    pub initial: Vec<Transition>,
    /// Transitions of each state, for all later steps.
    pub states: Vec<Vec<Transition>>,
    /// For each state, the justice guarantees that it works for, by their indices in ascending
    /// order: several if the machine does the same for each of them. Empty if this is not known, as
    /// for counterstrategies. Only drawings show it.
    pub goals: Vec<Vec<usize>>,
}

impl Machine {
    /// Returns the transition for these inputs from `state`, or in step 0 if `state` is `None`.
    /// Returns `None` if no guard holds, which means that the inputs break an assumption.
    pub fn step(&self, state: Option<usize>, inputs: &[i64]) -> Option<&Transition> {
        self.transitions(state)
            .iter()
            .find(|t| t.guard.holds(inputs))
    }

    /// Returns the transitions of `state`, or the initial ones if `state` is `None`.
    pub fn transitions(&self, state: Option<usize>) -> &[Transition] {
        state.map_or(&self.initial, |s| &self.states[s])
    }

    /// Returns the outputs of a Moore machine in the next step, which do not depend on the inputs
    /// of that step.
    ///
    /// # Panics
    /// Panics if `state` has no transition.
    pub fn moore_output(&self, state: Option<usize>) -> &[i64] {
        debug_assert_eq!(self.timing, Timing::Moore);
        &self.transitions(state)[0].output
    }

    /// Returns the number of transitions, including the initial ones.
    pub fn transition_count(&self) -> usize {
        self.initial.len() + self.states.iter().map(Vec::len).sum::<usize>()
    }

    /// Returns a guard as a disjunction of conjunctions, with cubes combined for readability. Each
    /// conjunction lists the values of every input as ascending intervals with gaps between them.
    pub fn guard_values(&self, guard: &Guard) -> Vec<Vec<Vec<(i64, i64)>>> {
        text::guard_values(self, &[guard])
    }

    /// Formats a guard: `command = turn & desired = 3 | command != turn`.
    pub fn show_guard(&self, guard: &Guard) -> String {
        if guard.0.is_empty() {
            return "false".to_owned();
        }
        let show = |tests: Vec<String>| {
            if tests.is_empty() {
                "true".to_owned()
            } else {
                tests.join(" & ")
            }
        };
        let cubes = text::guard_parts(self, &[guard]).into_iter();
        cubes.map(show).collect::<Vec<_>>().join(" | ")
    }

    /// Formats a cube: `command = turn & 2 <= desired <= 4 & !grip`.
    pub fn show_cube(&self, cube: &Cube) -> String {
        if cube.0.is_empty() {
            return "true".to_owned();
        }
        let tests: Vec<String> = cube.0.iter().map(|t| self.show_test(t)).collect();
        tests.join(" & ")
    }

    fn show_test(&self, test: &Test) -> String {
        let port = &self.inputs[test.input];
        let name = &port.name;
        match &port.domain {
            Domain::Bool if test.low == test.high => {
                format!("{}{name}", if test.low == 0 { "!" } else { "" })
            }
            domain if test.low == test.high => {
                format!("{name} = {}", show_value(domain, test.low, &port.unit))
            }
            Domain::Enum { .. } => {
                let labels: Vec<String> = (test.low..=test.high)
                    .map(|v| port.domain.show(v))
                    .collect();
                format!("{name} in {{{}}}", labels.join(", "))
            }
            domain => format!(
                "{} <= {name} <= {}",
                show_value(domain, test.low, &port.unit),
                show_value(domain, test.high, &port.unit)
            ),
        }
    }
}
