//! A controller in one of two forms: explicit states if it is small, otherwise functions of bits.

use super::functions::Functions;
use super::{Machine, Port};
use linewright_core::gr1::Timing;

/// A controller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Controller {
    /// States and guarded transitions.
    Machine(Machine),
    /// Functions of bits.
    Functions(Box<Functions>),
}

impl Controller {
    /// Name of the contract.
    pub fn name(&self) -> &str {
        match self {
            Self::Machine(machine) => &machine.name,
            Self::Functions(functions) => &functions.name,
        }
    }

    /// Which side moves first.
    pub fn timing(&self) -> Timing {
        match self {
            Self::Machine(machine) => machine.timing,
            Self::Functions(functions) => functions.timing,
        }
    }

    /// Inputs in the order of the specification.
    pub fn inputs(&self) -> &[Port] {
        match self {
            Self::Machine(machine) => &machine.inputs,
            Self::Functions(functions) => &functions.inputs,
        }
    }

    /// Outputs and internal variables in the order of the specification.
    pub fn outputs(&self) -> &[Port] {
        match self {
            Self::Machine(machine) => &machine.outputs,
            Self::Functions(functions) => &functions.outputs,
        }
    }

    /// Returns the machine, if the controller has this form.
    pub fn machine(&self) -> Option<&Machine> {
        match self {
            Self::Machine(machine) => Some(machine),
            Self::Functions(_) => None,
        }
    }

    /// Returns the functions, if the controller has this form.
    pub fn functions(&self) -> Option<&Functions> {
        match self {
            Self::Machine(_) => None,
            Self::Functions(functions) => Some(functions),
        }
    }
}

impl From<Machine> for Controller {
    fn from(machine: Machine) -> Self {
        Self::Machine(machine)
    }
}

impl From<Functions> for Controller {
    fn from(functions: Functions) -> Self {
        Self::Functions(Box::new(functions))
    }
}
