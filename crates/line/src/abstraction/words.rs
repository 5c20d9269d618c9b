//! Shorthands for building expressions.

use linewright_core::gr1::{BinaryOp, Expr, Time, VarId};

/// A name with its indefinite article: `an Axle`, `a Plate`.
pub(crate) fn an(name: &str) -> String {
    let vowel = name.starts_with(['A', 'E', 'I', 'O', 'a', 'e', 'i', 'o']);
    format!("{} {name}", if vowel { "an" } else { "a" })
}

/// The variable has this value now.
pub(crate) fn is(variable: VarId, value: usize) -> Expr {
    Expr::now(variable).equals(Expr::Const(value as i64))
}

/// The variable has this value in the next step.
pub(crate) fn becomes(variable: VarId, value: usize) -> Expr {
    Expr::next(variable).equals(Expr::Const(value as i64))
}

/// The variable keeps its value.
pub(crate) fn stays(variable: VarId) -> Expr {
    Expr::next(variable).equals(Expr::now(variable))
}

/// The conjunction of these expressions; true if there are none.
pub(crate) fn all(parts: impl IntoIterator<Item = Expr>) -> Expr {
    parts.into_iter().reduce(Expr::and).unwrap_or(Expr::TRUE)
}

/// The disjunction of these expressions; false if there are none.
pub(crate) fn any(parts: impl IntoIterator<Item = Expr>) -> Expr {
    parts.into_iter().reduce(Expr::or).unwrap_or(Expr::FALSE)
}

/// The number of these conditions that hold.
pub(crate) fn count(parts: impl IntoIterator<Item = Expr>) -> Expr {
    let one = |e| {
        Expr::If(
            Box::new(e),
            Box::new(Expr::Const(1)),
            Box::new(Expr::Const(0)),
        )
    };
    sum(parts.into_iter().map(one))
}

/// The sum of these expressions; 0 if there are none.
pub(crate) fn sum(parts: impl IntoIterator<Item = Expr>) -> Expr {
    let add = |a, b| Expr::binary(BinaryOp::Add, a, b);
    parts.into_iter().reduce(add).unwrap_or(Expr::Const(0))
}

/// The first of these values whose condition holds, or else `otherwise`.
pub(crate) fn choose(cases: Vec<(Expr, Expr)>, otherwise: Expr) -> Expr {
    let case = |rest, (c, v)| Expr::If(Box::new(c), Box::new(v), Box::new(rest));
    cases.into_iter().rev().fold(otherwise, case)
}

/// A number clamped to the range from 0 to `most`.
pub(crate) fn within(number: Expr, most: i64) -> Expr {
    let low = Expr::binary(BinaryOp::Max, Expr::Const(0), number);
    Expr::binary(BinaryOp::Min, Expr::Const(most), low)
}

/// The same expression one step later.
pub(crate) fn later(expr: &Expr) -> Expr {
    expr.substitute(&mut |v, _| Expr::Var(v, Time::Next))
}
