//! Conversion of numbers to a common unit or an expected type.

use super::findings::Findings;
use super::{constant_real, is_zero};
use crate::contract::units::{Dimension, Unit};
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;
use linewright_core::source::Span;

/// Converts two numbers to a common unit, and returns them with their common type. The number 0
/// fits every unit. Reports numbers without a common unit.
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
            no_common_unit(span, &at, &bt, findings);
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
            no_common_unit(span, &at, &bt, findings);
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

/// Converts a scalar to the expected type; reports a scalar that cannot be converted.
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
                no_common_unit(span, &found, wanted, findings);
            }
            times.map(|n| scaled(term, n))
        }
        (Type::Measured(unit), Type::Number(dimension)) => {
            whole_count(span, &term, *dimension, *unit, findings)
        }
        _ => {
            findings.mismatch(span, &wanted.describe(), &found);
            None
        }
    }
}

/// Converts a value of any shape to the expected type; reports a value that cannot be converted.
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

/// Converts a constant quantity, or a choice between constant quantities, to a whole number of
/// `unit`. Reports a quantity that cannot be converted.
fn whole_count(
    span: Span,
    term: &Term,
    dimension: Dimension,
    unit: Unit,
    findings: &mut Findings,
) -> Option<Term> {
    if dimension != unit.dimension() {
        no_common_unit(
            span,
            &Type::Number(dimension),
            &Type::Measured(unit),
            findings,
        );
        return None;
    }
    if let Term::If(condition, a, b) = term {
        let a = whole_count(span, a, dimension, unit, findings);
        let b = whole_count(span, b, dimension, unit, findings);
        return Some(Term::choose((**condition).clone(), a?, b?));
    }
    let Some(base) = constant_real(term) else {
        not_constant(span, findings);
        return None;
    };
    let count = unit.count(base);
    if count.is_none() {
        findings.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("this is not a whole number of `{}`", unit.name()),
            "a contract has only whole numbers: round the value, or declare the variable in a finer unit",
        );
    }
    count.map(Term::Int)
}

/// Reports a quantity whose number depends on variables.
pub(super) fn not_constant(span: Span, findings: &mut Findings) {
    findings.error_with(
        codes::NOT_CONSTANT,
        span,
        "this quantity has to be a constant",
        "use numbers, constants and parameters only; what varies is a variable with a unit, or a choice: `if x then 5 mm else 0 mm`",
    );
}

/// Reports two numbers without a common unit.
fn no_common_unit(span: Span, a: &Type, b: &Type, findings: &mut Findings) {
    let help = if a.dimension() == b.dimension() {
        "use the same unit on both sides: neither unit is a multiple of the other"
    } else {
        "use units of the same kind on both sides; write a bare number with a unit, such as `5 mm`"
    };
    let word = |t: &Type| match t {
        Type::Int => "a bare number".to_owned(),
        other => other.describe(),
    };
    let message = format!("{} cannot be combined with {}", word(a), word(b));
    findings.error_with(codes::TYPE_MISMATCH, span, message, help);
}

/// Returns the common dimension of two operands of addition or comparison. The number 0 fits every
/// dimension. Among constants a bare number fits a share, as in `1 - 30 %`: it is a multiple of
/// 100 %. Reports operands without a common dimension.
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
    let is_share_of_1 = matches!(
        (ad, bd),
        (Dimension::Share, Dimension::None) | (Dimension::None, Dimension::Share)
    );
    if is_share_of_1 && constant_real(a).is_some() && constant_real(b).is_some() {
        return Some(Dimension::Share);
    }
    let help = if is_share_of_1 {
        "write the number as a share, too: `100 %` for 1; only among constants, a bare number is a multiple of 100 %"
    } else {
        "use units of the same kind on both sides"
    };
    findings.error_with(
        codes::TYPE_MISMATCH,
        span,
        format!(
            "{} cannot be combined with {}",
            ad.describe(),
            bd.describe()
        ),
        help,
    );
    None
}

/// Returns the coarsest unit of which both `unit` and a constant quantity are multiples, and the
/// number of these units in one `unit`. Returns `unit` itself and 1 if there is no such unit.
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
