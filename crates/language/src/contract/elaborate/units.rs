//! Conversion of two numbers to one unit, so that they can be added and compared.

use super::findings::Findings;
use super::{constant_real, is_zero};
use crate::contract::units::{Dimension, Unit};
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;
use linewright_core::source::Span;

/// Converts two numbers to multiples of the finer of their units, and returns that type. 0 fits
/// every unit.
pub(super) fn aligned(
    span: Span,
    (a, at): (Term, Type),
    (b, bt): (Term, Type),
    findings: &mut Findings,
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
            apart(span, &at, &bt, findings);
            None
        }
        (Type::Measured(_), Type::Int) if is_zero(&b) => Some((a, b, at)),
        (Type::Int, Type::Measured(_)) if is_zero(&a) => Some((a, b, bt)),
        (Type::Measured(unit), Type::Number(_)) => {
            let (unit, times) = finer(*unit, &b, &bt);
            let ty = Type::Measured(unit);
            let b = fitted(span, (b, bt), &ty, findings)?;
            Some((scaled(a, times), b, ty))
        }
        (Type::Number(_), Type::Measured(_)) => {
            let (b, a, ty) = aligned(span, (b, bt), (a, at), findings)?;
            Some((a, b, ty))
        }
        (Type::Measured(_), _) | (_, Type::Measured(_)) => {
            apart(span, &at, &bt, findings);
            None
        }
        _ => {
            let dimension = same_dimension(span, (&a, &at), (&b, &bt), findings)?;
            let ty = match (at, bt) {
                (Type::Int, Type::Int) => Type::Int,
                _ => Type::Number(dimension),
            };
            Some((a, b, ty))
        }
    }
}

/// Converts a scalar to the expected type; reports one that does not fit.
pub(in crate::contract) fn fitted(
    span: Span,
    (term, found): (Term, Type),
    wanted: &Type,
    findings: &mut Findings,
) -> Option<Term> {
    match (wanted, &found) {
        _ if *wanted == found => Some(term),
        (Type::Number(_), Type::Int) => Some(term),
        (Type::Measured(_), Type::Int) if is_zero(&term) => Some(term),
        (Type::Measured(unit), Type::Measured(other)) => {
            let times = other.in_terms_of(*unit);
            if times.is_none() {
                apart(span, &found, wanted, findings);
            }
            times.map(|n| scaled(term, n))
        }
        (Type::Measured(unit), Type::Number(dimension)) => {
            counted(span, &term, *dimension, *unit, findings)
        }
        _ => {
            findings.mismatch(span, &wanted.describe(), &found);
            None
        }
    }
}

/// Converts a value of any shape to the expected type.
pub(in crate::contract) fn fitted_value(
    span: Span,
    value: Value,
    wanted: &Type,
    findings: &mut Findings,
) -> Option<Value> {
    match (value, wanted) {
        (Value::Scalar(term, found), _) => {
            let term = fitted(span, (term, found), wanted, findings)?;
            Some(Value::Scalar(term, wanted.clone()))
        }
        (Value::Array(values), Type::Array(of, n)) if values.len() == *n => {
            let values = values
                .into_iter()
                .map(|v| fitted_value(span, v, of, findings));
            Some(Value::Array(values.collect::<Option<_>>()?))
        }
        (Value::Record(members), Type::Record(types))
            if members.len() == types.len()
                && members.iter().zip(types).all(|((a, _), (b, _))| a == b) =>
        {
            let members = members
                .into_iter()
                .zip(types)
                .map(|((name, v), (_, ty))| fitted_value(span, v, ty, findings).map(|v| (name, v)));
            Some(Value::Record(members.collect::<Option<_>>()?))
        }
        (value, _) => {
            findings.mismatch(span, &wanted.describe(), &value.ty());
            None
        }
    }
}

/// Converts a quantity of the file to a whole number of a unit.
fn counted(
    span: Span,
    term: &Term,
    dimension: Dimension,
    unit: Unit,
    findings: &mut Findings,
) -> Option<Term> {
    if dimension != unit.dimension() {
        apart(
            span,
            &Type::Number(dimension),
            &Type::Measured(unit),
            findings,
        );
        return None;
    }
    let Some(base) = constant_real(term) else {
        findings.error_with(
            codes::NOT_CONSTANT,
            span,
            "a quantity of the plant has to be known here beforehand",
            "use numbers, constants and parameters only",
        );
        return None;
    };
    let count = unit.count(base);
    if count.is_none() {
        findings.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("this is not a whole number of `{}`", unit.name()),
            "a contract counts in whole numbers: round it, or declare the variable in a finer unit",
        );
    }
    count.map(Term::Int)
}

/// Reports two numbers without a common unit.
fn apart(span: Span, a: &Type, b: &Type, findings: &mut Findings) {
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
    findings.error_with(codes::TYPE_MISMATCH, span, message, help);
}

/// Checks that two operands of addition or comparison have the same dimension; 0 fits every
/// dimension.
pub(super) fn same_dimension(
    span: Span,
    (a, at): (&Term, &Type),
    (b, bt): (&Term, &Type),
    findings: &mut Findings,
) -> Option<Dimension> {
    let of = |t: &Type| match t {
        Type::Number(d) => *d,
        _ => Dimension::None,
    };
    let (ad, bd) = (of(at), of(bt));
    if ad == bd || is_zero(b) {
        return Some(ad);
    }
    if is_zero(a) {
        return Some(bd);
    }
    findings.error_with(
        codes::TYPE_MISMATCH,
        span,
        format!("{} does not go together with {}", ad.word(), bd.word()),
        "give both sides the same kind of unit",
    );
    None
}

/// Returns the unit in which a quantity is a whole number, and that number: the given unit, or the
/// coarsest one that divides the quantity. The given unit if there is none.
fn finer(unit: Unit, quantity: &Term, ty: &Type) -> (Unit, i64) {
    let known = (unit, 1);
    let Some(base) = constant_real(quantity) else {
        return known;
    };
    if ty.dimension() != unit.dimension() || unit.count(base).is_some() {
        return known;
    }
    Unit::all()
        .filter(|u| u.count(base).is_some())
        .filter_map(|u| unit.in_terms_of(u).map(|times| (u, times)))
        .min_by_key(|(_, times)| *times)
        .unwrap_or(known)
}

fn scaled(term: Term, times: i64) -> Term {
    if times == 1 {
        term
    } else {
        Term::binary(BinaryOp::Mul, term, Term::Int(times))
    }
}
