//! Reads programs: each line is a call of a skill, or of several skills at once.
//!
//! In a text file, a line is `Left` or `Left & Down`; text after `#` or `//` is a comment. In a
//! `.csv` file, the skills of a line are in its cells. If the first line is a header with a column
//! `skill`, `skills`, `call` or `calls`, only that column is read, and consecutive lines with the
//! same entry in a column `step` are one call.

mod table;

use crate::diagnostics::{Code, Diagnostic, codes, nearest};
use crate::order::Skills;
use crate::order::supervisor::Call;
use crate::source::{FileId, SourceMap, Span};

/// A program with the places of its calls.
#[derive(Debug, Default)]
pub struct Program {
    /// Calls in order.
    pub calls: Vec<Call>,
    /// Places of the calls.
    pub spans: Vec<Span>,
    /// Errors found while reading.
    pub findings: Vec<Diagnostic>,
}

/// Parses a program whose file has been added to the sources.
pub fn read(sources: &SourceMap, file: FileId, skills: &Skills) -> Program {
    let source = sources.file(file);
    let mut program = Program::default();
    if source.name.to_ascii_lowercase().ends_with(".csv") {
        program.read_table(&source.text, file, skills);
    } else {
        program.read_text(&source.text, file, skills);
    }
    program
}

/// Parses one call: `Left`, `Left & Down`.
///
/// # Errors
/// Returns a mistake with its place in the text.
pub fn call(text: &str, skills: &Skills) -> Result<Call, Box<CallMistake>> {
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
            return Err(Box::new(CallMistake {
                code: codes::SKILL,
                place,
                message: format!("`{name}` appears twice in one call"),
                help: "a skill can be called only once at a time: write the second call on a separate line".to_owned(),
                is_guess: false,
            }));
        }
        mask |= 1 << skill;
    }
    Ok(Call(mask))
}

/// An error in a call.
#[derive(Debug)]
pub struct CallMistake {
    /// Kind of error.
    pub code: Code,
    /// Start and end of the place in bytes.
    pub place: (usize, usize),
    /// Message of the finding.
    pub message: String,
    /// Help of the finding.
    pub help: String,
    /// Whether the help is a guess at the intended skill.
    pub is_guess: bool,
}

fn unknown(name: &str, place: (usize, usize), skills: &Skills) -> CallMistake {
    let names = || skills.skills.iter().map(|s| s.name.as_str());
    let list = || names().collect::<Vec<_>>().join(", ");
    let near = nearest(name, names());
    let (code, message, help) = if name.is_empty() {
        let message = "a skill is missing".to_owned();
        (codes::SYNTAX, message, example(skills))
    } else if name.contains([',', ';', ' ', '\t']) {
        (
            codes::SYNTAX,
            format!("`{name}` is not a skill"),
            "write each call on a separate line, and `&` between skills that are called at once"
                .to_owned(),
        )
    } else {
        let help = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the skills of `{}` are {}", skills.name, list()),
        };
        let message = format!("there is no skill `{name}`");
        (codes::NAME_UNKNOWN, message, help)
    };
    CallMistake {
        is_guess: code == codes::NAME_UNKNOWN && near.is_some(),
        code,
        place,
        message,
        help,
    }
}

/// Help text with an example of a call of existing skills.
fn example(skills: &Skills) -> String {
    let Some(first) = skills.skills.first() else {
        return "declare a skill first".to_owned();
    };
    let name = &first.name;
    match skills
        .skills
        .iter()
        .find(|s| s.component != first.component)
    {
        Some(other) => format!(
            "write `{name}`, or `{name} & {}` for skills that are called at once",
            other.name
        ),
        None => format!("write `{name}`"),
    }
}

/// The place to mark for a finding: if it is empty, the preceding character.
fn marked(text: &str, (from, to): (usize, usize)) -> (usize, usize) {
    let before = text[..from].char_indices().next_back();
    match before {
        Some((sign, _)) if from == to => (sign, from),
        _ => (from, to),
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
                let (from, to) = marked(text, wrong.place);
                let span = Span::new(file, start + from, start + to);
                let finding = Diagnostic::error(wrong.code, span, wrong.message);
                self.findings.push(finding.with_help(wrong.help));
            }
        }
    }

    fn read_text(&mut self, text: &str, file: FileId, skills: &Skills) {
        let mut at = 0;
        for line in text.split_inclusive(['\n', '\r']) {
            let code = line
                .split('#')
                .next()
                .unwrap_or_default()
                .split("//")
                .next()
                .unwrap_or_default()
                .trim_start_matches('\u{feff}');
            let before = line.find(code).unwrap_or_default() + code.len() - code.trim_start().len();
            let code = code.trim();
            if !code.is_empty() {
                self.push(code, at + before, file, skills);
            }
            at += line.len();
        }
    }
}
