//! Operators: logic, equality, arithmetic, choice; dimensions and ranges.

use super::{Elaborator, comparable, constant_real, is_zero};
use crate::contract::value::{Dimension, Term, Type, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::interval::{Interval, Problem, interval};
use linewright_core::gr1::{BinaryOp, Time, UnaryOp};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind};

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
                // Both sides are looked at even when one is wrong: all findings at once.
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
                    _ => BinaryOp::Ne,
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
                let (x, y, _) = self.aligned(span, x?, y?)?;
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

    /// Both sides of an equality; a bare label is looked up in the type of the other side.
    pub(super) fn two_sides(
        &mut self,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        time: Time,
    ) -> Option<(Value, Value)> {
        if self.is_label(a) && !self.is_label(b) {
            let right = self.value(b, None, time)?;
            let left = self.value(a, Some(&right.ty()), time)?;
            return Some((left, right));
        }
        let left = self.value(a, None, time);
        let ty = left.as_ref().map(Value::ty);
        let right = self.value(b, ty.as_ref(), time);
        Some((left?, right?))
    }

    pub(super) fn is_label(&self, e: &ast::Expr) -> bool {
        match &e.kind {
            ExprKind::Path(names) => {
                let [name] = names.as_slice() else {
                    return false;
                };
                !self.variables.contains_key(&name.text)
                    && !self.constants.contains_key(&name.text)
                    && !self.defines.contains_key(&name.text)
                    && !self.counters.contains_key(&name.text)
            }
            ExprKind::If(_, a, b) => self.is_label(a) && self.is_label(b),
            ExprKind::List(members) => members.iter().all(|m| self.is_label(m)),
            ExprKind::Index(base, _) => self.is_label(base),
            _ => false,
        }
    }

    pub(super) fn equal(&mut self, span: Span, a: Value, b: Value) -> Option<Term> {
        match (a, b) {
            (Value::Scalar(a, at), Value::Scalar(b, bt)) => {
                if !comparable(&at, &bt) {
                    self.unequal(span, &at, &bt);
                    return None;
                }
                let (a, b) = if at.is_numeric() {
                    let (a, b, _) = self.aligned(span, (a, at), (b, bt))?;
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
                self.spend(span, sizes.fold(0, usize::saturating_add))?;
                let mut terms = Vec::with_capacity(a.len());
                for (a, b) in a.into_iter().zip(b) {
                    terms.push(self.equal(span, a, b)?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (Value::Array(a), b @ Value::Scalar(..)) => {
                self.spend(span, b.size().saturating_mul(a.len()))?;
                // An array equals a scalar when every element does: `h = 0`.
                let mut terms = Vec::with_capacity(a.len());
                for a in a {
                    terms.push(self.equal(span, a, b.clone())?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (a, b) => {
                self.unequal(span, &a.ty(), &b.ty());
                None
            }
        }
    }

    fn unequal(&mut self, span: Span, a: &Type, b: &Type) {
        let help = match (a, b) {
            (Type::Array(..), Type::Array(..)) => {
                "compare arrays of one length, or single elements with `[i]`"
            }
            (Type::Record(_), _) | (_, Type::Record(_)) => {
                "compare records with the same members, or single members"
            }
            (Type::Array(..), _) | (_, Type::Array(..)) => {
                "name one element with `[i]`, or quantify over `forall i in 0..n-1`"
            }
            (Type::Bool, _) | (_, Type::Bool) => {
                "a truth value stands alone or after `not`; put brackets around a comparison that is compared again"
            }
            _ => {
                "both sides must be of one type; does another declaration hide the label that was meant? Then write `Type.label`"
            }
        };
        self.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("{} cannot equal {}", a.describe(), b.describe()),
            help,
        );
    }

    /// Adding and comparing needs one dimension; 0 fits every one.
    pub(super) fn same_dimension(
        &mut self,
        span: Span,
        at: &Type,
        a: &Term,
        bt: &Type,
        b: &Term,
    ) -> Option<Dimension> {
        let of = |t: &Type| match t {
            Type::Number(d) => *d,
            _ => Dimension::None,
        };
        let (ad, bd) = (of(at), of(bt));
        if ad == bd || is_zero(b) {
            return Some(ad);
        }
        if is_zero(a) {
            return Some(bd);
        }
        self.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("{} does not go together with {}", ad.word(), bd.word()),
            "give both sides the same kind of unit",
        );
        None
    }

    pub(super) fn arithmetic(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
        b_span: Span,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        if !self.real && (at.dimension() != Dimension::None || bt.dimension() != Dimension::None) {
            return self.measured_arithmetic(span, op, (a, at), (b, bt), b_span);
        }
        let of = |t: &Type| match t {
            Type::Number(d) => *d,
            _ => Dimension::None,
        };
        let dimension = match op {
            A::Add | A::Sub | A::Mod => self.same_dimension(span, &at, &a, &bt, &b)?,
            A::Mul | A::Div => {
                let (x, y) = (of(&at), of(&bt));
                let known = if op == A::Mul { x.times(y) } else { x.over(y) };
                let Some(dimension) = known else {
                    let word = if op == A::Mul {
                        "multiplied"
                    } else {
                        "divided"
                    };
                    self.error_with(
                        codes::TYPE_MISMATCH,
                        span,
                        format!("{} cannot be {word} by {}", x.word(), y.word()),
                        "there is no unit for the result; divide by `1 s`, `1 m` or the like where a bare number is meant",
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
        if self.real {
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
            self.error_with(
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

    /// Whole numbers with units.
    fn measured_arithmetic(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
        b_span: Span,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        let counted = |t: &Type| matches!(t, Type::Measured(_));
        if constant_real(&a).is_some()
            && constant_real(&b).is_some()
            && !counted(&at)
            && !counted(&bt)
        {
            // Quantities of the file, not yet counted in a unit.
            let real = std::mem::replace(&mut self.real, true);
            let value = self.arithmetic(span, op, (a, at), (b, bt), b_span);
            self.real = real;
            return value;
        }
        let (op, a, b, ty) = match op {
            A::Add | A::Sub | A::Mod | A::Div if at.dimension() == bt.dimension() => {
                let (a, b, ty) = self.aligned(span, (a, at), (b, bt))?;
                match op {
                    A::Add => (BinaryOp::Add, a, b, ty),
                    A::Sub => (BinaryOp::Sub, a, b, ty),
                    A::Mod => (BinaryOp::Mod, a, b, ty),
                    _ => (BinaryOp::Div, a, b, Type::Int),
                }
            }
            A::Add | A::Sub | A::Mod => {
                let (a, b, ty) = self.aligned(span, (a, at), (b, bt))?;
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
                self.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("{} cannot be {word} by {}", at.describe(), bt.describe()),
                    "there is no unit for the result; divide by `1 mm`, `1 deg` or the like where a bare number is meant",
                );
                return None;
            }
        };
        if matches!(op, BinaryOp::Div | BinaryOp::Mod) && self.range_of(&b, b_span)?.contains(0) {
            self.error_with(
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

    /// The interval of a whole number; reports what leaves the arithmetic's limits.
    pub fn range_of(&mut self, term: &Term, span: Span) -> Option<Interval> {
        if self.real {
            // Plant expressions are not bounded; only constant indices are asked for here.
            return if let Term::Int(i) = term {
                Some(Interval { low: *i, high: *i })
            } else {
                self.error_with(
                    codes::NOT_CONSTANT,
                    span,
                    "the index has to be known before the line runs",
                    "use numbers, constants, parameters and quantified names",
                );
                None
            };
        }
        self.spend(span, term.size())?;
        let expr = term.to_expr()?;
        let result = interval(&expr, &|v| {
            self.domains[v.index()]
                .as_ref()
                .map_or(Interval::BOOL, Interval::of)
        });
        match result {
            Ok(range) => Some(range),
            Err(Problem::TooLarge) => {
                self.error_with(
                    codes::NUMBER_RANGE,
                    span,
                    "this can grow beyond 2^62",
                    "use smaller domains",
                );
                None
            }
            Err(Problem::DivisorZero) => {
                self.error_with(
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
