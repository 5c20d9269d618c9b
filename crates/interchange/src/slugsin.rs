//! Reads `.slugsin` and `.structuredslugs`: one declaration or formula per line, in sections whose
//! names are in brackets.
//!
//! ```text
//! [INPUT]              [OUTPUT]          # variables of the environment and of the system
//! a                    d
//! b:0...10                               # structured only: a number
//! [ENV_INIT] [ENV_TRANS] [ENV_LIVENESS]  # formulas; also SYS_INIT, SYS_TRANS, SYS_LIVENESS
//! ```
//!
//! All formulas of a section have to hold. Sections can repeat and appear in any order. `SYS_INIT`
//! can refer to the environment's variables, because the system chooses after it has seen them.
//! Goals can contain primes. Formulas are in [`prefix`] notation; structured files also allow
//! [`infix`](super::infix) notation.

use super::names::{Names, Part, Section, quoted};
use super::{prefix, structured};
use linewright_core::diagnostics::{codes, nearest};
use linewright_core::gr1::{Domain, Owner};
use std::ops::Range;

/// The format of the file.
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
    /// An unknown or unsupported section; its lines are skipped.
    Other,
}

/// Reads a file into `names`.
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
                        "this line is before the first section",
                        "begin with a section: `[INPUT]` or `[OUTPUT]`",
                    );
                }
            }
        }
    }
    if head.is_none() && !orphan {
        names.syntax(
            0..0,
            "the file has no section",
            "begin with a section: `[INPUT]` or `[OUTPUT]`",
        );
    }
    // Formulas can appear before the declarations of their variables.
    for (section, line) in formulas {
        let infix = dialect == Dialect::Structured && !prefix::is_prefix(names, line.clone());
        let term = if infix {
            structured::formula(names, line.clone())
        } else {
            prefix::formula(names, line.clone())
        };
        names.formula(section, term, line);
    }
}

/// Byte ranges of the trimmed lines that are neither blank nor comments.
fn lines(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive(['\n', '\r']) {
        // Some editors write a byte order mark at the start of a file.
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
                format!("`{text}` is not supported: it changes the rules of the game"),
                "use [INPUT]: the environment chooses every input, and the system sees it",
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
        None if !exact => "write only a section's name in brackets; write formulas without `[]`, since the section says when they hold".to_owned(),
        None => "sections are [INPUT], [OUTPUT], and [ENV_INIT], [ENV_TRANS], [ENV_LIVENESS] with their SYS counterparts".to_owned(),
    };
    names.syntax(line, format!("`{text}` is not a section"), help);
    Head::Other
}

fn declaration(names: &mut Names<'_>, owner: Owner, dialect: Dialect, line: Range<usize>) {
    let text = &names.text[line.clone()];
    if dialect == Dialect::Structured {
        structured::declaration(names, owner, line);
        return;
    }
    let bad = if text.contains(char::is_whitespace) {
        Some("a variable's name cannot contain spaces")
    } else if text.contains('\'') {
        Some("a variable's name cannot contain a prime")
    } else if prefix::is_operator(text) {
        Some("an operator or a constant cannot be a variable's name")
    } else {
        None
    };
    if let Some(message) = bad {
        names.syntax(
            line,
            message,
            "write one name per line; in formulas, a prime after the name means its next value",
        );
        return;
    }
    names.declare(owner, text, Domain::Bool, line);
}
