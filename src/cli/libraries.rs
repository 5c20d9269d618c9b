//! Machines with their controllers: whether they fit together, and their station libraries.

use crate::contract::machine::Machine;
use crate::diagnostics::Diagnostic;
use crate::mealy;
use crate::station::composition::{self, Composition};
use crate::station::{self, Package, Toolchain};
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
    /// The C sources, with all headers they need
    Source,
}

/// Writes a machine's station library, or its sources, into a folder, and gives the files that a user needs.
pub fn build(
    controlled: &Controlled<'_>,
    target: Target,
    folder: &Path,
    rebuild: bool,
) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
    let package = package(controlled);
    let explain = |e: station::Error| Box::new(e.to_diagnostic());
    match target {
        Target::Linux => {
            let built = Toolchain::host()
                .build(&package, folder, rebuild)
                .map_err(explain)?;
            Ok(vec![built.path])
        }
        Target::Source => {
            package.write_source(folder).map_err(explain)?;
            let files = package.files();
            Ok(files.iter().map(|(name, _)| folder.join(name)).collect())
        }
    }
}

/// The C of a machine.
pub fn package(controlled: &Controlled<'_>) -> Package {
    let controllers: Vec<mealy::Controller> = controlled
        .controllers
        .iter()
        .map(|c| (*c).clone())
        .collect();
    Package::emit(controlled.machine, &controllers)
}
