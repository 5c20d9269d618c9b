//! Reads programs from tables written by spreadsheets.
//!
//! Without a header, the skills of a row are called at once. If the first row is a header with a
//! column `skill`, only that column is read; with a column `step`, consecutive rows with the same
//! entry are one call. Sorting or copying rows can break this order unnoticed, so it is an error if
//! a step occurs again or is lower than the one before it.

use super::{CallMistake, Program, call};
use crate::diagnostics::{Code, Diagnostic, codes};
use crate::order::Skills;
use crate::order::supervisor::Call;
use crate::source::{FileId, Span};
use std::collections::BTreeMap;

/// Possible titles of the column with the skills.
const CALLS: [&str; 4] = ["skill", "skills", "call", "calls"];
/// Title of the column that groups rows into calls.
const STEP: &str = "step";

/// Indices of the columns.
struct Columns {
    calls: usize,
    step: Option<usize>,
}

/// Identity of a step: `1`, `01` and ` 1` are the same.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    Number(i64),
    Text(String),
}

/// The step of the previous row.
struct Last {
    step: Step,
    /// Skills of this step that were read so far.
    calls: u64,
    /// Index of the step's call; `None` if none of the step's rows could be read so far.
    place: Option<usize>,
}

/// State of reading a table.
struct Reader<'a> {
    program: &'a mut Program,
    skills: &'a Skills,
    delimiter: char,
    columns: Option<Columns>,
    last: Option<Last>,
    /// Place of the first row of each step.
    first_rows: BTreeMap<Step, Span>,
    /// Number of columns in the header.
    width: usize,
    /// Whether numbers in place of skills were already reported.
    has_reported_numbers: bool,
}

impl Program {
    pub(super) fn read_table(&mut self, text: &str, file: FileId, skills: &Skills) {
        let mut lines = text.trim_start_matches('\u{feff}').split(['\n', '\r']);
        let known = [';', '\t', ','];
        let first = lines.find(|l| l.contains(known)).unwrap_or_default();
        let delimiter = known
            .into_iter()
            .find(|d| first.contains(*d))
            .unwrap_or(',');
        let mut rows = csv::ReaderBuilder::new()
            .delimiter(delimiter as u8)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut reader = Reader {
            program: self,
            skills,
            delimiter,
            columns: None,
            last: None,
            first_rows: BTreeMap::new(),
            width: 0,
            has_reported_numbers: false,
        };
        let mut is_first = true;
        let mut last = Span::new(file, 0, first.len());
        for row in rows.records() {
            let Ok(row) = row else {
                let span = Span::new(file, 0, first.len());
                let help = "save it as CSV in UTF-8, or as text with one call per line";
                reader.finding(codes::SYNTAX, span, "this is not CSV in UTF-8", help);
                return;
            };
            let start = row.position().map_or(0, |p| p.byte() as usize);
            // The reported position is directly after the previous row, so blank lines are skipped.
            let start = start + blank(&text[start.min(text.len())..]);
            let line = text[start.min(text.len())..].split(['\n', '\r']).next();
            let length = line.unwrap_or_default().trim_end().len();
            let span = Span::new(file, start, start + length);
            if row.iter().all(str::is_empty) {
                continue;
            }
            if is_first {
                reader.columns = header(&row, skills);
                if reader.columns.is_some() {
                    reader.read_header(&row, span);
                }
            }
            // A header is not a call.
            if !is_first || reader.columns.is_none() {
                reader.row(&row, span, is_first);
            }
            is_first = false;
            last = span;
        }
        if text.matches('"').count() % 2 == 1 {
            let help = "close it, or remove it: names of skills need no quotes";
            reader.finding(codes::SYNTAX, last, "unclosed quote", help);
        }
    }
}

/// The relevant columns, if a row is a header.
fn header(row: &csv::StringRecord, skills: &Skills) -> Option<Columns> {
    let named = |names: &[&str]| {
        let mut cells = row.iter();
        cells.position(|c| names.iter().any(|n| c.eq_ignore_ascii_case(n)))
    };
    let calls = named(&CALLS)?;
    // If there is a skill with that name, the row is not a header.
    let is_skill = skills.skills.iter().any(|s| s.name == row[calls]);
    (!is_skill).then(|| Columns {
        calls,
        step: named(&[STEP]),
    })
}

impl Reader<'_> {
    /// Reads the header: its number of columns, and findings about ambiguous titles.
    fn read_header(&mut self, row: &csv::StringRecord, span: Span) {
        self.width = row.len();
        for titles in [&CALLS[..], &[STEP]] {
            let is_one = |c: &&str| titles.iter().any(|t| c.eq_ignore_ascii_case(t));
            let found: Vec<&str> = row.iter().filter(is_one).collect();
            if let [one, other, ..] = found.as_slice() {
                let message = format!("the columns `{one}` and `{other}` have the same meaning");
                let help = "keep one of them: write skills that are called at once in one cell, `A & B`, or in rows of the same step";
                self.finding(codes::SYNTAX, span, &message, help);
            }
        }
    }

    fn row(&mut self, row: &csv::StringRecord, span: Span, first: bool) {
        let cell = |column: usize| row.get(column).unwrap_or_default();
        let Some(Columns { calls, step }) = self.columns else {
            self.without_header(row, span, first);
            return;
        };
        if let Some(more) = row.iter().skip(self.width).find(|c| !c.is_empty()) {
            let message = format!("`{more}` has no column in the header");
            let help = format!(
                "write one row per skill, or `&` between skills that are called at once; columns are separated by `{}`",
                self.delimiter.escape_default()
            );
            self.finding(codes::SYNTAX, span, &message, &help);
        }
        let text = cell(calls);
        if text.is_empty() {
            let help = format!(
                "name a skill in the column `skill`, or remove the row; columns are separated by `{}`",
                self.delimiter.escape_default()
            );
            self.finding(codes::SYNTAX, span, "this row names no skill", &help);
            return;
        }
        match step.map(cell) {
            None => {
                if let Some(call) = self.call(text, span) {
                    self.push(call, span);
                }
            }
            Some("") => {
                self.finding(
                    codes::SYNTAX,
                    span,
                    "this row has no step",
                    "write a step in every row: the same one for skills that are called at once",
                );
                // Other errors in the row are also reported.
                self.call(text, span);
            }
            Some(step) => self.row_of_step(Step::of(step), text, span),
        }
    }

    fn row_of_step(&mut self, step: Step, text: &str, span: Span) {
        let before = self.last.take();
        let mut last = match before {
            Some(last) if last.step == step => last,
            before => {
                self.begin_step(&step, before.as_ref(), span);
                Last {
                    step,
                    calls: 0,
                    place: None,
                }
            }
        };
        if let Some(call) = self.call(text, span) {
            let twice = last.calls & call.0;
            if let Some(skill) = Call(twice).skills().next() {
                let message = format!(
                    "`{}` appears twice in step {}",
                    self.skills.skills[skill].name,
                    last.step.text()
                );
                self.finding(
                    codes::SKILL,
                    span,
                    &message,
                    "a skill can be called only once at a time: give this row a new step number, and the rows after it higher ones",
                );
            }
            last.calls |= call.0;
            if let Some(place) = last.place {
                self.program.calls[place].0 |= call.0;
                let whole = &mut self.program.spans[place];
                *whole = whole.to(span);
            } else {
                last.place = Some(self.program.calls.len());
                self.push(call, span);
            }
        }
        self.last = Some(last);
    }

    /// Starts a step. Reports a step that has occurred before, or a number that is not higher than
    /// the previous one.
    fn begin_step(&mut self, step: &Step, before: Option<&Last>, span: Span) {
        if let Some(first) = self.first_rows.get(step) {
            let message = format!("step {} appears again", step.text());
            let finding = Diagnostic::error(codes::SYNTAX, span, message)
                .with_label(*first, "first used here")
                .with_help("the rows of one call must be consecutive: move this row there, or give it and the rows after it new step numbers");
            self.program.findings.push(finding);
            return;
        }
        self.first_rows.insert(step.clone(), span);
        let Some(before) = before else { return };
        let (how, help) = if step.is_same_number(&before.step) {
            (
                "is not written as",
                "write both in the same way if they are one step; otherwise, give them different numbers",
            )
        } else if step.is_before(&before.step) {
            (
                "comes after",
                "calls are made in the order of the rows: sort the rows by step, or number the steps in row order",
            )
        } else {
            return;
        };
        let message = format!("step {} {how} step {}", step.text(), before.step.text());
        self.finding(codes::SYNTAX, span, &message, help);
    }

    /// Reads a row of a table without a header: its skills are called at once.
    fn without_header(&mut self, row: &csv::StringRecord, span: Span, first: bool) {
        // No name of a skill begins with a digit.
        let is_number = |cell: &&str| cell.starts_with(|c: char| c.is_ascii_digit());
        let cells = || row.iter().filter(|c| !c.is_empty());
        let header = format!("`step{}skill`", self.delimiter);
        if let Some(number) = cells().find(is_number) {
            if !self.has_reported_numbers {
                let message = format!("there is no skill `{number}`");
                let help = format!(
                    "if there are columns other than skills, the first line must be a header: {header}, with `skill` above the skills, and `step` above the numbers that group rows into calls"
                );
                self.finding(codes::NAME_UNKNOWN, span, &message, &help);
            }
            // Reported only once, since the cause is the same in every row.
            self.has_reported_numbers = true;
        }
        let text = cells().filter(|c| !is_number(c)).collect::<Vec<_>>();
        if text.is_empty() {
            return;
        }
        match call(&text.join(" & "), self.skills) {
            Ok(call) => self.push(call, span),
            Err(wrong) => {
                let known = text.iter().any(|t| call(t, self.skills).is_ok());
                let help = if first && !(known && wrong.is_guess) {
                    // The row can be intended as a header.
                    let list = match wrong.code {
                        codes::SYNTAX => String::new(),
                        _ => format!("{}; ", wrong.help),
                    };
                    format!("{list}a header has a column `skill`, such as {header}")
                } else {
                    wrong.help
                };
                self.finding(wrong.code, span, &wrong.message, &help);
            }
        }
    }

    fn call(&mut self, text: &str, span: Span) -> Option<Call> {
        match call(text, self.skills) {
            Ok(call) => Some(call),
            Err(wrong) => {
                let CallMistake {
                    code,
                    message,
                    help,
                    ..
                } = *wrong;
                self.finding(code, span, &message, &help);
                None
            }
        }
    }

    fn push(&mut self, call: Call, span: Span) {
        self.program.calls.push(call);
        self.program.spans.push(span);
    }

    fn finding(&mut self, code: Code, span: Span, message: &str, help: &str) {
        let finding = Diagnostic::error(code, span, message).with_help(help);
        self.program.findings.push(finding);
    }
}

impl Step {
    fn of(text: &str) -> Self {
        match text.parse() {
            Ok(number) => Self::Number(number),
            Err(_) => Self::Text(text.to_owned()),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => format!("`{text}`"),
        }
    }

    /// Whether both are the same number, such as `1` and `1.0`.
    fn is_same_number(&self, other: &Self) -> bool {
        let number = |step: &Self| match step {
            Self::Number(number) => Some(*number as f64),
            Self::Text(text) => text.replace(',', ".").parse::<f64>().ok(),
        };
        number(self).is_some_and(|own| number(other) == Some(own))
    }

    /// Whether the integer part is lower. Decimals are not compared, since 1.10 can be intended to
    /// come before or after 1.9.
    fn is_before(&self, other: &Self) -> bool {
        let whole = |step: &Self| match step {
            Self::Number(number) => Some(*number),
            Self::Text(text) => {
                text.parse::<f64>().ok()?;
                text.split('.').next()?.parse().ok()
            }
        };
        let both: Option<(i64, i64)> = whole(self).zip(whole(other));
        both.is_some_and(|(own, others)| own < others)
    }
}

/// Number of bytes of leading blank lines.
fn blank(text: &str) -> usize {
    text.len() - text.trim_start_matches(['\n', '\r', '\u{feff}']).len()
}
