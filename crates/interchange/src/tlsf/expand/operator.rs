//! Evaluates operators on formulas, numbers and sets.

use super::super::ast::{Binary, Kind, Tree, Unary};
use super::super::ltl::{FormulaId, Op, Place};
use super::super::value::Value;
use super::{Expander, MAX_AHEAD, Result, Scope};
use linewright_core::diagnostics::codes;
use std::rc::Rc;

impl<'f> Expander<'f, '_> {
    pub(super) fn unary(
        &mut self,
        op: Unary,
        a: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        let make: fn(FormulaId) -> Op = match op {
            Unary::Not => Op::Not,
            Unary::Next => Op::Next,
            Unary::Globally => Op::Globally,
            Unary::Finally => Op::Finally,
            Unary::SizeOf => {
                return match self.value(a, scope, site)? {
                    Value::Bus(bits) => Ok(Value::Number(bits.len() as i64)),
                    other => self.fail(
                        codes::TYPE_MISMATCH,
                        &a.range,
                        site,
                        format!("this is {}, where a bus is needed", other.word()),
                        "use `SIZEOF` for the signals of a bus, and `SIZE` for the elements of a set",
                    ),
                };
            }
            Unary::Size => return Ok(Value::Number(self.set(a, scope, site)?.len() as i64)),
            Unary::Min | Unary::Max => {
                let set = self.set(a, scope, site)?;
                let numbers = set.iter().filter_map(|v| match v {
                    Value::Number(n) => Some(*n),
                    _ => None,
                });
                let found = if op == Unary::Min {
                    numbers.min()
                } else {
                    numbers.max()
                };
                return match found {
                    Some(n) => Ok(Value::Number(n)),
                    None => self.fail(
                        codes::DOMAIN_EMPTY,
                        &tree.range,
                        site,
                        "this set contains no number",
                        "use a set with at least one number",
                    ),
                };
            }
        };
        let a = self.condition(a, scope, site)?;
        Ok(Value::Formula(self.formulas.make(make(a), place)))
    }

    /// Expands `X[n] f`, `G[n:m] f` or `F[n:m] f` into nested `X`.
    pub(super) fn bounded(
        &mut self,
        op: Unary,
        bound: &'f Tree,
        body: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        let place = Place::new(&tree.range, site);
        let (low, high) = match (&bound.kind, op) {
            (Kind::Binary(Binary::Colon, low, high), Unary::Globally | Unary::Finally) => (
                self.numeric(low, scope, site)?,
                self.numeric(high, scope, site)?,
            ),
            (Kind::Binary(Binary::Colon, ..), Unary::Next) => {
                return self.fail(
                    codes::SYNTAX,
                    &bound.range,
                    site,
                    "`X` needs one step, but this is a range of steps",
                    "write `X[2] a`, or `F[1:2] a` for one of them and `G[1:2] a` for all",
                );
            }
            (_, Unary::Next) => {
                let n = self.numeric(bound, scope, site)?;
                (n, n)
            }
            _ => {
                return self.fail(
                    codes::SYNTAX,
                    &bound.range,
                    site,
                    "expected two numbers with `:` between them",
                    "write `G[0:3] a` or `F[0:3] a`, and `X[3] a`",
                );
            }
        };
        if !(0..=MAX_AHEAD).contains(&low) || high > MAX_AHEAD {
            return self.fail(
                codes::TOO_LARGE,
                &bound.range,
                site,
                format!("the number of steps is not between 0 and {MAX_AHEAD}"),
                "count further steps in a bus of outputs",
            );
        }
        let and = op != Unary::Finally;
        if low > high {
            // An empty range: by the format's definition, `F` is false and `G` is true. syfco, the
            // format's tool, answers `true` for both.
            if !and {
                self.note(
                    codes::NOTATION,
                    &bound.range,
                    site,
                    format!("the range from {low} to {high} is empty, and `F` over an empty range is true here, as in syfco"),
                    "write the smaller number first, or remove the formula",
                );
            }
            return Ok(Value::Formula(self.formulas.constant(true, place)));
        }
        let mut f = self.condition(body, scope, site)?;
        let first = f;
        for _ in low..high {
            let next = self.formulas.make(Op::Next(f), place);
            f = if and {
                self.formulas.and(vec![first, next], place)
            } else {
                self.formulas.or(vec![first, next], place)
            };
        }
        for _ in 0..low {
            f = self.formulas.make(Op::Next(f), place);
        }
        Ok(Value::Formula(f))
    }

    pub(super) fn binary(
        &mut self,
        op: Binary,
        a: &'f Tree,
        b: &'f Tree,
        tree: &'f Tree,
        scope: Scope<'_>,
        site: u32,
    ) -> Result<Value> {
        use Binary as B;
        let place = Place::new(&tree.range, site);
        match op {
            B::Times | B::Divide | B::Modulo | B::Plus | B::Minus => {
                let (x, y) = (self.numeric(a, scope, site)?, self.numeric(b, scope, site)?);
                if y == 0 && matches!(op, B::Divide | B::Modulo) {
                    return self.fail(
                        codes::DIVISION,
                        &tree.range,
                        site,
                        "the divisor is 0 here",
                        "exclude that case with a guard",
                    );
                }
                // Rounds towards minus infinity, as the format's tool does.
                let quotient = || {
                    let q = x.checked_div(y)?;
                    Some(q - i64::from(x % y != 0 && (x < 0) != (y < 0)))
                };
                let result = match op {
                    B::Times => x.checked_mul(y),
                    B::Plus => x.checked_add(y),
                    B::Minus => x.checked_sub(y),
                    B::Divide => quotient(),
                    _ => quotient().and_then(|q| x.checked_sub(q.checked_mul(y)?)),
                };
                self.checked_number(result, tree, site)
            }
            B::SetMinus | B::Cap | B::Cup => {
                let (x, y) = (self.set(a, scope, site)?, self.set(b, scope, site)?);
                Ok(Value::Set(Rc::new(match op {
                    B::SetMinus => x.difference(&y).cloned().collect(),
                    B::Cap => x.intersection(&y).cloned().collect(),
                    _ => x.union(&y).cloned().collect(),
                })))
            }
            B::Less | B::LessEqual | B::Greater | B::GreaterEqual => {
                let (x, y) = (self.numeric(a, scope, site)?, self.numeric(b, scope, site)?);
                let truth = match op {
                    B::Less => x < y,
                    B::LessEqual => x <= y,
                    B::Greater => x > y,
                    _ => x >= y,
                };
                Ok(Value::Formula(self.formulas.constant(truth, place)))
            }
            B::Element => {
                let x = self.value(a, scope, site)?;
                let set = self.set(b, scope, site)?;
                Ok(Value::Formula(self.formulas.constant(set.contains(&x), place)))
            }
            B::Equal | B::Unequal => {
                let (x, y) = (self.value(a, scope, site)?, self.value(b, scope, site)?);
                let equal = self.equal(&x, &y, tree, site)?;
                Ok(Value::Formula(if op == B::Equal {
                    equal
                } else {
                    self.formulas.make(Op::Not(equal), place)
                }))
            }
            B::Pattern | B::Colon => self.fail(
                codes::SYNTAX,
                &tree.range,
                site,
                if op == B::Colon {
                    "this guard is outside a definition"
                } else {
                    "this pattern is outside a guard"
                },
                "write guards and patterns under DEFINITIONS: `f(x) = x ~ a U b : a  otherwise : x`",
            ),
            B::And | B::Or | B::Implies | B::Equivalent | B::Weak | B::Until | B::Release => {
                let (x, y) = (self.condition(a, scope, site)?, self.condition(b, scope, site)?);
                let op = match op {
                    B::And => Op::And(vec![x, y]),
                    B::Or => Op::Or(vec![x, y]),
                    B::Implies => Op::Implies(x, y),
                    B::Equivalent => Op::Iff(x, y),
                    B::Weak => Op::Weak(x, y),
                    B::Until => Op::Until(x, y),
                    _ => Op::Release(x, y),
                };
                Ok(Value::Formula(self.formulas.make(op, place)))
            }
        }
    }
}
