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
            let value = value.clone();
            if !self.real && value.is_real() {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("`{full}` is a quantity of the plant, and whole numbers without units are counted here"),
                    "say in the machine what the numbers mean in the plant: `abstract`, `time`, `write`",
                );
                return None;
            }
            self.spend(span, value.size())?;
            return Some(value);
        }
        if let Some(define) = self.defines.get(&full).copied() {
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
            let value = self.unbound(|e| e.value(&define.value, expected, time));
            self.defining.pop();
            return value;
        }
        if let Some(counter) = self.counters.get(&full).copied() {
            if self.defining.contains(&full) {
                self.error_with(
                    codes::NAME_DOUBLE,
                    span,
                    format!("the counter `{full}` is told by itself when to count"),
                    "break the circle; a value that depends on itself needs an internal variable and `next`",
                );
                return None;
            }
            self.defining.push(full);
            let value = self.unbound(|e| e.counter(counter, time));
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
        if self.broken.contains(&full) {
            self.tainted = true;
            return None;
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
            self.error_with(
                codes::TYPE_MISMATCH,
                base.span,
                format!("this is {}, not an array", base_value.ty().describe()),
                "leave the index out, or declare it as `array[n] of ...`",
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
            let count = match elements.len() {
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
        self.spend(span, index_term.size().saturating_mul(elements.len()))?;
        let chosen = &elements[range.low as usize..=range.high as usize];
        if chosen.len() > MAX_LINEAR {
            let Some(terms) = scalars(chosen) else {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    "an array of arrays needs a constant first index",
                    "use one array with `rows * columns` elements",
                );
                return None;
            };
            let (_, ty) = &terms[0];
            let ty = ty.clone();
            return Some(Value::Scalar(halved(&index_term, range.low, &terms), ty));
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
                    self.error_with(
                        codes::TYPE_MISMATCH,
                        span,
                        "an array of arrays needs a constant first index",
                        "use one array with `rows * columns` elements",
                    );
                    return None;
                }
            });
        }
        chosen
    }
}

/// Up to so many elements are chosen one by one; more by halves, which keeps formulas shallow.
const MAX_LINEAR: usize = 16;

fn scalars(values: &[Value]) -> Option<Vec<(Term, Type)>> {
    values
        .iter()
        .map(|v| match v {
            Value::Scalar(term, ty) => Some((term.clone(), ty.clone())),
            Value::Array(_) => None,
        })
        .collect()
}

/// The term of `terms`, of which the first has the index `low`, that `index` names.
fn halved(index: &Term, low: i64, terms: &[(Term, Type)]) -> Term {
    if let [(one, _)] = terms {
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
