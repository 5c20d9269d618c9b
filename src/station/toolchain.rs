//! Compiling packages into libraries, and remembering what was compiled.
//!
//! The compiler is the one that the `cc` crate finds (the environment variables `CC` and `CFLAGS` are honoured), asked for
//! only when something has to be compiled. A library's name carries a hash of all that decides what is in it: the C text,
//! the runtime, the flags, and what names the compiler. Beside it stands a manifest with its length and SHA-256, without
//! which it is not loaded.
//!
//! Optimisation: none. Measured with gcc 12 on a manipulator of five components (128 kB of C), as CPU time of one run of
//! the compiler and as time of a step: `-O0` 0.10 s and 285 ns, `-Og` 0.14 s and 164 ns, `-O1` 0.19 s and 125 ns, `-O2`
//! 0.27 s and 132 ns. A run has to make some hundred thousand steps before the optimiser has paid for itself.

use super::package::{Package, create_folder, write};
use super::{Error, emit};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::OnceLock;

/// `LW_ABI_VERSION` of `ffi/station.h`.
pub(super) const ABI_VERSION: i32 = 1;

/// Flags of every library.
const FLAGS: [&str; 6] = [
    "-std=c99",
    "-O0",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
    "-ffp-contract=off",
];

/// Further ones for the linker. An export that the library calls itself is always its own.
const LINKER_FLAGS: &[&str] = if cfg!(target_os = "linux") {
    &["-pthread", "-Wl,-Bsymbolic", "-lm"]
} else {
    &["-pthread", "-lm"]
};

/// What the `cc` crate looks at to find a compiler and its flags, beside the same with the target's name.
const ENVIRONMENT: [&str; 4] = ["CC", "HOST_CC", "CFLAGS", "HOST_CFLAGS"];

/// A C compiler for this platform.
#[derive(Debug, Default)]
pub struct Toolchain {
    command: Option<PathBuf>,
    flags: Option<Vec<String>>,
    found: OnceLock<Result<cc::Tool, (String, String)>>,
}

/// A library that is in its folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Built {
    /// The library.
    pub path: PathBuf,
    /// Whether a compiler was run; otherwise it was there already.
    pub compiled: bool,
}

/// What is written down beside a library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Manifest {
    schema: String,
    machine: String,
    contract_hash: String,
    length: u64,
    sha256: String,
}

const MANIFEST_SCHEMA: &str = "linewright/library/1";

impl Manifest {
    fn path(library: &Path) -> PathBuf {
        library.with_extension("json")
    }

    /// Compares a library with its manifest.
    pub(super) fn verify(library: &Path) -> Result<(), Error> {
        let damaged = |reason: String| Error::LibraryDamaged {
            path: library.to_owned(),
            reason,
        };
        let path = Self::path(library);
        let text = std::fs::read(&path).map_err(|e| {
            damaged(format!(
                "its manifest {} cannot be read: {e}",
                path.display()
            ))
        })?;
        let manifest: Self = serde_json::from_slice(&text)
            .map_err(|e| damaged(format!("its manifest {} is damaged: {e}", path.display())))?;
        let bytes =
            std::fs::read(library).map_err(|e| damaged(format!("it cannot be read: {e}")))?;
        if bytes.len() as u64 != manifest.length {
            return Err(damaged(format!(
                "it has {} bytes instead of {}",
                bytes.len(),
                manifest.length
            )));
        }
        if emit::hex(&Sha256::digest(&bytes)) != manifest.sha256 {
            return Err(damaged(
                "its bytes are not those that were built".to_owned(),
            ));
        }
        Ok(())
    }
}

impl Toolchain {
    /// The compiler that the environment names, else the platform's `cc`. Nothing is looked for yet.
    pub fn host() -> Self {
        Self::default()
    }

    /// A compiler by its path or name.
    pub fn with_compiler(command: impl Into<PathBuf>) -> Self {
        Self {
            command: Some(command.into()),
            ..Self::default()
        }
    }

    /// Other compiler flags than the usual ones; those for the linker stay.
    #[must_use]
    pub fn with_flags(mut self, flags: &[&str]) -> Self {
        self.flags = Some(flags.iter().map(|f| (*f).to_owned()).collect());
        self
    }

    /// Where a package's library is, or will be: `assembly_cell-0123456789abcdef.so`.
    pub fn path(&self, package: &Package, folder: &Path) -> PathBuf {
        let mut hash = Sha256::new();
        hash.update(&package.hash);
        for flag in self.flags().chain(LINKER_FLAGS.iter().copied()) {
            hash.update(flag);
            hash.update([0]);
        }
        hash.update(target());
        if let Some(command) = &self.command {
            hash.update(command.as_os_str().as_encoded_bytes());
        }
        for (name, value) in environment() {
            hash.update(name);
            hash.update([0]);
            hash.update(value.as_encoded_bytes());
            hash.update([0]);
        }
        let hash = emit::hex(&hash.finalize());
        folder.join(format!(
            "{}-{}{}",
            package.stem,
            &hash[..16],
            std::env::consts::DLL_SUFFIX
        ))
    }

    /// Sees to it that a package's library is in `folder`. Unless `rebuild` is asked for, a library that is there already is
    /// taken as it is; loading it checks that it is whole.
    pub fn build(&self, package: &Package, folder: &Path, rebuild: bool) -> Result<Built, Error> {
        let path = self.path(package, folder);
        let compiled = rebuild || !path.exists() || !Manifest::path(&path).exists();
        if compiled {
            self.compile(package, folder, &path)?;
        }
        Ok(Built { path, compiled })
    }

    /// The same for several packages at once, compiled in parallel.
    pub fn build_all(
        &self,
        packages: &[Package],
        folder: &Path,
        rebuild: bool,
    ) -> Vec<Result<Built, Error>> {
        packages
            .par_iter()
            .map(|package| self.build(package, folder, rebuild))
            .collect()
    }

    fn compile(&self, package: &Package, folder: &Path, path: &Path) -> Result<(), Error> {
        create_folder(folder)?;
        // Beside its place, so that the library can be renamed into it.
        let work = tempfile::Builder::new()
            .prefix(".build-")
            .tempdir_in(folder)
            .map_err(|cause| Error::Unwritable {
                path: folder.to_owned(),
                cause,
            })?;
        let source = package.write_source(work.path())?;
        let tool = self.compiler(work.path())?;
        let shown = tool.path().display().to_string();
        let output = tool
            .to_command()
            .args(self.flags())
            .arg(source.file_name().unwrap_or_default())
            .args(["-o", "library"])
            .args(LINKER_FLAGS)
            .current_dir(work.path())
            .stdin(Stdio::null())
            .output()
            .map_err(|e| Error::CompilerMissing {
                command: shown.clone(),
                cause: e.to_string(),
            })?;
        let failed = |stderr: String| Error::CompilerFailed {
            command: shown.clone(),
            machine: package.name.clone(),
            stderr,
        };
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(failed(format!("{}\n({})", text.trim_end(), output.status)));
        }
        let made = work.path().join("library");
        let bytes = std::fs::read(&made)
            .map_err(|e| failed(format!("it succeeded but left no library: {e}")))?;
        let manifest = Manifest {
            schema: MANIFEST_SCHEMA.to_owned(),
            machine: package.name.clone(),
            contract_hash: package.contract_hash.clone(),
            length: bytes.len() as u64,
            sha256: emit::hex(&Sha256::digest(&bytes)),
        };
        let manifest = serde_json::to_vec_pretty(&manifest)
            .map_err(|e| failed(format!("its manifest cannot be written: {e}")))?;
        let unwritable = |cause| Error::Unwritable {
            path: path.to_owned(),
            cause,
        };
        // A library without a manifest is made again, so that of other bytes goes first and the new one comes last. One of
        // the same bytes stays: another process may just have built the same, and be about to load it.
        let manifest_path = Manifest::path(path);
        if std::fs::read(&manifest_path).is_ok_and(|old| old != manifest) {
            std::fs::remove_file(&manifest_path).map_err(unwritable)?;
        }
        std::fs::rename(&made, path).map_err(unwritable)?;
        write(&manifest_path, &manifest)
    }

    fn flags(&self) -> impl Iterator<Item = &str> {
        let usual = if self.flags.is_none() {
            &FLAGS[..]
        } else {
            &[]
        };
        let own = self.flags.iter().flatten().map(String::as_str);
        usual.iter().copied().chain(own)
    }

    /// The compiler, found when first asked for. `work` is a folder for the files with which its kind is found out.
    fn compiler(&self, work: &Path) -> Result<&cc::Tool, Error> {
        let found = self.found.get_or_init(|| {
            let target = target();
            let mut build = cc::Build::new();
            build
                .target(&target)
                .host(&target)
                .opt_level(0)
                .out_dir(work)
                .no_default_flags(true)
                .warnings(false)
                .extra_warnings(false)
                .inherit_rustflags(false)
                .cargo_metadata(false)
                .cargo_warnings(false)
                .cargo_output(false);
            if let Some(command) = &self.command {
                build.compiler(command);
            }
            let wanted = || match (&self.command, std::env::var("CC")) {
                (Some(command), _) => command.display().to_string(),
                (None, Ok(command)) => command,
                (None, Err(_)) => "cc".to_owned(),
            };
            let tool = build
                .try_get_compiler()
                .map_err(|e| (wanted(), e.to_string()))?;
            if tool.is_like_msvc() {
                let cause = "it takes the options of cl, not those of cc".to_owned();
                return Err((tool.path().display().to_string(), cause));
            }
            Ok(tool)
        });
        found
            .as_ref()
            .map_err(|(command, cause)| Error::CompilerMissing {
                command: command.clone(),
                cause: cause.clone(),
            })
    }
}

/// This platform in the words of the `cc` crate.
fn target() -> String {
    let system = if cfg!(target_os = "macos") {
        "apple-darwin"
    } else if cfg!(all(windows, target_env = "msvc")) {
        "pc-windows-msvc"
    } else if cfg!(windows) {
        "pc-windows-gnu"
    } else if cfg!(target_env = "musl") {
        "unknown-linux-musl"
    } else if cfg!(target_os = "freebsd") {
        "unknown-freebsd"
    } else {
        "unknown-linux-gnu"
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

/// The environment variables that decide which compiler is run, and how.
fn environment() -> Vec<(String, OsString)> {
    let target = target();
    let with_target = ["CC", "CFLAGS"].into_iter().flat_map(|name| {
        let plain = format!("{name}_{target}");
        [plain.replace('-', "_"), plain]
    });
    let names = ENVIRONMENT
        .into_iter()
        .map(str::to_owned)
        .chain(with_target);
    names
        .filter_map(|name| {
            let value = std::env::var_os(&name)?;
            Some((name, value))
        })
        .collect()
}
