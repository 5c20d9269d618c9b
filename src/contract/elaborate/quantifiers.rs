//! Quantifiers, written out, and functions.

use super::{Elaborator, MAX_EXPANSION, nearest};
use crate::contract::value::{Dimension, Rounding, Term, Type, Value};
use crate::diagnostics::codes;
use crate::gr1::{BinaryOp, Time, UnaryOp};
use crate::source::Span;
use crate::syntax::ast::{self, Quantifier};

impl<'a> Elaborator<'a> {
    /// The values that a quantified name takes, each with its type.
    pub fn quantified(&mut self, domain: &'a ast::Domain) -> Option<Vec<Value>> {
        let values: Vec<Value> = if let ast::DomainKind::Range(low, high) = &domain.kind {
            let (low, high) = (self.constant_int(low)?, self.constant_int(high)?);
            if high.saturating_sub(low) >= MAX_EXPANSION {
                self.error_with(
                    codes::DOMAIN_EMPTY,
                    domain.span,
                    format!("more than {MAX_EXPANSION} values"),
                    "use a smaller range",
                );
                return None;
            }
            (low..=high)
                .map(|i| Value::Scalar(Term::Int(i), Type::Int))
                .collect()
        } else {
            let (base, length) = self.domain(domain)?;
            if length.is_some() || base.size() as i64 > MAX_EXPANSION {
                self.error_with(
                    codes::DOMAIN_EMPTY,
                    domain.span,
                    "a quantifier ranges over numbers, labels or truth values",
                    "write a range such as `0..3`, `bool`, or a set of labels",
                );
                return None;
            }
            (base.low()..=base.high())
                .map(|i| Value::Scalar(Term::Int(i), Type::of(&base)))
                .collect()
        };
        self.expansions += values.len() as i64;
        if self.expansions > MAX_EXPANSION * 64 {
            self.too_large(domain.span);
            return None;
        }
        Some(values)
    }

    pub(super) fn quantifier(
        &mut self,
        span: Span,
        (kind, expected): (Quantifier, Option<&Type>),
        name: &ast::Name,
        domain: &'a ast::Domain,
        body: &'a ast::Expr,
        time: Time,
    ) -> Option<Value> {
        let values = self.quantified(domain)?;
        let element = match expected {
            Some(Type::Array(element, _)) => Some(&**element),
            _ => None,
        };
        let mut terms = Vec::with_capacity(values.len());
        for value in values {
            let term = self.with_bound(&name.text, value, |e| match kind {
                Quantifier::Sum => e.number(body, time),
                Quantifier::Array => e.any_scalar(body, element, time),
                _ => e.boolean(body, time).map(|t| (t, Type::Bool)),
            });
            terms.push(term?);
        }
        if kind == Quantifier::Array {
            let elements = terms.into_iter().map(|(t, ty)| Value::Scalar(t, ty));
            return Some(Value::Array(elements.collect()));
        }
        let real = terms.iter().find_map(|(_, t)| match t {
            Type::Number(d) => Some(Type::Number(*d)),
            _ => None,
        });
        let terms = terms.into_iter().map(|(t, _)| t);
        let value = match kind {
            Quantifier::Forall => {
                Value::Scalar(Term::fold(BinaryOp::And, terms.collect(), 1), Type::Bool)
            }
            Quantifier::Exists => {
                Value::Scalar(Term::fold(BinaryOp::Or, terms.collect(), 0), Type::Bool)
            }
            Quantifier::Count => Value::Scalar(
                Term::fold(
                    BinaryOp::Add,
                    terms
                        .map(|t| Term::choose(t, Term::Int(1), Term::Int(0)))
                        .collect(),
                    0,
                ),
                Type::Int,
            ),
            Quantifier::Sum | Quantifier::Array => Value::Scalar(
                Term::fold(BinaryOp::Add, terms.collect(), 0),
                real.unwrap_or(Type::Int),
            ),
        };
        if let (Value::Scalar(term, Type::Int), false) = (&value, self.real) {
            self.range_of(term, span)?;
        }
        Some(value)
    }

    pub(super) fn call(
        &mut self,
        span: Span,
        name: &ast::Name,
        arguments: &'a [ast::Expr],
        time: Time,
    ) -> Option<Value> {
        let rounding = match name.text.as_str() {
            "floor" => Some(Rounding::Floor),
            "ceil" => Some(Rounding::Ceil),
            "round" => Some(Rounding::Round),
            "min" | "max" | "abs" => None,
            other => {
                let help = match nearest(
                    other,
                    ["min", "max", "abs", "floor", "ceil", "round"].into_iter(),
                ) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => {
                        "the functions are min, max, abs, and in machines floor, ceil and round"
                            .to_owned()
                    }
                };
                self.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no function `{other}`"),
                    help,
                );
                return None;
            }
        };
        let mut values = Vec::with_capacity(arguments.len());
        for a in arguments {
            values.push(self.number(a, time));
        }
        let values: Vec<(Term, Type)> = values.into_iter().collect::<Option<_>>()?;
        if (name.text == "abs" || rounding.is_some()) && values.len() != 1 {
            self.error_with(
                codes::ARGUMENT,
                span,
                format!("`{}` takes one argument", name.text),
                "`min` and `max` take several",
            );
            return None;
        }
        if let Some(rounding) = rounding {
            if !self.real {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("`{}` has no meaning in a contract", name.text),
                    "a contract's numbers are whole; `/` rounds down",
                );
                return None;
            }
            let (term, _) = values.into_iter().next()?;
            return Some(Value::Scalar(
                Term::Rounded(rounding, Box::new(term)),
                Type::Number(Dimension::None),
            ));
        }
        let op = if name.text == "min" {
            BinaryOp::Min
        } else {
            BinaryOp::Max
        };
        let mut values = values.into_iter();
        let (mut term, mut ty) = values.next()?;
        if name.text == "abs" {
            return Some(Value::Scalar(Term::unary(UnaryOp::Abs, term), ty));
        }
        for (next, next_ty) in values {
            let dimension = self.same_dimension(span, &ty, &term, &next_ty, &next)?;
            if next_ty != Type::Int || ty != Type::Int {
                ty = Type::Number(dimension);
            }
            term = Term::binary(op, term, next);
        }
        Some(Value::Scalar(term, ty))
    }
}
