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
    /// Applies these controllers to a machine that differs from theirs only in numbers.
    pub fn interpreter(&self, machine: &Machine) -> Interpreter {
        Interpreter::new(Arc::new(machine.clone()), Arc::new(self.owned()))
    }

    /// Clones the controllers.
    pub fn owned(&self) -> Vec<mealy::Controller> {
        self.controllers.iter().map(|c| (*c).clone()).collect()
    }
}

/// Checks whether a machine's coordinator and actions fit together.
pub fn compose(controlled: &ControlledMachine<'_>) -> Composition {
    composition::check(controlled.machine, &controlled.controllers)
}
