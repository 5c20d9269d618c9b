//! The runner beside `SimPy` and `NeXosim`: five stations with exponential services, buffers of
//! three, blocking after service, a source that is never empty, no log.
//!
//! Every row is a process of its own. Its processor time is that beyond a run of one part, so that
//! the start of the process and the building of libraries do not count; its memory is the peak. The
//! rows take turns, and each figure is a median. The two rows by which lines of different size are
//! compared follow one another, and their ratio is that of the same round. A peer that is missing
//! is skipped: `SimPy` is a package of the Python that `LINEWRIGHT_PYTHON` names, and `NeXosim` is
//! built by cargo from `peers/line/nexosim`.
//!
//!     cargo bench --bench line

#[path = "../line/models.rs"]
#[expect(dead_code, reason = "the tests need more of it")]
mod models;

#[cfg(unix)]
#[path = "peers/measure.rs"]
#[allow(
    dead_code,
    reason = "the bench of peers also looks at how another tool ends"
)]
mod measure;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    match arguments.split_first() {
        Some((first, rest)) if first == measure::ARGUMENT => measure::stand_between(rest),
        Some((first, rest)) if first == rows::CONTROLLERS => rows::controllers(rest),
        _ => rows::main(),
    }
}

#[cfg(not(unix))]
fn main() {
    println!("line: not measured, the system's account of a process is asked for in Unix's way");
}

#[cfg(unix)]
mod rows {
    use super::measure::{self, End};
    use super::models::{Builder, Exponential};
    use linewright::line::Options;
    use std::ffi::OsString;
    use std::fmt::Write as _;
    use std::path::{Path, PathBuf};
    use std::process::{Command, ExitCode, Stdio};
    use std::time::Duration;

    /// First argument of the process that runs the line with controllers in memory.
    pub const CONTROLLERS: &str = "--controllers";

    /// Number of measurements of each row.
    const ROUNDS: usize = 9;

    /// A row of the table.
    struct Row {
        name: &'static str,
        /// The command; the number of parts follows.
        command: Vec<OsString>,
        parts: u64,
        /// Whether the last line of the output is a number of events, or contains it as JSON.
        tells_events: bool,
    }

    /// What a row has cost.
    struct Cost {
        /// Processor seconds beyond those of one part, and events.
        seconds: f64,
        events: Option<f64>,
        mebibytes: f64,
    }

    /// The line with controllers in this process that do nothing but draw the time.
    pub fn controllers(arguments: &[OsString]) -> ExitCode {
        let parts = arguments.first().and_then(|count| count.to_str());
        let Some(parts) = parts.and_then(|count| count.parse().ok()) else {
            return ExitCode::FAILURE;
        };
        let mut builder = Builder::new(&["Part"]);
        builder.endless("source", "Part");
        let mut way = vec!["source".to_owned()];
        for i in 0..5 {
            if i > 0 {
                let name = format!("buffer{i}");
                builder.buffer(&name, 3);
                way.push(name);
            }
            let name = format!("station{i}");
            builder.station(&name, &["Part"], Exponential::new(&name));
            way.push(name);
        }
        builder.sink("sink");
        way.push("sink".to_owned());
        let way: Vec<&str> = way.iter().map(String::as_str).collect();
        builder.route("Part", &way);
        let options = Options {
            parts: Some(parts),
            ..Options::default()
        };
        println!("{}", builder.plant(options).run().events);
        ExitCode::SUCCESS
    }

    /// A line of this many stations with buffers of three between them.
    fn line(stations: usize, station: &str, head: &str) -> String {
        let mut text = format!("{head}line Row {{\n  part Part\n  source s: Part every 0 s\n");
        let mut way = "s".to_owned();
        for i in 0..stations {
            if i > 0 {
                let _ = writeln!(text, "  buffer b{i} capacity 3");
                let _ = write!(way, " -> b{i}");
            }
            let _ = writeln!(text, "  station m{i}{station}");
            let _ = write!(way, " -> m{i}");
        }
        let _ = writeln!(text, "  sink k\n  route Part: {way} -> k\n}}");
        text
    }

    const TIMES: &str = " { takes exponential(1 s) }";
    const MACHINE: &str = "contract Work {
  input requested: bool
  output finished: bool
  guarantee reports: always (finished <-> requested)
}
machine Press {
  action ram: Work when operation = press {
    requested = operation = press
    time 1 s
  }
  operation press: ram
  done ram.finished
}
";

    fn rows(folder: &Path) -> Vec<Row> {
        let program = |name: &str, text: &str| {
            let file = folder.join(name);
            std::fs::write(&file, text).expect("a file");
            let words: [OsString; 9] = [
                env!("CARGO_BIN_EXE_linewright").into(),
                "run".into(),
                file.into(),
                "--no-cache".into(),
                "--format".into(),
                "json".into(),
                "--out".into(),
                folder.join("libraries").into(),
                "--parts".into(),
            ];
            words.to_vec()
        };
        let own = std::env::current_exe().expect("this bench");
        let five = program("five.lw", &line(5, TIMES, ""));
        let row = |name, command, parts, tells_events| Row {
            name,
            command,
            parts,
            tells_events,
        };
        let mut rows = vec![
            row("stations by times", five.clone(), 1_000_000, true),
            row(
                "1000 stations by times",
                program("thousand.lw", &line(1000, TIMES, "")),
                2_000,
                true,
            ),
            row("stations by times, fewer parts", five, 100_000, true),
            row(
                "controllers that draw the time",
                vec![own.into(), CONTROLLERS.into()],
                300_000,
                true,
            ),
            row(
                "station libraries, constant time",
                program(
                    "libraries.lw",
                    &line(5, ": Press { perform press on Part }", MACHINE),
                ),
                300_000,
                true,
            ),
        ];
        if let Some(python) = simpy() {
            let script = peers().join("five.py");
            rows.push(row("SimPy", vec![python, script.into()], 50_000, false));
        }
        if let Some(program) = nexosim() {
            rows.push(row("NeXosim", vec![program], 300_000, false));
        }
        rows
    }

    fn peers() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/peers/line")
    }

    /// The Python that has `SimPy`.
    fn simpy() -> Option<OsString> {
        let python = std::env::var_os("LINEWRIGHT_PYTHON").unwrap_or_else(|| "python3".into());
        let mut command = Command::new(&python);
        command.args(["-c", "import simpy"]).stderr(Stdio::null());
        if command.status().is_ok_and(|status| status.success()) {
            return Some(python);
        }
        println!("skipped: SimPy, which {} does not have", python.display());
        None
    }

    /// The line for `NeXosim`, built if cargo can fetch what it needs.
    fn nexosim() -> Option<OsString> {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("nexosim");
        let built = Command::new(env!("CARGO"))
            .args([
                "build",
                "--release",
                "--locked",
                "--quiet",
                "--manifest-path",
            ])
            .arg(peers().join("nexosim/Cargo.toml"))
            .arg("--target-dir")
            .arg(&target)
            .status();
        if built.is_ok_and(|status| status.success()) {
            return Some(target.join("release/linewright-bench-nexosim").into());
        }
        println!("skipped: NeXosim, which cargo does not build");
        None
    }

    fn measure(row: &Row, parts: u64) -> Result<measure::Run, String> {
        let mut command = row.command.clone();
        command.push(parts.to_string().into());
        let run = measure::run(&command, Duration::from_mins(5))?;
        if run.end == End::Exit(0) {
            return Ok(run);
        }
        Err(format!("{}: {:?}: {}", row.name, run.end, run.words))
    }

    /// The number of events in the output of a run.
    fn events(text: &str) -> Option<f64> {
        let text = text.trim();
        let json = || {
            let value: serde_json::Value = serde_json::from_str(text).ok()?;
            value["events"].as_f64()
        };
        text.parse().ok().or_else(json)
    }

    fn cost(row: &Row) -> Result<Cost, String> {
        let start = measure(row, 1)?;
        let run = measure(row, row.parts)?;
        let events_beyond = || Some(events(&run.text)? - events(&start.text)?);
        Ok(Cost {
            seconds: run.seconds - start.seconds,
            mebibytes: run.mebibytes,
            events: row.tells_events.then(events_beyond).flatten(),
        })
    }

    fn median(mut numbers: Vec<f64>) -> f64 {
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    }

    pub fn main() -> ExitCode {
        let folder = tempfile::tempdir().expect("a folder");
        let rows = rows(folder.path());
        // The first run builds the libraries.
        let mut costs: Vec<Vec<Cost>> = rows.iter().map(|_| Vec::new()).collect();
        for round in 0..=ROUNDS {
            for (row, costs) in rows.iter().zip(&mut costs) {
                match cost(row) {
                    Ok(_) if round == 0 => {}
                    Ok(cost) => costs.push(cost),
                    Err(why) => {
                        eprintln!("{why}");
                        return ExitCode::FAILURE;
                    }
                }
            }
        }
        println!("| | parts | parts a CPU second | events a CPU second | ns an event | peak |");
        println!("|---|---:|---:|---:|---:|---:|");
        let mut speeds = Vec::new();
        let mut of_events = Vec::new();
        for (row, costs) in rows.iter().zip(&costs) {
            let seconds = median(costs.iter().map(|cost| cost.seconds).collect());
            let mebibytes = median(costs.iter().map(|cost| cost.mebibytes).collect());
            let speed = row.parts as f64 / seconds;
            let event = costs[0].events.map(|events| seconds / events);
            let (rate, cost) = event.map_or((String::new(), String::new()), |event| {
                (
                    format!("{:.2} M", 1e-6 / event),
                    format!("{:.0}", event * 1e9),
                )
            });
            println!(
                "| {} | {} | {speed:.0} | {rate} | {cost} | {mebibytes:.0} MiB |",
                row.name, row.parts
            );
            speeds.push((row.name, speed));
            let of_rounds: Vec<f64> = costs
                .iter()
                .filter_map(|cost| Some(cost.seconds / cost.events?))
                .collect();
            of_events.push((row.name, of_rounds));
        }
        let first = speeds[0].1;
        let ratios: Vec<String> = speeds
            .iter()
            .filter(|(name, _)| ["SimPy", "NeXosim"].contains(name))
            .map(|(name, speed)| format!("{:.1} times as fast as {name}", first / speed))
            .collect();
        if !ratios.is_empty() {
            println!("\nStations by times are {}.", ratios.join(" and "));
        }
        let of = |wanted: &str| of_events.iter().find(|(name, _)| *name == wanted);
        if let (Some((_, five)), Some((_, thousand))) =
            (of("stations by times"), of("1000 stations by times"))
            && !five.is_empty()
            && five.len() == thousand.len()
        {
            let rounds = thousand.iter().zip(five);
            let mut ratios: Vec<f64> = rounds.map(|(thousand, five)| thousand / five).collect();
            ratios.sort_by(f64::total_cmp);
            println!(
                "An event of 1000 stations costs {:.2} times one of five ({:.2} to {:.2} in {ROUNDS} rounds).",
                median(ratios.clone()),
                ratios[0],
                ratios[ratios.len() - 1]
            );
        }
        ExitCode::SUCCESS
    }
}
