//! The meaning of an expression, by direct evaluation.

use super::{BinaryOp, Expr, Time, UnaryOp};

/// The value of `expr` where variable `v` has the value `now[v]` and the next value `next[v]`.
///
/// An expression without next values may be given an empty `next`. Arithmetic is exact as long as the value fits an `i64`,
/// which [`interval`](super::interval) checks beforehand.
pub fn eval(expr: &Expr, now: &[i64], next: &[i64]) -> i64 {
    match expr {
        Expr::Const(c) => *c,
        Expr::Var(v, Time::Now) => now[v.index()],
        Expr::Var(v, Time::Next) => next[v.index()],
        Expr::Unary(op, a) => unary(*op, eval(a, now, next)),
        Expr::Binary(BinaryOp::And, a, b) => {
            i64::from(eval(a, now, next) != 0 && eval(b, now, next) != 0)
        }
        Expr::Binary(BinaryOp::Or, a, b) => {
            i64::from(eval(a, now, next) != 0 || eval(b, now, next) != 0)
        }
        Expr::Binary(BinaryOp::Implies, a, b) => {
            i64::from(eval(a, now, next) == 0 || eval(b, now, next) != 0)
        }
        Expr::Binary(op, a, b) => binary(*op, eval(a, now, next), eval(b, now, next)),
        Expr::If(c, a, b) => {
            if eval(c, now, next) != 0 {
                eval(a, now, next)
            } else {
                eval(b, now, next)
            }
        }
    }
}

/// Whether a boolean expression holds.
pub fn holds(expr: &Expr, now: &[i64], next: &[i64]) -> bool {
    eval(expr, now, next) != 0
}

/// One operator applied to a value.
pub fn unary(op: UnaryOp, a: i64) -> i64 {
    match op {
        UnaryOp::Not => i64::from(a == 0),
        UnaryOp::Neg => -a,
        UnaryOp::Abs => a.abs(),
    }
}

/// One operator applied to two values.
pub fn binary(op: BinaryOp, a: i64, b: i64) -> i64 {
    match op {
        BinaryOp::And => i64::from(a != 0 && b != 0),
        BinaryOp::Or => i64::from(a != 0 || b != 0),
        BinaryOp::Implies => i64::from(a == 0 || b != 0),
        BinaryOp::Eq => i64::from(a == b),
        BinaryOp::Ne => i64::from(a != b),
        BinaryOp::Lt => i64::from(a < b),
        BinaryOp::Le => i64::from(a <= b),
        BinaryOp::Gt => i64::from(a > b),
        BinaryOp::Ge => i64::from(a >= b),
        BinaryOp::Add => a + b,
        BinaryOp::Sub => a - b,
        BinaryOp::Mul => a * b,
        BinaryOp::Div => floor_div(a, b),
        BinaryOp::Mod => a - b * floor_div(a, b),
        BinaryOp::Min => a.min(b),
        BinaryOp::Max => a.max(b),
    }
}

/// Division rounded towards minus infinity.
pub fn floor_div(a: i64, b: i64) -> i64 {
    let q = a / b;
    if a % b != 0 && (a < 0) != (b < 0) {
        q - 1
    } else {
        q
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn division_rounds_down_and_the_rest_has_the_divisors_sign() {
        for a in -7..=7 {
            for b in [-3, -2, -1, 1, 2, 3] {
                let (q, r) = (binary(BinaryOp::Div, a, b), binary(BinaryOp::Mod, a, b));
                assert_eq!(q * b + r, a);
                assert!(r == 0 || (r < 0) == (b < 0), "{a} mod {b} = {r}");
                assert!(r.abs() < b.abs());
            }
        }
    }
}
