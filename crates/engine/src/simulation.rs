//! Runs a line in the bundled runner, with the station libraries that `build` also delivers.

use crate::controlled::ControlledMachine;
use crate::libraries;
use crate::parametrized::{ParametrizedController, ParametrizedMachine};
use crate::speed::{FasterController, speed_up};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_language::contract::line::Line;
use linewright_line::replicate::replicate;
use linewright_line::{Batches, Count, Monitor, Observer, Options, Plant, Replications, Trace};
use linewright_station::load::Library;
use linewright_station::profile::Profile;
use linewright_station::{CallError, Controller, Package, Toolchain};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Options of a simulation. By default it is one run, with libraries that exist used again.
#[derive(Debug, Clone, Default)]
pub struct SimulationOptions {
    /// End conditions and seed of a run; the deadline also applies to compilers.
    pub options: Options,
    /// Whether a pilot run finds the warm-up.
    pub find_warm_up: bool,
    /// Number of runs, with consecutive seeds.
    pub replications: Count,
    /// By node: how many times as fast as in its file the station works.
    pub speeds: BTreeMap<usize, f64>,
    /// Whether other times and powers of actions will be tried. If so, the libraries do not contain
    /// them, so that all runs use the same libraries. The results are the same.
    pub is_study: bool,
    /// Whether to recompile libraries that already exist.
    pub rebuild: bool,
    /// Watches the runs.
    pub monitor: Option<Arc<Monitor>>,
}

/// Results of all runs of a line.
#[derive(Debug)]
pub struct Run {
    /// Traces of the runs in seed order; never empty.
    pub traces: Vec<Trace>,
    /// Combined statistics of all runs, and the problems found in any of them.
    pub replications: Replications,
    /// Statistics over the batches of the first run, if the options ask for batches and the run has
    /// come to its end.
    pub batches: Option<Batches>,
    /// Wall-clock seconds for all runs.
    pub seconds: f64,
}

impl Run {
    /// The problems found in the runs. The requirements are judged by the batches, if there are
    /// some.
    pub fn findings(&self) -> Vec<Diagnostic> {
        let mut findings = self.replications.findings.clone();
        if let Some(batches) = &self.batches {
            findings.retain(|finding| finding.code != codes::LINE_REQUIREMENT);
            findings.extend(batches.findings.clone());
        }
        findings
    }
}

/// Builds the libraries of a line's machines into a folder, loads them, and runs the line.
/// The observer watches the first run.
///
/// # Errors
/// Returns the findings if a library cannot be built or loaded, or if the runner refuses the line.
pub fn simulate(
    line: &Line,
    machines: &[ControlledMachine<'_>],
    folder: &Path,
    options: &SimulationOptions,
    observer: Option<&mut dyn Observer>,
) -> Result<Run, Vec<Diagnostic>> {
    let packaged = |machine: &ControlledMachine<'_>| {
        if options.is_study {
            Packaged::parametrized(machine)
        } else {
            Packaged::whole(machine)
        }
    };
    let packaged = machines.par_iter().map(packaged).collect();
    let libraries = build(packaged, folder, options)?;
    run(line, machines, &libraries, options, observer)
}

/// Number of parts from which on optimized libraries save more time in the run than the compiler
/// needs for them.
const MANY_PARTS: u64 = 100_000;

/// The toolchain for the libraries of a run.
fn toolchain(options: &SimulationOptions) -> Toolchain {
    let runs = match options.replications {
        Count::Fixed(runs) => runs,
        Count::Until { .. } => 1,
    };
    let parts = options.options.parts.unwrap_or(0).saturating_mul(runs);
    if parts < MANY_PARTS {
        Toolchain::host()
    } else {
        Toolchain::shipping()
    }
}

/// The library of a machine, and the values of the parameters that only the library has.
pub(crate) struct Packaged {
    package: Package,
    values: Vec<f64>,
}

impl Packaged {
    pub(crate) fn whole(controlled: &ControlledMachine<'_>) -> Self {
        Self {
            package: libraries::package(controlled, &Profile::assumed()),
            values: Vec::new(),
        }
    }

    fn parametrized(controlled: &ControlledMachine<'_>) -> Self {
        let ParametrizedMachine { machine, values } = ParametrizedMachine::new(controlled.machine);
        let controlled = ControlledMachine {
            machine: &machine,
            controllers: controlled.controllers.clone(),
        };
        Self {
            values,
            ..Self::whole(&controlled)
        }
    }
}

fn run(
    line: &Line,
    machines: &[ControlledMachine<'_>],
    libraries: &[LoadedLibrary],
    options: &SimulationOptions,
    observer: Option<&mut dyn Observer>,
) -> Result<Run, Vec<Diagnostic>> {
    let mut line = line.clone();
    for (node, speed) in &options.speeds {
        speed_up(&mut line, *node, *speed);
    }
    let line = Arc::new(line);
    let plant = |is_shown: bool| -> Result<Plant, Vec<Diagnostic>> {
        let mut controllers = instances(&line, machines, libraries)?;
        for (node, speed) in &options.speeds {
            if let Some(controller) = controllers.remove(node) {
                controllers.insert(*node, Box::new(FasterController::new(controller, *speed)));
            }
        }
        let plant = Plant::new(Arc::clone(&line), controllers, options.options)?;
        Ok(plant.watched(options.monitor.clone(), is_shown))
    };
    let start = Instant::now();
    let warm_up = if options.find_warm_up {
        Some(
            plant(true)?
                .find_warm_up()
                .map_err(|finding| vec![*finding])?,
        )
    } else {
        None
    };
    let plant = |is_shown: bool| {
        let mut plant = plant(is_shown)?;
        if let Some(seconds) = warm_up {
            plant.set_found_warm_up(seconds);
        }
        Ok(plant)
    };
    let threads = rayon::current_num_threads();
    let (traces, replications) = replicate(threads, plant, options.replications, observer)?;
    Ok(Run {
        batches: Batches::of(&line, &traces[0]),
        traces,
        replications,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// A loaded library, and the values of the parameters that only the library has.
pub(crate) struct LoadedLibrary {
    pub(crate) library: Arc<Library>,
    values: Vec<f64>,
}

/// Builds and loads libraries, in order. Equal packages are built once.
pub(crate) fn build(
    packaged: Vec<Packaged>,
    folder: &Path,
    options: &SimulationOptions,
) -> Result<Vec<LoadedLibrary>, Vec<Diagnostic>> {
    let mut packages: Vec<Package> = Vec::new();
    let mut uses: Vec<(usize, Vec<f64>)> = Vec::new();
    for Packaged { package, values } in packaged {
        let known = packages.iter().position(|p| *p == package);
        uses.push((known.unwrap_or(packages.len()), values));
        if known.is_none() {
            packages.push(package);
        }
    }
    let toolchain = toolchain(options).with_deadline(options.options.deadline);
    let mut findings = Vec::new();
    let mut libraries = Vec::new();
    for built in toolchain.build_all(&packages, folder, options.rebuild) {
        match built.and_then(|b| Library::open(&b.path)) {
            Ok(library) => libraries.push(library),
            Err(error) => {
                // If the compiler is missing, it is missing for every machine.
                let finding = error.to_diagnostic();
                if !findings.contains(&finding) {
                    findings.push(finding);
                }
            }
        }
    }
    if findings.is_empty() {
        let loaded = uses.into_iter().map(|(index, values)| LoadedLibrary {
            library: Arc::clone(&libraries[index]),
            values,
        });
        Ok(loaded.collect())
    } else {
        Err(findings)
    }
}

/// The finding for a station or resource whose library gives no instance.
pub(crate) fn not_instantiated(name: &str, at: Span, error: &CallError) -> Diagnostic {
    let message = format!("`{name}` cannot be instantiated: {error}");
    Diagnostic::error(codes::LIBRARY_CALL, at, message)
        .with_help("rebuild its library with --rebuild; `linewright explain LW505` lists the codes")
}

/// Creates the controller of every station and every conveyor with a machine, by node index.
fn instances(
    line: &Line,
    machines: &[ControlledMachine<'_>],
    libraries: &[LoadedLibrary],
) -> Result<BTreeMap<usize, Box<dyn Controller>>, Vec<Diagnostic>> {
    let mut findings = Vec::new();
    let mut controllers: BTreeMap<usize, Box<dyn Controller>> = BTreeMap::new();
    for (index, node) in line.nodes.iter().enumerate() {
        let Some(machine) = node.machine() else {
            continue;
        };
        let library = machines
            .iter()
            .position(|c| std::ptr::eq(c.machine, Arc::as_ptr(machine)))
            .map(|i| &libraries[i]);
        let instance = library.map(|l| (l.library.instance(), &l.values));
        match instance {
            Some((Ok(instance), values)) if values.is_empty() => {
                controllers.insert(index, Box::new(instance));
            }
            Some((Ok(instance), values)) => {
                let controller = ParametrizedController::new(instance, values.clone());
                controllers.insert(index, Box::new(controller));
            }
            Some((Err(error), _)) => {
                findings.push(not_instantiated(&node.name, node.span, &error));
            }
            None => {}
        }
    }
    if findings.is_empty() {
        Ok(controllers)
    } else {
        Err(findings)
    }
}
