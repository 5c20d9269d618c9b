//! Finds C compilers for this computer and for 64-bit Windows.
//!
//! The `cc` crate finds the compiler for this computer; it respects the environment variables `CC`
//! and `CFLAGS`. Windows libraries are built with the first available compiler of this list, with
//! the flags from `CFLAGS_x86_64_pc_windows_gnu`:
//!
//! 1. the value of `CC_x86_64_pc_windows_gnu`;
//! 2. `x86_64-w64-mingw32-gcc` on the PATH (Debian's `gcc-mingw-w64-x86-64`);
//! 3. `zig` on the PATH, as `zig cc`;
//! 4. `python3 -m ziglang`, or `python -m ziglang` (PyPI's `ziglang`).
//!
//! Microsoft's compiler is found only on Windows, by `cc::windows_registry`. The general search of
//! the `cc` crate would return another compiler on other systems.

use super::trial::{self, Answer};
use crate::Error;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Target platform of a library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Platform {
    /// The computer that this program runs on.
    Host,
    /// 64-bit Windows, with the options of gcc.
    Windows,
    /// 64-bit Windows, with Microsoft's compiler.
    Msvc,
}

/// A kind of compiler for 64-bit Windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CrossCompiler {
    /// The compiler that `CC_x86_64_pc_windows_gnu` names.
    Named,
    /// MinGW's gcc.
    MinGw,
    /// Zig, on the PATH.
    Zig,
    /// Zig, installed as a Python package.
    PythonZig,
}

/// A compiler with its command line.
#[derive(Debug, Clone)]
pub struct Compiler {
    program: PathBuf,
    /// Fixed arguments, before all others.
    first: Vec<OsString>,
    /// Number of fixed arguments that belong to the compiler's name: `cc` in `zig cc`.
    named: usize,
    environment: Vec<(OsString, OsString)>,
}

/// The environment variable that names the compiler for Windows.
const NAMED: &str = "CC_x86_64_pc_windows_gnu";

/// The environment variable with flags for the compiler for Windows.
const NAMED_FLAGS: &str = "CFLAGS_x86_64_pc_windows_gnu";

impl Platform {
    /// Target triple for the `cc` crate.
    pub(super) fn triple(self) -> String {
        match self {
            Self::Host => host(),
            Self::Windows => "x86_64-pc-windows-gnu".to_owned(),
            Self::Msvc => "x86_64-pc-windows-msvc".to_owned(),
        }
    }

    /// File name suffix of libraries, with the dot.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Host => std::env::consts::DLL_SUFFIX,
            Self::Windows | Self::Msvc => ".dll",
        }
    }

    /// Environment variables that affect the choice of compiler and its flags, if set.
    pub(super) fn environment(self) -> Vec<(String, OsString)> {
        let triple = self.triple();
        let with_target = |name: &&str| {
            let plain = format!("{name}_{triple}");
            [plain.replace('-', "_"), plain]
        };
        let names: Vec<String> = match self {
            Self::Host => {
                let plain = ["CC", "HOST_CC", "CFLAGS", "HOST_CFLAGS"];
                let targeted = ["CC", "CFLAGS"].iter().flat_map(with_target);
                plain
                    .map(str::to_owned)
                    .into_iter()
                    .chain(targeted)
                    .collect()
            }
            Self::Windows => vec![NAMED.to_owned(), NAMED_FLAGS.to_owned()],
            Self::Msvc => vec!["CL".to_owned(), "_CL_".to_owned()],
        };
        names
            .into_iter()
            .filter_map(|name| {
                let value = std::env::var_os(&name)?;
                Some((name, value))
            })
            .collect()
    }
}

impl Compiler {
    fn plain(program: PathBuf, first: &[&str]) -> Self {
        Self {
            program,
            first: first.iter().map(OsString::from).collect(),
            named: first.len(),
            environment: Vec::new(),
        }
    }

    /// Finds the compiler for this computer, or the one with the given path or name. The compiler
    /// must take the options of `cc`. `work` is a folder for the files with which the `cc` crate
    /// identifies the kind of the compiler.
    pub(super) fn host(wanted: Option<&Path>, work: &Path) -> Result<Self, Error> {
        let missing = |command: String, cause: String| Error::CompilerMissing { command, cause };
        let named = || match (wanted, std::env::var("CC")) {
            (Some(command), _) => command.display().to_string(),
            (None, Ok(command)) => command,
            (None, Err(_)) => "cc".to_owned(),
        };
        let tool = tool(wanted, work).map_err(|e| missing(named(), e))?;
        if tool.is_like_msvc() {
            let cause = "it takes the options of cl instead of those of cc".to_owned();
            return Err(missing(tool.path().display().to_string(), cause));
        }
        Ok(Self::of(&tool))
    }

    /// Finds the first available compiler for 64-bit Windows.
    pub fn windows() -> Result<(CrossCompiler, Self), Error> {
        let found = CrossCompiler::ALL
            .into_iter()
            .find_map(|kind| Some((kind, kind.find()?)));
        let (kind, mut compiler) = found.ok_or(Error::CrossCompilerMissing)?;
        let flags = std::env::var(NAMED_FLAGS).unwrap_or_default();
        compiler
            .first
            .extend(flags.split_whitespace().map(OsString::from));
        Ok((kind, compiler))
    }

    /// Finds Microsoft's compiler for 64-bit Windows.
    pub fn msvc() -> Result<Self, Error> {
        let tool = cc::windows_registry::find_tool("x86_64-pc-windows-msvc", "cl.exe");
        Ok(Self::of(&tool.ok_or(Error::MsvcMissing)?))
    }

    fn of(tool: &cc::Tool) -> Self {
        Self {
            program: tool.path().to_owned(),
            first: tool.args().to_vec(),
            named: 0,
            environment: tool
                .get_envs()
                .map(|(k, v)| (k.to_owned(), v.to_owned()))
                .collect(),
        }
    }

    /// Returns a command with the fixed arguments and environment, without standard input.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.args(&self.first);
        command.envs(self.environment.iter().map(|(k, v)| (k, v)));
        command.stdin(Stdio::null());
        command
    }

    /// Path of the program, as found on the PATH.
    pub fn program(&self) -> PathBuf {
        on_path(self.program.as_os_str()).unwrap_or_else(|| self.program.clone())
    }

    /// Formats the command for messages: `zig cc`.
    pub fn show(&self) -> String {
        let first = self.first[..self.named].iter().map(|a| a.to_string_lossy());
        let program = self.program.display().to_string();
        let words: Vec<_> = std::iter::once(program.into()).chain(first).collect();
        words.join(" ")
    }

    /// Returns the first line of the compiler's version output.
    ///
    /// # Errors
    /// Returns the reason why there is none.
    pub fn version(&self) -> Result<String, String> {
        let answer = trial::answer(self.command().arg("--version"))?;
        if !answer.status.success() {
            return Err(format!(
                "it does not report its version ({})",
                answer.status
            ));
        }
        Answer::first_line(&answer.stdout).ok_or("it does not report its version".to_owned())
    }
}

impl CrossCompiler {
    /// All kinds, in order of preference.
    pub const ALL: [Self; 4] = [Self::Named, Self::MinGw, Self::Zig, Self::PythonZig];

    /// Name of the compiler in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Named => "the compiler that CC_x86_64_pc_windows_gnu names",
            Self::MinGw => "x86_64-w64-mingw32-gcc",
            Self::Zig => "zig cc",
            Self::PythonZig => "python3 -m ziglang cc",
        }
    }

    /// Whether the compiler is searched for even if the environment does not name it.
    pub fn is_searched_by_default(self) -> bool {
        self != Self::Named
    }

    /// Finds the compiler, without trying to compile.
    pub fn find(self) -> Option<Compiler> {
        let zig = ["cc", "-target", "x86_64-windows-gnu"];
        match self {
            Self::Named => {
                let named = std::env::var(NAMED).ok()?;
                let mut words = named.split_whitespace();
                let program = on_path(OsStr::new(words.next()?))?;
                Some(Compiler::plain(program, &words.collect::<Vec<_>>()))
            }
            Self::MinGw => {
                let program = on_path(OsStr::new("x86_64-w64-mingw32-gcc"))?;
                Some(Compiler::plain(program, &[]))
            }
            Self::Zig => Some(Compiler::plain(on_path(OsStr::new("zig"))?, &zig)),
            Self::PythonZig => ["python3", "python"].into_iter().find_map(|python| {
                let python = on_path(OsStr::new(python))?;
                let mut zig_version = Command::new(&python);
                zig_version.args(["-m", "ziglang", "version"]);
                let answer = trial::answer(&mut zig_version).ok()?;
                let words: Vec<&str> = ["-m", "ziglang"].into_iter().chain(zig).collect();
                answer
                    .status
                    .success()
                    .then(|| Compiler::plain(python, &words))
            }),
        }
    }
}

/// Finds a compiler with the `cc` crate.
fn tool(wanted: Option<&Path>, work: &Path) -> Result<cc::Tool, String> {
    let host = host();
    let mut build = cc::Build::new();
    build
        .target(&host)
        .host(&host)
        .opt_level(0)
        .out_dir(work)
        .no_default_flags(true)
        .warnings(false)
        .extra_warnings(false)
        .inherit_rustflags(false)
        .cargo_metadata(false)
        .cargo_warnings(false)
        .cargo_output(false);
    if let Some(command) = wanted {
        build.compiler(command);
    }
    build.try_get_compiler().map_err(|e| e.to_string())
}

/// Target triple of this computer, for the `cc` crate.
fn host() -> String {
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

/// Finds a program by its name in the folders of the PATH, or by its path.
pub fn on_path(program: &OsStr) -> Option<PathBuf> {
    let is_program = |path: &PathBuf| path.is_file();
    if Path::new(program).components().count() > 1 {
        return Some(PathBuf::from(program)).filter(is_program);
    }
    let mut name = program.to_owned();
    if cfg!(windows) && Path::new(program).extension().is_none() {
        name.push(".exe");
    }
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .map(|folder| folder.join(&name))
        .find(is_program)
}
