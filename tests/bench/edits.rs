//! What the cache is worth while somebody edits: a check of a specification that is not in the
//! cache, but was before an edit, beside a check without a cache.
//!
//! The cache keeps the last variable order of each large contract, and its winning region. A check
//! begins with that order, even if variables were added, and with the region if the edit cannot
//! have made it larger. Every figure is of a whole process, user and system time, the fastest of
//! three runs.
//!
//!     cargo bench --bench edits

#[cfg(unix)]
#[path = "families/mod.rs"]
mod families;
#[cfg(unix)]
#[path = "peers/measure.rs"]
#[allow(dead_code, reason = "other benches look at memory and output")]
mod measure;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    match arguments.split_first() {
        Some((first, rest)) if first == measure::ARGUMENT => measure::stand_between(rest),
        _ => edits::main(),
    }
}

#[cfg(not(unix))]
fn main() {
    println!("edits: not measured, the system's account of a process is asked for in Unix's way");
}

#[cfg(unix)]
mod edits {
    use super::families::anzu::{amba, genbuf};
    use super::families::arithmetic::{Task, ahb, elevator, robot_arm};
    use super::families::formula::Format;
    use super::measure::{self, End};
    use std::ffi::OsString;
    use std::path::Path;
    use std::process::ExitCode;
    use std::time::Duration;

    const RUNS: usize = 3;

    /// An edit of a specification.
    struct Edit {
        name: &'static str,
        apply: fn(&str) -> String,
    }

    const EDITS: [Edit; 4] = [
        Edit {
            name: "a comment",
            apply: |text| format!("{text}\n// Reviewed.\n"),
        },
        Edit {
            name: "a rule less",
            apply: without_last_guarantee,
        },
        Edit {
            name: "a rule more",
            apply: |text| format!("{text}\ngar GF TRUE;\n"),
        },
        Edit {
            name: "a variable more",
            apply: |text| format!("{text}\nsys boolean edited;\ngar GF edited;\n"),
        },
    ];

    /// Removes the last guarantee that is a line of its own.
    fn without_last_guarantee(text: &str) -> String {
        let is_guarantee = |line: &&str| {
            (line.starts_with("gar ") || line.starts_with("guarantee ")) && line.ends_with(';')
        };
        let lines: Vec<&str> = text.lines().collect();
        let last = lines.iter().rposition(is_guarantee).expect("a guarantee");
        [&lines[..last], &lines[last + 1..]].concat().join("\n") + "\n"
    }

    fn specifications() -> Vec<(&'static str, String)> {
        vec![
            ("genbuf40", genbuf(40, Format::Spectra)),
            ("genbuf100", genbuf(100, Format::Spectra)),
            ("amba8", amba(8, Format::Spectra)),
            ("amba11", amba(11, Format::Spectra)),
            ("ahb-8", ahb(8, false)),
            ("arm-sum-16", robot_arm(5, 16, Task::Sum, false)),
            ("arm-product-12", robot_arm(5, 12, Task::Product, false)),
            ("elevator-5-1-26", elevator(5, 1, Some(26))),
            ("elevator-24-3", elevator(24, 3, None)),
        ]
    }

    /// A check of a file with a cache in a folder. Returns its seconds and its exit code.
    fn check(file: &Path, cache: &Path) -> Result<(f64, End), String> {
        let command: [OsString; 6] = [
            "env".into(),
            format!("LINEWRIGHT_CACHE={}", cache.display()).into(),
            env!("CARGO_BIN_EXE_linewright").into(),
            "check".into(),
            "--verdict-only".into(),
            file.into(),
        ];
        let run = measure::run(&command, Duration::from_mins(2))?;
        Ok((run.seconds, run.end))
    }

    /// The fastest of some checks of `text`, each with a new cache that knows at most `before`.
    fn fastest(before: Option<&str>, text: &str) -> Result<(f64, End), String> {
        let mut best: Option<(f64, End)> = None;
        for _ in 0..RUNS {
            let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
            let (file, cache) = (
                folder.path().join("edited.spectra"),
                folder.path().join("cache"),
            );
            let write = |text: &str| std::fs::write(&file, text).map_err(|e| e.to_string());
            if let Some(before) = before {
                write(before)?;
                check(&file, &cache)?;
            }
            write(text)?;
            let (seconds, end) = check(&file, &cache)?;
            if best.is_none_or(|(least, _)| seconds < least) {
                best = Some((seconds, end));
            }
        }
        best.ok_or_else(|| "no run".to_owned())
    }

    fn table() -> Result<bool, String> {
        println!("| | edit | without | after the check before | worth |");
        println!("|---|---|---:|---:|---:|");
        let mut equal = true;
        for (name, text) in specifications() {
            for edit in &EDITS {
                let edited = (edit.apply)(&text);
                let (anew, verdict) = fastest(None, &edited)?;
                let (known, again) = fastest(Some(&text), &edited)?;
                println!(
                    "| {name} | {} | {anew:.2} s | {known:.2} s | {:.1} |{}",
                    edit.name,
                    anew / known,
                    if verdict == again {
                        ""
                    } else {
                        " another verdict"
                    }
                );
                equal &= verdict == again;
            }
        }
        Ok(equal)
    }

    pub fn main() -> ExitCode {
        match table() {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(why) => {
                eprintln!("{why}");
                ExitCode::FAILURE
            }
        }
    }
}
