//! Machines with their controllers: whether they fit together, and their station libraries.

use crate::contract::machine::Machine;
use crate::diagnostics::Diagnostic;
use crate::mealy;
use crate::station::composition::{self, Composition};
use crate::station::{self, Package, Toolchain, fmi};
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
    toolchain: Option<&Toolchain>,
    folder: &Path,
    rebuild: bool,
) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
    let package = package(controlled);
    let explain = |e: station::Error| Box::new(e.to_diagnostic());
    if let Some(toolchain) = toolchain {
        let built = toolchain
            .build(&package, folder, rebuild)
            .map_err(explain)?;
        return Ok(vec![built.path]);
    }
    package.write_source(folder).map_err(explain)?;
    let files = package.files();
    Ok(files.iter().map(|(name, _)| folder.join(name)).collect())
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
pub fn package(controlled: &Controlled<'_>) -> Package {
    Package::emit(controlled.machine, &controllers(controlled))
}

fn controllers(controlled: &Controlled<'_>) -> Vec<mealy::Controller> {
    controlled
        .controllers
        .iter()
        .map(|c| (*c).clone())
        .collect()
}
