//! A folder with copies of the cases, and the program run in it.

use crate::support::{PROGRAM, documents, root};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A new folder with `tests/cases/cli` and `tests/cases/line` in it, so that all paths are relative
/// and short.
pub struct Session {
    folder: tempfile::TempDir,
}

/// Output and exit code of a command.
pub struct Printed {
    pub code: i32,
    pub out: String,
    pub err: String,
    command: String,
}

impl Session {
    pub fn new() -> Self {
        let session = Self {
            folder: tempfile::tempdir().expect("a folder"),
        };
        for stage in ["cli", "line"] {
            let cases = std::fs::read_dir(root().join("tests/cases").join(stage));
            for entry in cases.expect("cases") {
                let entry = entry.expect("an entry");
                if entry.path().is_dir() {
                    continue; // Snapshots.
                }
                std::fs::copy(
                    entry.path(),
                    session.path(&entry.file_name().to_string_lossy()),
                )
                .expect("a copy");
            }
        }
        session
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Replaces a text in a file, which must contain it.
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.path(name)).expect("a text");
        assert!(text.contains(from), "{name} holds {from}");
        std::fs::write(self.path(name), text.replace(from, to)).expect("a file");
    }

    /// The program as a command, without environment variables for compilers or colors.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(line.split_whitespace());
        command.current_dir(self.folder());
        for (name, _) in std::env::vars_os() {
            let text = name.to_string_lossy();
            let text = text
                .trim_start_matches("HOST_")
                .trim_start_matches("TARGET_");
            if text.starts_with("CC") || text.starts_with("CFLAGS") {
                command.env_remove(&name);
            }
        }
        command.env_remove("CLICOLOR_FORCE").env("NO_COLOR", "1");
        command.env("LINEWRIGHT_CACHE", "off");
        command
    }

    pub fn run(&self, line: &str) -> Printed {
        self.run_with(line, &[])
    }

    /// Runs the program with environment variables. Documents that it prints have to be as their
    /// schemas say.
    pub fn run_with(&self, line: &str, environment: &[(&str, &str)]) -> Printed {
        let mut command = self.command(line);
        command.envs(environment.iter().copied());
        let output = command.output().expect("the program starts");
        documents::assert_valid(&output.stdout);
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let variables = environment.iter().map(|(n, v)| format!("{n}={v} "));
        Printed {
            code: output.status.code().expect("an exit code"),
            out: text(output.stdout),
            err: text(output.stderr),
            command: variables.collect::<String>() + "linewright " + line,
        }
    }

    /// A `PATH` in which the compiler is a program that records that it was started, and fails.
    pub fn failing_compiler(&self) -> String {
        let folder = self.path("failing");
        std::fs::create_dir_all(&folder).expect("a folder");
        for name in ["cc", "gcc", "clang"] {
            let file = folder.join(name);
            let log = self.path("compiler.log");
            let script = format!(
                "#!/bin/sh\necho started >> '{}'\necho 'no compiling today' >&2\nexit 1\n",
                log.display()
            );
            std::fs::write(&file, script).expect("a file");
            make_executable(&file);
        }
        let path = std::env::var("PATH").unwrap_or_default();
        format!("{}:{path}", folder.display())
    }

    /// Whether that compiler was started.
    pub fn compiler_was_started(&self) -> bool {
        self.path("compiler.log").exists()
    }

    /// Every file and folder below this one with its content, including hidden ones.
    pub fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        fn visit(folder: &Path, top: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
            for entry in std::fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                let name = path.strip_prefix(top).expect("below").display().to_string();
                if path.is_dir() {
                    found.insert(name + "/", Vec::new());
                    visit(&path, top, found);
                } else {
                    found.insert(name, std::fs::read(&path).expect("a file"));
                }
            }
        }
        let mut found = BTreeMap::new();
        visit(self.folder(), self.folder(), &mut found);
        found
    }

    /// The one library in a folder.
    pub fn library(&self, folder: &str) -> PathBuf {
        let ending = std::env::consts::DLL_EXTENSION;
        let mut found: Vec<PathBuf> = std::fs::read_dir(self.path(folder))
            .expect("a folder")
            .map(|e| e.expect("an entry").path())
            .filter(|p| p.extension().is_some_and(|e| e == ending))
            .collect();
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    }
}

#[cfg(unix)]
fn make_executable(path: &Path) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).expect("permissions");
}

#[cfg(not(unix))]
fn make_executable(_: &Path) {}

impl Printed {
    /// Command, exit code and both streams, as a snapshot shows them.
    pub fn shown(&self) -> String {
        let mut text = format!("$ {}\nexit code {}\n", self.command, self.code);
        for (name, stream) in [
            ("standard output", &self.out),
            ("standard error", &self.err),
        ] {
            if !stream.is_empty() {
                let _ = write!(text, "--- {name}\n{stream}");
            }
        }
        text
    }
}

/// Compares with a snapshot, without what differs between computers.
macro_rules! assert_shown {
    ($name:expr, $printed:expr) => {
        insta::with_settings!({filters => vec![
            (r"-[0-9a-f]{16}\.(so|dylib|dll|json)", "-[hash].$1"),
            (r"instead of \d+", "instead of [length]"),
            (r" \(os error \d+\)", ""),
        ]}, {
            insta::assert_snapshot!($name, $printed.shown());
        })
    };
}
pub(crate) use assert_shown;
