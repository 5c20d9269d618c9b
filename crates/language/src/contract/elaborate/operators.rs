//! Elaboration of operators: logic, equality, arithmetic and choice, with checks of dimensions and
//! ranges.

use super::findings::Findings;
use super::units::{aligned, not_constant, same_dimension};
use super::{Elaborator, comparable, constant_real};
use crate::contract::value::{Dimension, Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::interval::{Interval, IntervalError, interval};
use linewright_core::gr1::{BinaryOp, Time, UnaryOp};
use linewright_core::source::Span;
use linewright_syntax::ast;

impl<'a> Elaborator<'a> {
    pub(super) fn operation(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        time: Time,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        let boolean = |op, a, b| Some(Value::Scalar(Term::binary(op, a, b), Type::Bool));
        match op {
            A::And | A::Or | A::Implies | A::Iff | A::Xor => {
                // Both sides are elaborated even if one has an error, to report all findings at
                // once.
                let (x, y) = (self.boolean(a, time), self.boolean(b, time));
                let (x, y) = (x?, y?);
                if op == A::Iff {
                    self.equated(span, op.sign(), (a, &x), (b, &y), time);
                }
                let op = match op {
                    A::And => BinaryOp::And,
                    A::Or => BinaryOp::Or,
                    A::Implies => BinaryOp::Implies,
                    A::Iff => BinaryOp::Eq,
                    A::Xor => BinaryOp::Ne,
                    other => unreachable!("{other:?} is not among the operators above"),
                };
                boolean(op, x, y)
            }
            A::Eq | A::Ne => {
                let (left, right) = self.two_sides(a, b, time)?;
                let equal = self.equal(span, left, right)?;
                if let Term::Binary(BinaryOp::Eq, x, y) = &equal {
                    let sign = op.sign();
                    if op == A::Eq {
                        self.equated(span, sign, (a, x), (b, y), time);
                    }
                    let term = Term::Binary(compared(op), x.clone(), y.clone());
                    self.compared(span, sign, &term, a, b);
                }
                let term = if op == A::Eq {
                    equal
                } else {
                    match equal {
                        Term::Binary(BinaryOp::Eq, a, b) => Term::Binary(BinaryOp::Ne, a, b),
                        other => Term::unary(UnaryOp::Not, other),
                    }
                };
                Some(Value::Scalar(term, Type::Bool))
            }
            A::Lt | A::Le | A::Gt | A::Ge => {
                let (x, y) = (self.number(a, time), self.number(b, time));
                let (x, y, _) = aligned(span, x?, y?, &mut self.findings)?;
                let term = Term::binary(compared(op), x, y);
                self.compared(span, op.sign(), &term, a, b);
                Some(Value::Scalar(term, Type::Bool))
            }
            A::Add | A::Sub | A::Mul | A::Div | A::Mod => {
                let (a, b_value) = (self.number(a, time), self.number(b, time));
                self.arithmetic(span, op, a?, b_value?, b.span)
            }
        }
    }

    /// Elaborates both sides of an equality. A label is looked up in the type of the opposite side.
    pub(super) fn two_sides(
        &mut self,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        time: Time,
    ) -> Option<(Value, Value)> {
        if self.names.is_label(a) && !self.names.is_label(b) {
            let right = self.value(b, None, time)?;
            let left = self.value(a, Some(&right.ty()), time)?;
            return Some((left, right));
        }
        let left = self.value(a, None, time);
        let ty = left.as_ref().map(Value::ty);
        let right = self.value(b, ty.as_ref(), time);
        Some((left?, right?))
    }

    /// Builds the equality of two values of any shape.
    pub(super) fn equal(&mut self, span: Span, a: Value, b: Value) -> Option<Term> {
        match (a, b) {
            (Value::Scalar(a, at), Value::Scalar(b, bt)) => {
                if !comparable(&at, &bt) {
                    unequal(span, &at, &bt, &mut self.findings);
                    return None;
                }
                let (a, b) = if at.is_numeric() {
                    let (a, b, _) = aligned(span, (a, at), (b, bt), &mut self.findings)?;
                    (a, b)
                } else {
                    (a, b)
                };
                Some(Term::binary(BinaryOp::Eq, a, b))
            }
            (Value::Record(a), Value::Record(mut b))
                if a.len() == b.len() && a.iter().all(|(x, _)| b.iter().any(|(y, _)| x == y)) =>
            {
                let place = |name: &str| a.iter().position(|(x, _)| x == name);
                b.sort_by_key(|(name, _)| place(name));
                let mut terms = Vec::with_capacity(a.len());
                for ((_, a), (_, b)) in a.into_iter().zip(b) {
                    terms.push(self.equal(span, a, b)?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                let sizes = a.iter().chain(&b).map(Value::size);
                self.expansion.spend(
                    span,
                    sizes.fold(0, usize::saturating_add),
                    &mut self.findings,
                )?;
                let mut terms = Vec::with_capacity(a.len());
                for (a, b) in a.into_iter().zip(b) {
                    terms.push(self.equal(span, a, b)?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (Value::Array(a), b @ Value::Scalar(..)) => {
                self.expansion
                    .spend(span, b.size().saturating_mul(a.len()), &mut self.findings)?;
                // An array equals a scalar if every element does: `h = 0`.
                let mut terms = Vec::with_capacity(a.len());
                for a in a {
                    terms.push(self.equal(span, a, b.clone())?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (a, b) => {
                unequal(span, &a.ty(), &b.ty(), &mut self.findings);
                None
            }
        }
    }

    /// Builds an arithmetic operation; reports operands whose dimensions do not fit, divisors that
    /// can be 0, and results that are too large.
    pub(super) fn arithmetic(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
        b_span: Span,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        if !self.dialect.real
            && (at.dimension() != Dimension::None || bt.dimension() != Dimension::None)
        {
            return self.measured_arithmetic(span, op, (a, at), (b, bt), b_span);
        }
        let of = |t: &Type| match t {
            Type::Number(d) => *d,
            _ => Dimension::None,
        };
        let dimension = match op {
            A::Add | A::Sub | A::Mod => {
                same_dimension(span, (&a, &at), (&b, &bt), &mut self.findings)?
            }
            A::Mul | A::Div => {
                let (x, y) = (of(&at), of(&bt));
                let known = if op == A::Mul {
                    x.times(y)
                } else {
                    x.divided_by(y)
                };
                let Some(dimension) = known else {
                    let word = if op == A::Mul {
                        "multiplied"
                    } else {
                        "divided"
                    };
                    self.findings.error_with(
                        codes::TYPE_MISMATCH,
                        span,
                        format!("{} cannot be {word} by {}", x.describe(), y.describe()),
                        "the language has no unit for the result; to get a bare number, divide by `1 s`, `1 m` or the like",
                    );
                    return None;
                };
                dimension
            }
            _ => Dimension::None,
        };
        let int = at == Type::Int && bt == Type::Int;
        let op = match op {
            A::Add => BinaryOp::Add,
            A::Sub => BinaryOp::Sub,
            A::Mul => BinaryOp::Mul,
            A::Div => BinaryOp::Div,
            _ => BinaryOp::Mod,
        };
        if self.dialect.real {
            let exact = int && op != BinaryOp::Div;
            let ty = if exact {
                Type::Int
            } else {
                Type::Number(dimension)
            };
            let term = match (constant_real(&a), constant_real(&b)) {
                (Some(x), Some(y)) if !exact => Term::Real(match op {
                    BinaryOp::Add => x + y,
                    BinaryOp::Sub => x - y,
                    BinaryOp::Mul => x * y,
                    BinaryOp::Div => x / y,
                    _ => x - y * (x / y).floor(),
                }),
                _ if exact => Term::binary(op, a, b),
                _ => Term::Binary(op, Box::new(a), Box::new(b)),
            };
            return Some(Value::Scalar(term, ty));
        }
        if matches!(op, BinaryOp::Div | BinaryOp::Mod) && self.range_of(&b, b_span)?.contains(0) {
            self.findings.error_with(
                codes::DIVISION,
                b_span,
                "this divisor can be 0",
                "divide by a constant, or by an expression that is never 0, such as `max(x, 1)`",
            );
            return None;
        }
        let term = Term::binary(op, a, b);
        self.range_of(&term, span)?;
        Some(Value::Scalar(term, Type::Int))
    }

    /// Builds an arithmetic operation on whole numbers with units.
    fn measured_arithmetic(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
        b_span: Span,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        let is_measured = |t: &Type| matches!(t, Type::Measured(_));
        if constant_real(&a).is_some()
            && constant_real(&b).is_some()
            && !is_measured(&at)
            && !is_measured(&bt)
        {
            // Both are constant quantities that have not been converted to a unit yet.
            let real = std::mem::replace(&mut self.dialect.real, true);
            let value = self.arithmetic(span, op, (a, at), (b, bt), b_span);
            self.dialect.real = real;
            return value;
        }
        let (op, a, b, ty) = match op {
            A::Add | A::Sub | A::Mod | A::Div if at.dimension() == bt.dimension() => {
                let (a, b, ty) = aligned(span, (a, at), (b, bt), &mut self.findings)?;
                match op {
                    A::Add => (BinaryOp::Add, a, b, ty),
                    A::Sub => (BinaryOp::Sub, a, b, ty),
                    A::Mod => (BinaryOp::Mod, a, b, ty),
                    _ => (BinaryOp::Div, a, b, Type::Int),
                }
            }
            A::Add | A::Sub | A::Mod => {
                let (a, b, ty) = aligned(span, (a, at), (b, bt), &mut self.findings)?;
                let op = match op {
                    A::Add => BinaryOp::Add,
                    A::Sub => BinaryOp::Sub,
                    _ => BinaryOp::Mod,
                };
                (op, a, b, ty)
            }
            A::Mul if bt == Type::Int => (BinaryOp::Mul, a, b, at),
            A::Mul if at == Type::Int => (BinaryOp::Mul, a, b, bt),
            A::Div if bt == Type::Int => (BinaryOp::Div, a, b, at),
            _ => {
                let word = if op == A::Mul {
                    "multiplied"
                } else {
                    "divided"
                };
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("{} cannot be {word} by {}", at.describe(), bt.describe()),
                    "the language has no unit for the result; to get a bare number, divide by `1 mm`, `1 deg` or the like",
                );
                return None;
            }
        };
        if matches!(op, BinaryOp::Div | BinaryOp::Mod) && self.range_of(&b, b_span)?.contains(0) {
            self.findings.error_with(
                codes::DIVISION,
                b_span,
                "this divisor can be 0",
                "divide by a constant, or by an expression that is never 0, such as `max(x, 1 mm)`",
            );
            return None;
        }
        let term = Term::binary(op, a, b);
        self.range_of(&term, span)?;
        Some(Value::Scalar(term, ty))
    }

    /// Returns the range of an integer term; reports a term that can exceed the limits of
    /// arithmetic or divide by 0. In a plant expression the term has to be constant.
    pub fn range_of(&mut self, term: &Term, span: Span) -> Option<Interval> {
        if self.dialect.real {
            // Plant expressions have no bounds; their ranges are needed only for indices.
            return if let Term::Int(i) = term {
                Some(Interval { low: *i, high: *i })
            } else {
                self.findings.error_with(
                    codes::NOT_CONSTANT,
                    span,
                    "the index has to be known before the line runs",
                    "use numbers, constants, parameters and quantified names",
                );
                None
            };
        }
        self.expansion
            .spend(span, term.size(), &mut self.findings)?;
        let Some(expr) = term.to_expr() else {
            not_constant(span, &mut self.findings);
            return None;
        };
        let result = interval(&expr, &|v| self.variables.interval(v));
        match result {
            Ok(range) => Some(range),
            Err(IntervalError::TooLarge) => {
                self.findings.error_with(
                    codes::NUMBER_RANGE,
                    span,
                    "this number can exceed 2^62",
                    "use smaller domains",
                );
                None
            }
            Err(IntervalError::DivisorZero) => {
                self.findings.error_with(
                    codes::DIVISION,
                    span,
                    "a divisor can be 0",
                    "divide by a constant, or by an expression that is never 0, such as `max(x, 1)`",
                );
                None
            }
        }
    }

    pub(super) fn conditional(
        &mut self,
        c: &'a ast::Expr,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let condition = self.boolean(c, time);
        let (left, right) = if expected.is_some() {
            (self.value(a, expected, time), self.value(b, expected, time))
        } else {
            let (l, r) = self.two_sides(a, b, time)?;
            (Some(l), Some(r))
        };
        let (condition, left, right) = (condition?, left?, right?);
        self.choose(&condition, (left, a.span), (right, b.span))
    }
}

/// Converts a comparison operator of the syntax tree to an operator of terms.
fn compared(op: ast::BinaryOp) -> BinaryOp {
    match op {
        ast::BinaryOp::Eq => BinaryOp::Eq,
        ast::BinaryOp::Ne => BinaryOp::Ne,
        ast::BinaryOp::Lt => BinaryOp::Lt,
        ast::BinaryOp::Le => BinaryOp::Le,
        ast::BinaryOp::Gt => BinaryOp::Gt,
        _ => BinaryOp::Ge,
    }
}

/// Reports an equality of two types that cannot be compared.
fn unequal(span: Span, a: &Type, b: &Type, findings: &mut Findings) {
    let help = match (a, b) {
        (Type::Array(..), Type::Array(..)) => {
            "compare arrays of the same length, or single elements with `[i]`"
        }
        (Type::Record(_), _) | (_, Type::Record(_)) => {
            "compare records with the same members, or single members"
        }
        (Type::Array(..), _) | (_, Type::Array(..)) => {
            "select one element with `[i]`, or quantify with `forall i in 0..n-1`"
        }
        (Type::Bool, _) | (_, Type::Bool) => {
            "write a truth value by itself or after `not`; put parentheses around a comparison that is compared again"
        }
        _ => {
            "use the same type on both sides; if another declaration hides a label, write `Type.label`"
        }
    };
    findings.error_with(
        codes::TYPE_MISMATCH,
        span,
        format!("{} cannot equal {}", a.describe(), b.describe()),
        help,
    );
}
