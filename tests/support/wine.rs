//! Windows programs on this computer: the location of Wine, and running a program under it.
//!
//! The first start of Wine in a prefix takes some seconds, so all tests share one, in cargo's
//! folder for test files. Exit codes are unreliable: a crashed program may end with 0. A program's
//! last line says that it completed.

use super::programs::{Finished, run};
use linewright::station::toolchain::survey;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

/// Maximum time for creating a prefix on a busy computer.
const FIRST_START: Duration = Duration::from_mins(5);

/// Wine with an initialized prefix.
pub struct Wine {
    program: PathBuf,
    prefix: PathBuf,
}

/// Returns Wine, if it is installed and works; otherwise the reason.
pub fn wine() -> Result<&'static Wine, String> {
    static WINE: OnceLock<Result<Wine, String>> = OnceLock::new();
    WINE.get_or_init(Wine::new).as_ref().map_err(Clone::clone)
}

/// Converts a path for Windows programs: the root of this computer is their drive Z.
pub fn windows_path(path: &Path) -> String {
    let path = std::path::absolute(path).expect("the current folder is there");
    let path = path.to_str().expect("a path in UTF-8");
    format!("Z:{}", path.replace('/', "\\"))
}

impl Wine {
    fn new() -> Result<Self, String> {
        let program =
            survey::wine().ok_or("Wine is neither on the PATH nor in its usual places")?;
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let prefix = folder.join("wine");
        let wine = Self { program, prefix };
        // Several test programs may be the first.
        let said = |e: std::io::Error| format!("{}: {e}", folder.display());
        let lock = File::create(folder.join("wine.lock")).map_err(said)?;
        lock.lock().map_err(said)?;
        let ready = folder.join("wine.ready");
        if !(ready.is_file() && wine.prefix.is_dir()) {
            let _ = std::fs::remove_dir_all(&wine.prefix);
            std::fs::create_dir_all(&wine.prefix).map_err(said)?;
            let mut boot = wine.command();
            boot.args(["cmd", "/c", "echo started"]);
            let finished = run(&mut boot, FIRST_START);
            if !finished.output.contains("started") {
                return Err(format!(
                    "{} does not start: {}",
                    wine.program.display(),
                    finished.all()
                ));
            }
            std::fs::write(&ready, "").map_err(said)?;
        }
        Ok(wine)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command
            .env("WINEPREFIX", &self.prefix)
            .env("WINEDEBUG", "-all")
            // Neither of these is needed, and each would open a dialog.
            .env("WINEDLLOVERRIDES", "mscoree=;mshtml=;winemenubuilder.exe=")
            .env_remove("DISPLAY");
        command
    }

    /// Runs a Windows program. Paths among its arguments have to be Windows paths.
    ///
    /// Wine's server ends soon after the last program. A program that starts at this moment can
    /// lose its connection before it has done anything; it is then started again.
    pub fn run(&self, program: &Path, arguments: &[String], patience: Duration) -> Finished {
        const ATTEMPTS: usize = 3;
        let attempt = || {
            let mut command = self.command();
            command.arg(windows_path(program)).args(arguments);
            run(&mut command, patience)
        };
        let mut finished = attempt();
        for _ in 1..ATTEMPTS {
            let is_lost = finished.output.is_empty();
            if !(is_lost && finished.errors.contains("wine client error")) {
                break;
            }
            finished = attempt();
        }
        finished
    }
}
