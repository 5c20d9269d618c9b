//! The bits of each variable, and expressions as functions of those bits.
//!
//! A variable with `n` values has ⌈log2 n⌉ pairs of bits, with the most significant pair on top.
//! They hold the *code* of its value: the value minus the smallest value of the domain. If `n` is
//! not a power of two, some codes stand for no value. The result of an encoded formula on such
//! codes is undefined; callers exclude them with [`Encoding::in_domain`].

use super::bits::{Number, width};
use super::{Bit, BitSet, Kernel, Limit};
use linewright_core::gr1::interval::{Interval, interval};
use linewright_core::gr1::{BinaryOp, Expr, Specification, Time, UnaryOp, VarId};

/// The bits of one variable.
#[derive(Debug, Clone)]
struct Layout {
    low: i64,
    high: i64,
    /// Current bits, most significant first.
    bits: Vec<Bit>,
}

/// The bits of all variables of a specification.
#[derive(Debug, Clone)]
pub struct Encoding {
    variables: Vec<Layout>,
    pairs: usize,
}

impl Encoding {
    /// Assigns bits to the variables in declaration order.
    pub fn new(specification: &Specification) -> Self {
        let mut pairs = 0;
        let variables = specification
            .variables
            .iter()
            .map(|v| {
                let count = (u64::BITS - (v.domain.size() - 1).leading_zeros()) as usize;
                let bits = (pairs..pairs + count)
                    .map(|p| Bit((2 * p) as u16))
                    .collect();
                pairs += count;
                Layout {
                    low: v.domain.low(),
                    high: v.domain.high(),
                    bits,
                }
            })
            .collect();
        Self { variables, pairs }
    }

    /// Total number of pairs of bits, over all variables.
    pub fn pairs(&self) -> usize {
        self.pairs
    }

    /// The bits of a variable, most significant first.
    pub fn bits(&self, var: VarId, time: Time) -> impl Iterator<Item = Bit> {
        let bits = self.variables[var.index()].bits.iter();
        bits.map(move |b| at(*b, time))
    }

    /// The set of all bits of these variables at the given time.
    pub fn bit_set(&self, vars: impl IntoIterator<Item = VarId>, time: Time) -> BitSet {
        BitSet::new(vars.into_iter().flat_map(|v| self.bits(v, time)))
    }

    /// The bits of a variable, each with the value that it has in the code of `value`; most
    /// significant bit first.
    pub fn assignment(&self, var: VarId, time: Time, value: i64) -> Vec<(Bit, bool)> {
        let layout = &self.variables[var.index()];
        let code = (value - layout.low) as u64;
        let count = layout.bits.len();
        let bits = layout.bits.iter().enumerate();
        bits.map(|(i, b)| (at(*b, time), code >> (count - 1 - i) & 1 == 1))
            .collect()
    }

    /// Decodes the value of a variable. `bits` holds the values of all bits, indexed by [`Bit`].
    pub fn value(&self, var: VarId, time: Time, bits: &[bool]) -> i64 {
        let layout = &self.variables[var.index()];
        let code = layout.bits.iter().fold(0i64, |code, bit| {
            code << 1 | i64::from(bits[usize::from(at(*bit, time).0)])
        });
        layout.low + code
    }

    /// Returns the codes that stand for a value of the variable.
    pub fn in_domain<K: Kernel>(
        &self,
        m: &K,
        var: VarId,
        time: Time,
    ) -> Result<K::Function, Limit> {
        let layout = &self.variables[var.index()];
        let values = (layout.high - layout.low + 1) as u64;
        if values.is_power_of_two() {
            return Ok(m.constant(true));
        }
        let last = Number::constant(m, layout.high - layout.low);
        m.not(&last.less(m, &code(m, layout, time))?)
    }

    /// Returns the steps in which the variable keeps its value.
    pub fn unchanged<K: Kernel>(&self, m: &K, var: VarId) -> Result<K::Function, Limit> {
        let mut result = m.constant(true);
        for bit in self.variables[var.index()].bits.iter().rev() {
            let same = m.iff(&m.literal(*bit, true), &m.literal(bit.primed(), true))?;
            result = m.and(&result, &same)?;
        }
        Ok(result)
    }

    /// Encodes a formula: the valuations on which the expression is not 0.
    ///
    /// Returns [`Limit::Size`] if arithmetic could exceed 64 bits or divide by 0. Files with such
    /// arithmetic are rejected earlier, during resolution.
    pub fn formula<K: Kernel>(&self, m: &K, expr: &Expr) -> Result<K::Function, Limit> {
        self.check(expr)?;
        self.truth(m, expr)
    }

    /// Returns the valuations on which the expression equals `value`; for tests.
    #[cfg(test)]
    pub(super) fn has_value<K: Kernel>(
        &self,
        m: &K,
        expr: &Expr,
        value: i64,
    ) -> Result<K::Function, Limit> {
        self.check(expr)?;
        self.number(m, expr)?.equal(m, &Number::constant(m, value))
    }

    fn check(&self, expr: &Expr) -> Result<(), Limit> {
        self.interval(expr).map(|_| ())
    }

    fn interval(&self, expr: &Expr) -> Result<Interval, Limit> {
        let domain = |v: VarId| {
            let layout = &self.variables[v.index()];
            Interval {
                low: layout.low,
                high: layout.high,
            }
        };
        interval(expr, &domain).map_err(|_| Limit::Size)
    }

    fn truth<K: Kernel>(&self, m: &K, expr: &Expr) -> Result<K::Function, Limit> {
        // Allows the kernel to reorder before the whole formula is encoded in a bad order.
        m.safe_point()?;
        match expr {
            Expr::Const(c) => Ok(m.constant(*c != 0)),
            Expr::Unary(UnaryOp::Not, a) => m.not(&self.truth(m, a)?),
            Expr::If(c, a, b) => m.ite(&self.truth(m, c)?, &self.truth(m, a)?, &self.truth(m, b)?),
            Expr::Binary(op, a, b) => match op {
                BinaryOp::And => m.and(&self.truth(m, a)?, &self.truth(m, b)?),
                BinaryOp::Or => m.or(&self.truth(m, a)?, &self.truth(m, b)?),
                BinaryOp::Implies => m.implies(&self.truth(m, a)?, &self.truth(m, b)?),
                BinaryOp::Eq => self.number(m, a)?.equal(m, &self.number(m, b)?),
                BinaryOp::Ne => m.not(&self.number(m, a)?.equal(m, &self.number(m, b)?)?),
                BinaryOp::Lt => self.number(m, a)?.less(m, &self.number(m, b)?),
                BinaryOp::Gt => self.number(m, b)?.less(m, &self.number(m, a)?),
                BinaryOp::Le => m.not(&self.number(m, b)?.less(m, &self.number(m, a)?)?),
                BinaryOp::Ge => m.not(&self.number(m, a)?.less(m, &self.number(m, b)?)?),
                _ => self.number(m, expr)?.non_zero(m),
            },
            _ => self.number(m, expr)?.non_zero(m),
        }
    }

    fn number<K: Kernel>(&self, m: &K, expr: &Expr) -> Result<Number<K>, Limit> {
        let result = match expr {
            Expr::Const(c) => return Ok(Number::constant(m, *c)),
            Expr::Var(v, time) => {
                let layout = &self.variables[v.index()];
                let code = code(m, layout, *time);
                if layout.low == 0 {
                    code
                } else {
                    code.add(m, &Number::constant(m, layout.low))?
                }
            }
            Expr::Unary(UnaryOp::Neg, a) => self.number(m, a)?.neg(m)?,
            Expr::Unary(UnaryOp::Abs, a) => self.number(m, a)?.abs(m)?,
            Expr::If(c, a, b) => Number::ite(
                m,
                &self.truth(m, c)?,
                &self.number(m, a)?,
                &self.number(m, b)?,
            )?,
            Expr::Binary(
                op @ (BinaryOp::Add
                | BinaryOp::Sub
                | BinaryOp::Mul
                | BinaryOp::Div
                | BinaryOp::Mod
                | BinaryOp::Min
                | BinaryOp::Max),
                a,
                b,
            ) => {
                let (a, b) = (self.number(m, a)?, self.number(m, b)?);
                match op {
                    BinaryOp::Add => a.add(m, &b)?,
                    BinaryOp::Sub => a.sub(m, &b)?,
                    BinaryOp::Mul => a.mul(m, &b)?,
                    BinaryOp::Div => a.div_mod(m, &b)?.0,
                    BinaryOp::Mod => a.div_mod(m, &b)?.1,
                    BinaryOp::Min => Number::ite(m, &a.less(m, &b)?, &a, &b)?,
                    _ => Number::ite(m, &a.less(m, &b)?, &b, &a)?,
                }
            }
            Expr::Unary(UnaryOp::Not, _) | Expr::Binary(..) => {
                return Ok(Number::boolean(m, self.truth(m, expr)?));
            }
        };
        let range = self.interval(expr)?;
        Ok(result.resize(width(range.low, range.high)))
    }
}

/// The bits of a variable as an unsigned number.
fn code<K: Kernel>(m: &K, layout: &Layout, time: Time) -> Number<K> {
    let mut bits: Vec<_> = layout
        .bits
        .iter()
        .rev()
        .map(|b| m.literal(at(*b, time), true))
        .collect();
    bits.push(m.constant(false));
    Number::new(bits)
}

fn at(bit: Bit, time: Time) -> Bit {
    match time {
        Time::Now => bit,
        Time::Next => bit.primed(),
    }
}
