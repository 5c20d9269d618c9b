//! A line in the bundled runner, with the station libraries that ship.

use crate::controlled::Controlled;
use crate::libraries;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::machine::Machine;
use linewright_line::{Options, Plant, Replications, Trace};
use linewright_station::load::Library;
use linewright_station::profile::Profile;
use linewright_station::{Controller, Package, Toolchain};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// How a line is run.
#[derive(Debug, Clone)]
pub struct SimulationOptions {
    /// When a run ends, and its seed; the deadline holds for compilers as well.
    pub options: Options,
    /// How many runs, with the seeds that follow.
    pub replications: u32,
    /// Compile the libraries even where they are there already.
    pub rebuild: bool,
}

/// What the runs of a line came to.
#[derive(Debug)]
pub struct Run {
    /// The runs, in the order of their seeds; there is at least one.
    pub traces: Vec<Trace>,
    /// Their figures together, and what went wrong in any of them.
    pub replications: Replications,
    /// Seconds of the clock for all runs.
    pub seconds: f64,
}

/// Builds the libraries of a line's machines into a folder, loads them and runs the line.
///
/// # Errors
/// Findings, where a library cannot be built or loaded, or the runner refuses the line.
pub fn simulate(
    line: &Line,
    machines: &[Controlled<'_>],
    folder: &Path,
    how: &SimulationOptions,
) -> Result<Run, Vec<Diagnostic>> {
    let libraries = build(machines, folder, how)?;
    let controllers = instances(line, machines, &libraries)?;
    let mut plant = Plant::new(Arc::new(line.clone()), controllers, how.options)?;
    let start = Instant::now();
    let (traces, replications) = plant.replicate(u64::from(how.replications));
    Ok(Run {
        traces,
        replications,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// The libraries of the machines, in their order.
fn build(
    machines: &[Controlled<'_>],
    folder: &Path,
    how: &SimulationOptions,
) -> Result<Vec<Arc<Library>>, Vec<Diagnostic>> {
    let profile = Profile::assumed();
    let packages: Vec<Package> = machines
        .par_iter()
        .map(|m| libraries::package(m, &profile))
        .collect();
    let toolchain = Toolchain::host().until(how.options.deadline);
    let mut findings = Vec::new();
    let mut libraries = Vec::new();
    for built in toolchain.build_all(&packages, folder, how.rebuild) {
        match built.and_then(|b| Library::open(&b.path)) {
            Ok(library) => libraries.push(library),
            Err(error) => {
                // A compiler that is missing is missing for every machine.
                let finding = error.to_diagnostic();
                if !findings.contains(&finding) {
                    findings.push(finding);
                }
            }
        }
    }
    if findings.is_empty() {
        Ok(libraries)
    } else {
        Err(findings)
    }
}

/// By node, an instance of its machine.
fn instances(
    line: &Line,
    machines: &[Controlled<'_>],
    libraries: &[Arc<Library>],
) -> Result<BTreeMap<usize, Box<dyn Controller>>, Vec<Diagnostic>> {
    let mut findings = Vec::new();
    let mut controllers: BTreeMap<usize, Box<dyn Controller>> = BTreeMap::new();
    for (index, node) in line.nodes.iter().enumerate() {
        let machine: &Machine = match &node.kind {
            NodeKind::Station { machine, .. } => machine,
            NodeKind::Conveyor {
                belt: Some(belt), ..
            } => &belt.machine,
            _ => continue,
        };
        let library = machines
            .iter()
            .position(|c| std::ptr::eq(c.machine, machine))
            .map(|i| &libraries[i]);
        match library.map(Library::instance) {
            Some(Ok(instance)) => {
                controllers.insert(index, Box::new(instance));
            }
            Some(Err(error)) => findings.push(
                Diagnostic::error(
                    codes::LIBRARY_CALL,
                    node.span,
                    format!("`{}` cannot be instantiated: {error}", node.name),
                )
                .with_help(
                    "build it anew with --rebuild; `linewright explain LW505` lists the codes",
                ),
            ),
            None => {}
        }
    }
    if findings.is_empty() {
        Ok(controllers)
    } else {
        Err(findings)
    }
}
