//! Bounds for the values of an expression, by interval arithmetic.
//!
//! The bounds are sound but not exact: the true range lies within them. They are used to choose bit
//! widths, to reject arithmetic that could overflow an `i64` or divide by zero, and to find next
//! values that can leave their domain.

use super::{BinaryOp, Domain, Expr, UnaryOp, VarId};

/// A closed interval `low..=high`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// Lower bound.
    pub low: i64,
    /// Upper bound.
    pub high: i64,
}

impl Interval {
    /// Both truth values.
    pub const BOOL: Self = Self { low: 0, high: 1 };

    /// Returns the interval of a domain.
    pub fn of(domain: &Domain) -> Self {
        Self {
            low: domain.low(),
            high: domain.high(),
        }
    }

    /// Returns whether `value` lies within the interval.
    pub fn contains(self, value: i64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// Error for an expression whose interval cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalError {
    /// A value could be outside ±2^62.
    TooLarge,
    /// A divisor's range contains 0.
    DivisorZero,
}

const LIMIT: i128 = 1 << 62;

/// Computes the interval of `expr`. `domain` gives the interval of each variable, for current and
/// next values alike.
///
/// # Errors
/// If a subexpression could be too large, or a divisor could be 0.
pub fn interval(
    expr: &Expr,
    domain: &impl Fn(VarId) -> Interval,
) -> Result<Interval, IntervalError> {
    let make = |low: i128, high: i128| {
        if low < -LIMIT || high > LIMIT {
            Err(IntervalError::TooLarge)
        } else {
            Ok(Interval {
                low: low as i64,
                high: high as i64,
            })
        }
    };
    match expr {
        Expr::Const(c) => make(i128::from(*c), i128::from(*c)),
        Expr::Var(v, _) => Ok(domain(*v)),
        Expr::Unary(op, a) => {
            let a = interval(a, domain)?;
            let (l, h) = (i128::from(a.low), i128::from(a.high));
            match op {
                UnaryOp::Not => Ok(Interval::BOOL),
                UnaryOp::Neg => make(-h, -l),
                UnaryOp::Abs if l <= 0 && h >= 0 => make(0, h.max(-l)),
                UnaryOp::Abs => make(l.abs().min(h.abs()), l.abs().max(h.abs())),
            }
        }
        Expr::If(c, a, b) => {
            interval(c, domain)?;
            let (a, b) = (interval(a, domain)?, interval(b, domain)?);
            make(i128::from(a.low.min(b.low)), i128::from(a.high.max(b.high)))
        }
        Expr::Binary(op, a, b) => {
            let (a, b) = (interval(a, domain)?, interval(b, domain)?);
            let (al, ah) = (i128::from(a.low), i128::from(a.high));
            let (bl, bh) = (i128::from(b.low), i128::from(b.high));
            let hull = |v: [i128; 4]| {
                make(
                    v.into_iter().min().unwrap_or(0),
                    v.into_iter().max().unwrap_or(0),
                )
            };
            match op {
                BinaryOp::Add => make(al + bl, ah + bh),
                BinaryOp::Sub => make(al - bh, ah - bl),
                BinaryOp::Mul => hull([al * bl, al * bh, ah * bl, ah * bh]),
                BinaryOp::Div | BinaryOp::Mod if b.contains(0) => Err(IntervalError::DivisorZero),
                BinaryOp::Div => hull([
                    floor_div(al, bl),
                    floor_div(al, bh),
                    floor_div(ah, bl),
                    floor_div(ah, bh),
                ]),
                BinaryOp::Mod if bl > 0 => make(0, bh - 1),
                BinaryOp::Mod => make(bl + 1, 0),
                BinaryOp::Min => make(al.min(bl), ah.min(bh)),
                BinaryOp::Max => make(al.max(bl), ah.max(bh)),
                _ => Ok(Interval::BOOL),
            }
        }
    }
}

fn floor_div(a: i128, b: i128) -> i128 {
    let q = a / b;
    if a % b != 0 && (a < 0) != (b < 0) {
        q - 1
    } else {
        q
    }
}
