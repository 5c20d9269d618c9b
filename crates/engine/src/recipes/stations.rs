//! Machines that do the work of a layout's resources.
//!
//! An operation of such a resource is an operation of the machine. It takes the time and the energy
//! of the machine, unless the layout gives a time of its own. Properties of the machine have their
//! default values.

use crate::simulation::{Packaged, SimulationOptions, build, not_instantiated};
use crate::synthesis::Synthesis;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::Library;
use linewright_language::contract::machine::Machine;
use linewright_language::contract::recipe::{Layout, ResourceInfo};
use linewright_recipe::model::{Action, Transition};
use linewright_recipe::run::Performance;
use linewright_station::{CallError, Controller, Service};
use rayon::prelude::*;
use std::path::Path;

/// Returns the machine that does the work of a resource.
pub fn machine_of<'l>(library: &'l Library, resource: &ResourceInfo) -> Option<&'l Machine> {
    library.machine_at(resource.machine?)
}

/// Returns the machines of some layouts, each once.
pub fn machines_of<'l>(library: &'l Library, layouts: &[&Layout]) -> Vec<&'l Machine> {
    let mut machines: Vec<&Machine> = Vec::new();
    let resources = layouts.iter().flat_map(|l| &l.resources);
    for machine in resources.filter_map(|r| machine_of(library, r)) {
        if !machines.iter().any(|m| m.span == machine.span) {
            machines.push(machine);
        }
    }
    machines
}

/// Returns the operation of a machine that a transition performs.
fn operation(machine: &Machine, transition: &Transition) -> Option<usize> {
    match &transition.action {
        Action::Operation(name) => machine.operations.iter().position(|o| o.name == *name),
        Action::Internal(_) | Action::In(_) | Action::Out(_) => None,
    }
}

/// Performs an operation with the default values of all properties.
fn perform(
    machine: &Machine,
    controller: &mut dyn Controller,
    operation: usize,
) -> Result<Service, CallError> {
    let mut values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
    controller.simulate(operation, &mut values)
}

fn failed(resource: &ResourceInfo, name: &str, operation: &str, error: &CallError) -> Diagnostic {
    let message = format!("`{name}` cannot perform `{operation}`: {error}");
    Diagnostic::error(codes::LIBRARY_CALL, resource.name, message)
        .with_help("`linewright explain LW505` lists the codes")
}

/// Returns a layout in which each operation of a machine has the time and the power of the machine,
/// as if it were the first that the machine performs, unless the layout gives a time.
///
/// # Errors
/// The operations that fail.
pub fn timed_layout(
    library: &Library,
    layout: &Layout,
    synthesis: &Synthesis<'_>,
) -> Result<Layout, Vec<Diagnostic>> {
    let mut timed = layout.clone();
    let mut findings = Vec::new();
    for (resource, info) in timed.model.resources.iter_mut().zip(&layout.resources) {
        let Some(machine) = machine_of(library, info) else {
            continue;
        };
        let Some(controlled) = synthesis.of(machine) else {
            continue;
        };
        let name = resource.name.clone();
        for transition in resource
            .transitions
            .iter_mut()
            .filter(|t| t.seconds.is_none())
        {
            let Some(number) = operation(machine, transition) else {
                continue;
            };
            match perform(machine, &mut controlled.interpreter(machine), number) {
                Ok(service) => {
                    transition.seconds = Some(service.seconds);
                    // Energy without time has no power.
                    let watts = service.joules / service.seconds;
                    transition.watts = watts.is_finite().then_some(watts);
                }
                Err(error) => {
                    let operation = &machine.operations[number].name;
                    findings.push(failed(info, &name, operation, &error));
                }
            }
        }
    }
    if findings.is_empty() {
        Ok(timed)
    } else {
        Err(findings)
    }
}

/// Station libraries that do the work of a layout's resources.
pub struct Stations<'l> {
    layout: &'l Layout,
    /// For each resource with a machine, the machine and its library.
    controllers: Vec<Option<(&'l Machine, Box<dyn Controller>)>>,
}

impl<'l> Stations<'l> {
    /// Builds and loads the libraries of a layout's machines.
    ///
    /// # Errors
    /// The libraries that cannot be built, loaded or instantiated.
    pub fn new(
        library: &'l Library,
        layout: &'l Layout,
        synthesis: &Synthesis<'_>,
        folder: &Path,
        options: &SimulationOptions,
    ) -> Result<Self, Vec<Diagnostic>> {
        let machines = machines_of(library, &[layout]);
        let controlled: Vec<_> = machines.iter().filter_map(|m| synthesis.of(m)).collect();
        let packaged = controlled.par_iter().map(Packaged::whole).collect();
        let libraries = build(packaged, folder, options)?;
        let mut findings = Vec::new();
        let mut controllers: Vec<Option<(&Machine, Box<dyn Controller>)>> = Vec::new();
        for (resource, info) in layout.model.resources.iter().zip(&layout.resources) {
            let machine = machine_of(library, info);
            let at = machine.and_then(|m| machines.iter().position(|o| o.span == m.span));
            let Some((machine, loaded)) = machine.zip(at.and_then(|at| libraries.get(at))) else {
                controllers.push(None);
                continue;
            };
            match loaded.library.instance() {
                Ok(instance) => controllers.push(Some((machine, Box::new(instance)))),
                Err(error) => findings.push(not_instantiated(&resource.name, info.name, &error)),
            }
        }
        if findings.is_empty() {
            Ok(Self {
                layout,
                controllers,
            })
        } else {
            Err(findings)
        }
    }

    /// Lets the library of a resource perform an operation. Returns what it took; `None` if the
    /// resource has no machine, or the layout gives the time.
    ///
    /// # Errors
    /// The library returns an error.
    pub fn perform(
        &mut self,
        resource: usize,
        transition: usize,
    ) -> Result<Option<Performance>, Box<Diagnostic>> {
        let model = &self.layout.model.resources[resource];
        let about = &model.transitions[transition];
        let Some((machine, controller)) = &mut self.controllers[resource] else {
            return Ok(None);
        };
        let Some(number) = operation(machine, about) else {
            return Ok(None);
        };
        let service = perform(machine, &mut **controller, number).map_err(|error| {
            let operation = &machine.operations[number].name;
            let info = &self.layout.resources[resource];
            Box::new(failed(info, &model.name, operation, &error))
        })?;
        Ok(about.seconds.is_none().then(|| Performance {
            nanoseconds: (service.seconds * 1e9).round() as i64,
            microjoules: (service.joules * 1e6).round() as i64,
        }))
    }
}
