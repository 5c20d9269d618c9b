//! Packs a machine as an FMI co-simulation unit for other simulators, in versions 2.0 and 3.0 of
//! the standard.
//!
//! A unit is an archive: the description of its variables (`description`), a page for users
//! (`documentation`), the C sources, and a binary for each platform with a compiler. The C source
//! is that of the station library, with `ffi/fmi2.c` or `ffi/fmi3.c` instead of the adapter for
//! Plant Simulation; `ffi/fmi.c` defines a communication step. An archive does not depend on the
//! time or path of the build: the same contract and compiler give the same bytes.
//!
//! Each version of the standard has its own archive. A unit of FMI 3 could also contain a unit of
//! FMI 2, but many current importers support only one of the versions, and choose by what the
//! archive mentions first.

mod archive;
mod description;
mod documentation;
mod tables;
mod units;
pub mod variables;

use super::interpret::Interpreter;
use super::package::file_stem;
use super::profile::Profile;
use super::toolchain::{Platform, WorkFolder};
use super::{Controller as _, Error, Package, Toolchain, emit};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::machine::{Machine, PlantSource};
use linewright_solver::mealy;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use variables::Interface;

/// A version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Version {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// Both versions.
    pub const ALL: [Self; 2] = [Self::Two, Self::Three];

    /// Adapter included at the end of the C file.
    fn adapter(self) -> &'static str {
        match self {
            Self::Two => "fmi2.c",
            Self::Three => "fmi3.c",
        }
    }

    /// Files of `ffi/` that the C file includes.
    fn support(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Two => &SUPPORT_TWO,
            Self::Three => &SUPPORT_THREE,
        }
    }

    /// Folder of a platform's binary within the archive.
    fn binaries(self, platform: Platform) -> &'static str {
        let (system, processor) = match platform {
            Platform::Windows | Platform::Msvc => ("windows", "x86_64"),
            Platform::Host => (std::env::consts::OS, std::env::consts::ARCH),
        };
        match (self, system, processor) {
            (Self::Two, "windows", _) => "win64",
            (Self::Two, "macos", _) => "darwin64",
            (Self::Two, _, _) => "linux64",
            (Self::Three, "windows", _) => "x86_64-windows",
            (Self::Three, "macos", "aarch64") => "aarch64-darwin",
            (Self::Three, "macos", _) => "x86_64-darwin",
            (Self::Three, _, "aarch64") => "aarch64-linux",
            (Self::Three, _, _) => "x86_64-linux",
        }
    }
}

const SUPPORT_TWO: [(&str, &str); 7] = [
    ("station.h", include_str!("../../../../ffi/station.h")),
    ("machine.h", include_str!("../../../../ffi/machine.h")),
    ("step.c", include_str!("../../../../ffi/step.c")),
    ("runtime.c", include_str!("../../../../ffi/runtime.c")),
    ("fmi.h", include_str!("../../../../ffi/fmi.h")),
    ("fmi.c", include_str!("../../../../ffi/fmi.c")),
    ("fmi2.c", include_str!("../../../../ffi/fmi2.c")),
];

const SUPPORT_THREE: [(&str, &str); 7] = {
    let mut support = SUPPORT_TWO;
    support[6] = ("fmi3.c", include_str!("../../../../ffi/fmi3.c"));
    support
};

/// A unit before it is compiled.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Version of the standard.
    pub version: Version,
    /// Variables of the unit.
    pub interface: Interface,
    /// Token that ties the description to the binary: the `guid` of FMI 2, the `instantiationToken`
    /// of FMI 3.
    pub token: String,
    /// C files of the unit.
    pub package: Package,
    name: String,
    doc: String,
    step_seconds: f64,
}

impl Unit {
    /// Emits a machine with the controller of each of its components, in order.
    ///
    /// # Panics
    /// Panics if a controller does not fit its component's contract.
    pub fn emit(machine: &Machine, controllers: &[mealy::Controller], version: Version) -> Self {
        let emitted = emit::emit(machine, controllers, &Profile::assumed());
        let first = first_operation(machine, controllers);
        let tables = tables::tables(machine, first);
        let mut hash = Sha256::new();
        for text in [&emitted.unit, &tables, version.adapter()] {
            hash.update(text);
        }
        let token = token(&emit::hex(&hash.finalize()));
        let support = version
            .support()
            .iter()
            .map(|(name, text)| (*name, (*text).to_owned()));
        let source = tables::source(machine, &emitted.unit, &tables, &token, version);
        let stem = file_stem(&machine.name);
        let mut package = Package::of_files(&machine.name, &stem, source, support.collect());
        package.contract_hash = emitted.contract_hash;
        Self {
            version,
            interface: Interface::of(machine, first),
            package,
            token,
            name: machine.name.clone(),
            doc: machine.doc.clone(),
            step_seconds: step_seconds(machine),
        }
    }

    /// File name of the unit's archive: `assembly_cell_fmi2.fmu`.
    pub fn file_name(&self) -> String {
        let version = match self.version {
            Version::Two => 2,
            Version::Three => 3,
        };
        format!("{}_fmi{version}.fmu", self.package.stem)
    }

    /// Builds the unit's archive with these binaries and returns its bytes.
    pub fn archive(&self, binaries: &[(Platform, Vec<u8>)]) -> Vec<u8> {
        archive::archive(self, binaries)
    }
}

/// Communication step in seconds: the machine's step, or one second if the machine's steps take no
/// time.
fn step_seconds(machine: &Machine) -> f64 {
    if machine.step_seconds > 0.0 {
        machine.step_seconds
    } else {
        1.0
    }
}

/// Index of the operation that runs if the host sets none: the first operation that can be repeated
/// with the start values of all other inputs, so that a unit can be simulated directly after
/// import. For example, an operation that grips a part cannot be repeated. If no operation can be
/// repeated, the first operation is used.
fn first_operation(machine: &Machine, controllers: &[mealy::Controller]) -> usize {
    const TIMES: usize = 3;
    let mut still = machine.clone();
    for input in &mut still.plant {
        if let PlantSource::Signal { script } = &mut input.source {
            script.truncate(1);
        }
    }
    let fresh = Interpreter::new(Arc::new(still), Arc::new(controllers.to_vec()));
    let values: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
    let repeats = |operation: &usize| {
        let mut trial = fresh.clone();
        (0..TIMES).all(|_| trial.simulate(*operation, &mut values.clone()).is_ok())
    };
    (0..machine.operations.len()).find(repeats).unwrap_or(0)
}

/// Formats a hash as a GUID in braces.
fn token(hash: &str) -> String {
    let parts = [(0, 8), (8, 12), (12, 16), (16, 20), (20, 32)].map(|(from, to)| &hash[from..to]);
    format!("{{{}}}", parts.join("-"))
}

/// Returns the compilers for the binaries that a unit should have, and a finding for each missing
/// compiler. A missing compiler for this computer is detected only by [`build`].
pub fn toolchains() -> (Vec<Toolchain>, Vec<Diagnostic>) {
    let mut toolchains = vec![Toolchain::shipping()];
    let mut findings = Vec::new();
    if !cfg!(windows) {
        match Toolchain::windows() {
            Ok(toolchain) => toolchains.push(toolchain),
            Err(error) => findings.push(missing("Windows", &error)),
        }
    }
    (toolchains, findings)
}

/// Creates the finding for a platform whose binary is missing.
fn missing(platform: &str, error: &Error) -> Diagnostic {
    let finding = error.to_diagnostic();
    let message = format!(
        "the FMI units have no binary for {platform}: {}",
        finding.message
    );
    let help = finding.help.unwrap_or_default();
    Diagnostic::warning(codes::UNIT_WITHOUT_BINARY, None, message).with_help(format!(
        "{help}; hosts that compile the sources in the unit can use the unit without the binary"
    ))
}

/// Builds a machine's units, one per version, in a folder, and returns their paths. For a compiler
/// that cannot be started, a finding is returned, and the units have no binary from that compiler.
pub fn build(
    machine: &Machine,
    controllers: &[mealy::Controller],
    toolchains: &[Toolchain],
    folder: &Path,
) -> Result<(Vec<PathBuf>, Vec<Diagnostic>), Error> {
    super::package::create_folder(folder)?;
    let unwritable = |cause| Error::Unwritable {
        path: folder.to_owned(),
        cause,
    };
    let work = WorkFolder::new(folder)?;
    let units = Version::ALL.map(|version| Unit::emit(machine, controllers, version));
    let tasks: Vec<(&Unit, &Toolchain)> = units
        .iter()
        .flat_map(|unit| toolchains.iter().map(move |t| (unit, t)))
        .collect();
    let compiled: Vec<Result<Vec<u8>, Error>> = tasks
        .par_iter()
        .map(|(unit, toolchain)| {
            let built = toolchain.build(&unit.package, work.path(), true)?;
            std::fs::read(&built.path).map_err(unwritable)
        })
        .collect();
    let mut findings: Vec<Diagnostic> = Vec::new();
    let mut binaries: Vec<Vec<(Platform, Vec<u8>)>> = units.iter().map(|_| Vec::new()).collect();
    for ((unit, toolchain), result) in tasks.iter().zip(compiled) {
        match result {
            Ok(bytes) => {
                let of_unit = units.iter().position(|u| u.version == unit.version);
                binaries[of_unit.unwrap_or(0)].push((toolchain.platform(), bytes));
            }
            Err(error @ Error::CompilerMissing { .. }) => {
                let platform = match toolchain.platform() {
                    Platform::Host => "this computer",
                    Platform::Windows | Platform::Msvc => "Windows",
                };
                let finding = missing(platform, &error);
                if findings.iter().all(|f| f.message != finding.message) {
                    findings.push(finding);
                }
            }
            Err(error) => return Err(error),
        }
    }
    let mut files = Vec::new();
    for (unit, binaries) in units.iter().zip(&binaries) {
        let path = folder.join(unit.file_name());
        super::package::write(&path, &unit.archive(binaries))?;
        files.push(path);
    }
    Ok((files, findings))
}
