//! What must stay within bounds: inputs that once made a command run for minutes or fill the
//! memory, with the time and the memory that each may take.
//!
//! Every row is a whole process, with user and system time and peak resident memory, and without
//! the cache unless the row is about it. A row that takes more than its bound is marked; the last
//! line counts them.
//!
//!     cargo bench --bench bounds

#[cfg(unix)]
#[path = "families/mod.rs"]
mod families;
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
        _ => bounds::main(),
    }
}

#[cfg(not(unix))]
fn main() {
    println!("bounds: not measured, the system's account of a process is asked for in Unix's way");
}

#[cfg(unix)]
mod bounds {
    use super::families::anzu::{amba, genbuf};
    use super::families::arithmetic::{Task, elevator, robot_arm};
    use super::families::formula::Format;
    use super::measure::{self, End};
    use std::ffi::OsString;
    use std::fmt::Write as _;
    use std::io::{BufRead as _, BufReader};
    use std::path::{Path, PathBuf};
    use std::process::{Command, ExitCode, Stdio};
    use std::time::{Duration, Instant};

    const WITHOUT_CACHE: &str = "--no-cache";

    /// A command, and what it may take.
    struct Case {
        name: &'static str,
        arguments: Vec<OsString>,
        seconds: f64,
        mebibytes: f64,
        exit: i32,
    }

    /// Types of records of records, each with two members of the type before it.
    fn nested_records(levels: usize) -> String {
        let mut text = "type R0 = record {a: bool, b: bool}\n".to_owned();
        for i in 1..=levels {
            let _ = writeln!(text, "type R{i} = record {{a: R{0}, b: R{0}}}", i - 1);
        }
        let _ = writeln!(
            text,
            "contract Deep {{ input x: R{levels}\n output y: bool\n guarantee always y }}"
        );
        text
    }

    /// A contract with many inputs whose names differ in a number.
    fn similar_names(inputs: usize) -> String {
        let mut text = "contract Many {\n".to_owned();
        for i in 0..inputs {
            let _ = writeln!(text, "  input signal_{i}: bool");
        }
        text + "  output y: bool\n  guarantee always y\n}\n"
    }

    /// A contract whose inputs have types that are misspelt, each of another type.
    fn misspelt_names(types: usize) -> String {
        let mut text = String::new();
        for i in 0..types {
            let _ = writeln!(text, "type Signal{i}Kind = {{on{i}, off{i}}}");
        }
        text += "contract Misspelt {\n";
        for i in 0..types {
            let _ = writeln!(text, "  input x{i}: Signol{i}Kind");
        }
        text + "  output y: bool\n  guarantee always y\n}\n"
    }

    /// A contract that says the same many times.
    fn repeated_guarantees(count: usize) -> String {
        let repeated = "  guarantee always y\n".repeat(count);
        format!("contract Long {{\n  output y: bool\n{repeated}}}\n")
    }

    struct Folder {
        path: tempfile::TempDir,
    }

    impl Folder {
        fn write(&self, name: &str, text: &str) -> PathBuf {
            let path = self.path.path().join(name);
            std::fs::write(&path, text).expect("the file is written");
            path
        }

        /// A case whose command ends with a file.
        fn case(
            &self,
            name: &'static str,
            options: &str,
            file: &Path,
            (seconds, mebibytes, exit): (f64, f64, i32),
        ) -> Case {
            let out = self.path.path().join("out");
            let options = options.split_whitespace().map(|word| match word {
                "OUT" => out.clone().into(),
                word => word.into(),
            });
            Case {
                name,
                arguments: options.chain([file.into()]).collect(),
                seconds,
                mebibytes,
                exit,
            }
        }
    }

    fn cases(folder: &Folder) -> Vec<Case> {
        let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/ice-lab");
        let line = examples.join("line.lw");
        let deep = folder.write("deep.lw", &nested_records(20));
        let deeper = folder.write("deeper.lw", &nested_records(24));
        let many = folder.write("many.lw", &similar_names(10_000));
        let misspelt = folder.write("misspelt.lw", &misspelt_names(5_000));
        let lost = folder.write("elevator.spectra", &elevator(4, 1, Some(19)));
        let genbuf7 = folder.write("genbuf7.slugsin", &genbuf(7, Format::Slugsin));
        let genbuf40 = folder.write("genbuf40.slugsin", &genbuf(40, Format::Slugsin));
        let genbuf200 = folder.write("genbuf200.slugsin", &genbuf(200, Format::Slugsin));
        let long = folder.write("long.lw", &repeated_guarantees(200_000));
        let sum = folder.write("sum.spectra", &robot_arm(5, 16, Task::Sum, false));
        let amba8 = folder.write("amba8.slugsin", &amba(8, Format::Slugsin));
        let amba15 = folder.write("amba15.slugsin", &amba(15, Format::Slugsin));
        let [
            anew,
            verdict,
            bounded,
            small,
            smaller,
            written,
            written_small,
        ] = [
            "check",
            "check --verdict-only",
            "check --memory 200 --timeout 3",
            "check --memory 100",
            "check --memory 50",
            "synth --emit c --out OUT",
            "synth --emit c --out OUT --memory 200",
        ]
        .map(|command| format!("{command} {WITHOUT_CACHE}"));
        let mut cases = vec![
            folder.case("records, 20 levels", &bounded, &deep, (3.0, 200.0, 1)),
            folder.case("records, 24 levels", &bounded, &deeper, (3.0, 200.0, 1)),
            folder.case("10,000 similar names", &bounded, &many, (3.0, 200.0, 0)),
            folder.case("5,000 misspelt names", &bounded, &misspelt, (3.0, 200.0, 1)),
            folder.case("200,000 lines, 100 MiB", &small, &long, (3.0, 110.0, 3)),
            folder.case("genbuf200, 50 MiB", &smaller, &genbuf200, (10.0, 60.0, 3)),
            folder.case("arm, C, 200 MiB", &written_small, &sum, (20.0, 220.0, 3)),
            folder.case("genbuf200, verdict", &verdict, &genbuf200, (40.0, 800.0, 0)),
            folder.case("amba15, verdict", &verdict, &amba15, (40.0, 800.0, 0)),
            folder.case("genbuf7, C", &written, &genbuf7, (0.5, 100.0, 0)),
            folder.case("genbuf40, C", &written, &genbuf40, (6.0, 200.0, 0)),
            folder.case("amba8, C", &written, &amba8, (20.0, 300.0, 0)),
            folder.case("elevator, verdict", &verdict, &lost, (0.5, 100.0, 1)),
            folder.case("elevator, explained", &anew, &lost, (60.0, 500.0, 1)),
            folder.case(
                "holistic cell",
                &anew,
                &examples.join("holistic.lw"),
                (1.4, 100.0, 0),
            ),
            folder.case("laboratory's line", "check", &line, (2.0, 200.0, 0)),
            folder.case("... again, cached", "check", &line, (0.2, 100.0, 0)),
        ];
        // A published file whose controller is too large to be listed.
        let sort = specifications().join("syntech15/ColorSortLTL3_679_ColorSort_fixed.spectra");
        if sort.is_file() {
            let options = format!("synth --emit json {WITHOUT_CACHE}");
            cases.push(folder.case("ColorSort 679, JSON", &options, &sort, (5.0, 100.0, 0)));
        } else {
            println!("not measured: ColorSort, which LINEWRIGHT_SPECS does not contain\n");
        }
        cases
    }

    /// The folder of published specifications.
    fn specifications() -> PathBuf {
        std::env::var_os("LINEWRIGHT_SPECS").map_or_else(
            || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bench/specs"),
            PathBuf::from,
        )
    }

    /// The seconds by the clock until `check` tells that the file is unrealizable.
    fn until_verdict(options: &[&str], file: &Path) -> std::io::Result<f64> {
        let begin = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_linewright"))
            .args(["check", WITHOUT_CACHE])
            .args(options)
            .arg(file)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let stderr = child.stderr.take().expect("a pipe");
        let mut lines = BufReader::new(stderr).lines();
        let told = lines.find(|line| line.as_ref().map_or(true, |l| l.contains("unrealizable")));
        // Without a verdict there, the command has ended.
        told.transpose()?;
        let seconds = begin.elapsed().as_secs_f64();
        child.kill()?;
        child.wait()?;
        Ok(seconds)
    }

    /// Whether a verdict waits for its explanation: the time until `check` announces it, beside
    /// that of `check --verdict-only`. The median of three runs each.
    fn announcement(folder: &Folder) -> std::io::Result<bool> {
        let lost = folder.write("elevator5.spectra", &elevator(5, 2, Some(13)));
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..3 {
            times[0].push(until_verdict(&["--verdict-only"], &lost)?);
            times[1].push(until_verdict(&[], &lost)?);
        }
        let [alone, announced] = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[1]
        });
        let is_within = announced <= 1.1 * alone;
        println!(
            "\nverdict of an elevator, by the clock: {alone:.2} s alone, {announced:.2} s before its explanation{}",
            if is_within {
                ""
            } else {
                " (exceeded: at most 10 % more)"
            }
        );
        Ok(is_within)
    }

    pub fn main() -> ExitCode {
        let folder = Folder {
            path: tempfile::tempdir().expect("a folder"),
        };
        // The rows about the cache use one of their own.
        let cache = folder.path.path().join("cache");
        let program = [
            OsString::from("env"),
            format!("LINEWRIGHT_CACHE={}", cache.display()).into(),
            env!("CARGO_BIN_EXE_linewright").into(),
        ];
        let mut exceeded = 0;
        println!("| | time | may take | by the clock | peak | may take | |");
        println!("|---|---:|---:|---:|---:|---:|---|");
        for case in cases(&folder) {
            let command: Vec<OsString> = program.iter().cloned().chain(case.arguments).collect();
            let run = match measure::run(&command, Duration::from_mins(2)) {
                Ok(run) => run,
                Err(why) => {
                    eprintln!("{}: {why}", case.name);
                    return ExitCode::FAILURE;
                }
            };
            let within = run.seconds <= case.seconds
                && run.mebibytes <= case.mebibytes
                && run.end == End::Exit(case.exit);
            exceeded += u32::from(!within);
            println!(
                "| {} | {:.2} s | {:.1} s | {:.2} s | {:.0} MiB | {:.0} MiB | {} |",
                case.name,
                run.seconds,
                case.seconds,
                run.elapsed,
                run.mebibytes,
                case.mebibytes,
                match (within, run.end) {
                    (true, _) => String::new(),
                    (false, End::Exit(code)) => format!("exceeded, exit code {code}"),
                    (false, end) => format!("exceeded, {end:?}"),
                }
            );
        }
        match announcement(&folder) {
            Ok(is_within) => exceeded += u32::from(!is_within),
            Err(why) => {
                eprintln!("the announcement of a verdict: {why}");
                return ExitCode::FAILURE;
            }
        }
        println!("\nrows out of bounds: {exceeded}");
        if exceeded == 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }
}
