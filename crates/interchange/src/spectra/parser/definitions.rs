//! Parses defines, predicates and patterns.

use super::{Parsed, Parser};
use crate::spectra::syntax::{Define, Elements, Parameter, Pattern, Predicate};

impl Parser<'_> {
    pub fn define(&mut self) -> Parsed<Define> {
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

    pub fn elements(&mut self) -> Parsed<Elements> {
        let start = self.start();
        self.expect("{", "write an array's elements in braces: `{a, b}`")?;
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
        self.expect("}", "write an array's elements in braces: `{a, b}`")?;
        Ok(Elements::Many(found, self.since(start)))
    }

    pub fn predicate(&mut self) -> Parsed<Predicate> {
        self.next();
        let name = self.name_of_definition("the predicate's name")?;
        let parameters = if self.take("(") {
            let found = if self.is(")") {
                Vec::new()
            } else {
                self.parameters()?
            };
            self.expect(
                ")",
                "write parameters in parentheses: `predicate p(boolean a):`",
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

    pub fn parameters(&mut self) -> Parsed<Vec<Parameter>> {
        let mut found = vec![self.variable()?];
        while self.take(",") {
            found.push(self.variable()?);
        }
        Ok(found)
    }

    pub fn pattern(&mut self) -> Parsed<Pattern> {
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
            self.expect(")", "write parameters in parentheses: `pattern p(a, b) {`")?;
        }
        let mut variables = Vec::new();
        self.expect("{", "write a pattern's formulas in braces")?;
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
}
