//! Gates over the bits of numbers, for formats with Boolean variables only.
//!
//! The bits of a number hold its distance from the smallest value of its domain.

use super::gates::{Gate, Gates, Shape};
use linewright_core::gr1::{Domain, Specification, Time, VarId};
use std::collections::BTreeMap;

/// Number of bits of a variable.
pub(super) fn width(domain: &Domain) -> u32 {
    u64::BITS - (domain.size() - 1).leading_zeros()
}

/// Whether some bit patterns stand for no value of the domain.
pub(super) fn has_holes(domain: &Domain) -> bool {
    domain.size() != 1 << width(domain)
}

impl Gates {
    /// The gate that is true if the bits of a variable hold a value of its domain.
    pub fn in_domain(&mut self, domain: &Domain, v: VarId, time: Time) -> Gate {
        self.at_most(domain, v, time, domain.size() - 1)
    }

    /// The gate that is true if the bits hold a number of at most `bound`.
    ///
    /// It is built from the lowest bit up. The bits so far are at most those of `bound` in two
    /// cases: the current bit is smaller than that of `bound`, or the two are equal and the lower
    /// bits are at most those of `bound`.
    fn at_most(&mut self, domain: &Domain, v: VarId, time: Time, bound: u64) -> Gate {
        let mut gate = self.bool(true);
        for k in 0..width(domain) {
            let bit = self.bit(v, time, k);
            let unset = self.not(bit);
            gate = if bound >> k & 1 == 1 {
                self.or(unset, gate)
            } else {
                self.and(unset, gate)
            };
        }
        gate
    }

    fn at_least(&mut self, domain: &Domain, v: VarId, time: Time, bound: u64) -> Gate {
        match bound.checked_sub(1) {
            None => self.bool(true),
            Some(below) => {
                let gate = self.at_most(domain, v, time, below);
                self.not(gate)
            }
        }
    }

    /// Replaces the tests of values in a gate with tests of bits.
    pub fn in_bits(&mut self, specification: &Specification, root: Gate) -> Gate {
        let mut done: BTreeMap<Gate, Gate> = BTreeMap::new();
        // Gates are numbered after their operands.
        for gate in self.uses(root).into_keys() {
            let new = |g: Gate| done.get(&g).copied().unwrap_or(g);
            let made = match self.shape(gate) {
                Shape::Within(v, time, low, high) => {
                    let domain = &specification.variable(v).domain;
                    let from = |value: i64| (value - domain.low()) as u64;
                    let low = self.at_least(domain, v, time, from(low));
                    let high = self.at_most(domain, v, time, from(high));
                    self.and(low, high)
                }
                Shape::Not(a) => self.not(new(a)),
                Shape::And(a, b) => self.and(new(a), new(b)),
                Shape::Or(a, b) => self.or(new(a), new(b)),
                Shape::Xor(a, b) => self.xor(new(a), new(b)),
                Shape::Const(_) | Shape::Bit(..) => gate,
            };
            done.insert(gate, made);
        }
        done.get(&root).copied().unwrap_or(root)
    }
}
