//! `linewright check`: checks the consistency of every contract, machine and line found.

mod assembly;
mod changes;
mod document;
mod explained;
mod flow;
mod grounds;
mod recipe_page;
mod recipes;
mod report;
mod table;
mod view;
mod watch;

use super::console::Console;
use super::console::Failed;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::page::{self, PageFile};
use super::pictures;
use super::proof;
use super::schema::{Described, form};
use crate::contract::machine::Machine;
use crate::contract::{Contract, Library};
use crate::diagnostics::{Diagnostic, Severity, codes, has_errors, json, sarif};
use crate::engine::controller::ExtractionOptions;
use crate::engine::files::{self, LoadedFiles, StandardLibrary};
use crate::engine::machine::StateCount;
use crate::engine::machines::{self, MachinePlan};
use crate::engine::output;
use crate::engine::pipeline::{CheckedContract, Goal, Jobs, Memory, Settings, Verdict};
use crate::engine::prover::Discharges;
use crate::source::Span;
use assembly::Assembly;
use clap::Args;
use document::Document;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use view::{FileView, view};

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "check",
    "Verdicts on contracts, machines and lines",
    &[form::<Document>, form::<Failed>],
);

/// The end of the help.
const EXAMPLES: &str = "Examples:
    linewright check contracts/
    linewright check --format short contracts/handling/turn.lw
    linewright check --stats --proof turn.proof.json contracts/handling/turn.lw
    linewright check --report cell.html examples/ice-lab/line.lw
    linewright check --verdict-only examples/other-tools/arbiter.spc

    $ linewright check --watch contracts/

A contract is realizable if some controller keeps its guarantees as long as the plant keeps its \
assumptions (strict semantics, step by step). The controller is synthesized and verified, but \
not written; for a large contract that no machine uses, only the verdict is given. Results for \
unchanged contracts, machines and lines are read from the cache (see --no-cache).

Files of gr1c (.spc), slugs (.slugsin, .structuredslugs), Spectra (.spectra) and TLSF (.tlsf) are \
recognized by their extension; check reports the verdict, the reason if it is unrealizable, and \
suspicious formulas.

If an explanation takes more than a second, standard error says what is known so far.";

/// The arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = pictures::below(EXAMPLES, pictures::CHECK))]
pub struct Arguments {
    /// Files (.lw, .spc, .slugsin, .structuredslugs, .spectra, .tlsf), or folders with .lw files
    /// [default: ./contracts, or else the bundled library]
    #[arg(value_name = "PATH")]
    pub paths: Vec<String>,
    /// Show solver statistics for each contract: BDD kernel, time by phase, nodes, iterations,
    /// variable order
    #[arg(long)]
    pub stats: bool,
    /// Write a certificate that the contract is realizable, for other programs to check
    #[arg(
        long,
        value_name = "FILE",
        long_help = "Write a certificate of realizability as JSON: the ranking of the winning region (see \
docs/proof.md). Exactly one contract must be given"
    )]
    pub proof: Option<PathBuf>,
    /// Only decide whether contracts are realizable: no reasons, findings or controllers
    #[arg(
        long,
        conflicts_with = "proof",
        long_help = "Only decide whether each contract is realizable, which is all that other synthesis tools do by \
default: no reason if it is not, no findings about suspicious formulas, and no controller. \
Machines and lines are still proved"
    )]
    pub verdict_only: bool,
    /// Check again whenever a file has changed, until Ctrl-C
    #[arg(
        long,
        conflicts_with = "proof",
        long_help = "Check again whenever a file or one of its imports changes, until Ctrl-C; the exit code is that \
of the last check. Unchanged contracts are not solved again. With `--format json` each check is \
one document on one line, with the changes since the last one (`changes`, `unix_seconds`); \
SARIF is refused"
    )]
    pub watch: bool,
    /// Write a report as one HTML file: verdicts, findings, plays as timing diagrams, interfaces,
    /// drawings, and what each proof rests on
    #[arg(long, value_name = "FILE", conflicts_with = "watch")]
    pub report: Option<PathBuf>,
}

/// Result of a check.
struct CheckResult {
    /// The report, if one is wanted.
    page: Option<String>,
    loaded: LoadedFiles,
    document: Document,
    findings: Vec<Diagnostic>,
    code: ExitCode,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if arguments.watch {
        return watch::run(arguments, options);
    }
    let settings = options.settings();
    let loaded = load(arguments, options);
    let console = options.console();
    // A report that cannot be written ends the command before anything is solved.
    let file = match PageFile::begin(arguments.report.as_deref(), &loaded, "check", options)? {
        Ok(file) => file,
        Err(code) => return Ok(code),
    };
    let mut checked = check(loaded, arguments, options, &settings, None)?;
    write(console, &checked, options)?;
    if let (Some(file), Some(page)) = (file, checked.page.take()) {
        let code = file.write(&page, console, &checked.loaded.library.sources)?;
        checked.code = checked.code.and(code);
    }
    Ok(checked.code)
}

/// Loads the files.
fn load(arguments: &Arguments, options: &GlobalOptions) -> LoadedFiles {
    files::load(
        &arguments.paths,
        &StandardLibrary::new(options.library.clone()),
    )
}

/// Checks everything once.
fn check(
    loaded: LoadedFiles,
    arguments: &Arguments,
    options: &GlobalOptions,
    settings: &Settings,
    memory: Option<&mut Memory>,
) -> anyhow::Result<CheckResult> {
    let console = options.console();
    let files = FileView::all(&loaded);

    // Controllers of actions have the same form as in `build`.
    let mut jobs = Jobs::examining()
        .with_extraction(ExtractionOptions {
            functions: true,
            ..ExtractionOptions::default()
        })
        .with_ranking(arguments.proof.is_some());
    let goal = |goal| {
        if arguments.verdict_only {
            Goal::Answer
        } else {
            goal
        }
    };
    let library = &loaded.library;
    let contracts: Vec<(&Contract, usize)> = library
        .contracts
        .iter()
        .filter(|c| view(&files, c.span.file).is_some_and(|f| f.is_sound(c.span)))
        .filter(|c| !is_only_refined(&loaded, c))
        .map(|c| match loaded.foreign(c.span.file) {
            Some(foreign) => {
                let reading = &foreign.reading;
                let job = jobs.add_foreign(&c.specification, c.span, goal(Goal::Verdict), reading);
                (c, job)
            }
            None => (c, jobs.add_for(goal(Goal::Small), &c.specification, c.span)),
        })
        .collect();
    let machines: Vec<MachinePlan<'_>> = library
        .machines
        .iter()
        .filter(|m| view(&files, m.span.file).is_some_and(|f| f.is_sound(m.span)))
        .map(|m| MachinePlan::new(m, &mut jobs))
        .collect();
    let instances = line_instances(&files, library, &machines, &mut jobs);
    let progress = console.progress(jobs.len(), "checking");
    let announcing = options.announcing(settings, &progress);
    let checked = jobs.run_with(memory, &announcing, &progress);

    // Only the tables and pages show what a discharge rests on.
    let is_detailed = options.format == Format::Json || arguments.report.is_some();
    let discharges = if options.verbose || is_detailed {
        Discharges::Minimal
    } else {
        Discharges::Sufficient
    };
    let assembly = Assembly {
        loaded: &loaded,
        files: &files,
        contracts: &contracts,
        machines: &machines,
        instances: &instances,
        jobs: &jobs,
        checked: &checked,
        prover: settings.prover().with_discharges(discharges),
        progress: &console.progress(
            machines.len() + library.lines.len() + library.realizations.len(),
            "proving",
        ),
        verbose: options.verbose || arguments.report.is_some(),
        state_count: if is_detailed {
            StateCount::Wanted
        } else {
            StateCount::Omitted
        },
        timing: !options.no_timing,
        statistics: arguments.stats,
    };
    let (mut document, mut findings) = assembly.document();
    let page = arguments.report.as_ref().map(|_| {
        let command = page::command();
        let of = page::origin(&command, &library.sources, &findings);
        report::page(&assembly, &document, &of)
    });
    if let Some(path) = &arguments.proof {
        let own = contracts.iter().filter(|(c, _)| {
            loaded
                .roots
                .contains(&library.sources.file(c.span.file).name)
        });
        let own: Vec<_> = own.map(|(c, job)| (*c, &checked[*job])).collect();
        // If the contract itself has errors, they are already reported, so its absence is not
        // reported as well.
        let found = if own.is_empty() && has_errors(&findings) {
            Vec::new()
        } else {
            write_proof(path, &own, &loaded.places)?
        };
        document
            .findings
            .extend(json::findings(&library.sources, &found));
        document.summary.findings += found.len();
        findings.extend(found);
    }
    let contracts = document.contracts.iter().map(|c| c.verdict);
    let realizations = document.realizations.iter().map(|r| r.verdict);
    let code = contracts
        .chain(realizations)
        .map(ExitCode::from)
        .fold(options.exit_code(&findings), ExitCode::and);
    Ok(CheckResult {
        page,
        code: code.and(ExitCode::of_loading(&loaded)),
        document,
        findings,
        loaded,
    })
}

/// Plans the machines to which lines give arguments other than the defaults, each with the place of
/// the first such line.
fn line_instances<'a>(
    files: &[FileView<'_>],
    library: &'a Library,
    declared: &[MachinePlan<'a>],
    jobs: &mut Jobs,
) -> Vec<(Span, MachinePlan<'a>)> {
    let mut instances: Vec<(Span, MachinePlan<'a>)> = Vec::new();
    let lines = library.lines.iter();
    for line in lines.filter(|l| view(files, l.span.file).is_some_and(|f| f.is_sound(l.span))) {
        for machine in machines::of_line(line) {
            let own = instances.iter().map(|(_, planned)| planned);
            let mut known = declared.iter().chain(own);
            if !known.any(|p| machines::has_same_proofs(p.machine, machine)) {
                instances.push((line.span, MachinePlan::new(machine, jobs)));
            }
        }
    }
    instances
}

/// Whether a contract was imported only to be refined by machines. Such a contract is not solved: a
/// machine that refines it shows that it can be kept.
fn is_only_refined(loaded: &LoadedFiles, contract: &Contract) -> bool {
    let library = &loaded.library;
    let own = &library.sources.file(contract.span.file).name;
    let name = &contract.name;
    let refined = |m: &Machine| m.refines.iter().any(|r| r.contract == *name);
    let used = |m: &Machine| m.components.iter().any(|c| c.contract == *name);
    !loaded.roots.contains(own)
        && library.machines.iter().any(refined)
        && !library.machines.iter().any(used)
}

/// Writes the proof of the only contract. Returns a finding if the contract is unrealizable, or the
/// file cannot be written.
fn write_proof(
    path: &Path,
    contracts: &[(&Contract, &CheckedContract)],
    sources: &BTreeSet<PathBuf>,
) -> anyhow::Result<Vec<Diagnostic>> {
    let [(contract, checked)] = contracts else {
        anyhow::bail!(
            "--proof needs exactly one contract, but there are {}: give a file with one contract, or FILE::NAME",
            contracts.len()
        );
    };
    let name = &contract.name;
    let note = |text: String| {
        let mut note = Diagnostic::error(codes::UNREALIZABLE, contract.span, text);
        note.severity = Severity::Note;
        note
    };
    Ok(match (&checked.ranking, checked.verdict) {
        (Some(ranking), _) => {
            let text = proof::to_text(&contract.specification, ranking);
            output::write(path, &text, sources).err().map(|f| *f).into_iter().collect()
        }
        (None, Verdict::Unrealizable) => vec![
            note(format!("no proof of `{name}` was written to {}", path.display())).with_help(
                "--proof works only for realizable contracts; the guarantees that clash are listed above",
            ),
        ],
        // Another finding explains why there is no verdict.
        (None, _) => Vec::new(),
    })
}

/// Prints the result. Returns whether the output is still read.
fn write(console: Console, checked: &CheckResult, options: &GlobalOptions) -> anyhow::Result<bool> {
    let CheckResult {
        loaded,
        document,
        findings,
        ..
    } = checked;
    let sources = &loaded.library.sources;
    let text = |table: String| console.render(sources, findings) + &table;
    match options.format {
        Format::Json if document.occasion.is_some() => console.line(document),
        Format::Json => console.document(document).map(|()| true),
        Format::Sarif => {
            let document = sarif::document(sources, findings);
            console.document(&document).map(|()| true)
        }
        Format::Short => console.part(&text(table::short(document))),
        Format::Human => console.part(&text(table::human(document, options.verbose))),
    }
}
