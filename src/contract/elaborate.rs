//! From a syntax tree's expressions to typed terms.
//!
//! Labels have no type of their own: `turn` in `command = turn` is looked up in the type of `command`. A name is, in this order:
//! bound by a quantifier, a `define`, a variable, a parameter or constant, a label of the expected type, a label of the one
//! enumeration in sight that has it.

use super::value::{Dimension, Rounding, Term, Type, Value, unit};
use crate::diagnostics::{Code, Diagnostic, codes};
use crate::gr1::interval::{Interval, Problem, interval};
use crate::gr1::{BinaryOp, Domain, Time, UnaryOp, VarId};
use crate::source::Span;
use crate::syntax::ast::{self, ExprKind, Quantifier};
use std::collections::BTreeMap;

/// Quantifiers and arrays expand to at most so many instances.
pub(super) const MAX_EXPANSION: i64 = 4096;
/// A domain has at most so many values.
pub(super) const MAX_DOMAIN: i64 = 1 << 20;

/// A variable in sight.
#[derive(Debug, Clone)]
pub(super) enum Entry {
    /// A scalar.
    One(VarId),
    /// An array.
    Many(Vec<VarId>),
}

/// A property's unit, for reading it: its dimension and how many base units it is.
pub(super) type UnitOf = (Dimension, f64);

/// What names mean, and where findings go.
pub(super) struct Elaborator<'a> {
    /// Variables by name; dotted for a component's.
    pub variables: BTreeMap<String, Entry>,
    /// The domains of variables by id; `None` for real ones.
    pub domains: Vec<Option<Domain>>,
    /// The units of real variables by id.
    pub units: BTreeMap<VarId, UnitOf>,
    /// Constants, parameters and quantified names.
    pub constants: BTreeMap<String, Value>,
    /// Named types in sight.
    pub types: BTreeMap<String, Type>,
    /// The domains of the named types that are finite.
    pub named_domains: BTreeMap<String, Domain>,
    /// Defines by name.
    pub defines: BTreeMap<String, &'a ast::Expr>,
    /// Whether real numbers are understood: `/` is then the division of real numbers.
    pub real: bool,
    /// Whether next values are understood.
    pub next: bool,
    /// What was found.
    pub findings: Vec<Diagnostic>,
    defining: Vec<String>,
    expansions: i64,
}

impl<'a> Elaborator<'a> {
    pub fn new() -> Self {
        Self {
            variables: BTreeMap::new(),
            domains: Vec::new(),
            units: BTreeMap::new(),
            constants: BTreeMap::new(),
            types: BTreeMap::new(),
            named_domains: BTreeMap::new(),
            defines: BTreeMap::new(),
            real: false,
            next: false,
            findings: Vec::new(),
            defining: Vec::new(),
            expansions: 0,
        }
    }

    /// Records an error.
    pub fn error(&mut self, code: Code, span: Span, message: impl Into<String>) {
        self.findings.push(Diagnostic::error(code, span, message));
    }

    /// Records an error with a next step.
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

    fn mismatch(&mut self, span: Span, expected: &str, found: &Type) {
        self.error(
            codes::TYPE_MISMATCH,
            span,
            format!("expected {expected}, found {}", found.describe()),
        );
    }

    // ---- entry points ------------------------------------------------------------------------------------------------

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
        let value = self.value(e, Some(expected), Time::Now)?;
        match (value, expected) {
            (Value::Scalar(term, found), _) if found == *expected => Some(term),
            (Value::Scalar(term, Type::Int), Type::Number(_)) => Some(term),
            (value, _) => {
                self.mismatch(e.span, &expected.describe(), &value.ty());
                None
            }
        }
    }

    /// A whole number that is known now.
    pub fn constant_int(&mut self, e: &'a ast::Expr) -> Option<i64> {
        let before = self.findings.len();
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
            None => {
                debug_assert!(self.findings.len() > before);
                None
            }
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
            Type::Int if dimension == Dimension::None => Some(term),
            Type::Int | Type::Number(Dimension::None) if term == Term::Int(0) => Some(term),
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
        match &e.kind {
            ExprKind::Bool(b) => Some(Value::Scalar(Term::truth(*b), Type::Bool)),
            ExprKind::Int(i) => Some(Value::Scalar(Term::Int(*i), Type::Int)),
            ExprKind::Quantity(number, name) => self.literal(e.span, *number, name),
            ExprKind::Path(names) => self.path(e.span, names, expected, time),
            ExprKind::Index(base, index) => self.index(e.span, base, index, expected, time),
            ExprKind::Next(inner) => {
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
            ExprKind::Always(_) | ExprKind::Eventually(_) => {
                let word = if matches!(e.kind, ExprKind::Always(_)) {
                    "always"
                } else {
                    "eventually"
                };
                self.error_with(
                    codes::NOT_GR1,
                    e.span,
                    format!("`{word}` stands within a larger formula, which is outside GR(1)"),
                    "an assumption or guarantee is an initial condition, `always P`, or `always eventually P`",
                );
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
            ExprKind::Binary(op, a, b) => self.operation(e.span, *op, a, b, expected, time),
            ExprKind::If(c, a, b) => self.conditional(c, a, b, expected, time),
            ExprKind::Quantifier(kind, name, domain, body) => {
                self.quantifier(e.span, *kind, name, domain, body, time)
            }
            ExprKind::Call(name, arguments) => self.call(e.span, name, arguments, time),
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
            ExprKind::Member(x, members) => {
                let (x, ty) = self.any_scalar(x, None, time)?;
                let mut terms = Vec::new();
                for m in members {
                    let (m_term, m_ty) = self.any_scalar(m, Some(&ty), time)?;
                    if !comparable(&ty, &m_ty) {
                        self.mismatch(m.span, &ty.describe(), &m_ty);
                        return None;
                    }
                    terms.push(Term::binary(BinaryOp::Eq, x.clone(), m_term));
                }
                Some(Value::Scalar(
                    Term::fold(BinaryOp::Or, terms, 0),
                    Type::Bool,
                ))
            }
            ExprKind::Within(x, low, high) => {
                let x = self.number(x, time)?;
                let low = self.number(low, time)?;
                let high = self.number(high, time)?;
                Some(Value::Scalar(
                    Term::binary(
                        BinaryOp::And,
                        Term::binary(BinaryOp::Le, low.0, x.0.clone()),
                        Term::binary(BinaryOp::Le, x.0, high.0),
                    ),
                    Type::Bool,
                ))
            }
        }
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
            array @ Value::Array(_) => {
                let ty = array.ty();
                self.findings.push(
                    Diagnostic::error(
                        codes::TYPE_MISMATCH,
                        e.span,
                        format!("this is {}", ty.describe()),
                    )
                    .with_help(
                        "name one element with `[i]`, or quantify over `forall i in 0..n-1`",
                    ),
                );
                None
            }
        }
    }

    fn number(&mut self, e: &'a ast::Expr, time: Time) -> Option<(Term, Type)> {
        let (term, ty) = self.any_scalar(e, Some(&Type::Int), time)?;
        if ty.is_numeric() {
            Some((term, ty))
        } else {
            self.mismatch(e.span, "a number", &ty);
            None
        }
    }

    // ---- names -------------------------------------------------------------------------------------------------------

    fn literal(&mut self, span: Span, number: f64, name: &str) -> Option<Value> {
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

    fn path(
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

    fn variable(&self, id: VarId, time: Time) -> Value {
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
    fn label(&mut self, name: &ast::Name, expected: Option<&Type>) -> Option<Option<Value>> {
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

    fn unknown(&mut self, span: Span, name: &str, expected: Option<&Type>) {
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

    fn index(
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

    // ---- operators ---------------------------------------------------------------------------------------------------

    fn operation(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        let boolean = |op, a, b| Some(Value::Scalar(Term::binary(op, a, b), Type::Bool));
        match op {
            A::And | A::Or | A::Implies | A::Iff | A::Xor => {
                // Both sides are looked at even when one is wrong: all findings at once.
                let (a, b) = (self.boolean(a, time), self.boolean(b, time));
                let op = match op {
                    A::And => BinaryOp::And,
                    A::Or => BinaryOp::Or,
                    A::Implies => BinaryOp::Implies,
                    A::Iff => BinaryOp::Eq,
                    _ => BinaryOp::Ne,
                };
                boolean(op, a?, b?)
            }
            A::Eq | A::Ne => {
                let (left, right) = self.two_sides(a, b, time)?;
                let equal = self.equal(span, left, right)?;
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
                let (a, b) = (self.number(a, time), self.number(b, time));
                let ((a, at), (b, bt)) = (a?, b?);
                self.same_dimension(span, &at, &a, &bt, &b)?;
                let op = match op {
                    A::Lt => BinaryOp::Lt,
                    A::Le => BinaryOp::Le,
                    A::Gt => BinaryOp::Gt,
                    _ => BinaryOp::Ge,
                };
                boolean(op, a, b)
            }
            A::Add | A::Sub | A::Mul | A::Div | A::Mod => {
                let _ = expected;
                let (a, b_value) = (self.number(a, time), self.number(b, time));
                self.arithmetic(span, op, a?, b_value?, b.span)
            }
        }
    }

    /// Both sides of an equality; a bare label is looked up in the type of the other side.
    fn two_sides(
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

    fn is_label(&self, e: &ast::Expr) -> bool {
        match &e.kind {
            ExprKind::Path(names) => {
                let [name] = names.as_slice() else {
                    return false;
                };
                !self.variables.contains_key(&name.text)
                    && !self.constants.contains_key(&name.text)
                    && !self.defines.contains_key(&name.text)
            }
            ExprKind::If(_, a, b) => self.is_label(a) && self.is_label(b),
            ExprKind::List(members) => members.iter().all(|m| self.is_label(m)),
            ExprKind::Index(base, _) => self.is_label(base),
            _ => false,
        }
    }

    fn equal(&mut self, span: Span, a: Value, b: Value) -> Option<Term> {
        match (a, b) {
            (Value::Scalar(a, at), Value::Scalar(b, bt)) => {
                if !comparable(&at, &bt) {
                    self.error(
                        codes::TYPE_MISMATCH,
                        span,
                        format!("{} cannot equal {}", at.describe(), bt.describe()),
                    );
                    return None;
                }
                self.same_dimension(span, &at, &a, &bt, &b)?;
                Some(Term::binary(BinaryOp::Eq, a, b))
            }
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                let mut terms = Vec::with_capacity(a.len());
                for (a, b) in a.into_iter().zip(b) {
                    terms.push(self.equal(span, a, b)?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (Value::Array(a), b @ Value::Scalar(..)) => {
                // An array equals a scalar when every element does: `h = 0`.
                let mut terms = Vec::with_capacity(a.len());
                for a in a {
                    terms.push(self.equal(span, a, b.clone())?);
                }
                Some(Term::fold(BinaryOp::And, terms, 1))
            }
            (a, b) => {
                self.error(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("{} cannot equal {}", a.ty().describe(), b.ty().describe()),
                );
                None
            }
        }
    }

    /// Adding and comparing needs one dimension; 0 fits every one.
    fn same_dimension(
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

    fn arithmetic(
        &mut self,
        span: Span,
        op: ast::BinaryOp,
        (a, at): (Term, Type),
        (b, bt): (Term, Type),
        b_span: Span,
    ) -> Option<Value> {
        use ast::BinaryOp as A;
        let of = |t: &Type| match t {
            Type::Number(d) => *d,
            _ => Dimension::None,
        };
        let dimension = match op {
            A::Add | A::Sub | A::Mod => self.same_dimension(span, &at, &a, &bt, &b)?,
            A::Mul if of(&at) == Dimension::None => of(&bt),
            A::Mul | A::Div if of(&bt) == Dimension::None => of(&at),
            A::Div if of(&at) == Dimension::Length && of(&bt) == Dimension::Speed => {
                Dimension::Time
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

    /// The interval of a whole number; reports what leaves the arithmetic's limits.
    pub fn range_of(&mut self, term: &Term, span: Span) -> Option<Interval> {
        if self.real {
            // Plant expressions are not bounded; only constant indices are asked for here.
            return match term {
                Term::Int(i) => Some(Interval { low: *i, high: *i }),
                _ => {
                    self.error_with(
                        codes::NOT_CONSTANT,
                        span,
                        "the index has to be known before the line runs",
                        "use numbers, constants, parameters and quantified names",
                    );
                    None
                }
            };
        }
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
                self.error(codes::DIVISION, span, "a divisor can be 0");
                None
            }
        }
    }

    fn conditional(
        &mut self,
        c: &'a ast::Expr,
        a: &'a ast::Expr,
        b: &'a ast::Expr,
        expected: Option<&Type>,
        time: Time,
    ) -> Option<Value> {
        let condition = self.boolean(c, time);
        let (left, right) = match expected {
            Some(_) => (self.value(a, expected, time), self.value(b, expected, time)),
            None => {
                let (l, r) = self.two_sides(a, b, time)?;
                (Some(l), Some(r))
            }
        };
        let (condition, left, right) = (condition?, left?, right?);
        match (left, right) {
            (Value::Scalar(l, lt), Value::Scalar(r, rt)) if comparable(&lt, &rt) => {
                let ty = if lt == Type::Int { rt } else { lt };
                Some(Value::Scalar(Term::choose(condition, l, r), ty))
            }
            (Value::Array(l), Value::Array(r)) if l.len() == r.len() => {
                let mut elements = Vec::with_capacity(l.len());
                for (l, r) in l.into_iter().zip(r) {
                    let (Value::Scalar(l, lt), Value::Scalar(r, rt)) = (l, r) else {
                        self.error(
                            codes::TYPE_MISMATCH,
                            a.span,
                            "arrays of arrays cannot be chosen",
                        );
                        return None;
                    };
                    if !comparable(&lt, &rt) {
                        self.mismatch(b.span, &lt.describe(), &rt);
                        return None;
                    }
                    elements.push(Value::Scalar(Term::choose(condition.clone(), l, r), lt));
                }
                Some(Value::Array(elements))
            }
            (l, r) => {
                self.mismatch(b.span, &l.ty().describe(), &r.ty());
                None
            }
        }
    }

    /// The values that a quantified name takes, each with its type.
    pub fn quantified(&mut self, domain: &'a ast::Domain) -> Option<Vec<Value>> {
        let values: Vec<Value> = match &domain.kind {
            ast::DomainKind::Range(low, high) => {
                let (low, high) = (self.constant_int(low)?, self.constant_int(high)?);
                if high - low >= MAX_EXPANSION {
                    self.error(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        format!("more than {MAX_EXPANSION} values"),
                    );
                    return None;
                }
                (low..=high)
                    .map(|i| Value::Scalar(Term::Int(i), Type::Int))
                    .collect()
            }
            _ => {
                let (base, length) = self.domain(domain)?;
                if length.is_some() || base.size() as i64 > MAX_EXPANSION {
                    self.error(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        "a quantifier ranges over numbers, labels or truth values",
                    );
                    return None;
                }
                (base.low()..=base.high())
                    .map(|i| Value::Scalar(Term::Int(i), Type::of(&base)))
                    .collect()
            }
        };
        self.expansions += values.len() as i64;
        if self.expansions > MAX_EXPANSION * 64 {
            self.error_with(
                codes::DOMAIN_EMPTY,
                domain.span,
                "the quantifiers expand to too many instances",
                "use smaller ranges or fewer nested quantifiers",
            );
            return None;
        }
        Some(values)
    }

    fn quantifier(
        &mut self,
        span: Span,
        kind: Quantifier,
        name: &ast::Name,
        domain: &'a ast::Domain,
        body: &'a ast::Expr,
        time: Time,
    ) -> Option<Value> {
        let values = self.quantified(domain)?;
        let mut terms = Vec::with_capacity(values.len());
        for value in values {
            let shadowed = self.constants.insert(name.text.clone(), value);
            let term = match kind {
                Quantifier::Sum => self.number(body, time),
                _ => self.boolean(body, time).map(|t| (t, Type::Bool)),
            };
            match shadowed {
                Some(old) => self.constants.insert(name.text.clone(), old),
                None => self.constants.remove(&name.text),
            };
            terms.push(term?);
        }
        let real = terms.iter().find_map(|(_, t)| match t {
            Type::Number(d) => Some(Type::Number(*d)),
            _ => None,
        });
        let terms = terms.into_iter().map(|(t, _)| t);
        let value = match kind {
            Quantifier::Forall => {
                Value::Scalar(Term::fold(BinaryOp::And, terms.collect(), 1), Type::Bool)
            }
            Quantifier::Exists => {
                Value::Scalar(Term::fold(BinaryOp::Or, terms.collect(), 0), Type::Bool)
            }
            Quantifier::Count => Value::Scalar(
                Term::fold(
                    BinaryOp::Add,
                    terms
                        .map(|t| Term::choose(t, Term::Int(1), Term::Int(0)))
                        .collect(),
                    0,
                ),
                Type::Int,
            ),
            Quantifier::Sum => Value::Scalar(
                Term::fold(BinaryOp::Add, terms.collect(), 0),
                real.unwrap_or(Type::Int),
            ),
        };
        if let (Value::Scalar(term, Type::Int), false) = (&value, self.real) {
            self.range_of(term, span)?;
        }
        Some(value)
    }

    fn call(
        &mut self,
        span: Span,
        name: &ast::Name,
        arguments: &'a [ast::Expr],
        time: Time,
    ) -> Option<Value> {
        let rounding = match name.text.as_str() {
            "floor" => Some(Rounding::Floor),
            "ceil" => Some(Rounding::Ceil),
            "round" => Some(Rounding::Round),
            "min" | "max" | "abs" => None,
            other => {
                let help = match nearest(
                    other,
                    ["min", "max", "abs", "floor", "ceil", "round"].into_iter(),
                ) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => {
                        "the functions are min, max, abs, and in machines floor, ceil and round"
                            .to_owned()
                    }
                };
                self.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no function `{other}`"),
                    help,
                );
                return None;
            }
        };
        let mut values = Vec::with_capacity(arguments.len());
        for a in arguments {
            values.push(self.number(a, time));
        }
        let values: Vec<(Term, Type)> = values.into_iter().collect::<Option<_>>()?;
        if (name.text == "abs" || rounding.is_some()) && values.len() != 1 {
            self.error(
                codes::ARGUMENT,
                span,
                format!("`{}` takes one argument", name.text),
            );
            return None;
        }
        if let Some(rounding) = rounding {
            if !self.real {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    span,
                    format!("`{}` has no meaning in a contract", name.text),
                    "a contract's numbers are whole; `/` rounds down",
                );
                return None;
            }
            let (term, _) = values.into_iter().next()?;
            return Some(Value::Scalar(
                Term::Rounded(rounding, Box::new(term)),
                Type::Number(Dimension::None),
            ));
        }
        let op = if name.text == "min" {
            BinaryOp::Min
        } else {
            BinaryOp::Max
        };
        let mut values = values.into_iter();
        let (mut term, mut ty) = values.next()?;
        if name.text == "abs" {
            return Some(Value::Scalar(Term::unary(UnaryOp::Abs, term), ty));
        }
        for (next, next_ty) in values {
            let dimension = self.same_dimension(span, &ty, &term, &next_ty, &next)?;
            if next_ty != Type::Int || ty != Type::Int {
                ty = Type::Number(dimension);
            }
            term = Term::binary(op, term, next);
        }
        Some(Value::Scalar(term, ty))
    }

    // ---- types -------------------------------------------------------------------------------------------------------

    /// A finite domain, and the length of the array if it is one.
    pub fn domain(&mut self, domain: &'a ast::Domain) -> Option<(Domain, Option<usize>)> {
        match &domain.kind {
            ast::DomainKind::Labels(names) => {
                let mut labels: Vec<String> = Vec::new();
                for name in names {
                    if labels.contains(&name.text) {
                        self.error(
                            codes::NAME_DOUBLE,
                            name.span,
                            format!("the label `{}` is there already", name.text),
                        );
                    } else {
                        labels.push(name.text.clone());
                    }
                }
                Some((Domain::Enum { name: None, labels }, None))
            }
            ast::DomainKind::Range(low, high) => {
                let (l, h) = (self.constant_int(low), self.constant_int(high));
                let (low, high) = (l?, h?);
                if low > high {
                    self.error_with(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        format!("{low}..{high} is empty"),
                        "write the smaller number first",
                    );
                    return None;
                }
                if high - low >= MAX_DOMAIN {
                    self.error_with(
                        codes::DOMAIN_EMPTY,
                        domain.span,
                        format!("{low}..{high} has more than {MAX_DOMAIN} values"),
                        "use a coarser abstraction",
                    );
                    return None;
                }
                Some((Domain::Range { low, high }, None))
            }
            ast::DomainKind::Array(length, of) => {
                let length_value = self.constant_int(length)?;
                if !(1..=MAX_EXPANSION).contains(&length_value) {
                    self.error(
                        codes::DOMAIN_EMPTY,
                        length.span,
                        format!("an array has 1 to {MAX_EXPANSION} elements, not {length_value}"),
                    );
                    return None;
                }
                let (base, inner) = self.domain(of)?;
                if inner.is_some() {
                    self.error_with(
                        codes::TYPE_MISMATCH,
                        of.span,
                        "arrays of arrays are not known",
                        "use one array with `rows * columns` elements",
                    );
                    return None;
                }
                Some((base, Some(length_value as usize)))
            }
            ast::DomainKind::Named(name) if name.text == "bool" => Some((Domain::Bool, None)),
            ast::DomainKind::Named(name) => {
                if let Some(domain) = self.named_domains.get(&name.text) {
                    return Some((domain.clone(), None));
                }
                let known: Vec<String> = self
                    .named_domains
                    .keys()
                    .cloned()
                    .chain(["bool".to_owned()])
                    .collect();
                let help = if matches!(name.text.as_str(), "int" | "integer" | "real" | "number") {
                    "a contract's numbers are bounded: write a range such as `0..9`".to_owned()
                } else {
                    match nearest(&name.text, known.iter().map(String::as_str)) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => "declare it with `type`, or import the file that does".to_owned(),
                    }
                };
                self.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("there is no type `{}`", name.text),
                    help,
                );
                None
            }
            ast::DomainKind::Unit(unit) => {
                self.error_with(
                    codes::TYPE_MISMATCH,
                    domain.span,
                    format!("`{unit}` is a unit of the plant; a contract counts in whole numbers"),
                    "write a range such as `0..9`, and give its meaning in the machine with `abstract`",
                );
                None
            }
        }
    }
}

/// A real constant.
pub(super) fn constant_real(term: &Term) -> Option<f64> {
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

/// The known name closest to a misspelt one, if any is close.
pub(super) fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    known
        .map(|k| (distance(name, k), k))
        .filter(|(d, k)| *d <= 1 + name.len().min(k.len()) / 4)
        .min()
        .map(|(_, k)| k)
}

/// Levenshtein's edit distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
