//! Programs that are tried: started with a deadline, and compilers with a line of C.

use super::compiler::Compiler;
use linewright_core::deadline::{Deadline, StopReason};
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

/// A program that says nothing for so long hangs. Zig needs its time when it runs first.
const PATIENCE: Duration = Duration::from_mins(1);

/// How a program that has ended answered.
pub(super) struct Answer {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Answer {
    /// The first line of a text that is not empty.
    pub fn first_line(text: &str) -> Option<String> {
        let line = text.lines().find(|l| !l.trim().is_empty())?;
        Some(line.trim().to_owned())
    }
}

/// Runs a program to its end; an error says why there is no answer. One that does not end is ended.
pub(super) fn answer(command: &mut Command) -> Result<Answer, String> {
    let answer = answer_until(command, Deadline::in_time(PATIENCE)).map_err(|e| e.to_string())?;
    answer.map_err(|_| format!("it did not answer within {} s", PATIENCE.as_secs()))
}

/// Runs a program to its end, or ends it when the deadline is past.
pub(super) fn answer_until(
    command: &mut Command,
    deadline: Deadline,
) -> std::io::Result<Result<Answer, StopReason>> {
    // Files rather than pipes: what a program leaves running cannot hold them open for us.
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
        if let Err(late) = deadline.check() {
            // It may have ended at this very moment; then there is nothing to end.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(Err(late));
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

/// Lets a compiler compile a line; an error says why it does not.
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
    // It may be tried by another compiler next.
    let _ = std::fs::remove_file(&object);
    if length == 0 {
        return Err("it made nothing".to_owned());
    }
    Ok(())
}
