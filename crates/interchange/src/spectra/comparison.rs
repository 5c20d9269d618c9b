//! Comparisons: equality, and the order of enumerations.
//!
//! Two values of enumerations are equal if they have the same name. As in Spectra's tool, two
//! variables of enumerations can be compared by size; the order is that in which their values are
//! declared.

use super::reader::Reader;
use super::syntax::Node;
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::BinaryOp;
use linewright_core::source::Span;

impl Reader {
    /// The value of a chain of `=`, `!=`, `<->`, `xor` and `|`.
    pub fn equations(
        &mut self,
        values: Vec<Value>,
        rest: &[(BinaryOp, Node)],
        spans: &[Span],
    ) -> Option<Value> {
        let mut values = values.into_iter();
        let mut left = values.next()?;
        for (index, ((op, _), right)) in rest.iter().zip(values).enumerate() {
            let around = spans[index].to(spans[index + 1]);
            if *op == BinaryOp::Or {
                self.expect_kind(&left, &Kind::Bool, around)?;
                self.expect_kind(&right, &Kind::Bool, around)?;
                left = Value::binary(BinaryOp::Or, left, right);
            } else {
                let equal = self.equal(left, right, around)?;
                left = if *op == BinaryOp::Ne {
                    equal.not()
                } else {
                    equal
                };
            }
        }
        Some(left)
    }

    /// The value of `a = b`; values of enumerations are compared by name.
    pub fn equal(&mut self, a: Value, b: Value, span: Span) -> Option<Value> {
        let found = match (&a.kind, &b.kind) {
            (Kind::Bool, Kind::Bool) | (Kind::Int, Kind::Int) => {
                Some(Value::binary(BinaryOp::Eq, a, b))
            }
            (Kind::Label(x), Kind::Label(y)) => Some(Value::bool(x == y)),
            (Kind::Labels(x), Kind::Labels(y)) if x == y => Some(Value::binary(BinaryOp::Eq, a, b)),
            (Kind::Labels(x), Kind::Labels(y)) => {
                let (x, y) = (x.clone(), y.clone());
                let mut cases = Vec::new();
                for (i, label) in x.iter().enumerate() {
                    if let Some(j) = y.iter().position(|l| l == label) {
                        let is = |v: &Value, n: usize| {
                            Value::binary(BinaryOp::Eq, v.clone(), Value::int(n as i64))
                        };
                        cases.push(Value::binary(BinaryOp::And, is(&a, i), is(&b, j)));
                    }
                }
                (!cases.is_empty()).then(|| Value::chain(BinaryOp::Or, cases))
            }
            (Kind::Labels(labels), Kind::Label(label))
            | (Kind::Label(label), Kind::Labels(labels)) => {
                let Some(index) = labels.iter().position(|l| l == label) else {
                    let described = Kind::Labels(labels.clone()).describe();
                    let message = format!("`{label}` is compared with {described}");
                    self.error(
                        codes::TYPE_MISMATCH,
                        span,
                        message,
                        "compare the variable with one of its own values",
                    );
                    return None;
                };
                let variable = if matches!(a.kind, Kind::Labels(_)) {
                    a
                } else {
                    b
                };
                let index = Value::int(index as i64);
                return Some(Value::binary(BinaryOp::Eq, variable, index));
            }
            // If an enumeration consists of numbers with gaps, its labels are compared with the
            // number.
            (Kind::Labels(labels), Kind::Int) | (Kind::Int, Kind::Labels(labels)) => {
                let (variable, number) = if a.kind == Kind::Int {
                    (&b, &a)
                } else {
                    (&a, &b)
                };
                let label = number.constant().map(|n| n.to_string());
                let index = label.and_then(|l| labels.iter().position(|m| *m == l));
                index.map(|i| Value::binary(BinaryOp::Eq, variable.clone(), Value::int(i as i64)))
            }
            _ => None,
        };
        if found.is_none() {
            let message = "values of different types are compared";
            self.error(
                codes::TYPE_MISMATCH,
                span,
                message,
                "compare numbers with numbers, truth values with truth values, and values of one enumeration with each other",
            );
        }
        found
    }

    /// The value of `a < b` and similar operators, if an operand has an enumeration type.
    pub fn compare_positions(
        &mut self,
        op: BinaryOp,
        values: Vec<Value>,
        span: Span,
    ) -> Option<Value> {
        if !values.iter().all(|v| v.kind.is_enumeration()) {
            self.error(
                codes::TYPE_MISMATCH,
                span,
                "a comparison by size needs a variable of an enumeration on both sides",
                "compare two variables of enumerations, which are ordered by the positions of their values, or list the values: `x in {a, b}`",
            );
            return None;
        }
        self.note(
            codes::NOTATION,
            span,
            "values of enumerations are compared by their positions: the first is the smallest",
            "compare numbers, or list the values: `x in {a, b}`",
        );
        let mut values = values.into_iter();
        Some(Value::binary(op, values.next()?, values.next()?))
    }
}
