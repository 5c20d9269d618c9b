//! Typed terms: the values of the language's expressions, before they are converted to formulas or
//! plant expressions.
//!
//! One elaborator serves contracts (finite values, now and in the next state) and plants (real
//! numbers, properties and wires). Both use [`Term`]; [`Term::to_expr`] and [`Term::to_real`]
//! convert a term for the later stages.

use super::machine::{RealBinary, RealExpr, RealUnary};
pub(super) use super::units::{Dimension, Unit, unit};
use linewright_core::gr1::{BinaryOp, Domain, Expr, Time, UnaryOp, VarId};

/// Type of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Type {
    Bool,
    /// A whole number.
    Int,
    /// A real number.
    Number(Dimension),
    /// A whole number of a unit, such as millimetres in a contract.
    Measured(Unit),
    /// One of these labels; two enumerations with the same labels are the same type.
    Enum(Vec<String>),
    Array(Box<Type>, usize),
    /// Members by name, in the order of their declaration.
    Record(Vec<(String, Type)>),
}

impl Type {
    pub fn of(domain: &Domain) -> Self {
        match domain {
            Domain::Bool => Self::Bool,
            Domain::Range { .. } => Self::Int,
            Domain::Enum { labels, .. } => Self::Enum(labels.clone()),
        }
    }

    pub fn describe(&self) -> String {
        match self {
            Self::Bool => "a truth value".to_owned(),
            Self::Int => "a whole number".to_owned(),
            Self::Number(d) => d.describe().to_owned(),
            Self::Enum(labels) => format!("one of {{{}}}", labels.join(", ")),
            Self::Measured(unit) => format!("a whole number of `{}`", unit.name()),
            Self::Array(of, n) => format!("an array of {n}, each {}", of.describe()),
            Self::Record(members) => {
                let names: Vec<&str> = members.iter().map(|(n, _)| n.as_str()).collect();
                format!("a record of {}", names.join(", "))
            }
        }
    }

    pub fn is_numeric(&self) -> bool {
        matches!(self, Self::Int | Self::Number(_) | Self::Measured(_))
    }

    /// Returns the dimension of the type; `Dimension::None` for types other than quantities.
    pub fn dimension(&self) -> Dimension {
        match self {
            Self::Number(dimension) => *dimension,
            Self::Measured(unit) => unit.dimension(),
            _ => Dimension::None,
        }
    }
}

/// A rounding operator on real numbers; [`UnaryOp`] contains none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rounding {
    Floor,
    Ceil,
    Round,
}

/// A scalar expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Term {
    Int(i64),
    Real(f64),
    Var(VarId, Time),
    Unary(UnaryOp, Box<Term>),
    Rounded(Rounding, Box<Term>),
    Binary(BinaryOp, Box<Term>, Box<Term>),
    If(Box<Term>, Box<Term>, Box<Term>),
}

impl Term {
    pub const TRUE: Self = Self::Int(1);
    pub const FALSE: Self = Self::Int(0);

    pub fn truth(value: bool) -> Self {
        Self::Int(i64::from(value))
    }

    pub fn unary(op: UnaryOp, a: Self) -> Self {
        match a {
            Self::Int(a) => Self::Int(linewright_core::gr1::eval::unary(op, a)),
            Self::Unary(UnaryOp::Not, inner) if op == UnaryOp::Not => *inner,
            a => Self::Unary(op, Box::new(a)),
        }
    }

    /// Applies an operator to two operands, folding constants. Constant arithmetic is folded only
    /// if it cannot overflow or divide by zero.
    pub fn binary(op: BinaryOp, a: Self, b: Self) -> Self {
        use BinaryOp as B;
        match (op, &a, &b) {
            (B::And, Self::Int(0), _)
            | (B::And, _, Self::Int(0))
            | (B::Or, Self::Int(0), Self::Int(0)) => return Self::FALSE,
            (B::Or, Self::Int(1), _)
            | (B::Or | B::Implies, _, Self::Int(1))
            | (B::Implies, Self::Int(0), _) => return Self::TRUE,
            (B::And | B::Implies, Self::Int(1), _) | (B::Or, Self::Int(0), _) => return b,
            (B::And, _, Self::Int(1)) | (B::Or, _, Self::Int(0)) => return a,
            (B::Implies, _, Self::Int(0)) => return Self::unary(UnaryOp::Not, a),
            (B::Div | B::Mod, _, Self::Int(0)) => {}
            (_, Self::Int(x), Self::Int(y)) => {
                if let Some(value) = exact(op, *x, *y) {
                    return Self::Int(value);
                }
            }
            (_, Self::Int(_) | Self::Real(_), Self::Int(_) | Self::Real(_)) => {
                let (x, y) = (a.to_real(0), b.to_real(0));
                let whole = RealExpr::Binary(RealBinary::of(op), Box::new(x), Box::new(y));
                let value = whole.eval(&[], &[]);
                return match op {
                    B::Add | B::Sub | B::Mul | B::Div | B::Mod | B::Min | B::Max => {
                        Self::Real(value)
                    }
                    _ => Self::truth(value != 0.0),
                };
            }
            _ => {}
        }
        Self::Binary(op, Box::new(a), Box::new(b))
    }

    /// Returns the number of nodes of the tree.
    pub fn size(&self) -> usize {
        1 + match self {
            Self::Int(_) | Self::Real(_) | Self::Var(..) => 0,
            Self::Unary(_, a) | Self::Rounded(_, a) => a.size(),
            Self::Binary(_, a, b) => a.size() + b.size(),
            Self::If(c, a, b) => c.size() + a.size() + b.size(),
        }
    }

    /// Returns the depth of the tree.
    pub fn depth(&self) -> usize {
        1 + match self {
            Self::Int(_) | Self::Real(_) | Self::Var(..) => 0,
            Self::Unary(_, a) | Self::Rounded(_, a) => a.depth(),
            Self::Binary(_, a, b) => a.depth().max(b.depth()),
            Self::If(c, a, b) => c.depth().max(a.depth()).max(b.depth()),
        }
    }

    pub fn choose(c: Self, a: Self, b: Self) -> Self {
        match c {
            Self::Int(0) => b,
            Self::Int(_) => a,
            c if a == b => {
                drop(c);
                a
            }
            c => Self::If(Box::new(c), Box::new(a), Box::new(b)),
        }
    }

    /// Combines terms with an associative operator, as a balanced tree; returns `empty` if there
    /// are no terms.
    pub fn fold(op: BinaryOp, mut terms: Vec<Self>, empty: i64) -> Self {
        if terms.is_empty() {
            return Self::Int(empty);
        }
        while terms.len() > 1 {
            let mut halved = Vec::with_capacity(terms.len().div_ceil(2));
            let mut pairs = terms.into_iter();
            while let Some(a) = pairs.next() {
                halved.push(match pairs.next() {
                    Some(b) => Self::binary(op, a, b),
                    None => a,
                });
            }
            terms = halved;
        }
        terms.pop().unwrap_or(Self::Int(empty))
    }

    /// Converts the term to an integer expression; `None` if the term contains a real number or a
    /// rounding operator.
    pub fn to_expr(&self) -> Option<Expr> {
        Some(match self {
            Self::Int(c) => Expr::Const(*c),
            Self::Real(_) | Self::Rounded(..) => return None,
            Self::Var(v, t) => Expr::Var(*v, *t),
            Self::Unary(op, a) => Expr::Unary(*op, Box::new(a.to_expr()?)),
            Self::Binary(op, a, b) => {
                Expr::Binary(*op, Box::new(a.to_expr()?), Box::new(b.to_expr()?))
            }
            Self::If(c, a, b) => Expr::If(
                Box::new(c.to_expr()?),
                Box::new(a.to_expr()?),
                Box::new(b.to_expr()?),
            ),
        })
    }

    /// Returns whether the term contains a variable.
    pub fn has_variable(&self) -> bool {
        match self {
            Self::Int(_) | Self::Real(_) => false,
            Self::Var(..) => true,
            Self::Unary(_, a) | Self::Rounded(_, a) => a.has_variable(),
            Self::Binary(_, a, b) => a.has_variable() || b.has_variable(),
            Self::If(c, a, b) => c.has_variable() || a.has_variable() || b.has_variable(),
        }
    }

    /// Converts an integer expression to a term.
    pub fn from_expr(expr: &Expr) -> Self {
        let sub = |e: &Expr| Box::new(Self::from_expr(e));
        match expr {
            Expr::Const(c) => Self::Int(*c),
            Expr::Var(v, t) => Self::Var(*v, *t),
            Expr::Unary(op, a) => Self::Unary(*op, sub(a)),
            Expr::Binary(op, a, b) => Self::Binary(*op, sub(a), sub(b)),
            Expr::If(c, a, b) => Self::If(sub(c), sub(a), sub(b)),
        }
    }

    /// Converts the term to a plant expression: variables with ids below `properties` become
    /// properties, the others become wires, numbered from 0.
    pub fn to_real(&self, properties: usize) -> RealExpr {
        let sub = |t: &Self| Box::new(t.to_real(properties));
        match self {
            Self::Int(c) => RealExpr::Number(*c as f64),
            Self::Real(x) => RealExpr::Number(*x),
            Self::Var(v, _) if v.index() < properties => RealExpr::Property(v.index()),
            Self::Var(v, _) => RealExpr::Wire(v.index() - properties),
            Self::Unary(op, a) => RealExpr::Unary(
                match op {
                    UnaryOp::Not => RealUnary::Not,
                    UnaryOp::Neg => RealUnary::Neg,
                    UnaryOp::Abs => RealUnary::Abs,
                },
                sub(a),
            ),
            Self::Rounded(op, a) => RealExpr::Unary(
                match op {
                    Rounding::Floor => RealUnary::Floor,
                    Rounding::Ceil => RealUnary::Ceil,
                    Rounding::Round => RealUnary::Round,
                },
                sub(a),
            ),
            Self::Binary(op, a, b) => RealExpr::Binary(RealBinary::of(*op), sub(a), sub(b)),
            Self::If(c, a, b) => RealExpr::If(sub(c), sub(a), sub(b)),
        }
    }
}

/// Computes constant integer arithmetic; `None` if an operand or the result exceeds the limits of
/// [`interval`](linewright_core::gr1::interval).
fn exact(op: BinaryOp, x: i64, y: i64) -> Option<i64> {
    const LIMIT: u64 = 1 << 62;
    if x.unsigned_abs() > LIMIT || y.unsigned_abs() > LIMIT {
        return None;
    }
    let value = match op {
        BinaryOp::Add => x.checked_add(y)?,
        BinaryOp::Sub => x.checked_sub(y)?,
        BinaryOp::Mul => x.checked_mul(y)?,
        _ => linewright_core::gr1::eval::binary(op, x, y),
    };
    (value.unsigned_abs() <= LIMIT).then_some(value)
}

/// Value of an expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Scalar(Term, Type),
    Array(Vec<Value>),
    /// Members by name, in the order of their declaration.
    Record(Vec<(String, Value)>),
}

impl Value {
    /// Returns the number of nodes of all terms.
    pub fn size(&self) -> usize {
        match self {
            Self::Scalar(term, _) => term.size(),
            Self::Array(values) => values.iter().map(Self::size).sum(),
            Self::Record(members) => members.iter().map(|(_, v)| v.size()).sum(),
        }
    }

    /// Returns whether the value contains a real number.
    pub fn is_real(&self) -> bool {
        match self {
            Self::Scalar(_, ty) => matches!(ty, Type::Number(_)),
            Self::Array(values) => values.iter().any(Self::is_real),
            Self::Record(members) => members.iter().any(|(_, v)| v.is_real()),
        }
    }

    pub fn ty(&self) -> Type {
        match self {
            Self::Scalar(_, ty) => ty.clone(),
            Self::Array(v) => Type::Array(Box::new(v.first().map_or(Type::Int, Self::ty)), v.len()),
            Self::Record(members) => {
                Type::Record(members.iter().map(|(n, v)| (n.clone(), v.ty())).collect())
            }
        }
    }

    /// Replaces each scalar by the result of `change`; `None` if `change` returns `None`.
    pub fn map(self, change: &mut impl FnMut(Term, Type) -> Option<(Term, Type)>) -> Option<Self> {
        Some(match self {
            Self::Scalar(term, ty) => {
                let (term, ty) = change(term, ty)?;
                Self::Scalar(term, ty)
            }
            Self::Array(values) => Self::Array(
                values
                    .into_iter()
                    .map(|v| v.map(change))
                    .collect::<Option<_>>()?,
            ),
            Self::Record(members) => Self::Record(
                members
                    .into_iter()
                    .map(|(name, v)| Some((name, v.map(change)?)))
                    .collect::<Option<_>>()?,
            ),
        })
    }
}
