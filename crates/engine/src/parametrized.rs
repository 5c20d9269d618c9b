//! Machines whose times and powers are parameters of their operations.
//!
//! A station library contains the times and powers of a machine's actions as constants, so another
//! time is another library. For a study, the constants become parameters, which `simulate` takes at
//! each call like those that the machine declares. Runs that differ only in these numbers then use
//! the same library, with the same results: the library computes with the same numbers.

use linewright_language::contract::machine::{
    ActionTime, Machine, Property, PropertyKind, RealExpr,
};
use linewright_station::{CallError, Controller, Service};

/// A machine without constant times and powers of its actions, and the values in their places.
#[derive(Debug, Clone)]
pub struct ParametrizedMachine {
    /// The machine, with one more parameter for each constant.
    pub machine: Machine,
    /// Values of the additional parameters.
    pub values: Vec<f64>,
}

impl ParametrizedMachine {
    /// Replaces the constants. Values that a library only describes, for hosts other than the
    /// bundled runner, are cleared, because every library contains its description.
    pub fn new(machine: &Machine) -> Self {
        let mut result = Self {
            machine: machine.clone(),
            values: Vec::new(),
        };
        let mut components = std::mem::take(&mut result.machine.components);
        let step = machine.step_seconds;
        for component in components.iter_mut().filter(|c| c.active.is_some()) {
            let (name, span) = (&component.name, component.span);
            let time = component.time.take();
            component.time = Some(match time {
                None => {
                    let step = RealExpr::Number(step);
                    ActionTime::PerStep(result.parameter(&format!("time of {name}"), span, step))
                }
                Some(ActionTime::PerStep(time)) => {
                    ActionTime::PerStep(result.parameter(&format!("time of {name}"), span, time))
                }
                Some(ActionTime::PerExecution(time)) => ActionTime::PerExecution(result.parameter(
                    &format!("time of {name}"),
                    span,
                    time,
                )),
            });
            let watts = std::mem::replace(&mut component.watts, RealExpr::Number(0.0));
            component.watts = result.parameter(&format!("power of {name}"), span, watts);
        }
        let machine = &mut result.machine;
        machine.components = components;
        machine.idle_watts = 0.0;
        for property in &mut machine.properties {
            property.default = property.domain.as_ref().map_or(0.0, |d| d.low() as f64);
        }
        result
    }

    /// Returns the expression, or a new parameter if it is a finite constant.
    fn parameter(
        &mut self,
        name: &str,
        span: linewright_core::source::Span,
        value: RealExpr,
    ) -> RealExpr {
        match value {
            RealExpr::Number(number) if number.is_finite() => {
                let index = self.machine.properties.len();
                self.machine.properties.push(Property {
                    name: name.to_owned(),
                    unit: String::new(),
                    default: 0.0,
                    kind: PropertyKind::Parameter,
                    domain: None,
                    span,
                });
                self.values.push(number);
                RealExpr::Property(index)
            }
            other => other,
        }
    }
}

/// A controller that adds the values of the additional parameters to every call.
pub struct ParametrizedController<C> {
    controller: C,
    values: Vec<f64>,
    /// Values of the last call.
    all: Vec<f64>,
}

impl<C: Controller> ParametrizedController<C> {
    /// Adds these values to the calls of a controller of [`ParametrizedMachine::machine`].
    pub fn new(controller: C, values: Vec<f64>) -> Self {
        Self {
            controller,
            values,
            all: Vec::new(),
        }
    }
}

impl<C: Controller> Controller for ParametrizedController<C> {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        self.all.clear();
        self.all.extend_from_slice(values);
        self.all.extend_from_slice(&self.values);
        let service = self.controller.simulate(operation, &mut self.all)?;
        values.copy_from_slice(&self.all[..values.len()]);
        Ok(service)
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        self.controller.step(plant, outputs)
    }

    fn reset(&mut self) {
        self.controller.reset();
    }
}
