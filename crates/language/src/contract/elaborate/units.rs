//! Two numbers in one unit, so that they can be added and compared.

use super::{Elaborator, is_zero};
use crate::contract::units::{Dimension, Unit};
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;
use linewright_core::source::Span;

impl Elaborator<'_> {
    /// Two numbers as multiples of one unit, and their type: the finer of two units. 0 fits every one.
    pub(super) fn aligned(
        &mut self,
        span: Span,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
    ) -> Option<(Term, Term, Type)> {
        match (&at, &bt) {
            (Type::Measured(x), Type::Measured(y)) if x == y => Some((a, b, at)),
            (Type::Measured(x), Type::Measured(y)) => {
                if let Some(times) = x.in_terms_of(*y) {
                    return Some((scaled(a, times), b, bt));
                }
                if let Some(times) = y.in_terms_of(*x) {
                    return Some((a, scaled(b, times), at));
                }
                self.apart(span, &at, &bt);
                None
            }
            (Type::Measured(_), Type::Int) if is_zero(&b) => Some((a, b, at)),
            (Type::Int, Type::Measured(_)) if is_zero(&a) => Some((a, b, bt)),
            (Type::Measured(unit), Type::Number(_)) => {
                let (unit, times) = finer(*unit, &b, &bt);
                let ty = Type::Measured(unit);
                let b = self.fitted(span, (b, bt), &ty)?;
                Some((scaled(a, times), b, ty))
            }
            (Type::Number(_), Type::Measured(_)) => {
                let (b, a, ty) = self.aligned(span, (b, bt), (a, at))?;
                Some((a, b, ty))
            }
            (Type::Measured(_), _) | (_, Type::Measured(_)) => {
                self.apart(span, &at, &bt);
                None
            }
            _ => {
                let dimension = self.same_dimension(span, &at, &a, &bt, &b)?;
                let ty = match (at, bt) {
                    (Type::Int, Type::Int) => Type::Int,
                    _ => Type::Number(dimension),
                };
                Some((a, b, ty))
            }
        }
    }

    /// A scalar as one of the wanted type; reports what does not fit.
    pub(in crate::contract) fn fitted(
        &mut self,
        span: Span,
        (term, found): (Term, Type),
        wanted: &Type,
    ) -> Option<Term> {
        match (wanted, &found) {
            _ if *wanted == found => Some(term),
            (Type::Number(_), Type::Int) => Some(term),
            (Type::Measured(_), Type::Int) if is_zero(&term) => Some(term),
            (Type::Measured(unit), Type::Measured(other)) => {
                let times = other.in_terms_of(*unit);
                if times.is_none() {
                    self.apart(span, &found, wanted);
                }
                times.map(|n| scaled(term, n))
            }
            (Type::Measured(unit), Type::Number(dimension)) => {
                self.counted(span, &term, *dimension, *unit)
            }
            _ => {
                self.mismatch(span, &wanted.describe(), &found);
                None
            }
        }
    }

    /// A value of whatever shape as one of the wanted type.
    pub(in crate::contract) fn fitted_value(
        &mut self,
        span: Span,
        value: Value,
        wanted: &Type,
    ) -> Option<Value> {
        match (value, wanted) {
            (Value::Scalar(term, found), _) => {
                let term = self.fitted(span, (term, found), wanted)?;
                Some(Value::Scalar(term, wanted.clone()))
            }
            (Value::Array(values), Type::Array(of, n)) if values.len() == *n => {
                let values = values.into_iter().map(|v| self.fitted_value(span, v, of));
                Some(Value::Array(values.collect::<Option<_>>()?))
            }
            (Value::Record(members), Type::Record(types))
                if members.len() == types.len()
                    && members.iter().zip(types).all(|((a, _), (b, _))| a == b) =>
            {
                let members = members.into_iter().zip(types);
                let members = members
                    .map(|((name, v), (_, ty))| self.fitted_value(span, v, ty).map(|v| (name, v)));
                Some(Value::Record(members.collect::<Option<_>>()?))
            }
            (value, _) => {
                self.mismatch(span, &wanted.describe(), &value.ty());
                None
            }
        }
    }

    /// A quantity of the file as a whole number of a unit.
    fn counted(
        &mut self,
        span: Span,
        term: &Term,
        dimension: Dimension,
        unit: Unit,
    ) -> Option<Term> {
        if dimension != unit.dimension() {
            self.apart(span, &Type::Number(dimension), &Type::Measured(unit));
            return None;
        }
        let Some(base) = super::constant_real(term) else {
            self.error_with(
                codes::NOT_CONSTANT,
                span,
                "a quantity of the plant has to be known here beforehand",
                "use numbers, constants and parameters only",
            );
            return None;
        };
        let count = unit.count(base);
        if count.is_none() {
            self.error_with(
                codes::TYPE_MISMATCH,
                span,
                format!("this is no whole number of `{}`", unit.name()),
                "a contract counts in whole numbers: round it, or declare the variable in a finer unit",
            );
        }
        count.map(Term::Int)
    }

    fn apart(&mut self, span: Span, a: &Type, b: &Type) {
        let help = if a.dimension() == b.dimension() {
            "neither unit is a multiple of the other: give both the same one"
        } else {
            "give both sides the same kind of unit; a bare number gets one by being written with it, `5 mm`"
        };
        let word = |t: &Type| match t {
            Type::Int => "a bare number".to_owned(),
            other => other.describe(),
        };
        let message = format!("{} does not go together with {}", word(a), word(b));
        self.error_with(codes::TYPE_MISMATCH, span, message, help);
    }
}

/// The unit in which a quantity is a whole number: the given one, or the coarsest of those that it is a multiple of; and how many of it
/// that is. The given one, where there is none.
fn finer(unit: Unit, quantity: &Term, ty: &Type) -> (Unit, i64) {
    let known = (unit, 1);
    let Some(base) = super::constant_real(quantity) else {
        return known;
    };
    if ty.dimension() != unit.dimension() || unit.count(base).is_some() {
        return known;
    }
    let parts = Unit::all().filter(|u| u.count(base).is_some());
    let multiples = parts.filter_map(|u| unit.in_terms_of(u).map(|times| (u, times)));
    multiples.min_by_key(|(_, times)| *times).unwrap_or(known)
}

fn scaled(term: Term, times: i64) -> Term {
    if times == 1 {
        term
    } else {
        Term::binary(BinaryOp::Mul, term, Term::Int(times))
    }
}
