//! Machines with their controllers.

use linewright_language::contract::machine::Machine;
use linewright_solver::mealy;
use linewright_station::composition::{self, Composition};
use linewright_station::interpret::Interpreter;
use std::sync::Arc;

/// A machine with the verified controllers of its components, in their order.
#[derive(Debug)]
pub struct Controlled<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller a component.
    pub controllers: Vec<&'a mealy::Controller>,
}

impl Controlled<'_> {
    /// These controllers in a machine that differs from theirs in numbers only.
    pub fn interpreter(&self, machine: &Machine) -> Interpreter {
        Interpreter::new(Arc::new(machine.clone()), Arc::new(self.owned()))
    }

    /// Copies of the controllers.
    pub fn owned(&self) -> Vec<mealy::Controller> {
        self.controllers.iter().map(|c| (*c).clone()).collect()
    }
}

/// Whether a machine's coordinator and actions fit together.
pub fn compose(controlled: &Controlled<'_>) -> Composition {
    composition::check(controlled.machine, &controlled.controllers)
}
