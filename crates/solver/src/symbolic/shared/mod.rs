//! A kernel whose functions share their nodes, with complement edges, a cache that persists across
//! operations, and reordering. Suited to large games.
//!
//! An operation locks the store ([`store::Store`]) and works on plain numbers, so nothing is
//! counted, locked or released for a single node. A [`Function`] refers to its root: an entry of a
//! table that collections read and reordering updates. These rules follow:
//!
//! - Garbage is collected only between operations: at a safe point, when the store has grown to
//!   three times its size after the last collection, or after an operation that found no room,
//!   which is then repeated.
//! - Functions are ordered by the sifter on plain data ([`super::sift`]), whose result replaces the
//!   whole store. This happens at a safe point, or within an operation that takes long, which is
//!   then repeated.
//! - Node counts, collections and orders depend only on the operations, not on time, addresses or
//!   other threads. So limits on nodes and work give the same answer every time.

mod operations;
mod store;
#[cfg(test)]
mod tests;

use super::link::Link;
use super::{Bit, BitSet, Diagram, Kernel, Limit, Limits, MAX_PAIRS, Order, sift};
use rustc_hash::FxHashMap;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use store::{MAX_NODES, Stop, Store};

/// Maximum bytes per node: itself, its slots in the unique table while that grows, and the copy
/// that is sifted.
const BYTES_PER_NODE: u64 = 44;

/// Maximum bytes per live node that sifting takes.
const SIFT_BYTES_PER_NODE: u64 = 160;

/// Capacity of the store in nodes without a memory limit: about 5 GiB when full.
const USUAL_NODES: u64 = 1 << 27;

/// Minimum useful capacity of the store in nodes.
const MIN_NODES: u64 = 1 << 16;

/// Maximum number of cache entries. A larger cache costs more than it saves: every collection
/// clears it, and it no longer fits into the processor's caches.
const LARGE_CACHE: usize = 1 << 18;

/// Maximum number of cache entries for at most [`FEW_PAIRS`] pairs, if only memory is limited.
const SMALL_CACHE: usize = 1 << 17;

/// Maximum number of pairs for [`SMALL_CACHE`].
const FEW_PAIRS: usize = 48;

/// Minimum number of nodes in the store for a collection at a safe point.
const COLLECT_NODES: u64 = 1 << 19;

/// Maximum number of nodes created since the last collection for which reordering starts without a
/// collection.
const FEW_DEAD_NODES: u64 = 10_000;

/// Minimum number of nodes created between two safe points that triggers reordering.
const REORDER_NODES: u64 = 30_000;

/// Maximum number of nodes that sifting at a safe point may touch per node created since the last
/// sifting, so that sifting takes a bounded share of all work.
const SIFT_WORK_PER_NODE: u64 = 60;

/// Work since the last safe point from which on an operation is interrupted for reordering, at
/// first; see [`State::patience`]. In a bad order, a single operation can exceed any memory.
const FIRST_PATIENCE: u64 = 20_000_000;

/// Minimum of that work per live node.
const PATIENCE_PER_NODE: u64 = 100;

/// Units of work per operation.
const WORK_PER_OPERATION: u64 = 10;

/// The store is reordered only if the new order needs less than this percentage of the current
/// nodes.
const WORTHWHILE_PERCENT: usize = 98;

/// Root of functions: of one and of its negation.
#[derive(Debug)]
struct Root {
    /// Number of the root; no two roots of a kernel have the same.
    id: u64,
    /// Number of the node, which changes when the store is reordered. Only read and written while
    /// the store is locked.
    node: AtomicU32,
}

/// A boolean function.
#[derive(Clone)]
pub struct Function {
    root: Arc<Root>,
    negated: bool,
}

impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        self.root.id == other.root.id && self.negated == other.negated
    }
}

impl Eq for Function {}

impl Hash for Function {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.root.id, self.negated).hash(state);
    }
}

impl fmt::Debug for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negated { "!" } else { "" };
        write!(f, "{sign}{}", self.root.id)
    }
}

impl Function {
    fn link(&self) -> Link {
        Link::to(self.root.node.load(Ordering::Relaxed)).flipped(self.negated)
    }
}

/// What all clones of a kernel share.
struct Shared {
    state: Mutex<State>,
    /// Maximum number of nodes: the store's capacity, or the node limit if that is lower.
    capacity: u64,
    yes: Function,
    /// The negated and the positive literal of each bit.
    literals: Vec<[Function; 2]>,
}

/// What operations change.
struct State {
    store: Store,
    /// All roots by their nodes. A root that only this table refers to is removed by the next
    /// collection.
    roots: FxHashMap<u32, Arc<Root>>,
    /// Id of the next root.
    next_id: u64,
    /// Conjunctions of bits that were quantified.
    cubes: FxHashMap<BitSet, Function>,
    /// Number of finished operations.
    operations: u64,
    peak: u64,
    /// Number of nodes left after the last collection.
    collected: u64,
    /// Number of nodes at the last safe point.
    before: u64,
    /// Number of nodes created since the last sifting.
    made: u64,
    /// Since the last sifting, the largest number of nodes created between two consecutive safe
    /// points.
    busiest: u64,
    /// Value of `busiest` at the last sifting.
    busiest_at_sifting: u64,
    /// Whether the order may change.
    reordering: bool,
    /// Work of the store until the last safe point or reordering.
    work_before: u64,
    /// Minimum work since then from which on an operation is interrupted for reordering.
    patience: u64,
}

impl State {
    fn new(store: Store) -> Self {
        Self {
            store,
            roots: FxHashMap::default(),
            next_id: 0,
            cubes: FxHashMap::default(),
            operations: 0,
            peak: 0,
            collected: 0,
            before: 0,
            made: 0,
            busiest: 0,
            busiest_at_sifting: 0,
            reordering: true,
            work_before: 0,
            patience: FIRST_PATIENCE,
        }
    }

    /// Returns a function that keeps the node of `link` alive.
    fn function(&mut self, link: Link) -> Function {
        let next_id = &mut self.next_id;
        let root = self.roots.entry(link.node()).or_insert_with(|| {
            *next_id += 1;
            Arc::new(Root {
                id: *next_id,
                node: AtomicU32::new(link.node()),
            })
        });
        Function {
            root: Arc::clone(root),
            negated: link.is_negated(),
        }
    }

    fn nodes(&self) -> u64 {
        self.store.count() as u64
    }

    fn work(&self) -> u64 {
        WORK_PER_OPERATION * self.operations + self.store.work()
    }

    fn note_peak(&mut self) {
        self.peak = self.peak.max(self.nodes());
    }

    fn collect(&mut self) {
        self.note_peak();
        self.roots.retain(|_, root| Arc::strong_count(root) > 1);
        self.store
            .collect(self.roots.keys().map(|node| Link::to(*node)));
        self.collected = self.nodes();
    }

    /// Searches for a better order, touching at most `work` nodes, and reorders the store if the
    /// new order is worthwhile.
    fn sift_within(&mut self, work: usize, capacity: u64, limits: &Limits) {
        self.note_peak();
        // Dead nodes are not sifted, but they take room. If there are only a few, keeping them is
        // cheaper than a collection.
        if self.nodes() > self.collected + FEW_DEAD_NODES {
            self.collect();
        }
        let has_room = self.nodes() < limits.deadline.memory_left() / SIFT_BYTES_PER_NODE;
        if self.nodes() < capacity / 3 && has_room {
            self.reorder(work, limits);
        }
        self.collected = self.nodes();
        self.before = self.collected;
        self.work_before = self.store.work();
        self.made = 0;
        self.busiest_at_sifting = std::mem::take(&mut self.busiest);
    }

    /// Returns the work of the store from which on an operation is interrupted for reordering.
    fn patience(&self) -> u64 {
        if self.reordering {
            let live = self.collected.saturating_mul(PATIENCE_PER_NODE);
            self.work_before + self.patience.max(live)
        } else {
            u64::MAX
        }
    }

    /// Reorders within an operation, before it is repeated. The next interruption comes after twice
    /// as much work, or four times as much if no better order was found.
    fn relieve(&mut self, capacity: u64, limits: &Limits) {
        let made = (self.store.work() - self.work_before) / WORK_PER_OPERATION;
        let before = self.store.order().clone();
        let work = made.saturating_mul(SIFT_WORK_PER_NODE);
        self.sift_within(work as usize, capacity, limits);
        let is_better = *self.store.order() != before;
        self.patience *= if is_better { 2 } else { 4 };
    }

    /// Sifts a copy of the live nodes; if that is worthwhile, it replaces the store.
    fn reorder(&mut self, work: usize, limits: &Limits) {
        self.roots.retain(|_, root| Arc::strong_count(root) > 1);
        let mut roots: Vec<Arc<Root>> = self.roots.values().cloned().collect();
        roots.sort_unstable_by_key(|root| root.id);
        let links: Vec<Link> = roots
            .iter()
            .map(|root| Link::to(root.node.load(Ordering::Relaxed)))
            .collect();
        let live = self.store.diagram(&links);
        let Some(sifted) = sift::sift(&live, self.store.order(), work, limits) else {
            return;
        };
        if sifted.after * 100 >= sifted.before * WORTHWHILE_PERCENT {
            return;
        }
        let links = self.store.replace(&sifted.diagram, &sifted.order);
        self.roots.clear();
        for (root, link) in roots.into_iter().zip(links) {
            // The high edge of a node is not negated in any order. So if the edge to a function's
            // node is not negated in one order, it is not negated in any other.
            debug_assert!(!link.is_negated(), "reordering has negated a function");
            root.node.store(link.node(), Ordering::Relaxed);
            self.roots.insert(link.node(), root);
        }
    }
}

/// The kernel with a shared store.
#[derive(Clone)]
pub struct SharedStore {
    shared: Arc<Shared>,
    limits: Limits,
}

impl fmt::Debug for SharedStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SharedStore")
            .field("nodes", &self.nodes())
            .finish()
    }
}

impl SharedStore {
    /// Locks the state. An operation that panics leaves complete nodes only.
    fn state(&self) -> MutexGuard<'_, State> {
        let state = self.shared.state.lock();
        state.unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs an operation; if there is no room, collects garbage and repeats the operation.
    fn attempt(
        &self,
        mut operation: impl FnMut(&mut Store) -> Result<Link, Stop>,
    ) -> Result<Function, Limit> {
        self.limits.check_time()?;
        let mut state = self.state();
        self.limits.check_work(state.work())?;
        let capacity = self.capacity();
        let max_work = self.limits.max_work.unwrap_or(u64::MAX);
        let function = loop {
            let left = max_work.saturating_sub(WORK_PER_OPERATION * state.operations);
            let patience = state.patience();
            state.store.set_limits(self.limits.deadline, left, patience);
            let mut result = operation(&mut state.store);
            if result == Err(Stop::Full) {
                state.collect();
                if state.nodes() > capacity / 10 * 9 {
                    return Err(Limit::Memory);
                }
                result = operation(&mut state.store);
            }
            break match result {
                Ok(link) => state.function(link),
                Err(Stop::Full) => return Err(Limit::Memory),
                Err(Stop::Late(reason)) => return Err(reason.into()),
                Err(Stop::Work) => return Err(Limit::Work(max_work)),
                Err(Stop::Tedious) => {
                    state.relieve(self.shared.capacity, &self.limits);
                    continue;
                }
            };
        };
        state.operations += 1;
        if state.nodes() > capacity {
            state.collect();
            if state.nodes() > capacity / 10 * 9 {
                return Err(Limit::Memory);
            }
        }
        Ok(function)
    }

    /// Returns the maximum number of nodes between two operations. That of
    /// [`Kernel::with_limits`] can be lower than that of the store.
    fn capacity(&self) -> u64 {
        let capacity = self.shared.capacity;
        self.limits
            .max_nodes
            .map_or(capacity, |most| most.min(capacity))
    }

    /// Returns the conjunction of the bits, which is how the store represents a set of bits.
    fn conjunction(&self, bits: &BitSet) -> Result<Function, Limit> {
        if let Some(cube) = self.state().cubes.get(bits) {
            return Ok(cube.clone());
        }
        let literals: Vec<(Bit, bool)> = bits.iter().map(|b| (b, true)).collect();
        let cube = self.cube(&literals)?;
        self.state().cubes.insert(bits.clone(), cube.clone());
        Ok(cube)
    }
}

impl Kernel for SharedStore {
    type Function = Function;

    const NAME: &'static str = "shared";

    const REORDERS: bool = true;

    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit> {
        let pairs = order.pairs().len();
        if pairs > MAX_PAIRS {
            return Err(Limit::Bits);
        }
        let by_memory = Limits {
            max_nodes: None,
            ..*limits
        };
        let room = by_memory.nodes(BYTES_PER_NODE, USUAL_NODES, MAX_NODES);
        let is_limited = limits.max_nodes.is_some() || limits.max_work.is_some();
        // An operation may take more nodes than may be left after it.
        let (capacity, room) = if is_limited {
            let most = limits.nodes(BYTES_PER_NODE, USUAL_NODES, MAX_NODES);
            let room = room.min(2 * most + 2 * MIN_NODES);
            (most.min(room / 2), room)
        } else {
            (room, room)
        };
        if room < MIN_NODES {
            return Err(Limit::Memory);
        }
        // If the cache is too small, an operation can run for ever and yet create no nodes that a
        // budget would count. So a node budget does not reduce the cache.
        let entries = if pairs > FEW_PAIRS || is_limited {
            LARGE_CACHE
        } else {
            SMALL_CACHE
        };
        let store = Store::new(order, room as usize, entries);
        let mut state = State::new(store);
        let yes = state.function(Link::TRUE);
        let mut literals = Vec::with_capacity(2 * pairs);
        for bit in 0..2 * pairs as u16 {
            let literal = state.store.literal(Bit(bit)).map_err(|_| Limit::Memory)?;
            literals.push([literal.negated(), literal].map(|link| state.function(link)));
        }
        Ok(Self {
            shared: Arc::new(Shared {
                state: Mutex::new(state),
                capacity,
                yes,
                literals,
            }),
            limits: *limits,
        })
    }

    fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            shared: Arc::clone(&self.shared),
            limits: *limits,
        }
    }

    fn limits(&self) -> Limits {
        self.limits
    }

    fn order(&self) -> Order {
        self.state().store.order().clone()
    }

    fn constant(&self, value: bool) -> Function {
        Function {
            root: Arc::clone(&self.shared.yes.root),
            negated: !value,
        }
    }

    fn literal(&self, bit: Bit, positive: bool) -> Function {
        self.shared.literals[bit.index()][usize::from(positive)].clone()
    }

    fn is_true(&self, a: &Function) -> bool {
        *a == self.shared.yes
    }

    fn is_false(&self, a: &Function) -> bool {
        a.negated && a.root.id == self.shared.yes.root.id
    }

    fn not(&self, a: &Function) -> Result<Function, Limit> {
        Ok(Function {
            root: Arc::clone(&a.root),
            negated: !a.negated,
        })
    }

    fn and(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.and(a.link(), b.link()))
    }

    fn or(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.or(a.link(), b.link()))
    }

    fn and_not(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.and(a.link(), b.link().negated()))
    }

    fn xor(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.xor(a.link(), b.link()))
    }

    fn ite(&self, c: &Function, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.choice(c.link(), a.link(), b.link()))
    }

    fn and_exists(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        let cube = self.conjunction(bits)?;
        self.attempt(|store| store.product(a.link(), b.link(), cube.link()))
    }

    fn exists(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        let cube = self.conjunction(bits)?;
        self.attempt(|store| store.exists(a.link(), cube.link()))
    }

    fn restrict(&self, a: &Function, values: &[(Bit, bool)]) -> Result<Function, Limit> {
        let cube = self.cube(values)?;
        self.attempt(|store| store.restrict(a.link(), cube.link()))
    }

    fn prime(&self, a: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.rename(a.link(), true))
    }

    fn unprime(&self, a: &Function) -> Result<Function, Limit> {
        self.attempt(|store| store.rename(a.link(), false))
    }

    fn size(&self, a: &Function) -> usize {
        let mut count = 0;
        self.state()
            .store
            .walk([a.link()], &mut |_, _, _, _| count += 1);
        count
    }

    fn support(&self, a: &Function) -> Vec<Bit> {
        let mut depends = vec![false; self.shared.literals.len()];
        self.state()
            .store
            .walk([a.link()], &mut |_, bit, _, _| depends[bit.index()] = true);
        let bits = depends.into_iter().enumerate();
        bits.filter(|(_, depends)| *depends)
            .map(|(bit, _)| Bit(bit as u16))
            .collect()
    }

    fn witness(&self, a: &Function) -> Option<Vec<bool>> {
        if self.is_false(a) {
            return None;
        }
        let state = self.state();
        let mut bits = vec![false; self.shared.literals.len()];
        let mut here = a.link();
        while let Some(bit) = state.store.bit(here) {
            let (high, low) = state.store.children(here);
            let take_high = low == Link::FALSE;
            bits[bit.index()] = take_high;
            here = if take_high { high } else { low };
        }
        Some(bits)
    }

    fn export(&self, functions: &[&Function]) -> Diagram {
        let mut state = self.state();
        let links: Vec<Link> = functions.iter().map(|f| f.link()).collect();
        state.store.diagram(&links)
    }

    fn nodes(&self) -> u64 {
        self.state().nodes()
    }

    fn peak_nodes(&self) -> u64 {
        let mut state = self.state();
        state.note_peak();
        state.peak
    }

    fn work(&self) -> u64 {
        self.state().work()
    }

    fn safe_point(&self) -> Result<(), Limit> {
        self.limits.check_time()?;
        let mut state = self.state();
        state.note_peak();
        let nodes = state.nodes();
        let made = nodes.saturating_sub(state.before);
        state.before = nodes;
        state.work_before = state.store.work();
        state.busiest = state.busiest.max(made);
        state.made += made;
        if state.reordering && state.busiest > REORDER_NODES.max(2 * state.busiest_at_sifting) {
            let work = state.made.saturating_mul(SIFT_WORK_PER_NODE);
            state.sift_within(work as usize, self.shared.capacity, &self.limits);
        } else if nodes >= COLLECT_NODES.max(3 * state.collected) {
            state.collect();
            state.before = state.nodes();
        }
        Ok(())
    }

    fn ignore_growth(&self) {
        let mut state = self.state();
        state.before = state.nodes();
        state.work_before = state.store.work();
    }

    fn sift(&self) -> Result<(), Limit> {
        self.limits.check_time()?;
        self.state()
            .sift_within(usize::MAX, self.shared.capacity, &self.limits);
        Ok(())
    }

    fn set_reordering(&self, allowed: bool) {
        self.state().reordering = allowed;
    }
}
