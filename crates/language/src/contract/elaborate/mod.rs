//! Elaboration: converts expressions of the syntax tree to typed terms.
//!
//! A label has no type of its own: `turn` in `command = turn` is looked up in the type of
//! `command`. A name is looked up in this order: quantified names, parameters and constants,
//! `define`s, counters, variables, labels of the expected type, and labels of other enumerations in
//! scope if only one of them has the name.

mod domains;
mod expansion;
mod findings;
mod index;
mod lookup;
mod names;
mod operators;
mod past;
mod predicates;
mod quantifiers;
mod records;
mod suspects;
mod units;
mod variables;

pub(super) use expansion::MAX_EXPANSION;
pub(super) use findings::Findings;
pub(super) use linewright_core::diagnostics::nearest;
pub(super) use names::{FileNames, Names};
pub(super) use units::{fitted, fitted_value};
pub(super) use variables::VariableTable;

use super::table::Tables;
use super::value::{Dimension, Term, Type, Value};
use expansion::{Expansion, MAX_FORMULA_DEPTH};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::{Monitors, Origin};
use linewright_core::gr1::{BinaryOp, Expr, Time, UnaryOp};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind};
use linewright_syntax::format;
use records::member;
use units::aligned;

/// How expressions are interpreted.
#[derive(Default)]
pub(super) struct Dialect {
    /// Whether real numbers are allowed. If so, `/` is real division.
    pub real: bool,
    /// Whether `next` is allowed.
    pub next: bool,
    /// The enclosing operator that looks at other steps, such as `once`, if there is one. `next` is
    /// not allowed within it.
    looking_back: Option<String>,
}

/// Monitors, which record what happened in earlier steps.
#[derive(Default)]
pub(super) struct Memory {
    /// Monitors of the contract; `None` outside of contracts, where past operators are not allowed.
    pub monitors: Option<Monitors>,
    /// The formula that is being elaborated. Each monitor records the formulas that need it.
    pub origin: Origin,
}

/// Converts expressions to typed terms, and reports errors.
#[derive(Default)]
pub(super) struct Elaborator<'a> {
    /// Names in scope.
    pub names: Names<'a>,
    /// Domains and units of variables.
    pub variables: VariableTable,
    /// How expressions are interpreted.
    pub dialect: Dialect,
    /// Monitors, which record what happened in earlier steps.
    pub memory: Memory,
    /// Findings so far.
    pub findings: Findings,
    /// Cost of expanding defines, quantifiers and arrays so far.
    pub expansion: Expansion,
    /// The tables that statements name.
    pub tables: Option<&'a Tables>,
}

impl<'a> Elaborator<'a> {
    /// Creates an elaborator with these names in scope.
    pub fn new(names: Names<'a>) -> Self {
        Self {
            names,
            ..Self::default()
        }
    }

    /// Converts a term to a formula over whole numbers. Reports a term that contains real numbers
    /// or is too deep.
    pub fn formula(&mut self, term: &Term, span: Span) -> Option<Expr> {
        if term.depth() > MAX_FORMULA_DEPTH {
            self.expansion.too_large(span, &mut self.findings);
            return None;
        }
        let expr = term.to_expr();
        if expr.is_none() {
            self.findings.error_with(
                codes::TYPE_MISMATCH,
                span,
                "a formula contains only whole numbers, and this is a real quantity of the plant",
                "declare in the machine what the numbers mean in the plant, with `abstract`, `time` or `write`",
            );
        }
        expr
    }

    /// Elaborates a truth value. `time` is the step of the variables that are not under `next`.
    pub fn boolean(&mut self, e: &'a ast::Expr, time: Time) -> Option<Term> {
        match self.value(e, Some(&Type::Bool), time)? {
            Value::Scalar(term, Type::Bool) => Some(term),
            other => {
                self.findings.mismatch(e.span, "a truth value", &other.ty());
                None
            }
        }
    }

    /// Elaborates a scalar, and converts it to the expected type.
    pub fn scalar(&mut self, e: &'a ast::Expr, expected: &Type) -> Option<Term> {
        match self.value(e, Some(expected), Time::Now)? {
            Value::Scalar(term, found) => {
                fitted(e.span, (term, found), expected, &mut self.findings)
            }
            value => {
                self.findings
                    .mismatch(e.span, &expected.describe(), &value.ty());
                None
            }
        }
    }

    /// Evaluates a constant whole number.
    pub fn constant_int(&mut self, e: &'a ast::Expr) -> Option<i64> {
        match self.value(e, Some(&Type::Int), Time::Now) {
            Some(Value::Scalar(Term::Int(i), Type::Int)) => Some(i),
            Some(Value::Scalar(Term::Real(x), Type::Number(_))) if x.fract() == 0.0 => {
                Some(x as i64)
            }
            Some(Value::Scalar(_, Type::Int)) => {
                self.findings.error_with(
                    codes::NOT_CONSTANT,
                    e.span,
                    "this has to be known before the machine runs",
                    "use numbers, constants and parameters only",
                );
                None
            }
            Some(Value::Scalar(Term::Real(x), Type::Number(Dimension::None))) => {
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    e.span,
                    format!("{x} is not a whole number"),
                    format!("write a whole number, such as `{}`", x.round()),
                );
                None
            }
            Some(other) => {
                self.findings
                    .mismatch(e.span, "a whole number", &other.ty());
                None
            }
            None => None,
        }
    }

    /// Evaluates a constant number in base units of `dimension`. Rejects a bare number other than 0
    /// where a unit is expected.
    pub fn constant_quantity(&mut self, e: &'a ast::Expr, dimension: Dimension) -> Option<f64> {
        let term = self.quantity(e, dimension)?;
        let value = constant_real(&term);
        if value.is_none() {
            self.findings.error_with(
                codes::NOT_CONSTANT,
                e.span,
                "this has to be known before the line runs",
                "use numbers, constants and parameters only",
            );
        }
        value
    }

    /// Elaborates a real expression in base units of `dimension`. Rejects a bare number other than
    /// 0 where a unit is expected.
    pub fn quantity(&mut self, e: &'a ast::Expr, dimension: Dimension) -> Option<Term> {
        let (term, ty) = self.any_scalar(e, None, Time::Now)?;
        match ty {
            Type::Number(d) if d == dimension => Some(term),
            Type::Int | Type::Number(Dimension::Share) if dimension == Dimension::None => {
                Some(term)
            }
            Type::Int | Type::Number(Dimension::None) if is_zero(&term) => Some(term),
            Type::Int | Type::Number(Dimension::None) => {
                self.findings.error_with(
                    codes::TYPE_MISMATCH,
                    e.span,
                    "a unit is missing",
                    format!("write {}", dimension.describe()),
                );
                None
            }
            other => {
                self.findings.mismatch(e.span, dimension.describe(), &other);
                None
            }
        }
    }

    /// Elaborates a value of any shape. `expected` is a hint for labels and literals; the type of
    /// the result can differ.
    pub fn value(
        &mut self,
        e: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        self.expansion.spend(e.span, 1, &mut self.findings)?;
        self.expansion.enter(e.span, &mut self.findings)?;
        let value = self.value_of(e, expected, time);
        self.expansion.leave();
        value
    }

    fn value_of(&mut self, e: &'a ast::Expr, expected: Option<&Type>, time: Time) -> Option<Value> {
        match &e.kind {
            ExprKind::Unknown => {
                self.findings.tainted = true;
                None
            }
            ExprKind::Bool(b) => Some(Value::Scalar(Term::truth(*b), Type::Bool)),
            ExprKind::Int(i) => Some(Value::Scalar(Term::Int(*i), Type::Int)),
            ExprKind::Quantity(number, name) => self.literal(e.span, *number, name),
            ExprKind::Path(names) => self.path(e.span, names, expected, time),
            ExprKind::Index(base, index) => self.index(e.span, base, index, expected, time),
            ExprKind::Next(inner) => {
                if let Some(word) = &self.dialect.looking_back {
                    let message = format!("`next` is nested in `{word}`");
                    self.findings.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        message,
                        "the operand of an operator over other steps is a condition on one step: hold the value in an internal variable, or remove `next`",
                    );
                    return None;
                }
                if !self.dialect.next {
                    self.findings.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        "`next` is not allowed here",
                        "use `next` only under `always` in assumptions and guarantees",
                    );
                    return None;
                }
                if time == Time::Next {
                    self.findings.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        "`next` is nested in `next`",
                        "GR(1) looks one step ahead; hold the value in an internal variable to look further",
                    );
                    return None;
                }
                self.value(inner, expected, Time::Next)
            }
            ExprKind::Always(_)
            | ExprKind::Eventually(_)
            | ExprKind::Until(..)
            | ExprKind::Pattern(_) => {
                self.reject_temporal(e);
                None
            }
            ExprKind::Not(inner) => {
                let a = self.boolean(inner, time)?;
                Some(Value::Scalar(Term::unary(UnaryOp::Not, a), Type::Bool))
            }
            ExprKind::Neg(inner) => {
                let (a, ty) = self.any_scalar(inner, expected, time)?;
                if !ty.is_numeric() {
                    self.findings.mismatch(inner.span, "a number", &ty);
                    return None;
                }
                let term = match a {
                    Term::Real(x) => Term::Real(-x),
                    a => Term::unary(UnaryOp::Neg, a),
                };
                Some(Value::Scalar(term, ty))
            }
            ExprKind::Binary(op, a, b) => self.operation(e.span, *op, a, b, time),
            ExprKind::If(c, a, b) => self.conditional(c, a, b, expected, time),
            ExprKind::Quantifier(kind, name, domain, body) => {
                self.quantifier(e.span, (*kind, expected), name, domain, body, time)
            }
            ExprKind::Call(name, arguments) if self.names.defines.contains_key(&name.text) => {
                self.predicate(e.span, name, arguments, expected, time)
            }
            ExprKind::Call(name, arguments) => self.call(e.span, name, arguments, time),
            ExprKind::Field(base, name) => {
                let value = self.value(base, None, time)?;
                member(base.span, value, name, &mut self.findings)
            }
            ExprKind::Record(members) => self.record(e.span, members, expected, time),
            ExprKind::List(members) => {
                let inner = match expected {
                    Some(Type::Array(of, _)) => Some((**of).clone()),
                    _ => None,
                };
                let mut values = Vec::with_capacity(members.len());
                for m in members {
                    values.push(self.value(m, inner.as_ref(), time)?);
                }
                let first = values.first().map(Value::ty);
                for (v, m) in values.iter().zip(members) {
                    if Some(v.ty()) != first
                        && !(v.ty().is_numeric() && first.as_ref().is_some_and(Type::is_numeric))
                    {
                        let found = v.ty();
                        let expected = first.map(|t| t.describe()).unwrap_or_default();
                        self.findings.mismatch(m.span, &expected, &found);
                        return None;
                    }
                }
                Some(Value::Array(values))
            }
            ExprKind::Member(of, members) => {
                let (x, ty) = self.any_scalar(of, None, time)?;
                self.expansion.spend(
                    e.span,
                    x.size().saturating_mul(members.len()),
                    &mut self.findings,
                )?;
                let mut terms = Vec::new();
                for m in members {
                    let (m_term, m_ty) = self.any_scalar(m, Some(&ty), time)?;
                    if !comparable(&ty, &m_ty) {
                        self.findings.mismatch(m.span, &ty.describe(), &m_ty);
                        return None;
                    }
                    let (x, m_term) = if ty.is_numeric() {
                        let (x, m, _) = aligned(
                            m.span,
                            (x.clone(), ty.clone()),
                            (m_term, m_ty),
                            &mut self.findings,
                        )?;
                        (x, m)
                    } else {
                        (x.clone(), m_term)
                    };
                    let equal = Term::binary(BinaryOp::Eq, x, m_term);
                    self.compared(m.span, "=", &equal, of, m);
                    terms.push(equal);
                }
                Some(Value::Scalar(
                    Term::fold(BinaryOp::Or, terms, 0),
                    Type::Bool,
                ))
            }
            ExprKind::Past(op, body, bound) => self.past(e.span, *op, body, bound.as_deref(), time),
            ExprKind::Since(p, q) => self.since(e.span, p, q, time),
            ExprKind::Within(x, low, high) => {
                let x = self.number(x, time)?;
                let low = self.number(low, time)?;
                let high = self.number(high, time)?;
                self.expansion
                    .spend(e.span, x.0.size(), &mut self.findings)?;
                let (low, above, _) = aligned(e.span, low, x.clone(), &mut self.findings)?;
                let (below, high, _) = aligned(e.span, x, high, &mut self.findings)?;
                Some(Value::Scalar(
                    Term::binary(
                        BinaryOp::And,
                        Term::binary(BinaryOp::Le, low, above),
                        Term::binary(BinaryOp::Le, below, high),
                    ),
                    Type::Bool,
                ))
            }
        }
    }

    /// Reports a temporal formula where a condition on one step is expected.
    fn reject_temporal(&mut self, e: &ast::Expr) {
        let word = match &e.kind {
            ExprKind::Always(_) => "`always`",
            ExprKind::Eventually(_) => "`eventually`",
            ExprKind::Until(op, ..) => &format!("`{}`", op.word()),
            _ => "this pattern",
        };
        let (message, help) = match self.expansion.defining.last() {
            Some(name) => (
                format!("{word} appears in the definition `{name}`, which has to be a condition on one step"),
                format!(
                    "write `{}` in the assumption or guarantee itself",
                    format::format_expression(e)
                ),
            ),
            None => (
                format!("{word} appears within a larger formula; this is outside GR(1)"),
                "write it as a separate assumption or guarantee, or look back with `once`, `since` or `previous`".to_owned(),
            ),
        };
        self.findings
            .error_with(codes::NOT_GR1, e.span, message, help);
    }

    /// Elaborates a scalar of any type.
    pub fn any_scalar(
        &mut self,
        e: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<(Term, Type)> {
        match self.value(e, expected, time)? {
            Value::Scalar(term, ty) => Some((term, ty)),
            other => {
                let help = if matches!(other, Value::Record(_)) {
                    "select one member, such as `target.x`"
                } else {
                    "select one element with `[i]`, or quantify with `forall i in 0..n-1`"
                };
                let message = format!("this is {}", other.ty().describe());
                self.findings
                    .error_with(codes::TYPE_MISMATCH, e.span, message, help);
                None
            }
        }
    }

    /// Elaborates a scalar number of any numeric type.
    pub(super) fn number(&mut self, e: &'a ast::Expr, time: Time) -> Option<(Term, Type)> {
        let (term, ty) = self.any_scalar(e, Some(&Type::Int), time)?;
        if ty.is_numeric() {
            Some((term, ty))
        } else {
            self.findings.mismatch(e.span, "a number", &ty);
            None
        }
    }
}

/// Returns the value of a constant term; `None` if it is not constant.
pub(in crate::contract) fn constant_real(term: &Term) -> Option<f64> {
    match term {
        Term::Int(i) => Some(*i as f64),
        Term::Real(x) => Some(*x),
        Term::Unary(UnaryOp::Neg, a) => constant_real(a).map(|x| -x),
        _ => None,
    }
}

fn is_zero(term: &Term) -> bool {
    constant_real(term) == Some(0.0)
}

fn comparable(a: &Type, b: &Type) -> bool {
    a == b || a.is_numeric() && b.is_numeric()
}
