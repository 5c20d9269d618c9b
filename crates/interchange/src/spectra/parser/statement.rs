//! Parses assumptions and guarantees, and the formulas of monitors and patterns.

use super::words::Word;
use super::{Parsed, Parser, when};
use crate::spectra::syntax::{Body, Clause, Statement, TemporalForm};
use linewright_core::gr1::Owner;

impl Parser<'_> {
    pub fn statement(&mut self, side: Owner) -> Parsed<Statement> {
        self.next();
        let mut name = None;
        let mut parameters = Vec::new();
        if self.at_name() && (self.is_ahead(1, ":") || self.is_ahead(1, "{")) {
            name = Some(self.name("a name")?);
            if self.take("{") {
                parameters = self.parameters()?;
                self.expect(
                    "}",
                    "write parameters in braces: `gar name{Int(0..3) i}: ...`",
                )?;
            }
            self.expect(":", "write `:` after the name")?;
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

    pub fn clauses(&mut self, what: &str) -> Parsed<Vec<Clause>> {
        self.expect("{", &format!("write a {what}'s formulas in braces"))?;
        self.clauses_inside()
    }

    pub fn clauses_inside(&mut self) -> Parsed<Vec<Clause>> {
        let mut found = Vec::new();
        while !self.take("}") {
            if self.token().0 == Word::End {
                return self.unexpected("`}`", "close the braces");
            }
            found.push(self.clause()?);
            self.end()?;
        }
        Ok(found)
    }

    pub fn clause(&mut self) -> Parsed<Clause> {
        let start = self.start();
        let operator = when(self.word());
        if operator.is_some() {
            self.next();
        }
        let node = self.formula()?;
        Ok(Clause {
            when: operator.unwrap_or(TemporalForm::Initially),
            explicit: operator.is_some(),
            node,
            span: self.since(start),
        })
    }
}
