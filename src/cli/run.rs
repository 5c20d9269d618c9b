//! `linewright run`: a line in the bundled runner, from its contracts to its figures.

use super::build::default_folder;
use super::exit::ExitCode;
use super::libraries;
use super::options::{Format, GlobalOptions};
use super::select::Selection;
use super::time;
use crate::contract::line::{Line, NodeKind};
use crate::contract::machine::Machine;
use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::engine::controlled::Controlled;
use crate::engine::controller::Wish;
use crate::engine::internal;
use crate::engine::judgement;
use crate::engine::lines;
use crate::engine::machines::{self, Planned};
use crate::engine::pipeline::Jobs;
use crate::line::{Options, Plant};
use crate::report;
use crate::station::load::Library;
use crate::station::profile::Profile;
use crate::station::{Controller, Package, Toolchain};
use clap::Args;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// The arguments of `run`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright run examples/ice-lab/line.lw --parts 50
    linewright run examples/ice-lab/line.lw --until 8h --seed 7 --replications 10

TIME is a number of seconds (3600) or has units (90m, 8h, 1d, 1h30m).")]
pub struct Arguments {
    /// A file with a line, and its name where there are several
    #[arg(value_name = "LINE")]
    pub selection: Selection,
    /// End when so many end products are made
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub parts: Option<u64>,
    /// End at this time of the simulation
    #[arg(long, value_name = "TIME", value_parser = time::seconds)]
    pub until: Option<f64>,
    /// Where all randomness comes from
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Run so many times, with the seeds that follow
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub replications: u32,
    /// The folder for the station libraries [default: .linewright beside the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compile again what is there already
    #[arg(long)]
    pub rebuild: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let settings = options.settings();
    let loaded = match arguments.selection.load("run", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
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
        let endless = Diagnostic::error(
            codes::LINE_LIMIT,
            line.span,
            format!("nothing says when a run of `{}` ends", line.name),
        )
        .with_help(
            "say it with --parts N or --until TIME, or write `limit 50 products` into the line",
        );
        console.failed("run", sources, &[endless])?;
        return Ok(ExitCode::CannotRun);
    }

    let mut jobs = Jobs::default().wishing(Wish {
        functions: true,
        ..Wish::default()
    });
    let planned: Vec<Planned<'_>> = machines::of_line(line)
        .into_iter()
        .map(|m| Planned::new(m, &mut jobs))
        .collect();
    let checked = jobs.run(&settings, &console.progress(jobs.len(), "synthesizing"));
    let mut findings = loaded.findings.clone();
    findings.extend(machines::findings_where_needed(&planned, &jobs, &checked));
    let controlled: Option<Vec<_>> = planned.iter().map(|p| p.controlled(&checked)).collect();
    for machine in controlled.iter().flatten() {
        findings.extend(judgement::findings(
            machine,
            &settings.limits,
            settings.cache.as_ref(),
        ));
    }
    let Some(controlled) = controlled.filter(|_| !has_errors(&findings)) else {
        console.failed("run", sources, &findings)?;
        return Ok(options.exit_code(&findings));
    };

    // A line that refuses parts can be run, and its run shows how often; that it does is an error all the same.
    let of_machine = |machine: &Machine| {
        let mut known = controlled.iter();
        let known = known.find(|c| std::ptr::eq(c.machine, machine))?;
        Some(Controlled {
            machine: known.machine,
            controllers: known.controllers.clone(),
        })
    };
    let doing = || format!("following the parts of the line `{}`", line.name);
    let followed = internal::caught(doing, || lines::follow(line, of_machine, &settings.limits));
    let followed = followed.unwrap_or_else(|fault| lines::Followed {
        findings: vec![fault.finding(Some(line.span))],
        ..lines::Followed::default()
    });
    findings.retain(|f| !(followed.routes_decided && lines::is_doubt(f, line)));
    findings.extend(followed.findings);
    findings.extend(followed.remarks);

    let default = default_folder(&arguments.selection.path);
    let run_options = RunOptions {
        parts: arguments.parts,
        until: arguments.until,
        seed: arguments.seed,
        replications: arguments.replications,
        deadline: settings.limits.deadline,
        rebuild: arguments.rebuild,
        timing: !options.no_timing,
    };
    let folder = arguments.out.as_deref().unwrap_or(&default);
    match simulate(line, &controlled, folder, &run_options) {
        Ok(run) => {
            findings.extend(run.findings);
            match options.format {
                Format::Json => console.document(&run.document)?,
                Format::Sarif => console.failed("run", sources, &findings)?,
                Format::Human | Format::Short => console.result(&run.table)?,
            }
            if options.format != Format::Sarif {
                console.findings(sources, &findings)?;
            }
        }
        Err(more) => {
            findings.extend(more);
            console.failed("run", sources, &findings)?;
        }
    }
    Ok(options.exit_code(&findings))
}

/// How a line is to be run.
#[derive(Debug, Clone, Copy)]
struct RunOptions {
    /// End after so many end products.
    parts: Option<u64>,
    /// End after so many simulated seconds.
    until: Option<f64>,
    /// The first seed.
    seed: u64,
    /// How many runs, with seeds `seed`, `seed + 1`, ...
    replications: u32,
    /// Give up at this instant.
    deadline: Option<Instant>,
    /// Compile the libraries even where they are there already.
    rebuild: bool,
    /// Whether measured times belong into the result.
    timing: bool,
}

/// What a run came to.
#[derive(Debug)]
struct Run {
    /// The table for a person.
    table: String,
    /// The document of INTERFACE, `linewright/run/1`.
    document: serde_json::Value,
    /// Violations, requirements that do not hold, a line that is blocked.
    findings: Vec<Diagnostic>,
}

/// Builds and loads the libraries of a line's machines and runs it.
fn simulate(
    line: &Line,
    machines: &[Controlled<'_>],
    folder: &Path,
    options: &RunOptions,
) -> Result<Run, Vec<Diagnostic>> {
    let profile = Profile::assumed();
    let packages: Vec<Package> = machines
        .par_iter()
        .map(|m| libraries::package(m, &profile))
        .collect();
    let mut findings = Vec::new();
    let mut libraries = Vec::new();
    for built in
        Toolchain::host()
            .until(options.deadline)
            .build_all(&packages, folder, options.rebuild)
    {
        match built.and_then(|b| Library::open(&b.path)) {
            Ok(library) => libraries.push(library),
            Err(error) => {
                // A compiler that is missing is missing for every machine.
                let finding = error.to_diagnostic();
                if !findings.contains(&finding) {
                    findings.push(finding);
                }
            }
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
            Some(Err(error)) => findings.push(
                Diagnostic::error(
                    codes::LIBRARY_CALL,
                    node.span,
                    format!("`{}` cannot be instantiated: {error}", node.name),
                )
                .with_help(
                    "build it anew with --rebuild; `linewright explain LW505` lists the codes",
                ),
            ),
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
            deadline: options.deadline,
            ..Options::default()
        },
    )?;
    let start = Instant::now();
    let (traces, replications) = plant.replicate(u64::from(options.replications));
    let wall = options.timing.then(|| start.elapsed().as_secs_f64());
    let findings = replications.findings.clone();
    let replications = (options.replications > 1).then_some(replications);
    Ok(Run {
        table: report::table(&line, &traces[0], replications.as_ref()),
        document: report::json(&line, &traces[0], replications.as_ref(), wall),
        findings,
    })
}
