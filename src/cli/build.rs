//! `linewright build`: the station library of a machine.

use super::console::schema;
use super::controller::Wish;
use super::exit::ExitCode;
use super::libraries::{self, Target};
use super::machines::{self, Planned};
use super::options::{Format, GlobalOptions};
use super::pipeline::Jobs;
use super::select::Selection;
use crate::diagnostics::{has_errors, json};
use crate::station::fmi;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The arguments of `build`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright build examples/ice-lab/cell.lw
    linewright build examples/ice-lab/camera.lw::QualityCheck --target source --out station

`linux` needs a C compiler; `windows` needs MinGW's (x86_64-w64-mingw32-gcc) or Zig (zig, or Python's package ziglang); `source` \
needs none. `fmu` takes what there is.")]
pub struct Arguments {
    /// A file with machines, and the name of one of them; without a name, all that the file declares
    #[arg(value_name = "FILE[::NAME]")]
    pub selection: Selection,
    /// What to build; can be given several times
    #[arg(long, value_enum, default_value = "linux")]
    pub target: Vec<Target>,
    /// The folder to write to [default: .linewright beside the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compile again what is there already
    #[arg(long)]
    pub rebuild: bool,
}

#[derive(Serialize)]
struct Document {
    schema: String,
    libraries: Vec<Built>,
    findings: Vec<json::Finding>,
}

#[derive(Serialize)]
struct Built {
    machine: String,
    target: &'static str,
    files: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let settings = options.settings();
    let loaded = match arguments.selection.load("build", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let library = &loaded.library;
    let picked = arguments
        .selection
        .pick(&loaded, "machine", &library.machines, |m| (&m.name, m.span))?;
    let mut jobs = Jobs::default().wishing(Wish {
        functions: true,
        ..Wish::default()
    });
    let planned: Vec<Planned<'_>> = picked.iter().map(|m| Planned::new(m, &mut jobs)).collect();
    let checked = jobs.run(&settings, &console.progress(jobs.len(), "synthesizing"))?;
    let mut findings = loaded.findings.clone();
    findings.extend(machines::findings_where_needed(&planned, &jobs, &checked));

    // A missing compiler is said once, not once a machine.
    let mut toolchains = Vec::new();
    let mut units = None;
    for target in &arguments.target {
        if *target == Target::Fmu {
            let (found, missing) = fmi::toolchains();
            findings.extend(missing);
            units = Some(found);
            continue;
        }
        match target.toolchain() {
            Ok(toolchain) => toolchains.push((target, toolchain)),
            Err(finding) => findings.push(*finding),
        }
    }
    let default = default_folder(&arguments.selection.path);
    let folder = arguments.out.as_deref().unwrap_or(&default);
    let mut libraries = Vec::new();
    for plan in planned.iter().filter_map(|p| p.controlled(&checked)) {
        let misfits = libraries::compose(&plan).findings;
        let fits = !has_errors(&misfits);
        findings.extend(misfits);
        if !fits {
            continue;
        }
        for (target, toolchain) in &toolchains {
            match libraries::build(&plan, toolchain.as_ref(), folder, arguments.rebuild) {
                Ok(files) => libraries.push(Built {
                    machine: plan.machine.name.clone(),
                    target: target.name(),
                    files: files.iter().map(|f| f.display().to_string()).collect(),
                }),
                Err(finding) => findings.push(*finding),
            }
        }
        if let Some(toolchains) = &units {
            match libraries::build_units(&plan, toolchains, folder) {
                Ok((files, missing)) => {
                    for finding in missing {
                        if !findings.contains(&finding) {
                            findings.push(finding);
                        }
                    }
                    libraries.push(Built {
                        machine: plan.machine.name.clone(),
                        target: Target::Fmu.name(),
                        files: files.iter().map(|f| f.display().to_string()).collect(),
                    });
                }
                Err(finding) => findings.push(*finding),
            }
        }
    }
    let sources = &library.sources;
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("build"),
            libraries,
            findings: json::findings(sources, &findings),
        })?,
        Format::Sarif => console.failed("build", sources, &findings)?,
        Format::Human | Format::Short => {
            console.findings(sources, &findings)?;
            let mut text = String::new();
            for file in libraries.iter().flat_map(|l| &l.files) {
                let _ = writeln!(text, "{file}");
            }
            console.result(&text)?;
        }
    }
    debug_assert!(
        has_errors(&findings) || planned.iter().all(|p| p.controlled(&checked).is_some())
    );
    Ok(options.exit_code(&findings))
}

/// `.linewright` beside a file; in the current folder for the bundled library.
pub fn default_folder(path: &str) -> PathBuf {
    let place = Path::new(path);
    let beside = if place.is_dir() {
        place
    } else {
        place.parent().unwrap_or(Path::new(""))
    };
    beside.join(".linewright")
}
