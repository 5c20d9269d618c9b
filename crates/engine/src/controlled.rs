//! Machines with their controllers.

use linewright_language::contract::machine::Machine;
use linewright_solver::mealy;
use linewright_station::composition::{self, Composition};
use linewright_station::interpret::Interpreter;
use std::sync::Arc;

/// A machine with the verified controllers of its components, in component order.
#[derive(Debug)]
pub struct ControlledMachine<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller per component.
    pub controllers: Vec<&'a mealy::Controller>,
}

impl ControlledMachine<'_> {
    /// Creates an interpreter of `machine` with these controllers. `machine` must have the same
    /// components as `self.machine`; times and other numbers can differ.
    pub fn interpreter(&self, machine: &Machine) -> Interpreter {
        Interpreter::new(
            Arc::new(machine.clone()),
            Arc::new(self.clone_controllers()),
        )
    }

    /// Clones the controllers.
    pub fn clone_controllers(&self) -> Vec<mealy::Controller> {
        self.controllers.iter().map(|c| (*c).clone()).collect()
    }
}

/// Checks whether a machine's coordinator and actions fit together, by exploring the coordinator's
/// states.
pub fn compose(controlled: &ControlledMachine<'_>) -> Composition {
    composition::check(controlled.machine, &controlled.controllers)
}
