//! `linewright run`: simulates a line in the bundled runner, with controllers synthesized from its
//! contracts.

mod page;
mod progress;
mod trace_files;
mod what_if;

use super::build::default_folder;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::page::PageFile;
use super::pictures;
use super::select::Selection;
use super::time;
use crate::contract::line::Line;
use crate::contract::machine::Machine;
use crate::contract::set::Setting;
use crate::diagnostics::{Diagnostic, codes, has_errors, json};
use crate::engine::files::LoadedFiles;
use crate::engine::simulation::{self, Run, SimulationOptions};
use crate::engine::synthesis::Synthesis;
use crate::engine::{lines, machines};
use crate::event_log::Epoch;
use crate::line::batches::{MAX_BATCHES, MIN_BATCHES};
use crate::line::comparison::{Comparison, compare};
use crate::line::log::Observers;
use crate::line::{Count, Observer, Options};
use crate::report::html::run::Recorder;
use crate::report::{self, Intervals, Variant};
use clap::Args;
use progress::RunProgress;
use std::collections::BTreeMap;
use std::path::PathBuf;
use trace_files::{TraceFile, TraceFiles};
use what_if::{Changes, DEFAULT_PAIRS};

/// The end of the help.
const EXAMPLES: &str = "Examples:
    linewright run examples/ice-lab/line.lw --parts 50
    linewright run examples/ice-lab/line.lw --until 8h --seed 7 --replications 10
    linewright run examples/ice-lab/line.lw --parts 400 --warm-up 1h --batches 20
    linewright run examples/ice-lab/line.lw --parts 50 --set printer.time='40 s'
    linewright run examples/ice-lab/line.lw --parts 50 --what-if printer=10%
    linewright run examples/bottling/line.lw --until 1d --report bottling.html
    linewright run examples/ice-lab/line.lw --until 8h --trace run.parquet --trace run.perfetto.json

TIME is a number of seconds (3600) or has units (90m, 8h, 1d, 1h30m).";

/// The arguments of `run`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = pictures::below(EXAMPLES, pictures::RUN))]
pub struct Arguments {
    /// File with a line, and the name of the line if there are several
    #[arg(value_name = "LINE")]
    pub selection: Selection,
    /// Stop after N finished products (after the warm-up)
    #[arg(long, value_name = "N", value_parser = products, allow_negative_numbers = true)]
    pub parts: Option<u64>,
    /// Stop at this simulation time
    #[arg(long, value_name = "TIME", value_parser = time::seconds, allow_hyphen_values = true)]
    pub until: Option<f64>,
    /// Count nothing until this simulation time, because the line is still filling, or until a
    /// number of products is finished, `'500 parts'`; `auto` finds the time
    #[arg(long, value_name = "TIME", value_parser = warm_up, allow_hyphen_values = true)]
    pub warm_up: Option<WarmUp>,
    /// Set a number of the line for this run, such as `capper.takes='2 s'`; repeatable
    #[arg(
        long,
        value_name = "NAME=VALUE",
        long_help = "Set a number of the line for this run, such as `capper.takes='2 s'` or `belt.places=8`; repeatable. The value is checked as if it \
stood in the file. A number of a machine is set for one station only. A wrong name is answered with the names that there are"
    )]
    pub set: Vec<Setting>,
    /// Compare with a variant under the same random seeds: `capper.takes='2 s'`, or a station that
    /// is 10 % faster, `capper=10%`; repeatable
    #[arg(
        long,
        value_name = "NAME=VALUE",
        long_help = "Run the line, and a variant of it under the same random seeds, and print the difference of each measure with its paired 95 % \
confidence interval. NAME=VALUE is a number as in --set, or a station and how many percent faster it works: capper=10% divides its times of work by \
1.1, and capper=-10% by 0.9. All that are given make one variant, unless they begin with the names of several: --what-if 'fast: capper=10%' --what-if \
'slow: capper=-10%'. The default for --replications is then 10"
    )]
    pub what_if: Vec<Setting>,
    /// Random seed
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Number of replications, with consecutive random seeds; their confidence intervals decide the
    /// requirements [default: 1; with --precision, at most 1000]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub replications: Option<u32>,
    /// Make replications until throughput and mean lead time have this relative precision, such as
    /// 1%
    #[arg(long, value_name = "P", value_parser = precision)]
    pub precision: Option<f64>,
    /// Cut the run after the warm-up into N batches, usually 10 to 30; confidence intervals of
    /// their means decide the requirements
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(i64::from(MIN_BATCHES)..=i64::from(MAX_BATCHES)),
        conflicts_with_all = ["replications", "precision", "what_if"],
        long_help = "Cut the run after the warm-up into N batches, usually 10 to 30, and give the means of the batches with confidence intervals, by \
which requirements are judged. One long run needs one warm-up only. Batches are as long as each other if --until ends the run, and have as many products \
each if --parts does. A finding says if they may be too short"
    )]
    pub batches: Option<u32>,
    /// Write a report as one HTML file: the line as a picture in which the run is played, charts,
    /// tables, and the model itself. With replications, pictures and charts show the first run
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Write every event of the run to a file, while it runs; repeatable. With replications, this
    /// is the first run
    #[arg(
        long,
        value_name = "FILE",
        long_help = "Write every event of the run to a file, while it runs; repeatable. With replications or --what-if, this is the first run of the line. The \
extension gives the format: .csv; .parquet; .jsonl (JSON lines); .perfetto.json or .trace.json (for ui.perfetto.dev); .ocel.json or .jsonocel (OCEL 2.0, \
for process mining by objects); .xes (IEEE 1849, for process mining by cases). An existing file is replaced when the run has ended"
    )]
    pub trace: Vec<TraceFile>,
    /// Date and time (UTC) at which the run starts, for formats with dates [default: midnight of
    /// the line's first day, or 2026-01-05T00:00:00]
    #[arg(long, value_name = "DATE", requires = "trace")]
    pub epoch: Option<Epoch>,
    /// Folder of the station libraries [default: .linewright next to the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compile again even if nothing has changed
    #[arg(long)]
    pub rebuild: bool,
}

/// The warm-up of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WarmUp {
    /// Found by a pilot run.
    Auto,
    /// Simulated seconds.
    Seconds(f64),
    /// Finished end products.
    Products(u64),
}

fn warm_up(text: &str) -> Result<WarmUp, String> {
    if text.trim() == "auto" {
        return Ok(WarmUp::Auto);
    }
    if let Some(count) = counted_products(text) {
        return count;
    }
    time::seconds(text)
        .map(WarmUp::Seconds)
        .map_err(|why| format!("{why}, products (`500 parts`), or `auto`"))
}

/// Parses a number of products.
fn products(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| "write a whole number from 1 on".to_owned())
}

/// Parses a number of products, such as `500 parts`; `None` for a text without this word.
fn counted_products(text: &str) -> Option<Result<WarmUp, String>> {
    let mut words = ["parts", "part", "products", "product"].into_iter();
    let digits = words.find_map(|word| text.trim().strip_suffix(word))?;
    let count = digits.trim_end().parse::<u64>().ok();
    Some(match count.filter(|count| *count > 0) {
        Some(count) => Ok(WarmUp::Products(count)),
        None => Err(format!(
            "`{}` is not a number of finished products: write for example `500 parts`",
            text.trim()
        )),
    })
}

/// Maximum number of replications with `--precision` if `--replications` does not limit them.
const MOST_REPLICATIONS: u64 = 1000;

/// Parses a relative precision: `1%`, `1 %` or `0.01`.
fn precision(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (digits, scale) = match text.strip_suffix('%') {
        Some(digits) => (digits.trim_end(), 0.01),
        None => (text, 1.0),
    };
    let value = digits.parse::<f64>().ok().map(|value| value * scale);
    value
        .filter(|value| (1e-6..1.0).contains(value))
        .ok_or_else(|| format!("`{text}` is not a precision: write for example `1%`, or `0.01`"))
}

/// Names and values of settings, by name, so that their order does not matter.
fn settings_by_name(settings: &[Setting]) -> BTreeMap<&str, &str> {
    settings.iter().map(|s| (s.name(), s.value())).collect()
}

/// The runs of a line, or of a variant of it.
struct Simulated {
    loaded: LoadedFiles,
    line: Line,
    run: Run,
    findings: Vec<Diagnostic>,
    /// What a report shows of the first run, and its file, if one is wanted.
    recorder: Option<Recorder>,
    page_file: Option<PageFile>,
    /// What differs in the variants of the line, if it is run as it is.
    variants: Vec<Changes>,
}

/// A variant, its runs, and how they differ from those of the line.
struct Compared {
    variant: Variant,
    simulated: Simulated,
    differences: Vec<Comparison>,
}

impl Compared {
    /// The part of the document about it.
    fn json(&self) -> serde_json::Result<serde_json::Value> {
        let mut what_if = report::what_if_json(&self.variant, &self.differences);
        let sources = &self.simulated.loaded.library.sources;
        let findings = json::findings(sources, &self.simulated.findings);
        what_if["findings"] = serde_json::to_value(findings)?;
        Ok(what_if)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let simulation = simulation_options(arguments, options)?;
    let mut base = match simulate(arguments, &arguments.set, &simulation, true, options)? {
        Ok(simulated) => simulated,
        Err(code) => return Ok(code),
    };
    let mut code = options.exit_code(&base.findings);
    let mut compared: Vec<Compared> = Vec::new();
    let mut variants = std::mem::take(&mut base.variants);
    if arguments.report.is_some() && !variants.is_empty() {
        let numbers = arguments.selection.settable(&base.line.name, options);
        let set = settings_by_name(&arguments.set);
        for changes in &mut variants {
            changes.compare_numbers(&set, &numbers);
        }
    }
    for changes in variants {
        let variant = SimulationOptions {
            find_warm_up: false,
            replications: Count::Fixed(base.run.traces.len() as u64),
            speeds: changes.speeds,
            ..simulation.clone()
        };
        let variant = SimulationOptions {
            options: Options {
                warm_up: match simulation.options.warm_up_products {
                    0 => base.run.traces[0].warm_up,
                    // Each run ends its own warm-up.
                    _ => 0.0,
                },
                ..variant.options
            },
            ..variant
        };
        match simulate(arguments, &changes.set, &variant, false, options)? {
            Ok(simulated) => {
                code = code.and(options.exit_code(&simulated.findings));
                compared.push(Compared {
                    variant: changes.variant,
                    differences: compare(&base.run.traces, &simulated.run.traces),
                    simulated,
                });
            }
            Err(code) => return Ok(code),
        }
    }
    let set = settings_by_name(&arguments.set);
    let page_file = base.page_file.take();
    let Simulated {
        loaded,
        line,
        run,
        findings,
        ..
    } = &base;
    let sources = &loaded.library.sources;
    let trace = &run.traces[0];
    let is_single = simulation.replications == Count::Fixed(1);
    let several = (!is_single).then_some(Intervals::Replications(&run.replications));
    let several = several.or(run.batches.as_ref().map(Intervals::Batches));
    let seconds = (!options.no_timing).then_some(run.seconds);
    match options.format {
        Format::Json => {
            let mut document = report::json(line, trace, several, seconds);
            document["findings"] = serde_json::to_value(json::findings(sources, findings))?;
            if !set.is_empty() {
                document["set"] = serde_json::to_value(&set)?;
            }
            let what_if = compared.iter().map(Compared::json);
            let mut what_if = what_if.collect::<Result<Vec<_>, _>>()?;
            if what_if.len() > 1 {
                document["variants"] = what_if.clone().into();
            }
            if !what_if.is_empty() {
                document["what_if"] = what_if.swap_remove(0);
            }
            console.document(&document)?;
        }
        Format::Sarif => console.failed("run", sources, findings)?,
        Format::Human | Format::Short => {
            let mut text = report::settings(&set) + &report::table(line, trace, several);
            if options.verbose {
                text += &report::details(line, trace, several);
            }
            for of in &compared {
                text += &report::what_if_table(&of.variant, &of.differences);
            }
            console.result(&text)?;
            console.findings(sources, findings)?;
            for of in compared
                .iter()
                .filter(|of| !of.simulated.findings.is_empty())
            {
                console.remark(&match of.variant.name.as_str() {
                    "" => "with --what-if:\n".to_owned(),
                    name => format!("with --what-if {name}:\n"),
                })?;
                let sources = &of.simulated.loaded.library.sources;
                console.findings(sources, &of.simulated.findings)?;
            }
        }
    }
    if let Some(file) = page_file
        && let Some(text) = page::page(arguments, &base, several, &compared)
    {
        code = code.and(file.write(&text, console, sources)?);
    }
    Ok(code)
}

/// The options of all runs.
fn simulation_options(
    arguments: &Arguments,
    options: &GlobalOptions,
) -> anyhow::Result<SimulationOptions> {
    let count = match (arguments.precision, arguments.replications) {
        (Some(precision), most) => Count::Until {
            precision,
            most: most.map_or(MOST_REPLICATIONS, u64::from),
        },
        (None, None) if !arguments.what_if.is_empty() => Count::Fixed(DEFAULT_PAIRS),
        (None, count) => Count::Fixed(count.map_or(1, u64::from)),
    };
    if count == Count::Fixed(1) && !arguments.what_if.is_empty() {
        anyhow::bail!("--what-if needs at least 2 replications for an interval");
    }
    Ok(SimulationOptions {
        options: Options {
            seed: arguments.seed,
            parts: arguments.parts,
            until: arguments.until,
            batches: arguments.batches,
            warm_up: match arguments.warm_up {
                Some(WarmUp::Seconds(seconds)) => seconds,
                Some(WarmUp::Auto | WarmUp::Products(_)) | None => 0.0,
            },
            warm_up_products: match arguments.warm_up {
                Some(WarmUp::Products(products)) => products,
                _ => 0,
            },
            deadline: options.settings().limits.deadline,
        },
        find_warm_up: arguments.warm_up == Some(WarmUp::Auto),
        replications: count,
        speeds: BTreeMap::new(),
        is_study: !arguments.set.is_empty() || !arguments.what_if.is_empty(),
        rebuild: arguments.rebuild,
        monitor: None,
    })
}

/// Loads the line with these settings, synthesizes its controllers and runs it. Prints the findings
/// that prevent this, and returns the exit code then.
fn simulate(
    arguments: &Arguments,
    set: &[Setting],
    simulation: &SimulationOptions,
    is_observed: bool,
    options: &GlobalOptions,
) -> anyhow::Result<Result<Simulated, ExitCode>> {
    let console = options.console();
    let settings = options.settings();
    let loaded = match arguments.selection.load_with(set, "run", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(Err(code)),
    };
    let library = &loaded.library;
    let sources = &library.sources;
    let picked = arguments
        .selection
        .pick(&loaded, "line", &library.lines, |l| (&l.name, l.span))?;
    let [line] = picked.as_slice() else {
        let names: Vec<&str> = picked.iter().map(|l| l.name.as_str()).collect();
        anyhow::bail!(
            "there are several lines in {path}: write {path}::{} or another of {}",
            names[0],
            names.join(", "),
            path = arguments.selection.path,
        );
    };
    if arguments.parts.is_none() && arguments.until.is_none() && line.limit.is_none() {
        let finding = Diagnostic::error(
            codes::LINE_LIMIT,
            line.span,
            format!("a run of `{}` has no end condition", line.name),
        )
        .with_help(
            "give --parts N or --until TIME, or write for example `limit 50 products` in the line",
        );
        console.failed("run", sources, &[finding])?;
        return Ok(Err(ExitCode::CannotRun));
    }

    let what_if = if is_observed {
        &arguments.what_if[..]
    } else {
        &[]
    };
    let mut with_options = sources.clone();
    let variants = match Changes::variants(what_if, set, line, &mut with_options) {
        Ok(variants) => variants,
        Err(found) => {
            console.failed("run", &with_options, &found)?;
            return Ok(Err(options.exit_code(&found)));
        }
    };

    let traces: &[TraceFile] = if is_observed { &arguments.trace } else { &[] };
    let report = arguments.report.as_deref().filter(|_| is_observed);
    let (files, page_file) = match (
        TraceFiles::new(traces, &loaded.places),
        PageFile::new(report, &loaded.places),
    ) {
        (Ok(files), Ok(page_file)) => (files, page_file),
        (files, page_file) => {
            let mut found = files.err().unwrap_or_default();
            found.extend(page_file.err().map(|finding| *finding));
            console.failed("run", sources, &found)?;
            return Ok(Err(options.exit_code(&found)));
        }
    };

    let of_line = machines::of_line(line).into_iter().map(|m| &**m);
    let synthesis = Synthesis::new(of_line, &settings, |count| {
        console.progress(count, "synthesizing")
    });
    let mut findings = loaded.findings.clone();
    findings.extend(synthesis.findings());
    let controlled: Vec<_> = synthesis.controlled().collect();
    if synthesis.is_complete() {
        for (index, machine) in controlled.iter().enumerate() {
            // A machine that was set for one station differs in times only.
            let mut earlier = controlled[..index].iter();
            if !earlier.any(|m| machines::has_same_proofs(m.machine, machine.machine)) {
                findings.extend(synthesis.judge(machine, &settings));
            }
        }
    }
    if !synthesis.is_complete() || has_errors(&findings) {
        console.failed("run", sources, &findings)?;
        return Ok(Err(options.exit_code(&findings)));
    }

    // A line whose stations refuse parts is run nevertheless, to show how often this happens; the
    // refusals are still errors.
    let of_machine = |machine: &Machine| synthesis.of(machine);
    lines::add_call_findings(line, of_machine, &settings.limits, &mut findings);

    let default = default_folder(&arguments.selection.path);
    let folder = arguments.out.as_deref().unwrap_or(&default);
    let progress = RunProgress::new(simulation.replications);
    let simulation = SimulationOptions {
        monitor: progress.monitor(),
        ..simulation.clone()
    };
    let mut recorder = page_file.is_some().then(|| Recorder::new(line));
    let mut logs = files.logs(line, simulation.options.seed, arguments.epoch);
    let mut observers = Observers::default();
    if !traces.is_empty() {
        observers.0.push(&mut logs);
    }
    if let Some(recorder) = &mut recorder {
        observers.0.push(recorder);
    }
    let observer = (!observers.0.is_empty()).then_some(&mut observers as &mut dyn Observer);
    let run = simulation::simulate(line, &controlled, folder, &simulation, observer);
    let written = logs.finish();
    progress.clear();
    match run {
        Ok(run) => {
            findings.extend(run.findings());
            findings.extend(files.keep(written));
            let line = Line::clone(line);
            drop(controlled);
            drop(synthesis);
            Ok(Ok(Simulated {
                loaded,
                line,
                run,
                findings,
                recorder,
                page_file,
                variants,
            }))
        }
        Err(found) => {
            findings.extend(found);
            console.failed("run", sources, &findings)?;
            Ok(Err(options.exit_code(&findings)))
        }
    }
}
