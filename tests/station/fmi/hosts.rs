//! The units of the laboratory's machines, built once, and the hosts that step them.

use super::tape::{self, Tape};
use crate::laboratory::{Controlled, machines, of_lines};
use crate::support::programs;
use linewright::contract::machine::Machine;
use linewright::mealy;
use linewright::station::fmi::{self, Unit, Version};
use linewright::station::{Package, Toolchain};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// A unit in its archive.
pub struct Built {
    pub machine: Arc<Machine>,
    pub controllers: Arc<Vec<mealy::Controller>>,
    pub unit: Unit,
    pub archive: PathBuf,
}

/// Communication step in seconds. A machine whose steps take no time makes one a second.
pub fn communication_step(machine: &Machine) -> f64 {
    Some(machine.step_seconds)
        .filter(|step| *step > 0.0)
        .unwrap_or(1.0)
}

/// Every machine of the laboratory and one whose steps take no time, in both versions, and the
/// folder they are in.
pub fn laboratory() -> &'static [Built] {
    static BUILT: OnceLock<(tempfile::TempDir, Vec<Built>)> = OnceLock::new();
    let (_, built) = BUILT.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let (toolchains, _) = fmi::toolchains();
        let instant = of_lines(&["tests/station/fmi/instant.lw"]);
        let built = machines()
            .iter()
            .chain(&instant)
            .flat_map(|c| build(c, &toolchains, folder.path()))
            .collect();
        (folder, built)
    });
    built
}

fn build(controlled: &Controlled, toolchains: &[Toolchain], folder: &Path) -> Vec<Built> {
    let Controlled {
        machine,
        controllers,
    } = controlled;
    let (files, missing) =
        fmi::build(machine, controllers, toolchains, folder).expect("the units are built");
    assert!(missing.is_empty(), "{missing:?}");
    let units = Version::ALL.map(|v| Unit::emit(machine, controllers, v));
    files
        .into_iter()
        .zip(units)
        .map(|(archive, unit)| Built {
            machine: Arc::clone(machine),
            controllers: Arc::clone(controllers),
            unit,
            archive,
        })
        .collect()
}

/// A file of an archive; `None` where there is none of that name.
pub fn file_of(archive: &Path, name: &str) -> Option<Vec<u8>> {
    let file = std::fs::File::open(archive).expect("an archive");
    let mut archive = zip::ZipArchive::new(file).expect("an archive");
    let mut bytes = Vec::new();
    archive
        .by_name(name)
        .ok()?
        .read_to_end(&mut bytes)
        .expect("a file in the archive");
    Some(bytes)
}

/// Path of the binary for a system in an archive.
pub fn binary_name(unit: &Unit, windows: bool) -> String {
    let folder = match (unit.version, windows) {
        (Version::Two, false) => "linux64",
        (Version::Two, true) => "win64",
        (Version::Three, false) => "x86_64-linux",
        (Version::Three, true) => "x86_64-windows",
    };
    let ending = if windows { "dll" } else { "so" };
    format!("binaries/{folder}/{}.{ending}", unit.package.stem)
}

/// Puts the binary of an archive into a folder.
pub fn unpack(built: &Built, windows: bool, folder: &Path) -> PathBuf {
    let bytes = file_of(&built.archive, &binary_name(&built.unit, windows)).expect("a binary");
    let ending = if windows { "dll" } else { "so" };
    let path = folder.join(format!(
        "{}{:?}.{ending}",
        built.unit.package.stem, built.unit.version
    ));
    std::fs::write(&path, bytes).expect("a file");
    path
}

/// The C host for a version, compiled by this compiler.
pub fn host(mut compiler: Command, version: Version, folder: &Path) -> PathBuf {
    let number = match version {
        Version::Two => 2,
        Version::Three => 3,
    };
    let path = folder.join(format!("host{number}.exe"));
    let source = crate::support::root().join("tests/station/fmi/host.c");
    let windows = compiler.get_program() != "cc";
    let output = compiler
        .args([
            "-std=gnu99",
            "-O1",
            "-Wall",
            "-Wextra",
            "-Wno-unused-function",
        ])
        .arg(format!("-DFMI={number}"))
        .arg(source)
        .arg("-o")
        .arg(&path)
        .arg("-lm")
        .arg(if windows {
            "-D__USE_MINGW_ANSI_STDIO=1"
        } else {
            "-ldl"
        })
        .output()
        .expect("the compiler starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    path
}

/// Maximum time of a host on a busy computer.
pub const PATIENCE: Duration = Duration::from_mins(5);

/// Output of a program.
pub fn run(command: &mut Command) -> String {
    let finished = programs::run(command, PATIENCE);
    print!("{}", finished.errors);
    finished.output
}

/// Writes a tape to a file.
pub fn write(tape: &Tape, folder: &Path) -> PathBuf {
    let path = folder.join("tape");
    std::fs::write(&path, &tape.text).expect("a file");
    path
}

/// The arguments of the C host: to play a tape, or to check the calls.
pub fn arguments(built: &Built, library: String, tape: Option<String>) -> Vec<String> {
    let what = if tape.is_some() { "play" } else { "check" };
    let step = format!("{:?}", communication_step(&built.machine));
    let mut arguments = vec![what.to_owned(), library, built.unit.token.clone(), step];
    arguments.extend(tape);
    arguments
}

/// Output of the C host on this computer.
pub fn run_here(host: &Path, built: &Built, library: &Path, tape: Option<&Path>) -> String {
    let tape = tape.map(|t| t.display().to_string());
    let arguments = arguments(built, library.display().to_string(), tape);
    run(Command::new(host).args(arguments))
}

/// A tape of a unit, with probabilities for all possible events.
pub fn record(built: &Built, sequences: usize, steps: usize, seed: u64) -> Tape {
    tape::record(
        &built.machine,
        &built.controllers,
        &built.unit,
        sequences,
        steps,
        seed,
    )
}

/// The library of a unit whose C was changed.
pub fn build_package(package: &Package, folder: &Path) -> PathBuf {
    Toolchain::shipping()
        .build(package, folder, true)
        .expect("the library is built")
        .path
}
