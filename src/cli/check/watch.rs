//! `check --watch`: checks again whenever a file has changed, until Ctrl-C.
//!
//! Unchanged contracts are not solved again. If a contract is still at the same place, its result
//! comes from the previous check; if it has moved within its file, from the cache. If the user
//! disabled the cache, a temporary one is used during the watch. Ctrl-C ends the watch normally,
//! with the exit code of the last completed check.

mod file_watcher;

use super::{Arguments, CheckResult, check, load, write};
use crate::cli::exit::ExitCode;
use crate::cli::interrupt;
use crate::cli::options::{Format, GlobalOptions};
use crate::engine::cache::Cache;
use crate::engine::files::StandardLibrary;
use crate::engine::pipeline::Memory;
use crate::source::SourceMap;
use anyhow::Context as _;
use file_watcher::{Change, FileWatcher};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The reason for a check, as a part of the JSON document of the check.
#[derive(Debug, JsonSchema, Serialize)]
pub(super) struct Trigger {
    /// Changes since the previous check; empty for the first check.
    changes: Vec<Change>,
    /// Start time, in seconds since 1970 (UTC).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    unix_seconds: Option<f64>,
}

impl Trigger {
    fn now(changes: Vec<Change>, timing: bool) -> Self {
        let now = || SystemTime::now().duration_since(UNIX_EPOCH).ok();
        let unix_seconds = now().filter(|_| timing).map(|t| t.as_secs_f64());
        Self {
            changes,
            unix_seconds,
        }
    }

    /// Formats the trigger: `[08:15:00 UTC] turn.lw has changed, lamp.lw is new`. Empty for the
    /// first check.
    fn line(&self) -> String {
        if self.changes.is_empty() {
            return String::new();
        }
        let changes: Vec<String> = self.changes.iter().map(Change::to_string).collect();
        let clock = self.unix_seconds.map(|s| {
            let of_day = s as u64 % 86_400;
            let (hours, minutes) = (of_day / 3600, of_day / 60 % 60);
            format!("[{hours:02}:{minutes:02}:{:02} UTC] ", of_day % 60)
        });
        format!("{}{}\n", clock.unwrap_or_default(), changes.join(", "))
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if options.format == Format::Sarif {
        anyhow::bail!(
            "a SARIF document can hold only one check: leave out --watch, or use it with `--format json`"
        );
    }
    let console = options.console();
    let standard = StandardLibrary::new(options.library.clone());
    let mut watcher = FileWatcher::new(&arguments.paths, standard.clone());
    let mut memory = Memory::default();
    let own = tempfile::tempdir().context("cannot create a temporary folder")?;
    let mut code = None;
    let mut changes = watcher.scan();
    changes.clear();
    loop {
        let occasion = Trigger::now(changes, !options.no_timing);
        // Each check has the full time limit.
        let mut settings = options.settings();
        settings.limits = options.limits_from(Instant::now());
        settings
            .cache
            .get_or_insert_with(|| Cache::in_folder(own.path()));
        let mut checked = check(
            load(arguments, options),
            arguments,
            options,
            &settings,
            Some(&mut memory),
        )?;
        if interrupt::take() {
            return Ok(code.unwrap_or(ExitCode::GaveUp));
        }
        let line = occasion.line();
        checked.document.occasion = Some(occasion);
        if !console.part(&line_for(options.format, &line))? || !write(console, &checked, options)? {
            return Ok(checked.code);
        }
        if code.replace(checked.code).is_none() && options.format != Format::Json {
            console.remark("Watching for changes; stop with Ctrl-C.\n")?;
        }
        watcher.set_imports(&read_files(&checked, &standard));
        let Some(found) = watcher.wait(interrupt::interrupted) else {
            interrupt::take();
            return Ok(checked.code);
        };
        changes = found;
    }
}

/// Formats a trigger's line for printing before a check; human output has blank lines around it.
/// Empty for JSON, where the trigger is a part of the document.
fn line_for(format: Format, line: &str) -> String {
    match format {
        Format::Human if !line.is_empty() => format!("\n\u{1b}[1m{line}\u{1b}[0m\n"),
        Format::Human | Format::Short => line.to_owned(),
        Format::Json | Format::Sarif => String::new(),
    }
}

/// Paths of all files that a check has read, with their texts, and of imports that could not be
/// read.
fn read_files<'a>(
    checked: &'a CheckResult,
    standard: &StandardLibrary,
) -> Vec<(PathBuf, Option<&'a str>)> {
    let loaded = &checked.loaded;
    let sources: &SourceMap = &loaded.library.sources;
    // Bundled files do not exist on disk.
    let is_on_disk = |name: &str| !name.starts_with("std/") || standard.disk_path(name).exists();
    let read = sources
        .files()
        .filter(|(_, file)| is_on_disk(&file.name))
        .map(|(_, file)| (standard.disk_path(&file.name), Some(&*file.text)));
    let missing = loaded
        .missing
        .iter()
        .map(|name| (standard.disk_path(name), None));
    read.chain(missing).collect()
}

/// Interval between scans where the operating system cannot report file changes.
pub(super) const POLL_INTERVAL: Duration = Duration::from_millis(200);
