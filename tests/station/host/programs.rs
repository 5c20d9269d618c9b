//! The host program, built for this computer and for Windows, and its runs.

use super::machines::{self, Subject};
use super::plan::plan;
use super::walk::{Script, script};
use crate::support::programs::{Finished, run};
use crate::support::wine::{Wine, windows_path, wine};
use crate::support::{root, skip};
use linewright::station::toolchain::{Compiler, Platform};
use linewright::station::{Package, Toolchain};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// Longer than any run of the host; ends a hung one.
pub const PATIENCE: Duration = Duration::from_secs(400);

/// Last line of a run without faults.
pub const PASSED: &str = "HOST PASSED";

/// Strict compiler warnings; all of them are errors.
const WARNINGS: [&str; 6] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-pedantic",
    "-Werror",
];

/// Libraries that the host is linked with.
const POSIX_LIBRARIES: [&str; 2] = ["-pthread", "-ldl"];

/// Inputs for a run of the host beside the library.
pub struct Prepared {
    pub subject: Subject,
    pub package: Package,
    pub script: Arc<Script>,
    folder: tempfile::TempDir,
}

impl Prepared {
    /// Writes a machine's plan into a separate folder. The walk through the machine is computed
    /// once.
    pub fn new(subject: &Subject) -> Self {
        static SCRIPTS: Mutex<BTreeMap<String, Arc<Script>>> = Mutex::new(BTreeMap::new());
        let package = Package::emit(&subject.machine, &subject.controllers);
        let mut scripts = SCRIPTS.lock().unwrap_or_else(PoisonError::into_inner);
        let known = scripts.entry(package.hash.clone());
        let script = Arc::clone(known.or_insert_with(|| Arc::new(script(subject))));
        drop(scripts);
        let folder = tempfile::tempdir().expect("a folder");
        let text = plan(subject, &package, &script);
        std::fs::write(folder.path().join("plan"), text).expect("a plan");
        Self {
            subject: subject.clone(),
            package,
            script,
            folder,
        }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn plan(&self) -> PathBuf {
        self.folder.path().join("plan")
    }

    /// Builds the machine's library.
    pub fn library(&self, toolchain: &Toolchain) -> PathBuf {
        let built = toolchain.build(&self.package, self.folder(), false);
        built.expect("the library is built").path
    }

    /// Builds a library from other C.
    pub fn changed(&self, toolchain: &Toolchain, c_source: String, name: &str) -> PathBuf {
        let mut package = self.package.clone();
        package.c_source = c_source;
        package.hash.push_str(name);
        let built = toolchain.build(&package, self.folder(), false);
        built.unwrap_or_else(|e| panic!("{name}: {e}")).path
    }
}

/// A machine whose handles are foreign: the belt for all others, the printer for the belt.
fn other(name: &str) -> &'static Package {
    static OTHERS: OnceLock<[Package; 2]> = OnceLock::new();
    let others = OTHERS.get_or_init(|| {
        ["Belt", "Printer"].map(|name| {
            let subject = machines::named(name);
            Package::emit(&subject.machine, &subject.controllers)
        })
    });
    &others[usize::from(name == "Belt")]
}

/// Compiles C with all warnings as errors. `flags` come first.
pub fn compile(compiler: &mut Command, flags: &[&str], sources: &[PathBuf], program: &Path) {
    let output = compiler
        .args(WARNINGS)
        .args(flags)
        .arg("-I")
        .arg(root().join("ffi"))
        .args(sources)
        .arg("-o")
        .arg(program)
        .args(if program.extension().is_some() {
            &[][..]
        } else {
            &POSIX_LIBRARIES[..]
        })
        .output()
        .expect("the compiler starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{said}");
}

/// The host's own C files.
pub fn sources() -> Vec<PathBuf> {
    let folder = root().join("tests/station/libraries/host");
    let entries = std::fs::read_dir(folder).expect("the host's folder");
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("a file").path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "c"));
    files.sort();
    files
}

/// The usual C compiler of this computer.
pub fn cc() -> Command {
    Command::new("cc")
}

/// A host, and the toolchain whose libraries it loads.
pub struct Host {
    pub toolchain: Toolchain,
    program: PathBuf,
    wine: Option<&'static Wine>,
    /// Folder of the program and of other machines' libraries.
    folder: PathBuf,
}

/// An empty folder with a name, which stays until the tests run again: static values are never
/// dropped.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

impl Host {
    /// The host for this computer; its libraries are the shipped ones.
    pub fn native() -> &'static Self {
        static HOST: OnceLock<Host> = OnceLock::new();
        HOST.get_or_init(|| Self::with_flags("host", Toolchain::shipping(), &["-O2"]))
    }

    /// The host for this computer, compiled with flags, and a matching toolchain. Each has its own
    /// name.
    pub fn with_flags(name: &str, toolchain: Toolchain, flags: &[&str]) -> Self {
        let folder = folder(name);
        let program = folder.join("host");
        compile(&mut cc(), flags, &sources(), &program);
        Self {
            toolchain,
            program,
            wine: None,
            folder,
        }
    }

    /// The host for Windows, under Wine; `None`, with a message, if one of the two is missing.
    pub fn windows() -> Option<&'static Self> {
        static HOST: OnceLock<Result<Host, (&str, String)>> = OnceLock::new();
        let host = HOST.get_or_init(|| {
            let (_, compiler) = Compiler::windows().map_err(|e| ("mingw", e.to_string()))?;
            let toolchain = Toolchain::windows().map_err(|e| ("mingw", e.to_string()))?;
            let wine = wine().map_err(|e| ("wine", e))?;
            let folder = folder("host-windows");
            let program = folder.join("host.exe");
            compile(&mut compiler.command(), &["-O2"], &sources(), &program);
            Ok(Self {
                toolchain,
                program,
                wine: Some(wine),
                folder,
            })
        });
        match host {
            Ok(host) => Some(host),
            Err((what, why)) => {
                skip(what, why);
                None
            }
        }
    }

    fn path(&self, path: &Path) -> String {
        if self.toolchain.platform() == Platform::Host {
            path.display().to_string()
        } else {
            windows_path(path)
        }
    }

    /// Runs the host on a library of a machine.
    pub fn run(&self, prepared: &Prepared, library: &Path, calls: u64) -> Finished {
        self.run_within(prepared, library, calls, PATIENCE)
    }

    /// Like `run`, with another time limit.
    pub fn run_within(
        &self,
        prepared: &Prepared,
        library: &Path,
        calls: u64,
        patience: Duration,
    ) -> Finished {
        self.start(prepared, library, calls, patience, |program| {
            Command::new(program)
        })
    }

    /// Like `run`, started by another program or with other settings.
    pub fn run_through(
        &self,
        prepared: &Prepared,
        library: &Path,
        calls: u64,
        start: impl Fn(&Path) -> Command,
    ) -> Finished {
        self.start(prepared, library, calls, PATIENCE, start)
    }

    fn start(
        &self,
        prepared: &Prepared,
        library: &Path,
        calls: u64,
        patience: Duration,
        start: impl Fn(&Path) -> Command,
    ) -> Finished {
        let other = other(prepared.subject.name());
        let other = self.toolchain.build(other, &self.folder, false);
        let other = other.expect("another machine's library").path;
        let arguments = [
            self.path(library),
            self.path(&prepared.plan()),
            calls.to_string(),
            self.path(&other),
        ];
        match self.wine {
            Some(wine) => wine.run(&self.program, &arguments, patience),
            None => run(start(&self.program).args(&arguments), patience),
        }
    }

    /// Builds the machine's library and runs the host on it; it must pass.
    pub fn passes(&self, prepared: &Prepared, calls: u64) {
        let library = prepared.library(&self.toolchain);
        let finished = self.run(prepared, &library, calls);
        println!("{}", finished.output);
        assert_eq!(
            finished.last_line(),
            PASSED,
            "{}: {}",
            prepared.subject.name(),
            finished.all()
        );
        // An exit code is meaningless under Wine.
        assert!(finished.success || self.wine.is_some(), "{finished:?}");
    }

    /// Runs the host on a faulty library; it must not pass. Returns its output.
    pub fn refuses(&self, prepared: &Prepared, library: &Path, what: &str) -> Finished {
        let finished = self.run(prepared, library, 0);
        assert_eq!(
            finished.last_line(),
            "HOST FAILED",
            "{}, {what}: {}",
            prepared.subject.name(),
            finished.all()
        );
        assert!(!finished.success || self.wine.is_some(), "{finished:?}");
        finished
    }
}
