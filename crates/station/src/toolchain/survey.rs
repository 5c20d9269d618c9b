//! Surveys this computer: the compilers, each tested with a line of C, and the programs that tests
//! use, with their versions.

use super::compiler::on_path;
use super::trial::{self, Answer};
use super::{Compiler, CrossCompiler};
use crate::Error;
use schemars::JsonSchema;
use serde::Serialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Locations at which Wine can be installed without being on the PATH.
const WINE_PLACES: [&str; 8] = [
    "/usr/lib/wine/wine64",
    "/usr/lib/wine/wine",
    "/usr/lib/x86_64-linux-gnu/wine/wine64",
    "/usr/lib64/wine/wine64",
    "/opt/wine-stable/bin/wine64",
    "/opt/wine-stable/bin/wine",
    "/opt/wine-devel/bin/wine",
    "/Applications/Wine Stable.app/Contents/Resources/wine/bin/wine64",
];

/// Python packages that tests use.
const PACKAGES: [&str; 3] = ["fmpy", "blark", "ziglang"];

/// A program that was found.
#[derive(Debug, Clone, PartialEq, Eq, JsonSchema, Serialize)]
pub struct FoundProgram {
    /// Command that starts the program.
    pub command: String,
    /// First line of its version output.
    pub version: Option<String>,
    /// Reason why an existing compiler fails to compile.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
}

/// Result of the survey.
#[derive(Debug)]
pub struct Survey {
    /// The C compiler for this computer.
    pub host: Result<FoundProgram, Error>,
    /// Compilers for 64-bit Windows, in order of preference.
    pub cross: Vec<(CrossCompiler, Option<FoundProgram>)>,
    /// Wine.
    pub wine: Option<FoundProgram>,
    /// Python 3.
    pub python: Option<FoundProgram>,
    /// Installed packages that tests use.
    pub packages: Vec<&'static str>,
}

impl Survey {
    /// The compiler that `--target windows` uses: the first that exists, even if it has a fault.
    pub fn windows(&self) -> Option<(CrossCompiler, &FoundProgram)> {
        let mut cross = self.cross.iter();
        cross.find_map(|(kind, found)| Some((*kind, found.as_ref()?)))
    }
}

/// Surveys this computer. Starts all compilers and programs that exist.
pub fn survey() -> Survey {
    let python = ["python3", "python"]
        .into_iter()
        .find_map(|p| on_path(OsStr::new(p)));
    let packages = python.as_deref().map(packages).unwrap_or_default();
    let work = tempfile::tempdir();
    let cross = CrossCompiler::ALL.into_iter().map(|kind| {
        let found = kind.find().map(|compiler| {
            let version = compiler.version();
            let tried = match (&version, &work) {
                (Ok(_), Ok(work)) => trial::compiles(&compiler, work.path()),
                (Err(why), _) => Err(why.clone()),
                (_, Err(e)) => Err(e.to_string()),
            };
            FoundProgram {
                command: compiler.show(),
                version: version.ok(),
                fault: tried.err(),
            }
        });
        (kind, found)
    });
    Survey {
        host: host(),
        cross: cross.collect(),
        wine: wine().as_deref().map(with_version),
        python: python.as_deref().map(with_version),
        packages,
    }
}

/// Finds Wine, on the PATH or in one of its usual locations.
pub fn wine() -> Option<PathBuf> {
    let named = ["wine64", "wine"]
        .into_iter()
        .find_map(|p| on_path(OsStr::new(p)));
    let place = || {
        let mut places = WINE_PLACES.iter().map(PathBuf::from);
        places.find(|p| p.is_file())
    };
    named.or_else(place)
}

fn host() -> Result<FoundProgram, Error> {
    let work = tempfile::tempdir().map_err(|cause| Error::Unwritable {
        path: std::env::temp_dir(),
        cause,
    })?;
    let unusable = |command: String, cause: String| Error::CompilerMissing { command, cause };
    // The `cc` crate would wait forever for a hanging compiler, so this function first checks that
    // the compiler answers.
    let named = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let program = named.split_whitespace().next().unwrap_or("cc");
    if let Some(program) = on_path(OsStr::new(program)) {
        let answer = trial::answer(Command::new(program).arg("--version"));
        answer.map_err(|why| unusable(named.clone(), why))?;
    }
    let compiler = Compiler::host(None, work.path())?;
    let version = compiler
        .version()
        .and_then(|v| trial::compiles(&compiler, work.path()).map(|()| v))
        .map_err(|why| unusable(compiler.show(), why))?;
    Ok(FoundProgram {
        command: compiler.program().display().to_string(),
        version: Some(version),
        fault: None,
    })
}

/// Runs a program to find out its version.
fn with_version(program: &Path) -> FoundProgram {
    let mut command = Command::new(program);
    let answer = trial::answer(command.arg("--version").env("WINEDEBUG", "-all"));
    FoundProgram {
        command: program.display().to_string(),
        version: answer.ok().and_then(|a| Answer::first_line(&a.stdout)),
        fault: None,
    }
}

/// Finds the installed packages among [`PACKAGES`].
fn packages(python: &Path) -> Vec<&'static str> {
    let script = format!(
        "import importlib.util as u\nprint(' '.join(p for p in '{}'.split() if u.find_spec(p)))",
        PACKAGES.join(" ")
    );
    let answer = trial::answer(Command::new(python).args(["-c", &script]));
    let output = answer.map(|a| a.stdout).unwrap_or_default();
    let has = |p: &&str| output.split_whitespace().any(|word| word == *p);
    PACKAGES.into_iter().filter(has).collect()
}
