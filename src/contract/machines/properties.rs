//! Properties of parts: their types, their values, and how expressions see them.

use crate::contract::elaborate::{Elaborator, Entry, MAX_EXPANSION, constant_real};
use crate::contract::value::{Dimension, Term, Type, Value, unit};
use crate::diagnostics::codes;
use crate::gr1::{Domain, Time, VarId};
use crate::syntax::ast;

/// The type of a property: what a plant expression sees of it.
#[derive(Debug, Clone)]
pub(in crate::contract) struct PropertyType {
    /// How it is shown, `deg`; empty for a bare number.
    pub unit: String,
    /// Its finite domain, for truth values, ranges and labels.
    pub domain: Option<Domain>,
    /// How many elements, for an array.
    pub length: Option<usize>,
}

/// The type of a property as it was written.
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
                e.error(
                    codes::DOMAIN_EMPTY,
                    length.span,
                    format!("an array has at least one element, not {n}"),
                );
                return None;
            }
            let inner = property_type(e, of)?;
            if inner.length.is_some() {
                e.error(
                    codes::TYPE_MISMATCH,
                    of.span,
                    "arrays of arrays are not known",
                );
                return None;
            }
            Some(PropertyType {
                length: Some(n as usize),
                ..inner
            })
        }
        _ => {
            let (base, length) = e.domain(domain)?;
            Some(PropertyType {
                unit: String::new(),
                domain: Some(base),
                length,
            })
        }
    }
}

/// The value of a property, in its declared unit: a constant, or a list of them for an array.
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
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("{} values for {n} elements", values.len()),
            );
            return None;
        }
        scalar @ Value::Scalar(..) => vec![scalar; n],
    };
    let (dimension, factor) = unit(&ty.unit);
    let mut numbers = Vec::with_capacity(n);
    for v in values {
        let Value::Scalar(term, found) = v else {
            return None;
        };
        let Some(number) = constant_real(&term) else {
            e.error(
                codes::NOT_CONSTANT,
                value.span,
                "this has to be known beforehand",
            );
            return None;
        };
        let fits = match (&ty.domain, &found) {
            (Some(d), Type::Int | Type::Bool | Type::Enum(_)) => {
                *d != Domain::Bool && found == Type::Int && Type::of(d) == Type::Int
                    || Type::of(d) == found
            }
            (None, Type::Int) => true,
            (None, Type::Number(d)) => *d == dimension || *d == Dimension::None,
            _ => false,
        };
        if !fits {
            let wanted = ty
                .domain
                .as_ref()
                .map_or_else(|| dimension.word().to_owned(), |d| Type::of(d).describe());
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("expected {wanted}, found {}", found.describe()),
            );
            return None;
        }
        if let Some(d) = &ty.domain
            && !d.contains(number as i64)
        {
            e.error(
                codes::PROPERTY,
                value.span,
                format!("{number} is outside {}", d.describe()),
            );
            return None;
        }
        // A bare number is in the declared unit already.
        numbers.push(match found {
            Type::Number(d) if d != Dimension::None => number / factor,
            _ => number,
        });
    }
    Some(numbers)
}

/// Brings a property into an elaborator's sight under new ids; gives the ids.
pub(in crate::contract) fn see_property(
    e: &mut Elaborator<'_>,
    name: &str,
    ty: &PropertyType,
) -> Vec<VarId> {
    let ids: Vec<VarId> = (0..ty.length.unwrap_or(1))
        .map(|_| {
            let id = VarId(e.domains.len() as u32);
            e.domains.push(ty.domain.clone());
            if ty.domain.is_none() {
                e.units.insert(id, unit(&ty.unit));
            }
            id
        })
        .collect();
    let entry = match ty.length {
        None => Entry::One(ids[0]),
        Some(_) => Entry::Many(ids.clone()),
    };
    e.variables.insert(name.to_owned(), entry);
    ids
}

/// The names of a property's elements.
pub(in crate::contract) fn element_names(name: &str, ty: &PropertyType) -> Vec<String> {
    match ty.length {
        None => vec![name.to_owned()],
        Some(n) => (0..n).map(|i| format!("{name}[{i}]")).collect(),
    }
}

/// A real expression assigned to a property: a value with a dimension is converted to the property's unit, a bare number is
/// taken to be in it.
pub(in crate::contract) fn assigned<'a>(
    e: &mut Elaborator<'a>,
    ty: &PropertyType,
    value: &'a ast::Expr,
) -> Option<Term> {
    let expected = ty.domain.as_ref().map(Type::of);
    let (term, found) = e.any_scalar(value, expected.as_ref(), Time::Now)?;
    let (dimension, factor) = unit(&ty.unit);
    match (&expected, &found) {
        (Some(want), _) if want == &found => Some(term),
        (Some(Type::Int), Type::Number(Dimension::None)) | (None, Type::Int | Type::Bool) => {
            Some(term)
        }
        (None, Type::Number(d)) if *d == Dimension::None => Some(term),
        (None, Type::Number(d)) if *d == dimension =>
        {
            #[expect(clippy::float_cmp, reason = "base units have exactly the factor 1")]
            if factor == 1.0 {
                Some(term)
            } else {
                Some(Term::Binary(
                    crate::gr1::BinaryOp::Div,
                    Box::new(term),
                    Box::new(Term::Real(factor)),
                ))
            }
        }
        _ => {
            let want = expected.map_or_else(|| dimension.word().to_owned(), |t| t.describe());
            e.error(
                codes::TYPE_MISMATCH,
                value.span,
                format!("expected {want}, found {}", found.describe()),
            );
            None
        }
    }
}
