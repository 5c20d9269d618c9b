//! Runs programs with a deadline, and tests compilers with a line of C.

use super::compiler::Compiler;
use linewright_core::deadline::{Deadline, StopReason};
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

/// Time after which a program that has not ended is considered hung. It is long because the first
/// run of Zig is slow.
const ANSWER_TIMEOUT: Duration = Duration::from_mins(1);

/// Output of a program that has ended.
pub(super) struct Answer {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Answer {
    /// Returns the first non-empty line of a text.
    pub fn first_line(text: &str) -> Option<String> {
        let line = text.lines().find(|l| !l.trim().is_empty())?;
        Some(line.trim().to_owned())
    }
}

/// Runs a program to its end; terminates it after [`ANSWER_TIMEOUT`].
///
/// # Errors
/// Returns the reason why there is no output.
pub(super) fn answer(command: &mut Command) -> Result<Answer, String> {
    let answer =
        answer_until(command, Deadline::from_now(ANSWER_TIMEOUT)).map_err(|e| e.to_string())?;
    answer.map_err(|_| format!("it did not answer within {} s", ANSWER_TIMEOUT.as_secs()))
}

/// Runs a program to its end, or terminates it at the deadline.
pub(super) fn answer_until(
    command: &mut Command,
    deadline: Deadline,
) -> std::io::Result<Result<Answer, StopReason>> {
    // The output goes to files instead of pipes, because a background process that the program
    // leaves behind would block reading from a pipe.
    let (mut stdout, mut stderr) = (tempfile::tempfile()?, tempfile::tempfile()?);
    let mut child = command
        .stdin(Stdio::null())
        .stdout(stdout.try_clone()?)
        .stderr(stderr.try_clone()?)
        .spawn()?;
    let mut pause = Duration::from_millis(1);
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if let Err(reason) = deadline.check() {
            // Errors are ignored: the program can have ended in the meantime.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(Err(reason));
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(20));
    };
    let text = |file: &mut std::fs::File| {
        let mut bytes = Vec::new();
        file.rewind()?;
        file.take(1 << 20).read_to_end(&mut bytes)?;
        Ok::<_, std::io::Error>(String::from_utf8_lossy(&bytes).into_owned())
    };
    Ok(Ok(Answer {
        status,
        stdout: text(&mut stdout)?,
        stderr: text(&mut stderr)?,
    }))
}

/// Whether Ctrl-C ended a program.
pub fn was_interrupted(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        const SIGINT: i32 = 2;
        std::os::unix::process::ExitStatusExt::signal(&status) == Some(SIGINT)
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// Tests whether a compiler can compile a line of C.
///
/// # Errors
/// Returns the reason why it cannot.
pub(super) fn compiles(compiler: &Compiler, work: &Path) -> Result<(), String> {
    let (source, object) = ("trial.c", work.join("trial.o"));
    std::fs::write(work.join(source), "int lw_trial(void) { return 0; }\n")
        .map_err(|e| e.to_string())?;
    let mut command = compiler.command();
    command
        .args(["-c", source, "-o", "trial.o"])
        .current_dir(work);
    let answer = answer(&mut command)?;
    let why = || Answer::first_line(&answer.stderr).unwrap_or_else(|| answer.status.to_string());
    if !answer.status.success() {
        return Err(why());
    }
    let length = std::fs::metadata(&object).map_or(0, |m| m.len());
    // The file is removed because the next compiler uses the same file name.
    let _ = std::fs::remove_file(&object);
    if length == 0 {
        return Err("it wrote no object file".to_owned());
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_ctrl_c_interrupts() {
        let status = |script: &str| {
            let mut command = Command::new("sh");
            command.args(["-c", script]);
            let answer = answer_until(&mut command, Deadline::NONE).expect("it starts");
            was_interrupted(answer.expect("no deadline").status)
        };
        assert!(status("kill -INT $$"));
        assert!(!status("kill -TERM $$"));
        assert!(!status("exit 2"));
        assert!(!status("exit 0"));
    }
}
