//! `linewright doctor`: reports the compilers and tools of this computer, or evaluates the dump of
//! a probe.
//!
//! Exit code 0 if there is a C compiler for this computer, which `build` and `run` need; 2 if there
//! is none. A missing compiler for Windows is only a warning, with a remedy.

mod probe;

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::profiles;
use crate::cli::console::Failed;
use crate::cli::schema::{Described, form};
use crate::diagnostics::{Diagnostic, codes, has_errors, json};
use crate::engine::cache::Cache;
use crate::source::SourceMap;
use crate::station::profile::{Profile, ProfileEntry};
use crate::station::toolchain::survey::{self, FoundProgram, Survey};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// The arguments of `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright doctor
    linewright doctor --format json

To infer the layout of UF_Value from the dump of a probe (`build --probe`):

    $ linewright doctor --probe linewright_probe.dll.dump.txt --out plant-simulation.toml

Exit codes without --probe: 0 if a C compiler works; 2 if none does. With --probe: 0 if the layout was \
found or confirmed; 1 if the dump does not determine the layout, or contradicts the profile; 2 if the \
dump cannot be read.")]
pub struct Arguments {
    /// Infer the layout of UF_Value from this dump of the probe
    #[arg(long, value_name = "FILE")]
    pub probe: Option<PathBuf>,
    /// Write the profile to this file; an existing file with a different profile is not overwritten
    #[arg(long, value_name = "FILE", requires = "probe")]
    pub out: Option<PathBuf>,
    /// Show this profile of UF_Value instead of the built-in one
    #[arg(long, value_name = "FILE", conflicts_with = "probe")]
    pub profile: Option<PathBuf>,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "doctor",
    "Available compilers and tools, or the layout that a probe found",
    &[
        form::<Document<'_>>,
        form::<probe::Document>,
        form::<Failed>,
    ],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document<'a> {
    schema: String,
    /// The C compiler for this computer.
    c_compiler: Option<&'a FoundProgram>,
    /// The compilers for 64-bit Windows, in order of preference.
    windows_compilers: Vec<Entry<'a>>,
    /// Whether libraries for Windows can be built.
    windows: bool,
    /// Wine, which runs Windows programs.
    wine: Option<&'a FoundProgram>,
    /// Python 3.
    python: Option<&'a FoundProgram>,
    /// Those Python packages that the tests use and that are installed.
    python_packages: &'a [&'static str],
    /// The profile of `UF_Value`; null if it cannot be read.
    profile: Option<ProfileEntry>,
    /// The folder of the cache; null if there is none.
    cache: Option<String>,
    /// Where `build` and `run` put libraries.
    libraries: &'static str,
    /// All findings.
    findings: Vec<json::Finding>,
}

/// A compiler that was searched for.
#[derive(JsonSchema, Serialize)]
struct Entry<'a> {
    /// The kind of compiler.
    name: &'static str,
    /// The program found; null if it is not installed.
    found: Option<&'a FoundProgram>,
}

/// Folder where `build` and `run` put libraries.
const LIBRARIES: &str = ".linewright next to the file that is built, or --out";

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if let Some(dump) = &arguments.probe {
        return probe::run(dump, arguments.out.as_deref(), options);
    }
    let console = options.console();
    let mut sources = SourceMap::new();
    let mut findings = Vec::new();
    let profile = match profiles::load(arguments.profile.as_deref(), &mut sources) {
        Ok(profile) => {
            findings.extend(profiles::note_if_unverified(&profile));
            Some(profile)
        }
        Err(found) => {
            findings.extend(found);
            None
        }
    };
    let survey = survey::survey();
    if let Err(error) = &survey.host {
        findings.push(error.to_diagnostic());
    }
    findings.extend(no_windows(&survey));
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("doctor"),
            c_compiler: survey.host.as_ref().ok(),
            windows_compilers: survey
                .cross
                .iter()
                .map(|(kind, found)| Entry {
                    name: kind.name(),
                    found: found.as_ref(),
                })
                .collect(),
            windows: survey.windows().is_some_and(|(_, f)| f.fault.is_none()),
            wine: survey.wine.as_ref(),
            python: survey.python.as_ref(),
            python_packages: &survey.packages,
            profile: profile.as_ref().map(Profile::describe),
            cache: cache_folder(),
            libraries: LIBRARIES,
            findings: json::findings(&sources, &findings),
        })?,
        Format::Sarif => console.failed("doctor", &sources, &findings)?,
        Format::Human | Format::Short => {
            console.result(&table(&survey, profile.as_ref()))?;
            console.findings(&sources, &findings)?;
        }
    }
    debug_assert!(has_errors(&findings) || profile.is_some());
    Ok(options.exit_code(&findings))
}

/// Finding if no compiler for Windows is found, or the preferred one cannot compile anything.
fn no_windows(survey: &Survey) -> Option<Diagnostic> {
    let (why, help) = match survey.windows() {
        None => {
            let error = crate::station::Error::CrossCompilerMissing.to_diagnostic();
            let why = "no C compiler for 64-bit Windows was found".to_owned();
            (why, error.help.unwrap_or_default())
        }
        Some((kind, found)) => {
            let why = format!(
                "{} was found, but it does not compile: {}",
                kind.name(),
                found.fault.as_ref()?
            );
            let help = "repair or remove it; compilers are tried in the order of the list above"
                .to_owned();
            (why, help)
        }
    };
    let message = format!("Windows libraries cannot be built here: {why}");
    Some(Diagnostic::warning(codes::CROSS_COMPILER_MISSING, None, message).with_help(help))
}

fn cache_folder() -> Option<String> {
    Cache::of_user().map(|c| c.folder().display().to_string())
}

fn table(survey: &Survey, profile: Option<&Profile>) -> String {
    let mut out = String::new();
    let mut row = |what: &str, said: &str| {
        let _ = writeln!(out, "  {what:24} {said}");
    };
    let show = |found: &FoundProgram| {
        let fault = if found.fault.is_some() {
            ", which does not compile"
        } else {
            ""
        };
        match &found.version {
            Some(version) => format!("{version} ({}){fault}", found.command),
            None => format!("{}{fault}", found.command),
        }
    };
    match &survey.host {
        Ok(found) => row("C compiler", &show(found)),
        Err(_) => row("C compiler", "not found, or does not work"),
    }
    for (kind, found) in &survey.cross {
        // An unusual compiler is only listed if it was found.
        match found {
            Some(found) => row(kind.name(), &show(found)),
            None if kind.is_searched_by_default() => row(kind.name(), "not found"),
            None => {}
        }
    }
    row(
        "Windows libraries",
        &match survey.windows() {
            Some((kind, found)) if found.fault.is_none() => format!("with {}", kind.name()),
            _ => "cannot be built here".to_owned(),
        },
    );
    match &survey.wine {
        Some(found) => row("Wine", &show(found)),
        None => row("Wine", "not found (only needed by tests)"),
    }
    match &survey.python {
        Some(found) => {
            row("Python", &show(found));
            let packages = if survey.packages.is_empty() {
                "none of fmpy, blark, ziglang".to_owned()
            } else {
                survey.packages.join(", ")
            };
            row("Python packages", &packages);
        }
        None => row("Python", "not found (only needed by tests)"),
    }
    if let Some(profile) = profile {
        row(
            "UF_Value",
            &format!("{}: {}", profile.label(), profile.found),
        );
    }
    row(
        "cache",
        &cache_folder().unwrap_or_else(|| "none; every contract is solved again".to_owned()),
    );
    row("libraries", LIBRARIES);
    out.push('\n');
    out
}
