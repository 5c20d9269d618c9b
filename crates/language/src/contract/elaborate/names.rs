//! Names, labels and indices.

use super::{Elaborator, nearest};
use crate::contract::shape::measured;
use crate::contract::value::{Dimension, Term, Type, Value, unit};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{BinaryOp, Domain, Time, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast;

impl<'a> Elaborator<'a> {
    pub(super) fn literal(&mut self, span: Span, number: f64, name: &str) -> Option<Value> {
        let (dimension, factor) = unit(name);
        if !self.real && matches!(dimension, Dimension::None | Dimension::Share) {
            self.error_with(
                codes::TYPE_MISMATCH,
                span,
                "a contract counts in whole numbers",
                "say in the machine what the numbers mean in the plant: `abstract`, `time`, `write`",
            );
            return None;
        }
        // 95 hundredths are nearest to 95 / 100, and not to 95 times what is nearest to 0.01.
        let base = match dimension {
            Dimension::Share => number / (1.0 / factor).round(),
            _ => number * factor,
        };
        Some(Value::Scalar(Term::Real(base), Type::Number(dimension)))
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
            self.spend(span, value.size())?;
            let value = if self.real {
                in_base_units(value)
            } else {
                value
            };
            return match time {
                Time::Now => Some(value),
                Time::Next => self.later(span, value),
            };
        }
        if let Some(define) = self.defines.get(&full).copied() {
            return self.defined(span, define, expected, time);
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
            return Some(self.entry(&entry, time));
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
        // `target.x` of a record `target`.
        if let [first @ .., last] = names
            && let Some(end) = first.last()
            && self.knows(first)
        {
            let base = Span::new(span.file, span.start as usize, end.span.end as usize);
            let value = self.path(base, first, None, time)?;
            return self.member(base, value, last);
        }
        if self.broken.contains(&full) {
            self.tainted = true;
            return None;
        }
        self.unknown(span, &full, expected);
        None
    }

    /// Whether a dotted name, or what it begins with, is declared.
    fn knows(&self, names: &[ast::Name]) -> bool {
        (1..=names.len()).any(|n| {
            let words: Vec<&str> = names[..n].iter().map(|n| n.text.as_str()).collect();
            let name = words.join(".");
            self.constants.contains_key(&name)
                || self.defines.contains_key(&name)
                || self.variables.contains_key(&name)
                || self.broken.contains(&name)
        })
    }

    pub(super) fn variable(&self, id: VarId, time: Time) -> Value {
        if let Some(domain) = &self.domains[id.index()] {
            let read = Term::Var(id, time);
            let ty = measured(domain, self.measures.get(&id).copied());
            // The plant computes in base units.
            return match ty {
                Type::Measured(unit) if self.real => {
                    let factor = Box::new(Term::Real(unit.factor()));
                    let term = Term::Binary(BinaryOp::Mul, Box::new(read), factor);
                    Value::Scalar(term, Type::Number(unit.dimension()))
                }
                ty => Value::Scalar(read, ty),
            };
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
            [one] => match expected {
                Some(Type::Enum(labels)) => {
                    self.foreign_label(name, labels, one);
                    Some(None)
                }
                _ => Some(of(one)),
            },
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

    /// A label where one of another type is wanted.
    fn foreign_label(&mut self, name: &ast::Name, wanted: &[String], other: &[String]) {
        let named = self.types.iter().find(|(_, t)| match t {
            Type::Enum(labels) => labels == other,
            _ => false,
        });
        let owner = match named {
            Some((ty, _)) => format!("`{ty}`"),
            None => format!("{{{}}}", other.join(", ")),
        };
        let help = match nearest(&name.text, wanted.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the labels that fit here are {}", wanted.join(", ")),
        };
        self.error_with(
            codes::TYPE_MISMATCH,
            name.span,
            format!(
                "`{}` is a label of {owner}, which is not the type here",
                name.text
            ),
            help,
        );
    }

    pub(super) fn unknown(&mut self, span: Span, name: &str, expected: Option<&Type>) {
        // Definitions within definitions may come by the same place a million times, and what is near it takes long to find.
        let mut latest = self.findings.iter().rev().take(64);
        if latest.any(|f| f.code == codes::NAME_UNKNOWN && f.span == Some(span)) {
            return;
        }
        // A label of the type that is wanted goes before all else.
        if let Some(Type::Enum(labels)) = expected {
            let near = nearest(name, labels.iter().map(String::as_str));
            let help = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the labels that fit here are {}", labels.join(", ")),
            };
            self.error_with(
                codes::NAME_UNKNOWN,
                span,
                format!("`{name}` is not declared"),
                help,
            );
            return;
        }
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
        let found = element(&index_term, range.low, chosen);
        if found.is_none() {
            self.error_with(
                codes::TYPE_MISMATCH,
                span,
                "the elements of this array differ in kind, so that only a constant index chooses one",
                "give all elements the same length and the same members",
            );
        }
        found
    }
}

/// Counted quantities as real numbers of the plant.
fn in_base_units(value: Value) -> Value {
    let plain = value.clone();
    let changed = value.map(&mut |term, ty| match (term, ty) {
        (Term::Int(i), Type::Measured(unit)) => Some((
            Term::Real(i as f64 * unit.factor()),
            Type::Number(unit.dimension()),
        )),
        other => Some(other),
    });
    changed.unwrap_or(plain)
}

/// Up to so many elements are chosen one by one; more by halves, which keeps formulas shallow.
const MAX_LINEAR: usize = 16;

/// The element that an index names, of those from `low` on: leaf by leaf, where they are no scalars.
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

/// The term that an index names, of those from `low` on.
fn chosen(index: &Term, low: i64, terms: &[Term]) -> Term {
    if terms.len() > MAX_LINEAR {
        return halved(index, low, terms);
    }
    let [first @ .., last] = terms else {
        return Term::FALSE;
    };
    let pairs = (low..).zip(first).collect::<Vec<_>>();
    pairs
        .into_iter()
        .rev()
        .fold(last.clone(), |rest, (i, term)| {
            let here = Term::binary(BinaryOp::Eq, index.clone(), Term::Int(i));
            Term::choose(here, term.clone(), rest)
        })
}

/// The term of `terms`, of which the first has the index `low`, that `index` names.
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
