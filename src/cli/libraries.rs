//! Machines with their controllers: whether they fit together, and their station libraries.

use super::output;
use crate::contract::machine::Machine;
use crate::diagnostics::Diagnostic;
use crate::mealy;
use crate::station::composition::{self, Composition};
use crate::station::profile::Profile;
use crate::station::{self, Package, Toolchain, fmi, probe, simtalk};
use std::path::{Path, PathBuf};

/// A machine with the verified controllers of its components, in their order.
#[derive(Debug)]
pub struct Controlled<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// One controller a component.
    pub controllers: Vec<&'a mealy::Controller>,
}

/// Whether a machine's coordinator and actions fit together.
pub fn compose(controlled: &Controlled<'_>) -> Composition {
    composition::check(controlled.machine, &controlled.controllers)
}

/// What `build` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// A shared library for this computer
    Linux,
    /// A 64-bit DLL, with MinGW or Zig
    Windows,
    /// A 64-bit DLL, with Microsoft's compiler; on Windows only
    Msvc,
    /// Co-simulation units of FMI 2.0 and 3.0, with the binaries that there are compilers for
    Fmu,
    /// The C sources, with all headers they need
    Source,
}

impl Target {
    /// As it is written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linux => "linux",
            Self::Windows => "windows",
            Self::Msvc => "msvc",
            Self::Fmu => "fmu",
            Self::Source => "source",
        }
    }

    /// Whether Plant Simulation can load what is built.
    pub fn is_windows(self) -> bool {
        matches!(self, Self::Windows | Self::Msvc)
    }

    /// The compiler for it; none for the sources. Units have several, and take what there is: see [`fmi::toolchains`].
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

/// Writes a machine's station library, or its sources where there is no toolchain, into a folder, and gives the files that a user
/// needs.
pub fn build(
    controlled: &Controlled<'_>,
    profile: &Profile,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
    let package = package(controlled, profile);
    let (mut files, library) = compile(&package, toolchain, folder, rebuild)?;
    let texts = simtalk::texts(controlled.machine, &package, profile, &library);
    let named = [
        (simtalk::methods_name(&library), &texts.methods),
        (simtalk::page_name(&library), &texts.page),
    ];
    for (name, text) in named {
        let path = folder.join(name);
        output::write(&path, text)?;
        files.push(path);
    }
    Ok(files)
}

/// Writes the probe's library, or its sources, and the SimTalk that calls it. With a profile it is the second round.
pub fn build_probe(
    profile: Option<&Profile>,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
    let package = probe::package::package(profile);
    let (mut files, library) = compile(&package, toolchain, folder, rebuild)?;
    let path = folder.join(simtalk::methods_name(&library));
    output::write(&path, &probe::package::simtalk(profile, &library))?;
    files.push(path);
    Ok(files)
}

/// The files of a package, and the library's file name: for the sources, what it would be called.
fn compile(
    package: &Package,
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<(Vec<PathBuf>, String), Box<Diagnostic>> {
    let explain = |e: station::Error| Box::new(e.to_diagnostic());
    if let Some(toolchain) = toolchain {
        let built = toolchain.build(package, folder, rebuild).map_err(explain)?;
        let name = built.path.file_name().unwrap_or_default();
        let name = name.to_string_lossy().into_owned();
        return Ok((vec![built.path], name));
    }
    package.write_source(folder).map_err(explain)?;
    let files = package.files();
    let files = files.iter().map(|(name, _)| folder.join(name)).collect();
    Ok((files, format!("{}.dll", package.stem)))
}

/// Writes a machine's FMI units into a folder, and gives their paths and what they lack.
pub fn build_units(
    controlled: &Controlled<'_>,
    toolchains: &[Toolchain],
    folder: &Path,
) -> Result<(Vec<PathBuf>, Vec<Diagnostic>), Box<Diagnostic>> {
    let controllers = controllers(controlled);
    fmi::build(controlled.machine, &controllers, toolchains, folder)
        .map_err(|e| Box::new(e.to_diagnostic()))
}

/// The C of a machine.
pub fn package(controlled: &Controlled<'_>, profile: &Profile) -> Package {
    Package::emit_with(controlled.machine, &controllers(controlled), profile)
}

fn controllers(controlled: &Controlled<'_>) -> Vec<mealy::Controller> {
    let controllers = controlled.controllers.iter();
    controllers.map(|c| (*c).clone()).collect()
}
