//! Parses a file into declarations. After an error, parsing continues after the next `;` or at the
//! next declaration.
//!
//! The parser is written by hand rather than with pest, so that it finds the errors of all
//! declarations at once and can limit the nesting.

mod counter;
mod declarations;
mod definitions;
mod formulas;
mod regexps;
mod statement;
mod types;
mod words;

use super::syntax::{Declaration, Name, TemporalForm};
use crate::names::quoted;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Owner;
use linewright_core::source::{FileId, Span};
use std::ops::Range;
pub(super) use words::one_line;
use words::{Token, Word, words};

/// Maximum nesting depth of formulas.
pub(super) const MAX_NESTING: u32 = 400;

/// Marker for an error that is already in the findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Reported;

pub(super) type Parsed<T> = Result<T, Reported>;

pub(super) struct Parser<'t> {
    text: &'t str,
    file: FileId,
    tokens: Vec<Token>,
    at: usize,
    pub depth: u32,
    pub findings: Vec<Diagnostic>,
}

const DECLARATIONS: &str = "begin the file with `spec NAME`; then write types, variables (`env`, `sys`, `aux`), `define`, `predicate`, `pattern`, `monitor`, `counter`, `regexp`, `asm` and `gar`";

/// Whether a word begins a declaration.
fn begins_declaration(word: &str) -> bool {
    owner(word).is_some()
        || matches!(
            word,
            "type"
                | "define"
                | "predicate"
                | "pattern"
                | "monitor"
                | "weight"
                | "guarantee"
                | "gar"
                | "assumption"
                | "asm"
                | "counter"
                | "regtest"
                | "import"
                | "spec"
                | "module"
        )
}

/// The owner of the variable that a word declares, and whether the variable is auxiliary.
fn owner(word: &str) -> Option<(Owner, bool)> {
    match word {
        "output" | "out" | "sysvar" | "sys" => Some((Owner::System, false)),
        "input" | "envvar" | "env" | "in" => Some((Owner::Environment, false)),
        "auxvar" | "aux" => Some((Owner::System, true)),
        _ => None,
    }
}

fn when(word: &str) -> Option<TemporalForm> {
    match word {
        "ini" | "initially" => Some(TemporalForm::Initially),
        "G" | "trans" => Some(TemporalForm::Transition),
        "always" | "alw" => Some(TemporalForm::Always),
        "GF" | "alwEv" | "alwaysEventually" => Some(TemporalForm::Repeatedly),
        _ => None,
    }
}

/// Whether a word is reserved.
pub(crate) fn is_keyword(word: &str) -> bool {
    begins_declaration(word)
        || when(word).is_some()
        || matches!(
            word,
            "boolean" | "Int" | "true" | "false" | "TRUE" | "FALSE" | "next" | "regexp" | "forall"
        )
        || matches!(
            word,
            "exists" | "in" | "not" | "and" | "or" | "xor" | "iff" | "implies" | "mod" | "trig"
        )
        || matches!(
            word,
            "PREV" | "Y" | "ONCE" | "O" | "HISTORICALLY" | "H" | "SINCE" | "S" | "TRIGGERED" | "T"
        )
        || matches!(word, "var" | "GE" | "GEF")
}

/// Parses a text into its declarations and the findings.
pub(super) fn parse(file: FileId, text: &str) -> (Vec<Declaration>, Vec<Diagnostic>) {
    let mut parser = Parser {
        text,
        file,
        tokens: words(text),
        at: 0,
        depth: 0,
        findings: Vec::new(),
    };
    let found = parser.file();
    (found, parser.findings)
}

impl<'t> Parser<'t> {
    pub fn text(&self) -> &'t str {
        self.text
    }

    fn token(&self) -> Token {
        self.tokens[self.at.min(self.tokens.len() - 1)].clone()
    }

    fn ahead(&self, by: usize) -> Token {
        self.tokens[(self.at + by).min(self.tokens.len() - 1)].clone()
    }

    /// The text of the current token if it is a name or keyword, otherwise an empty text.
    pub fn word(&self) -> &'t str {
        match self.token() {
            (Word::Name, range) => &self.text[range],
            _ => "",
        }
    }

    pub fn word_ahead(&self, by: usize) -> &'t str {
        match self.ahead(by) {
            (Word::Name, range) => &self.text[range],
            _ => "",
        }
    }

    pub fn is_ahead(&self, by: usize, sign: &'static str) -> bool {
        self.ahead(by).0 == Word::Sign(sign)
    }

    pub fn next(&mut self) -> Range<usize> {
        let (_, range) = self.token();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        range
    }

    pub fn is(&self, sign: &'static str) -> bool {
        self.token().0 == Word::Sign(sign)
    }

    pub fn take(&mut self, sign: &'static str) -> bool {
        let found = self.is(sign);
        if found {
            self.next();
        }
        found
    }

    pub fn take_word(&mut self, word: &str) -> bool {
        let found = self.word() == word;
        if found {
            self.next();
        }
        found
    }

    pub fn span(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end)
    }

    /// Byte offset of the current token.
    pub fn start(&self) -> usize {
        self.token().1.start
    }

    /// The location from `start` to the end of the last consumed token.
    pub fn since(&self, start: usize) -> Span {
        let end = self.tokens[self.at.saturating_sub(1)].1.end;
        self.span(start..end.max(start))
    }

    pub fn report<T>(
        &mut self,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Parsed<T> {
        let span = self.span(range);
        self.findings
            .push(Diagnostic::error(codes::SYNTAX, span, message).with_help(help));
        Err(Reported)
    }

    /// Reports that the current token is not the expected one.
    pub fn unexpected<T>(&mut self, expected: &str, help: &str) -> Parsed<T> {
        let (word, range) = self.token();
        // The valid uses of this sign, in regular expressions, are parsed elsewhere.
        if word == Word::Sign("?") {
            return self.report(
                range,
                "Spectra has no conditional operator `c ? a : b`",
                "write `ite(c, a, b)`",
            );
        }
        let found = match word {
            Word::End => "the end of the file".to_owned(),
            _ => format!("`{}`", quoted(&self.text[range.clone()])),
        };
        self.report(range, format!("expected {expected}, found {found}"), help)
    }

    pub fn expect(&mut self, sign: &'static str, help: &str) -> Parsed<()> {
        if self.take(sign) {
            return Ok(());
        }
        self.unexpected(&format!("`{sign}`"), help)
    }

    pub fn name(&mut self, what: &str) -> Parsed<Name> {
        self.name_or(what, &[])
    }

    /// Parses a name that parentheses can follow; before `(`, `forall` and `exists` are names too.
    fn name_of_definition(&mut self, what: &str) -> Parsed<Name> {
        let quantifiers: &[&str] = if self.is_ahead(1, "(") {
            &["forall", "exists"]
        } else {
            &[]
        };
        self.name_or(what, quantifiers)
    }

    /// Parses a name; the `allowed` keywords count as names.
    fn name_or(&mut self, what: &str, allowed: &[&str]) -> Parsed<Name> {
        let word = self.word();
        if word.is_empty() {
            return self.unexpected(what, "use letters, digits and `_` in a name");
        }
        if is_keyword(word) && !allowed.contains(&word) {
            return self.unexpected(
                what,
                "this is a keyword; use another name, or write `^` before it",
            );
        }
        let range = self.next();
        Ok(Name {
            text: word.trim_start_matches('^').to_owned(),
            span: self.span(range),
        })
    }

    fn file(&mut self) -> Vec<Declaration> {
        let mut found = Vec::new();
        let mut named = false;
        while self.token().0 != Word::End {
            let before = self.at;
            self.depth = 0;
            if matches!(self.word(), "spec" | "module") {
                let range = self.next();
                if named {
                    let _ = self.report::<()>(
                        range,
                        "the file already has a `spec`",
                        "write `spec NAME` once, after the imports",
                    );
                }
                named = true;
                if self.name("the specification's name").is_err()
                    && !begins_declaration(self.word())
                    && self.token().0 == Word::Name
                {
                    self.next();
                }
                continue;
            }
            if self.declaration(&mut found).is_err() {
                self.resume(before);
            }
        }
        if !named && self.findings.is_empty() {
            let imports = found
                .iter()
                .rposition(|d| matches!(d, Declaration::Import(..)));
            let place = match imports.map(|i| &found[i]) {
                Some(Declaration::Import(_, span)) => span.end as usize..span.end as usize,
                _ => 0..self.text.len().min(1),
            };
            let _ = self.report::<()>(
                place,
                "the specification has no name",
                "write `spec NAME` here, after the imports and before the first declaration",
            );
        }
        found
    }

    /// Skips the rest of an invalid declaration whose first token has the index `from`.
    fn resume(&mut self, from: usize) {
        if self.at == from {
            self.next();
        }
        loop {
            match self.token().0 {
                Word::End => return,
                Word::Sign(";") => {
                    self.next();
                    // A `;` within braces, or before a closing brace, does not end the declaration.
                    if !self.is("}") && !self.inside(from) {
                        return;
                    }
                }
                Word::Name
                    if begins_declaration(self.word()) && self.word() != "in" && self.at > from =>
                {
                    return;
                }
                _ => {
                    self.next();
                }
            }
        }
    }

    /// Whether braces that were opened since the token `from` are still open.
    fn inside(&self, from: usize) -> bool {
        let mut open = 0_i64;
        for (word, _) in &self.tokens[from..self.at] {
            match word {
                Word::Sign("{") => open += 1,
                Word::Sign("}") => open -= 1,
                _ => {}
            }
        }
        open > 0
    }

    fn end(&mut self) -> Parsed<()> {
        let (last, next) = (self.at.saturating_sub(1), self.token().1);
        let before = self.tokens[last].1.clone();
        let between = self.text.get(before.end..next.start);
        if !self.is(";") && between.is_some_and(|text| text.contains('\n')) {
            let word = quoted(&self.text[before.clone()]);
            return self.report(
                before,
                format!("`;` is missing after `{word}`"),
                "declarations end with `;`",
            );
        }
        self.expect(";", "declarations end with `;`")
    }

    /// Increments the nesting depth. If it becomes too large, reports this and returns an error.
    pub fn deeper(&mut self) -> Parsed<()> {
        self.depth += 1;
        if self.depth > MAX_NESTING {
            let range = self.token().1;
            self.depth = 0;
            return self.report(
                range,
                format!("this nests more than {MAX_NESTING} levels deep"),
                "name parts of it with `define`",
            );
        }
        Ok(())
    }
}
