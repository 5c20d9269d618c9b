//! The operations that a GR(1) game needs from a BDD package, and nothing more.
//!
//! Bits come in pairs: bit `2k` is the current one, bit `2k + 1` its primed twin. A kernel keeps
//! twins adjacent in every order, so that renaming one to the other preserves the order.
//!
//! An operation that runs out of nodes or time returns an error. Between operations, the caller can
//! declare a *safe point* ([`Kernel::safe_point`]), at which the kernel can collect garbage and
//! change its order.

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

    /// Number of the bit's pair.
    pub fn pair(self) -> u16 {
        self.0 >> 1
    }

    /// The bit's number, as an index into slices of values.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Maximum number of pairs of bits, so that the number of each bit fits into a [`Bit`]. A kernel
/// for more pairs cannot be created ([`Limit::Bits`]).
pub const MAX_PAIRS: usize = 32_767;

/// A set of bits to quantify.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct BitSet(Vec<bool>);

impl BitSet {
    /// Creates a set of these bits.
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

    /// Whether the set contains the bit.
    pub fn contains(&self, bit: Bit) -> bool {
        self.0.get(bit.index()).copied().unwrap_or(false)
    }

    /// The bits in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = Bit> {
        let bits = self.0.iter().enumerate();
        bits.filter(|(_, b)| **b).map(|(i, _)| Bit(i as u16))
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        !self.0.contains(&true)
    }
}

/// A variable order: a permutation of the pairs of bits, from the top of a diagram to the bottom.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Order(Vec<u16>);

impl Order {
    /// Creates the order `0, 1, ..., pairs - 1`, from top to bottom. With more than [`MAX_PAIRS`],
    /// it is one for which no kernel can be created.
    pub fn natural(pairs: usize) -> Self {
        Self((0..pairs.min(MAX_PAIRS + 1) as u16).collect())
    }

    /// Creates an order from its pairs, the topmost first; `None` unless each of `0..pairs.len()`
    /// occurs once.
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

    /// The pairs, topmost first.
    pub fn pairs(&self) -> &[u16] {
        &self.0
    }

    /// For every pair, the number of pairs above it.
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

    /// Name of the package, as given to `--kernel`.
    const NAME: &'static str;

    /// Whether the package can change its order.
    const REORDERS: bool;

    /// Creates a kernel for functions over the pairs of bits in `order`, at most [`MAX_PAIRS`].
    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit>;

    /// Returns a handle to the same kernel whose operations obey other limits.
    #[must_use]
    fn with_limits(&self, limits: &Limits) -> Self;

    /// Current limits.
    fn limits(&self) -> Limits;

    /// Current order of the pairs.
    fn order(&self) -> Order;

    /// The constant function `value`.
    fn constant(&self, value: bool) -> Self::Function;

    /// The function `bit` if `positive`, otherwise its negation.
    fn literal(&self, bit: Bit, positive: bool) -> Self::Function;

    /// Whether the function is constantly true.
    fn is_true(&self, a: &Self::Function) -> bool;

    /// Whether the function is constantly false.
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

    /// Fixes the values of some bits (cofactor).
    fn restrict(&self, a: &Self::Function, values: &[(Bit, bool)])
    -> Result<Self::Function, Limit>;

    /// Renames current bits to primed bits. The function must not depend on both bits of a pair.
    fn prime(&self, a: &Self::Function) -> Result<Self::Function, Limit>;

    /// Renames primed bits to current bits. The function must not depend on both bits of a pair.
    fn unprime(&self, a: &Self::Function) -> Result<Self::Function, Limit>;

    /// Number of nodes of a function; shared nodes count once.
    fn size(&self, a: &Self::Function) -> usize;

    /// The bits that the function depends on, in ascending order.
    fn support(&self, a: &Self::Function) -> Vec<Bit>;

    /// Values of all bits, indexed by bit, that satisfy the function; `None` if it is constantly
    /// false. They depend only on the function and the order.
    fn witness(&self, a: &Self::Function) -> Option<Vec<bool>>;

    /// Exports functions as plain data; they share equal nodes.
    fn export(&self, functions: &[&Self::Function]) -> Diagram;

    /// Builds the roots of a diagram as functions. The diagram can have any order.
    fn import(&self, diagram: &Diagram) -> Result<Vec<Self::Function>, Limit> {
        diagram.build(self)
    }

    /// Current number of nodes, including dead ones not yet collected.
    fn nodes(&self) -> u64;

    /// Peak number of nodes. Some kernels sample it only at safe points and collections, so they
    /// can miss a higher peak in between.
    fn peak_nodes(&self) -> u64;

    /// Work done so far, in units: nodes created, operand nodes visited, and operations, weighted
    /// so that a unit takes about the same time in every kernel. The count depends only on the
    /// operations, not on time, addresses or other threads. A kernel created without
    /// [`Limits::max_work`] need not count work.
    fn work(&self) -> u64;

    /// Declares a safe point, at which the kernel can collect garbage and, if the functions have
    /// grown, search for a better order. All functions stay valid.
    fn safe_point(&self) -> Result<(), Limit>;

    /// Makes the next safe point ignore what was created before now, such as the results of trials.
    /// Otherwise it would search for a better order because of them.
    fn ignore_growth(&self) {}

    /// Searches for a better order for the live functions; never increases the number of nodes. A
    /// kernel without reordering does nothing.
    fn sift(&self) -> Result<(), Limit>;

    /// Sets whether later safe points may change the order.
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

    /// Conjunction of all functions.
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

    /// Whether the function depends on the bit.
    fn depends_on(&self, a: &Self::Function, bit: Bit) -> bool {
        self.support(a).contains(&bit)
    }

    /// Returns a handle to the same kernel whose operations may take at most this much more work.
    /// If they need more, the error is [`Limit::Work`] with a number other than this handle's.
    #[must_use]
    fn with_work(&self, work: u64) -> Self {
        let limits = self.limits();
        let allowed = self.work().saturating_add(work);
        self.with_limits(&Limits {
            max_work: Some(limits.max_work.map_or(allowed, |most| most.min(allowed))),
            ..limits
        })
    }

    /// Conjunction of literals. Long ones are joined from the bottom of the order upwards: then
    /// each step takes constant time.
    fn cube(&self, literals: &[(Bit, bool)]) -> Result<Self::Function, Limit> {
        const LONG: usize = 8;
        let mut literals = literals.to_vec();
        if literals.len() > LONG {
            let positions = self.order().positions();
            literals.sort_by_key(|(bit, _)| (positions[usize::from(bit.pair())], *bit));
        }
        let mut cube = self.constant(true);
        for (bit, positive) in literals.into_iter().rev() {
            cube = self.and(&cube, &self.literal(bit, positive))?;
        }
        Ok(cube)
    }
}
