//! The files of `run --trace`.

use crate::contract::line::Line;
use crate::diagnostics::Diagnostic;
use crate::engine::output::PendingFile;
use crate::event_log::{Context, EXTENSIONS, Epoch, EventLog, Format};
use crate::line::Observer;
use crate::line::log::{LogEntry, Moment};
use crate::line::trace::{End, Violation};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A file for the events of a run, with the format that its name gives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceFile {
    path: PathBuf,
    format: Format,
}

impl std::str::FromStr for TraceFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        match Format::of(&path) {
            Some(format) => Ok(Self { path, format }),
            None => Err(format!(
                "the format of a log follows from its extension, which is one of {}",
                EXTENSIONS.map(|(extension, _)| extension).join(", ")
            )),
        }
    }
}

/// The files of a run, which take their names when it has ended.
pub(super) struct TraceFiles(Vec<(PendingFile, Format)>);

impl TraceFiles {
    /// Begins all files.
    pub(super) fn new(
        files: &[TraceFile],
        sources: &BTreeSet<PathBuf>,
    ) -> Result<Self, Vec<Diagnostic>> {
        let (mut pending, mut findings) = (Vec::new(), Vec::new());
        for file in files {
            match PendingFile::new(&file.path, sources) {
                Ok(begun) => pending.push((begun, file.format)),
                Err(finding) => findings.push(*finding),
            }
        }
        if findings.is_empty() {
            Ok(Self(pending))
        } else {
            Err(findings)
        }
    }

    /// The logs to be written.
    pub(super) fn logs<'a>(&'a self, line: &'a Line, seed: u64, epoch: Option<Epoch>) -> Logs<'a> {
        let context = Context {
            line,
            seed,
            epoch: epoch.unwrap_or_else(|| Epoch::of(line)),
        };
        let logs = self.0.iter();
        Logs(
            logs.map(|(file, format)| EventLog::new(*format, context, file.file()))
                .collect(),
        )
    }

    /// Gives the files their names, unless they could not be written.
    pub(super) fn keep(self, written: Vec<std::io::Result<()>>) -> Vec<Diagnostic> {
        let files = self.0.into_iter().zip(written);
        let kept = files.map(|((file, _), written)| file.keep(written));
        kept.filter_map(|kept| kept.err().map(|finding| *finding))
            .collect()
    }
}

/// Logs of the same run.
pub(super) struct Logs<'a>(Vec<std::io::Result<EventLog<'a>>>);

impl Logs<'_> {
    /// Whether each log was written.
    pub(super) fn finish(self) -> Vec<std::io::Result<()>> {
        let logs = self.0.into_iter();
        logs.map(|log| log.and_then(EventLog::finish)).collect()
    }
}

impl Observer for Logs<'_> {
    fn record(&mut self, entry: &LogEntry) {
        for log in self.0.iter_mut().flatten() {
            log.record(entry);
        }
    }

    fn record_violation(&mut self, violation: &Violation) {
        for log in self.0.iter_mut().flatten() {
            log.record_violation(violation);
        }
    }

    fn begin_counting(&mut self, moment: Moment) {
        for log in self.0.iter_mut().flatten() {
            log.begin_counting(moment);
        }
    }

    fn end(&mut self, moment: Moment, end: End) {
        for log in self.0.iter_mut().flatten() {
            log.end(moment, end);
        }
    }
}
