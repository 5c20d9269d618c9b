//! Resolution of names, labels and literals in expressions.

use super::records::member;
use super::{Elaborator, nearest};
use crate::contract::units::UNITS;
use crate::contract::value::{Dimension, Term, Type, Value, unit};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::{Domain, Time};
use linewright_core::source::Span;
use linewright_syntax::ast;

/// Words by which authors of machines and lines try to write a random time.
const DISTRIBUTIONS: [&str; 7] = [
    "exponential",
    "exp",
    "normal",
    "poisson",
    "random",
    "triangular",
    "uniform",
];

impl Elaborator<'_> {
    pub(super) fn literal(&mut self, span: Span, number: f64, name: &str) -> Option<Value> {
        let (dimension, factor) = unit(name);
        if !self.dialect.real && matches!(dimension, Dimension::None | Dimension::Share) {
            self.findings.error_with(
                codes::TYPE_MISMATCH,
                span,
                "a contract has only whole numbers",
                "declare in the machine what the numbers mean in the plant, with `abstract`, `time` or `write`",
            );
            return None;
        }
        // 95 % is computed as 95 / 100, because 95 * 0.01 would be rounded twice.
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
        if let Some(value) = self.names.constants.get(&full) {
            let value = value.clone();
            self.expansion
                .spend(span, value.size(), &mut self.findings)?;
            let value = if self.dialect.real {
                in_base_units(value)
            } else {
                value
            };
            return match time {
                Time::Now => Some(value),
                Time::Next => self.later(span, value),
            };
        }
        if let Some(define) = self.names.defines.get(&full).copied() {
            return self.constant_define(span, define, expected, time);
        }
        if let Some(counter) = self.names.counters.get(&full).copied() {
            if self.expansion.defining.contains(&full) {
                self.findings.error_with(
                    codes::NAME_DUPLICATE,
                    span,
                    format!("the counter `{full}` depends on itself"),
                    "break the cycle; to compute a value from its previous value, use an internal variable and `next`",
                );
                return None;
            }
            self.expansion.defining.push(full);
            let value = self.without_bound_names(|e| e.counter(counter, time));
            self.expansion.defining.pop();
            return value;
        }
        if let Some(entry) = self.names.variables.get(&full) {
            return Some(self.variables.entry(entry, time, self.dialect.real));
        }
        if let [label] = names
            && let Some(value) = self.label(label, expected)
        {
            return value;
        }
        if let [ty, label] = names
            && let Some(Type::Enum(labels)) = self.names.types.get(&ty.text)
            && let Some(index) = labels.iter().position(|l| *l == label.text)
        {
            return Some(Value::Scalar(
                Term::Int(index as i64),
                Type::Enum(labels.clone()),
            ));
        }
        // `x` can be a member of a record `target`, as in `target.x`.
        if let [first @ .., last] = names
            && let Some(end) = first.last()
            && self.names.has_prefix_of(first)
        {
            let base = Span::new(span.file, span.start as usize, end.span.end as usize);
            let value = self.path(base, first, None, time)?;
            return member(base, value, last, &mut self.findings);
        }
        if self.names.broken.contains(&full) {
            self.findings.tainted = true;
            return None;
        }
        self.unknown(span, &full, expected);
        None
    }

    /// Resolves a label. Returns `None` if the name is not a label. Reports an error and returns
    /// `Some(None)` if it is a label of several types, or not of the expected type.
    #[expect(
        clippy::option_option,
        reason = "the outer `None` means that the name is no label, the inner one that an error was reported"
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
        let named = self.names.types.values().filter_map(|t| match t {
            Type::Enum(l) => Some(l),
            _ => None,
        });
        let of_variables = self.variables.domains.iter().filter_map(|d| match d {
            Some(Domain::Enum { labels, .. }) => Some(labels),
            _ => None,
        });
        for labels in named.chain(of_variables) {
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
                self.findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("`{}` is a label of several types", name.text),
                    "compare it with a variable of the type that you mean",
                );
                Some(None)
            }
        }
    }

    /// Reports a label of one type where another type is expected.
    fn foreign_label(&mut self, name: &ast::Name, expected: &[String], other: &[String]) {
        let named = self.names.types.iter().find(|(_, t)| match t {
            Type::Enum(labels) => labels == other,
            _ => false,
        });
        let owner = match named {
            Some((ty, _)) => format!("`{ty}`"),
            None => format!("{{{}}}", other.join(", ")),
        };
        let help = match nearest(&name.text, expected.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "the labels of the expected type are {}",
                expected.join(", ")
            ),
        };
        self.findings.error_with(
            codes::TYPE_MISMATCH,
            name.span,
            format!(
                "`{}` is a label of {owner}, which is not the expected type",
                name.text
            ),
            help,
        );
    }

    /// Reports a name that is not declared, and suggests a similar one.
    pub(super) fn unknown(&mut self, span: Span, name: &str, expected: Option<&Type>) {
        // A name that was just reported is skipped: nested defines can expand to the same unknown
        // name a million times, and the search for similar names is slow.
        let mut latest = self.findings.list.iter().rev().take(64);
        if latest.any(|f| f.code == codes::NAME_UNKNOWN && f.span == Some(span)) {
            return;
        }
        // Where a label is expected, only labels of that type are suggested.
        if let Some(Type::Enum(labels)) = expected {
            let near = nearest(name, labels.iter().map(String::as_str));
            let help = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the labels of the expected type are {}", labels.join(", ")),
            };
            self.findings.error_with(
                codes::NAME_UNKNOWN,
                span,
                format!("`{name}` is not declared"),
                help,
            );
            return;
        }
        let mut known: Vec<&str> = self
            .names
            .variables
            .keys()
            .chain(self.names.constants.keys())
            .map(String::as_str)
            .chain(self.names.defines.keys().map(String::as_str))
            .collect();
        for ty in self.names.types.values().chain(expected) {
            if let Type::Enum(labels) = ty {
                known.extend(labels.iter().map(String::as_str));
            }
        }
        for domain in self.variables.domains.iter().flatten() {
            if let Domain::Enum { labels, .. } = domain {
                known.extend(labels.iter().map(String::as_str));
            }
        }
        let help = match nearest(name, known.into_iter()) {
            _ if UNITS.contains(&name) => format!(
                "`{name}` is a unit, and has to follow a number; the units of speed are `m/s`, `mm/s`, `m/min` and `mm/min`"
            ),
            Some(near) => format!("did you mean `{near}`?"),
            None if self.dialect.real && DISTRIBUTIONS.contains(&name) => {
                "write a distribution with its parameters: `takes exponential(20 s)`, `every erlang(3, 20 s)`; `random` is for sources: `every random 20 s`".to_owned()
            }
            None => "declare it, or import the file that declares it".to_owned(),
        };
        self.findings.error_with(
            codes::NAME_UNKNOWN,
            span,
            format!("`{name}` is not declared"),
            help,
        );
    }
}

/// Converts whole numbers with units to real numbers in base units.
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
