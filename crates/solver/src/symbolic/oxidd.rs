//! The kernel over `OxiDD`'s diagrams with complement edges: one store for all functions, and a
//! cache that persists across operations.
//!
//! Suited to large games. The store's capacity is fixed at creation, but its memory pages are used
//! only as nodes are created. Three properties of the package shape this file:
//!
//! - Garbage collection clears the cache. So it is normally done only at safe points, and only when
//!   the store has grown to three times its size after the last collection.
//! - The package's own collector runs concurrently with the operation that fills the store, and can
//!   start too late. The operation then fails although most nodes are dead. So a failed operation
//!   is repeated after a collection.
//! - Running out of nodes while levels are swapped aborts the process. So nothing is reordered
//!   without headroom in the store.
//!
//! If the number of nodes or the work is limited in addition to the memory ([`Ration`]), the result
//! must not depend on when the package's collector runs. In that case the store has headroom, and
//! the nodes are counted after every operation. Once an operation comes near the collector's
//! threshold, this and all later operations fail. So garbage is collected only between operations,
//! when the node count requires it, and the number of created nodes depends only on the operations:
//! if a result is lost from the cache, computing it again creates no nodes, because its nodes still
//! exist.

use super::{Bit, BitSet, Diagram, DiagramNode, Edge, Kernel, Limit, Limits, Order, sift};
use oxidd::bcdd::{BCDDFunction, BCDDManagerRef, new_manager};
use oxidd::util::{AllocResult, Ref};
use oxidd::{
    BooleanFunction, BooleanFunctionQuant, BooleanOperator, Function as _, FunctionSubst, HasLevel,
    InnerNode, Manager, ManagerRef, Node, Subst, VarNo,
};
use oxidd_core::LevelView as _;
use oxidd_reorder::set_var_order_seq;
use rustc_hash::{FxHashMap, FxHashSet};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes per node, including its slot in the unique table.
const BYTES_PER_NODE: u64 = 28;

/// Capacity of the store in nodes without a memory limit: about 3.5 GiB when full.
const USUAL_NODES: u64 = 1 << 27;

/// Maximum number of nodes that the package can address.
const MAX_NODES: u64 = 1 << 30;

/// Minimum useful capacity of the store in nodes.
const MIN_NODES: u64 = 1 << 16;

/// Number of cache entries. A larger cache costs more than it saves: every collection clears it,
/// and it no longer fits into the processor's caches.
const LARGE_CACHE: usize = 1 << 18;

/// Number of cache entries for at most [`FEW_PAIRS`] pairs, if only memory is limited.
const SMALL_CACHE: usize = 1 << 17;

/// Maximum number of pairs for [`SMALL_CACHE`].
const FEW_PAIRS: usize = 48;

/// Minimum number of nodes in the store for a collection at a safe point.
const COLLECT_NODES: u64 = 1 << 19;

/// Maximum number of nodes created since the last collection for which reordering starts without a
/// collection.
const FEW_DEAD_NODES: u64 = 10_000;

/// Minimum number of nodes created between two safe points that triggers reordering.
const REORDER_NODES: u64 = 18_000;

/// Maximum number of nodes that sifting at a safe point may touch per node created since the last
/// sifting, so that sifting takes a bounded share of all work.
const SIFT_WORK_PER_NODE: u64 = 60;

/// Units of work per created node, and per operation. A node of this kernel is looked up in a
/// common table and moved when the order changes, and so takes about this many times as long as a
/// node that is owned by a single function.
const WORK_PER_NODE: u64 = 10;

/// Number of node slots that the package allocates at once. Only at such an allocation does the
/// package compare the node count with the threshold of its collector.
const CHUNK_NODES: u64 = 1 << 16;

/// The store is reordered only if the new order needs less than this percentage of the current
/// nodes.
const WORTHWHILE_PERCENT: usize = 98;

/// A boolean function.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Function(BCDDFunction);

impl fmt::Debug for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} nodes", self.0.node_count())
    }
}

/// State shared by all clones of a kernel.
struct Shared {
    store: BCDDManagerRef,
    /// Maximum number of nodes: the store's capacity, or the node limit if that is lower.
    capacity: u64,
    yes: Function,
    no: Function,
    /// The negated and the positive literal of each bit.
    literals: Vec<[Function; 2]>,
    to_primed: Subst<BCDDFunction>,
    to_current: Subst<BCDDFunction>,
    cubes: Mutex<FxHashMap<BitSet, Function>>,
    peak: AtomicU64,
    /// Number of nodes left after the last collection.
    collected: AtomicU64,
    /// Number of nodes at the last safe point.
    before: AtomicU64,
    /// Number of nodes created since the last sifting.
    made: AtomicU64,
    /// Since the last sifting, the largest number of nodes created between two consecutive safe
    /// points.
    busiest: AtomicU64,
    /// Value of `busiest` at the last sifting.
    busiest_at_sifting: AtomicU64,
    /// Whether safe points may change the order.
    reordering: AtomicBool,
    ration: Option<Ration>,
}

/// Counters for limits on nodes and work.
#[derive(Debug)]
struct Ration {
    /// If an operation reaches this node count, the package's collector might have run during it.
    threshold: u64,
    /// Whether an operation has reached the threshold.
    overrun: AtomicBool,
    /// Number of nodes after the last operation.
    nodes: AtomicU64,
    /// Units of work done: created nodes and operations.
    work: AtomicU64,
}

impl Ration {
    /// Returns the capacity of the store, the maximum number of nodes in use, and fresh counters.
    /// `most` is the requested maximum, and `fit` the number of nodes that fit into memory.
    fn new(most: u64, fit: u64) -> (u64, u64, Self) {
        let wanted = 2 * most.saturating_add(2 * CHUNK_NODES);
        let capacity = wanted.min(fit);
        let most = most.min((capacity / 2).saturating_sub(CHUNK_NODES));
        let ration = Self {
            // The collector starts when 95 % of the store is in use.
            threshold: (capacity / 100 * 95).saturating_sub(CHUNK_NODES),
            overrun: AtomicBool::new(false),
            nodes: AtomicU64::new(0),
            work: AtomicU64::new(0),
        };
        (capacity, most, ration)
    }
}

/// The kernel over `OxiDD`.
#[derive(Clone)]
pub struct OxiDd {
    shared: Arc<Shared>,
    limits: Limits,
}

impl fmt::Debug for OxiDd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = self.nodes();
        f.debug_struct("OxiDd").field("nodes", &nodes).finish()
    }
}

impl OxiDd {
    /// Runs an operation; if the store is full, collects garbage and repeats the operation, at most
    /// twice.
    fn attempt(
        &self,
        operation: impl Fn() -> AllocResult<BCDDFunction>,
    ) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if let Some(ration) = &self.shared.ration {
            return self.attempt_within(ration, operation);
        }
        for _ in 0..2 {
            if let Ok(function) = operation() {
                return Ok(Function(function));
            }
            self.note_peak();
            self.collect();
            if self.nodes() > self.shared.capacity / 10 * 9 {
                return Err(Limit::Memory);
            }
            self.limits.check_time()?;
        }
        operation().map(Function).map_err(|_| Limit::Memory)
    }

    /// Runs an operation under limits on nodes and work, and counts its work.
    fn attempt_within(
        &self,
        ration: &Ration,
        operation: impl Fn() -> AllocResult<BCDDFunction>,
    ) -> Result<Function, Limit> {
        if ration.overrun.load(Ordering::Relaxed) {
            return Err(Limit::Memory);
        }
        self.limits
            .check_work(ration.work.load(Ordering::Relaxed))?;
        let collections = || self.shared.store.with_manager_shared(|m| m.gc_count());
        let collected = collections();
        let result = operation();
        let nodes = self.nodes();
        // The node count is read before the number of collections. So if a collection has removed
        // nodes from the count, the number of collections shows it.
        if nodes >= ration.threshold || result.is_err() || collections() != collected {
            ration.overrun.store(true, Ordering::Relaxed);
            return Err(Limit::Memory);
        }
        let made = nodes.saturating_sub(ration.nodes.swap(nodes, Ordering::Relaxed));
        ration
            .work
            .fetch_add(WORK_PER_NODE * (1 + made), Ordering::Relaxed);
        if nodes > self.shared.capacity {
            self.note_peak();
            self.collect();
            if self.nodes() > self.shared.capacity / 10 * 9 {
                return Err(Limit::Memory);
            }
        }
        result.map(Function).map_err(|_| Limit::Memory)
    }

    fn note_peak(&self) {
        self.shared.peak.fetch_max(self.nodes(), Ordering::Relaxed);
    }

    fn collect(&self) {
        self.shared.store.with_manager_shared(|m| m.gc());
        self.note_left();
    }

    /// Records the number of nodes left by a collection, and returns it.
    fn note_left(&self) -> u64 {
        let left = self.nodes();
        self.shared.collected.store(left, Ordering::Relaxed);
        if let Some(ration) = &self.shared.ration {
            ration.nodes.store(left, Ordering::Relaxed);
        }
        left
    }

    /// Searches for a better order, touching at most `work` nodes, and reorders the store if the
    /// new order is worthwhile.
    fn sift_within(&self, work: usize) -> Result<(), Limit> {
        self.limits.check_time()?;
        self.note_peak();
        // Dead nodes would be reordered, too, so they are collected first. If there are only a few,
        // moving them is cheaper than a collection.
        if self.nodes() > self.shared.collected.load(Ordering::Relaxed) + FEW_DEAD_NODES {
            self.collect();
        }
        let live_nodes = self.live_nodes();
        if self.nodes() < self.shared.capacity / 3
            && let Some((order, before, after)) =
                sift::sift(&live_nodes, &self.order(), work, &self.limits)
            && after * 100 < before * WORTHWHILE_PERCENT
        {
            drop(live_nodes);
            set_order(&self.shared.store, &order);
        }
        let left = self.note_left();
        let busiest = self.shared.busiest.swap(0, Ordering::Relaxed);
        self.shared.made.store(0, Ordering::Relaxed);
        self.shared
            .busiest_at_sifting
            .store(busiest, Ordering::Relaxed);
        self.shared.before.store(left, Ordering::Relaxed);
        Ok(())
    }

    /// Returns all live nodes of the store. The nodes referenced from outside the store are the
    /// roots.
    fn live_nodes(&self) -> Diagram {
        self.shared.store.with_manager_shared(|m| {
            let mut nodes = Vec::new();
            // For each node, the number of all references, and of references by other nodes.
            let mut references: Vec<(usize, usize)> = Vec::new();
            let mut numbers: FxHashMap<usize, usize> = FxHashMap::default();
            for level in (0..m.num_levels()).rev() {
                let bit = Bit(m.level_to_var(level) as u16);
                for edge in m.level(level).iter() {
                    let Node::Inner(node) = m.get_node(edge) else {
                        continue;
                    };
                    let mut child = |n: usize| {
                        let child = node.child(n);
                        let negated = is_negated(m, &child);
                        match m.get_node(child) {
                            Node::Terminal(_) => Edge::TRUE.flipped(negated),
                            Node::Inner(_) => {
                                let number = numbers[&child.node_id()];
                                references[number].1 += 1;
                                Edge::to(number).flipped(negated)
                            }
                        }
                    };
                    let (high, low) = (child(0), child(1));
                    numbers.insert(edge.node_id(), nodes.len());
                    nodes.push(DiagramNode { bit, high, low });
                    references.push((node.ref_count(), 0));
                }
            }
            let roots = external_roots(&nodes, &mut references);
            compact(&nodes, &roots, &references)
        })
    }

    /// Returns the conjunction of the bits, which is how the package represents a set of bits.
    fn conjunction(&self, bits: &BitSet) -> Result<Function, Limit> {
        let mut cubes = self
            .shared
            .cubes
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(cube) = cubes.get(bits) {
            return Ok(cube.clone());
        }
        let literals: Vec<(Bit, bool)> = bits.iter().map(|b| (b, true)).collect();
        let cube = self.cube(&literals)?;
        cubes.insert(bits.clone(), cube.clone());
        Ok(cube)
    }
}

/// Returns the nodes referenced from outside the store. `references` holds, for each node, the
/// number of all references and of references by nodes; the references by dead nodes are subtracted
/// from both.
fn external_roots(nodes: &[DiagramNode], references: &mut [(usize, usize)]) -> Vec<usize> {
    let mut roots = Vec::new();
    for n in (0..nodes.len()).rev() {
        let (all, by_nodes) = references[n];
        if all == 0 {
            for child in [nodes[n].high, nodes[n].low]
                .into_iter()
                .filter_map(Edge::node)
            {
                references[child].0 -= 1;
                references[child].1 -= 1;
            }
        } else if all > by_nodes {
            roots.push(n);
        }
    }
    roots
}

/// Returns a diagram of those nodes that have references.
fn compact(nodes: &[DiagramNode], roots: &[usize], references: &[(usize, usize)]) -> Diagram {
    let mut places = vec![0; nodes.len()];
    let mut left: Vec<DiagramNode> = Vec::new();
    for (n, node) in nodes.iter().enumerate() {
        if references[n].0 > 0 {
            let at = |edge: Edge| match edge.node() {
                Some(child) => Edge::to(places[child]).flipped(edge.is_negated()),
                None => edge,
            };
            let (high, low) = (at(node.high), at(node.low));
            places[n] = left.len();
            left.push(DiagramNode {
                bit: node.bit,
                high,
                low,
            });
        }
    }
    let roots = roots.iter().map(|n| Edge::to(places[*n])).collect();
    Diagram { nodes: left, roots }
}

/// Returns the order of the pairs in a store.
fn order_of(store: &BCDDManagerRef) -> Order {
    store.with_manager_shared(|m| {
        let levels = (0..m.num_levels()).step_by(2);
        let pairs = levels.map(|l| (m.level_to_var(l) / 2) as u16);
        Order::new(pairs.collect()).expect("twins are not adjacent; please report this")
    })
}

/// Changes a store to this order of the pairs.
fn set_order(store: &BCDDManagerRef, order: &Order) {
    let variables = order.pairs().iter().map(|p| 2 * VarNo::from(*p));
    let variables: Vec<VarNo> = variables.flat_map(|v| [v, v + 1]).collect();
    store.with_manager_exclusive(|m| set_var_order_seq(m, &variables));
}

/// Calls `visit` with the bit and the edges of every node of `function`, children first. `visit`
/// returns the node's number, which `numbers` stores by the package's node id. Returns the root
/// edge.
fn walk(
    function: &Function,
    numbers: &mut FxHashMap<usize, usize>,
    visit: &mut impl FnMut(Bit, Edge, Edge) -> usize,
) -> Edge {
    fn edge_of<M: Manager>(
        manager: &M,
        edge: Ref<'_, M::Edge>,
        numbers: &mut FxHashMap<usize, usize>,
        visit: &mut impl FnMut(Bit, Edge, Edge) -> usize,
    ) -> Edge
    where
        M::InnerNode: HasLevel,
    {
        let negated = is_negated(manager, &edge);
        let Node::Inner(node) = manager.get_node(edge) else {
            return Edge::TRUE.flipped(negated);
        };
        let id = edge.node_id();
        let number = if let Some(number) = numbers.get(&id) {
            *number
        } else {
            let high = edge_of(manager, node.child(0), numbers, visit);
            let low = edge_of(manager, node.child(1), numbers, visit);
            let bit = Bit(manager.level_to_var(node.level()) as u16);
            let number = visit(bit, high, low);
            numbers.insert(id, number);
            number
        };
        Edge::to(number).flipped(negated)
    }
    function
        .0
        .with_manager_shared(|manager, edge| edge_of(manager, edge, numbers, visit))
}

impl Kernel for OxiDd {
    type Function = Function;

    const NAME: &'static str = "oxidd";

    const REORDERS: bool = true;

    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit> {
        let pairs = order.pairs().len();
        let most = limits.nodes(BYTES_PER_NODE, USUAL_NODES, MAX_NODES);
        let is_limited = limits.max_nodes.is_some() || limits.max_work.is_some();
        let (room, capacity, fit, ration) = if is_limited {
            let by_memory = Limits {
                max_nodes: None,
                ..*limits
            };
            let fit = by_memory.nodes(BYTES_PER_NODE, USUAL_NODES, MAX_NODES);
            let (room, most, ration) = Ration::new(most, fit);
            (room, most, fit, Some(ration))
        } else {
            (most, most, most, None)
        };
        // If the cache is too small, an operation can run for ever and yet create no nodes that a
        // budget would count. So a node budget does not reduce the cache.
        let cache = if pairs > FEW_PAIRS || is_limited {
            LARGE_CACHE
        } else {
            SMALL_CACHE
        };
        if room < MIN_NODES {
            return Err(Limit::Memory);
        }
        let cache = cache.min(usize::try_from(fit / 8).unwrap_or(cache));
        let store = new_manager(room as usize, cache, 1);
        let variables = 2 * pairs as VarNo;
        store.with_manager_exclusive(|m| {
            m.add_vars(variables);
        });
        set_order(&store, order);
        let literals: AllocResult<Vec<[Function; 2]>> = store.with_manager_shared(|m| {
            (0..variables)
                .map(|v| {
                    let (no, yes) = (BCDDFunction::not_var(m, v)?, BCDDFunction::var(m, v)?);
                    Ok([Function(no), Function(yes)])
                })
                .collect()
        });
        let literals = literals.map_err(|_| Limit::Memory)?;
        let (current, primed): (Vec<VarNo>, Vec<VarNo>) = (0..variables).partition(|v| v % 2 == 0);
        let functions = |of: &[VarNo]| -> Vec<BCDDFunction> {
            let positive = of.iter().map(|v| &literals[*v as usize][1].0);
            positive.cloned().collect()
        };
        let yes = Function(store.with_manager_shared(|m| BCDDFunction::t(m)));
        let no = Function(store.with_manager_shared(|m| BCDDFunction::f(m)));
        Ok(Self {
            shared: Arc::new(Shared {
                to_primed: Subst::new(current.clone(), functions(&primed)),
                to_current: Subst::new(primed, functions(&current)),
                literals,
                yes,
                no,
                store,
                capacity,
                cubes: Mutex::default(),
                peak: AtomicU64::new(0),
                collected: AtomicU64::new(0),
                busiest_at_sifting: AtomicU64::new(0),
                before: AtomicU64::new(0),
                made: AtomicU64::new(0),
                busiest: AtomicU64::new(0),
                reordering: AtomicBool::new(true),
                ration,
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
        order_of(&self.shared.store)
    }

    fn constant(&self, value: bool) -> Function {
        if value {
            self.shared.yes.clone()
        } else {
            self.shared.no.clone()
        }
    }

    fn literal(&self, bit: Bit, positive: bool) -> Function {
        self.shared.literals[bit.index()][usize::from(positive)].clone()
    }

    fn is_true(&self, a: &Function) -> bool {
        *a == self.shared.yes
    }

    fn is_false(&self, a: &Function) -> bool {
        *a == self.shared.no
    }

    fn not(&self, a: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.not())
    }

    fn and(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.and(&b.0))
    }

    fn or(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.or(&b.0))
    }

    fn and_not(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|| b.0.imp_strict(&a.0))
    }

    fn xor(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.xor(&b.0))
    }

    fn ite(&self, c: &Function, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.attempt(|| c.0.ite(&a.0, &b.0))
    }

    fn and_exists(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        if bits.is_empty() {
            return self.and(a, b);
        }
        let cube = self.conjunction(bits)?;
        self.attempt(|| a.0.apply_exists(BooleanOperator::And, &b.0, &cube.0))
    }

    fn exists(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        if bits.is_empty() {
            return Ok(a.clone());
        }
        let cube = self.conjunction(bits)?;
        self.attempt(|| a.0.exists(&cube.0))
    }

    fn restrict(&self, a: &Function, values: &[(Bit, bool)]) -> Result<Function, Limit> {
        if values.is_empty() {
            return Ok(a.clone());
        }
        let cube = self.cube(values)?;
        self.attempt(|| a.0.restrict(&cube.0))
    }

    fn prime(&self, a: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.substitute(&self.shared.to_primed))
    }

    fn unprime(&self, a: &Function) -> Result<Function, Limit> {
        self.attempt(|| a.0.substitute(&self.shared.to_current))
    }

    fn size(&self, a: &Function) -> usize {
        a.0.node_count()
    }

    fn support(&self, a: &Function) -> Vec<Bit> {
        let mut bits = FxHashSet::default();
        let mut count = 0;
        walk(a, &mut FxHashMap::default(), &mut |bit, _, _| {
            bits.insert(bit);
            count += 1;
            count
        });
        let mut bits: Vec<Bit> = bits.into_iter().collect();
        bits.sort_unstable();
        bits
    }

    fn witness(&self, a: &Function) -> Option<Vec<bool>> {
        if self.is_false(a) {
            return None;
        }
        let mut bits = vec![false; self.shared.literals.len()];
        let mut here = a.clone();
        let level = |f: &Function| {
            f.0.with_manager_shared(|m, edge| match m.get_node(edge) {
                Node::Inner(node) => Some(m.level_to_var(node.level())),
                Node::Terminal(_) => None,
            })
        };
        while let (Some(variable), Some((high, low))) = (level(&here), here.0.cofactors()) {
            let take_high = low == self.shared.no.0;
            bits[variable as usize] = take_high;
            here = Function(if take_high { high } else { low });
        }
        Some(bits)
    }

    fn export(&self, functions: &[&Function]) -> Diagram {
        let mut nodes: Vec<DiagramNode> = Vec::new();
        let mut numbers = FxHashMap::default();
        let roots = functions.iter().map(|f| {
            walk(f, &mut numbers, &mut |bit, high, low| {
                nodes.push(DiagramNode { bit, high, low });
                nodes.len() - 1
            })
        });
        let roots = roots.collect();
        Diagram { nodes, roots }
    }

    fn nodes(&self) -> u64 {
        self.shared
            .store
            .with_manager_shared(|m| m.num_inner_nodes()) as u64
    }

    fn peak_nodes(&self) -> u64 {
        self.note_peak();
        self.shared.peak.load(Ordering::Relaxed)
    }

    fn work(&self) -> u64 {
        let ration = self.shared.ration.as_ref();
        ration.map_or(0, |r| r.work.load(Ordering::Relaxed))
    }

    fn safe_point(&self) -> Result<(), Limit> {
        self.limits.check_time()?;
        let nodes = self.nodes();
        self.shared.peak.fetch_max(nodes, Ordering::Relaxed);
        let before = self.shared.before.swap(nodes, Ordering::Relaxed);
        let made = nodes.saturating_sub(before);
        self.shared.busiest.fetch_max(made, Ordering::Relaxed);
        self.shared.made.fetch_add(made, Ordering::Relaxed);
        let collected = self.shared.collected.load(Ordering::Relaxed);
        let last = self.shared.busiest_at_sifting.load(Ordering::Relaxed);
        if self.shared.reordering.load(Ordering::Relaxed)
            && self.shared.busiest.load(Ordering::Relaxed) > REORDER_NODES.max(2 * last)
        {
            let made = self.shared.made.load(Ordering::Relaxed);
            return self.sift_within(made.saturating_mul(SIFT_WORK_PER_NODE) as usize);
        }
        if nodes < COLLECT_NODES.max(3 * collected) {
            return Ok(());
        }
        self.collect();
        self.shared.before.store(self.nodes(), Ordering::Relaxed);
        Ok(())
    }

    fn sift(&self) -> Result<(), Limit> {
        self.sift_within(usize::MAX)
    }

    fn set_reordering(&self, allowed: bool) {
        self.shared.reordering.store(allowed, Ordering::Relaxed);
    }
}

/// Whether an edge is complemented.
fn is_negated<M: Manager>(_: &M, edge: &Ref<'_, M::Edge>) -> bool {
    edge.tag() != M::EdgeTag::default()
}
