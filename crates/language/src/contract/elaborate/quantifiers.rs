//! Expansion of quantifiers, and calls of functions.

use super::domains::unit_in;
use super::expansion::MAX_EXPANSION;
use super::units::aligned;
use super::{Elaborator, nearest};
use crate::contract::shape::measured;
use crate::contract::value::{Dimension, Rounding, Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Time, UnaryOp};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, Quantifier};

impl<'a> Elaborator<'a> {
    /// Returns the values over which a quantified name ranges.
    pub fn quantified(&mut self, domain: &'a ast::Domain) -> Option<Vec<Value>> {
        let values: Vec<Value> = if let ast::DomainKind::Range(low, high, None) = &domain.kind
            && unit_in(low).is_none()
            && unit_in(high).is_none()
        {
            let (low, high) = (self.constant_int(low)?, self.constant_int(high)?);
            if high.saturating_sub(low) >= MAX_EXPANSION {
                self.findings.error_with(
                    codes::DOMAIN_EMPTY,
                    domain.span,
                    format!("this range has more than {MAX_EXPANSION} values"),
                    "use a smaller range",
                );
                return None;
            }
            (low..=high)
                .map(|i| Value::Scalar(Term::Int(i), Type::Int))
                .collect()
        } else if let ast::DomainKind::Named(ast::Name { text: name, .. })
        // An array can have the name of a unit: `h`.
        | ast::DomainKind::Unit(name) = &domain.kind
            && let Some(length) = self.names.array_length(name)
        {
            (0..length as i64)
                .map(|i| Value::Scalar(Term::Int(i), Type::Int))
                .collect()
        } else {
            let (base, unit, length) = self.measured_domain(domain)?;
            if length.is_some() || base.size() as i64 > MAX_EXPANSION {
                self.findings.error_with(
                    codes::DOMAIN_EMPTY,
                    domain.span,
                    format!("a quantifier has to range over at most {MAX_EXPANSION} numbers, labels or truth values"),
                    "write a range such as `0..3`, `bool`, or a set of labels",
                );
                return None;
            }
            (base.low()..=base.high())
                .map(|i| Value::Scalar(Term::Int(i), measured(&base, unit)))
                .collect()
        };
        self.expansion
            .add_instances(domain.span, values.len(), &mut self.findings)?;
        Some(values)
    }

    /// Runs a function with a quantified name in scope.
    pub fn with_bound<T>(
        &mut self,
        name: &str,
        value: Value,
        run: impl FnOnce(&mut Self) -> T,
    ) -> T {
        self.names.bind(name.to_owned(), value);
        let result = run(self);
        self.names.unbind();
        result
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
        if kind == Quantifier::Array {
            let element = match expected {
                Some(Type::Array(element, _)) => Some(&**element),
                _ => None,
            };
            let mut elements = Vec::with_capacity(values.len());
            for value in values {
                let element = self.with_bound(&name.text, value, |e| e.value(body, element, time));
                elements.push(element?);
            }
            return Some(Value::Array(elements));
        }
        let mut terms = Vec::with_capacity(values.len());
        for value in values {
            let term = self.with_bound(&name.text, value, |e| match kind {
                Quantifier::Sum => e.number(body, time),
                _ => e.boolean(body, time).map(|t| (t, Type::Bool)),
            });
            terms.push(term?);
        }
        let real = terms.iter().find_map(|(_, t)| match t {
            Type::Number(_) | Type::Measured(_) => Some(t.clone()),
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
        if let (Value::Scalar(term, Type::Int | Type::Measured(_)), false) =
            (&value, self.dialect.real)
        {
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
                let functions = ["min", "max", "abs", "floor", "ceil", "round"];
                let known = self.names.defines.keys().map(String::as_str);
                let help = match nearest(other, known.chain(functions)) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => {
                        "the functions are `min`, `max` and `abs`, those declared with `define`, and in machines also `floor`, `ceil` and `round`"
                            .to_owned()
                    }
                };
                self.findings.error_with(
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
            self.findings.error_with(
                codes::ARGUMENT,
                span,
                format!("`{}` takes one argument", name.text),
                "`min` and `max` take several",
            );
            return None;
        }
        if let Some(rounding) = rounding {
            if !self.dialect.real {
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("`{}` is not allowed in a contract", name.text),
                    "use `/`, which rounds down: a contract has only whole numbers",
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
            let (a, b, common) = aligned(span, (term, ty), (next, next_ty), &mut self.findings)?;
            ty = common;
            term = Term::binary(op, a, b);
        }
        Some(Value::Scalar(term, ty))
    }
}
