//! What a BDD package must be able to do for a GR(1) game, and nothing more.
//!
//! Bits come in pairs: bit `2k` is the current one, bit `2k + 1` its primed twin. A kernel keeps
//! the twins of a pair next to each other whatever the order of the pairs is, so that renaming
//! between them keeps the order.
//!
//! Every operation gives a result: that the nodes do not fit, or that the time has run out, is a
//! value. Between operations lie *safe points*, at which whoever drives the game lets the kernel
//! collect what is dead and change its order.

use super::{Diagram, Limit, Limits};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::hash::Hash;

/// A boolean variable of the diagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Bit(pub u16);

impl Bit {
    /// The primed twin of a current bit.
    #[must_use]
    pub fn primed(self) -> Self {
        Self(self.0 | 1)
    }

    /// The pair it belongs to.
    pub fn pair(self) -> u16 {
        self.0 >> 1
    }

    /// As an index into slices of values.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// A set of bits to quantify.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct BitSet(Vec<bool>);

impl BitSet {
    /// The set of these bits.
    pub fn new(bits: impl IntoIterator<Item = Bit>) -> Self {
        let mut set = Self::default();
        for bit in bits {
            set.insert(bit);
        }
        set
    }

    /// Adds a bit.
    pub fn insert(&mut self, bit: Bit) {
        let index = bit.index();
        if self.0.len() <= index {
            self.0.resize(index + 1, false);
        }
        self.0[index] = true;
    }

    /// Whether a bit is in it.
    pub fn contains(&self, bit: Bit) -> bool {
        self.0.get(bit.index()).copied().unwrap_or(false)
    }

    /// The bits, in order.
    pub fn iter(&self) -> impl Iterator<Item = Bit> {
        let bits = self.0.iter().enumerate();
        bits.filter(|(_, b)| **b).map(|(i, _)| Bit(i as u16))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        !self.0.contains(&true)
    }
}

/// The pairs of bits from the top of a diagram to its bottom; a permutation.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Order(Vec<u16>);

impl Order {
    /// The pairs by number.
    pub fn natural(pairs: usize) -> Self {
        Self((0..pairs as u16).collect())
    }

    /// An order from its pairs, the topmost first; `None` unless each of `0..pairs.len()` occurs
    /// once.
    pub fn new(pairs: Vec<u16>) -> Option<Self> {
        let mut seen = vec![false; pairs.len()];
        for pair in &pairs {
            let place = seen.get_mut(usize::from(*pair))?;
            if std::mem::replace(place, true) {
                return None;
            }
        }
        Some(Self(pairs))
    }

    /// The pairs, the topmost first.
    pub fn pairs(&self) -> &[u16] {
        &self.0
    }

    /// For every pair, how many pairs lie above it.
    pub fn positions(&self) -> Vec<u16> {
        let mut positions = vec![0; self.0.len()];
        for (position, pair) in self.0.iter().enumerate() {
            positions[usize::from(*pair)] = position as u16;
        }
        positions
    }
}

/// A BDD package. Cheap to clone: clones share nodes and counters.
pub trait Kernel: Clone + Debug + Send + Sync + 'static {
    /// A boolean function over the kernel's bits. Cheap to clone; equal functions compare equal.
    type Function: Clone + Eq + Hash + Debug + Send + Sync;

    /// The package's name, as `--kernel` takes it.
    const NAME: &'static str;

    /// Whether it can change its order.
    const REORDERS: bool;

    /// Room for functions over the pairs of an order.
    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit>;

    /// The same functions with other limits for what is made from here on.
    #[must_use]
    fn with_limits(&self, limits: &Limits) -> Self;

    /// The limits in force.
    fn limits(&self) -> Limits;

    /// The order of the pairs.
    fn order(&self) -> Order;

    /// `true` or `false`.
    fn constant(&self, value: bool) -> Self::Function;

    /// A bit, or its negation.
    fn literal(&self, bit: Bit, positive: bool) -> Self::Function;

    /// Whether it is `true` everywhere.
    fn is_true(&self, a: &Self::Function) -> bool;

    /// Whether it is `false` everywhere.
    fn is_false(&self, a: &Self::Function) -> bool;

    /// `¬a`
    fn not(&self, a: &Self::Function) -> Result<Self::Function, Limit>;

    /// `a ∧ b`
    fn and(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit>;

    /// `a ∨ b`
    fn or(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit>;

    /// `a ∧ ¬b`
    fn and_not(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit>;

    /// `a ⊕ b`
    fn xor(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit>;

    /// `(c ∧ a) ∨ (¬c ∧ b)`
    fn ite(
        &self,
        c: &Self::Function,
        a: &Self::Function,
        b: &Self::Function,
    ) -> Result<Self::Function, Limit>;

    /// `∃ bits. a ∧ b`
    fn and_exists(
        &self,
        a: &Self::Function,
        b: &Self::Function,
        bits: &BitSet,
    ) -> Result<Self::Function, Limit>;

    /// `∃ bits. a`
    fn exists(&self, a: &Self::Function, bits: &BitSet) -> Result<Self::Function, Limit>;

    /// The function with some bits fixed.
    fn restrict(&self, a: &Self::Function, values: &[(Bit, bool)])
    -> Result<Self::Function, Limit>;

    /// A function of current bits as one of primed bits.
    fn prime(&self, a: &Self::Function) -> Result<Self::Function, Limit>;

    /// A function of primed bits as one of current bits.
    fn unprime(&self, a: &Self::Function) -> Result<Self::Function, Limit>;

    /// The number of nodes, those of shared parts once.
    fn size(&self, a: &Self::Function) -> usize;

    /// The bits it depends on, in order.
    fn support(&self, a: &Self::Function) -> Vec<Bit>;

    /// Some assignment to all bits that satisfies it, indexed by bit. It depends on the function
    /// and the order only.
    fn witness(&self, a: &Self::Function) -> Option<Vec<bool>>;

    /// Several functions as plain data, sharing what they have in common.
    fn export(&self, functions: &[&Self::Function]) -> Diagram;

    /// The roots of a diagram as functions, whatever order it was made in.
    fn import(&self, diagram: &Diagram) -> Result<Vec<Self::Function>, Limit> {
        diagram.build(self)
    }

    /// How many nodes are kept now; dead ones that were not yet collected count.
    fn nodes(&self) -> u64;

    /// The largest number of nodes that were kept at once, as far as safe points and single
    /// functions show it.
    fn peak_nodes(&self) -> u64;

    /// The work that was done, in units: nodes that were made, operands' nodes that were walked,
    /// and operations, each with a weight by which kernels take about the same time for a unit. It
    /// depends on the questions alone: on no clock, no address, and not on what other threads do. A
    /// kernel may leave it uncounted where [`Limits::most_work`] is none.
    fn work(&self) -> u64;

    /// A safe point: may collect, and may look for a better order when the functions have grown.
    /// All functions stay valid.
    fn safe_point(&self) -> Result<(), Limit>;

    /// Looks for a better order for what is alive. Never ends with more nodes than it began with; a
    /// kernel without reordering does nothing.
    fn sift(&self) -> Result<(), Limit>;

    /// Whether safe points may change the order from here on.
    fn set_reordering(&self, allowed: bool);

    /// `a → b`
    fn implies(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit> {
        self.not(&self.and_not(a, b)?)
    }

    /// `a ↔ b`
    fn iff(&self, a: &Self::Function, b: &Self::Function) -> Result<Self::Function, Limit> {
        self.not(&self.xor(a, b)?)
    }

    /// `∀ bits. a`
    fn forall(&self, a: &Self::Function, bits: &BitSet) -> Result<Self::Function, Limit> {
        self.not(&self.exists(&self.not(a)?, bits)?)
    }

    /// `∀ bits. a → b`
    fn implies_forall(
        &self,
        a: &Self::Function,
        b: &Self::Function,
        bits: &BitSet,
    ) -> Result<Self::Function, Limit> {
        self.not(&self.and_exists(a, &self.not(b)?, bits)?)
    }

    /// The conjunction of all.
    fn all<'a>(
        &self,
        functions: impl IntoIterator<Item = &'a Self::Function>,
    ) -> Result<Self::Function, Limit> {
        let mut result = self.constant(true);
        for f in functions {
            result = self.and(&result, f)?;
        }
        Ok(result)
    }

    /// Whether it depends on the bit.
    fn depends_on(&self, a: &Self::Function, bit: Bit) -> bool {
        self.support(a).contains(&bit)
    }

    /// The conjunction of literals.
    fn cube(&self, literals: &[(Bit, bool)]) -> Result<Self::Function, Limit> {
        let mut cube = self.constant(true);
        for (bit, positive) in literals.iter().rev() {
            cube = self.and(&cube, &self.literal(*bit, *positive))?;
        }
        Ok(cube)
    }
}
