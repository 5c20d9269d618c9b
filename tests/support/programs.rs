//! Runs other programs with a time limit.

use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Output of a program, and whether it succeeded.
#[derive(Debug)]
pub struct Finished {
    /// Standard output, with lines that end in `\n`.
    pub output: String,
    /// Standard error.
    pub errors: String,
    /// Whether it ended by itself with exit code 0.
    pub success: bool,
}

impl Finished {
    /// The last non-empty line.
    pub fn last_line(&self) -> &str {
        let mut lines = self.output.lines().rev();
        lines
            .find(|l| !l.trim().is_empty())
            .unwrap_or_default()
            .trim()
    }

    /// All of its output.
    pub fn all(&self) -> String {
        format!("{}{}", self.output, self.errors)
    }
}

/// Runs a command with an option that writes a page, and returns the path of the page.
pub fn page(folder: &Path, name: &str, arguments: &[&str]) -> PathBuf {
    let path = folder.join(format!("{name}.html"));
    let run = run(
        Command::new(super::PROGRAM)
            .args(arguments)
            .arg(&path)
            .current_dir(folder),
        Duration::from_mins(10),
    );
    assert!(path.is_file(), "{}", run.all());
    path
}

/// Runs a program; it is terminated when it takes too long, which is noted in its errors.
pub fn run(command: &mut Command, patience: Duration) -> Finished {
    // Files, not pipes: a process left running by the program (Wine's server) would keep a pipe
    // open.
    let mut files = [(); 2].map(|()| tempfile::tempfile().expect("a file"));
    let [output, errors] = files.each_ref().map(|f| f.try_clone().expect("a file"));
    let child = command
        .stdin(Stdio::null())
        .stdout(output)
        .stderr(errors)
        .spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) => {
            return Finished {
                output: String::new(),
                errors: format!(
                    "{} cannot be started: {error}",
                    command.get_program().display()
                ),
                success: false,
            };
        }
    };
    let begin = Instant::now();
    let mut ended = None;
    while ended.is_none() && begin.elapsed() < patience {
        ended = child.try_wait().expect("the program can be waited for");
        std::thread::sleep(Duration::from_millis(5));
    }
    if ended.is_none() {
        let _ = child.kill();
        let _ = child.wait();
    }
    let [output, mut errors] = files.each_mut().map(text);
    if ended.is_none() {
        errors.extend(["\nended after ".to_owned(), format!("{patience:?}")]);
    }
    Finished {
        output: output.replace("\r\n", "\n"),
        errors,
        success: ended.is_some_and(|status| status.success()),
    }
}

fn text(file: &mut File) -> String {
    let mut bytes = Vec::new();
    file.rewind().expect("a file");
    file.read_to_end(&mut bytes).expect("a file");
    String::from_utf8_lossy(&bytes).into_owned()
}
