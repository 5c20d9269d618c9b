//! The calls into stages whose code comes from elsewhere, in one place: what a game tells beside its verdict, the written
//! forms of a controller, station libraries, and the runner. Everything else in `cli` only knows these functions.

use super::synth::Emit;
use crate::contract::line::{Line, NodeKind};
use crate::contract::machine::Machine;
use crate::diagnostics::{Diagnostic, codes};
use crate::game::{Limits, Lost, Won, examine_environment};
use crate::gr1::Specification;
use crate::line::{Options, Plant};
use crate::mealy;
use crate::report;
use crate::source::Span;
use crate::station::load::Library;
use crate::station::{self, Controller, Package, Toolchain};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// What is known of a game that was lost.
#[derive(Debug, Default)]
pub struct Insight {
    /// Names of the formulas of a core.
    pub core: Vec<String>,
    /// The largest number of nodes.
    pub peak_nodes: Option<u64>,
}

/// The largest number of nodes of a game that was won.
pub fn won(won: &Won) -> Option<u64> {
    Some(won.peak_nodes)
}

/// What is known of a game that was lost.
pub fn lost(specification: &Specification, lost: &Lost) -> Insight {
    Insight {
        core: lost.core_names(specification),
        peak_nodes: Some(lost.peak_nodes),
    }
}

/// What makes a realizable contract mean less than it seems to: LW205 and LW206. Nothing where a limit was reached first.
pub fn examine(specification: &Specification, span: Span, limits: &Limits) -> Vec<Diagnostic> {
    let Ok(found) = examine_environment(specification, limits) else {
        return Vec::new();
    };
    let name = &specification.name;
    let mut findings = Vec::new();
    if found.cannot_start {
        findings.push(
            Diagnostic::warning(
                codes::ENVIRONMENT_EMPTY,
                span,
                format!("the assumptions of `{name}` contradict each other at the start, so every machine keeps it"),
            )
            .with_help("no plant can begin like this; weaken an initial or `always` assumption"),
        );
    } else if let Some(values) = found.stuck_at_start.as_ref().or(found.dead_end.as_ref()) {
        findings.push(
            Diagnostic::warning(
                codes::ENVIRONMENT_EMPTY,
                span,
                format!(
                    "the assumptions of `{name}` leave the plant no next step in some situations"
                ),
            )
            .with_help(format!(
                "one of them is {}",
                situation(specification, values)
            )),
        );
    }
    if let Some(values) = &found.forced {
        findings.push(
            Diagnostic::warning(
                codes::NOT_WELL_SEPARATED,
                span,
                format!("a controller of `{name}` may keep its contract by making the plant break an assumption"),
            )
            .with_help(format!(
                "it can force that from {}; let assumptions speak of what the plant decides, not of what the machine does to it",
                situation(specification, values)
            )),
        );
    }
    findings
}

/// A valuation in words.
fn situation(specification: &Specification, values: &[i64]) -> String {
    let shown: Vec<String> = specification
        .variables
        .iter()
        .zip(values)
        .map(|(v, x)| format!("{} = {}", v.name, v.domain.show(*x)))
        .collect();
    shown.join(", ")
}

/// A controller in one of its written forms. A finding (LW204) where that form would be too large.
pub fn write(emit: Emit, machine: &mealy::Machine) -> Result<String, Box<Diagnostic>> {
    let too_large = |limit: crate::game::Limit| {
        Box::new(
            Diagnostic::error(
                codes::GAVE_UP,
                None,
                format!("`{}` was not written in this form: {limit}", machine.name),
            )
            .with_help("use --emit json, whose transitions carry guards"),
        )
    };
    let pretty = |value: &serde_json::Value| format!("{value:#}\n");
    Ok(match emit {
        Emit::Json => mealy::json::to_text(&mealy::json::to_json(machine, true)),
        Emit::Gr1c => pretty(&mealy::gr1c::to_json(machine).map_err(too_large)?),
        Emit::Dot => mealy::dot::to_dot(machine),
        Emit::Svg => mealy::svg::to_svg(machine),
    })
}

/// A machine with the verified controllers of its components, in their order.
#[derive(Debug)]
pub struct Controlled<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller a component.
    pub controllers: Vec<&'a mealy::Machine>,
}

/// What `build` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// A shared library for this computer
    Linux,
    /// The C sources, with all headers they need
    Source,
}

/// Writes a machine's station library, or its sources, into a folder, and gives the files that a user needs.
pub fn build(
    controlled: &Controlled<'_>,
    target: Target,
    folder: &Path,
    rebuild: bool,
) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
    let package = package(controlled);
    let explain = |e: station::Error| Box::new(e.to_diagnostic());
    match target {
        Target::Linux => {
            let built = Toolchain::host()
                .build(&package, folder, rebuild)
                .map_err(explain)?;
            Ok(vec![built.path])
        }
        Target::Source => {
            package.write_source(folder).map_err(explain)?;
            let files = package.files();
            Ok(files.iter().map(|(name, _)| folder.join(name)).collect())
        }
    }
}

fn package(controlled: &Controlled<'_>) -> Package {
    let controllers: Vec<mealy::Machine> = controlled
        .controllers
        .iter()
        .map(|c| (*c).clone())
        .collect();
    Package::emit(controlled.machine, &controllers)
}

/// How a line is to be run.
#[derive(Debug, Clone, Copy)]
pub struct RunOptions {
    /// End after so many end products.
    pub parts: Option<u64>,
    /// End after so many simulated seconds.
    pub until: Option<f64>,
    /// The first seed.
    pub seed: u64,
    /// How many runs, with seeds `seed`, `seed + 1`, ...
    pub replications: u32,
    /// Compile the libraries even where they are there already.
    pub rebuild: bool,
    /// Whether measured times belong into the result.
    pub timing: bool,
}

/// What a run came to.
#[derive(Debug)]
pub struct Run {
    /// The table for a person.
    pub table: String,
    /// The document of INTERFACE, `linewright/run/1`.
    pub document: serde_json::Value,
    /// Violations, requirements that do not hold, a line that is blocked.
    pub findings: Vec<Diagnostic>,
}

/// Builds and loads the libraries of a line's machines and runs it.
pub fn run(
    line: &Line,
    machines: &[Controlled<'_>],
    folder: &Path,
    options: &RunOptions,
) -> Result<Run, Vec<Diagnostic>> {
    let packages: Vec<Package> = machines.par_iter().map(package).collect();
    let mut findings = Vec::new();
    let mut libraries = Vec::new();
    for built in Toolchain::host().build_all(&packages, folder, options.rebuild) {
        match built.and_then(|b| Library::open(&b.path)) {
            Ok(library) => libraries.push(library),
            Err(error) => findings.push(error.to_diagnostic()),
        }
    }
    if !findings.is_empty() {
        return Err(findings);
    }
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
            Some(Err(error)) => findings.push(Diagnostic::error(
                codes::LIBRARY_CALL,
                node.span,
                format!("`{}` cannot be instantiated: {error}", node.name),
            )),
            None => {}
        }
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    let line = Arc::new(line.clone());
    let mut plant = Plant::new(
        Arc::clone(&line),
        controllers,
        Options {
            seed: options.seed,
            parts: options.parts,
            until: options.until,
            ..Options::default()
        },
    )?;
    let start = Instant::now();
    let (traces, replications) = plant.replicate(u64::from(options.replications));
    let wall = options.timing.then(|| start.elapsed().as_secs_f64());
    let replications = (options.replications > 1).then_some(replications);
    let mut found = Vec::new();
    for trace in &traces {
        for finding in &trace.findings {
            if !found.contains(finding) {
                found.push(finding.clone());
            }
        }
    }
    Ok(Run {
        table: report::table(&line, &traces[0], replications.as_ref()),
        document: report::json(&line, &traces[0], replications.as_ref(), wall),
        findings: found,
    })
}
