//! A thin layer over biodivine-lib-bdd: handles, limits as values, and the few operations a GR(1) game needs.
//!
//! Bits come in pairs: bit `2k` is the current one, bit `2k + 1` its primed twin. Renaming between the two therefore keeps
//! the order and is a linear copy. Functions of this package own their nodes; a [`Function`] shares them behind an `Arc` and
//! keeps count of what is alive, which is what the memory limit and `peak_nodes` go by.
//!
//! The package's fused relational product has neither a limit nor cancellation, so it is used while the operands are small
//! enough that their product is harmless, and beyond that conjunction and quantification are done apart, each with a limit.

use super::{Limit, Limits};
use biodivine_lib_bdd::{Bdd, BddNode, BddValuation, BddVariable, BddVariableSet, op_function};
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A boolean variable of the diagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bit(pub u16);

impl Bit {
    /// The primed twin of a current bit.
    #[must_use]
    pub fn primed(self) -> Self {
        Self(self.0 | 1)
    }

    fn variable(self) -> BddVariable {
        BddVariable::from_index(usize::from(self.0))
    }
}

/// A set of bits to quantify.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
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
        let index = usize::from(bit.0);
        if self.0.len() <= index {
            self.0.resize(index + 1, false);
        }
        self.0[index] = true;
    }

    /// Whether a bit is in it.
    pub fn contains(&self, bit: Bit) -> bool {
        self.0.get(usize::from(bit.0)).copied().unwrap_or(false)
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

/// How many nodes are alive, and how many ever were at once.
#[derive(Debug, Default)]
struct Meter {
    live: AtomicUsize,
    peak: AtomicUsize,
}

/// The nodes of one function; gives them back to the meter when dropped.
#[derive(Debug)]
struct Owned {
    bdd: Bdd,
    meter: Arc<Meter>,
}

impl Drop for Owned {
    fn drop(&mut self) {
        self.meter
            .live
            .fetch_sub(self.bdd.size(), Ordering::Relaxed);
    }
}

/// A boolean function over the manager's bits. Cheap to clone; equal functions compare equal.
#[derive(Debug, Clone)]
pub struct Function(Arc<Owned>);

impl Function {
    /// The number of nodes.
    pub fn size(&self) -> usize {
        self.0.bdd.size()
    }

    /// Whether it is `true` everywhere.
    pub fn is_true(&self) -> bool {
        self.0.bdd.is_true()
    }

    /// Whether it is `false` everywhere.
    pub fn is_false(&self) -> bool {
        self.0.bdd.is_false()
    }

    /// The bits it depends on, in order.
    pub fn support(&self) -> Vec<Bit> {
        let mut bits: Vec<Bit> = self
            .0
            .bdd
            .support_set()
            .into_iter()
            .map(|v| Bit(v.to_index() as u16))
            .collect();
        bits.sort_unstable();
        bits
    }

    /// Whether it depends on the bit.
    pub fn depends_on(&self, bit: Bit) -> bool {
        self.0.bdd.support_set_contains(&bit.variable())
    }

    /// The topmost bit it depends on, or `None` for a constant.
    pub fn top(&self) -> Option<Bit> {
        if self.size() <= 2 {
            return None;
        }
        let root = self.0.bdd.root_pointer();
        Some(Bit(self.0.bdd.var_of(root).to_index() as u16))
    }

    /// Some assignment to all bits that satisfies it, indexed by bit.
    pub fn witness(&self) -> Option<Vec<bool>> {
        self.0.bdd.first_valuation().map(BddValuation::into_vector)
    }
}

impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.bdd == other.0.bdd
    }
}

impl Eq for Function {}

impl Hash for Function {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.bdd.hash(state);
    }
}

/// Bytes a node costs, the tables of the operation that makes it included.
const BYTES_PER_NODE: u64 = 48;

/// Without a memory limit, a single function still has to fit the package's 32-bit pointers.
const MOST_NODES: usize = 1 << 28;

/// While the product of the operands' sizes is below this, the fused operations are safe to run without a limit.
const FUSED_PRODUCT: usize = 1 << 24;

/// Makes functions over a fixed number of bits.
#[derive(Debug)]
pub struct Manager {
    set: BddVariableSet,
    meter: Arc<Meter>,
    limits: Limits,
    most_nodes: usize,
}

impl Manager {
    /// A manager of `pairs` pairs of bits.
    pub fn new(pairs: usize, limits: &Limits) -> Result<Self, Limit> {
        let bits = u16::try_from(2 * pairs).map_err(|_| Limit::Memory)?;
        if bits == u16::MAX {
            return Err(Limit::Memory);
        }
        Ok(Self {
            set: BddVariableSet::new_anonymous(bits),
            meter: Arc::default(),
            limits: *limits,
            most_nodes: most_nodes(limits),
        })
    }

    /// The same manager with other limits, for a later stage that has its own.
    #[must_use]
    pub fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            set: self.set.clone(),
            meter: Arc::clone(&self.meter),
            limits: *limits,
            most_nodes: most_nodes(limits),
        }
    }

    /// The limits it goes by.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// The largest number of nodes that were alive at once.
    pub fn peak_nodes(&self) -> u64 {
        self.meter.peak.load(Ordering::Relaxed) as u64
    }

    /// A constant.
    pub fn constant(&self, value: bool) -> Function {
        self.keep(if value {
            self.set.mk_true()
        } else {
            self.set.mk_false()
        })
    }

    /// The function that is the bit itself, or its negation.
    pub fn literal(&self, bit: Bit, positive: bool) -> Function {
        self.keep(self.set.mk_literal(bit.variable(), positive))
    }

    /// `¬a`
    pub fn not(&self, a: &Function) -> Result<Function, Limit> {
        self.limits.check_time()?;
        self.limited(Some(a.0.bdd.not()))
    }

    /// `a ∧ b`
    pub fn and(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_true() || b.is_false() || a == b {
            return Ok(b.clone());
        }
        if b.is_true() || a.is_false() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::and)
    }

    /// `a ∨ b`
    pub fn or(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_false() || b.is_true() || a == b {
            return Ok(b.clone());
        }
        if b.is_false() || a.is_true() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::or)
    }

    /// `a ∧ ¬b`
    pub fn and_not(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_false() || b.is_false() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::and_not)
    }

    /// `a → b`
    pub fn implies(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_true() {
            return Ok(b.clone());
        }
        self.apply(a, b, op_function::imp)
    }

    /// `a ↔ b`
    pub fn iff(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.apply(a, b, op_function::iff)
    }

    /// `a ⊕ b`
    pub fn xor(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.apply(a, b, op_function::xor)
    }

    /// `(c ∧ a) ∨ (¬c ∧ b)`
    pub fn ite(&self, c: &Function, a: &Function, b: &Function) -> Result<Function, Limit> {
        if c.is_true() || a == b {
            return Ok(a.clone());
        }
        if c.is_false() {
            return Ok(b.clone());
        }
        let (yes, no) = (self.and(c, a)?, self.and_not(b, c)?);
        self.or(&yes, &no)
    }

    /// The conjunction of all.
    pub fn all<'a>(
        &self,
        functions: impl IntoIterator<Item = &'a Function>,
    ) -> Result<Function, Limit> {
        let mut result = self.constant(true);
        for f in functions {
            result = self.and(&result, f)?;
        }
        Ok(result)
    }

    /// `∃ bits. a`
    pub fn exists(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.and_exists(a, a, bits)
    }

    /// `∀ bits. a`
    pub fn forall(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.implies_forall(&self.constant(true), a, bits)
    }

    /// `∃ bits. a ∧ b`
    pub fn and_exists(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        if a.is_false() || b.is_false() {
            return Ok(self.constant(false));
        }
        if bits.is_empty() {
            return self.and(a, b);
        }
        self.limits.check_time()?;
        if a.size().saturating_mul(b.size()) <= FUSED_PRODUCT {
            return self.limited(Some(Bdd::binary_op_with_exists_trigger(
                &a.0.bdd,
                &b.0.bdd,
                |v| bits.contains(Bit(v.to_index() as u16)),
                op_function::and,
            )));
        }
        // From the bottom up: the lower a bit, the smaller what its elimination touches.
        let mut result = self.and(a, b)?;
        for bit in bits.iter().collect::<Vec<_>>().into_iter().rev() {
            if result.depends_on(bit) {
                self.limits.check_time()?;
                result = self.limited(Bdd::fused_binary_flip_op_with_limit(
                    self.room()?,
                    (&result.0.bdd, None),
                    (&result.0.bdd, Some(bit.variable())),
                    None,
                    op_function::or,
                ))?;
            }
        }
        Ok(result)
    }

    /// `∀ bits. a → b`
    pub fn implies_forall(
        &self,
        a: &Function,
        b: &Function,
        bits: &BitSet,
    ) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size().saturating_mul(b.size()) <= FUSED_PRODUCT {
            return self.limited(Some(Bdd::binary_op_with_for_all_trigger(
                &a.0.bdd,
                &b.0.bdd,
                |v| bits.contains(Bit(v.to_index() as u16)),
                op_function::imp,
            )));
        }
        let broken = self.and_exists(a, &self.not(b)?, bits)?;
        self.not(&broken)
    }

    /// The function with some bits fixed.
    pub fn restrict(&self, a: &Function, values: &[(Bit, bool)]) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size() <= 2 || values.is_empty() {
            return Ok(a.clone());
        }
        let values: Vec<_> = values.iter().map(|(b, v)| (b.variable(), *v)).collect();
        self.limited(Some(a.0.bdd.restrict(&values)))
    }

    /// A function of current bits as one of primed bits.
    pub fn prime(&self, a: &Function) -> Result<Function, Limit> {
        self.shift(a, |v| v | 1)
    }

    /// A function of primed bits as one of current bits.
    pub fn unprime(&self, a: &Function) -> Result<Function, Limit> {
        self.shift(a, |v| v & !1)
    }

    /// Renames every bit. Twins are neighbours, so the order stays as long as a function has only one of the two.
    fn shift(&self, a: &Function, rename: impl Fn(usize) -> usize) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size() <= 2 {
            return Ok(a.clone());
        }
        let mut nodes: Vec<BddNode> = a.0.bdd.clone().to_nodes();
        for node in nodes.iter_mut().skip(2) {
            node.var = BddVariable::from_index(rename(node.var.to_index()));
        }
        let shifted = Bdd::from_nodes(&nodes)
            .expect("a function of both current and primed bits was renamed; please report this");
        self.limited(Some(shifted))
    }

    fn apply(
        &self,
        a: &Function,
        b: &Function,
        op: fn(Option<bool>, Option<bool>) -> Option<bool>,
    ) -> Result<Function, Limit> {
        self.limits.check_time()?;
        let result = Bdd::binary_op_with_limit(self.room()?, &a.0.bdd, &b.0.bdd, op);
        self.limited(result)
    }

    /// How many nodes may still be made.
    fn room(&self) -> Result<usize, Limit> {
        let live = self.meter.live.load(Ordering::Relaxed);
        match self.most_nodes.checked_sub(live) {
            Some(room) if room > 2 => Ok(room),
            _ => Err(Limit::Memory),
        }
    }

    fn limited(&self, result: Option<Bdd>) -> Result<Function, Limit> {
        let bdd = result.ok_or(Limit::Memory)?;
        let function = self.keep(bdd);
        self.room()?;
        Ok(function)
    }

    fn keep(&self, bdd: Bdd) -> Function {
        let size = bdd.size();
        let live = self.meter.live.fetch_add(size, Ordering::Relaxed) + size;
        self.meter.peak.fetch_max(live, Ordering::Relaxed);
        Function(Arc::new(Owned {
            bdd,
            meter: Arc::clone(&self.meter),
        }))
    }
}

fn most_nodes(limits: &Limits) -> usize {
    limits.memory_mib.map_or(MOST_NODES, |mib| {
        let nodes = mib.saturating_mul(1 << 20) / BYTES_PER_NODE;
        usize::try_from(nodes).map_or(MOST_NODES, |n| n.min(MOST_NODES))
    })
}
