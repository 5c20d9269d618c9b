//! `linewright step`: plays a contract in the terminal, one step at a time.

use super::console::Console;
use super::exit::ExitCode;
use super::interrupt;
use super::options::{Format, GlobalOptions};
use super::page::{self, PageFile};
use super::pictures;
use super::select::Selection;
use crate::contract::Contract;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::controller::ExtractionOptions;
use crate::engine::files;
use crate::engine::output;
use crate::engine::pipeline::{CheckedContract, Goal, InternalError, Jobs, Verdict};
use crate::engine::worker::{self, Completion};
use crate::game::{self, GuaranteeRef, Limits};
use crate::gr1::{FormulaKind, Specification};
use crate::mealy::{counter, verify::verify_counterstrategy};
use crate::play::{Effect, Opponent, Session};
use crate::report::html::session;
use anyhow::Context as _;
use clap::Args;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, IsTerminal as _};
use std::path::{Path, PathBuf};

/// Maximum nesting depth of scripts that replay each other.
const MAX_NESTED: usize = 8;

/// The end of the help.
const EXAMPLES: &str = "Examples:
    linewright step contracts/handling/turn.lw --script examples/step/turn.txt
    linewright step contracts/handling/turn.lw --script examples/step/turn.txt --html turn.html

Without a script, commands are read from the terminal or a pipe; `help` lists them. If the \
contract is realizable, you play the plant against its verified controller. Otherwise you play \
the machine, and the plant plays the counterstrategy.

In a script or a pipe, a wrong command is reported on standard error, the next one is run, and \
the exit code is 1.";

/// The arguments of `step`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = pictures::below(EXAMPLES, pictures::STEP))]
pub struct Arguments {
    /// File, and the name of a contract if there are several
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// Run the commands in this file, one per line
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Save the play as one HTML file when it ends: a timing diagram, and all commands with their
    /// answers
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Random seed of the command `random`
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    options.refuse_sarif("a play")?;
    let console = options.console();
    // The limits of the command end loading, too, but not a play in a terminal.
    let (selection, own) = (arguments.selection.clone(), options.clone());
    let load = move |_: &dyn Fn(())| selection.load_alone("step", &own);
    let loaded = match worker::run(options.hard_deadline(), load, |_| ()) {
        Completion::Done(Ok(Ok(loaded))) => loaded,
        Completion::Done(Ok(Err(code))) => return Ok(code),
        Completion::Done(Err(error)) => return Err(error),
        Completion::Abandoned(late, _) => {
            console.aborted("step", &super::overdue("step", late))?;
            return Ok(ExitCode::GaveUp);
        }
    };
    let library = &loaded.library;
    let picked = arguments
        .selection
        .pick(&loaded, "contract", &library.contracts, |c| {
            (&c.name, c.span)
        })?;
    let selection = &arguments.selection;
    let contract = selection.only(&picked, "only one contract can be played at a time")?;
    let page_file = match PageFile::begin(arguments.html.as_deref(), &loaded, "step", options)? {
        Ok(file) => file,
        Err(code) => return Ok(code),
    };
    // An unreadable script ends the command before anything is solved.
    let script = match &arguments.script {
        Some(path) => Some(read(path)?),
        None => None,
    };

    let settings = options.settings();
    let mut jobs = Jobs::default().with_extraction(ExtractionOptions {
        functions: true,
        ..ExtractionOptions::default()
    });
    match loaded.foreign(contract.span.file) {
        Some(foreign) => jobs.add_foreign(
            &contract.specification,
            contract.span,
            Goal::Controller,
            &foreign.reading,
        ),
        None => jobs.add(&contract.specification, contract.span),
    };
    let solving = interrupt::Watch::new();
    let progress = console.progress(jobs.len(), "solving");
    let checked = jobs.run(&options.announcing(&settings, &progress), &progress);
    let Some(checked) = checked.into_iter().next() else {
        anyhow::bail!("the file has no contract to play");
    };
    let opponent = match opponent(contract, &checked, &settings.limits)? {
        Ok(opponent) => opponent,
        Err(findings) => {
            console.failed("step", &library.sources, &findings)?;
            return Ok(options.exit_code(&findings));
        }
    };
    drop(solving);

    let session = Session::new(
        &contract.specification,
        &library.sources,
        opponent,
        arguments.seed,
    );
    let mut terminal = Terminal {
        session,
        sources: &loaded.places,
        console,
        mistakes: 0,
        is_read: true,
        commands: Vec::new(),
    };
    let mut code = terminal.play(script.as_deref(), arguments)?;
    if let Some(file) = page_file {
        let command = page::command();
        let over = terminal.session.over();
        let text = session::page(&session::Page {
            contract,
            definitions: library.definitions_of(contract),
            person: terminal.session.person(),
            player: &player(arguments),
            plays: &terminal.session.plays(),
            commands: &terminal.commands,
            over: over.as_deref(),
            origin: page::origin(&command, &library.sources, &loaded.findings),
        });
        code = code.and(file.write(&text, console, &library.sources)?);
    }
    Ok(code)
}

/// Where the commands of a play come from, as the subject of a sentence.
fn player(arguments: &Arguments) -> String {
    match &arguments.script {
        Some(path) => format!("The script {}", path.display()),
        None if std::io::stdin().is_terminal() => "A person".to_owned(),
        None => "Commands from standard input".to_owned(),
    }
}

/// Returns the person's opponent, or findings if there is none.
fn opponent(
    contract: &Contract,
    checked: &CheckedContract,
    limits: &Limits,
) -> anyhow::Result<Result<Opponent, Vec<Diagnostic>>> {
    if let Some(controller) = &checked.controller {
        return Ok(Ok(Opponent::Controller(controller.clone())));
    }
    if checked.verdict != Verdict::Unrealizable {
        return Ok(Err(checked.findings_where_needed()));
    }
    let known = checked
        .explanation
        .as_ref()
        .and_then(|l| l.counterstrategy.clone());
    if let Some(machine) = known {
        return Ok(Ok(Opponent::Counterstrategy(machine)));
    }
    // The explanation of unrealizability reached its own limit. The core suffices: a controller
    // that cannot keep the guarantees of the core cannot keep all guarantees.
    let specification = restrict_to_core(&contract.specification, &checked.core);
    let gave_up = |limit: game::Limit| {
        let name = &contract.name;
        let core = checked.core.join(", ");
        let message = format!("`{name}` has no counterstrategy to play against: {limit}");
        let help =
            format!("these guarantees clash: {core}; `linewright check` shows them in the source");
        let finding = Diagnostic::error(codes::GAVE_UP, contract.span, message);
        vec![finding.with_help(help).giving_up(limit.is_external())]
    };
    let attack = match game::attack(&specification, &[], limits) {
        Ok(Some(attack)) => attack,
        Ok(None) => {
            let rule = "an unrealizable contract has no counterstrategy".to_owned();
            return Err(InternalError::new(&specification, rule).into());
        }
        Err(limit) => return Ok(Err(gave_up(limit))),
    };
    let machine = counter::to_machine(&specification, &attack);
    match verify_counterstrategy(&specification, &machine, limits) {
        Ok(Ok(())) => Ok(Ok(Opponent::Counterstrategy(machine))),
        Ok(Err(violation)) => {
            Err(InternalError::new(&specification, violation.clause.to_string()).into())
        }
        Err(limit) => Ok(Err(gave_up(limit))),
    }
}

/// The specification with only the guarantees of a core; with all of them if no core is known.
fn restrict_to_core(specification: &Specification, core: &[String]) -> Specification {
    let side = &specification.guarantees;
    let lists = [
        (FormulaKind::Initial, &side.initial),
        (FormulaKind::Invariant, &side.invariants),
        (FormulaKind::Safety, &side.safety),
        (FormulaKind::Justice, &side.justice),
    ];
    let mut kept = Vec::new();
    for (kind, list) in lists {
        for (index, formula) in list.iter().enumerate() {
            if core.is_empty() || formula.defines || core.contains(&formula.name) {
                kept.push(GuaranteeRef { kind, index });
            }
        }
    }
    game::select_guarantees(specification, &kept)
}

fn read(path: &Path) -> anyhow::Result<String> {
    files::read(path).map_err(|why| anyhow::anyhow!("{} cannot be read: {why}", path.display()))
}

/// Runs the commands of a play, with its input, output and files.
struct Terminal<'a> {
    session: Session<'a>,
    /// Paths of the sources on disk, which `save` must not overwrite.
    sources: &'a BTreeSet<PathBuf>,
    console: Console,
    /// Number of failed commands.
    mistakes: usize,
    /// Whether the output is still read.
    is_read: bool,
    /// The commands so far, each with what was answered.
    commands: Vec<(String, String)>,
}

impl Terminal<'_> {
    /// Plays with the commands of a script, of the terminal, or of a pipe.
    fn play(&mut self, script: Option<&str>, arguments: &Arguments) -> anyhow::Result<ExitCode> {
        if self.console.format == Format::Json {
            self.console.line(&self.session.opening_line())?;
        } else {
            self.print(&self.session.opening())?;
        }
        match script {
            Some(text) => {
                let name = arguments.script.as_deref().unwrap_or(Path::new(""));
                self.script(text, &name.display().to_string(), 0)?;
            }
            None if std::io::stdin().is_terminal() => return self.interact(),
            None => {
                let mut number = 0;
                for line in BufReader::new(std::io::stdin()).lines() {
                    number += 1;
                    let line = line.context("standard input cannot be read")?;
                    if !self.line(&line, &format!("line {number}"), 0)? {
                        break;
                    }
                }
            }
        }
        Ok(if self.mistakes == 0 {
            ExitCode::Success
        } else {
            ExitCode::Findings
        })
    }

    fn print(&mut self, text: &str) -> anyhow::Result<()> {
        self.is_read &= self.console.part(text)?;
        Ok(())
    }

    /// Runs a script. Returns whether the play continues.
    fn script(&mut self, text: &str, name: &str, depth: usize) -> anyhow::Result<bool> {
        for (index, line) in text.lines().enumerate() {
            if !self.line(line, &format!("{name}:{}", index + 1), depth)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Runs a line from a script, and echoes it before its output. Returns whether the play
    /// continues.
    fn line(&mut self, line: &str, place: &str, depth: usize) -> anyhow::Result<bool> {
        let command = line.trim();
        if self.console.format != Format::Json && !command.is_empty() {
            self.print(&format!("> {command}\n"))?;
        }
        self.command(command, depth, |message| format!("{place}: {message}"))
    }

    /// Runs a command. `shown` formats an error message. Returns whether the play continues.
    fn command(
        &mut self,
        line: &str,
        depth: usize,
        shown: impl Fn(&str) -> String,
    ) -> anyhow::Result<bool> {
        let ran = self.session.run(line);
        if !line.is_empty() && !line.starts_with('#') {
            let answer = ran
                .as_ref()
                .map_or_else(Clone::clone, |reply| reply.text.clone());
            self.commands.push((line.to_owned(), answer));
        }
        let done = match ran {
            Err(mistake) => Err(mistake),
            Ok(reply) => {
                if self.console.format == Format::Json {
                    for object in &reply.lines {
                        self.is_read &= self.console.line(object)?;
                    }
                } else {
                    self.print(&reply.text)?;
                }
                match reply.effect {
                    Effect::Nothing => Ok(()),
                    Effect::Quit => return Ok(false),
                    Effect::Save(file, text) => {
                        match output::write(Path::new(&file), &text, self.sources) {
                            Ok(()) => {
                                self.console.remark(&format!("wrote {file}\n"))?;
                                Ok(())
                            }
                            Err(finding) => Err(finding.message),
                        }
                    }
                    Effect::Replay(_) if depth == MAX_NESTED => {
                        Err(format!("scripts are nested more than {MAX_NESTED} deep"))
                    }
                    Effect::Replay(file) => match read(Path::new(&file)) {
                        Ok(text) => return self.script(&text, &file, depth + 1),
                        Err(error) => Err(format!("{error:#}")),
                    },
                }
            }
        };
        if let Err(mistake) = done {
            self.mistakes += 1;
            self.console
                .remark(&format!("{}\n", shown(mistake.trim_end())))?;
        }
        Ok(self.is_read)
    }

    /// Reads commands from a terminal until the end of the play or of the input.
    fn interact(&mut self) -> anyhow::Result<ExitCode> {
        let mut input = std::io::stdin().lock();
        loop {
            if self.console.format != Format::Json {
                self.print(&format!("{}> ", self.session.role()))?;
            }
            let mut line = String::new();
            let read = input.read_line(&mut line);
            if read.context("standard input cannot be read")? == 0 {
                self.print("\n")?;
                break;
            }
            if !self.command(line.trim(), 0, str::to_owned)? {
                break;
            }
        }
        Ok(ExitCode::Success)
    }
}
