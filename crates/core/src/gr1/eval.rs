//! Direct evaluation of expressions.

use super::{BinaryOp, Expr, Time, UnaryOp};

/// Evaluates `expr`, where variable `v` has the current value `now[v]` and the next value
/// `next[v]`.
///
/// `next` can be empty if the expression has no next values. Arithmetic is exact as long as every
/// result fits into an `i64`, which [`interval`](super::interval) checks beforehand.
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

/// Returns whether a boolean expression holds.
pub fn holds(expr: &Expr, now: &[i64], next: &[i64]) -> bool {
    eval(expr, now, next) != 0
}

/// Applies an operator to a value.
pub fn unary(op: UnaryOp, a: i64) -> i64 {
    match op {
        UnaryOp::Not => i64::from(a == 0),
        UnaryOp::Neg => -a,
        UnaryOp::Abs => a.abs(),
    }
}

/// Applies an operator to two values.
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

/// Like [`binary`], but returns `None` if the result does not fit into an `i64` or the divisor is
/// 0.
pub fn checked(op: BinaryOp, a: i64, b: i64) -> Option<i64> {
    match op {
        BinaryOp::Add => a.checked_add(b),
        BinaryOp::Sub => a.checked_sub(b),
        BinaryOp::Mul => a.checked_mul(b),
        BinaryOp::Div | BinaryOp::Mod if b == 0 || (a, b) == (i64::MIN, -1) => None,
        BinaryOp::Mod => a.checked_sub(b.checked_mul(floor_div(a, b))?),
        _ => Some(binary(op, a, b)),
    }
}

/// Divides and rounds towards minus infinity.
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
    fn division_rounds_down_and_the_remainder_has_the_sign_of_the_divisor() {
        for a in -7..=7 {
            for b in [-3, -2, -1, 1, 2, 3] {
                let (q, r) = (binary(BinaryOp::Div, a, b), binary(BinaryOp::Mod, a, b));
                assert_eq!(q * b + r, a);
                assert!(r == 0 || (r < 0) == (b < 0), "{a} mod {b} = {r}");
                assert!(r.abs() < b.abs());
            }
        }
    }
    #[test]
    fn checked_arithmetic_is_exact_or_none() {
        let numbers = [
            i64::MIN,
            i64::MIN + 1,
            -(1 << 40),
            -(1 << 31),
            -7,
            -1,
            0,
            1,
            3,
            (1 << 31) - 1,
            1 << 31,
            (1 << 31) + 1,
            1 << 40,
            i64::MAX,
        ];
        for a in numbers {
            for b in numbers {
                let (x, y) = (i128::from(a), i128::from(b));
                for (op, exact) in [
                    (BinaryOp::Add, x + y),
                    (BinaryOp::Sub, x - y),
                    (BinaryOp::Mul, x * y),
                    (BinaryOp::Eq, i128::from(x == y)),
                    (BinaryOp::Lt, i128::from(x < y)),
                    (BinaryOp::Min, x.min(y)),
                ] {
                    assert_eq!(
                        checked(op, a, b),
                        i64::try_from(exact).ok(),
                        "{a} {op:?} {b}"
                    );
                }
                for op in [BinaryOp::Div, BinaryOp::Mod] {
                    let known = checked(op, a, b);
                    assert!(b != 0 || known.is_none());
                    if let Some(known) = known {
                        assert_eq!(known, binary(op, a, b), "{a} {op:?} {b}");
                    }
                }
            }
        }
    }
}
