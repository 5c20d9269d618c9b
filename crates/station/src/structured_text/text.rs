//! A block as Structured Text.

use super::{Block, Enumeration, Initial, Section, Type, Variable};
use std::fmt::Write;

/// A variable and its comment stand on one line of at most so many characters, or on two.
const WIDTH: usize = 110;

/// Breaks a long text at its spaces; `indent` begins the further lines.
pub(super) fn wrap(text: &str, indent: &str) -> String {
    crate::emit::text::wrap(text, indent)
}

/// The same for a condition: a test, from its bracket to the next one, stays on its line.
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

/// The same lines, so many levels further in.
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
    /// The keywords that begin it.
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
            Self::Text(most) => format!("STRING[{most}]"),
            Self::Array(first, last, of) => format!("ARRAY[{first}..{last}] OF {}", of.to_text()),
        }
    }
}

impl Enumeration {
    fn to_text(&self) -> String {
        let mut out = String::new();
        if !self.description.is_empty() {
            let _ = writeln!(out, "(* {} *)", self.description);
        }
        let _ = writeln!(out, "TYPE {} :\n(", self.name);
        for (place, (label, meaning)) in self.labels.iter().enumerate() {
            let comma = if place + 1 < self.labels.len() {
                ","
            } else {
                ""
            };
            let _ = write!(out, "    {label}{comma}");
            if !meaning.is_empty() {
                let _ = write!(out, " (* {meaning} *)");
            }
            out.push('\n');
        }
        out.push_str(");\nEND_TYPE\n\n");
        out
    }
}

impl Variable {
    fn to_text(&self) -> String {
        let mut out = format!("{} : {}", self.name, self.kind.to_text());
        match &self.initial {
            Initial::Usual => {}
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
    /// The types and the function block, as text.
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        for declared in &self.types {
            out.push_str(&declared.to_text());
        }
        out.push_str("(*\n");
        out.push_str(&self.description_text());
        let _ = writeln!(out, "*)\nFUNCTION_BLOCK {}", self.name);
        for (section, variables) in &self.sections {
            let _ = writeln!(out, "{}", section.keywords());
            for variable in variables {
                out.push_str(&indented(&variable.to_text(), 1));
            }
            out.push_str("END_VAR\n");
        }
        out.push('\n');
        out.push_str(&self.body);
        out.push_str("END_FUNCTION_BLOCK\n");
        out
    }

    /// The description in lines of a bearable width.
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
