//! From a syntax tree's expressions to typed terms.
//!
//! Labels have no type of their own: `turn` in `command = turn` is looked up in the type of `command`. A name is, in this order:
//! bound by a quantifier, a `define`, a variable, a parameter or constant, a label of the expected type, a label of the one
//! enumeration in sight that has it.

mod domains;
mod names;
mod operators;
mod past;
mod predicates;
mod quantifiers;
mod records;
mod suspects;
mod units;

use super::shape::{Entry, Shape};
use super::units::Unit;
use super::value::{Dimension, Term, Type, Value};
pub(in crate::contract) use linewright_core::diagnostics::nearest;
use linewright_core::diagnostics::{Code, Diagnostic, codes, has_errors};
use linewright_core::gr1::monitors::{Monitors, Origin};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Time, UnaryOp, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, ExprKind};
use linewright_syntax::format;
use std::collections::{BTreeMap, BTreeSet};

/// Quantifiers and arrays expand to at most so many instances.
pub(super) const MAX_EXPANSION: i64 = 4096;
/// A domain has at most so many values.
pub(super) const MAX_DOMAIN: i64 = 1 << 20;

/// Expressions nest so deep at most, defines written out: later stages walk formulas by recursion.
const MAX_NESTED: usize = 400;
/// A formula's tree is at most so deep once arrays are written out.
const MAX_FORMULA_DEPTH: usize = 600;
/// What one contract or machine may cost to write out: nodes that are made, copied or looked at.
const MAX_WORK: usize = 1_000_000;

/// What stands outside of all contracts, for the defines that stand there, too.
#[derive(Debug, Clone, Default)]
pub(super) struct Outside<'a> {
    /// Constants.
    pub constants: BTreeMap<String, Value>,
    /// Defines.
    pub defines: BTreeMap<String, &'a ast::Define>,
}

/// A property's unit, for reading it: its dimension and how many base units it is.
pub(super) type UnitOf = (Dimension, f64);

/// What names mean, and where findings go.
#[expect(
    clippy::struct_excessive_bools,
    reason = "independent settings of one walk"
)]
pub(super) struct Elaborator<'a> {
    /// Variables by name; dotted for a component's.
    pub variables: BTreeMap<String, Entry>,
    /// The domains of variables by id; `None` for real ones.
    pub domains: Vec<Option<Domain>>,
    /// The units of real variables by id.
    pub units: BTreeMap<VarId, UnitOf>,
    /// The units of whole-number variables by id.
    pub measures: BTreeMap<VarId, Unit>,
    /// Constants, parameters and quantified names.
    pub constants: BTreeMap<String, Value>,
    /// Named types in sight.
    pub types: BTreeMap<String, Type>,
    /// What the named types are made of.
    pub shapes: BTreeMap<String, Shape>,
    /// Defines by name.
    pub defines: BTreeMap<String, &'a ast::Define>,
    /// What a define of the file sees: what stands outside of all contracts.
    pub outside: Outside<'a>,
    /// Whether real numbers are understood: `/` is then the division of real numbers.
    pub real: bool,
    /// Whether next values are understood.
    pub next: bool,
    /// What remembers earlier steps, in a contract.
    pub monitors: Option<Monitors>,
    /// The formula that is being resolved, for the monitors that it needs.
    pub origin: Origin,
    /// Counters by name.
    pub counters: BTreeMap<String, &'a ast::Counter>,
    /// The operator over other steps within which `next` has no meaning.
    looking_back: Option<String>,
    /// What was found.
    pub findings: Vec<Diagnostic>,
    /// Names whose declaration was reported: their uses are not, ...
    pub broken: BTreeSet<String>,
    /// ... but nothing that used one can be trusted.
    pub tainted: bool,
    defining: Vec<String>,
    /// Quantified names in sight, innermost last, with what each one hides.
    bound: Vec<(String, Option<Value>)>,
    expansions: i64,
    nested: usize,
    work: usize,
    exhausted: bool,
    /// The expression that all those at hand stand within, where it was asked for.
    root: Option<Span>,
}

impl<'a> Elaborator<'a> {
    pub fn new() -> Self {
        Self {
            variables: BTreeMap::new(),
            domains: Vec::new(),
            units: BTreeMap::new(),
            constants: BTreeMap::new(),
            types: BTreeMap::new(),
            measures: BTreeMap::new(),
            shapes: BTreeMap::new(),
            defines: BTreeMap::new(),
            outside: Outside::default(),
            real: false,
            next: false,
            monitors: None,
            origin: Origin::default(),
            counters: BTreeMap::new(),
            looking_back: None,
            findings: Vec::new(),
            broken: BTreeSet::new(),
            tainted: false,
            defining: Vec::new(),
            bound: Vec::new(),
            expansions: 0,
            nested: 0,
            work: 0,
            exhausted: false,
            root: None,
        }
    }

    /// Whether something is wrong, here or with a name that was used.
    pub fn refused(&self) -> bool {
        self.tainted || has_errors(&self.findings)
    }

    /// Counts work; `None` and one finding where there is too much of it.
    pub fn spend(&mut self, span: Span, amount: usize) -> Option<()> {
        self.work = self.work.saturating_add(amount);
        if self.work > MAX_WORK {
            self.too_large(span);
            return None;
        }
        Some(())
    }

    /// Reports that a formula grows too large, once.
    pub fn too_large(&mut self, span: Span) {
        self.tainted = true;
        if !std::mem::replace(&mut self.exhausted, true) {
            let span = self.root.filter(|_| self.nested > 0).unwrap_or(span);
            self.error_with(
                codes::TOO_LARGE,
                span,
                "this becomes too large once defines, quantifiers and arrays are written out",
                "use smaller ranges and arrays, fewer nested quantifiers, or an internal variable that holds a value for reuse",
            );
        }
    }

    /// A term as a formula of whole numbers; reports what is none.
    pub fn formula(&mut self, term: &Term, span: Span) -> Option<Expr> {
        if term.depth() > MAX_FORMULA_DEPTH {
            self.too_large(span);
            return None;
        }
        let expr = term.to_expr();
        if expr.is_none() {
            self.error_with(
                codes::TYPE_MISMATCH,
                span,
                "whole numbers without units are counted here, and this is a quantity of the plant",
                "say in the machine what the numbers mean in the plant: `abstract`, `time`, `write`",
            );
        }
        expr
    }

    /// Does something with a quantified name in sight.
    pub fn with_bound<T>(
        &mut self,
        name: &str,
        value: Value,
        run: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let hidden = self.constants.insert(name.to_owned(), value);
        self.bound.push((name.to_owned(), hidden));
        let result = run(self);
        if let Some((name, hidden)) = self.bound.pop() {
            self.replace_constant(name, hidden);
        }
        result
    }

    fn replace_constant(&mut self, name: String, value: Option<Value>) -> Option<Value> {
        match value {
            Some(value) => self.constants.insert(name, value),
            None => self.constants.remove(&name),
        }
    }

    /// Does something with only what stands outside of all contracts in sight.
    pub(super) fn outside<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        let variables = std::mem::take(&mut self.variables);
        let counters = std::mem::take(&mut self.counters);
        let outside = self.outside.clone();
        let constants = std::mem::replace(&mut self.constants, outside.constants);
        let defines = std::mem::replace(&mut self.defines, outside.defines);
        let result = run(self);
        self.variables = variables;
        self.counters = counters;
        self.constants = constants;
        self.defines = defines;
        result
    }

    /// Does something without the quantified names: a define means the same wherever it is used.
    pub(super) fn unbound<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        let mut bound = std::mem::take(&mut self.bound);
        for (name, value) in bound.iter_mut().rev() {
            *value = self.replace_constant(name.clone(), value.take());
        }
        let result = run(self);
        for (name, value) in &mut bound {
            *value = self.replace_constant(name.clone(), value.take());
        }
        self.bound = bound;
        result
    }

    /// Records an error. There is none without a next step.
    pub fn error_with(
        &mut self,
        code: Code,
        span: Span,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.findings
            .push(Diagnostic::error(code, span, message).with_help(help));
    }

    pub(in crate::contract) fn mismatch(&mut self, span: Span, expected: &str, found: &Type) {
        let help = match found {
            Type::Int | Type::Number(_) | Type::Measured(_) if expected != "a truth value" => {
                "write a value of that kind, or give the declaration the other type"
            }
            Type::Array(..) if expected.starts_with("an array") => {
                "give it as many elements, and of the same kind"
            }
            Type::Bool => "a truth value counts as a number with `if ... then 1 else 0`",
            Type::Enum(_) => "a label is compared with `=`, `!=` or `in {...}`",
            Type::Array(..) => "name one element with `[i]`, or quantify over `forall i in 0..n-1`",
            Type::Record(_) => "name one member, such as `target.x`",
            Type::Int | Type::Number(_) | Type::Measured(_) => {
                "compare the number with something to get a truth value"
            }
        };
        self.error_with(
            codes::TYPE_MISMATCH,
            span,
            format!("expected {expected}, found {}", found.describe()),
            help,
        );
    }

    /// A truth value over current (and, where allowed, next) values.
    pub fn boolean(&mut self, e: &'a ast::Expr, time: Time) -> Option<Term> {
        match self.value(e, Some(&Type::Bool), time)? {
            Value::Scalar(term, Type::Bool) => Some(term),
            other => {
                self.mismatch(e.span, "a truth value", &other.ty());
                None
            }
        }
    }

    /// A scalar of a type.
    pub fn scalar(&mut self, e: &'a ast::Expr, expected: &Type) -> Option<Term> {
        match self.value(e, Some(expected), Time::Now)? {
            Value::Scalar(term, found) => self.fitted(e.span, (term, found), expected),
            value => {
                self.mismatch(e.span, &expected.describe(), &value.ty());
                None
            }
        }
    }

    /// A whole number that is known now.
    pub fn constant_int(&mut self, e: &'a ast::Expr) -> Option<i64> {
        match self.value(e, Some(&Type::Int), Time::Now) {
            Some(Value::Scalar(Term::Int(i), Type::Int)) => Some(i),
            Some(Value::Scalar(Term::Real(x), Type::Number(_))) if x.fract() == 0.0 => {
                Some(x as i64)
            }
            Some(Value::Scalar(_, Type::Int)) => {
                self.error_with(
                    codes::NOT_CONSTANT,
                    e.span,
                    "this has to be known before the machine runs",
                    "use numbers, constants and parameters only",
                );
                None
            }
            Some(other) => {
                self.mismatch(e.span, "a whole number", &other.ty());
                None
            }
            None => None,
        }
    }

    /// A number that is known now, in base units of `dimension`; a bare number is refused where a unit is expected.
    pub fn constant_quantity(&mut self, e: &'a ast::Expr, dimension: Dimension) -> Option<f64> {
        let term = self.quantity(e, dimension)?;
        let value = constant_real(&term);
        if value.is_none() {
            self.error_with(
                codes::NOT_CONSTANT,
                e.span,
                "this has to be known before the line runs",
                "use numbers, constants and parameters only",
            );
        }
        value
    }

    /// A real expression in base units of `dimension`.
    pub fn quantity(&mut self, e: &'a ast::Expr, dimension: Dimension) -> Option<Term> {
        let (term, ty) = self.any_scalar(e, None, Time::Now)?;
        match ty {
            Type::Number(d) if d == dimension => Some(term),
            Type::Int | Type::Number(Dimension::Share) if dimension == Dimension::None => {
                Some(term)
            }
            Type::Int | Type::Number(Dimension::None) if is_zero(&term) => Some(term),
            Type::Int | Type::Number(Dimension::None) => {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    e.span,
                    "a unit is missing",
                    format!("write {}", dimension.word()),
                );
                None
            }
            other => {
                self.mismatch(e.span, dimension.word(), &other);
                None
            }
        }
    }

    /// Any value.
    pub fn value(
        &mut self,
        e: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        self.spend(e.span, 1)?;
        if self.nested == MAX_NESTED {
            self.too_large(e.span);
            return None;
        }
        if self.nested == 0 {
            self.root = Some(e.span);
        }
        self.nested += 1;
        let value = self.value_of(e, expected, time);
        self.nested -= 1;
        value
    }

    fn value_of(&mut self, e: &'a ast::Expr, expected: Option<&Type>, time: Time) -> Option<Value> {
        match &e.kind {
            ExprKind::Unknown => {
                self.tainted = true;
                None
            }
            ExprKind::Bool(b) => Some(Value::Scalar(Term::truth(*b), Type::Bool)),
            ExprKind::Int(i) => Some(Value::Scalar(Term::Int(*i), Type::Int)),
            ExprKind::Quantity(number, name) => self.literal(e.span, *number, name),
            ExprKind::Path(names) => self.path(e.span, names, expected, time),
            ExprKind::Index(base, index) => self.index(e.span, base, index, expected, time),
            ExprKind::Next(inner) => {
                if let Some(word) = &self.looking_back {
                    let message = format!("`next` stands within `{word}`");
                    self.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        message,
                        "operators that look at other steps are about the values of each step; hold the value in an internal variable, or leave `next` out",
                    );
                    return None;
                }
                if !self.next {
                    self.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        "`next` has no meaning here",
                        "next values stand under `always` in assumptions and guarantees only",
                    );
                    return None;
                }
                if time == Time::Next {
                    self.error_with(
                        codes::NEXT_NESTED,
                        e.span,
                        "`next` stands within `next`",
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
                self.promise_as_condition(e);
                None
            }
            ExprKind::Not(inner) => {
                let a = self.boolean(inner, time)?;
                Some(Value::Scalar(Term::unary(UnaryOp::Not, a), Type::Bool))
            }
            ExprKind::Neg(inner) => {
                let (a, ty) = self.any_scalar(inner, expected, time)?;
                if !ty.is_numeric() {
                    self.mismatch(inner.span, "a number", &ty);
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
            ExprKind::Call(name, arguments) if self.defines.contains_key(&name.text) => {
                self.predicate(e.span, name, arguments, expected, time)
            }
            ExprKind::Call(name, arguments) => self.call(e.span, name, arguments, time),
            ExprKind::Field(base, name) => {
                let value = self.value(base, None, time)?;
                self.member(base.span, value, name)
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
                        self.mismatch(m.span, &expected, &found);
                        return None;
                    }
                }
                Some(Value::Array(values))
            }
            ExprKind::Member(of, members) => {
                let (x, ty) = self.any_scalar(of, None, time)?;
                self.spend(e.span, x.size().saturating_mul(members.len()))?;
                let mut terms = Vec::new();
                for m in members {
                    let (m_term, m_ty) = self.any_scalar(m, Some(&ty), time)?;
                    if !comparable(&ty, &m_ty) {
                        self.mismatch(m.span, &ty.describe(), &m_ty);
                        return None;
                    }
                    let (x, m_term) = if ty.is_numeric() {
                        let (x, m, _) =
                            self.aligned(m.span, (x.clone(), ty.clone()), (m_term, m_ty))?;
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
                self.spend(e.span, x.0.size())?;
                let (low, above, _) = self.aligned(e.span, low, x.clone())?;
                let (below, high, _) = self.aligned(e.span, x, high)?;
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

    /// Reports a promise about the whole run where the condition of one step is wanted.
    fn promise_as_condition(&mut self, e: &ast::Expr) {
        let word = match &e.kind {
            ExprKind::Always(_) => "`always`",
            ExprKind::Eventually(_) => "`eventually`",
            ExprKind::Until(op, ..) => &format!("`{}`", op.word()),
            _ => "this pattern",
        };
        let (message, help) = match self.defining.last() {
            Some(name) => (
                format!("{word} stands in the definition `{name}`, which is the condition of one step"),
                format!(
                    "write `{}` in the assumption or guarantee itself",
                    format::expression(e)
                ),
            ),
            None => (
                format!("{word} stands within a larger formula, which is outside GR(1)"),
                "give it an assumption or guarantee of its own, or look back with `once`, `since` and `previous`".to_owned(),
            ),
        };
        self.error_with(codes::NOT_GR1, e.span, message, help);
    }

    /// A scalar of whatever type.
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
                    "name one member, such as `target.x`"
                } else {
                    "name one element with `[i]`, or quantify over `forall i in 0..n-1`"
                };
                let message = format!("this is {}", other.ty().describe());
                self.error_with(codes::TYPE_MISMATCH, e.span, message, help);
                None
            }
        }
    }

    pub(super) fn number(&mut self, e: &'a ast::Expr, time: Time) -> Option<(Term, Type)> {
        let (term, ty) = self.any_scalar(e, Some(&Type::Int), time)?;
        if ty.is_numeric() {
            Some((term, ty))
        } else {
            self.mismatch(e.span, "a number", &ty);
            None
        }
    }
}

/// A real constant.
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
