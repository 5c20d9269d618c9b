//! `linewright compose`, `refine`, `compat`, `conjoin`, `quotient` and `merge`: the algebra of
//! contracts on the command line.

mod compare;
mod compose;
pub mod document;
mod operand;
mod refine;
mod views;

use super::console::Failed;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::schema::{Described, form};
use crate::algebra::contract::Contract as Sets;
use crate::algebra::join::{Sharing, join};
use crate::algebra::system::System;
use crate::diagnostics::{Diagnostic, has_errors, json, sarif};
use crate::engine::files::{self, LoadedFiles, StandardLibrary};
use crate::source::Span;
use clap::Args;
use document::Document;
use operand::{Members, Operand, Operation, Rename};

/// The documents of the commands: all have the same form.
pub const DOCUMENTS: [Described; 6] = [
    of_command("compose", "Which guarantees discharge which assumptions"),
    of_command(
        "refine",
        "Whether one contract, or a whole library, refines another",
    ),
    of_command(
        "compat",
        "Whether some environment can keep the assumptions of contracts",
    ),
    of_command(
        "conjoin",
        "The conjunction of contracts: several views of one component",
    ),
    of_command(
        "quotient",
        "The quotient of two contracts: the missing component",
    ),
    of_command(
        "merge",
        "The merge of contracts: requirements that hold at the same time",
    ),
];

const fn of_command(name: &'static str, title: &'static str) -> Described {
    Described::new(name, title, &[form::<Document>, form::<Failed>])
}

/// The arguments of `refine`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright refine std.handling.turn std.handling.turn
    linewright refine contracts contracts

    $ linewright refine cell.lw::Whole 'compose(cell.lw::Left, cell.lw::Right)'

NEW refines OLD if it can be used wherever OLD was used: it assumes no more than OLD and \
guarantees no less. Whether a controller can keep NEW is a question for `check`. For two folders, contracts with the same name are compared; a removed \
contract counts as broken.

A contract is given as FILE, as FILE::NAME if the file declares several contracts, as a library name such as \
std.handling.turn, or as an expression: compose(A, B), conjoin(A, B), quotient(A, B), merge(A, B).")]
pub struct RefineArguments {
    /// Contract or folder to be refined
    #[arg(value_name = "OLD")]
    pub old: Operand,
    /// Contract, expression or folder that is to refine OLD
    #[arg(value_name = "NEW")]
    pub new: Operand,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// Options common to the commands of the algebra.
#[derive(Debug, Args)]
pub struct Common {
    /// Rename a port, to wire contracts that use different names (repeatable)
    #[arg(long, value_name = "CONTRACT.PORT=NAME")]
    pub rename: Vec<Rename>,
}

/// The arguments of `compose`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright compose std.handling.turn std.handling.place
    linewright compose std.handling.turn std.handling.place --rename Turn.desired=cell

Variables of the same name are one wire. For each assumption, the proof names what discharges \
it: the safety guarantees of the other components, by induction over the steps; their justice guarantees, \
if these do not wait for one another in a cycle; or the environment. Assumptions about inputs from outside become assumptions of the composition. An \
assumption that is not discharged is shown with a run that breaks it. The proof assumes \
that each component keeps its guarantees; whether a controller can do so is a question for `check`.")]
pub struct ComposeArguments {
    /// The contracts
    #[arg(value_name = "CONTRACT", required = true, num_args = 1..)]
    pub contracts: Vec<Operand>,
    /// Synthesize one controller of the composition, and print it as JSON
    #[arg(long)]
    pub synth: bool,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// The arguments of `compat`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright compat std.handling.turn
    linewright compat std.handling.turn std.handling.place

Contracts are compatible if some environment can keep their assumptions, whatever the \
components do within their guarantees. This is decided as a game with the roles swapped, first for \
safety and then for justice. If there is no such environment, a play shows why.")]
pub struct CompatArguments {
    /// The contracts
    #[arg(value_name = "CONTRACT", required = true, num_args = 1..)]
    pub contracts: Vec<Operand>,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// The arguments of `conjoin`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright conjoin std.handling.turn std.handling.turn

A component that satisfies the conjunction satisfies every contract.")]
pub struct ConjoinArguments {
    /// The contracts
    #[arg(value_name = "CONTRACT", required = true, num_args = 2..)]
    pub contracts: Vec<Operand>,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// The arguments of `merge`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright merge std.handling.turn std.handling.turn

The merge assumes everything that any of the contracts assumes, and under these assumptions keeps all their guarantees.")]
pub struct MergeArguments {
    /// The contracts
    #[arg(value_name = "CONTRACT", required = true, num_args = 2..)]
    pub contracts: Vec<Operand>,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// The arguments of `quotient`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright quotient std.handling.turn std.handling.turn

The quotient is the weakest contract that, composed with EXISTING, refines WHOLE. The command checks that this composition refines WHOLE. \
`quotient` compares sets of infinite runs: a contract says that if its assumptions hold in the whole run, so do its guarantees. `compose` demands more: \
safety guarantees hold for as long as safety assumptions have held. So `compose` can accept a component that does not refine the quotient.")]
pub struct QuotientArguments {
    /// Contract that EXISTING and the missing component must satisfy together
    #[arg(value_name = "WHOLE")]
    pub whole: Operand,
    /// Contract of the existing component
    #[arg(value_name = "EXISTING")]
    pub existing: Operand,
    /// Options common to the commands of the algebra.
    #[command(flatten)]
    pub common: Common,
}

/// Operands that are loaded and joined into one system.
struct Joined {
    loaded: LoadedFiles,
    system: System,
    /// For each operand, the expression over the system's parts.
    sets: Vec<Sets>,
    /// Place of each part's declaration.
    spans: Vec<Span>,
}

/// Result of a command that has not been printed yet.
struct Outcome {
    document: Document,
    /// Text for human-readable output.
    text: String,
    findings: Vec<Diagnostic>,
}

/// Loads the files of the operands; on errors, prints the findings and returns the exit code.
fn load(
    command: &str,
    operands: &[&Operand],
    options: &GlobalOptions,
) -> anyhow::Result<Result<LoadedFiles, ExitCode>> {
    let mut paths: Vec<String> = Vec::new();
    for operand in operands {
        for path in operand::paths(std::slice::from_ref(*operand)) {
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
    }
    let loaded = files::load(&paths, &StandardLibrary::new(options.library.clone()));
    if has_errors(&loaded.findings) {
        let sources = &loaded.library.sources;
        options
            .console()
            .failed(command, sources, &loaded.findings)?;
        let code = options
            .exit_code(&loaded.findings)
            .and(ExitCode::of_loading(&loaded));
        return Ok(Err(code));
    }
    Ok(Ok(loaded))
}

/// Loads and joins operands; on failure, prints the findings and returns the exit code.
fn load_joined(
    command: &str,
    operands: &[&Operand],
    common: &Common,
    sharing: Sharing,
    options: &GlobalOptions,
) -> anyhow::Result<Result<Joined, ExitCode>> {
    let loaded = match load(command, operands, options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(Err(code)),
    };
    let mut members = Members::default();
    let mut sets = Vec::new();
    for operand in operands {
        sets.push(members.add(operand, &loaded)?);
    }
    members.rename(&common.rename)?;
    let spans = members.contracts.iter().map(|c| c.span).collect();
    match join(&members.list, sharing) {
        Ok(system) => Ok(Ok(Joined {
            loaded,
            system,
            sets,
            spans,
        })),
        Err(mismatches) => {
            let findings: Vec<Diagnostic> = mismatches
                .iter()
                .map(crate::engine::found::of_mismatch)
                .collect();
            let sources = &loaded.library.sources;
            options.console().failed(command, sources, &findings)?;
            Ok(Err(options.exit_code(&findings)))
        }
    }
}

/// Prints a result and returns the exit code.
fn print_outcome(
    outcome: Outcome,
    loaded: &LoadedFiles,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let sources = &loaded.library.sources;
    let Outcome {
        mut document,
        text,
        findings,
    } = outcome;
    match options.format {
        Format::Json => {
            document.findings = json::findings(sources, &findings);
            console.document(&document)?;
        }
        Format::Sarif => console.document(&sarif::document(sources, &findings))?,
        Format::Human | Format::Short => {
            console.result(&(console.render(sources, &findings) + &text))?;
        }
    }
    Ok(options.exit_code(&findings))
}

/// Reports that a limit was reached before there was a result.
fn gave_up(
    limit: crate::game::Limit,
    command: &str,
    loaded: &LoadedFiles,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let finding = Diagnostic::error(
        crate::diagnostics::codes::GAVE_UP,
        None,
        format!("not decided: {limit}"),
    )
    .with_help(crate::engine::closed::limit_help(limit))
    .giving_up(limit.is_external());
    let sources = &loaded.library.sources;
    options.console().failed(command, sources, &[finding])?;
    Ok(ExitCode::GaveUp)
}

/// Runs `refine`.
pub fn refine(arguments: &RefineArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if let (Some(old), Some(new)) = (
        compare::library(&arguments.old),
        compare::library(&arguments.new),
    ) {
        return compare::run(&old, &new, &arguments.common, options);
    }
    refine::run(arguments, options)
}

/// Runs `compose`.
pub fn compose(arguments: &ComposeArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    compose::run(arguments, options)
}

/// Runs `compat`.
pub fn compat(arguments: &CompatArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    compose::compat(arguments, options)
}

/// Runs `conjoin`.
pub fn conjoin(arguments: &ConjoinArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let operands: Vec<&Operand> = arguments.contracts.iter().collect();
    views::run(Operation::Conjoin, &operands, &arguments.common, options)
}

/// Runs `merge`.
pub fn merge(arguments: &MergeArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let operands: Vec<&Operand> = arguments.contracts.iter().collect();
    views::run(Operation::Merge, &operands, &arguments.common, options)
}

/// Runs `quotient`.
pub fn quotient(
    arguments: &QuotientArguments,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let operands = [&arguments.whole, &arguments.existing];
    views::run(Operation::Quotient, &operands, &arguments.common, options)
}
