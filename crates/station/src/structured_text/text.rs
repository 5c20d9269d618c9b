//! Prints a block as Structured Text.

use super::{Block, Enumeration, Initial, Section, Type, Variable};
use crate::template::render;
use serde::Serialize;
use std::fmt::Write;

/// Maximum length of a line with a variable and its comment; a longer comment gets its own line.
const WIDTH: usize = 110;

/// The fields of `block.st`.
#[derive(Serialize)]
struct BlockText<'a> {
    types: Vec<TypeText<'a>>,
    description: String,
    name: &'a str,
    sections: Vec<SectionText>,
    body: &'a str,
}

#[derive(Serialize)]
struct TypeText<'a> {
    description: &'a str,
    name: &'a str,
    /// Labels with commas and comments.
    labels: Vec<String>,
}

#[derive(Serialize)]
struct SectionText {
    keywords: &'static str,
    variables: Vec<String>,
}

/// Breaks a long text at its spaces; continuation lines start with `indent`.
pub(super) fn wrap(text: &str, indent: &str) -> String {
    crate::emit::text::wrap(text, indent)
}

/// Like `wrap`, for a condition: a test in innermost parentheses stays on one line.
pub(super) fn wrap_condition(text: &str, indent: &str) -> String {
    const HELD: char = '\u{a0}';
    let mut held = String::new();
    for (place, c) in text.char_indices() {
        let before = text[..place].rfind(['(', ')']);
        let after = text[place..].find(['(', ')']);
        let inside = matches!((before, after), (Some(b), Some(a)) if text[b..].starts_with('(') && text[place + a..].starts_with(')'));
        held.push(if c == ' ' && inside { HELD } else { c });
    }
    wrap(&held, indent).replace(HELD, " ")
}

/// Indents all non-empty lines by a number of levels.
pub(super) fn indented(text: &str, levels: usize) -> String {
    let indent = "    ".repeat(levels);
    text.lines().fold(String::new(), |mut out, line| {
        if !line.is_empty() {
            out.push_str(&indent);
            out.push_str(line);
        }
        out.push('\n');
        out
    })
}

impl Section {
    /// Keywords that begin the section.
    fn keywords(self) -> &'static str {
        match self {
            Self::Input => "VAR_INPUT",
            Self::Output => "VAR_OUTPUT",
            Self::Local => "VAR",
            Self::Constant => "VAR CONSTANT",
            Self::Temporary => "VAR_TEMP",
        }
    }
}

impl Type {
    fn to_text(&self) -> String {
        match self {
            Self::Bool => "BOOL".to_owned(),
            Self::Integer(width) => width.keyword().to_owned(),
            Self::Enumeration(name) => name.clone(),
            Self::Text(max_chars) => format!("STRING[{max_chars}]"),
            Self::Array(first, last, of) => format!("ARRAY[{first}..{last}] OF {}", of.to_text()),
        }
    }
}

impl Enumeration {
    fn text(&self) -> TypeText<'_> {
        let last = self.labels.len().saturating_sub(1);
        let labels = self
            .labels
            .iter()
            .enumerate()
            .map(|(place, (label, meaning))| {
                let comma = if place < last { "," } else { "" };
                let meaning = match meaning.as_str() {
                    "" => String::new(),
                    meaning => format!(" (* {meaning} *)"),
                };
                format!("{label}{comma}{meaning}")
            });
        TypeText {
            description: &self.description,
            name: &self.name,
            labels: labels.collect(),
        }
    }
}

impl Variable {
    fn to_text(&self) -> String {
        let mut out = format!("{} : {}", self.name, self.kind.to_text());
        match &self.initial {
            Initial::Default => {}
            Initial::Value(value) => {
                let _ = write!(out, " := {value}");
            }
            Initial::Values(values) => {
                let _ = write!(out, " := [{}]", values.join(", "));
            }
        }
        let text = wrap(&out, "    ") + ";";
        if self.description.is_empty() {
            return text + "\n";
        }
        let comment = format!("(* {} *)", self.description);
        if text.len() + comment.len() < WIDTH {
            format!("{text} {comment}\n")
        } else {
            format!("{}\n{text}\n", wrap(&comment, "   "))
        }
    }
}

impl Block {
    /// Returns the types and the function block as text.
    pub fn to_text(&self) -> String {
        let sections = self.sections.iter().map(|(section, variables)| {
            let variables = variables.iter();
            let texts = variables.map(|v| indented(&v.to_text(), 1).trim_end().to_owned());
            SectionText {
                keywords: section.keywords(),
                variables: texts.collect(),
            }
        });
        render(
            "structured_text/block.st",
            BlockText {
                types: self.types.iter().map(Enumeration::text).collect(),
                description: self.description_text().trim_end().to_owned(),
                name: &self.name,
                sections: sections.collect(),
                body: self.body.trim_end(),
            },
        )
    }

    /// The description as wrapped lines.
    pub(super) fn description_text(&self) -> String {
        let lines = self.description.iter();
        lines.fold(String::new(), |mut out, line| {
            let rest = line.trim_start();
            let indent = &line[..line.len() - rest.len()];
            let further = if indent.is_empty() { "" } else { "      " };
            out.push_str(indent);
            out.push_str(&wrap(rest, further));
            out.push('\n');
            out
        })
    }
}
