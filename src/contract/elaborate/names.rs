//! Names, labels and indices.

use super::{Elaborator, Entry, nearest};
use crate::contract::value::{Dimension, Term, Type, Value, unit};
use crate::diagnostics::codes;
use crate::gr1::{BinaryOp, Domain, Time, VarId};
use crate::source::Span;
use crate::syntax::ast;

impl<'a> Elaborator<'a> {
    pub(super) fn literal(&mut self, span: Span, number: f64, name: &str) -> Option<Value> {
        if !self.real {
            self.error_with(
                codes::TYPE_MISMATCH,
                span,
                "a contract counts in whole numbers without units",
                "say in the machine what the numbers mean in the plant: `abstract`, `time`, `write`",
            );
            return None;
        }
        let (dimension, factor) = unit(name);
        Some(Value::Scalar(
            Term::Real(number * factor),
            Type::Number(dimension),
        ))
    }

    pub(super) fn path(
        &mut self,
        span: Span,
        names: &[ast::Name],
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let full = names
            .iter()
            .map(|n| n.text.as_str())
            .collect::<Vec<_>>()
            .join(".");
        if let Some(value) = self.constants.get(&full) {
            return Some(value.clone());
        }
        if let Some(body) = self.defines.get(&full).copied() {
            if self.defining.contains(&full) {
                self.error_with(
                    codes::NAME_DOUBLE,
                    span,
                    format!("`{full}` is defined by itself"),
                    "break the circle; a value that depends on itself needs an internal variable and `next`",
                );
                return None;
            }
            self.defining.push(full);
            let value = self.value(body, expected, time);
            self.defining.pop();
            return value;
        }
        if let Some(entry) = self.variables.get(&full).cloned() {
            return Some(match entry {
                Entry::One(id) => self.variable(id, time),
                Entry::Many(ids) => {
                    Value::Array(ids.iter().map(|id| self.variable(*id, time)).collect())
                }
            });
        }
        if let [label] = names
            && let Some(value) = self.label(label, expected)
        {
            return value;
        }
        if let [ty, label] = names
            && let Some(Type::Enum(labels)) = self.types.get(&ty.text)
            && let Some(index) = labels.iter().position(|l| *l == label.text)
        {
            return Some(Value::Scalar(
                Term::Int(index as i64),
                Type::Enum(labels.clone()),
            ));
        }
        self.unknown(span, &full, expected);
        None
    }

    pub(super) fn variable(&self, id: VarId, time: Time) -> Value {
        if let Some(domain) = &self.domains[id.index()] {
            return Value::Scalar(Term::Var(id, time), Type::of(domain));
        }
        let (dimension, factor) = self
            .units
            .get(&id)
            .copied()
            .unwrap_or((Dimension::None, 1.0));
        let read = Term::Var(id, time);
        #[expect(clippy::float_cmp, reason = "base units have exactly the factor 1")]
        let term = if factor == 1.0 {
            read
        } else {
            Term::Binary(BinaryOp::Mul, Box::new(read), Box::new(Term::Real(factor)))
        };
        Value::Scalar(term, Type::Number(dimension))
    }

    /// A label. `None`: it is none. `Some(None)`: it is ambiguous, and that was reported.
    #[expect(
        clippy::option_option,
        reason = "not a label, or one that was reported"
    )]
    pub(super) fn label(
        &mut self,
        name: &ast::Name,
        expected: Option<&Type>,
    ) -> Option<Option<Value>> {
        let of = |labels: &[String]| {
            labels
                .iter()
                .position(|l| *l == name.text)
                .map(|i| Value::Scalar(Term::Int(i as i64), Type::Enum(labels.to_vec())))
        };
        if let Some(Type::Enum(labels)) = expected
            && let Some(value) = of(labels)
        {
            return Some(Some(value));
        }
        let mut candidates: Vec<Vec<String>> = Vec::new();
        let named = self.types.values().filter_map(|t| match t {
            Type::Enum(l) => Some(l),
            _ => None,
        });
        let placed = self.domains.iter().filter_map(|d| match d {
            Some(Domain::Enum { labels, .. }) => Some(labels),
            _ => None,
        });
        for labels in named.chain(placed) {
            if labels.contains(&name.text) && !candidates.contains(labels) {
                candidates.push(labels.clone());
            }
        }
        match candidates.as_slice() {
            [] => None,
            [one] => Some(of(one)),
            _ => {
                self.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("`{}` is a label of several types", name.text),
                    "compare it with a variable of the type that you mean",
                );
                Some(None)
            }
        }
    }

    pub(super) fn unknown(&mut self, span: Span, name: &str, expected: Option<&Type>) {
        let mut known: Vec<&str> = self
            .variables
            .keys()
            .chain(self.constants.keys())
            .map(String::as_str)
            .chain(self.defines.keys().map(String::as_str))
            .collect();
        for ty in self.types.values().chain(expected) {
            if let Type::Enum(labels) = ty {
                known.extend(labels.iter().map(String::as_str));
            }
        }
        for domain in self.domains.iter().flatten() {
            if let Domain::Enum { labels, .. } = domain {
                known.extend(labels.iter().map(String::as_str));
            }
        }
        let help = match nearest(name, known.into_iter()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare it, or import the file that does".to_owned(),
        };
        self.error_with(
            codes::NAME_UNKNOWN,
            span,
            format!("`{name}` is not declared"),
            help,
        );
    }

    pub(super) fn index(
        &mut self,
        span: Span,
        base: &'a ast::Expr,
        index: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let expected_array = expected.map(|t| Type::Array(Box::new(t.clone()), 0));
        let base_value = self.value(base, expected_array.as_ref(), time)?;
        let Value::Array(elements) = base_value else {
            self.error(
                codes::TYPE_MISMATCH,
                base.span,
                format!("this is {}, not an array", base_value.ty().describe()),
            );
            return None;
        };
        let (index_term, ty) = self.any_scalar(index, Some(&Type::Int), time)?;
        if ty != Type::Int {
            self.mismatch(index.span, "a whole number", &ty);
            return None;
        }
        let last = elements.len() as i64 - 1;
        let range = self.range_of(&index_term, index.span)?;
        if range.low < 0 || range.high > last {
            let message = if range.low == range.high {
                format!(
                    "index {} leaves the array, which has {} elements",
                    range.low,
                    elements.len()
                )
            } else {
                format!(
                    "the index can be {}..{}, but the array has only {} elements",
                    range.low,
                    range.high,
                    elements.len()
                )
            };
            self.error_with(
                codes::INDEX_RANGE,
                index.span,
                message,
                format!(
                    "indices are 0..{last}; hold it there with `min(..., {last})` or `max(..., 0)`"
                ),
            );
            return None;
        }
        if let Term::Int(i) = index_term {
            return elements.into_iter().nth(i as usize);
        }
        let mut chosen: Option<Value> = None;
        for i in (range.low..=range.high).rev() {
            let element = elements[i as usize].clone();
            chosen = Some(match (chosen, element) {
                (None, element) => element,
                (Some(Value::Scalar(rest, _)), Value::Scalar(term, ty)) => {
                    let here = Term::binary(BinaryOp::Eq, index_term.clone(), Term::Int(i));
                    Value::Scalar(Term::choose(here, term, rest), ty)
                }
                _ => {
                    self.error(
                        codes::TYPE_MISMATCH,
                        span,
                        "an array of arrays needs a constant first index",
                    );
                    return None;
                }
            });
        }
        chosen
    }
}
