//! Two's complement numbers whose bits are boolean functions.
//!
//! Every operation returns a result wide enough to be exact; the caller resizes it to the width
//! given by interval arithmetic. Division is long division on absolute values, rounded toward minus
//! infinity.

use super::{Kernel, Limit};

/// A number: its bits from the least significant one to the sign. Never empty.
#[derive(Debug, Clone)]
pub struct Number<K: Kernel>(Vec<K::Function>);

/// Returns the sum bit and the carry of three bits.
fn full_add<K: Kernel>(
    m: &K,
    a: &K::Function,
    b: &K::Function,
    carry: &K::Function,
) -> Result<(K::Function, K::Function), Limit> {
    let half = m.xor(a, b)?;
    let sum = m.xor(&half, carry)?;
    let carry = m.or(&m.and(a, b)?, &m.and(&half, carry)?)?;
    Ok((sum, carry))
}

/// Returns how many bits, including the sign, are needed for the values `low..=high`.
pub fn width(low: i64, high: i64) -> usize {
    let needed = |v: i64| 65 - (if v < 0 { !v } else { v }).leading_zeros() as usize;
    needed(low).max(needed(high))
}

impl<K: Kernel> Number<K> {
    /// Creates a number from its bits, the sign last.
    pub fn new(bits: Vec<K::Function>) -> Self {
        debug_assert!(!bits.is_empty());
        Self(bits)
    }

    /// Creates a constant.
    pub fn constant(m: &K, value: i64) -> Self {
        let bits = (0..width(value, value)).map(|i| m.constant(value >> i.min(63) & 1 == 1));
        Self(bits.collect())
    }

    /// Creates the number 0 or 1 from a condition.
    pub fn boolean(m: &K, value: K::Function) -> Self {
        Self(vec![value, m.constant(false)])
    }

    fn sign(&self) -> &K::Function {
        &self.0[self.0.len() - 1]
    }

    fn bit(&self, i: usize) -> &K::Function {
        self.0.get(i).unwrap_or_else(|| self.sign())
    }

    /// Returns the number with `width` bits; the value must fit.
    pub fn resize(&self, width: usize) -> Self {
        Self((0..width).map(|i| self.bit(i).clone()).collect())
    }

    /// Returns the valuations on which the number is not 0.
    pub fn non_zero(&self, m: &K) -> Result<K::Function, Limit> {
        let mut result = m.constant(false);
        for bit in &self.0 {
            result = m.or(&result, bit)?;
        }
        Ok(result)
    }

    fn add_with(&self, m: &K, b: &Self, carry: bool, flip: bool) -> Result<Self, Limit> {
        let width = self.0.len().max(b.0.len()) + 1;
        let mut carry = m.constant(carry);
        let mut bits = Vec::with_capacity(width);
        for i in 0..width {
            let other = if flip {
                m.not(b.bit(i))?
            } else {
                b.bit(i).clone()
            };
            let (sum, next) = full_add(m, self.bit(i), &other, &carry)?;
            bits.push(sum);
            carry = next;
        }
        Ok(Self(bits))
    }

    /// `a + b`
    pub fn add(&self, m: &K, b: &Self) -> Result<Self, Limit> {
        self.add_with(m, b, false, false)
    }

    /// `a - b`
    pub fn sub(&self, m: &K, b: &Self) -> Result<Self, Limit> {
        self.add_with(m, b, true, true)
    }

    /// `-a`
    pub fn neg(&self, m: &K) -> Result<Self, Limit> {
        Self::constant(m, 0).sub(m, self)
    }

    /// `|a|`
    pub fn abs(&self, m: &K) -> Result<Self, Limit> {
        let negated = self.neg(m)?;
        Self::ite(m, self.sign(), &negated, self)
    }

    /// `self * b`: the sum of shifted copies of `self`, one for each set bit of `b`, modulo 2^w,
    /// where w is the width of the result. In two's complement, w bits hold the exact product.
    pub fn mul(&self, m: &K, b: &Self) -> Result<Self, Limit> {
        let width = self.0.len() + b.0.len();
        let mut result = Self::constant(m, 0).resize(width);
        for i in 0..width {
            let chosen = b.bit(i);
            let mut row = vec![m.constant(false); i];
            for k in 0..width - i {
                row.push(m.and(self.bit(k), chosen)?);
            }
            result = result.add(m, &Self(row))?.resize(width);
        }
        Ok(result)
    }

    /// `a / b` and `a mod b`, rounded toward minus infinity; undefined where `b` is 0.
    pub fn div_mod(&self, m: &K, b: &Self) -> Result<(Self, Self), Limit> {
        let (dividend, divisor) = (self.abs(m)?, b.abs(m)?);
        let width = dividend.0.len();
        let mut rest = Self::constant(m, 0).resize(divisor.0.len() + 1);
        let mut quotient = vec![m.constant(false); width + 1];
        for i in (0..width).rev() {
            let mut shifted = vec![dividend.0[i].clone()];
            shifted.extend(rest.0.iter().take(divisor.0.len()).cloned());
            let shifted = Self(shifted);
            let fits = m.not(&shifted.less(m, &divisor)?)?;
            let reduced = shifted.sub(m, &divisor)?;
            rest = Self::ite(m, &fits, &reduced, &shifted)?.resize(divisor.0.len() + 1);
            quotient[i] = fits;
        }
        let quotient = Self(quotient);

        // |a| = q·|b| + r. With equal signs the quotient is q. With different signs it is -q, minus
        // one if r is not 0.
        let differ = m.xor(self.sign(), b.sign())?;
        let inexact = rest.non_zero(m)?;
        let correct = m.and(&differ, &inexact)?;
        let one_less = Self::boolean(m, correct);
        let negated = quotient.neg(m)?.sub(m, &one_less)?;
        let floor = Self::ite(m, &differ, &negated, &quotient)?;
        let rest = self.sub(m, &floor.mul(m, b)?)?.resize(b.0.len() + 1);
        Ok((floor, rest))
    }

    /// `a = b`
    pub fn equal(&self, m: &K, b: &Self) -> Result<K::Function, Limit> {
        let mut result = m.constant(true);
        for i in 0..self.0.len().max(b.0.len()) {
            result = m.and(&result, &m.iff(self.bit(i), b.bit(i))?)?;
        }
        Ok(result)
    }

    /// `a < b`, compared from the least significant bit up.
    pub fn less(&self, m: &K, b: &Self) -> Result<K::Function, Limit> {
        let width = self.0.len().max(b.0.len());
        let mut result = m.constant(false);
        for i in 0..width {
            let (mut high, mut low) = (b.bit(i), self.bit(i));
            if i == width - 1 {
                (high, low) = (low, high); // The number whose sign is set is smaller.
            }
            let equal = m.iff(high, low)?;
            let above = m.and_not(high, low)?;
            result = m.or(&above, &m.and(&equal, &result)?)?;
        }
        Ok(result)
    }

    /// `if c then a else b`
    pub fn ite(m: &K, c: &K::Function, a: &Self, b: &Self) -> Result<Self, Limit> {
        let width = a.0.len().max(b.0.len());
        let bits: Result<_, _> = (0..width).map(|i| m.ite(c, a.bit(i), b.bit(i))).collect();
        bits.map(Self)
    }
}
