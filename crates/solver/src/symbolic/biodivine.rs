//! The kernel over biodivine-lib-bdd: every function owns its nodes.
//!
//! Suited to many small contracts: a new kernel takes a few kilobytes, the package is safe Rust,
//! and functions can be sent between threads. Clones of a [`Function`] share its nodes in an `Arc`.
//! A meter counts the live nodes, for the memory limit and [`Kernel::peak_nodes`]. The order is
//! fixed at creation.
//!
//! The package's fused relational product can be neither limited nor cancelled. So it is used only
//! if the operands are small enough for their product to be harmless. For larger operands,
//! conjunction and quantification are separate operations, each with a limit.

use super::{Bit, BitSet, Diagram, DiagramNode, Edge, Kernel, Limit, Limits, MAX_PAIRS, Order};
use biodivine_lib_bdd::{Bdd, BddNode, BddValuation, BddVariable, BddVariableSet, op_function};
use std::collections::HashMap;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Counts of nodes and work, shared by a kernel and its functions.
#[derive(Debug, Default)]
struct Meter {
    /// Number of live nodes.
    live: AtomicUsize,
    /// Peak number of live nodes.
    peak: AtomicUsize,
    /// Number of nodes created in total.
    made: AtomicUsize,
    /// Work done: nodes read, nodes created, and operations.
    work: AtomicU64,
}

/// The nodes of one function. Dropping this value subtracts their number from the live nodes.
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

/// A boolean function.
#[derive(Debug, Clone)]
pub struct Function(Arc<Owned>);

impl Function {
    fn bdd(&self) -> &Bdd {
        &self.0.bdd
    }

    fn size(&self) -> usize {
        self.0.bdd.size()
    }

    fn is_true(&self) -> bool {
        self.0.bdd.is_true()
    }

    fn is_false(&self) -> bool {
        self.0.bdd.is_false()
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

/// Bytes per node, including the tables of the operation that creates it.
const BYTES_PER_NODE: u64 = 48;

/// Maximum number of nodes if no memory limit is set. The package's 32-bit pointers must be able to
/// address all nodes of a function.
const MAX_NODES: u64 = 1 << 28;

/// Maximum product of the operands' sizes for which the fused operations are safe without a limit.
const FUSED_PRODUCT: usize = 1 << 24;

/// The kernel over biodivine-lib-bdd.
#[derive(Debug, Clone)]
pub struct Biodivine {
    variables: Arc<BddVariableSet>,
    /// Position of each pair in the order.
    positions: Arc<Vec<u16>>,
    order: Arc<Order>,
    limits: Limits,
    max_nodes: usize,
    meter: Arc<Meter>,
}

impl Biodivine {
    fn variable(&self, bit: Bit) -> BddVariable {
        let position = usize::from(self.positions[usize::from(bit.pair())]);
        BddVariable::from_index(2 * position + (bit.index() & 1))
    }

    fn bit(&self, variable: BddVariable) -> Bit {
        let index = variable.to_index();
        Bit(2 * self.order.pairs()[index / 2] + (index & 1) as u16)
    }

    /// Returns, for each variable by index, whether the set contains its bit.
    fn mask(&self, bits: &BitSet) -> Vec<bool> {
        let mut mask = vec![false; 2 * self.positions.len()];
        for bit in bits.iter() {
            mask[self.variable(bit).to_index()] = true;
        }
        mask
    }

    /// Renames every variable of a function. Twins are adjacent, so the order is preserved unless
    /// the function depends on both bits of a pair.
    fn shift(&self, a: &Function, rename: impl Fn(usize) -> usize) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size() <= 2 {
            return Ok(a.clone());
        }
        self.charge(&[a]);
        let mut nodes: Vec<BddNode> = a.bdd().clone().to_nodes();
        for node in nodes.iter_mut().skip(2) {
            node.var = BddVariable::from_index(rename(node.var.to_index()));
        }
        let shifted = Bdd::from_nodes(&nodes)
            .expect("a function to rename depends on both bits of a pair; please report this");
        self.limited(Some(shifted))
    }

    fn apply(
        &self,
        a: &Function,
        b: &Function,
        op: fn(Option<bool>, Option<bool>) -> Option<bool>,
    ) -> Result<Function, Limit> {
        self.limits.check_time()?;
        self.charge(&[a, b]);
        let result = Bdd::binary_op_with_limit(self.room()?, a.bdd(), b.bdd(), op);
        self.limited(result)
    }

    /// Adds the work of one operation on these operands.
    fn charge(&self, operands: &[&Function]) {
        let nodes: usize = operands.iter().map(|f| f.size()).sum();
        self.meter
            .work
            .fetch_add(1 + nodes as u64, Ordering::Relaxed);
    }

    /// Returns the number of nodes that can still be created, or the limit that was reached.
    fn room(&self) -> Result<usize, Limit> {
        self.limits.check_work(self.work())?;
        let made = self.meter.made.load(Ordering::Relaxed);
        if self
            .limits
            .max_created
            .is_some_and(|most| made as u64 > most)
        {
            return Err(Limit::Memory);
        }
        let live = self.meter.live.load(Ordering::Relaxed);
        let left = self.limits.deadline.memory_left() / BYTES_PER_NODE;
        let left = usize::try_from(left).unwrap_or(usize::MAX);
        match self.max_nodes.checked_sub(live).map(|room| room.min(left)) {
            Some(room) if room > 2 => Ok(room),
            _ => Err(Limit::Memory),
        }
    }

    fn limited(&self, result: Option<Bdd>) -> Result<Function, Limit> {
        let bdd = result.ok_or(Limit::Memory)?;
        self.meter
            .work
            .fetch_add(bdd.size() as u64, Ordering::Relaxed);
        let function = self.keep(bdd);
        self.room()?;
        Ok(function)
    }

    fn keep(&self, bdd: Bdd) -> Function {
        let size = bdd.size();
        let live = self.meter.live.fetch_add(size, Ordering::Relaxed) + size;
        self.meter.peak.fetch_max(live, Ordering::Relaxed);
        self.meter.made.fetch_add(size, Ordering::Relaxed);
        Function(Arc::new(Owned {
            bdd,
            meter: Arc::clone(&self.meter),
        }))
    }
}

impl Kernel for Biodivine {
    type Function = Function;

    const NAME: &'static str = "biodivine";

    const REORDERS: bool = false;

    fn new(order: &Order, limits: &Limits) -> Result<Self, Limit> {
        if order.pairs().len() > MAX_PAIRS {
            return Err(Limit::Bits);
        }
        let variables = 2 * order.pairs().len();
        Ok(Self {
            variables: Arc::new(BddVariableSet::new_anonymous(variables as u16)),
            positions: Arc::new(order.positions()),
            order: Arc::new(order.clone()),
            limits: *limits,
            max_nodes: max_nodes(limits),
            meter: Arc::default(),
        })
    }

    fn with_limits(&self, limits: &Limits) -> Self {
        Self {
            limits: *limits,
            max_nodes: max_nodes(limits),
            ..self.clone()
        }
    }

    fn limits(&self) -> Limits {
        self.limits
    }

    fn order(&self) -> Order {
        (*self.order).clone()
    }

    fn constant(&self, value: bool) -> Function {
        self.keep(if value {
            self.variables.mk_true()
        } else {
            self.variables.mk_false()
        })
    }

    fn literal(&self, bit: Bit, positive: bool) -> Function {
        self.keep(self.variables.mk_literal(self.variable(bit), positive))
    }

    fn is_true(&self, a: &Function) -> bool {
        a.is_true()
    }

    fn is_false(&self, a: &Function) -> bool {
        a.is_false()
    }

    fn not(&self, a: &Function) -> Result<Function, Limit> {
        self.limits.check_time()?;
        self.charge(&[a]);
        self.limited(Some(a.bdd().not()))
    }

    fn and(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_true() || a == b || b.is_false() {
            return Ok(b.clone());
        }
        if b.is_true() || a.is_false() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::and)
    }

    fn or(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_false() || a == b || b.is_true() {
            return Ok(b.clone());
        }
        if b.is_false() || a.is_true() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::or)
    }

    fn and_not(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_false() || b.is_false() {
            return Ok(a.clone());
        }
        self.apply(a, b, op_function::and_not)
    }

    fn xor(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.apply(a, b, op_function::xor)
    }

    fn implies(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        if a.is_true() {
            return Ok(b.clone());
        }
        self.apply(a, b, op_function::imp)
    }

    fn iff(&self, a: &Function, b: &Function) -> Result<Function, Limit> {
        self.apply(a, b, op_function::iff)
    }

    fn ite(&self, c: &Function, a: &Function, b: &Function) -> Result<Function, Limit> {
        if c.is_true() || a == b {
            return Ok(a.clone());
        }
        if c.is_false() {
            return Ok(b.clone());
        }
        let (yes, no) = (self.and(c, a)?, self.and_not(b, c)?);
        self.or(&yes, &no)
    }

    fn exists(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.and_exists(a, a, bits)
    }

    fn forall(&self, a: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.implies_forall(&self.constant(true), a, bits)
    }

    fn and_exists(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        if a.is_false() || b.is_false() {
            return Ok(self.constant(false));
        }
        if bits.is_empty() {
            return self.and(a, b);
        }
        self.limits.check_time()?;
        let mask = self.mask(bits);
        if a.size().saturating_mul(b.size()) <= FUSED_PRODUCT {
            self.charge(&[a, b]);
            return self.limited(Some(Bdd::binary_op_with_exists_trigger(
                a.bdd(),
                b.bdd(),
                |v| mask[v.to_index()],
                op_function::and,
            )));
        }
        // Bits are eliminated from the bottom up, because eliminating a lower bit affects fewer
        // nodes.
        let mut result = self.and(a, b)?;
        for index in (0..mask.len()).rev().filter(|i| mask[*i]) {
            let variable = BddVariable::from_index(index);
            if result.bdd().support_set_contains(&variable) {
                self.limits.check_time()?;
                self.charge(&[&result, &result]);
                result = self.limited(Bdd::fused_binary_flip_op_with_limit(
                    self.room()?,
                    (result.bdd(), None),
                    (result.bdd(), Some(variable)),
                    None,
                    op_function::or,
                ))?;
            }
        }
        Ok(result)
    }

    fn implies_forall(&self, a: &Function, b: &Function, bits: &BitSet) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size().saturating_mul(b.size()) <= FUSED_PRODUCT {
            self.charge(&[a, b]);
            let mask = self.mask(bits);
            return self.limited(Some(Bdd::binary_op_with_for_all_trigger(
                a.bdd(),
                b.bdd(),
                |v| mask[v.to_index()],
                op_function::imp,
            )));
        }
        let broken = self.and_exists(a, &self.not(b)?, bits)?;
        self.not(&broken)
    }

    fn restrict(&self, a: &Function, values: &[(Bit, bool)]) -> Result<Function, Limit> {
        self.limits.check_time()?;
        if a.size() <= 2 || values.is_empty() {
            return Ok(a.clone());
        }
        self.charge(&[a]);
        let values: Vec<_> = values
            .iter()
            .map(|(b, v)| (self.variable(*b), *v))
            .collect();
        self.limited(Some(a.bdd().restrict(&values)))
    }

    fn prime(&self, a: &Function) -> Result<Function, Limit> {
        self.shift(a, |v| v | 1)
    }

    fn unprime(&self, a: &Function) -> Result<Function, Limit> {
        self.shift(a, |v| v & !1)
    }

    fn size(&self, a: &Function) -> usize {
        a.size()
    }

    fn support(&self, a: &Function) -> Vec<Bit> {
        let variables = a.bdd().support_set().into_iter();
        let mut bits: Vec<Bit> = variables.map(|v| self.bit(v)).collect();
        bits.sort_unstable();
        bits
    }

    fn depends_on(&self, a: &Function, bit: Bit) -> bool {
        a.bdd().support_set_contains(&self.variable(bit))
    }

    fn witness(&self, a: &Function) -> Option<Vec<bool>> {
        let by_variable = a.bdd().first_valuation().map(BddValuation::into_vector)?;
        let bits = (0..by_variable.len()).map(|b| Bit(b as u16));
        Some(
            bits.map(|b| by_variable[self.variable(b).to_index()])
                .collect(),
        )
    }

    fn export(&self, functions: &[&Function]) -> Diagram {
        let mut diagram = Diagram::default();
        let mut known: HashMap<DiagramNode, Edge> = HashMap::new();
        for function in functions {
            // The package stores children before parents.
            let nodes = function.bdd().clone().to_nodes();
            let mut edges = vec![Edge::FALSE, Edge::TRUE];
            for node in nodes.iter().skip(2) {
                let decision = DiagramNode {
                    bit: self.bit(node.var),
                    high: edges[node.high_link.to_index()],
                    low: edges[node.low_link.to_index()],
                };
                let edge = *known.entry(decision).or_insert_with(|| {
                    diagram.nodes.push(decision);
                    Edge::to(diagram.nodes.len() - 1)
                });
                edges.push(edge);
            }
            let root = function.bdd().root_pointer().to_index();
            diagram.roots.push(edges[root.min(edges.len() - 1)]);
        }
        diagram
    }

    fn nodes(&self) -> u64 {
        self.meter.live.load(Ordering::Relaxed) as u64
    }

    fn peak_nodes(&self) -> u64 {
        self.meter.peak.load(Ordering::Relaxed) as u64
    }

    fn work(&self) -> u64 {
        self.meter.work.load(Ordering::Relaxed)
    }

    fn safe_point(&self) -> Result<(), Limit> {
        self.limits.check_time()
    }

    fn sift(&self) -> Result<(), Limit> {
        Ok(())
    }

    fn set_reordering(&self, _allowed: bool) {}
}

fn max_nodes(limits: &Limits) -> usize {
    usize::try_from(limits.nodes(BYTES_PER_NODE, MAX_NODES, MAX_NODES)).unwrap_or(usize::MAX)
}
