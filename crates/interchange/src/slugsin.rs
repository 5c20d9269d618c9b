//! Reads `.slugsin` and `.structuredslugs`: a line a declaration or formula, under section heads in
//! brackets.
//!
//! ```text
//! [INPUT]              [OUTPUT]          # the environment's and the machine's variables
//! a                    d
//! b:0...10                               # structured only: a number
//! [ENV_INIT] [ENV_TRANS] [ENV_LIVENESS]  # and the same with SYS
//! ```
//!
//! All lines of a section hold together; sections may repeat and come in any order. `SYS_INIT` may
//! name the environment's variables (the machine chooses after it has seen them), goals may have
//! primes. Formulas are in [`prefix`] notation, and in structured files also in
//! [`infix`](super::infix) notation.

use super::names::{Names, Part, Section, quoted};
use super::{prefix, structured};
use linewright_core::diagnostics::{codes, nearest};
use linewright_core::gr1::{Domain, Owner};
use std::ops::Range;

/// Which of the two formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dialect {
    Prefix,
    Structured,
}

const SECTIONS: [Section; 6] = [
    section(Owner::Environment, Part::Initial, "ENV_INIT"),
    section(Owner::Environment, Part::Transition, "ENV_TRANS"),
    section(Owner::Environment, Part::Goal, "ENV_LIVENESS"),
    section(Owner::System, Part::Initial, "SYS_INIT"),
    section(Owner::System, Part::Transition, "SYS_TRANS"),
    section(Owner::System, Part::Goal, "SYS_LIVENESS"),
];

const fn section(owner: Owner, part: Part, name: &'static str) -> Section {
    Section { owner, part, name }
}

#[derive(Debug, Clone, Copy)]
enum Head {
    Variables(Owner),
    Formulas(Section),
    /// Not known, or not taken; its lines are passed over.
    Other,
}

/// Reads a file.
pub(super) fn read(names: &mut Names<'_>, dialect: Dialect) {
    let mut head = None;
    let mut formulas: Vec<(Section, Range<usize>)> = Vec::new();
    let mut orphan = false;
    for line in lines(names.text) {
        let text = &names.text[line.clone()];
        if text.starts_with('[') {
            head = Some(section_of(names, text, line));
            continue;
        }
        match head {
            Some(Head::Variables(owner)) => declaration(names, owner, dialect, line),
            Some(Head::Formulas(section)) => formulas.push((section, line)),
            Some(Head::Other) => {}
            None => {
                if !std::mem::replace(&mut orphan, true) {
                    names.syntax(
                        line,
                        "this comes before the first section",
                        "begin with a section: `[INPUT]` or `[OUTPUT]`",
                    );
                }
            }
        }
    }
    if head.is_none() && !orphan {
        names.syntax(
            0..0,
            "there is no section",
            "begin with a section: `[INPUT]` or `[OUTPUT]`",
        );
    }
    // Formulas may appear before the declarations.
    for (section, line) in formulas {
        let infix = dialect == Dialect::Structured && !prefix::fits(names, line.clone());
        let term = if infix {
            structured::formula(names, line.clone())
        } else {
            prefix::formula(names, line.clone())
        };
        names.formula(section, term, line);
    }
}

/// The lines that hold something, without blanks around them.
fn lines(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive(['\n', '\r']) {
        // Some editors put a mark in front of a file.
        let blank = |c: char| c.is_whitespace() || c == '\u{feff}';
        let trimmed = line.trim_matches(blank);
        let begin = start + (line.len() - line.trim_start_matches(blank).len());
        start += line.len();
        if !trimmed.is_empty() && !trimmed.starts_with('#') {
            found.push(begin..begin + trimmed.len());
        }
    }
    found
}

fn section_of(names: &mut Names<'_>, text: &str, line: Range<usize>) -> Head {
    let name = text.trim_start_matches('[').trim_end_matches(']').trim();
    let exact = text == format!("[{name}]");
    match name {
        _ if !exact => {}
        "INPUT" | "OBSERVABLE_INPUT" => return Head::Variables(Owner::Environment),
        "OUTPUT" => return Head::Variables(Owner::System),
        "UNOBSERVABLE_INPUT" | "CONTROLLABLE_INPUT" => {
            names.error(
                codes::NOT_GR1,
                line,
                format!("`{text}` makes another game of the specification"),
                "every input is seen by the machine and chosen by the environment here: use [INPUT]",
            );
            return Head::Other;
        }
        _ => {
            if let Some(section) = SECTIONS.into_iter().find(|s| s.name == name) {
                return Head::Formulas(section);
            }
        }
    }
    let (name, text) = (quoted(name), quoted(text));
    let known = SECTIONS.iter().map(|s| s.name).chain(["INPUT", "OUTPUT"]);
    let help = match nearest(&name, known) {
        Some(near) => format!("did you mean `[{near}]`?"),
        None if !exact => "a line that begins with `[` names a section and nothing else; a formula needs no `[]`, its section says when it holds".to_owned(),
        None => "sections are [INPUT], [OUTPUT], and [ENV_INIT], [ENV_TRANS], [ENV_LIVENESS] with their SYS counterparts".to_owned(),
    };
    names.syntax(line, format!("there is no section `{text}`"), help);
    Head::Other
}

fn declaration(names: &mut Names<'_>, owner: Owner, dialect: Dialect, line: Range<usize>) {
    let text = &names.text[line.clone()];
    if dialect == Dialect::Structured {
        structured::declaration(names, owner, line);
        return;
    }
    let bad = if text.contains(char::is_whitespace) {
        Some("a line declares one variable, without spaces in its name")
    } else if text.contains('\'') {
        Some("a variable's name has no prime")
    } else if prefix::is_operator(text) {
        Some("this is an operator or constant, and no name")
    } else {
        None
    };
    if let Some(message) = bad {
        names.syntax(
            line,
            message,
            "write one name a line; its next value is called by it and a prime",
        );
        return;
    }
    names.declare(owner, text, Domain::Bool, line);
}
