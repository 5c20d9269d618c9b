//! Parses declarations: variables, types, imports, weights, ...; the longer ones have their own
//! modules.

use super::words::Word;
use super::{DECLARATIONS, Parsed, Parser, is_keyword, owner};
use crate::spectra::syntax::{Declaration, Monitor, Parameter};
use linewright_core::gr1::Owner;

impl Parser<'_> {
    pub fn declaration(&mut self, found: &mut Vec<Declaration>) -> Parsed<()> {
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

    pub fn at_name(&self) -> bool {
        let word = self.word();
        !word.is_empty() && !is_keyword(word)
    }

    /// Parses a type and a name: `Int(0..3) x`.
    pub fn variable(&mut self) -> Parsed<Parameter> {
        let of = self.type_name()?;
        let name = self.name("a variable's name")?;
        Ok(Parameter { of, name })
    }
}
