//! `linewright synth`: writes verified controllers, counterstrategies, or specifications for other
//! tools.

mod recipes;

use super::exit::ExitCode;
use super::options::GlobalOptions;
use super::page::{self, PageFile};
use super::pictures;
use super::recipe::subject;
use super::results::{Results, file_name};
use super::select::Selection;
use crate::contract::Contract;
use crate::diagnostics::{Diagnostic, codes};
use crate::drawing::dot;
use crate::engine::controller::ExtractionOptions;
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::{CheckedContract, Goal, Jobs, Verdict};
use crate::game::{Limit, Preference};
use crate::gr1::Specification;
use crate::interchange::{self, Target};
use crate::mealy;
use crate::report::html::controller::{self, Opponent};
use crate::source::Span;
use crate::station::emit::controller::{self as c_files, Origin};
use crate::station::structured_text;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// The end of the help.
const EXAMPLES: &str = "Examples:
    linewright synth contracts/handling/turn.lw
    linewright synth contracts/handling/turn.lw::Turn --emit dot --emit svg --out controllers
    linewright synth examples/other-tools/arbiter.spc
    linewright synth contracts/handling/turn.lw --report turn.html
    linewright synth contracts/handling/turn.lw --emit spc
    linewright synth --counterstrategy --emit json examples/repair-me/1-clash.lw
    linewright synth examples/pad/hinge.lw::Hinge --emit st

A controller is verified against its contract before it is written. A controller with too many \
states is written as a symbolic controller (Boolean functions); its forms are json, c, st and \
plcopen. `--emit spc`, `slugsin`, `spectra` and `tlsf` write the specification for other tools \
and need no controller. For a statement `realize`, the controller tells each resource what to do \
next; its forms are json, c, st, plcopen, dot and svg.";

/// The arguments of `synth`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = pictures::below(EXAMPLES, pictures::SYNTH))]
pub struct Arguments {
    /// File, and optionally one of its contracts, or a recipe or layout of its statements `realize`
    /// [default: all contracts and statements]. The file can also be a specification for gr1c
    /// (.spc), slugs (.slugsin, .structuredslugs) or Spectra (.spectra), or one in TLSF (.tlsf)
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// Output form (repeatable) [default: json, or none with --report]
    #[arg(long, value_enum)]
    pub emit: Vec<Emit>,
    /// Write a report as one HTML file, in which one can walk through the controller: its state
    /// diagram, its answers, and why it refuses a move
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Write the counterstrategy of an unrealizable contract (json, dot, svg, and --report)
    #[arg(long)]
    pub counterstrategy: bool,
    /// Objective for a Mealy machine; symbolic controllers always use `reaction`
    #[arg(long, value_enum, default_value_t)]
    pub prefer: Prefer,
    /// Output folder; if omitted, a single result is printed to standard output
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print solver statistics by phase on standard error
    #[arg(long)]
    pub stats: bool,
}

/// Objective for which a Mealy machine is optimized.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Prefer {
    /// Few steps to the next justice guarantee
    #[default]
    Reaction,
    /// Few states, even if goals take longer; never more states than `reaction`
    States,
}

impl From<Prefer> for Preference {
    fn from(prefer: Prefer) -> Self {
        match prefer {
            Prefer::Reaction => Self::Reaction,
            Prefer::States => Self::States,
        }
    }
}

/// Form of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// States and guarded transitions; functions if there are too many states
    Json,
    /// Header and source file in C99, without dependencies
    C,
    /// Function block in IEC 61131-3 Structured Text
    St,
    /// Function block in PLCopen XML
    Plcopen,
    /// JSON as `gr1c -t json` writes it
    Gr1c,
    /// Graphviz drawing
    Dot,
    /// SVG drawing
    Svg,
    /// The specification, for gr1c
    Spc,
    /// The specification, for slugs
    Slugsin,
    /// The specification, for Spectra
    Spectra,
    /// The specification, for LTL synthesis tools
    Tlsf,
}

impl Emit {
    /// Number of files per controller.
    fn files(self) -> usize {
        if self == Self::C { 2 } else { 1 }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::C => "c",
            Self::St => "st",
            Self::Plcopen => "xml",
            Self::Gr1c => "gr1c.json",
            Self::Dot => "dot",
            Self::Svg => "svg",
            Self::Spc => "spc",
            Self::Slugsin => "slugsin",
            Self::Spectra => "spectra",
            Self::Tlsf => "tlsf",
        }
    }

    /// The format of a specification; `None` if this is a form of a controller.
    fn target(self) -> Option<Target> {
        match self {
            Self::Spc => Some(Target::Spc),
            Self::Slugsin => Some(Target::Slugsin),
            Self::Spectra => Some(Target::Spectra),
            Self::Tlsf => Some(Target::Tlsf),
            _ => None,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let loaded = match arguments.selection.load_alone("synth", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let library = &loaded.library;
    let realizations = subject::find(&arguments.selection, &loaded);
    let contracts = if realizations.is_empty() {
        arguments
            .selection
            .pick(&loaded, "contract", &library.contracts, |c| {
                (&c.name, c.span)
            })?
    } else {
        arguments
            .selection
            .find(&loaded, &library.contracts, |c| (&c.name, c.span))
    };
    recipes::check_arguments(arguments, &realizations)?;
    if arguments.report.is_some() {
        let selection = &arguments.selection;
        selection.only(&contracts, "a report shows only one contract")?;
    }
    // A report that cannot be written ends the command before anything is solved.
    let page_file = match PageFile::begin(arguments.report.as_deref(), &loaded, "synth", options)? {
        Ok(file) => file,
        Err(code) => return Ok(code),
    };
    let is_default = arguments.emit.is_empty() && page_file.is_none();
    let mut forms: Vec<Emit> = Vec::new();
    for emit in arguments
        .emit
        .iter()
        .chain(is_default.then_some(&Emit::Json))
    {
        if !forms.contains(emit) {
            forms.push(*emit);
        }
    }
    if arguments.counterstrategy
        && let Some(other) = forms
            .iter()
            .find(|e| !matches!(e, Emit::Json | Emit::Dot | Emit::Svg))
    {
        anyhow::bail!(
            "a counterstrategy is written as json, dot or svg, not as {}",
            other.ending()
        );
    }
    let files: usize = forms.iter().map(|e| e.files()).sum();
    let results = (contracts.len() + realizations.len()) * files;
    Results::check_count(results, arguments.out.as_deref())?;

    let mut findings = loaded.findings.clone();
    let mut written = Results::default();
    let (specifications, controllers): (Vec<Emit>, Vec<Emit>) =
        forms.into_iter().partition(|e| e.target().is_some());
    for contract in &contracts {
        for emit in &specifications {
            let Some(target) = emit.target() else {
                continue;
            };
            match interchange::write(&contract.specification, target) {
                Ok(text) => {
                    let name = file_name(&contract.name, emit.ending());
                    findings.extend(written.add(&contract.name, contract.span, vec![(name, text)]));
                }
                Err(found) => findings.extend(found),
            }
        }
    }
    let mut jobs = Jobs::examining().with_extraction(ExtractionOptions {
        preference: arguments.prefer.into(),
        // The other forms need a machine.
        functions: controllers
            .iter()
            .all(|e| matches!(e, Emit::Json | Emit::C | Emit::St | Emit::Plcopen)),
        drawn: page_file.is_none()
            && controllers
                .iter()
                .all(|e| matches!(e, Emit::Dot | Emit::Svg)),
    });
    let mut indices: Vec<usize> = Vec::new();
    if !controllers.is_empty() || page_file.is_some() {
        indices.extend(contracts.iter().map(|c| request(&mut jobs, &loaded, c)));
    }
    let progress = console.progress(jobs.len(), "synthesizing");
    let settings = options.announcing(&options.settings(), &progress);
    let checked = jobs.run(&settings, &progress);
    if arguments.stats {
        for (contract, index) in contracts.iter().zip(&indices) {
            let statistics = checked[*index].statistics.timed(!options.no_timing);
            console.remark(&(statistics.show(&contract.name) + "\n"))?;
        }
    }
    for (contract, index) in contracts.iter().zip(indices.iter().copied()) {
        if arguments.counterstrategy {
            if checked[index].verdict == Verdict::Realizable {
                anyhow::bail!(
                    "`{}` is realizable, so it has no counterstrategy: leave out --counterstrategy",
                    contract.name
                );
            }
            let wanted = counterstrategy(&checked[index], contract.span, &mut findings);
            for emit in controllers.iter().filter(|_| wanted.is_some()) {
                let Some(machine) = wanted else { continue };
                let name = format!("{}.counterstrategy", contract.name);
                let text = match emit {
                    Emit::Dot => mealy::picture::to_dot(machine),
                    Emit::Svg => mealy::picture::to_svg(machine, None),
                    _ => mealy::json::to_text(&mealy::json::to_json(machine, true)),
                };
                let files = vec![(file_name(&name, emit.ending()), text)];
                findings.extend(written.add(&contract.name, contract.span, files));
            }
            continue;
        }
        findings.extend(checked[index].findings_where_needed());
        let Some(controller) = &checked[index].controller else {
            continue;
        };
        for emit in &controllers {
            let synthesized = Synthesized {
                controller,
                specification: &contract.specification,
                origin: Origin::contract(&contract.name),
                span: contract.span,
            };
            match write_files(&synthesized, *emit) {
                Ok(files) => {
                    findings.extend(written.add(&contract.name, contract.span, files));
                }
                Err(finding) => findings.push(*finding),
            }
        }
    }
    let mut code = recipes::write(
        &loaded,
        &realizations,
        &controllers,
        options,
        &mut written,
        &mut findings,
    );
    if let (Some(file), [contract], [index]) = (page_file, contracts.as_slice(), indices.as_slice())
        && let Some(opponent) = opponent(&checked[*index], arguments.counterstrategy)
    {
        let command = page::command();
        let page = controller::Page {
            contract,
            definitions: library.definitions_of(contract),
            opponent,
            origin: page::origin(&command, &library.sources, &findings),
        };
        code = code.and(file.write(&controller::page(&page), console, &library.sources)?);
    }
    let written = written.finish(
        "synth",
        arguments.out.as_deref(),
        &loaded,
        findings,
        options,
    )?;
    Ok(written.and(code))
}

/// What a report shows: the controller, or the counterstrategy; `None` if there is none.
fn opponent(checked: &CheckedContract, counterstrategy: bool) -> Option<Opponent<'_>> {
    if counterstrategy {
        let explanation = checked.explanation.as_ref()?;
        return Some(Opponent::Counterstrategy(
            explanation.counterstrategy.as_ref()?,
        ));
    }
    checked.controller.as_ref().map(Opponent::Controller)
}

/// The counterstrategy of an unrealizable contract; if it is missing, adds a finding with the
/// reason.
pub(super) fn counterstrategy<'c>(
    checked: &'c CheckedContract,
    span: Span,
    findings: &mut Vec<Diagnostic>,
) -> Option<&'c mealy::Machine> {
    let found = checked
        .explanation
        .as_ref()
        .and_then(|l| l.counterstrategy.as_ref());
    if found.is_none() {
        if checked.verdict == Verdict::Unrealizable {
            let text = "no counterstrategy was found within the time and memory limits";
            let help = "give it more time with --timeout SECONDS or more memory with --memory MIB, or make its domains smaller";
            findings.push(Diagnostic::error(codes::GAVE_UP, span, text).with_help(help));
        } else {
            findings.extend(checked.findings_where_needed());
        }
    }
    found
}

/// Requests the controller of a contract; returns the index of the job.
pub(super) fn request(jobs: &mut Jobs, loaded: &LoadedFiles, contract: &Contract) -> usize {
    let (specification, span) = (&contract.specification, contract.span);
    match loaded.foreign(span.file) {
        Some(foreign) => jobs.add_foreign(specification, span, Goal::Controller, &foreign.reading),
        None => jobs.add(specification, span),
    }
}

/// A controller that is written.
struct Synthesized<'a> {
    controller: &'a mealy::Controller,
    specification: &'a Specification,
    origin: Origin,
    /// Place of the contract or of the statement.
    span: Span,
}

/// The names and texts of a controller's files in one form.
///
/// # Errors
/// LW204: the form cannot represent the controller, or would be too large.
fn write_files(
    synthesized: &Synthesized<'_>,
    emit: Emit,
) -> Result<Vec<(String, String)>, Box<Diagnostic>> {
    let Synthesized {
        controller,
        specification,
        origin,
        span,
    } = synthesized;
    if emit == Emit::C {
        let files = match controller {
            mealy::Controller::Machine(machine) => {
                c_files::of_machine_from(machine, specification, origin)
            }
            mealy::Controller::Functions(functions) => c_files::of_functions(functions),
        };
        let name = &files.name;
        return Ok(vec![
            (format!("{name}.h"), files.header),
            (format!("{name}.c"), files.source),
        ]);
    }
    if matches!(emit, Emit::St | Emit::Plcopen) {
        let block = structured_text::block_from(controller, specification, origin);
        let text = match emit {
            Emit::St => block.to_text(),
            _ => block.to_plcopen(),
        };
        let name = file_name(controller.name(), emit.ending());
        return Ok(vec![(name, text)]);
    }
    let (name, text) = match controller {
        mealy::Controller::Machine(machine) => {
            (&machine.name, write(emit, machine, specification)?)
        }
        mealy::Controller::Functions(functions) if emit == Emit::Json => {
            let document = functions.to_json(true);
            (&functions.name, mealy::json::to_text(&document))
        }
        mealy::Controller::Functions(functions) => {
            let name = &functions.name;
            let message = format!("the controller of `{name}` has too many states for this form");
            let finding = Diagnostic::error(codes::GAVE_UP, *span, message);
            return Err(Box::new(
                finding.with_help("use --emit json, c, st or plcopen"),
            ));
        }
    };
    Ok(vec![(file_name(name, emit.ending()), text)])
}

/// A machine in one form.
///
/// # Errors
/// LW204: the form would be too large.
fn write(
    emit: Emit,
    machine: &mealy::Machine,
    specification: &Specification,
) -> Result<String, Box<Diagnostic>> {
    let too_large = |limit: Limit| {
        Box::new(
            Diagnostic::error(
                codes::GAVE_UP,
                None,
                format!("`{}` was not written in this form: {limit}", machine.name),
            )
            .with_help("use --emit json, which writes transitions with guards"),
        )
    };
    Ok(match emit {
        Emit::Gr1c => format!(
            "{:#}\n",
            mealy::gr1c::to_json(machine, specification).map_err(too_large)?
        ),
        Emit::Dot => {
            let goals = mealy::picture::goals(specification);
            dot::render(&machine.name, &mealy::picture::to_graph(machine, &goals))
        }
        Emit::Svg => mealy::picture::to_svg(machine, Some(specification)),
        _ => mealy::json::to_text(&mealy::json::to_json(machine, true)),
    })
}
