//! Selection of array elements by index. The index can be constant, or depend on variables.

use super::Elaborator;
use crate::contract::shape::Entry;
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Time};
use linewright_core::source::Span;
use linewright_syntax::ast;

/// Maximum length of an array whose element is selected by a chain of comparisons. In longer arrays
/// it is selected by bisection, because the formula is then less deep.
const MAX_LINEAR: usize = 16;

/// What the expression before an index refers to.
enum Referent {
    /// A variable, or a part of a variable, that is not yet expanded to a value.
    Variable(Entry),
    /// Any other value.
    Value(Value),
}

impl<'a> Elaborator<'a> {
    pub(super) fn index(
        &mut self,
        span: Span,
        base: &'a ast::Expr,
        index: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let element = self.element_of(span, base, index, expected, time)?;
        Some(self.to_value(element, time))
    }

    fn to_value(&self, named: Referent, time: Time) -> Value {
        match named {
            Referent::Variable(entry) => self.variables.entry(&entry, time, self.dialect.real),
            Referent::Value(value) => value,
        }
    }

    /// Resolves the expression before an index. Follows an array of arrays of variables index by
    /// index, so that only the selected element is expanded.
    fn named(&mut self, e: &'a ast::Expr, expected: Option<&Type>, time: Time) -> Option<Referent> {
        match &e.kind {
            ast::ExprKind::Path(names) => {
                if let Some(entry) = self.names.variable(names) {
                    let entry = entry.clone();
                    self.expansion.spend(e.span, 1, &mut self.findings)?;
                    return Some(Referent::Variable(entry));
                }
            }
            ast::ExprKind::Index(base, index) => {
                self.expansion.spend(e.span, 1, &mut self.findings)?;
                self.expansion.enter(e.span, &mut self.findings)?;
                let element = self.element_of(e.span, base, index, expected, time);
                self.expansion.leave();
                return element;
            }
            _ => {}
        }
        self.value(e, expected, time).map(Referent::Value)
    }

    fn element_of(
        &mut self,
        span: Span,
        base: &'a ast::Expr,
        index: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Referent> {
        let expected_array = expected.map(|t| Type::Array(Box::new(t.clone()), 0));
        let named = self.named(base, expected_array.as_ref(), time)?;
        let length = match &named {
            Referent::Variable(Entry::Many(list)) => list.len(),
            Referent::Value(Value::Array(elements)) => elements.len(),
            Referent::Variable(_) | Referent::Value(_) => {
                let found = self.to_value(named, time).ty();
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    base.span,
                    format!("this is {}, not an array", found.describe()),
                    "remove the index, or declare it as `array[n] of ...`",
                );
                return None;
            }
        };
        let (index_term, ty) = self.any_scalar(index, Some(&Type::Int), time)?;
        if ty != Type::Int {
            self.findings.mismatch(index.span, "a whole number", &ty);
            return None;
        }
        let last = length as i64 - 1;
        let range = self.range_of(&index_term, index.span)?;
        if range.low < 0 || range.high > last {
            let count = match length {
                1 => "1 element".to_owned(),
                n => format!("{n} elements"),
            };
            let message = if range.low == range.high {
                format!(
                    "index {} is outside the array, which has {count}",
                    range.low
                )
            } else {
                format!(
                    "the index can be {}..{}, but the array has only {count}",
                    range.low, range.high
                )
            };
            self.findings.error_with(
                codes::INDEX_RANGE,
                index.span,
                message,
                format!("limit the index to 0..{last} with `min(..., {last})` or `max(..., 0)`"),
            );
            return None;
        }
        let elements = match (named, &index_term) {
            (Referent::Variable(Entry::Many(list)), Term::Int(i)) => {
                return list.get(*i as usize).cloned().map(Referent::Variable);
            }
            (Referent::Value(Value::Array(elements)), Term::Int(i)) => {
                return elements.into_iter().nth(*i as usize).map(Referent::Value);
            }
            (named, _) => match self.to_value(named, time) {
                Value::Array(elements) => elements,
                Value::Scalar(..) | Value::Record(_) => return None,
            },
        };
        self.expansion.spend(
            span,
            index_term.size().saturating_mul(length),
            &mut self.findings,
        )?;
        let chosen = &elements[range.low as usize..=range.high as usize];
        let found = element(&index_term, range.low, chosen);
        if found.is_none() {
            self.findings.error_with(
                codes::TYPE_MISMATCH,
                span,
                "the elements of this array have different types, so only a constant index can select one",
                "give all elements the same length and the same members",
            );
        }
        found.map(Referent::Value)
    }
}

/// Selects an element by index, leaf by leaf. The first of `elements` has the index `low`. Returns
/// `None` if the elements have different shapes.
fn element(index: &Term, low: i64, elements: &[Value]) -> Option<Value> {
    match elements.first()? {
        Value::Scalar(_, ty) => {
            let terms: Option<Vec<Term>> = elements
                .iter()
                .map(|v| match v {
                    Value::Scalar(term, _) => Some(term.clone()),
                    _ => None,
                })
                .collect();
            Some(Value::Scalar(chosen(index, low, &terms?), ty.clone()))
        }
        Value::Array(first) => {
            let parts = (0..first.len()).map(|k| {
                let parts = elements.iter().map(|v| match v {
                    Value::Array(list) if list.len() == first.len() => Some(list[k].clone()),
                    _ => None,
                });
                element(index, low, &parts.collect::<Option<Vec<_>>>()?)
            });
            Some(Value::Array(parts.collect::<Option<_>>()?))
        }
        Value::Record(first) => {
            let parts = first.iter().enumerate().map(|(k, (name, _))| {
                let parts = elements.iter().map(|v| match v {
                    Value::Record(members) => members
                        .get(k)
                        .filter(|(n, _)| n == name)
                        .map(|(_, v)| v.clone()),
                    _ => None,
                });
                let value = element(index, low, &parts.collect::<Option<Vec<_>>>()?)?;
                Some((name.clone(), value))
            });
            Some(Value::Record(parts.collect::<Option<_>>()?))
        }
    }
}

/// Selects a term by index; the first of `terms` has the index `low`.
fn chosen(index: &Term, low: i64, terms: &[Term]) -> Term {
    if terms.len() > MAX_LINEAR {
        return bisected(index, low, terms);
    }
    let [first @ .., last] = terms else {
        return Term::FALSE;
    };
    (low..)
        .zip(first)
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .fold(last.clone(), |rest, (i, term)| {
            let here = Term::binary(BinaryOp::Eq, index.clone(), Term::Int(i));
            Term::choose(here, term.clone(), rest)
        })
}

/// Selects the same term as [`chosen`], but by bisection.
fn bisected(index: &Term, low: i64, terms: &[Term]) -> Term {
    if let [one] = terms {
        return one.clone();
    }
    let (left, right) = terms.split_at(terms.len() / 2);
    let middle = low + left.len() as i64;
    let below = Term::binary(BinaryOp::Lt, index.clone(), Term::Int(middle));
    Term::choose(
        below,
        bisected(index, low, left),
        bisected(index, middle, right),
    )
}
