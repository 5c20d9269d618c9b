//! What there is on this computer: compilers, and what tests use beside them. Nothing is compiled; programs are only asked for their
//! version.

use super::compiler::on_path;
use super::{Compiler, CrossCompiler};
use crate::station::Error;
use serde::Serialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where Wine is installed without being on the PATH.
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
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Found {
    /// As it is started.
    pub command: String,
    /// The first line of what it says of its version.
    pub version: Option<String>,
}

/// What was looked for, and found or not.
#[derive(Debug)]
pub struct Survey {
    /// The C compiler for this computer.
    pub host: Result<Found, Error>,
    /// Those for 64-bit Windows, in the order in which they are taken.
    pub cross: Vec<(CrossCompiler, Option<Found>)>,
    /// Wine.
    pub wine: Option<Found>,
    /// Python 3.
    pub python: Option<Found>,
    /// Which of the packages that tests use it has.
    pub packages: Vec<&'static str>,
}

impl Survey {
    /// The compiler that `--target windows` takes.
    pub fn windows(&self) -> Option<CrossCompiler> {
        let found = self.cross.iter().find(|(_, found)| found.is_some());
        found.map(|(kind, _)| *kind)
    }
}

/// Looks for everything.
pub fn survey() -> Survey {
    let python = ["python3", "python"]
        .into_iter()
        .find_map(|p| on_path(OsStr::new(p)));
    let packages = python.as_deref().map(packages).unwrap_or_default();
    let cross = CrossCompiler::ALL.into_iter().map(|kind| {
        let found = kind.find().map(|compiler| Found {
            command: compiler.show(),
            version: compiler.version(),
        });
        // One that cannot say its version cannot compile either.
        (kind, found.filter(|f| f.version.is_some()))
    });
    Survey {
        host: host(),
        cross: cross.collect(),
        wine: wine().as_deref().map(asked),
        python: python.as_deref().map(asked),
        packages,
    }
}

/// Wine's program for 64 bits, on the PATH or in one of its usual places.
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

fn host() -> Result<Found, Error> {
    let work = tempfile::tempdir().map_err(|cause| Error::Unwritable {
        path: std::env::temp_dir(),
        cause,
    })?;
    let compiler = Compiler::host(None, work.path())?;
    let version = compiler.version();
    if version.is_none() {
        return Err(Error::CompilerMissing {
            command: compiler.show(),
            cause: "it does not say its version".to_owned(),
        });
    }
    Ok(Found {
        command: compiler.program().display().to_string(),
        version,
    })
}

/// A program and what it says of its version.
fn asked(program: &Path) -> Found {
    let output = Command::new(program)
        .arg("--version")
        .env("WINEDEBUG", "-all")
        .stdin(Stdio::null())
        .output();
    let version = output.ok().and_then(|o| {
        let text = String::from_utf8_lossy(&o.stdout).into_owned();
        let line = text.lines().find(|l| !l.trim().is_empty())?;
        Some(line.trim().to_owned())
    });
    Found {
        command: program.display().to_string(),
        version,
    }
}

fn packages(python: &Path) -> Vec<&'static str> {
    let script = format!(
        "import importlib.util as u\nprint(' '.join(p for p in '{}'.split() if u.find_spec(p)))",
        PACKAGES.join(" ")
    );
    let output = Command::new(python)
        .args(["-c", &script])
        .stdin(Stdio::null())
        .output();
    let said = output.map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
    let said = said.unwrap_or_default();
    let has = |p: &&str| said.split_whitespace().any(|word| word == *p);
    PACKAGES.into_iter().filter(has).collect()
}
