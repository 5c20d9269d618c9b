//! Parses the sections of a file.

use super::ast::{Entry, File, Section, Shape, Signal};
use super::lexer::{Token, Word};
use super::operators::is_reserved;
use super::report::Report;
use crate::names::quoted;
use std::ops::Range;

/// Maximum nesting depth of expressions.
pub(super) const MAX_NESTING: usize = 500;

pub(super) struct Parser<'t, 'r> {
    pub text: &'t str,
    pub tokens: &'t [Token],
    pub at: usize,
    pub report: &'r mut Report,
    depth: usize,
}

impl<'t, 'r> Parser<'t, 'r> {
    pub fn new(text: &'t str, tokens: &'t [Token], report: &'r mut Report) -> Self {
        Self {
            text,
            tokens,
            at: 0,
            report,
            depth: 0,
        }
    }

    pub fn word(&self, range: &Range<usize>) -> &'t str {
        &self.text[range.clone()]
    }

    /// Text of the next token; `None` at the end of the file.
    pub fn peek(&self) -> Option<&'t str> {
        self.tokens.get(self.at).map(|t| self.word(&t.range))
    }

    /// Consumes the next token if it is `word`.
    pub fn take(&mut self, word: &str) -> bool {
        let found = self.peek() == Some(word);
        self.at += usize::from(found);
        found
    }

    /// Consumes `word` and returns its end. If the next token is not `word`, reports this and
    /// returns `None`.
    pub fn expect(&mut self, word: &str) -> Option<usize> {
        if self.take(word) {
            return Some(self.tokens[self.at - 1].range.end);
        }
        self.missing(&format!("`{word}`"))
    }

    /// Byte range of the next token, or the end of the text.
    pub(super) fn here(&self) -> Range<usize> {
        if let Some(token) = self.tokens.get(self.at) {
            return token.range.clone();
        }
        let end = self.tokens.last().map_or(0, |t| t.range.end);
        end..end
    }

    pub fn missing<T>(&mut self, what: &str) -> Option<T> {
        let help = match self.peek() {
            Some(word) if is_reserved(word) && what == "an expression" => {
                format!("`{word}` is a keyword: write the missing operand, or use another name")
            }
            _ if what == "an expression" => {
                "write the missing operand: a formula, a number or a set".to_owned()
            }
            _ => "write sections in braces, and end formulas with `;`".to_owned(),
        };
        self.missing_with(what, help)
    }

    /// Reports that `what` is expected at the next token.
    pub fn missing_with<T>(&mut self, what: &str, help: impl Into<String>) -> Option<T> {
        let found = match self.peek() {
            Some(word) => format!("`{}`", quoted(word)),
            None => "the end of the file".to_owned(),
        };
        self.report
            .syntax(self.here(), format!("expected {what}, found {found}"), help);
        None
    }

    pub fn too_deep<T>(&mut self) -> Option<T> {
        self.report.error(
            linewright_core::diagnostics::codes::TOO_LARGE,
            self.here(),
            format!("this expression nests more than {MAX_NESTING} levels deep"),
            "define parts of it under DEFINITIONS",
        );
        None
    }

    pub fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.depth >= MAX_NESTING {
            return self.too_deep();
        }
        self.depth += 1;
        let found = read(self);
        self.depth -= 1;
        found
    }

    /// Skips to the token after the next `;` of this block, or to the brace that ends the block.
    pub(super) fn recover(&mut self) {
        let mut open = 0_usize;
        while let Some(word) = self.peek() {
            match word {
                "}" if open == 0 => return,
                ";" if open == 0 => {
                    self.at += 1;
                    return;
                }
                "{" => open += 1,
                "}" => open -= 1,
                _ => {}
            }
            self.at += 1;
        }
    }

    /// Parses a name that is not reserved; `what` describes it in messages.
    pub(super) fn name(&mut self, what: &str) -> Option<(String, Range<usize>)> {
        match self.tokens.get(self.at) {
            Some(token) if token.word == Word::Name && !is_reserved(self.word(&token.range)) => {
                self.at += 1;
                Some((self.word(&token.range).to_owned(), token.range.clone()))
            }
            _ => self.missing(what),
        }
    }

    /// Parses the whole file.
    pub fn file(&mut self) -> File {
        let mut file = File::default();
        let mut seen: Vec<&str> = Vec::new();
        while let Some(word) = self.peek() {
            let place = self.here();
            if !matches!(word, "INFO" | "GLOBAL" | "MAIN") {
                self.report.syntax(
                    place,
                    format!("expected INFO, GLOBAL or MAIN, found `{}`", quoted(word)),
                    "write the sections INFO { ... }, GLOBAL { ... } (optional) and MAIN { ... }",
                );
                while self
                    .peek()
                    .is_some_and(|w| !matches!(w, "INFO" | "GLOBAL" | "MAIN"))
                {
                    self.at += 1;
                }
                continue;
            }
            if seen.contains(&word) {
                self.report.syntax(
                    place,
                    format!("the section {word} appears twice"),
                    "join the two sections",
                );
            }
            seen.push(word);
            self.at += 1;
            if self.expect("{").is_none() {
                continue;
            }
            match word {
                "INFO" => self.info(&mut file),
                "GLOBAL" => self.global(&mut file),
                _ => self.main(&mut file),
            }
        }
        for needed in ["INFO", "MAIN"] {
            if !seen.contains(&needed) {
                self.report.syntax(
                    0..0,
                    format!("the section {needed} is missing"),
                    "write the sections INFO { ... } and MAIN { ... }",
                );
            }
        }
        file
    }

    fn global(&mut self, file: &mut File) {
        loop {
            match self.peek() {
                Some("}") => {
                    self.at += 1;
                    return;
                }
                Some(word @ ("PARAMETERS" | "DEFINITIONS")) => {
                    self.at += 1;
                    if self.expect("{").is_none() {
                        return;
                    }
                    let parameter = word == "PARAMETERS";
                    self.block(|parser| parser.definition(parameter, file));
                }
                _ => {
                    let _: Option<()> = self.missing("PARAMETERS, DEFINITIONS or `}`");
                    return self.leave();
                }
            }
        }
    }

    /// Skips an invalid section.
    pub(super) fn leave(&mut self) {
        while self
            .peek()
            .is_some_and(|w| !matches!(w, "INFO" | "GLOBAL" | "MAIN"))
        {
            self.at += 1;
        }
    }

    /// Parses entries that are separated by `;`, up to the closing brace.
    pub(super) fn block(&mut self, mut entry: impl FnMut(&mut Self) -> Option<()>) {
        loop {
            match self.peek() {
                None => {
                    let _: Option<()> = self.missing("`}`");
                    return;
                }
                Some("}") => {
                    self.at += 1;
                    return;
                }
                Some(";") => self.at += 1,
                Some(_) => {
                    let before = self.at;
                    let done = entry(self).is_some();
                    if done && matches!(self.peek(), None | Some(";" | "}")) {
                        continue;
                    }
                    if done {
                        let _: Option<()> = self.missing("`;`");
                    }
                    self.recover();
                    if self.at == before {
                        self.at += 1;
                    }
                }
            }
        }
    }

    fn main(&mut self, file: &mut File) {
        loop {
            let Some(word) = self.peek() else {
                let _: Option<()> = self.missing("`}`");
                return;
            };
            if word == "}" {
                self.at += 1;
                return;
            }
            let section = match word {
                "INITIALLY" => Section::Initially,
                "PRESET" => Section::Preset,
                "REQUIRE" | "REQUIREMENTS" => Section::Require,
                "ASSUME" | "ASSUMPTIONS" => Section::Assume,
                "ASSERT" | "INVARIANTS" => Section::Assert,
                "GUARANTEE" | "GUARANTEES" => Section::Guarantee,
                "INPUTS" | "OUTPUTS" => {
                    self.at += 1;
                    if self.expect("{").is_none() {
                        return self.leave();
                    }
                    let input = word == "INPUTS";
                    self.block(|parser| parser.signal(input, file));
                    continue;
                }
                _ => {
                    self.report.syntax(
                        self.here(),
                        format!("`{}` is not a section of MAIN", quoted(word)),
                        "MAIN has INPUTS, OUTPUTS, INITIALLY, PRESET, REQUIRE, ASSUME, ASSERT and GUARANTEE, each followed by braces",
                    );
                    return self.leave();
                }
            };
            let place = self.here();
            self.at += 1;
            if self.expect("{").is_none() {
                return self.leave();
            }
            let heading = word.to_owned();
            self.block(|parser| {
                let tree = parser.expression()?;
                file.entries.push(Entry {
                    section,
                    heading: heading.clone(),
                    place: place.clone(),
                    tree,
                });
                Some(())
            });
        }
    }

    /// Parses a signal: `x`, `x[n]` or `type x`.
    fn signal(&mut self, input: bool, file: &mut File) -> Option<()> {
        let (name, place) = self.name("the name of a signal")?;
        let next = self.tokens.get(self.at);
        let (name, place, shape) = if self.take("[") {
            let size = self.expression()?;
            self.expect("]")?;
            (name, place, Shape::Bus(size))
        } else if next.is_some_and(|t| t.word == Word::Name) {
            let (second, at) = self.name("the name of a signal")?;
            (second, at, Shape::Typed(name, place))
        } else {
            (name, place, Shape::Single)
        };
        file.signals.push(Signal {
            name,
            place,
            input,
            shape,
        });
        Some(())
    }
}
