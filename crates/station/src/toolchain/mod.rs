//! Compiling packages into libraries, and remembering what was compiled.
//!
//! Which compiler is taken stands in [`compiler`]; it is started only when something has to be
//! compiled. A library's name carries a hash of all that decides what is in it: the C text, the
//! runtime, the flags, and what names the compiler. Beside it stands a manifest with its length and
//! SHA-256, without which it is not loaded.
//!
//! # Same package, same compiler, same bytes
//!
//! The compiler is started in a temporary folder and sees no path: the source and the library are
//! named after the machine. The linker for Windows would note the time and the library's own name;
//! the first is switched off, the second is fixed.
//!
//! # Optimisation
//!
//! What ships is optimised ([`Toolchain::shipping`]), what the bundled runner builds for itself is
//! not ([`Toolchain::host`]): a run has to make some hundred thousand steps before the optimiser
//! has paid for itself. `-O2` takes twice as long to compile and steps no faster: a step is a chain
//! of short decisions. The figures are in `tests/bench/README.md`.

pub mod compiler;
mod manifest;
pub mod survey;
mod trial;
mod work;

use super::package::{Package, create_folder, write};
use super::{Error, disk, emit};
pub use compiler::{Compiler, CrossCompiler, Platform};
use linewright_core::deadline::Deadline;
pub(super) use manifest::Manifest;
pub use manifest::schema as manifest_schema;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub(super) use work::WorkFolder;

/// `LW_ABI_VERSION` of `ffi/station.h`.
pub(super) const ABI_VERSION: i32 = 1;

/// Flags of every library that is compiled with gcc's options, beside the level of optimisation.
const FLAGS: [&str; 4] = [
    "-std=c99",
    "-shared",
    "-fvisibility=hidden",
    "-ffp-contract=off",
];

/// What the runner builds for itself, and what ships.
const FAST_TO_BUILD: &str = "-O0";
const FAST_TO_STEP: &str = "-O1";

/// Further ones for the linker. An export that the library calls itself is always its own.
const HOST_LINKER: &[&str] = if cfg!(target_os = "linux") {
    &["-pthread", "-Wl,-Bsymbolic", "-lm"]
} else {
    &["-pthread", "-lm"]
};

/// The same for Windows: no time of the build in the library, and nothing of the compiler beside
/// it.
const WINDOWS_LINKER: &[&str] = &["-static-libgcc", "-Wl,--no-insert-timestamp"];

/// Microsoft's compiler and linker. `/Brepro` puts a hash where the time would stand.
const MSVC_FLAGS: &[&str] = &["/nologo", "/O2", "/fp:precise", "/utf-8", "/LD"];
const MSVC_LINKER: &[&str] = &["/link", "/Brepro"];

/// How a 64-bit DLL is made by hand of a package's C file: with MinGW's compiler, and with
/// Microsoft's.
pub fn by_hand(source: &str, library: &str) -> [String; 2] {
    let gcc: Vec<&str> = FLAGS.into_iter().chain([FAST_TO_STEP]).collect();
    [
        format!(
            "x86_64-w64-mingw32-gcc {} {source} -o {library} {}",
            gcc.join(" "),
            WINDOWS_LINKER.join(" ")
        ),
        format!(
            "cl {} {source} /Fe:{library} {}",
            MSVC_FLAGS.join(" "),
            MSVC_LINKER.join(" ")
        ),
    ]
}

/// A C compiler, and what it compiles for.
#[derive(Debug)]
pub struct Toolchain {
    platform: Platform,
    /// A compiler for this computer by its path or name.
    command: Option<PathBuf>,
    flags: Vec<String>,
    /// Further flags, which stand last.
    linker: &'static [&'static str],
    /// What is found before anything is built.
    name: &'static str,
    /// When compilers are ended.
    deadline: Deadline,
    found: OnceLock<Result<Compiler, (String, String)>>,
}

/// A library that is in its folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuiltLibrary {
    /// The library.
    pub path: PathBuf,
    /// Whether a compiler was run; otherwise it was there already.
    pub compiled: bool,
}

impl BuiltLibrary {
    /// Whether the library's bytes are those that were built; an error where they are not.
    pub fn verify(&self) -> Result<(), Error> {
        Manifest::verify(&self.path)
    }
}

impl Toolchain {
    fn new(platform: Platform, flags: &[&str]) -> Self {
        Self {
            platform,
            command: None,
            flags: flags.iter().map(|f| (*f).to_owned()).collect(),
            linker: match platform {
                Platform::Host => HOST_LINKER,
                Platform::Windows => WINDOWS_LINKER,
                Platform::Msvc => MSVC_LINKER,
            },
            name: "",
            deadline: Deadline::NONE,
            found: OnceLock::new(),
        }
    }

    fn like_gcc(platform: Platform, optimisation: &str) -> Self {
        let position = (platform == Platform::Host).then_some("-fPIC");
        let flags: Vec<&str> = FLAGS
            .into_iter()
            .chain([optimisation])
            .chain(position)
            .collect();
        Self::new(platform, &flags)
    }

    /// The compiler that the environment names, else the platform's `cc`; its libraries are quickly
    /// built. Nothing is looked for yet.
    pub fn host() -> Self {
        Self::like_gcc(Platform::Host, FAST_TO_BUILD)
    }

    /// The same compiler; its libraries are quick.
    pub fn shipping() -> Self {
        Self::like_gcc(Platform::Host, FAST_TO_STEP)
    }

    /// The first compiler for 64-bit Windows that there is. An error where there is none.
    pub fn windows() -> Result<Self, Error> {
        let (kind, compiler) = Compiler::windows()?;
        Ok(Self::cross(kind, compiler))
    }

    /// A compiler for 64-bit Windows that was found.
    pub fn cross(kind: CrossCompiler, compiler: Compiler) -> Self {
        let mut toolchain = Self::like_gcc(Platform::Windows, FAST_TO_STEP);
        if matches!(kind, CrossCompiler::Zig | CrossCompiler::PythonZig) {
            // Without these, zig adds traps for undefined behaviour, and debug information with
            // paths. Its linker notes no time, and refuses to be told so.
            let quiet = ["-fno-sanitize=undefined", "-g0", "-s"];
            toolchain.flags.extend(quiet.map(str::to_owned));
            toolchain.linker = &[];
        }
        toolchain.name = kind.name();
        toolchain.found = OnceLock::from(Ok(compiler));
        toolchain
    }

    /// Microsoft's compiler. An error where there is none; no other compiler is taken for it.
    pub fn msvc() -> Result<Self, Error> {
        let compiler = Compiler::msvc()?;
        let mut toolchain = Self::new(Platform::Msvc, MSVC_FLAGS);
        toolchain.found = OnceLock::from(Ok(compiler));
        Ok(toolchain)
    }

    /// A compiler for this computer, by its path or name.
    pub fn with_compiler(command: impl Into<PathBuf>) -> Self {
        Self {
            command: Some(command.into()),
            ..Self::host()
        }
    }

    /// Other compiler flags than the usual ones; those for the linker stay.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = flags.iter().map(|f| (*f).to_owned()).collect();
        self
    }

    /// Compilers that run at this time are ended, and none is started later.
    #[must_use]
    pub fn until(mut self, deadline: Deadline) -> Self {
        self.deadline = deadline;
        self
    }

    /// What its libraries run on.
    pub fn platform(&self) -> Platform {
        self.platform
    }

    /// Whether Windows loads its libraries.
    pub fn is_for_windows(&self) -> bool {
        self.platform.suffix() == ".dll"
    }

    /// Where a package's library is, or will be: `assembly_cell-0123456789abcdef.so`.
    pub fn path(&self, package: &Package, folder: &Path) -> PathBuf {
        let mut hash = Sha256::new();
        hash.update(&package.hash);
        for flag in self.flags().chain(self.linker.iter().copied()) {
            hash.update(flag);
            hash.update([0]);
        }
        hash.update(self.platform.triple());
        hash.update(self.name);
        if let Some(command) = &self.command {
            hash.update(command.as_os_str().as_encoded_bytes());
        }
        for (name, value) in self.platform.environment() {
            hash.update(name);
            hash.update([0]);
            hash.update(value.as_encoded_bytes());
            hash.update([0]);
        }
        let hash = emit::hex(&hash.finalize());
        let suffix = self.platform.suffix();
        folder.join(format!("{}-{}{suffix}", package.stem, &hash[..16]))
    }

    /// Sees to it that a package's library is in `folder`. Unless `rebuild` is asked for, a library
    /// that is there already is taken as it is; loading it checks that it is whole, and so does
    /// [`BuiltLibrary::verify`].
    pub fn build(
        &self,
        package: &Package,
        folder: &Path,
        rebuild: bool,
    ) -> Result<BuiltLibrary, Error> {
        let path = self.path(package, folder);
        let compiled = rebuild || !path.is_file() || !Manifest::path(&path).is_file();
        if compiled {
            self.compile(package, folder, &path)?;
        }
        Ok(BuiltLibrary { path, compiled })
    }

    /// The same for several packages at once, compiled in parallel.
    pub fn build_all(
        &self,
        packages: &[Package],
        folder: &Path,
        rebuild: bool,
    ) -> Vec<Result<BuiltLibrary, Error>> {
        packages
            .par_iter()
            .map(|package| self.build(package, folder, rebuild))
            .collect()
    }

    fn compile(&self, package: &Package, folder: &Path, path: &Path) -> Result<(), Error> {
        let given_up = |late| Error::GivenUp {
            machine: package.name.clone(),
            late,
        };
        self.deadline.check().map_err(given_up)?;
        create_folder(folder)?;
        // Beside its place, so that the library can be renamed into it.
        let work = WorkFolder::new(folder)?;
        let written = package.write_source(work.path())?;
        let source = written.file_name().unwrap_or_default();
        let compiler = self.compiler(work.path())?;
        let shown = compiler.show();
        // A library for Windows carries this name inside it.
        let made = format!("{}{}", package.stem, self.platform.suffix());
        let mut command = compiler.command();
        command
            .args(self.arguments(source, &made))
            .current_dir(work.path());
        let output = trial::answer_until(&mut command, self.deadline).map_err(|e| {
            Error::CompilerMissing {
                command: shown.clone(),
                cause: e.to_string(),
            }
        })?;
        let output = output.map_err(given_up)?;
        let failed = |stderr: String| Error::CompilerFailed {
            command: shown.clone(),
            machine: package.name.clone(),
            stderr,
        };
        if !output.status.success() {
            // Ctrl-C on a terminal ends the compiler as well.
            self.deadline.check().map_err(given_up)?;
            // Microsoft's compiler says what is wrong on its standard output.
            let text = [output.stdout, output.stderr].concat();
            return Err(failed(format!("{}\n({})", text.trim_end(), output.status)));
        }
        let made = work.path().join(made);
        let bytes = std::fs::read(&made)
            .map_err(|e| failed(format!("it succeeded but left no library: {e}")))?;
        let manifest = serde_json::to_vec_pretty(&Manifest::new(package, &bytes))
            .map_err(|e| failed(format!("its manifest cannot be written: {e}")))?;
        let unwritable = |cause| Error::Unwritable {
            path: path.to_owned(),
            cause,
        };
        // A library without a manifest is made again, so that of other bytes goes first and the new
        // one comes last. One of the same bytes stays: another process may just have built the
        // same, and be about to load it.
        let manifest_path = Manifest::path(path);
        if disk::read(&manifest_path).is_ok_and(|old| old != manifest) {
            std::fs::remove_file(&manifest_path).map_err(unwritable)?;
        }
        std::fs::rename(&made, path).map_err(unwritable)?;
        write(&manifest_path, &manifest)
    }

    fn flags(&self) -> impl Iterator<Item = &str> {
        self.flags.iter().map(String::as_str)
    }

    /// The compiler's arguments, from the folder in which the source is.
    fn arguments(&self, source: &std::ffi::OsStr, made: &str) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = self.flags().map(OsString::from).collect();
        arguments.push(source.to_owned());
        if self.platform == Platform::Msvc {
            arguments.push(format!("/Fe:{made}").into());
        } else {
            arguments.extend(["-o".into(), made.into()]);
        }
        arguments.extend(self.linker.iter().map(OsString::from));
        arguments
    }

    /// The compiler, found when first asked for. `work` is a folder for the files with which its
    /// kind is found out.
    fn compiler(&self, work: &Path) -> Result<&Compiler, Error> {
        let found = self.found.get_or_init(|| {
            Compiler::host(self.command.as_deref(), work).map_err(|e| match e {
                Error::CompilerMissing { command, cause } => (command, cause),
                other => ("cc".to_owned(), other.to_string()),
            })
        });
        found
            .as_ref()
            .map_err(|(command, cause)| Error::CompilerMissing {
                command: command.clone(),
                cause: cause.clone(),
            })
    }
}
