//! A set of inputs as disjoint cubes of intervals: the diagram is walked variable by variable, not bit by bit.
//!
//! Values next to each other that lead to the same rest go into one interval, so that a cube says `2 <= desired <= 4` and not
//! three bit patterns. Codes without a value are never looked at.

use crate::gr1::{Specification, Time, VarId};
use crate::symbolic::{Bit, Encoding, Function, Limit, Manager};

/// One condition: the input (by its place among the inputs), the smallest and the largest value.
pub type Condition = (usize, i64, i64);

/// Turns sets of next inputs into cubes.
pub struct Cover<'a> {
    manager: &'a Manager,
    inputs: Vec<Input>,
}

struct Input {
    bits: Vec<Bit>,
    low: i64,
    high: i64,
}

impl<'a> Cover<'a> {
    /// For the inputs of a specification.
    pub fn new(manager: &'a Manager, encoding: &Encoding, specification: &Specification) -> Self {
        let input = |v: VarId| Input {
            bits: encoding.bits(v, Time::Next).collect(),
            low: specification.variable(v).domain.low(),
            high: specification.variable(v).domain.high(),
        };
        Self {
            manager,
            inputs: specification.inputs().map(input).collect(),
        }
    }

    /// The cubes of a function over the bits of the next inputs, at most `most` of them.
    pub fn cubes(&self, set: &Function, most: usize) -> Result<Vec<Vec<Condition>>, Limit> {
        let mut found = Vec::new();
        self.walk(set, 0, &mut Vec::new(), &mut found, most)?;
        Ok(found)
    }

    fn walk(
        &self,
        set: &Function,
        index: usize,
        path: &mut Vec<Condition>,
        found: &mut Vec<Vec<Condition>>,
        most: usize,
    ) -> Result<(), Limit> {
        if set.is_false() {
            return Ok(());
        }
        let Some(top) = set.top() else {
            if found.len() >= most {
                return Err(Limit::Size);
            }
            found.push(path.clone());
            return Ok(());
        };
        let input = &self.inputs[index];
        if !input.bits.contains(&top) {
            return self.walk(set, index + 1, path, found, most);
        }
        let mut pieces: Vec<(i64, i64, Function)> = Vec::new();
        self.split(set, input, 0, 0, &mut pieces)?;
        for (low, high, rest) in pieces {
            let whole = low == input.low && high == input.high;
            if !whole {
                path.push((index, low, high));
            }
            self.walk(&rest, index + 1, path, found, most)?;
            if !whole {
                path.pop();
            }
        }
        Ok(())
    }

    /// The set by the values of one input, from the smallest up; neighbours with the same rest are one piece.
    fn split(
        &self,
        set: &Function,
        input: &Input,
        depth: usize,
        code: i64,
        pieces: &mut Vec<(i64, i64, Function)>,
    ) -> Result<(), Limit> {
        let left = input.bits.len() - depth;
        let low = input.low + (code << left);
        let high = (low + (1 << left) - 1).min(input.high);
        if low > input.high {
            return Ok(());
        }
        let varies = set.top().is_some_and(|t| input.bits[depth..].contains(&t));
        if varies {
            for bit in [false, true] {
                let half = self.manager.restrict(set, &[(input.bits[depth], bit)])?;
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
