//! Options common to all commands.

use super::console::Console;
use super::exit::ExitCode;
use super::interrupt;
use crate::deadline::{Deadline, MemoryGauge};
use crate::diagnostics::Diagnostic;
use crate::engine::cache::Cache;
use crate::engine::pipeline::{Announcer, Settings};
use crate::game::{BudgetFactor, Heuristic, Heuristics, KernelChoice, Limits};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time for a command to print its results after its time limit, before it is terminated: some
/// work, such as parsing, does not check the time limit. The worker that runs the command adds its
/// own, and both together are less than a second.
const GRACE: Duration = Duration::from_millis(600);

/// Memory in bytes in which every command can report that it reached a limit. Below it, no command
/// is terminated because of its memory.
const LEAST_MEMORY: u64 = 64 << 20;

/// The memory of the process, without that of the compilers it starts.
static MEMORY: MemoryGauge =
    MemoryGauge::new(|| memory_stats::memory_stats().map(|stats| stats.physical_mem as u64));

/// Output format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text, with the source lines of findings.
    Human,
    /// One finding per line: `file:line:column: error[LW101]: message`.
    Short,
    /// One JSON document (`linewright schema` prints its schema).
    Json,
    /// Findings in SARIF 2.1.0, for code hosts and editors.
    Sarif,
}

/// When to use colors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless `NO_COLOR` is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// Findings that count as errors in the exit code, in addition to errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Deny {
    /// Warnings.
    Warnings,
}

/// Choice of the BDD kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kernel {
    /// Chosen by the size of the game.
    Auto,
    /// biodivine-lib-bdd: no start-up time; for small games.
    Biodivine,
    /// Linewright's own: a common store of nodes, and variable reordering; for large games.
    #[value(alias = "oxidd")]
    Shared,
}

/// The options that every command takes.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options for every command")]
pub struct GlobalOptions {
    /// Output format
    #[arg(long, global = true, value_enum, default_value = "human")]
    pub format: Format,
    /// When to use colors
    #[arg(
        long,
        global = true,
        value_enum,
        default_value = "auto",
        value_name = "WHEN"
    )]
    pub color: Color,
    /// Omit times and memory sizes, so that equal input gives equal output
    #[arg(long, global = true)]
    pub no_timing: bool,
    /// Time limit of the whole command [default: never]
    #[arg(long, global = true, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub timeout: Option<Duration>,
    /// Multiply the work limit of proofs and explanations by FACTOR
    #[arg(
        long,
        global = true,
        value_name = "FACTOR",
        default_value = "1",
        value_parser = effort,
        allow_negative_numbers = true,
        long_help = "Multiply the work limit of proofs of machines and lines, and of explanations, by FACTOR. Work is counted in BDD nodes \
and operations, not in seconds, so the same input has the same verdict on every computer"
    )]
    pub effort: BudgetFactor,
    /// Memory limit of the whole command, compilers excluded, in MiB
    #[arg(
        long,
        global = true,
        value_name = "MIB",
        default_value_t = 4096,
        allow_negative_numbers = true
    )]
    pub memory: u64,
    /// BDD kernel; verdicts do not depend on it
    #[arg(long, global = true, value_enum, default_value = "auto")]
    pub kernel: Kernel,
    /// Disable these heuristics (comma-separated), to measure their effect; verdicts do not depend
    /// on them
    #[arg(
        long,
        global = true,
        value_name = "NAME",
        value_delimiter = ',',
        value_parser = heuristic(),
        hide_possible_values = true,
        long_help = without_help()
    )]
    pub without: Vec<Heuristic>,
    /// Neither read nor write the cache of results and proofs
    #[arg(
        long,
        global = true,
        long_help = "Neither read nor write the cache of results and proofs. By default the cache is in the folder that LINEWRIGHT_CACHE names (`off` disables it), or else \
in the user's cache folder. It can be deleted at any time"
    )]
    pub no_cache: bool,
    /// Treat warnings as errors in the exit code
    #[arg(long, global = true, value_enum, value_name = "WHAT")]
    pub deny: Option<Deny>,
    /// Folder that `import std...` reads instead of the bundled library
    #[arg(long, global = true, value_name = "DIR")]
    pub library: Option<PathBuf>,
    /// Verbose: also show the file and kernel of each contract, and how assumptions are discharged
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// When the command began; its time limit counts from this moment.
    #[arg(skip = Instant::now())]
    pub began: Instant,
}

impl GlobalOptions {
    /// Creates the console for these options.
    pub fn console(&self) -> Console {
        Console::new(self.format, self.color)
    }

    /// Fails if the format is SARIF, which can only hold findings. `result` names what the command
    /// prints instead.
    pub fn refuse_sarif(&self, result: &str) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.format != Format::Sarif,
            "{result} has no findings, so it cannot be written as SARIF: use `--format json`, or `linewright check` for findings"
        );
        Ok(())
    }

    /// The limits of the whole command.
    pub fn limits(&self) -> Limits {
        self.limits_from(self.began)
    }

    /// Limits of a command that began at this time. Work stops at 15/16 of the memory, because it
    /// notices the limit a little later.
    pub fn limits_from(&self, began: Instant) -> Limits {
        Limits {
            budget_factor: self.effort,
            deadline: self
                .timeout
                .map_or(Deadline::NONE, |t| Deadline::after(began, t))
                .with_interrupt(interrupt::flag())
                .with_memory_limit(&MEMORY, self.memory_bytes() / 16 * 15),
            memory_mib: Some(self.memory),
            ..Limits::default()
        }
    }

    /// When the command is terminated even if it does not check its limits. The worker that runs
    /// the command allows 1/16 more memory, so that this is at 1.03 times the memory.
    pub fn hard_deadline(&self) -> Deadline {
        self.timeout
            .map_or(Deadline::NONE, |limit| {
                Deadline::after(self.began, limit).extended(GRACE)
            })
            .with_memory_limit(&MEMORY, (self.memory_bytes() / 32 * 31).max(LEAST_MEMORY))
    }

    fn memory_bytes(&self) -> u64 {
        self.memory.saturating_mul(1 << 20)
    }

    /// Settings of the solver.
    pub fn settings(&self) -> Settings {
        let on = self
            .without
            .iter()
            .fold(Heuristics::default(), |h, w| h.without(*w));
        Settings {
            limits: self.limits(),
            kernel: match self.kernel {
                Kernel::Auto => KernelChoice::Automatic,
                Kernel::Biodivine => KernelChoice::Biodivine,
                Kernel::Shared => KernelChoice::Shared,
            },
            heuristics: on,
            cache: if self.no_cache {
                None
            } else {
                Cache::of_user()
            },
            announcer: None,
        }
    }

    /// Returns settings with which the verdict of an unrealizable contract is printed to standard
    /// error while its explanation is being computed, above the progress bar. Only text for readers
    /// is accompanied by such lines, and not if equal input is to give equal output, because it
    /// depends on the time which of them are printed.
    pub fn announcing(&self, settings: &Settings, progress: &ProgressBar) -> Settings {
        let announces = self.format == Format::Human && !self.no_timing;
        let announcer = announces.then(|| {
            let (bar, console) = (progress.clone(), self.console());
            Announcer::new(move |line| {
                // If standard error is closed, the result is all that can be printed.
                let _ = bar.suspend(|| console.remark(&format!("{line}\n")));
            })
        });
        Settings {
            announcer,
            ..settings.clone()
        }
    }

    /// The exit code of a command with these findings.
    pub fn exit_code(&self, findings: &[Diagnostic]) -> ExitCode {
        ExitCode::of(findings, self.deny == Some(Deny::Warnings))
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    text.parse::<f64>()
        .ok()
        .and_then(|s| Duration::try_from_secs_f64(s).ok())
        .ok_or_else(|| "expected a number of seconds, such as 30 or 0.5".to_owned())
}

fn effort(text: &str) -> Result<BudgetFactor, String> {
    text.parse()
        .ok()
        .and_then(BudgetFactor::new)
        .ok_or_else(|| "expected a number above 0, such as 10 or 0.5".to_owned())
}

fn heuristic() -> impl TypedValueParser<Value = Heuristic> {
    let names = Heuristic::ALL.map(|(_, name)| name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Heuristic>())
}

fn without_help() -> String {
    let names = Heuristic::ALL.map(|(_, name)| name);
    format!(
        "Disable these heuristics (comma-separated), to measure their effect; verdicts do not depend on \
them. One of {}",
        names.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches as _;

    /// Later phases have only the time left by earlier ones.
    #[test]
    fn a_time_limit_covers_the_whole_command() {
        let command = GlobalOptions::augment_args(clap::Command::new("linewright"));
        let given = command.get_matches_from(["linewright", "--timeout", "5"]);
        let options = GlobalOptions::from_arg_matches(&given).expect("valid arguments");
        let first = options.limits().deadline;
        assert_ne!(first, Deadline::NONE);
        std::thread::sleep(Duration::from_millis(2));
        assert_eq!(options.settings().limits.deadline, first);
        let later = options.limits_from(Instant::now()).deadline;
        assert!(later.remaining() > first.remaining());
    }
}
