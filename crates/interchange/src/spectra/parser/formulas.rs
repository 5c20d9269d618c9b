//! Parses formulas. Operators by precedence, the loosest first:
//!
//! ```text
//! in {..}   -> implies   <-> iff   | or xor   & and   = != < > <= >=   mod %   + -   * /
//! S SINCE T TRIGGERED   PREV ONCE ...
//! ```

use super::words::Word;
use super::{Parsed, Parser};
use crate::spectra::syntax::{Item, Name, Node, Past, Shape, SinceOp};
use linewright_core::gr1::BinaryOp;

/// Functions of a whole array.
const FUNCTIONS: [&str; 6] = ["all", "any", "prod", "sum", "min", "max"];

const IMPLIES: u8 = 1;
const RELATION: u8 = 5;
pub(super) const REMAINDER: u8 = 6;
const SINCE: u8 = 9;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Infix {
    Binary(BinaryOp),
    Implies,
    Since(SinceOp),
}

impl Parser<'_> {
    /// Parses a formula of any form.
    pub fn formula(&mut self) -> Parsed<Node> {
        self.deeper()?;
        let start = self.start();
        let mut node = self.operators(0)?;
        // `in` binds most loosely.
        let negated = self.word() == "not" && self.word_ahead(1) == "in";
        if negated || self.word() == "in" {
            self.next();
            if negated {
                self.next();
            }
            let items = self.items()?;
            node = Node {
                shape: Shape::In {
                    value: Box::new(node),
                    negated,
                    items,
                },
                span: self.since(start),
            };
        }
        self.depth -= 1;
        Ok(node)
    }

    fn items(&mut self) -> Parsed<Vec<Item>> {
        let help = "write `x in {a, b}` or `x in {1, 3-5}`";
        self.expect("{", help)?;
        let mut items = Vec::new();
        loop {
            let start = self.start();
            let item = if self.token().0 == Word::Number {
                let low = self.number()?;
                if self.take("-") {
                    if self.token().0 != Word::Number {
                        return self.unexpected("a number", help);
                    }
                    let high = self.number()?;
                    Item::Range(low, high, self.since(start))
                } else {
                    Item::One(Node {
                        shape: Shape::Number(low),
                        span: self.since(start),
                    })
                }
            } else {
                Item::One(self.unary()?)
            };
            items.push(item);
            if !self.take(",") {
                break;
            }
        }
        self.expect("}", help)?;
        Ok(items)
    }

    fn infix(&self) -> Option<(u8, Infix)> {
        use BinaryOp as B;
        let (word, range) = self.token();
        let word = match word {
            Word::Sign(sign) => sign,
            Word::Name => &self.text()[range],
            _ => return None,
        };
        Some(match word {
            "->" | "implies" => (IMPLIES, Infix::Implies),
            "<->" | "iff" => (2, Infix::Binary(B::Eq)),
            "|" | "or" => (3, Infix::Binary(B::Or)),
            "xor" => (3, Infix::Binary(B::Ne)),
            "&" | "and" => (4, Infix::Binary(B::And)),
            "=" => (RELATION, Infix::Binary(B::Eq)),
            "!=" => (RELATION, Infix::Binary(B::Ne)),
            "<" => (RELATION, Infix::Binary(B::Lt)),
            "<=" => (RELATION, Infix::Binary(B::Le)),
            ">" => (RELATION, Infix::Binary(B::Gt)),
            ">=" => (RELATION, Infix::Binary(B::Ge)),
            "mod" | "%" => (REMAINDER, Infix::Binary(B::Mod)),
            "+" => (7, Infix::Binary(B::Add)),
            "-" => (7, Infix::Binary(B::Sub)),
            "*" => (8, Infix::Binary(B::Mul)),
            "/" => (8, Infix::Binary(B::Div)),
            "S" | "SINCE" => (SINCE, Infix::Since(SinceOp::Since)),
            "T" | "TRIGGERED" => (SINCE, Infix::Since(SinceOp::Triggered)),
            _ => return None,
        })
    }

    /// Parses operators whose precedence is at least `least`, and their operands.
    pub fn operators(&mut self, least: u8) -> Parsed<Node> {
        let start = self.start();
        let mut left = self.unary()?;
        // The precedence of the last operator in `left`; `None` for a single operand.
        let mut made = None;
        while let Some((rank, operator)) = self.infix().filter(|(rank, _)| *rank >= least) {
            if made == Some(rank) && matches!(rank, RELATION | REMAINDER) {
                let range = self.token().1;
                return self.report(
                    range,
                    "these operators cannot be chained",
                    "put one of the two into parentheses",
                );
            }
            self.next();
            if rank == IMPLIES {
                self.deeper()?;
                let right = self.operators(IMPLIES)?;
                self.depth -= 1;
                left = Node {
                    shape: Shape::Implies(Box::new(left), Box::new(right)),
                    span: self.since(start),
                };
                continue;
            }
            let right = self.operators(rank + 1)?;
            let span = self.since(start);
            let shape = match (operator, left.shape) {
                (Infix::Binary(op), Shape::Chain(first, mut rest)) if made == Some(rank) => {
                    rest.push((op, right));
                    Shape::Chain(first, rest)
                }
                (Infix::Since(op), Shape::Since(first, mut rest)) if made == Some(rank) => {
                    rest.push((op, right));
                    Shape::Since(first, rest)
                }
                (operator, shape) => {
                    let first = Box::new(Node {
                        shape,
                        span: left.span,
                    });
                    match operator {
                        Infix::Binary(op) => Shape::Chain(first, vec![(op, right)]),
                        Infix::Since(op) => Shape::Since(first, vec![(op, right)]),
                        Infix::Implies => Shape::Implies(first, Box::new(right)),
                    }
                }
            };
            made = Some(rank);
            left = Node { shape, span };
        }
        Ok(left)
    }

    fn unary(&mut self) -> Parsed<Node> {
        let start = self.start();
        let past = match self.word() {
            "PREV" | "Y" => Some(Past::Previous),
            "ONCE" | "O" => Some(Past::Once),
            "HISTORICALLY" | "H" => Some(Past::Historically),
            _ => None,
        };
        if past.is_none() && !self.is("!") && !self.is("-") {
            return self.primary();
        }
        self.deeper()?;
        let shape = if let Some(past) = past {
            self.next();
            Shape::Past(past, Box::new(self.unary()?))
        } else if self.take("!") {
            Shape::Not(Box::new(self.unary()?))
        } else {
            self.next();
            Shape::Negative(Box::new(self.unary()?))
        };
        self.depth -= 1;
        Ok(Node {
            shape,
            span: self.since(start),
        })
    }

    fn primary(&mut self) -> Parsed<Node> {
        let start = self.start();
        let word = self.word();
        let shape = match word {
            "true" | "TRUE" => {
                self.next();
                Shape::Bool(true)
            }
            "false" | "FALSE" => {
                self.next();
                Shape::Bool(false)
            }
            "next" => {
                self.next();
                self.expect("(", "write `next(x)`")?;
                let inner = self.formula()?;
                self.expect(")", "close the parenthesis")?;
                Shape::Next(Box::new(inner))
            }
            "regexp" => {
                self.next();
                self.expect("(", "write `regexp(r)`")?;
                let regexp = self.regexp()?;
                self.expect(")", "close the parenthesis")?;
                Shape::Matches(regexp)
            }
            // Older versions of the language had no quantifiers, so these words can name
            // predicates.
            "forall" | "exists" if !self.is_ahead(1, "(") => {
                self.next();
                let name = self.name("a name for the values")?;
                if !self.take_word("in") {
                    return self.unexpected("`in`", "write `forall i in Int(0..3) . formula`");
                }
                let domain = self.type_name()?;
                self.expect(".", "write `forall i in Int(0..3) . formula`")?;
                let body = Box::new(self.formula()?);
                Shape::Quantified {
                    all: word == "forall",
                    name,
                    domain,
                    body,
                }
            }
            "" if self.token().0 == Word::Number => Shape::Number(self.number()?),
            "" if self.take("(") => {
                let inner = self.formula()?;
                self.expect(")", "close the parenthesis")?;
                return Ok(inner);
            }
            "" => {
                return self.unexpected(
                    "a formula",
                    "write formulas with variables, constants, `! & | -> <->`, comparisons, `+ - * / mod`, `next(x)` and `PREV ONCE HISTORICALLY SINCE TRIGGERED`",
                );
            }
            _ => self.named()?,
        };
        Ok(Node {
            shape,
            span: self.since(start),
        })
    }

    /// `x`, `x[1][i]`, `p(a, b)`, `x.all`
    fn named(&mut self) -> Parsed<Shape> {
        let name = self.name_of_definition("a formula")?;
        if self.take("(") {
            let mut arguments = Vec::new();
            while !self.is(")") {
                arguments.push(self.formula()?);
                if !self.take(",") {
                    break;
                }
            }
            self.expect(")", "close the parenthesis")?;
            return Ok(Shape::Call(name, arguments));
        }
        let mut indices = Vec::new();
        while self.take("[") {
            indices.push(self.formula()?);
            self.expect("]", "close the bracket")?;
        }
        if self.is(".") && FUNCTIONS.contains(&self.word_ahead(1)) {
            self.next();
            let word = self.word();
            let range = self.next();
            let function = Name {
                text: word.to_owned(),
                span: self.span(range),
            };
            return Ok(Shape::Array(name, indices, function));
        }
        Ok(Shape::Name(name.text, indices))
    }

    fn number(&mut self) -> Parsed<i64> {
        let range = self.next();
        match self.text()[range.clone()].parse::<i64>() {
            Ok(value) if value < 1 << 40 => Ok(value),
            _ => self.report(
                range,
                "this number is too large",
                "use numbers smaller than 2^40",
            ),
        }
    }
}
