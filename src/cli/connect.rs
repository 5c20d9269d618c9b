//! The calls into stages whose code comes from elsewhere, in one place: what a game tells beside its verdict, the written
//! forms of a controller, station libraries, and the runner. Everything else in `cli` only knows these functions.

use super::synth::Emit;
use crate::contract::line::Line;
use crate::contract::machine::Machine;
use crate::diagnostics::Diagnostic;
use crate::game::{Limits, Lost, Won};
use crate::gr1::Specification;
use crate::mealy;
use crate::source::Span;
use std::path::{Path, PathBuf};

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
    let _ = won;
    None
}

/// What is known of a game that was lost.
pub fn lost(specification: &Specification, lost: &Lost) -> Insight {
    let _ = (specification, lost);
    Insight::default()
}

/// What makes a realizable contract mean less than it seems to: LW205 and LW206.
pub fn examine(specification: &Specification, span: Span, limits: &Limits) -> Vec<Diagnostic> {
    let _ = (specification, span, limits);
    Vec::new()
}

/// A controller in one of its written forms. A finding (LW204) where that form would be too large.
pub fn write(
    emit: Emit,
    specification: &Specification,
    machine: &mealy::Machine,
) -> Result<String, Box<Diagnostic>> {
    let _ = (emit, specification, machine);
    todo!("mealy::json, mealy::gr1c, mealy::dot, mealy::svg")
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
    let _ = (controlled, target, folder, rebuild);
    todo!("station: package, compile")
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
    let _ = (line, machines, folder, options);
    todo!("station: package, compile, load; line: Plant::new(..).run(); report: table, json")
}
