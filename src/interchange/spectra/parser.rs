//! Reads words into declarations. A mistake is reported, and reading goes on behind the next `;` or at the next declaration.
//!
//! By hand rather than with pest: each declaration is read on its own, so that all mistakes of a file are found at once, and the nesting is
//! counted while it is read.

use super::syntax::{
    Body, Clause, Counter, Declaration, Define, Elements, Monitor, Name, Overflow, Parameter,
    Pattern, Predicate, Statement, When,
};
use super::words::{Token, Word, words};
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::Owner;
use crate::interchange::names::quoted;
use crate::source::{FileId, Span};
use std::ops::Range;

/// Formulas may nest so deeply.
pub(super) const MAX_NESTING: u32 = 400;

/// A mistake was reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Told;

pub(super) type Parsed<T> = Result<T, Told>;

pub(super) struct Parser<'t> {
    text: &'t str,
    file: FileId,
    tokens: Vec<Token>,
    at: usize,
    pub depth: u32,
    pub findings: Vec<Diagnostic>,
}

const DECLARATIONS: &str = "a file begins with `spec NAME` and goes on with types, variables (`env`, `sys`, `aux`), `define`, `predicate`, `pattern`, `monitor`, `counter`, `regexp`, `asm` and `gar`";

/// The words that begin a declaration.
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

/// Whose variable a word declares, and whether it is an auxiliary one.
fn owner(word: &str) -> Option<(Owner, bool)> {
    match word {
        "output" | "out" | "sysvar" | "sys" => Some((Owner::System, false)),
        "input" | "envvar" | "env" | "in" => Some((Owner::Environment, false)),
        "auxvar" | "aux" => Some((Owner::System, true)),
        _ => None,
    }
}

fn when(word: &str) -> Option<When> {
    match word {
        "ini" | "initially" => Some(When::Initially),
        "G" | "trans" => Some(When::Transition),
        "always" | "alw" => Some(When::Always),
        "GF" | "alwEv" | "alwaysEventually" => Some(When::Repeatedly),
        _ => None,
    }
}

/// Words that are no names.
pub(in crate::interchange) fn is_keyword(word: &str) -> bool {
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

/// Reads a text: the specification's name, and what it declares.
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

    pub fn token(&self) -> Token {
        self.tokens[self.at.min(self.tokens.len() - 1)].clone()
    }

    fn ahead(&self, by: usize) -> Token {
        self.tokens[(self.at + by).min(self.tokens.len() - 1)].clone()
    }

    /// The word at hand as it is written; nothing for what is no name.
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

    /// Where the word at hand begins.
    pub fn start(&self) -> usize {
        self.token().1.start
    }

    /// From `start` to the end of the last word read.
    pub fn since(&self, start: usize) -> Span {
        let end = self.tokens[self.at.saturating_sub(1)].1.end;
        self.span(start..end.max(start))
    }

    pub fn told<T>(
        &mut self,
        range: Range<usize>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Parsed<T> {
        let span = self.span(range);
        self.findings
            .push(Diagnostic::error(codes::SYNTAX, span, message).with_help(help));
        Err(Told)
    }

    /// The word at hand is not what was expected.
    pub fn unexpected<T>(&mut self, expected: &str, help: &str) -> Parsed<T> {
        let (word, range) = self.token();
        let found = match word {
            Word::End => "the end of the file".to_owned(),
            _ => format!("`{}`", quoted(&self.text[range.clone()])),
        };
        self.told(range, format!("expected {expected}, found {found}"), help)
    }

    pub fn expect(&mut self, sign: &'static str, help: &str) -> Parsed<()> {
        if self.take(sign) {
            return Ok(());
        }
        self.unexpected(&format!("`{sign}`"), help)
    }

    pub fn name(&mut self, what: &str) -> Parsed<Name> {
        let word = self.word();
        if word.is_empty() {
            return self.unexpected(what, "names are made of letters, digits and `_`");
        }
        if is_keyword(word) {
            return self.unexpected(
                what,
                "this word belongs to the language; write another name, or `^` before it",
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
                    let _ = self.told::<()>(
                        range,
                        "there is a specification already",
                        "a file has one `spec NAME`, behind its imports",
                    );
                }
                named = true;
                let _ = self.name("the specification's name");
                continue;
            }
            if self.declaration(&mut found).is_err() {
                self.resume(before);
            }
        }
        if !named && self.findings.is_empty() {
            let end = self.text.len();
            let _ = self.told::<()>(
                0..end.min(1),
                "the specification has no name",
                "write `spec NAME` behind the imports",
            );
        }
        found
    }

    /// Skips the rest of a declaration that begins at `from` and could not be read.
    fn resume(&mut self, from: usize) {
        if self.at == from {
            self.next();
        }
        loop {
            match self.token().0 {
                Word::End => return,
                Word::Sign(";") => {
                    self.next();
                    // What is left of braces, and of the declarations in them.
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

    /// Whether braces that were opened since a word are still open.
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
        self.expect(";", "declarations end with `;`")
    }

    fn declaration(&mut self, found: &mut Vec<Declaration>) -> Parsed<()> {
        let start = self.start();
        let word = self.word();
        if let Some(owner) = owner(word) {
            self.next();
            let variable = self.variable()?;
            self.end()?;
            found.push(Declaration::Variable(owner, variable));
            return Ok(());
        }
        match word {
            "import" => {
                self.next();
                let (word, range) = self.token();
                if word != Word::Quoted {
                    return self.unexpected(
                        "a file's name in quotes",
                        "write `import \"other.spectra\"`",
                    );
                }
                self.next();
                let path = self.text[range.start + 1..range.end - 1].to_owned();
                let span = self.since(start);
                self.take(";");
                found.push(Declaration::Import(path, span));
            }
            "type" => {
                self.next();
                let name = self.name("the type's name")?;
                self.expect(
                    "=",
                    "write `type NAME = {a, b};` or `type NAME = Int(0..3);`",
                )?;
                let of = self.type_name()?;
                self.end()?;
                found.push(Declaration::Type(name, of));
            }
            "define" => {
                self.next();
                loop {
                    found.push(Declaration::Define(self.define()?));
                    if !self.at_name() {
                        break;
                    }
                }
            }
            "regexp" => {
                self.next();
                loop {
                    let name = self.name("the regular expression's name")?;
                    self.expect(":=", "write `regexp NAME := [p] [q]*;`")?;
                    let regexp = self.regexp()?;
                    self.end()?;
                    found.push(Declaration::Regexp(name, regexp));
                    if !self.at_name() {
                        break;
                    }
                }
            }
            "predicate" => found.push(Declaration::Predicate(self.predicate()?)),
            "pattern" => found.push(Declaration::Pattern(self.pattern()?)),
            "monitor" => {
                self.next();
                let variable = self.variable()?;
                let clauses = self.clauses("monitor")?;
                found.push(Declaration::Monitor(Monitor { variable, clauses }));
            }
            "counter" => found.push(Declaration::Counter(Box::new(self.counter()?))),
            "weight" => {
                self.next();
                if !self.word().is_empty() && self.is_ahead(1, ":") {
                    self.next();
                    self.next();
                }
                self.take("-");
                if self.token().0 != Word::Number {
                    return self.unexpected("a number", "write `weight NAME: 3 formula;`");
                }
                self.next();
                self.formula()?;
                self.end()?;
                found.push(Declaration::Ignored("weight", self.since(start)));
            }
            "regtest" => {
                self.next();
                if !self.word().is_empty() && self.is_ahead(1, ":") {
                    self.next();
                    self.next();
                }
                self.regexp()?;
                self.end()?;
                found.push(Declaration::Ignored("regtest", self.since(start)));
            }
            "guarantee" | "gar" => {
                found.push(Declaration::Statement(self.statement(Owner::System)?));
            }
            "assumption" | "asm" => {
                found.push(Declaration::Statement(self.statement(Owner::Environment)?));
            }
            _ => return self.unexpected("a declaration", DECLARATIONS),
        }
        Ok(())
    }

    fn at_name(&self) -> bool {
        let word = self.word();
        !word.is_empty() && !is_keyword(word)
    }

    /// `Int(0..3) x`
    fn variable(&mut self) -> Parsed<Parameter> {
        let of = self.type_name()?;
        let name = self.name("a variable's name")?;
        Ok(Parameter { of, name })
    }

    fn define(&mut self) -> Parsed<Define> {
        let name = self.name("the define's name")?;
        let sizes = self.sizes()?;
        self.expect(":=", "write `define NAME := formula;`")?;
        let value = if sizes.is_empty() {
            Elements::One(self.formula()?)
        } else {
            self.elements()?
        };
        self.end()?;
        Ok(Define { name, sizes, value })
    }

    fn elements(&mut self) -> Parsed<Elements> {
        let start = self.start();
        self.expect("{", "an array's elements stand in braces: `{a, b}`")?;
        self.deeper()?;
        let mut found = Vec::new();
        loop {
            found.push(if self.is("{") {
                self.elements()?
            } else {
                Elements::One(self.formula()?)
            });
            if !self.take(",") {
                break;
            }
        }
        self.depth -= 1;
        self.expect("}", "an array's elements stand in braces: `{a, b}`")?;
        Ok(Elements::Many(found, self.since(start)))
    }

    /// Counts the nesting.
    pub fn deeper(&mut self) -> Parsed<()> {
        self.depth += 1;
        if self.depth > MAX_NESTING {
            let range = self.token().1;
            self.depth = 0;
            return self.told(
                range,
                format!("this nests more than {MAX_NESTING} deep"),
                "give parts of it names with `define`",
            );
        }
        Ok(())
    }

    fn predicate(&mut self) -> Parsed<Predicate> {
        self.next();
        let name = self.name("the predicate's name")?;
        let parameters = if self.take("(") {
            let found = if self.is(")") {
                Vec::new()
            } else {
                self.parameters()?
            };
            self.expect(
                ")",
                "parameters stand in parentheses: `predicate p(boolean a):`",
            )?;
            found
        } else {
            Vec::new()
        };
        let body = if self.take("{") {
            let body = self.formula()?;
            self.take(";");
            self.expect("}", "write `predicate p(boolean a) { formula }`")?;
            body
        } else {
            self.expect(":", "write `predicate p(boolean a): formula;`")?;
            let body = self.formula()?;
            self.end()?;
            body
        };
        Ok(Predicate {
            name,
            parameters,
            body,
        })
    }

    fn parameters(&mut self) -> Parsed<Vec<Parameter>> {
        let mut found = vec![self.variable()?];
        while self.take(",") {
            found.push(self.variable()?);
        }
        Ok(found)
    }

    fn pattern(&mut self) -> Parsed<Pattern> {
        self.next();
        let name = self.name("the pattern's name")?;
        let mut parameters = Vec::new();
        if self.take("(") {
            while !self.is(")") {
                parameters.push(self.name("a parameter")?);
                if !self.take(",") {
                    break;
                }
            }
            self.expect(")", "parameters stand in parentheses: `pattern p(a, b) {`")?;
        }
        let mut variables = Vec::new();
        self.expect("{", "a pattern's formulas stand in braces")?;
        while self.take_word("var") {
            variables.push(self.variable()?);
            self.end()?;
        }
        let clauses = self.clauses_inside()?;
        Ok(Pattern {
            name,
            parameters,
            variables,
            clauses,
        })
    }

    fn clauses(&mut self, what: &str) -> Parsed<Vec<Clause>> {
        self.expect("{", &format!("a {what}'s formulas stand in braces"))?;
        self.clauses_inside()
    }

    fn clauses_inside(&mut self) -> Parsed<Vec<Clause>> {
        let mut found = Vec::new();
        while !self.take("}") {
            if self.token().0 == Word::End {
                return self.unexpected("`}`", "the braces are not closed");
            }
            found.push(self.clause()?);
            self.end()?;
        }
        Ok(found)
    }

    fn clause(&mut self) -> Parsed<Clause> {
        let start = self.start();
        let operator = when(self.word());
        if operator.is_some() {
            self.next();
        }
        let node = self.formula()?;
        Ok(Clause {
            when: operator.unwrap_or(When::Initially),
            explicit: operator.is_some(),
            node,
            span: self.since(start),
        })
    }

    fn counter(&mut self) -> Parsed<Counter> {
        self.next();
        let name = self.name("the counter's name")?;
        let help = "write `counter NAME(0..9) { NAME = 0; inc: p; reset: q; overflow: keep; }`";
        self.expect("(", help)?;
        let (low, high) = self.range()?;
        self.expect(")", help)?;
        self.expect("{", help)?;
        let mut counter = Counter {
            name,
            low,
            high,
            initial: Vec::new(),
            reset: Vec::new(),
            up: Vec::new(),
            down: Vec::new(),
            overflow: None,
            underflow: None,
        };
        while !self.take("}") {
            if self.token().0 == Word::End {
                return self.unexpected("`}`", "the braces are not closed");
            }
            let section = if self.is_ahead(1, ":") {
                self.word()
            } else {
                ""
            };
            if section.is_empty() {
                if matches!(self.word(), "ini" | "initially") {
                    self.next();
                }
                counter.initial.push(self.formula()?);
            } else {
                let start = self.start();
                if !matches!(section, "reset" | "inc" | "dec" | "overflow" | "underflow") {
                    return self.unexpected(
                        "a section of a counter",
                        "sections are `reset:`, `inc:`, `dec:`, `overflow:` and `underflow:`",
                    );
                }
                self.next();
                self.next();
                match section {
                    "reset" => counter.reset.push(self.formula()?),
                    "inc" => counter.up.push(self.formula()?),
                    "dec" => counter.down.push(self.formula()?),
                    _ => {
                        let method = match self.word() {
                            "keep" => Overflow::Keep,
                            "false" => Overflow::Refuse,
                            "modulo" => Overflow::Modulo,
                            _ => {
                                return self.unexpected("`keep`, `false` or `modulo`", "`keep` stays at the end of the range, `modulo` goes on at the other end, `false` forbids to leave it");
                            }
                        };
                        self.next();
                        let method = Some((method, self.since(start)));
                        if section == "overflow" {
                            counter.overflow = method;
                        } else {
                            counter.underflow = method;
                        }
                    }
                }
            }
            self.end()?;
        }
        Ok(counter)
    }

    fn statement(&mut self, side: Owner) -> Parsed<Statement> {
        self.next();
        let mut name = None;
        let mut parameters = Vec::new();
        if self.at_name() && (self.is_ahead(1, ":") || self.is_ahead(1, "{")) {
            name = Some(self.name("a name")?);
            if self.take("{") {
                parameters = self.parameters()?;
                self.expect(
                    "}",
                    "parameters stand in braces: `gar name{Int(0..3) i}: ...`",
                )?;
            }
            self.expect(":", "a name is followed by `:`")?;
        }
        let start = self.start();
        let body = match self.word() {
            "trig" => {
                self.next();
                let from = self.regexp()?;
                self.expect("|=>", "write `trig r |=> e;`")?;
                Body::Trigger(from, self.regexp()?)
            }
            "GE" => {
                self.next();
                self.formula()?;
                while self.take(",") {
                    self.formula()?;
                }
                Body::Existential(self.since(start))
            }
            "GEF" => {
                self.next();
                self.regexp()?;
                Body::Existential(self.since(start))
            }
            _ => Body::Clause(self.clause()?),
        };
        let span = self.since(start);
        self.end()?;
        Ok(Statement {
            side,
            name,
            parameters,
            body,
            span,
        })
    }
}
