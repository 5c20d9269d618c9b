//! Resolved expressions: booleans, labels and integers are all `i64`, and all arithmetic is exact.

use super::VarId;
use serde::{Deserialize, Serialize};

/// Selects the current or the next value of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Time {
    /// Value in this step.
    Now,
    /// Value in the next step.
    Next,
}

/// An operator with one operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum UnaryOp {
    /// Boolean negation.
    Not,
    /// `-x`
    Neg,
    /// `abs(x)`
    Abs,
}

/// An operator with two operands. Boolean operands are 0 or 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum BinaryOp {
    /// Boolean and.
    And,
    /// Boolean or.
    Or,
    /// Boolean implication.
    Implies,
    /// `=`; for booleans, "if and only if".
    Eq,
    /// `!=`; for booleans, exclusive or.
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// Division rounded towards minus infinity. The divisor is never 0 (checked when a file is
    /// resolved).
    Div,
    /// Remainder of [`Div`](Self::Div). Its sign is that of the divisor, so it is never negative
    /// for a positive divisor.
    Mod,
    /// Minimum.
    Min,
    /// Maximum.
    Max,
}

/// An expression over the variables of one specification or the wires of one machine.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Expr {
    /// A constant; `true` is 1.
    Const(i64),
    /// A variable.
    Var(VarId, Time),
    /// An operator with one operand.
    Unary(UnaryOp, Box<Expr>),
    /// An operator with two operands.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `if c then a else b`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
}

impl Expr {
    /// `true`
    pub const TRUE: Self = Self::Const(1);
    /// `false`
    pub const FALSE: Self = Self::Const(0);

    /// Returns the current value of a variable.
    pub fn now(var: VarId) -> Self {
        Self::Var(var, Time::Now)
    }

    /// Returns the next value of a variable.
    pub fn next(var: VarId) -> Self {
        Self::Var(var, Time::Next)
    }

    /// Returns the boolean negation.
    #[must_use]
    #[expect(
        clippy::should_implement_trait,
        reason = "`not` is the usual name in logic"
    )]
    pub fn not(self) -> Self {
        Self::Unary(UnaryOp::Not, Box::new(self))
    }

    /// Applies an operator with two operands.
    pub fn binary(op: BinaryOp, a: Self, b: Self) -> Self {
        Self::Binary(op, Box::new(a), Box::new(b))
    }

    /// Returns the boolean and.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::binary(BinaryOp::And, self, other)
    }

    /// Returns the boolean or.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::binary(BinaryOp::Or, self, other)
    }

    /// Returns the boolean implication.
    #[must_use]
    pub fn implies(self, other: Self) -> Self {
        Self::binary(BinaryOp::Implies, self, other)
    }

    /// Returns the equality.
    #[must_use]
    pub fn equals(self, other: Self) -> Self {
        Self::binary(BinaryOp::Eq, self, other)
    }

    /// Calls `visit` once for every occurrence of a variable.
    pub fn for_each_var(&self, visit: &mut impl FnMut(VarId, Time)) {
        match self {
            Self::Const(_) => {}
            Self::Var(v, t) => visit(*v, *t),
            Self::Unary(_, a) => a.for_each_var(visit),
            Self::Binary(_, a, b) => {
                a.for_each_var(visit);
                b.for_each_var(visit);
            }
            Self::If(c, a, b) => {
                c.for_each_var(visit);
                a.for_each_var(visit);
                b.for_each_var(visit);
            }
        }
    }

    /// Returns the conjuncts of the expression, from left to right, with nested conjunctions
    /// flattened. An expression that is not a conjunction is its own only conjunct.
    pub fn conjuncts(&self) -> Vec<&Self> {
        let mut found = Vec::new();
        let mut left = vec![self];
        while let Some(expr) = left.pop() {
            match expr {
                Self::Binary(BinaryOp::And, a, b) => left.extend([&**b, &**a]),
                _ => found.push(expr),
            }
        }
        found
    }

    /// Returns expressions whose conjunction is equivalent to this one: its conjuncts, where an
    /// implication of a conjunction becomes one implication for each part of that conjunction:
    /// `a -> b and c` becomes `a -> b` and `a -> c`.
    pub fn parts(&self) -> Vec<Self> {
        let mut found = Vec::new();
        for conjunct in self.conjuncts() {
            match conjunct {
                Self::Binary(BinaryOp::Implies, a, b) => {
                    let parts = b.parts().into_iter();
                    found.extend(parts.map(|part| (**a).clone().implies(part)));
                }
                _ => found.push(conjunct.clone()),
            }
        }
        found
    }

    /// Returns whether the expression reads a next value.
    pub fn mentions_next(&self) -> bool {
        let mut found = false;
        self.for_each_var(&mut |_, t| found |= t == Time::Next);
        found
    }

    /// Returns the expression with every occurrence of a variable replaced by the result of
    /// `replace`.
    #[must_use]
    pub fn substitute(&self, replace: &mut impl FnMut(VarId, Time) -> Self) -> Self {
        match self {
            Self::Const(c) => Self::Const(*c),
            Self::Var(v, t) => replace(*v, *t),
            Self::Unary(op, a) => Self::Unary(*op, Box::new(a.substitute(replace))),
            Self::Binary(op, a, b) => Self::Binary(
                *op,
                Box::new(a.substitute(replace)),
                Box::new(b.substitute(replace)),
            ),
            Self::If(c, a, b) => Self::If(
                Box::new(c.substitute(replace)),
                Box::new(a.substitute(replace)),
                Box::new(b.substitute(replace)),
            ),
        }
    }

    /// Folds constants without changing the value: operators with constant operands, connectives
    /// that one operand decides, and choices with a constant condition or equal branches.
    /// Arithmetic whose result does not fit into an `i64`, or that divides by zero, is left
    /// unchanged.
    #[must_use]
    pub fn simplify(&self) -> Self {
        use BinaryOp as B;
        match self {
            Self::Const(_) | Self::Var(..) => self.clone(),
            Self::Unary(op, a) => match a.simplify() {
                Self::Const(a) if a != i64::MIN => Self::Const(super::eval::unary(*op, a)),
                a => Self::Unary(*op, Box::new(a)),
            },
            Self::If(c, a, b) => match c.simplify() {
                Self::Const(0) => b.simplify(),
                Self::Const(_) => a.simplify(),
                c => {
                    let (a, b) = (a.simplify(), b.simplify());
                    if a == b {
                        a
                    } else {
                        Self::If(Box::new(c), Box::new(a), Box::new(b))
                    }
                }
            },
            Self::Binary(op, a, b) => {
                let a = a.simplify();
                match (op, &a) {
                    (B::And, Self::Const(0)) => return Self::FALSE,
                    (B::Or, Self::Const(1)) | (B::Implies, Self::Const(0)) => return Self::TRUE,
                    (B::And | B::Implies, Self::Const(1)) | (B::Or, Self::Const(0)) => {
                        return b.simplify();
                    }
                    _ => {}
                }
                let b = b.simplify();
                match (op, &a, &b) {
                    (B::And, _, Self::Const(0)) => Self::FALSE,
                    (B::Or | B::Implies, _, Self::Const(1)) => Self::TRUE,
                    (B::And, _, Self::Const(1)) | (B::Or, _, Self::Const(0)) => a,
                    (B::Eq | B::Le | B::Ge, _, _) if a == b => Self::TRUE,
                    (B::Ne | B::Lt | B::Gt, _, _) if a == b => Self::FALSE,
                    (_, Self::Const(x), Self::Const(y)) => super::eval::checked(*op, *x, *y)
                        .map_or_else(|| Self::binary(*op, a, b), Self::Const),
                    _ => Self::binary(*op, a, b),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_implication_of_a_conjunction_has_parts() {
        let var = |v| Expr::Var(VarId(v), Time::Now);
        let [a, b, c, d] = [0, 1, 2, 3].map(var);
        let nested = a
            .clone()
            .implies(b.clone().implies(c.clone().and(d.clone())));
        let both = nested.and(a.clone().or(b.clone()));
        let parts = [
            a.clone().implies(b.clone().implies(c)),
            a.clone().implies(b.clone().implies(d)),
            a.or(b),
        ];
        assert_eq!(both.parts(), parts);
    }
}
