//! `linewright doctor --probe`: infers the layout of `UF_Value` from a dump, with the confidence in
//! each fact, and writes the profile.

use super::super::console::schema;
use super::super::exit::ExitCode;
use super::super::options::{Format, GlobalOptions};
use super::super::profiles;
use crate::diagnostics::{Diagnostic, has_errors, json};
use crate::engine::output;
use crate::source::SourceMap;
use crate::station::probe::dump::{self, Dump};
use crate::station::probe::infer::{self, Confidence, Fact};
use crate::station::profile::{Profile, ProfileEntry};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// Help text if the profile file already exists.
const FILE_EXISTS_HELP: &str = "name another file with --out, or move the existing one first";

/// Maximum size of a dump in bytes.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// The JSON document of `doctor --probe`.
#[derive(JsonSchema, Serialize)]
pub(super) struct Document {
    schema: String,
    /// The evaluation of the dump; null if it failed.
    probe: Option<ProbeReport>,
    /// All findings.
    findings: Vec<json::Finding>,
}

/// The evaluation of a dump.
#[derive(JsonSchema, Serialize)]
struct ProbeReport {
    /// The platform on which the probe ran.
    platform: String,
    /// The number of calls in the dump.
    calls: usize,
    /// The profile that was found.
    profile: ProfileEntry,
    /// The facts about the layout, with the confidence in each.
    facts: Vec<Fact>,
    /// The file to which the profile was written; null if it was not written.
    written: Option<String>,
}

/// Reads a dump, and writes the profile to `out` if given.
pub fn run(path: &Path, out: Option<&Path>, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let mut sources = SourceMap::new();
    let mut findings = Vec::new();
    let mut found = None;
    match profiles::text(path, MAX_FILE_BYTES) {
        Err(finding) => findings.push(*finding),
        Ok(text) => {
            let file = sources.add(path.display().to_string(), text.as_str());
            let (dump, damages) = dump::parse(file, &text);
            findings.extend(damages);
            if !has_errors(&findings) {
                match evaluate(&dump, out) {
                    Ok((profile, facts)) => found = Some((dump, profile, facts)),
                    Err(wrong) => findings.extend(wrong),
                }
            }
        }
    }
    let mut written = None;
    if let Some((_, profile, _)) = &found {
        findings.extend(profiles::note_if_unverified(profile).map(|note| {
            note.with_help("confirm it: build the probe of the second round with `linewright build --probe --profile FILE --target windows`, and pass its dump to `doctor --probe`")
        }));
        if let Some(out) = out {
            match output::keep(out, &profile.to_toml(), FILE_EXISTS_HELP) {
                Ok(()) => written = Some(out.display().to_string()),
                Err(finding) => findings.push(*finding),
            }
        }
    }
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("doctor"),
            probe: found.map(|(dump, profile, facts)| ProbeReport {
                platform: dump.platform,
                calls: dump.calls.len(),
                profile: profile.describe(),
                facts,
                written,
            }),
            findings: json::findings(&sources, &findings),
        })?,
        Format::Sarif => console.failed("doctor", &sources, &findings)?,
        Format::Human | Format::Short => {
            if let Some((dump, profile, facts)) = &found {
                console.result(&report(dump, profile, facts, out.is_none()))?;
            }
            console.findings(&sources, &findings)?;
            if let Some(written) = written {
                console.remark(&format!("wrote {written}\n"))?;
                if found.is_some_and(|(_, profile, _)| profile.is_verified()) {
                    console.remark(&format!(
                        "now build with it: linewright build FILE --target windows --profile {written}\n"
                    ))?;
                }
            }
        }
    }
    Ok(options.exit_code(&findings))
}

/// Returns the profile inferred from a dump, with the facts about its layout. In the second round,
/// returns the profile with which the probe was built, if the dump confirms it.
fn evaluate(dump: &Dump, out: Option<&Path>) -> Result<(Profile, Vec<Fact>), Vec<Diagnostic>> {
    match infer::confirm(dump) {
        Some(Ok(profile)) => {
            let fact = Fact {
                what: "round trip",
                found: "unchanged".to_owned(),
                sure: Confidence::Certain,
                why: "an integer, a real number and a string came back unchanged".to_owned(),
            };
            Ok((profile, vec![fact]))
        }
        Some(Err(findings)) => Err(findings),
        None => {
            let inference = infer::infer(dump).map_err(|f| vec![*f])?;
            let name = out
                .and_then(Path::file_stem)
                .map(|s| s.to_string_lossy().chars().take(60).collect::<String>())
                .filter(|s| {
                    // Whether the profile is verified must only follow from its state, not from its
                    // name.
                    let is_misleading = s.to_lowercase().contains("verified");
                    !s.trim().is_empty() && !s.chars().any(char::is_control) && !is_misleading
                })
                .unwrap_or_else(|| "probed".to_owned());
            let profile = Profile {
                name,
                found: format!(
                    "read from {} calls of the probe ({})",
                    dump.calls.len(),
                    dump.platform
                ),
                confirmed: None,
                layout: inference.layout,
            };
            Ok((profile, inference.facts))
        }
    }
}

/// Formats the evaluation as text; with `with_profile`, also the text of the profile file.
fn report(dump: &Dump, profile: &Profile, facts: &[Fact], with_profile: bool) -> String {
    let mut out = format!(
        "The layout of UF_Value from {} calls ({}): {}\n\n",
        dump.calls.len(),
        dump.platform,
        profile.label()
    );
    for fact in facts {
        let sure = match fact.sure {
            Confidence::Certain => "certain",
            Confidence::Likely => "likely",
            Confidence::Open => "open",
        };
        let _ = writeln!(
            out,
            "  {:10} {sure:8} {}: {}",
            fact.what, fact.found, fact.why
        );
    }
    out.push('\n');
    if with_profile {
        out.push_str(&profile.to_toml());
        out.push('\n');
    }
    out
}
