//! Programs of calls: a skill, or several called at once, a line.
//!
//! In a text file a line is `Left` or `Left & Down`; what follows `#` or `//` is a comment. In a `.csv` file the skills of a line stand in
//! its cells; where the first line is a header with a column `skill`, `skills`, `call` or `calls`, only that column counts, and lines that
//! have the same entry in a column `step` one after the other are one call.

use crate::diagnostics::{Diagnostic, codes, nearest};
use crate::order::Skills;
use crate::order::supervisor::Call;
use crate::source::{FileId, SourceMap, Span};

/// A program, and where each of its calls stands.
#[derive(Debug, Default)]
pub struct Program {
    /// The calls.
    pub calls: Vec<Call>,
    /// Where they stand.
    pub spans: Vec<Span>,
    /// What could not be read.
    pub findings: Vec<Diagnostic>,
}

/// Reads a file that is among the sources already.
pub fn read(sources: &SourceMap, file: FileId, skills: &Skills) -> Program {
    let source = sources.file(file);
    let mut program = Program::default();
    if source.name.to_ascii_lowercase().ends_with(".csv") {
        program.read_csv(&source.text, file, skills);
    } else {
        program.read_text(&source.text, file, skills);
    }
    program
}

/// What one call consists of: `Left`, `Left & Down`. The finding has the place within the text.
pub fn call(text: &str, skills: &Skills) -> Result<Call, Box<Wrong>> {
    let mut mask = 0;
    let mut at = 0;
    for piece in text.split('&') {
        let name = piece.trim();
        let start = at + (piece.len() - piece.trim_start().len());
        at += piece.len() + 1;
        let place = (start, start + name.len());
        let Some(skill) = skills.skills.iter().position(|s| s.name == name) else {
            return Err(Box::new(unknown(name, place, skills)));
        };
        if mask >> skill & 1 == 1 {
            return Err(Box::new(Wrong {
                place,
                message: format!("`{name}` stands twice in one call"),
                help: "a skill is called once at a time: write it on a line of its own".to_owned(),
            }));
        }
        mask |= 1 << skill;
    }
    Ok(Call(mask))
}

/// What is wrong with a call.
#[derive(Debug)]
pub struct Wrong {
    /// From which byte to which.
    pub place: (usize, usize),
    /// In words.
    pub message: String,
    /// The next step.
    pub help: String,
}

fn unknown(name: &str, place: (usize, usize), skills: &Skills) -> Wrong {
    let names = || skills.skills.iter().map(|s| s.name.as_str());
    let list = || names().collect::<Vec<_>>().join(", ");
    let (message, help) = if name.is_empty() {
        (
            "a skill is missing".to_owned(),
            "write `Left`, or `Left & Down` for skills that are called at once".to_owned(),
        )
    } else if name.contains([',', ';', ' ', '\t']) {
        (
            format!("`{name}` is no skill"),
            "write each call on a line of its own, and `&` between skills that are called at once"
                .to_owned(),
        )
    } else {
        let help = match nearest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the skills of `{}` are {}", skills.name, list()),
        };
        (format!("there is no skill `{name}`"), help)
    };
    Wrong {
        place,
        message,
        help,
    }
}

impl Program {
    fn push(&mut self, text: &str, start: usize, file: FileId, skills: &Skills) {
        match call(text, skills) {
            Ok(call) => {
                self.calls.push(call);
                self.spans.push(Span::new(file, start, start + text.len()));
            }
            Err(wrong) => {
                let (from, to) = (start + wrong.place.0, start + wrong.place.1);
                let span = Span::new(file, from, to.max(from + usize::from(!text.is_empty())));
                let finding = Diagnostic::error(codes::NAME_UNKNOWN, span, wrong.message);
                self.findings.push(finding.with_help(wrong.help));
            }
        }
    }

    fn read_text(&mut self, text: &str, file: FileId, skills: &Skills) {
        let mut at = 0;
        for line in text.split_inclusive('\n') {
            let code = line.split('#').next().unwrap_or_default();
            let code = code.split("//").next().unwrap_or_default();
            let code = code.trim_start_matches('\u{feff}');
            let before = line.find(code).unwrap_or_default() + code.len() - code.trim_start().len();
            let code = code.trim();
            if !code.is_empty() {
                self.push(code, at + before, file, skills);
            }
            at += line.len();
        }
    }

    fn read_csv(&mut self, text: &str, file: FileId, skills: &Skills) {
        let first = text.lines().next().unwrap_or_default();
        let delimiter = [b';', b'\t', b',']
            .into_iter()
            .find(|d| first.as_bytes().contains(d))
            .unwrap_or(b',');
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut columns: Option<(usize, Option<usize>)> = None;
        let mut last_step: Option<String> = None;
        for (number, record) in reader.records().enumerate() {
            let Ok(record) = record else {
                let span = Span::new(file, 0, first.len());
                let finding = Diagnostic::error(codes::SYNTAX, span, "this is no CSV in UTF-8");
                let help = "save it as CSV in UTF-8, or as text with one call a line";
                self.findings.push(finding.with_help(help));
                return;
            };
            let start = record.position().map_or(0, |p| p.byte() as usize);
            // The position is behind the last record: blank lines come before this one.
            let start = start + blank(&text[start.min(text.len())..]);
            let line = text[start.min(text.len())..]
                .lines()
                .next()
                .unwrap_or_default();
            let cell = |column: usize| record.get(column).unwrap_or_default();
            if number == 0 {
                let named = |names: &[&str]| {
                    let mut cells = record.iter();
                    cells.position(|c| names.iter().any(|n| c.eq_ignore_ascii_case(n)))
                };
                let calls = named(&["skill", "skills", "call", "calls"]);
                // A skill may be called `Call`: then it is no header.
                let is_skill = |c: usize| skills.skills.iter().any(|s| s.name == cell(c));
                if let Some(calls) = calls.filter(|c| !is_skill(*c)) {
                    columns = Some((calls, named(&["step"])));
                    continue;
                }
            }
            let text = match columns {
                None => {
                    let cells: Vec<&str> = record.iter().filter(|c| !c.is_empty()).collect();
                    cells.join(" & ")
                }
                Some((calls, _)) => cell(calls).to_owned(),
            };
            if text.is_empty() {
                continue;
            }
            let step = columns
                .and_then(|(_, step)| step)
                .map(|s| cell(s).to_owned());
            let span = Span::new(file, start, start + line.trim_end().len());
            let same = step.is_some() && step == last_step;
            last_step = step;
            match call(&text, skills) {
                Ok(call) => match self.calls.last_mut().filter(|_| same) {
                    Some(last) if last.0 & call.0 == 0 => {
                        last.0 |= call.0;
                        if let Some(whole) = self.spans.last_mut() {
                            *whole = whole.to(span);
                        }
                    }
                    _ => {
                        self.calls.push(call);
                        self.spans.push(span);
                    }
                },
                Err(wrong) => {
                    let finding = Diagnostic::error(codes::NAME_UNKNOWN, span, wrong.message);
                    self.findings.push(finding.with_help(wrong.help));
                }
            }
        }
    }
}

/// How many bytes of blank lines a text begins with.
fn blank(text: &str) -> usize {
    text.len() - text.trim_start_matches(['\n', '\r', '\u{feff}']).len()
}
