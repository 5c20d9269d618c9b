//! Compiles packages into libraries, and reuses earlier results.
//!
//! [`compiler`] chooses the compiler, which is started only if a library has to be compiled. A
//! library's file name includes a hash of everything that determines its content: the C source, the
//! runtime, the flags, and the compiler's name. A manifest next to the library holds its length and
//! SHA-256; a library without a manifest is not loaded.
//!
//! # Same package, same compiler, same bytes
//!
//! The compiler is started in a temporary folder and receives only file names without folders,
//! which are derived from the machine's name. By default, the linker for Windows records the time
//! and the library's own name. Recording the time is disabled, and the name is fixed.
//!
//! # Optimisation
//!
//! Shipped libraries are optimized ([`Toolchain::shipping`]). Libraries that the bundled runner
//! builds for itself are not ([`Toolchain::host`]), unless it is asked for many parts, because a
//! run recovers the cost of optimizing only after some hundred thousand steps. `-O2` takes twice as
//! long to compile without making steps faster, because a step is a chain of short decisions. The
//! figures are in `tests/bench/README.md`.

pub mod compiler;
mod manifest;
pub mod survey;
mod trial;
mod work;

use super::package::{Package, create_folder, write};
use super::{Error, disk, emit};
pub use compiler::{Compiler, CrossCompiler, Platform};
use linewright_core::deadline::{Deadline, StopReason};
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

/// Flags of every library compiled with gcc's options, apart from the optimization level.
const FLAGS: [&str; 4] = [
    "-std=c99",
    "-shared",
    "-fvisibility=hidden",
    "-ffp-contract=off",
];

/// Optimization levels of the libraries that the runner builds for itself, and of shipped
/// libraries.
const FAST_TO_BUILD: &str = "-O0";
const FAST_TO_STEP: &str = "-O1";

/// Additional linker flags. With `-Bsymbolic`, calls within the library resolve to its own exports.
const HOST_LINKER: &[&str] = if cfg!(target_os = "linux") {
    &["-pthread", "-Wl,-Bsymbolic", "-lm"]
} else {
    &["-pthread", "-lm"]
};

/// Linker flags for Windows: the library records no build time, and needs no other files of the
/// compiler.
const WINDOWS_LINKER: &[&str] = &["-static-libgcc", "-Wl,--no-insert-timestamp"];

/// Flags of Microsoft's compiler and linker. `/Brepro` puts a hash in place of the time.
const MSVC_FLAGS: &[&str] = &["/nologo", "/O2", "/fp:precise", "/utf-8", "/LD"];
const MSVC_LINKER: &[&str] = &["/link", "/Brepro"];

/// Returns the commands that build a 64-bit DLL from a package's C file: with MinGW's compiler, and
/// with Microsoft's.
pub fn manual_commands(source: &str, library: &str) -> [String; 2] {
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

/// A C compiler and its target platform.
#[derive(Debug)]
pub struct Toolchain {
    platform: Platform,
    /// Path or name of a compiler for this computer.
    command: Option<PathBuf>,
    flags: Vec<String>,
    /// Additional flags at the end.
    linker: &'static [&'static str],
    /// Name of a compiler for Windows; empty for other compilers.
    name: &'static str,
    /// Deadline at which compilers are terminated.
    deadline: Deadline,
    /// The compiler, or its command and the reason why it cannot be used; set on first use.
    found: OnceLock<Result<Compiler, (String, String)>>,
}

/// A library in its folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuiltLibrary {
    /// Path of the library.
    pub path: PathBuf,
    /// Whether a compiler was run; otherwise the library already existed.
    pub compiled: bool,
}

impl BuiltLibrary {
    /// Compares the library with its manifest.
    ///
    /// # Errors
    /// Returns [`Error::LibraryDamaged`] if they do not match.
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

    /// Uses the compiler that the environment names, or else the platform's `cc`, without
    /// optimization. The compiler is not searched for before its first use.
    pub fn host() -> Self {
        Self::like_gcc(Platform::Host, FAST_TO_BUILD)
    }

    /// Uses the same compiler as [`Self::host`], with optimization.
    pub fn shipping() -> Self {
        Self::like_gcc(Platform::Host, FAST_TO_STEP)
    }

    /// Uses the first available compiler for 64-bit Windows.
    ///
    /// # Errors
    /// Returns [`Error::CrossCompilerMissing`] if there is none.
    pub fn windows() -> Result<Self, Error> {
        let (kind, compiler) = Compiler::windows()?;
        Ok(Self::cross(kind, compiler))
    }

    /// Uses this compiler for 64-bit Windows.
    pub fn cross(kind: CrossCompiler, compiler: Compiler) -> Self {
        let mut toolchain = Self::like_gcc(Platform::Windows, FAST_TO_STEP);
        if matches!(kind, CrossCompiler::Zig | CrossCompiler::PythonZig) {
            // By default, zig adds traps for undefined behavior, and debug information with paths.
            // Its linker writes no timestamp, and rejects the option that would suppress it.
            let quiet = ["-fno-sanitize=undefined", "-g0", "-s"];
            toolchain.flags.extend(quiet.map(str::to_owned));
            toolchain.linker = &[];
        }
        toolchain.name = kind.name();
        toolchain.found = OnceLock::from(Ok(compiler));
        toolchain
    }

    /// Uses Microsoft's compiler.
    ///
    /// # Errors
    /// Returns [`Error::MsvcMissing`] if it is not found.
    pub fn msvc() -> Result<Self, Error> {
        let compiler = Compiler::msvc()?;
        let mut toolchain = Self::new(Platform::Msvc, MSVC_FLAGS);
        toolchain.found = OnceLock::from(Ok(compiler));
        Ok(toolchain)
    }

    /// Uses a compiler for this computer with this path or name.
    pub fn with_compiler(command: impl Into<PathBuf>) -> Self {
        Self {
            command: Some(command.into()),
            ..Self::host()
        }
    }

    /// Replaces the default compiler flags; the linker flags stay.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = flags.iter().map(|f| (*f).to_owned()).collect();
        self
    }

    /// Sets the deadline at which running compilers are terminated, and after which no compiler is
    /// started.
    #[must_use]
    pub fn with_deadline(mut self, deadline: Deadline) -> Self {
        self.deadline = deadline;
        self
    }

    /// Target platform of the libraries.
    pub fn platform(&self) -> Platform {
        self.platform
    }

    /// Whether the libraries are for Windows.
    pub fn is_for_windows(&self) -> bool {
        self.platform.suffix() == ".dll"
    }

    /// Returns the path of a package's library, which need not exist:
    /// `assembly_cell-0123456789abcdef.so`.
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

    /// Ensures that a package's library is in `folder`. Unless `rebuild` is set, an existing
    /// library is used without checking it; [`BuiltLibrary::verify`] and loading check it.
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

    /// Like `build`, for several packages in parallel.
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
        let given_up = |reason| Error::GivenUp {
            machine: package.name.clone(),
            reason,
        };
        self.deadline.check().map_err(given_up)?;
        create_folder(folder)?;
        // The work folder is in the folder of the result, so that the library can be moved by
        // renaming.
        let work = WorkFolder::new(folder)?;
        let written = package.write_source(work.path())?;
        let source = written.file_name().unwrap_or_default();
        let compiler = self.compiler(work.path())?;
        let shown = compiler.show();
        // A library for Windows contains its own name, so this name must not vary.
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
            // Ctrl-C in a terminal also ends the compiler, possibly before this process notices it.
            self.deadline.check().map_err(given_up)?;
            if trial::was_interrupted(output.status) {
                return Err(given_up(StopReason::Interrupt));
            }
            // Microsoft's compiler reports errors on its standard output.
            let text = [output.stdout, output.stderr].concat();
            return Err(failed(format!("{}\n({})", text.trim_end(), output.status)));
        }
        let made = work.path().join(made);
        let bytes = std::fs::read(&made)
            .map_err(|e| failed(format!("it succeeded but wrote no library: {e}")))?;
        let manifest = serde_json::to_vec_pretty(&Manifest::new(package, &bytes))
            .map_err(|e| failed(format!("its manifest cannot be written: {e}")))?;
        let unwritable = |cause| Error::Unwritable {
            path: path.to_owned(),
            cause,
        };
        // A library without a manifest is rebuilt, so a manifest for other bytes is removed first
        // and the new one is written last. A manifest for the same bytes stays, because another
        // process may have just built the same library and be about to load it.
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

    /// The compiler's arguments, relative to the folder of the source.
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

    /// Returns the compiler, which is searched for on first use. `work` is a folder for the files
    /// that identify the kind of the compiler.
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
