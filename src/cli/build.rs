//! `linewright build`: builds the station libraries of machines.

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::select::Selection;
use super::{picked, profiles};
use crate::cli::console::Failed;
use crate::cli::schema::{Described, form};
use crate::contract::machine::Machine;
use crate::deadline::Deadline;
use crate::diagnostics::{Diagnostic, has_errors, json};
use crate::engine::internal;
use crate::engine::libraries::{self, BuildOutput};
use crate::engine::lines;
use crate::engine::synthesis::Synthesis;
use crate::source::SourceMap;
use crate::station::profile::Profile;
use crate::station::{Toolchain, fmi};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What `build` builds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// Shared library for this computer
    Linux,
    /// 64-bit DLL, compiled with MinGW or Zig
    Windows,
    /// 64-bit DLL, compiled with Microsoft's compiler; on Windows only
    Msvc,
    /// Co-simulation FMUs (FMI 2.0 and 3.0), with binaries for each available compiler
    Fmu,
    /// C sources and headers
    Source,
}

impl Target {
    /// Name of the target as typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linux => "linux",
            Self::Windows => "windows",
            Self::Msvc => "msvc",
            Self::Fmu => "fmu",
            Self::Source => "source",
        }
    }

    /// Whether the target is a DLL, which Plant Simulation can load.
    pub fn is_windows(self) -> bool {
        matches!(self, Self::Windows | Self::Msvc)
    }

    /// The compiler for the target; `None` for sources, and for FMUs, which are built with all
    /// available compilers: see [`fmi::toolchains`].
    pub fn toolchain(self) -> Result<Option<Toolchain>, Box<Diagnostic>> {
        let found = match self {
            Self::Linux => Ok(Some(Toolchain::shipping())),
            Self::Windows => Toolchain::windows().map(Some),
            Self::Msvc => Toolchain::msvc().map(Some),
            Self::Fmu | Self::Source => Ok(None),
        };
        found.map_err(|e| Box::new(e.to_diagnostic()))
    }
}

/// The arguments of `build`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright build examples/ice-lab/cell.lw
    linewright build examples/ice-lab/line.lw --target source --out sources
    linewright build examples/ice-lab/camera.lw::QualityCheck --target source --out station

`linux` needs a C compiler; `windows` needs the MinGW compiler (x86_64-w64-mingw32-gcc) or Zig (zig, or the Python package ziglang); `source` needs none. `fmu` uses the compilers that it finds.")]
pub struct Arguments {
    /// File, and optionally one of its machines or lines. Without a name, builds all machines of
    /// the file's lines with the parameters given there, and all other machines of the file with
    /// their default parameters
    #[arg(value_name = "FILE[::NAME]", required_unless_present = "probe")]
    pub selection: Option<Selection>,
    /// What to build (repeatable)
    #[arg(long, value_enum, default_value = "linux")]
    pub target: Vec<Target>,
    /// Output folder [default: .linewright next to the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Profile file with the memory layout of Plant Simulation's UF_Value [default: an assumed,
    /// unverified one]
    #[arg(long, value_name = "FILE")]
    pub profile: Option<PathBuf>,
    /// Build the probe that finds the layout of UF_Value, and the SimTalk that calls it; with
    /// --profile, build the probe that confirms the layout
    #[arg(long, conflicts_with = "selection")]
    pub probe: bool,
    /// Compile again even if nothing has changed
    #[arg(long)]
    pub rebuild: bool,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "build",
    "The station libraries of a build",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The libraries that were built, one for each machine and target.
    libraries: Vec<BuildResult>,
    /// All findings.
    findings: Vec<json::Finding>,
}

/// A library that was built.
#[derive(JsonSchema, Serialize)]
struct BuildResult {
    /// The name of the machine.
    machine: String,
    /// The target for which it was built.
    #[schemars(extend("enum" = ["linux", "windows", "msvc", "fmu", "source"]))]
    target: &'static str,
    /// The files that were written, or that were up to date.
    files: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let mut files = SourceMap::new();
    let profile = match profiles::load(arguments.profile.as_deref(), &mut files) {
        Ok(profile) => profile,
        Err(findings) => {
            console.failed("build", &files, &findings)?;
            return Ok(options.exit_code(&findings));
        }
    };
    let Some(selection) = &arguments.selection else {
        return build_probe(arguments, &profile, options);
    };
    let settings = options.settings();
    let loaded = match selection.load("build", options)? {
        Ok(loaded) => loaded,
        Err(code) => return Ok(code),
    };
    let library = &loaded.library;
    let chosen = picked::select_machines(selection, &loaded)?;
    let picked = picked::with_distinct_names(&chosen.machines);
    let machines = picked.iter().map(|m| &**m);
    let synthesis = Synthesis::new(machines, &settings, |count| {
        console.progress(count, "synthesizing")
    });
    let mut findings = loaded.findings.clone();
    findings.extend(chosen.notes);
    findings.extend(synthesis.findings());

    // A missing compiler is reported once, not once per machine.
    let until = settings.limits.deadline;
    let toolchains = toolchains(&arguments.target, until, &mut findings);
    // The bundled runner always uses the assumed layout; only Plant Simulation can differ from it.
    let for_windows = toolchains.iter().any(|(t, _)| t.is_windows());
    if for_windows || arguments.profile.is_some() {
        findings.extend(profiles::note_if_unverified(&profile));
    }
    let fmu_toolchains = arguments.target.contains(&Target::Fmu).then(|| {
        let (toolchains, missing) = fmi::toolchains();
        findings.extend(missing);
        let toolchains = toolchains.into_iter().map(|t| t.with_deadline(until));
        toolchains.collect::<Vec<_>>()
    });
    let default = default_folder(&selection.path);
    let folder = arguments.out.as_deref().unwrap_or(&default);
    let mut libraries = Vec::new();
    for plan in synthesis.controlled() {
        let (name, span) = (&plan.machine.name, plan.machine.span);
        let doing = || format!("building the machine `{name}`");
        let found = synthesis.judge(&plan, &settings);
        let has_errors = has_errors(&found);
        findings.extend(found);
        if has_errors {
            continue;
        }
        for (target, toolchain) in &toolchains {
            let toolchain = toolchain.as_ref();
            let built = internal::caught(doing, || {
                libraries::build(&plan, &profile, toolchain, folder, arguments.rebuild)
            });
            let built = built.unwrap_or_else(|fault| Err(Box::new(fault.finding(Some(span)))));
            record_build(
                &plan.machine.name,
                **target,
                built,
                &mut libraries,
                &mut findings,
            );
        }
        if let Some(toolchains) = &fmu_toolchains {
            let built =
                internal::caught(doing, || libraries::build_fmus(&plan, toolchains, folder));
            let built = built.unwrap_or_else(|fault| Err(Box::new(fault.finding(Some(span)))));
            record_build(
                &plan.machine.name,
                Target::Fmu,
                built,
                &mut libraries,
                &mut findings,
            );
        }
    }
    debug_assert!(has_errors(&findings) || synthesis.is_complete());
    // Errors in a line do not prevent its libraries from being built, but are reported as errors,
    // as in `check` and `run`.
    let controlled = |machine: &Machine| synthesis.of(machine);
    for line in &library.lines {
        if chosen.lines.iter().any(|l| std::ptr::eq(*l, line)) {
            lines::add_call_findings(line, controlled, &settings.limits, &mut findings);
        } else {
            // The parts of this line are not followed, so warnings about its routes could not be
            // confirmed; they do not concern this command.
            findings.retain(|f| !lines::is_route_warning(f, line));
        }
    }
    print(libraries, &library.sources, &findings, options)
}

/// The compilers of all targets except FMUs; `None` for sources. Adds a finding for each missing
/// compiler.
fn toolchains<'a>(
    targets: &'a [Target],
    until: Deadline,
    findings: &mut Vec<Diagnostic>,
) -> Vec<(&'a Target, Option<Toolchain>)> {
    let mut found = Vec::new();
    // FMUs are built separately, with several compilers.
    for target in targets.iter().filter(|t| **t != Target::Fmu) {
        match target.toolchain() {
            Ok(toolchain) => found.push((target, toolchain.map(|t| t.with_deadline(until)))),
            Err(finding) => findings.push(*finding),
        }
    }
    found
}

/// Builds the probe for every target.
fn build_probe(
    arguments: &Arguments,
    profile: &Profile,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    if arguments.target.contains(&Target::Fmu) {
        anyhow::bail!("the probe is not an FMU: build it with --target windows");
    }
    let mut findings = Vec::new();
    let profile = arguments.profile.as_ref().map(|_| profile);
    findings.extend(profile.and_then(profiles::note_if_unverified).map(|note| {
        note.with_help(
            "this probe confirms the layout: run its SimTalk method, and pass the dump to `doctor --probe`",
        )
    }));
    let folder = arguments.out.as_deref().unwrap_or(Path::new(".linewright"));
    let mut libraries = Vec::new();
    let until = options.limits().deadline;
    for (target, toolchain) in toolchains(&arguments.target, until, &mut findings) {
        let built = libraries::build_probe(profile, toolchain.as_ref(), folder, arguments.rebuild);
        record_build("probe", *target, built, &mut libraries, &mut findings);
    }
    print(libraries, &SourceMap::new(), &findings, options)
}

/// Records the files built for a machine and a target, and new findings.
fn record_build(
    machine: &str,
    target: Target,
    built: Result<BuildOutput, Box<Diagnostic>>,
    libraries: &mut Vec<BuildResult>,
    findings: &mut Vec<Diagnostic>,
) {
    let found = match built {
        Ok(written) => {
            libraries.push(BuildResult {
                machine: machine.to_owned(),
                target: target.name(),
                files: written
                    .files
                    .iter()
                    .map(|f| f.display().to_string())
                    .collect(),
            });
            written.findings
        }
        Err(finding) => vec![*finding],
    };
    for finding in found {
        if !findings.contains(&finding) {
            findings.push(finding);
        }
    }
}

/// Prints the built files and the findings.
fn print(
    libraries: Vec<BuildResult>,
    sources: &SourceMap,
    findings: &[Diagnostic],
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let console = options.console();
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("build"),
            libraries,
            findings: json::findings(sources, findings),
        })?,
        Format::Sarif => console.failed("build", sources, findings)?,
        Format::Human | Format::Short => {
            console.findings(sources, findings)?;
            let mut text = String::new();
            for file in libraries.iter().flat_map(|l| &l.files) {
                let _ = writeln!(text, "{file}");
            }
            console.result(&text)?;
        }
    }
    Ok(options.exit_code(findings))
}

/// Default output folder: `.linewright` in a folder, or in the folder of a file.
pub fn default_folder(path: &str) -> PathBuf {
    let path = Path::new(path);
    let folder = if path.is_dir() {
        path
    } else {
        path.parent().unwrap_or(Path::new(""))
    };
    folder.join(".linewright")
}
