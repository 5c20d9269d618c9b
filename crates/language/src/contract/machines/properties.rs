//! Properties of parts: their types, their values, and their use in expressions.

use crate::contract::elaborate::{Elaborator, Findings, MAX_EXPANSION, constant_real};
use crate::contract::shape::Entry;
use crate::contract::units::Unit;
use crate::contract::value::{Dimension, Term, Type, Value, unit};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Domain, Time, VarId};
use linewright_syntax::ast;
use std::sync::Arc;

/// Type of a property in plant expressions.
#[derive(Debug, Clone)]
pub(in crate::contract) struct PropertyType {
    /// Declared unit, such as `deg`; empty for a bare number.
    pub unit: String,
    /// Domain of truth values, labels or a range of whole numbers; `None` for real numbers.
    pub domain: Option<Domain>,
    /// Number of elements of an array; `None` for a scalar.
    pub length: Option<usize>,
}

/// Resolves the declared type of a property.
pub(in crate::contract) fn property_type<'a>(
    e: &mut Elaborator<'a>,
    domain: &'a ast::Domain,
) -> Option<PropertyType> {
    match &domain.kind {
        ast::DomainKind::Unit(unit) => Some(PropertyType {
            unit: unit.clone(),
            domain: None,
            length: None,
        }),
        ast::DomainKind::Named(name) if name.text == "number" => Some(PropertyType {
            unit: String::new(),
            domain: None,
            length: None,
        }),
        ast::DomainKind::Array(length, of) => {
            let n = e.constant_int(length)?;
            if !(1..=MAX_EXPANSION).contains(&n) {
                e.findings.error_with(
                    codes::DOMAIN_EMPTY,
                    length.span,
                    format!("an array must have 1 to {MAX_EXPANSION} elements, not {n}"),
                    "give the array a length in that range",
                );
                return None;
            }
            let inner = property_type(e, of)?;
            if inner.length.is_some() {
                e.findings.error_with(
                    codes::TYPE_MISMATCH,
                    of.span,
                    "arrays of arrays are not supported",
                    "use one array with `rows * columns` elements",
                );
                return None;
            }
            Some(PropertyType {
                length: Some(n as usize),
                ..inner
            })
        }
        _ => {
            let (base, unit, length) = e.measured_domain(domain)?;
            Some(PropertyType {
                unit: unit.map(|u| u.name().to_owned()).unwrap_or_default(),
                domain: Some(base),
                length,
            })
        }
    }
}

/// Evaluates the constant value of a property. Returns one number per element, in the declared
/// unit. If there is no value, each number is the smallest value of the domain, or 0 if there is no
/// domain.
pub(in crate::contract) fn property_values<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    value: Option<&'a ast::Expr>,
) -> Option<Vec<f64>> {
    let n = ty.length.unwrap_or(1);
    let Some(value) = value else {
        return Some(vec![ty.domain.as_ref().map_or(0.0, |d| d.low() as f64); n]);
    };
    let expected = ty.domain.as_ref().map(Type::of);
    let expected = match (&expected, ty.length) {
        (Some(t), Some(n)) => Some(Type::Array(Box::new(t.clone()), n)),
        _ => expected,
    };
    let values = match e.value(value, expected.as_ref(), Time::Now)? {
        Value::Array(values) if values.len() == n && ty.length.is_some() => values,
        Value::Array(values) => {
            e.findings.error_with(
                codes::TYPE_MISMATCH,
                value.span,
                if ty.length.is_some() {
                    format!("{} values for {n} elements", values.len())
                } else {
                    format!("{} values, but the property is not an array", values.len())
                },
                "write one value for each element, or a single value for all of them",
            );
            return None;
        }
        other => vec![other; n],
    };
    let (dimension, factor) = unit(&ty.unit);
    let mut numbers = Vec::with_capacity(n);
    for v in values {
        let Value::Scalar(term, found) = v else {
            return None;
        };
        let Some(number) = constant_real(&term) else {
            e.findings.error_with(
                codes::NOT_CONSTANT,
                value.span,
                "this has to be known before the line runs",
                "use numbers, constants and parameters only",
            );
            return None;
        };
        let is_measured = ty.domain.is_some() && dimension != Dimension::None;
        let fits = match (&ty.domain, &found) {
            (Some(_), Type::Number(d)) if is_measured && *d == dimension => true,
            (Some(_), Type::Int) if is_measured => true,
            (Some(d), Type::Int | Type::Bool | Type::Enum(_)) => {
                *d != Domain::Bool && found == Type::Int && Type::of(d) == Type::Int
                    || Type::of(d) == found
            }
            (None, Type::Int) => true,
            (None, Type::Number(d)) => {
                *d == dimension
                    || *d == Dimension::None
                    || *d == Dimension::Share && dimension == Dimension::None
            }
            _ => false,
        };
        if !fits {
            let wanted = ty.domain.as_ref().map_or_else(
                || dimension.describe().to_owned(),
                |d| Type::of(d).describe(),
            );
            e.findings.mismatch(value.span, &wanted, &found);
            return None;
        }
        // A bare number is already in the declared unit.
        let number = match found {
            Type::Number(d) if d != Dimension::None => number / factor,
            _ => number,
        };
        let number = if is_measured {
            let near = number.round();
            if (number - near).abs() > 1e-9 * near.abs().max(1.0) {
                e.findings.error_with(
                    codes::PROPERTY,
                    value.span,
                    format!("{number} is not a whole number of `{}`", ty.unit),
                    "round it, or declare the property in a finer unit",
                );
                return None;
            }
            near
        } else {
            number
        };
        if let Some(d) = &ty.domain
            && !d.contains(number as i64)
        {
            e.findings.error_with(
                codes::PROPERTY,
                value.span,
                format!("{number} is outside {}", d.describe()),
                "use a value in this range, or extend the range in the declaration of the property",
            );
            return None;
        }
        numbers.push(number);
    }
    Some(numbers)
}

/// Declares a property as a variable of an elaborator; returns the ids of its elements.
pub(in crate::contract) fn declare_property(
    e: &mut Elaborator<'_>,
    name: &str,
    ty: &PropertyType,
) -> Vec<VarId> {
    let ids: Vec<VarId> = (0..ty.length.unwrap_or(1))
        .map(|_| match &ty.domain {
            Some(domain) => e.variables.add(domain.clone(), Unit::named(&ty.unit)),
            None => e.variables.add_real(unit(&ty.unit)),
        })
        .collect();
    let entry = match ty.length {
        None => Entry::One(ids[0]),
        Some(_) => Entry::Many(Arc::new(ids.iter().map(|id| Entry::One(*id)).collect())),
    };
    // A property hides an outer constant of the same name.
    e.names.hide(name);
    e.names.variables.insert(name.to_owned(), entry);
    ids
}

/// Returns the names of a property's elements: `h[0]`, `h[1]`; the name itself for a scalar.
pub(in crate::contract) fn element_names(name: &str, ty: &PropertyType) -> Vec<String> {
    match ty.length {
        None => vec![name.to_owned()],
        Some(n) => (0..n).map(|i| format!("{name}[{i}]")).collect(),
    }
}

/// Elaborates a scalar that is assigned to a property, in the property's unit. A bare number is
/// already in that unit if the property is real.
pub(in crate::contract) fn assigned<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    value: &'a ast::Expr,
) -> Option<Term> {
    let expected = ty.domain.as_ref().map(Type::of);
    let (term, found) = e.any_scalar(value, expected.as_ref(), Time::Now)?;
    converted(&mut e.findings, ty, term, &found, value)
}

/// Elaborates an array that is assigned to an array property of length `n`. Reports a different
/// length.
pub(in crate::contract) fn assigned_array<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    n: usize,
    value: &'a ast::Expr,
) -> Option<Vec<Term>> {
    let expected = ty
        .domain
        .as_ref()
        .map(|d| Type::Array(Box::new(Type::of(d)), n));
    match e.value(value, expected.as_ref(), Time::Now)? {
        Value::Array(values) if values.len() == n => values
            .into_iter()
            .map(|v| match v {
                Value::Scalar(term, found) => converted(&mut e.findings, ty, term, &found, value),
                inner => {
                    e.findings
                        .mismatch(value.span, "one value for each element", &inner.ty());
                    None
                }
            })
            .collect(),
        other => {
            e.findings.error_with(
                codes::TYPE_MISMATCH,
                value.span,
                format!("expected an array of {n}, found {}", other.ty().describe()),
                format!("write a list of {n} values"),
            );
            None
        }
    }
}

/// Converts a term to the unit of a property; reports a term of the wrong type.
fn converted(
    findings: &mut Findings,
    ty: &PropertyType,
    term: Term,
    found: &Type,
    value: &ast::Expr,
) -> Option<Term> {
    let expected = ty.domain.as_ref().map(Type::of);
    let (dimension, factor) = unit(&ty.unit);
    match (&expected, found) {
        // A quantity is assigned to a range with a unit. The number is the quantity divided by the
        // unit. The plant does not round it: a number that is not whole is reported at run time.
        (Some(Type::Int), Type::Number(d)) if dimension != Dimension::None => {
            if *d != dimension {
                findings.mismatch(value.span, dimension.describe(), found);
                return None;
            }
            let quotient = linewright_core::gr1::BinaryOp::Div;
            let factor = Term::Real(factor);
            Some(match constant_real(&term).zip(constant_real(&factor)) {
                Some((x, f)) => Term::Real(x / f),
                None => Term::Binary(quotient, Box::new(term), Box::new(factor)),
            })
        }
        (Some(Type::Int), Type::Int)
            if dimension != Dimension::None && constant_real(&term) != Some(0.0) =>
        {
            findings.mismatch(value.span, dimension.describe(), found);
            None
        }
        (Some(want), _) if want == found => Some(term),
        (Some(Type::Int), Type::Number(Dimension::None)) | (None, Type::Int) => Some(term),
        (None, Type::Bool) if dimension == Dimension::None => Some(term),
        (None, Type::Number(d))
            if *d == Dimension::None || *d == Dimension::Share && dimension == Dimension::None =>
        {
            Some(term)
        }
        (None, Type::Number(d)) if *d == dimension =>
        {
            #[expect(clippy::float_cmp, reason = "base units have exactly the factor 1")]
            if factor == 1.0 {
                Some(term)
            } else {
                Some(Term::Binary(
                    linewright_core::gr1::BinaryOp::Div,
                    Box::new(term),
                    Box::new(Term::Real(factor)),
                ))
            }
        }
        _ => {
            let want = expected.map_or_else(|| dimension.describe().to_owned(), |t| t.describe());
            findings.mismatch(value.span, &want, found);
            None
        }
    }
}
