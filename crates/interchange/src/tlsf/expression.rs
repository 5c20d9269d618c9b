//! Parses expressions by binding powers (Pratt, Top Down Operator Precedence, 1973).

use super::ast::{Binary, Kind, Tree, Unary};
use super::lexer::Word;
use super::operators::{big, infix, is_reserved, prefix};
use super::parser::{MAX_NESTING, Parser};

impl Parser<'_, '_> {
    /// Parses an expression; `None` after an error, which is reported.
    pub fn expression(&mut self) -> Option<Tree> {
        self.binding(0)
    }

    /// Parses an expression whose operators bind more tightly than `least`.
    fn binding(&mut self, least: u8) -> Option<Tree> {
        self.deeper(|parser| {
            let mut left = parser.operand()?;
            let mut height = 0;
            while let Some((op, power, right)) = parser.peek().and_then(infix) {
                if power <= least {
                    break;
                }
                // `&&[` after an operand is the operator `&&`; the `[` is reported as an error.
                parser.at += 1;
                let other = parser.binding(if right { power - 1 } else { power })?;
                left = match (op, left.kind) {
                    (Binary::And, Kind::And(mut list)) => {
                        let range = left.range.start..other.range.end;
                        list.push(other);
                        Tree {
                            kind: Kind::And(list),
                            range,
                        }
                    }
                    (Binary::Or, Kind::Or(mut list)) => {
                        let range = left.range.start..other.range.end;
                        list.push(other);
                        Tree {
                            kind: Kind::Or(list),
                            range,
                        }
                    }
                    (op, kind) => {
                        height += 1;
                        if height > MAX_NESTING {
                            return parser.too_deep();
                        }
                        let range = left.range.start..other.range.end;
                        let left = Tree {
                            kind,
                            range: left.range,
                        };
                        let kind = match op {
                            Binary::And => Kind::And(vec![left, other]),
                            Binary::Or => Kind::Or(vec![left, other]),
                            op => Kind::Binary(op, Box::new(left), Box::new(other)),
                        };
                        Tree { kind, range }
                    }
                };
            }
            Some(left)
        })
    }

    fn operand(&mut self) -> Option<Tree> {
        let Some(token) = self.tokens.get(self.at) else {
            return self.missing("an expression");
        };
        let (word, range) = (token.word, token.range.clone());
        let text = self.word(&range);
        let bracket = self.tokens.get(self.at + 1).map(|t| &t.range);
        let bracket = bracket.is_some_and(|r| self.text[r.clone()] == *"[");
        if let Some((op, power)) = big(text)
            && bracket
        {
            self.at += 2;
            let ranges = self.list("]")?;
            let body = self.binding(power)?;
            let range = range.start..body.range.end;
            return Some(Tree {
                kind: Kind::Big(op, ranges, Box::new(body)),
                range,
            });
        }
        if let Some((op, power)) = prefix(text) {
            self.at += 1;
            let temporal = matches!(op, Unary::Next | Unary::Globally | Unary::Finally);
            let bound = if temporal && bracket {
                self.at += 1;
                let bound = self.expression()?;
                self.expect("]")?;
                Some(bound)
            } else {
                None
            };
            let body = self.binding(power - 1)?;
            let range = range.start..body.range.end;
            let body = Box::new(body);
            let kind = match bound {
                Some(bound) => Kind::Bounded(op, Box::new(bound), body),
                None => Kind::Unary(op, body),
            };
            return Some(Tree { kind, range });
        }
        let leaf = |kind| {
            Some(Tree {
                kind,
                range: range.clone(),
            })
        };
        match (word, text) {
            (Word::Number, digits) => {
                self.at += 1;
                let Ok(value) = digits.parse::<i64>() else {
                    self.report.error(
                        linewright_core::diagnostics::codes::NUMBER_RANGE,
                        range,
                        "this number is too large",
                        "use numbers that fit in 64 bits",
                    );
                    return None;
                };
                leaf(Kind::Number(value))
            }
            (_, "(") => {
                self.at += 1;
                let inner = self.expression()?;
                let end = self.expect(")")?;
                Some(Tree {
                    kind: inner.kind,
                    range: range.start..end,
                })
            }
            (_, "|") => {
                self.at += 1;
                let inner = self.expression()?;
                let end = self.expect("|")?;
                Some(Tree {
                    kind: Kind::Unary(Unary::Size, Box::new(inner)),
                    range: range.start..end,
                })
            }
            (_, "{") => self.set(range.start),
            (Word::Name, "true") => {
                self.at += 1;
                leaf(Kind::Truth(true))
            }
            (Word::Name, "false") => {
                self.at += 1;
                leaf(Kind::Truth(false))
            }
            (Word::Name, "otherwise") => {
                self.at += 1;
                leaf(Kind::Otherwise)
            }
            (Word::Name, "_") => {
                self.at += 1;
                leaf(Kind::Wild)
            }
            (Word::Name, name) if !is_reserved(name) => {
                self.at += 1;
                let name = name.to_owned();
                if self.take("(") {
                    let arguments = self.list(")")?;
                    let end = self.tokens[self.at - 1].range.end;
                    return Some(Tree {
                        kind: Kind::Call(name, arguments),
                        range: range.start..end,
                    });
                }
                if self.take("[") {
                    let index = self.expression()?;
                    let end = self.expect("]")?;
                    return Some(Tree {
                        kind: Kind::Element(name, Box::new(index)),
                        range: range.start..end,
                    });
                }
                leaf(Kind::Name(name))
            }
            _ => self.missing("an expression"),
        }
    }

    /// Parses a set: `{}`, `{a, b, c}` or `{a, b .. c}`.
    fn set(&mut self, start: usize) -> Option<Tree> {
        self.at += 1;
        let mut elements = Vec::new();
        if !self.take("}") {
            loop {
                elements.push(self.expression()?);
                if elements.len() == 2 && self.take("..") {
                    let last = self.expression()?;
                    let end = self.expect("}")?;
                    let second = elements.pop()?;
                    let first = elements.pop()?;
                    return Some(Tree {
                        kind: Kind::Span(Box::new(first), Box::new(second), Box::new(last)),
                        range: start..end,
                    });
                }
                if !self.take(",") {
                    self.expect("}")?;
                    break;
                }
            }
        }
        let end = self.tokens[self.at - 1].range.end;
        Some(Tree {
            kind: Kind::Set(elements),
            range: start..end,
        })
    }

    /// Parses expressions that are separated by commas, and the closing bracket.
    fn list(&mut self, close: &str) -> Option<Vec<Tree>> {
        let mut found = Vec::new();
        if self.take(close) {
            return Some(found);
        }
        loop {
            found.push(self.expression()?);
            if !self.take(",") {
                self.expect(close)?;
                return Some(found);
            }
        }
    }
}
