//! One run of a program as a process: processor time, memory, and output.
//!
//! The system accumulates the cost of a process's children, and keeps the largest memory of any of
//! them, not per child. So every run gets an intermediate process, this bench started again, which
//! has only that child, waits for it or kills it when the time is up, and then queries the system.
//! This is safe code on every Unix, as exact as the system's accounting, and includes everything
//! that the program itself started and waited for.

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::{TimeVal, TimeValLike as _};
use std::ffi::OsString;
use std::io::Write as _;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// First argument of the intermediate process.
pub const ARGUMENT: &str = "--measure";

/// Beginning of its last line.
const REPORT: &str = "measured:";

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// By itself, with this exit code.
    Exit(i32),
    /// By a signal not sent by this bench.
    Killed,
    /// The time was up.
    TimedOut,
}

/// Cost of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    pub end: End,
    /// User and system time, including children.
    pub seconds: f64,
    /// Seconds by the clock.
    pub elapsed: f64,
    /// Peak resident memory in MiB. At least that of the intermediate process, about 2 MiB.
    pub mebibytes: f64,
    /// Standard output.
    pub text: String,
    /// Standard error.
    pub words: String,
}

/// Runs a program with a wall-clock limit.
pub fn run(program: &[OsString], limit: Duration) -> Result<Run, String> {
    let shown = program[0].display();
    let own = std::env::current_exe().map_err(|e| format!("this bench is not found: {e}"))?;
    let output = Command::new(own)
        .arg(ARGUMENT)
        .arg(limit.as_secs_f64().to_string())
        .args(program)
        .stdin(Stdio::null())
        .output()
        .map_err(|e| format!("{shown}: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let words = String::from_utf8_lossy(&output.stderr);
    let (said, report) = text
        .rsplit_once(REPORT)
        .ok_or_else(|| format!("{shown} was not measured: {}", words.trim()))?;
    let report: Vec<&str> = report.split_whitespace().collect();
    let number = |i: usize| report.get(i).and_then(|w| w.parse::<f64>().ok());
    let (Some(seconds), Some(elapsed), Some(mebibytes), Some(end)) =
        (number(0), number(1), number(2), report.get(3))
    else {
        return Err(format!("{shown}: a report that cannot be read: {report:?}"));
    };
    let end = match *end {
        "timeout" => End::TimedOut,
        "killed" => End::Killed,
        code => End::Exit(code.parse().map_err(|e| format!("{shown}: {e}"))?),
    };
    Ok(Run {
        end,
        seconds,
        elapsed,
        mebibytes,
        text: said.to_owned(),
        words: words.into_owned(),
    })
}

/// The intermediate process: `--measure SECONDS PROGRAM ARGUMENT...`
pub fn stand_between(arguments: &[OsString]) -> ExitCode {
    match measure(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn measure(arguments: &[OsString]) -> Result<(), String> {
    let [limit, program, rest @ ..] = arguments else {
        return Err("a limit and a program are needed".to_owned());
    };
    let limit = limit.to_str().and_then(|l| l.parse::<f64>().ok());
    let limit = Duration::from_secs_f64(limit.ok_or("the limit is no number")?);
    let begin = Instant::now();
    let mut child = Command::new(program)
        .args(rest)
        .spawn()
        .map_err(|e| e.to_string())?;
    // Polling costs this process some time, but not the child.
    let mut pause = Duration::from_micros(500);
    let end = loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            break status
                .code()
                .map_or("killed".to_owned(), |code| code.to_string());
        }
        if begin.elapsed() > limit {
            child.kill().map_err(|e| e.to_string())?;
            child.wait().map_err(|e| e.to_string())?;
            break "timeout".to_owned();
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(20));
    };
    let elapsed = begin.elapsed().as_secs_f64();
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).map_err(|e| e.to_string())?;
    let seconds = |time: TimeVal| time.num_microseconds() as f64 / 1e6;
    let seconds = seconds(usage.user_time()) + seconds(usage.system_time());
    // Linux reports KiB, macOS bytes.
    let unit = if cfg!(target_os = "macos") {
        1.0
    } else {
        1024.0
    };
    let mebibytes = usage.max_rss() as f64 * unit / f64::from(1 << 20);
    let mut out = std::io::stdout();
    writeln!(out, "\n{REPORT} {seconds} {elapsed} {mebibytes} {end}").map_err(|e| e.to_string())
}
