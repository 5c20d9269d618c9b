//! Elaboration of finite types.

use super::expansion::MAX_EXPANSION;
use super::units::fitted;
use super::{Elaborator, nearest};
use crate::contract::shape::Shape;
use crate::contract::units::Unit;
use crate::contract::value::{Term, Type};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Domain, Time};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind};
use std::collections::BTreeSet;

/// Maximum number of values of a domain.
const MAX_DOMAIN: i64 = 1 << 20;
/// Maximum number of scalar leaves of a type.
const MAX_LEAVES: usize = 1 << 16;

impl<'a> Elaborator<'a> {
    /// Elaborates a scalar domain without a unit, or an array of such scalars. Returns the domain
    /// and, for an array, its length.
    pub fn domain(&mut self, domain: &'a ast::Domain) -> Option<(Domain, Option<usize>)> {
        let (base, unit, length) = self.measured_domain(domain)?;
        if let Some(unit) = unit {
            self.findings.error_with(
                codes::TYPE_MISMATCH,
                domain.span,
                format!(
                    "a unit is not allowed here, and this domain is in `{}`",
                    unit.name()
                ),
                "remove the unit",
            );
            return None;
        }
        Some((base, length))
    }

    /// Elaborates a scalar domain, or an array of scalars. Returns the domain, its unit if there is
    /// one, and, for an array, its length.
    pub fn measured_domain(
        &mut self,
        domain: &'a ast::Domain,
    ) -> Option<(Domain, Option<Unit>, Option<usize>)> {
        match self.shape(domain)? {
            Shape::Scalar(base, unit) => Some((base, unit, None)),
            Shape::Array(of, n) if matches!(*of, Shape::Scalar(..)) => match *of {
                Shape::Scalar(base, unit) => Some((base, unit, Some(n))),
                _ => None,
            },
            Shape::Array(..) | Shape::Record(_) => {
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    domain.span,
                    "records and arrays of arrays are allowed only in contracts",
                    "declare each member separately, or one array with `rows * columns` elements",
                );
                None
            }
        }
    }

    /// Elaborates a finite type of any shape.
    pub fn shape(&mut self, domain: &'a ast::Domain) -> Option<Shape> {
        match &domain.kind {
            ast::DomainKind::Labels(names) => {
                let mut labels: Vec<String> = Vec::new();
                for name in names {
                    if labels.contains(&name.text) {
                        self.findings.error_with(
                            codes::NAME_DUPLICATE,
                            name.span,
                            format!("the label `{}` appears twice", name.text),
                            "remove it, or rename it",
                        );
                    } else {
                        labels.push(name.text.clone());
                    }
                }
                Some(Shape::Scalar(Domain::Enum { name: None, labels }, None))
            }
            ast::DomainKind::Range(low, high, unit) => {
                self.range(domain, low, high, unit.as_deref())
            }
            ast::DomainKind::Array(length, of) => {
                let length_value = self.constant_int(length)?;
                if !(1..=MAX_EXPANSION).contains(&length_value) {
                    self.findings.error_with(
                        codes::DOMAIN_EMPTY,
                        length.span,
                        format!(
                            "an array must have 1 to {MAX_EXPANSION} elements, not {length_value}"
                        ),
                        "give the array a length in that range",
                    );
                    return None;
                }
                let of = self.shape(of)?;
                let length = length_value as usize;
                self.bounded(domain.span, Shape::Array(Box::new(of), length))
            }
            ast::DomainKind::Record(members) => self.record_shape(domain.span, members),
            ast::DomainKind::Named(name) if name.text == "bool" => {
                Some(Shape::Scalar(Domain::Bool, None))
            }
            ast::DomainKind::Named(name) => {
                if let Some(shape) = self.names.shapes.get(&name.text) {
                    return Some(shape.clone());
                }
                if self.names.broken.contains(&name.text) {
                    self.findings.tainted = true;
                    return None;
                }
                let known: Vec<String> = self
                    .names
                    .shapes
                    .keys()
                    .cloned()
                    .chain(["bool".to_owned()])
                    .collect();
                let help = if matches!(name.text.as_str(), "int" | "integer" | "real" | "number") {
                    "a contract's numbers are bounded: write a range such as `0..9`".to_owned()
                } else {
                    match nearest(&name.text, known.iter().map(String::as_str)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            "declare it with `type`, or import the file that declares it".to_owned()
                        }
                    }
                };
                self.findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no type `{}`", name.text),
                    help,
                );
                None
            }
            ast::DomainKind::Unit(unit) => {
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    domain.span,
                    format!("`{unit}` by itself is the type of real numbers; a contract has only whole numbers"),
                    format!("write a range such as `0..9 {unit}`"),
                );
                None
            }
        }
    }

    fn range(
        &mut self,
        domain: &ast::Domain,
        low: &'a ast::Expr,
        high: &'a ast::Expr,
        written: Option<&str>,
    ) -> Option<Shape> {
        // If the two ends have different units, the finer unit is used.
        let named = |name: Option<&str>| name.and_then(Unit::named);
        let unit = match (named(written), named(unit_in(low)), named(unit_in(high))) {
            (Some(unit), ..) | (None, Some(unit), None) | (None, None, Some(unit)) => Some(unit),
            (None, Some(a), Some(b)) if b.in_terms_of(a).is_some() => Some(a),
            (None, _, b) => b,
        };
        let (l, h) = (self.bound_of(low, unit), self.bound_of(high, unit));
        let (low, high) = (l?, h?);
        if low > high {
            self.findings.error_with(
                codes::DOMAIN_EMPTY,
                domain.span,
                format!("{low}..{high} is empty"),
                "write the smaller number first",
            );
            return None;
        }
        if high.saturating_sub(low) >= MAX_DOMAIN {
            self.findings.error_with(
                codes::DOMAIN_EMPTY,
                domain.span,
                format!("{low}..{high} has more than {MAX_DOMAIN} values"),
                "use a coarser abstraction",
            );
            return None;
        }
        Some(Shape::Scalar(Domain::Range { low, high }, unit))
    }

    /// Evaluates one end of a range. A bare number is in the unit of the range.
    fn bound_of(&mut self, e: &'a ast::Expr, unit: Option<Unit>) -> Option<i64> {
        let Some(unit) = unit else {
            return self.constant_int(e);
        };
        let (term, ty) = self.any_scalar(e, Some(&Type::Int), Time::Now)?;
        let term = match (&term, &ty) {
            (Term::Int(_), Type::Int) => term,
            (Term::Real(x), Type::Number(d)) if *d == crate::contract::units::Dimension::None => {
                unit.count(*x * unit.factor()).map(Term::Int)?
            }
            _ => fitted(
                e.span,
                (term, ty),
                &Type::Measured(unit),
                &mut self.findings,
            )?,
        };
        if let Term::Int(i) = term {
            return Some(i);
        }
        self.findings.error_with(
            codes::NOT_CONSTANT,
            e.span,
            "this has to be known before the machine runs",
            "use numbers, constants and parameters only",
        );
        None
    }

    fn record_shape(
        &mut self,
        span: Span,
        members: &'a [(ast::Name, ast::Domain)],
    ) -> Option<Shape> {
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        let mut shapes = Vec::with_capacity(members.len());
        for (name, domain) in members {
            if !seen.insert(&name.text) {
                self.findings.error_with(
                    codes::NAME_DUPLICATE,
                    name.span,
                    format!("the member `{}` appears twice", name.text),
                    "remove it, or rename it",
                );
            }
            shapes.push(self.shape(domain).map(|s| (name.text.clone(), s)));
        }
        let members = shapes.into_iter().collect::<Option<_>>()?;
        self.bounded(span, Shape::Record(members))
    }

    /// Rejects a type with too many leaves before a larger type is built from it.
    fn bounded(&mut self, span: Span, shape: Shape) -> Option<Shape> {
        if shape.leaf_count() > MAX_LEAVES {
            self.findings.error_with(
                codes::DOMAIN_EMPTY,
                span,
                format!("this type has more than {MAX_LEAVES} scalar values"),
                "use smaller arrays and records",
            );
            return None;
        }
        Some(shape)
    }
}

/// Returns the first unit written in an expression.
pub(super) fn unit_in(e: &ast::Expr) -> Option<&str> {
    match &e.kind {
        ExprKind::Quantity(_, unit) if !unit.is_empty() => Some(unit),
        _ => e.children().into_iter().find_map(unit_in),
    }
}
