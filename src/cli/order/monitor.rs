//! `linewright order monitor`: monitors calls as they arrive, and writes the monitor as C or
//! Structured Text.

use super::early_exit::{EarlyExit, Outcome};
use super::rules::{self, RuleSelection};
use super::{Choice, program};
use crate::automata::bound::BoundExceeded;
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::schema::{Described, by_hand, form};
use crate::cli::select::Selection;
use crate::engine::output;
use crate::order::Skills;
use crate::order::fsm::{calls, is_truncated};
use crate::order::monitor::{LazyMonitor, Monitor, Verdict};
use crate::order::supervisor::Supervisor;
use crate::order::table::{RuleCitation, Table};
use crate::station::monitor::{c, structured_text};
use anyhow::Context as _;
use clap::{Args, ValueEnum};
use rustc_hash::FxHashMap;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-monitor",
    "The answer to each call, one per line: `order monitor`",
    &[
        |generator| by_hand(include_str!("monitor.schema.json"), generator),
        form::<Failed>,
    ],
);

/// Name of the command in its documents and findings.
const COMMAND: &str = "order-monitor";

/// Maximum length in bytes of a line that is parsed as a call, and of a quoted line.
const MAX_CALL_BYTES: usize = 1 << 12;

/// The arguments of `order monitor`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order monitor examples/pick-and-place/unit.lw < examples/pick-and-place/intended.txt
    linewright order monitor examples/pick-and-place/unit.lw --emit c --out monitor

Every line of standard input is a call: a skill, or `Left & Down` for skills called simultaneously. \
Comments begin with `#` or `//`. Each call is answered with one line: the call, and `ok` or the reason for the refusal; with \
--format json, the line is an object such as `{\"line\":3,\"allowed\":true}`. A refused call has no effect. A line that is not a call is refused, too. The exit code is 1 if \
any call was refused.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Write the source of a monitor instead of monitoring standard input
    #[arg(long, value_enum, value_name = "FORM")]
    pub emit: Option<Emit>,
    /// Output folder [default: standard output]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Maximum number of skills called at once [default: one per component]
    #[arg(long, value_name = "N", default_value_t = 64, hide_default_value = true, value_parser = clap::value_parser!(u8).range(1..=64))]
    pub at_once: u8,
    /// Stop at the first refused call
    #[arg(long)]
    pub stop: bool,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Output form of a monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// Header and source file in C99.
    C,
    /// Function block in IEC 61131-3 Structured Text.
    St,
    /// Function block in `PLCopen` XML.
    Plcopen,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let chosen = rules::choose(COMMAND, &arguments.rules, &arguments.choice, options)?;
    // A monitor lists only the rules that it applies.
    let kept = chosen.skills.rules.iter().enumerate();
    let kept: Vec<usize> = kept
        .filter(|(_, r)| r.level <= chosen.options.level)
        .map(|(place, _)| place)
        .collect();
    let skills = chosen.skills.with_rules(&kept);
    let at_once = usize::from(arguments.at_once);
    let calls = calls(&skills, at_once);
    let is_truncated = is_truncated(&calls, &skills, at_once);
    let made = Supervisor::new(&skills, chosen.options)
        .map(|supervisor| (Table::explore(&supervisor, calls), supervisor));
    match (made, arguments.emit) {
        (Ok((Ok(table), _)), Some(emit)) => {
            if is_truncated {
                rules::report_omitted_calls(&table.calls, options)?;
            }
            write_monitor(&table, emit, arguments.out.as_deref(), &chosen, options)
        }
        (Ok((Ok(table), _)), None) if !is_truncated => {
            let checker = CallChecker::Table(Monitor::new(&table));
            Ok(watch(checker, &skills, arguments.stop, options)?)
        }
        // Without a table of all calls, the rules themselves are evaluated.
        (Ok((Ok(_) | Err(BoundExceeded::Count { .. }), supervisor)), None) => {
            let checker =
                CallChecker::Rules(LazyMonitor::new(&supervisor, u32::from(arguments.at_once)));
            Ok(watch(checker, &skills, arguments.stop, options)?)
        }
        (Err(error) | Ok((Err(error), _)), _) => {
            let also_helps = rules::fewer_at_once(arguments.at_once);
            Err(EarlyExit::gave_up(also_helps)(error))
        }
    }
}

/// Decides which calls are allowed.
enum CallChecker<'a> {
    /// By a table, without allocations.
    Table(Monitor<'a>),
    /// By evaluating the rules, if their table would be too large.
    Rules(LazyMonitor<'a>),
}

impl CallChecker<'_> {
    fn call(&mut self, skill: u8) -> Verdict {
        match self {
            Self::Table(monitor) => monitor.call(skill),
            Self::Rules(rules) => rules.call_at_once(1 << skill),
        }
    }

    fn call_at_once(&mut self, skills: u64) -> Verdict {
        match self {
            Self::Table(monitor) => monitor.call_at_once(skills),
            Self::Rules(rules) => rules.call_at_once(skills),
        }
    }
}

fn write_monitor(
    table: &Table,
    emit: Emit,
    out: Option<&Path>,
    chosen: &RuleSelection,
    options: &GlobalOptions,
) -> Outcome {
    let files: Vec<(String, String)> = match emit {
        Emit::C => {
            let files = c::files(table);
            vec![
                (format!("{}.h", files.name), files.header),
                (format!("{}.c", files.name), files.source),
            ]
        }
        Emit::St => {
            let block = structured_text::block(table);
            vec![(format!("{}.st", block.name), block.to_text())]
        }
        Emit::Plcopen => {
            let block = structured_text::block(table);
            vec![(format!("{}.xml", block.name), block.to_plcopen())]
        }
    };
    let console = options.console();
    let Some(folder) = out else {
        for (_, text) in &files {
            console.result(text)?;
        }
        return Ok(ExitCode::Success);
    };
    for (name, text) in &files {
        let path = folder.join(name);
        if let Err(finding) = output::write(&path, text, &chosen.loaded.places) {
            return chosen.failed(COMMAND, *finding, options);
        }
        console.remark(&format!("wrote {}\n", path.display()))?;
    }
    Ok(ExitCode::Success)
}

/// Answers the lines of standard input. With a table, an allowed call needs no allocation, unless
/// its line is the longest so far.
fn watch(
    mut monitor: CallChecker<'_>,
    skills: &Skills,
    stop: bool,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let cited: Vec<RuleCitation> = skills.rules.iter().map(RuleCitation::of).collect();
    let names: FxHashMap<&[u8], u8> = skills
        .skills
        .iter()
        .zip(0_u8..)
        .map(|(s, number)| (s.name.as_bytes(), number))
        .collect();
    let json = options.format == Format::Json;
    let mut input = BufReader::with_capacity(1 << 16, io::stdin().lock());
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    let mut line = Vec::new();
    let mut result = ExitCode::Success;
    let mut number = 0_u64;
    loop {
        line.clear();
        let read = input.read_until(b'\n', &mut line);
        if read.context("standard input cannot be read")? == 0 {
            break;
        }
        number += 1;
        let text = without_mark(&line, number);
        let call = without_comment(text);
        if call.is_empty() {
            continue;
        }
        let answer = if let Some(skill) = names.get(call) {
            Answer::of(monitor.call(*skill), &cited)
        } else if let Some(mask) = mask(call, &names) {
            Answer::of(monitor.call_at_once(mask), &cited)
        } else {
            match parse_call(call, skills) {
                Ok(mask) => Answer::of(monitor.call_at_once(mask), &cited),
                Err(wrong) => Answer::NoCall(wrong),
            }
        };
        let refused = !matches!(answer, Answer::Allowed);
        if refused {
            result = ExitCode::Findings;
        }
        let mut written = if json {
            answer.write_json(&mut out, number)
        } else {
            answer.write(&mut out, call, number)
        };
        // Flushes only if no further input is buffered: a sender that waits gets its answer, and
        // one that sends many lines at once is not slowed down.
        if input.buffer().is_empty() {
            written = written.and_then(|()| out.flush());
        }
        match written {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(result),
            other => other.context("standard output cannot be written")?,
        }
        if refused && stop {
            break;
        }
    }
    match out.flush() {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(result),
        other => {
            other.context("standard output cannot be written")?;
            Ok(result)
        }
    }
}

/// The text before a comment, trimmed.
fn without_comment(line: &[u8]) -> &[u8] {
    let opens = |at: usize| matches!(line[at..], [b'#', ..] | [b'/', b'/', ..]);
    let end = (0..line.len()).find(|at| opens(*at)).unwrap_or(line.len());
    line[..end].trim_ascii()
}

/// The set of skills in `Left & Down`; `None` if the text is not of this form.
fn mask(call: &[u8], names: &FxHashMap<&[u8], u8>) -> Option<u64> {
    call.split(|b| *b == b'&').try_fold(0_u64, |mask, piece| {
        let skill = names.get(piece.trim_ascii())?;
        let bit = 1 << skill;
        (mask & bit == 0).then_some(mask | bit)
    })
}

/// The text of a line; on the first line, without a byte order mark.
fn without_mark(line: &[u8], number: u64) -> &[u8] {
    if number > 1 {
        return line;
    }
    line.strip_prefix("\u{feff}".as_bytes()).unwrap_or(line)
}

/// The set of skills in a line that [`mask`] does not accept, such as one with non-ASCII spaces.
///
/// # Errors
/// Returns the reason why the line is not a call.
fn parse_call(call: &[u8], skills: &Skills) -> Result<u64, String> {
    if call.len() > MAX_CALL_BYTES {
        let longer = format!("this line has more than {MAX_CALL_BYTES} bytes");
        return Err(format!("{longer}: write each call on a separate line"));
    }
    let Ok(text) = str::from_utf8(call) else {
        return Err("this line is not UTF-8 text: send the names of skills in UTF-8".to_owned());
    };
    match program::call(text, skills) {
        Ok(call) => Ok(call.0),
        Err(wrong) => Err(format!("{}: {}", wrong.message, wrong.help)),
    }
}

/// Answer to a line.
enum Answer {
    Allowed,
    /// The call is refused, for this reason.
    Refused(String),
    /// The line is not a call, for this reason.
    NoCall(String),
}

impl Answer {
    fn of(verdict: Verdict, rules: &[RuleCitation]) -> Self {
        match verdict {
            Verdict::Allowed => Self::Allowed,
            Verdict::Refused(why) => Self::Refused(why.text(rules)),
        }
    }

    fn write(&self, out: &mut impl Write, call: &[u8], number: u64) -> io::Result<()> {
        match self {
            Self::Allowed => {
                out.write_all(call)?;
                out.write_all(b": ok\n")
            }
            Self::Refused(why) => {
                out.write_all(call)?;
                writeln!(out, ": refused, {why}")
            }
            // Control characters are replaced, so that the input cannot control a terminal.
            Self::NoCall(why) => {
                let call = &call[..call.len().min(MAX_CALL_BYTES)];
                let call = printable(&String::from_utf8_lossy(call));
                writeln!(out, "{call}: refused, line {number}: {}", printable(why))
            }
        }
    }

    fn write_json(&self, out: &mut impl Write, number: u64) -> io::Result<()> {
        match self {
            Self::Allowed => writeln!(out, "{{\"line\":{number},\"allowed\":true}}"),
            Self::Refused(why) | Self::NoCall(why) => {
                let why = serde_json::Value::from(why.as_str());
                writeln!(out, "{{\"line\":{number},\"allowed\":false,\"why\":{why}}}")
            }
        }
    }
}

fn printable(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}
