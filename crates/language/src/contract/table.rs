//! Tables: CSV files whose columns hold durations, or the instants at which parts come.
//!
//! A table is read once, through the loader of imports. A column is parsed where it is used, and
//! all its mistakes are reported at their places in the table, up to a maximum number.

use super::Loader;
use super::distribution::Distribution;
use super::elaborate::{Elaborator, nearest};
use super::units::{MAX_SECONDS, MIN_SECONDS, is_duration, unit};
use super::value::Dimension;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::{FileId, SourceMap, Span};
use linewright_syntax::ast::{Column, Name};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of rows below the header.
pub const MAX_ROWS: usize = 1_000_000;

/// Maximum size of a table in bytes.
const MAX_BYTES: usize = 256 << 20;

/// Maximum number of wrong cells of a column that are reported one by one.
const MAX_FINDINGS: usize = 20;

/// Maximum number of headers in a help text.
const MAX_HEADERS: usize = 16;

/// A table as text.
#[derive(Debug, Clone)]
struct Table {
    file: FileId,
    text: Arc<str>,
}

/// The tables that statements name, by the place of the path; or why a table cannot be read.
#[derive(Debug, Default)]
pub(super) struct Tables {
    by_place: BTreeMap<Span, Result<Table, String>>,
    by_name: BTreeMap<String, Table>,
}

impl Tables {
    /// Reads the table that a statement in the file `importer` names, unless it is known already.
    pub fn read(
        &mut self,
        path: &Name,
        importer: &str,
        loader: &Loader<'_>,
        sources: &mut SourceMap,
    ) {
        let table = loader(&path.text, importer).and_then(|(name, text)| {
            if let Some(known) = self.by_name.get(&name) {
                return Ok(known.clone());
            }
            if text.len() > MAX_BYTES {
                return Err(format!("it has more than {} MiB", MAX_BYTES >> 20));
            }
            let text: Arc<str> = text.into();
            let file = sources.add(name.as_str(), Arc::clone(&text));
            let table = Table { file, text };
            self.by_name.insert(name, table.clone());
            Ok(table)
        });
        self.by_place.insert(path.span, table);
    }

    /// The files of the tables.
    pub fn files(&self) -> Vec<FileId> {
        self.by_name.values().map(|table| table.file).collect()
    }
}

/// What the numbers of a column mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    Time,
    Arrival,
}

/// Resolves `empirical(...)`: the distribution in which each row of a column has the same
/// probability.
pub(super) fn empirical(e: &mut Elaborator<'_>, column: &Column) -> Option<Distribution> {
    let mut values = seconds(e, column, Meaning::Time)?;
    values.sort_unstable_by(f64::total_cmp);
    Some(Distribution::Empirical(values.into()))
}

/// Resolves the instants of a column, in seconds and in ascending order.
pub(super) fn instants(e: &mut Elaborator<'_>, column: &Column) -> Option<Arc<[f64]>> {
    seconds(e, column, Meaning::Arrival).map(Arc::from)
}

/// Reads a column in seconds, from the top to the bottom.
fn seconds(e: &mut Elaborator<'_>, column: &Column, meaning: Meaning) -> Option<Vec<f64>> {
    let (dimension, factor) = unit(&column.unit.text);
    if dimension != Dimension::Time {
        let message = format!(
            "expected {}, found {}",
            Dimension::Time.describe(),
            dimension.describe()
        );
        let help = "write the unit of the numbers in the column, such as `in min`";
        e.findings
            .error_with(codes::TYPE_MISMATCH, column.unit.span, message, help);
    }
    let known = e
        .tables
        .and_then(|tables| tables.by_place.get(&column.path.span));
    let table = match known {
        Some(Ok(table)) => table,
        other => {
            let why = match other {
                Some(Err(why)) => why.as_str(),
                _ => "nothing has loaded it",
            };
            e.findings.error_with(
                codes::LINE_TABLE,
                column.path.span,
                format!("cannot read the table `{}`: {why}", column.path.text),
                "write the path of a CSV file, relative to the file with the line or machine",
            );
            return None;
        }
    };
    let mut reader = Reader {
        table,
        column,
        meaning,
        factor,
        values: Vec::new(),
        findings: Vec::new(),
        unreported: 0,
    };
    reader.read();
    let Reader {
        values, findings, ..
    } = reader;
    let is_sound = findings.is_empty() && dimension == Dimension::Time;
    for finding in findings {
        e.findings.push(finding);
    }
    is_sound.then_some(values)
}

/// State of reading a column.
struct Reader<'t> {
    table: &'t Table,
    column: &'t Column,
    meaning: Meaning,
    /// Seconds of the unit.
    factor: f64,
    values: Vec<f64>,
    findings: Vec<Diagnostic>,
    /// Number of wrong cells that are not reported one by one.
    unreported: usize,
}

/// A row of the table.
struct Row<'r> {
    cells: &'r csv::StringRecord,
    /// Offset at which it begins.
    start: usize,
}

impl Reader<'_> {
    fn read(&mut self) {
        let text = Arc::clone(&self.table.text);
        let body = text.trim_start_matches('\u{feff}');
        let before = text.len() - body.len();
        let separator = separator(body);
        let mut rows = csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(body.as_bytes());
        let mut cells = csv::StringRecord::new();
        let mut header: Option<(usize, usize)> = None;
        // The text is UTF-8 and in memory, so reading a record does not fail.
        while rows.read_record(&mut cells).is_ok_and(|is_there| is_there) {
            if cells.iter().all(str::is_empty) {
                continue;
            }
            let start = before + cells.position().map_or(0, |p| p.byte() as usize);
            let row = Row {
                cells: &cells,
                start,
            };
            match header {
                None => match self.find(&cells) {
                    Some(index) => header = Some((index, cells.len())),
                    None => return,
                },
                Some((index, width)) => {
                    if self.values.len() == MAX_ROWS {
                        self.report(
                            self.row_span(&row),
                            format!("this table has more than {MAX_ROWS} rows"),
                            "take a sample of the rows, or divide them among several tables"
                                .to_owned(),
                        );
                        break;
                    }
                    self.row(&row, index, width, separator);
                }
            }
        }
        self.finish(&text, header.is_some());
    }

    /// Finds the column by its header.
    fn find(&mut self, header: &csv::StringRecord) -> Option<usize> {
        let wanted = self.column.header.text.trim();
        let mut matching = header
            .iter()
            .enumerate()
            .filter(|(_, cell)| *cell == wanted);
        let span = self.column.header.span;
        let path = &self.column.path.text;
        let headers: Vec<&str> = header.iter().filter(|cell| !cell.is_empty()).collect();
        let first = matching.next();
        if first.is_some() && matching.next().is_none() {
            return first.map(|(index, _)| index);
        }
        let (message, help) = if first.is_some() {
            (
                format!("`{path}` has several columns `{wanted}`"),
                "give each column a header of its own".to_owned(),
            )
        } else {
            let shown = headers
                .iter()
                .take(MAX_HEADERS)
                .map(|cell| format!("`{cell}`"));
            let shown = shown.collect::<Vec<_>>().join(", ");
            let more = match headers.len().saturating_sub(MAX_HEADERS) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let near = nearest(wanted, headers.iter().copied());
            let near = near.map_or_else(String::new, |near| format!("did you mean `{near}`? "));
            (
                format!("`{path}` has no column `{wanted}`"),
                format!("{near}its first row names {shown}{more}"),
            )
        };
        self.findings
            .push(Diagnostic::error(codes::LINE_TABLE, span, message).with_help(help));
        None
    }

    fn row(&mut self, row: &Row<'_>, index: usize, width: usize, separator: u8) {
        let surplus = row.cells.iter().skip(width).any(|cell| !cell.is_empty());
        if surplus {
            self.report(
                self.row_span(row),
                format!(
                    "this row has {} cells, but the first row has {width}",
                    row.cells.len()
                ),
                format!(
                    "write numbers with a decimal point, and put cells that contain `{}` in quotes",
                    char::from(separator).escape_default()
                ),
            );
            return;
        }
        let cell = row.cells.get(index).unwrap_or_default();
        match self.value(cell) {
            Ok(value) => self.values.push(value),
            Err((message, help)) => {
                let span = self.cell_span(row, index, separator);
                self.report(span, message, help);
            }
        }
    }

    /// Reads a cell, in seconds. An error is a message and a help text.
    fn value(&self, cell: &str) -> Result<f64, (String, String)> {
        let error = |message: String, help: &str| Err((message, help.to_owned()));
        let header = &self.column.header.text;
        if cell.is_empty() {
            let message = format!("this row has no number in the column `{header}`");
            return error(message, "write a number, or remove the row");
        }
        let Ok(number) = cell.parse::<f64>() else {
            let help = match cell.replace(',', ".") {
                point if point.parse::<f64>().is_ok() => {
                    format!("write it with a decimal point: `{point}`")
                }
                _ => "write the number alone: the line names its unit".to_owned(),
            };
            return Err((format!("`{cell}` is not a number"), help));
        };
        let value = number * self.factor;
        let unit = &self.column.unit.text;
        if !value.is_finite() {
            return error(format!("`{cell}` is not finite"), "write a finite number");
        }
        if value < 0.0 {
            return error(
                format!("{cell} {unit} is negative"),
                "write a number that is at least 0",
            );
        }
        match self.meaning {
            Meaning::Time if !is_duration(value) => Err((
                format!("{cell} {unit} is not a valid duration"),
                format!("write 0, or a time from {MIN_SECONDS:e} s to {MAX_SECONDS:e} s"),
            )),
            Meaning::Arrival if value > MAX_SECONDS => Err((
                format!("{cell} {unit} is too late"),
                format!("write a time up to {MAX_SECONDS:e} s after the start of the run"),
            )),
            Meaning::Arrival if self.values.last().is_some_and(|last| value < *last) => error(
                format!("{cell} {unit} is before the instant above it"),
                "sort the rows by this column, the earliest first",
            ),
            // -0 becomes 0.
            _ => Ok(value + 0.0),
        }
    }

    fn report(&mut self, span: Span, message: String, help: String) {
        if self.findings.len() == MAX_FINDINGS {
            self.unreported += 1;
            return;
        }
        let used = format!("`{}` is read here", self.column.header.text);
        self.findings.push(
            Diagnostic::error(codes::LINE_TABLE, span, message)
                .with_label(self.column.span(), used)
                .with_help(help),
        );
    }

    /// Reports what concerns the table as a whole.
    fn finish(&mut self, text: &str, has_header: bool) {
        let path = &self.column.path.text;
        let (message, help) = if text.matches('"').count() % 2 == 1 {
            (
                format!("`{path}` has an unclosed quote"),
                "close it, or remove it: numbers need no quotes",
            )
        } else if !has_header {
            (
                format!("`{path}` is empty"),
                "write the headers of the columns in the first row, and a number in each row below",
            )
        } else if self.values.is_empty() && self.findings.is_empty() {
            (
                format!("`{path}` has no row below its header"),
                "add at least one row",
            )
        } else if self.unreported > 0 {
            (
                format!(
                    "{} more cells of `{}` in `{path}` are wrong",
                    self.unreported, self.column.header.text
                ),
                "repair those that are reported one by one; the others may have the same reason",
            )
        } else {
            return;
        };
        let span = self.column.path.span;
        self.findings
            .push(Diagnostic::error(codes::LINE_TABLE, span, message).with_help(help));
    }

    /// The first line of a row.
    fn row_span(&self, row: &Row<'_>) -> Span {
        let text = &self.table.text;
        let rest = text.get(row.start..).unwrap_or_default();
        // The position of a row can be that of the line ends before it.
        let start = row.start + rest.len() - rest.trim_start_matches(['\n', '\r']).len();
        let line = text
            .get(start..)
            .unwrap_or_default()
            .split(['\n', '\r'])
            .next();
        let length = line.unwrap_or_default().trim_end().len();
        Span::new(self.table.file, start, start + length)
    }

    /// A cell; the row if quotes could hide separators, or if the row is too short.
    fn cell_span(&self, row: &Row<'_>, index: usize, separator: u8) -> Span {
        let whole = self.row_span(row);
        let text = &self.table.text[whole.start as usize..whole.end as usize];
        if text.contains('"') {
            return whole;
        }
        let mut start = whole.start as usize;
        for (at, cell) in text.split(char::from(separator)).enumerate() {
            if at == index && !cell.trim().is_empty() {
                let blank = cell.len() - cell.trim_start().len();
                let start = start + blank;
                return Span::new(self.table.file, start, start + cell.trim().len());
            }
            start += cell.len() + 1;
        }
        whole
    }
}

/// The separator of a table: a semicolon or a tab if its first row has one, otherwise a comma.
fn separator(text: &str) -> u8 {
    let mut lines = text.split(['\n', '\r']);
    let first = lines
        .find(|line| !line.trim().is_empty())
        .unwrap_or_default();
    let mut known = [b';', b'\t'].into_iter();
    known
        .find(|separator| first.as_bytes().contains(separator))
        .unwrap_or(b',')
}
