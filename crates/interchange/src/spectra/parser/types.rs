//! Parses types, ranges and sizes.

use super::formulas::REMAINDER;
use super::words::Word;
use super::{Parsed, Parser};
use crate::spectra::syntax::{Base, Name, Node, TypeName};

impl Parser<'_> {
    /// Parses the sizes of an array: `[2][n]`.
    pub fn sizes(&mut self) -> Parsed<Vec<Node>> {
        let mut found = Vec::new();
        while self.take("[") {
            found.push(self.size()?);
            self.expect("]", "close the bracket")?;
        }
        Ok(found)
    }

    /// Parses an arithmetic expression, without comparisons and logical operators.
    pub fn size(&mut self) -> Parsed<Node> {
        self.operators(REMAINDER)
    }

    /// Parses a range: `0..3`.
    pub fn range(&mut self) -> Parsed<(Node, Node)> {
        let low = self.size()?;
        self.expect("..", "write a range as `0..3`")?;
        Ok((low, self.size()?))
    }

    pub fn type_name(&mut self) -> Parsed<TypeName> {
        let start = self.start();
        let base = match self.word() {
            "boolean" => {
                self.next();
                Base::Bool
            }
            "Int" => {
                self.next();
                self.expect("(", "write `Int(0..3)`")?;
                let (low, high) = self.range()?;
                self.expect(")", "write `Int(0..3)`")?;
                Base::Int(Box::new(low), Box::new(high))
            }
            "" if self.take("{") => {
                let mut labels = Vec::new();
                loop {
                    labels.push(self.label()?);
                    if !self.take(",") {
                        break;
                    }
                }
                self.expect("}", "write the values as `{a, b, c}`")?;
                Base::Labels(labels)
            }
            "" => {
                return self.unexpected(
                    "a type",
                    "types are `boolean`, `Int(0..3)`, `{a, b}` and those declared with `type`",
                );
            }
            _ => Base::Named(self.name("a type")?.text),
        };
        let sizes = self.sizes()?;
        Ok(TypeName {
            base,
            sizes,
            span: self.since(start),
        })
    }

    /// Parses a value of an enumeration: a name or a number.
    fn label(&mut self) -> Parsed<Name> {
        if self.token().0 == Word::Number {
            let range = self.next();
            return Ok(Name {
                text: self.text()[range.clone()].to_owned(),
                span: self.span(range),
            });
        }
        self.name("a value")
    }
}
