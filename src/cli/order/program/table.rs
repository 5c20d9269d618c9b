//! Programs as tables written by spreadsheets.
//!
//! Without a header the skills of a row are called at once. If the first row is a header with a
//! column `skill`, only that column counts; with a column `step`, consecutive rows with the same
//! entry are one call. Sorting or copying rows can break that order unnoticed, so a step that
//! occurs again, or goes back, is a finding and no new call.

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
    /// Skills called so far.
    calls: u64,
    /// Index of its call, unless none of its rows could be read.
    place: Option<usize>,
}

/// State of reading a table.
struct Reader<'a> {
    program: &'a mut Program,
    skills: &'a Skills,
    delimiter: char,
    columns: Option<Columns>,
    last: Option<Last>,
    /// Place where each step began.
    begun: BTreeMap<Step, Span>,
    /// Number of columns in the header.
    width: usize,
    /// Whether numbers in place of skills were already reported.
    numbered: bool,
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
            begun: BTreeMap::new(),
            width: 0,
            numbered: false,
        };
        let mut begun = false;
        let mut last = Span::new(file, 0, first.len());
        for row in rows.records() {
            let Ok(row) = row else {
                let span = Span::new(file, 0, first.len());
                let help = "save it as CSV in UTF-8, or as text with one call a line";
                reader.finding(codes::SYNTAX, span, "this is not CSV in UTF-8", help);
                return;
            };
            let start = row.position().map_or(0, |p| p.byte() as usize);
            // The position is after the previous row: blank lines come before this one.
            let start = start + blank(&text[start.min(text.len())..]);
            let line = text[start.min(text.len())..].split(['\n', '\r']).next();
            let length = line.unwrap_or_default().trim_end().len();
            let span = Span::new(file, start, start + length);
            if row.iter().all(str::is_empty) {
                continue;
            }
            if !begun {
                reader.columns = header(&row, skills);
                if reader.columns.is_some() {
                    reader.headed(&row, span);
                }
            }
            // A header is no call.
            if begun || reader.columns.is_none() {
                reader.row(&row, span, !begun);
            }
            begun = true;
            last = span;
        }
        if text.matches('"').count() % 2 == 1 {
            let help = "close it, or leave it out: names of skills need no quotes";
            reader.finding(
                codes::SYNTAX,
                last,
                "a quote is opened and not closed",
                help,
            );
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
    // If a skill has that name, the row is no header.
    let is_skill = skills.skills.iter().any(|s| s.name == row[calls]);
    (!is_skill).then(|| Columns {
        calls,
        step: named(&[STEP]),
    })
}

impl Reader<'_> {
    /// Reads a row under a header.
    fn headed(&mut self, row: &csv::StringRecord, span: Span) {
        self.width = row.len();
        for titles in [&CALLS[..], &[STEP]] {
            let is_one = |c: &&str| titles.iter().any(|t| c.eq_ignore_ascii_case(t));
            let found: Vec<&str> = row.iter().filter(is_one).collect();
            if let [one, other, ..] = found.as_slice() {
                let message = format!("the columns `{one}` and `{other}` say the same");
                let help = "leave one of them: skills that are called at once are in one cell, `A & B`, or in rows of the same step";
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
            let message = format!("`{more}` is in no column of the header");
            let help = format!(
                "write one row a skill, or `&` between skills that are called at once; the signs between columns are `{}`",
                self.delimiter.escape_default()
            );
            self.finding(codes::SYNTAX, span, &message, &help);
        }
        let text = cell(calls);
        if text.is_empty() {
            let help = format!(
                "name a skill in the column `skill`, or leave the row out; the signs between columns are `{}`",
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
                    "it is not said which step this belongs to",
                    "write a step in every row: the same one for skills that are called at once",
                );
                // All errors are reported nevertheless.
                self.call(text, span);
            }
            Some(step) => self.of_step(Step::of(step), text, span),
        }
    }

    fn of_step(&mut self, step: Step, text: &str, span: Span) {
        let before = self.last.take();
        let mut last = match before {
            Some(last) if last.step == step => last,
            before => {
                self.begin(&step, before.as_ref(), span);
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
                    "a skill is called once at a time: give this row a step of its own, and those behind it later ones",
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

    /// Starts a step: it must be new, and greater if it is a number.
    fn begin(&mut self, step: &Step, before: Option<&Last>, span: Span) {
        if let Some(first) = self.begun.get(step) {
            let message = format!("step {} comes again", step.text());
            let finding = Diagnostic::error(codes::SYNTAX, span, message)
                .with_label(*first, "it was here before")
                .with_help("rows of one call belong together: move this row there, or give it and those behind it steps of their own");
            self.program.findings.push(finding);
            return;
        }
        self.begun.insert(step.clone(), span);
        let Some(before) = before else { return };
        let (how, help) = if step.is_same_number(&before.step) {
            (
                "is not written as",
                "write both alike where they are one step, and otherwise another number",
            )
        } else if step.is_before(&before.step) {
            (
                "comes behind",
                "calls are made in the order of the rows: sort the rows by step, or number the steps as the rows stand",
            )
        } else {
            return;
        };
        let message = format!("step {} {how} step {}", step.text(), before.step.text());
        self.finding(codes::SYNTAX, span, &message, help);
    }

    /// Reads a row that consists of skills called at once.
    fn without_header(&mut self, row: &csv::StringRecord, span: Span, first: bool) {
        // No skill begins with a digit.
        let is_number = |cell: &&str| cell.starts_with(|c: char| c.is_ascii_digit());
        let cells = || row.iter().filter(|c| !c.is_empty());
        let header = format!("`step{}skill`", self.delimiter);
        if let Some(number) = cells().find(is_number) {
            if !self.numbered {
                let message = format!("there is no skill `{number}`");
                let help = format!(
                    "where there are other columns besides the skills, the first line is a header: {header}, with `skill` over the skills, and `step` over what tells which rows are one call"
                );
                self.finding(codes::NAME_UNKNOWN, span, &message, &help);
            }
            // Reported once, since it is the same in every row.
            self.numbered = true;
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
                    // It may be intended as a header.
                    let list = match wrong.code {
                        codes::SYNTAX => String::new(),
                        _ => format!("{}; ", wrong.help),
                    };
                    format!(
                        "{list}a first line that is a header has a column `skill`, such as {header}"
                    )
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

    /// Only the integer part is compared: 1.10 may be meant to come before or after 1.9.
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
