//! Array elements by index, including indices known only when the machine runs.

use super::Elaborator;
use crate::contract::shape::Entry;
use crate::contract::value::{Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Time};
use linewright_core::source::Span;
use linewright_syntax::ast;

/// Maximum number of elements chosen one by one; more are chosen by halves, which keeps formulas
/// shallow.
const MAX_LINEAR: usize = 16;

/// What an expression names: a variable or a part of one, not necessarily expanded yet, or any
/// other value.
enum Referent {
    Variable(Entry),
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
        Some(self.written_out(element, time))
    }

    fn written_out(&self, named: Referent, time: Time) -> Value {
        match named {
            Referent::Variable(entry) => self.variables.entry(&entry, time, self.dialect.real),
            Referent::Value(value) => value,
        }
    }

    /// Resolves the indexed expression. Follows an array of arrays of variables index by index, so
    /// that one element costs no more than itself.
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
                let found = self.written_out(named, time).ty();
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    base.span,
                    format!("this is {}, not an array", found.describe()),
                    "leave the index out, or declare it as `array[n] of ...`",
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
                format!("index {} leaves the array, which has {count}", range.low)
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
                format!(
                    "indices are 0..{last}; hold it there with `min(..., {last})` or `max(..., 0)`"
                ),
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
            (named, _) => match self.written_out(named, time) {
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
                "the elements of this array differ in kind, so that only a constant index chooses one",
                "give all elements the same length and the same members",
            );
        }
        found.map(Referent::Value)
    }
}

/// Selects an element by index, where `elements` begin at index `low`: leaf by leaf, if they are
/// not scalars.
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

/// Selects a term by index, where `terms` begin at index `low`.
fn chosen(index: &Term, low: i64, terms: &[Term]) -> Term {
    if terms.len() > MAX_LINEAR {
        return halved(index, low, terms);
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

/// Selects a term by index, where `terms` begin at index `low`, by halving.
fn halved(index: &Term, low: i64, terms: &[Term]) -> Term {
    if let [one] = terms {
        return one.clone();
    }
    let (left, right) = terms.split_at(terms.len() / 2);
    let middle = low + left.len() as i64;
    let below = Term::binary(BinaryOp::Lt, index.clone(), Term::Int(middle));
    Term::choose(
        below,
        halved(index, low, left),
        halved(index, middle, right),
    )
}
