//! Writes station libraries, probe libraries and FMUs of machines with their controllers.

use super::output;
use crate::controlled::ControlledMachine;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_station::profile::Profile;
use linewright_station::simtalk::LibraryForm;
use linewright_station::{self as station, Package, Toolchain, fmi, probe, simtalk};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Result of writing a library.
#[derive(Debug, Default)]
pub struct BuildOutput {
    /// Paths of the files that a user needs.
    pub files: Vec<PathBuf>,
    /// Findings about files that were kept and binaries that are missing.
    pub findings: Vec<Diagnostic>,
}

/// Writes a machine's station library, or its sources if there is no toolchain, into a folder. For
/// Windows targets it adds the C source and the texts for Plant Simulation.
pub fn build(
    controlled: &ControlledMachine<'_>,
    profile: &Profile,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<BuildOutput, Box<Diagnostic>> {
    let package = package(controlled, profile);
    let (files, library) = compile(&package, toolchain, folder, rebuild)?;
    let mut written = BuildOutput {
        files,
        ..BuildOutput::default()
    };
    let source = format!("{}-source", simtalk::stem(&library));
    let form = match toolchain {
        None => LibraryForm::Source { library: &library },
        Some(toolchain) if toolchain.is_for_windows() => {
            let main = package
                .write_source(&folder.join(&source))
                .map_err(|e| Box::new(e.to_diagnostic()))?;
            written.files.push(main);
            LibraryForm::Library {
                library: &library,
                source: &source,
            }
        }
        Some(_) => return Ok(written),
    };
    let texts = simtalk::texts(controlled.machine, &package, profile, form);
    written.write_methods(folder, &library, &texts.methods)?;
    let page = folder.join(simtalk::page_name(&library));
    output::write(&page, &texts.page, &BTreeSet::new())?;
    written.files.push(page);
    Ok(written)
}

impl BuildOutput {
    /// Writes the SimTalk methods that call a library. Users enter paths and stations in this file,
    /// so an existing file is kept, with a warning if its content differs.
    fn write_methods(
        &mut self,
        folder: &Path,
        library: &str,
        text: &str,
    ) -> Result<(), Box<Diagnostic>> {
        let path = folder.join(simtalk::methods_name(library));
        match output::keep(
            &path,
            text,
            "move it away or delete it to have it written again",
        ) {
            Err(mut kept) if kept.code == codes::FILE_KEPT => {
                kept.severity = Severity::Warning;
                kept.message.push_str("; it is kept");
                self.findings.push(*kept);
            }
            written => written?,
        }
        self.files.push(path);
        Ok(())
    }
}

/// Writes the probe's library, or its sources, and the SimTalk methods that call it. With a
/// profile, writes the probe for the second round.
pub fn build_probe(
    profile: Option<&Profile>,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<BuildOutput, Box<Diagnostic>> {
    let package = probe::package::package(profile);
    let (files, library) = compile(&package, toolchain, folder, rebuild)?;
    let mut written = BuildOutput {
        files,
        ..BuildOutput::default()
    };
    let text = probe::package::simtalk(profile, &library);
    written.write_methods(folder, &library, &text)?;
    Ok(written)
}

/// Builds a package, or writes its sources if there is no toolchain. Returns the files and the
/// library's file name; for sources, the name that the library is to get.
fn compile(
    package: &Package,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<(Vec<PathBuf>, String), Box<Diagnostic>> {
    let explain = |e: station::Error| Box::new(e.to_diagnostic());
    if let Some(toolchain) = toolchain {
        let built = toolchain.build(package, folder, rebuild).map_err(explain)?;
        built.verify().map_err(explain)?;
        let name = built
            .path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        return Ok((vec![built.path], name));
    }
    package.write_source(folder).map_err(explain)?;
    let files = package
        .files()
        .iter()
        .map(|(name, _)| folder.join(name))
        .collect();
    Ok((files, format!("{}.dll", package.stem)))
}

/// Writes a machine's FMUs into a folder.
pub fn build_fmus(
    controlled: &ControlledMachine<'_>,
    toolchains: &[Toolchain],
    folder: &Path,
) -> Result<BuildOutput, Box<Diagnostic>> {
    let controllers = controlled.clone_controllers();
    let (files, findings) = fmi::build(controlled.machine, &controllers, toolchains, folder)
        .map_err(|e| Box::new(e.to_diagnostic()))?;
    Ok(BuildOutput { files, findings })
}

/// Generates the C sources of a machine.
pub fn package(controlled: &ControlledMachine<'_>, profile: &Profile) -> Package {
    Package::emit_with(controlled.machine, &controlled.clone_controllers(), profile)
}
