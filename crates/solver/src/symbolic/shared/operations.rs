//! The operations on functions: recursive, over the cofactors for the topmost bit of the operands
//! (Bryant, "Graph-based algorithms for Boolean function manipulation", 1986), with results in the
//! store's cache.

use super::super::link::Link;
use super::store::{BOTTOM, Stop, Store};

/// Operations whose results the cache holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operation {
    And,
    Xor,
    Exists,
    Restrict,
    Rename,
}

/// Operands of an operation as the key of a cache entry. Edges leave the topmost bit of each number
/// free. It is set in the third if that is the set of bits of a fused product, and in the first if
/// the third is an [`Operation`]; otherwise the operands are those of a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key(pub [u32; 3]);

const FLAG: u32 = 1 << 31;

impl Key {
    /// Key of no operation.
    pub const NONE: Self = Self([u32::MAX; 3]);

    fn of(operation: Operation, a: Link, b: Link) -> Self {
        Self([a.0 | FLAG, b.0, operation as u32])
    }

    fn product(a: Link, b: Link, bits: Link) -> Self {
        Self([a.0, b.0, bits.0 | FLAG])
    }

    fn choice(c: Link, a: Link, b: Link) -> Self {
        Self([c.0, a.0, b.0])
    }
}

/// What is known of the result of an operation before it is computed.
enum Search {
    /// The result is one of the operands or a constant, or the cache has it.
    Known(Link),
    /// The operands in the order of the key, and the place of the result in the cache.
    Open { a: Link, b: Link, place: usize },
}

impl Store {
    /// `a ∧ b`
    pub fn and(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        match self.find_and(a, b) {
            Search::Known(result) => Ok(result),
            Search::Open { a, b, place } => self.compute_and(a, b, place),
        }
    }

    /// Looks up `a ∧ b`.
    #[inline]
    fn find_and(&self, a: Link, b: Link) -> Search {
        if a == b || b == Link::TRUE {
            return Search::Known(a);
        }
        if a == Link::TRUE {
            return Search::Known(b);
        }
        if a == Link::FALSE || b == Link::FALSE || a == b.negated() {
            return Search::Known(Link::FALSE);
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        match self.cached(Key::of(Operation::And, a, b)) {
            (_, Some(known)) => Search::Known(known),
            (place, None) => Search::Open { a, b, place },
        }
    }

    /// Computes `a ∧ b`, which is not in the cache.
    fn compute_and(&mut self, a: Link, b: Link, place: usize) -> Result<Link, Stop> {
        self.tick()?;
        let level = self.level(a).min(self.level(b));
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        // Both are looked up first, so that the processor waits for both entries at the same time.
        let high = self.find_and(a_high, b_high);
        let low = self.find_and(a_low, b_low);
        let (high, low) = match (high, low) {
            (Search::Known(high), Search::Known(low)) => (high, low),
            (Search::Known(high), Search::Open { a, b, place }) => {
                (high, self.compute_and(a, b, place)?)
            }
            (Search::Open { a, b, place }, Search::Known(low)) => {
                (self.compute_and(a, b, place)?, low)
            }
            (Search::Open { a, b, place }, Search::Open { .. }) => {
                (self.compute_and(a, b, place)?, self.and(a_low, b_low)?)
            }
        };
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, Key::of(Operation::And, a, b), result))
    }

    /// `a ∨ b`
    pub fn or(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        Ok(self.and(a.negated(), b.negated())?.negated())
    }

    /// `a ⊕ b`
    pub fn xor(&mut self, a: Link, b: Link) -> Result<Link, Stop> {
        let negate = a.is_negated() != b.is_negated();
        let (a, b) = (a.plain(), b.plain());
        if a == b {
            return Ok(Link::FALSE.flipped(negate));
        }
        if a == Link::TRUE {
            return Ok(b.flipped(!negate));
        }
        if b == Link::TRUE {
            return Ok(a.flipped(!negate));
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let key = Key::of(Operation::Xor, a, b);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(a).min(self.level(b));
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let high = self.xor(a_high, b_high)?;
        let low = self.xor(a_low, b_low)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// `(c ∧ a) ∨ (¬c ∧ b)`
    pub fn choice(&mut self, c: Link, a: Link, b: Link) -> Result<Link, Stop> {
        let (c, a, b) = if c.is_negated() {
            (c.negated(), b, a)
        } else {
            (c, a, b)
        };
        if c == Link::TRUE || a == b {
            return Ok(a);
        }
        if a == c || a == Link::TRUE {
            return self.or(c, b);
        }
        if a == c.negated() || a == Link::FALSE {
            return self.and(c.negated(), b);
        }
        if b == c || b == Link::FALSE {
            return self.and(c, a);
        }
        if b == c.negated() || b == Link::TRUE {
            return self.or(c.negated(), a);
        }
        if a == b.negated() {
            return self.xor(c, b);
        }
        let negate = a.is_negated();
        let (a, b) = (a.flipped(negate), b.flipped(negate));
        let key = Key::choice(c, a, b);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(c).min(self.level(a)).min(self.level(b));
        let (c_high, c_low) = self.cofactors(c, level);
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let high = self.choice(c_high, a_high, b_high)?;
        let low = self.choice(c_low, a_low, b_low)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// Returns a conjunction of positive literals without those above `level`.
    fn below(&self, mut bits: Link, level: u32) -> Link {
        while self.level(bits) < level {
            bits = self.children(bits).0;
        }
        bits
    }

    /// `∃ bits. a`, for a conjunction of positive literals `bits`.
    pub fn exists(&mut self, a: Link, bits: Link) -> Result<Link, Stop> {
        let level = self.level(a);
        let bits = self.below(bits, level);
        if bits == Link::TRUE || level == BOTTOM {
            return Ok(a);
        }
        let key = Key::of(Operation::Exists, a, bits);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known);
        }
        self.tick()?;
        let (a_high, a_low) = self.children(a);
        let result = if self.level(bits) == level {
            let rest = self.children(bits).0;
            let high = self.exists(a_high, rest)?;
            if high == Link::TRUE {
                high
            } else {
                let low = self.exists(a_low, rest)?;
                self.or(high, low)?
            }
        } else {
            let high = self.exists(a_high, bits)?;
            let low = self.exists(a_low, bits)?;
            self.make(level, high, low)?
        };
        Ok(self.remember(place, key, result))
    }

    /// `∃ bits. a ∧ b`, for a conjunction of positive literals `bits`.
    pub fn product(&mut self, a: Link, b: Link, bits: Link) -> Result<Link, Stop> {
        if a == b || b == Link::TRUE {
            return self.exists(a, bits);
        }
        if a == Link::TRUE {
            return self.exists(b, bits);
        }
        if a == Link::FALSE || b == Link::FALSE || a == b.negated() {
            return Ok(Link::FALSE);
        }
        let level = self.level(a).min(self.level(b));
        let bits = self.below(bits, level);
        if bits == Link::TRUE {
            return self.and(a, b);
        }
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let key = Key::product(a, b, bits);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known);
        }
        self.tick()?;
        let (a_high, a_low) = self.cofactors(a, level);
        let (b_high, b_low) = self.cofactors(b, level);
        let result = if self.level(bits) == level {
            let rest = self.children(bits).0;
            let high = self.product(a_high, b_high, rest)?;
            if high == Link::TRUE {
                high
            } else {
                let low = self.product(a_low, b_low, rest)?;
                self.or(high, low)?
            }
        } else {
            let high = self.product(a_high, b_high, bits)?;
            let low = self.product(a_low, b_low, bits)?;
            self.make(level, high, low)?
        };
        Ok(self.remember(place, key, result))
    }

    /// Fixes the bits of `values`, a conjunction of literals, to the values that satisfy it.
    pub fn restrict(&mut self, a: Link, values: Link) -> Result<Link, Stop> {
        let negate = a.is_negated();
        let mut a = a.plain();
        let mut values = values;
        loop {
            let (level, fixed) = (self.level(a), self.level(values));
            if values == Link::TRUE || level == BOTTOM {
                return Ok(a.flipped(negate));
            }
            if fixed > level {
                break;
            }
            let (high, low) = self.children(values);
            let positive = high != Link::FALSE;
            values = if positive { high } else { low };
            if fixed == level {
                let (a_high, a_low) = self.children(a);
                return self
                    .restrict(if positive { a_high } else { a_low }, values)
                    .map(|result| result.flipped(negate));
            }
        }
        let key = Key::of(Operation::Restrict, a, values);
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        let level = self.level(a);
        let (a_high, a_low) = self.children(a);
        a = self.restrict(a_high, values)?;
        let low = self.restrict(a_low, values)?;
        let result = self.make(level, a, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }

    /// Renames current bits to primed bits (`to_primed`), or primed bits to current bits. The
    /// function must not depend on both bits of a pair; the twins are adjacent, so the order of the
    /// levels stays.
    pub fn rename(&mut self, a: Link, to_primed: bool) -> Result<Link, Stop> {
        let negate = a.is_negated();
        let a = a.plain();
        if a == Link::TRUE {
            return Ok(a.flipped(negate));
        }
        let key = Key::of(Operation::Rename, a, Link::FALSE.flipped(to_primed));
        let (place, known) = self.cached(key);
        if let Some(known) = known {
            return Ok(known.flipped(negate));
        }
        self.tick()?;
        // The current bit of a pair has an even level, its twin the next one.
        let level = self.level(a) & !1 | u32::from(to_primed);
        let (a_high, a_low) = self.children(a);
        let high = self.rename(a_high, to_primed)?;
        let low = self.rename(a_low, to_primed)?;
        let result = self.make(level, high, low)?;
        Ok(self.remember(place, key, result).flipped(negate))
    }
}
