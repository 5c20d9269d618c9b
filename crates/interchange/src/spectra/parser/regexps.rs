//! Parses regular expressions over steps.

use super::{Parsed, Parser};
use crate::spectra::syntax::{Node, Regexp, RegexpOp, RegexpShape, Shape};

impl Parser<'_> {
    /// Parses a regular expression. As in the language's grammar, sequences, `&` and `|` have equal
    /// precedence and group from the left.
    pub fn regexp(&mut self) -> Parsed<Regexp> {
        self.deeper()?;
        let start = self.start();
        let first = self.repeated()?;
        let mut others = Vec::new();
        loop {
            let op = if self.take("&") {
                RegexpOp::And
            } else if self.take("|") {
                RegexpOp::Or
            } else if self.begins_regexp() {
                RegexpOp::Then
            } else {
                break;
            };
            others.push((op, self.repeated()?));
        }
        self.depth -= 1;
        if others.is_empty() {
            return Ok(first);
        }
        Ok(Regexp {
            shape: RegexpShape::Chain(Box::new(first), others),
            span: self.since(start),
        })
    }

    fn begins_regexp(&self) -> bool {
        let word = self.word();
        self.is("(")
            || self.is("[")
            || self.is("~")
            || (!word.is_empty() && !matches!(word, "gar" | "asm" | "guarantee" | "assumption"))
    }

    fn repeated(&mut self) -> Parsed<Regexp> {
        let start = self.start();
        let mut complemented = false;
        while self.take("~") {
            complemented = !complemented;
        }
        let mut inner = self.step()?;
        if complemented {
            inner = Regexp {
                shape: RegexpShape::Complement(Box::new(inner)),
                span: self.since(start),
            };
        }
        let number = |value| {
            Box::new(Node {
                shape: Shape::Number(value),
                span: inner.span,
            })
        };
        let (low, high) = if self.take("*") {
            (number(0), None)
        } else if self.take("+") {
            (number(1), None)
        } else if self.take("?") {
            (number(0), Some(number(1)))
        } else if self.take("{") {
            let low = Box::new(self.size()?);
            let high = if !self.take(",") {
                Some(low.clone())
            } else if self.is("}") {
                None
            } else {
                Some(Box::new(self.size()?))
            };
            self.expect("}", "repeat with `r{3}`, `r{3,}` or `r{3,5}`")?;
            (low, high)
        } else {
            return Ok(inner);
        };
        Ok(Regexp {
            shape: RegexpShape::Repeat(Box::new(inner), low, high),
            span: self.since(start),
        })
    }

    fn step(&mut self) -> Parsed<Regexp> {
        let start = self.start();
        let shape = match self.word() {
            "true" | "TRUE" => {
                self.next();
                RegexpShape::Constant(true)
            }
            "false" | "FALSE" => {
                self.next();
                RegexpShape::Constant(false)
            }
            "" if self.take("[") => {
                let node = self.formula()?;
                self.expect("]", "write a step's condition in brackets: `[p]`")?;
                RegexpShape::Step(Box::new(node))
            }
            "" if self.take("(") => {
                if self.take(")") {
                    RegexpShape::Empty
                } else {
                    let inner = self.regexp()?;
                    self.expect(")", "close the parenthesis")?;
                    return Ok(inner);
                }
            }
            "" => {
                return self.unexpected(
                    "a regular expression",
                    "use `[p]`, `true`, `false`, `()`, names and `* + ? {n} {n,m} & | ~`",
                );
            }
            _ => RegexpShape::Named(self.name("a regular expression")?.text),
        };
        Ok(Regexp {
            shape,
            span: self.since(start),
        })
    }
}
