//! `linewright recipe`: plans, topologies, comparisons and repairs of layouts and recipes.

mod assumed;
mod diff;
mod documents;
mod least;
mod plan;
mod repair;
mod run;
mod schedule;
mod stations;
pub(super) mod subject;
mod topology;

use super::console::Failed;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::schema::{Described, form};
use clap::{Args, Subcommand};
use serde::Serialize;

/// The arguments of `recipe`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Subcommand with its arguments.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show how the resources of a layout make a recipe
    Plan(plan::Arguments),
    /// Make the products of a layout once, with the station libraries of its machines
    Run(run::Arguments),
    /// Count or draw the states in which the resources of a layout can be together
    Topology(topology::Arguments),
    /// Compare which recipes two layouts can make
    Diff(diff::Arguments),
    /// Find the smallest changes of a layout that make a recipe possible
    Repair(repair::Arguments),
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    options.refuse_sarif("the result")?;
    match &arguments.command {
        Command::Plan(a) => plan::run(a, options),
        Command::Run(a) => run::run(a, options),
        Command::Topology(a) => topology::run(a, options),
        Command::Diff(a) => diff::run(a, options),
        Command::Repair(a) => repair::run(a, options),
    }
}

/// The documents of the subcommands, and the one that reports why `recipe` itself has no result.
pub const DOCUMENTS: [Described; 6] = [
    plan::DOCUMENT,
    run::DOCUMENT,
    topology::DOCUMENT,
    diff::DOCUMENT,
    repair::DOCUMENT,
    Described::new("recipe", "Why `recipe` has no result", &[form::<Failed>]),
];

/// Returns rows with aligned columns, of which those after `right` are right-aligned. Empty columns
/// are left out.
fn aligned<const N: usize>(rows: &[[String; N]], right: &[usize]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let columns = (0..N).map(|column| (column, width(column)));
    let columns: Vec<(usize, usize)> = columns.filter(|(_, width)| *width > 0).collect();
    let line = |row: &[String; N]| {
        let cell = |(column, width): &(usize, usize)| {
            let cell = &row[*column];
            if right.contains(column) {
                format!("{cell:>width$}")
            } else {
                format!("{cell:width$}")
            }
        };
        let cells: Vec<String> = columns.iter().map(cell).collect();
        cells.join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// Prints a result: the document with `--format json`, the text otherwise.
fn print_result(
    document: &impl Serialize,
    text: impl FnOnce() -> String,
    options: &GlobalOptions,
) -> anyhow::Result<()> {
    let console = options.console();
    if options.format == Format::Json {
        console.document(document)
    } else {
        console.result(&text())
    }
}
