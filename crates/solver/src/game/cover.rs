//! Converts a set of inputs to disjoint cubes of intervals. The function of the set is split
//! variable by variable, not bit by bit.
//!
//! Adjacent values with the same remaining function form one interval, so that a cube is `2 <=
//! desired <= 4` instead of three bit patterns. Codes that stand for no value are ignored. Inputs
//! are split in the order of the specification, independent of the variable order of the diagrams.

use crate::symbolic::{Bit, Encoding, Kernel, Limit};
use linewright_core::gr1::{Specification, Time, VarId};

/// One condition of a cube: index of the input, smallest and largest value.
pub type Condition = (usize, i64, i64);

/// Converts sets of next inputs (or outputs) to cubes.
pub struct Cover<'a, K: Kernel> {
    kernel: &'a K,
    inputs: Vec<Input>,
}

struct Input {
    bits: Vec<Bit>,
    low: i64,
    high: i64,
}

impl<'a, K: Kernel> Cover<'a, K> {
    /// Creates a cover over the inputs of a specification.
    pub fn new(kernel: &'a K, encoding: &Encoding, specification: &Specification) -> Self {
        Self::of(kernel, encoding, specification, specification.inputs())
    }

    /// Creates a cover over the outputs of a specification, which are the inputs of a
    /// counterstrategy.
    pub fn of_outputs(kernel: &'a K, encoding: &Encoding, specification: &Specification) -> Self {
        Self::of(kernel, encoding, specification, specification.outputs())
    }

    fn of(
        kernel: &'a K,
        encoding: &Encoding,
        specification: &Specification,
        variables: impl Iterator<Item = VarId>,
    ) -> Self {
        let input = |v: VarId| Input {
            bits: encoding.bits(v, Time::Next).collect(),
            low: specification.variable(v).domain.low(),
            high: specification.variable(v).domain.high(),
        };
        Self {
            kernel,
            inputs: variables.map(input).collect(),
        }
    }

    /// Returns the cubes of a function over the bits of the next inputs, or [`Limit::Size`] if
    /// there are more than `max`.
    pub fn cubes(&self, set: &K::Function, max: usize) -> Result<Vec<Vec<Condition>>, Limit> {
        let mut found = Vec::new();
        self.walk(set, 0, &mut Vec::new(), &mut found, max)?;
        Ok(found)
    }

    fn walk(
        &self,
        set: &K::Function,
        index: usize,
        path: &mut Vec<Condition>,
        found: &mut Vec<Vec<Condition>>,
        max: usize,
    ) -> Result<(), Limit> {
        if self.kernel.is_false(set) {
            return Ok(());
        }
        let support = self.kernel.support(set);
        let is_tested = |input: &Input| input.bits.iter().any(|b| support.contains(b));
        let next = self.inputs[index..].iter().position(is_tested);
        let Some(index) = next.map(|n| index + n) else {
            if found.len() >= max {
                return Err(Limit::Size);
            }
            found.push(path.clone());
            return Ok(());
        };
        let input = &self.inputs[index];
        let mut pieces: Vec<(i64, i64, K::Function)> = Vec::new();
        self.split(set, input, 0, 0, &mut pieces)?;
        for (low, high, rest) in pieces {
            let whole = low == input.low && high == input.high;
            if !whole {
                path.push((index, low, high));
            }
            self.walk(&rest, index + 1, path, found, max)?;
            if !whole {
                path.pop();
            }
        }
        Ok(())
    }

    /// Splits the set by the values of one input, ascending, into pieces: smallest value, largest
    /// value, and the remaining function. Adjacent values with the same remaining function form one
    /// piece.
    fn split(
        &self,
        set: &K::Function,
        input: &Input,
        depth: usize,
        code: i64,
        pieces: &mut Vec<(i64, i64, K::Function)>,
    ) -> Result<(), Limit> {
        let left = input.bits.len() - depth;
        let low = input.low + (code << left);
        let high = (low + (1 << left) - 1).min(input.high);
        if low > input.high {
            return Ok(());
        }
        let support = self.kernel.support(set);
        if input.bits[depth..].iter().any(|b| support.contains(b)) {
            for bit in [false, true] {
                let half = self.kernel.restrict(set, &[(input.bits[depth], bit)])?;
                self.split(&half, input, depth + 1, code << 1 | i64::from(bit), pieces)?;
            }
            return Ok(());
        }
        match pieces.last_mut() {
            Some((_, last, rest)) if *last + 1 == low && rest == set => *last = high,
            _ => pieces.push((low, high, set.clone())),
        }
        Ok(())
    }
}
