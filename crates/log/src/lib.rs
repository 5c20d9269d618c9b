//! Event logs of a run in the formats of other tools.
//!
//! An [`EventLog`] observes a run and writes each event at once. It holds what is in the line at a
//! moment, never what has passed, so that its memory does not grow with the run. The format follows
//! from the name of the file; see [`Format::of`].
//!
//! | Format | Module | Read by |
//! |---|---|---|
//! | CSV, JSON lines, Parquet | `csv`, `jsonl`, `parquet`: one row an event, see `row` | spreadsheets, databases, data frames |
//! | Chrome trace | `perfetto` | Perfetto, `chrome://tracing` |
//! | OCEL 2.0 | `ocel` | object-centric process mining |
//! | XES | `xes` | process mining by cases |

mod csv;
mod epoch;
mod format;
mod jsonl;
mod ocel;
mod parquet;
mod perfetto;
mod row;
mod xes;

pub use epoch::Epoch;
pub use format::{EXTENSIONS, Format};
pub use row::COLUMNS;

use linewright_language::contract::line::Line;
use linewright_line::Observer;
use linewright_line::log::{LogEntry, Moment};
use linewright_line::trace::{End, Violation};
use row::Table;
use std::io::{self, BufWriter, Write};

/// JSON Schema of the description of a line, with which JSON lines begin.
pub const LOG_SCHEMA: &str = jsonl::SCHEMA;

/// Writes the events of a run in one format.
trait EventWriter {
    fn entry(&mut self, entry: &LogEntry) -> io::Result<()>;

    fn violation(&mut self, violation: &Violation) -> io::Result<()>;

    /// The warm-up ends.
    fn counting(&mut self, moment: Moment) -> io::Result<()>;

    /// The run ends: completes the file.
    fn end(&mut self, moment: Moment, end: End) -> io::Result<()>;
}

/// The log of a run, in one format.
pub struct EventLog<'a> {
    writer: Box<dyn EventWriter + 'a>,
    /// The first error, after which nothing more is written.
    error: Option<io::Error>,
}

/// What a log says about its run.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The line.
    pub line: &'a Line,
    /// Seed of the run.
    pub seed: u64,
    /// The date and time at which the run starts, for formats with dates.
    pub epoch: Epoch,
}

impl<'a> EventLog<'a> {
    /// Begins a log. Formats whose file begins with what is known only at the end of a run keep
    /// that in a temporary file.
    ///
    /// # Errors
    /// The file cannot be written, or a temporary file cannot be created.
    pub fn new(
        format: Format,
        context: Context<'a>,
        file: impl Write + Send + 'a,
    ) -> io::Result<Self> {
        let line = context.line;
        let file = BufWriter::new(file);
        let writer: Box<dyn EventWriter + 'a> = match format {
            Format::Csv => Box::new(Table::new(line, csv::CsvWriter::new(file)?)),
            Format::Jsonl => Box::new(Table::new(line, jsonl::JsonLines::new(file, context)?)),
            Format::Parquet => Box::new(Table::new(
                line,
                parquet::ParquetWriter::new(file, context)?,
            )),
            Format::Perfetto => Box::new(perfetto::TraceEvents::new(file, line)?),
            Format::Ocel => Box::new(ocel::OcelWriter::new(file, context)?),
            Format::Xes => Box::new(xes::XesWriter::new(file, context)?),
        };
        Ok(Self {
            writer,
            error: None,
        })
    }

    /// Whether everything was written.
    ///
    /// # Errors
    /// The first error since the log began.
    pub fn finish(self) -> io::Result<()> {
        self.error.map_or(Ok(()), Err)
    }

    fn write(&mut self, write: impl FnOnce(&mut dyn EventWriter) -> io::Result<()>) {
        if self.error.is_none() {
            self.error = write(&mut *self.writer).err();
        }
    }
}

impl Observer for EventLog<'_> {
    fn record(&mut self, entry: &LogEntry) {
        self.write(|writer| writer.entry(entry));
    }

    fn record_violation(&mut self, violation: &Violation) {
        self.write(|writer| writer.violation(violation));
    }

    fn begin_counting(&mut self, moment: Moment) {
        self.write(|writer| writer.counting(moment));
    }

    fn end(&mut self, moment: Moment, end: End) {
        self.write(|writer| writer.end(moment, end));
    }
}

/// The kind of a place, as it is called in a log.
fn kind_word(kind: &linewright_language::contract::line::NodeKind) -> &'static str {
    use linewright_language::contract::line::NodeKind;
    match kind {
        NodeKind::Sink { reject: true, .. } => "rejects",
        kind => kind.word(),
    }
}
