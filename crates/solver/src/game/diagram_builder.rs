//! A small diagram package, used in addition to a kernel for computing strategies as functions.
//!
//! Deriving functions from a relation takes thousands of small operations, most of which recur for
//! the next goal. The functions are also simplified with respect to a care set, which no kernel
//! here supports. This package does only that, so it is simple: one thread, one fixed order, a
//! lossy cache of results, and no garbage collection. Callers start a new builder from time to
//! time.
//!
//! [`DiagramBuilder::restrict`] is from Coudert and Madre, "A unified framework for the formal
//! verification of sequential circuits", ICCAD 1990.

use crate::symbolic::{Bit, BitSet, Diagram, DiagramNode, Edge, Kernel, Limit, Limits, Order};
use rustc_hash::FxHashMap;

/// Maximum number of nodes, even if there is no memory limit.
const MAX_NODES: u64 = 1 << 25;

/// Bytes per node, including its share of the tables.
const NODE_BYTES: u64 = 48;

/// Number of slots of the result cache; a power of two.
const CACHED_RESULTS: usize = 1 << 17;

/// Number of slots of the cache of [`Choices`]; a power of two.
const CACHED_CHOICES: usize = 1 << 15;

/// A simplification is abandoned after this many units of work, plus [`WORK_PER_NODE`] for each
/// node of the function. Without this limit, reducing `care` to the bits
/// on which the function depends could take arbitrarily long.
const BASE_WORK: u64 = 1_000;

/// See [`BASE_WORK`].
const WORK_PER_NODE: u64 = 2;

/// Minimum number of slots of the node table; a power of two.
const MIN_SLOTS: usize = 1 << 12;

/// Hashes three numbers to a value below 2^32.
fn spread(a: u32, b: u32, c: u32) -> u32 {
    let both = u64::from(b) << 32 | u64::from(c);
    let mixed = (both ^ u64::from(a).wrapping_mul(0x9e37_79b9_7f4a_7c15))
        .wrapping_mul(0xf135_7aea_2e62_a9c5);
    ((mixed ^ mixed >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32
}

/// A decision node. Its high edge is never negated, so that a function and its negation share a
/// node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Node {
    level: u32,
    high: Edge,
    low: Edge,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Operation {
    #[default]
    Nothing,
    And,
    Xor,
    Restrict,
}

/// An operation with its operands, and its result.
type CachedResult = ((Operation, u32, u32), Edge);

/// The values that a condition allows for one of its bits, as functions of the other bits.
#[derive(Debug, Clone, Copy)]
pub struct Choices {
    /// Where the condition holds if the bit is 1.
    pub may_set: Edge,
    /// Where the condition holds for at least one value of the bit.
    pub possible: Edge,
    /// Where the condition holds for exactly one value of the bit.
    pub forced: Edge,
}

/// A store of functions under construction.
#[derive(Debug)]
pub struct DiagramBuilder {
    nodes: Vec<Node>,
    /// Hash table with open addressing that holds node numbers plus one; 0 marks a free slot. Its
    /// entries are small, so that much of it stays in the processor's caches. The size is a power
    /// of two, at least twice the number of nodes.
    slots: Vec<u32>,
    results: Vec<CachedResult>,
    choices: Vec<(Edge, u32, Choices)>,
    /// Position of each pair in the order.
    positions: Vec<u16>,
    /// For each node, the mark of the last traversal that visited it.
    marks: Vec<u32>,
    /// Mark of the latest traversal.
    mark: u32,
    limits: Limits,
    max_nodes: usize,
    /// Units of work so far: operations on two nodes whose result was not known.
    work: u64,
    /// Value of `work` above which a simplification is abandoned.
    work_limit: u64,
}

/// Level of constants, below all others.
const BOTTOM: u32 = u32::MAX;

impl DiagramBuilder {
    /// Creates an empty builder.
    pub fn new(order: &Order, limits: &Limits) -> Self {
        let by_memory = limits
            .memory_mib
            .map(|mib| mib.saturating_mul(1 << 20) / NODE_BYTES);
        let bounds = [by_memory, limits.max_nodes].into_iter().flatten();
        Self {
            nodes: Vec::new(),
            slots: vec![0; MIN_SLOTS],
            results: Vec::new(),
            choices: Vec::new(),
            positions: order.positions(),
            marks: Vec::new(),
            mark: 0,
            limits: *limits,
            max_nodes: bounds.fold(MAX_NODES, u64::min) as usize,
            work: 0,
            work_limit: u64::MAX,
        }
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    fn level_of(&self, bit: Bit) -> u32 {
        2 * u32::from(self.positions[usize::from(bit.pair())]) + u32::from(bit.0 & 1)
    }

    /// Returns the level of an edge's target; [`BOTTOM`] for a constant.
    fn level(&self, edge: Edge) -> u32 {
        edge.node().map_or(BOTTOM, |n| self.nodes[n].level)
    }

    /// Returns an edge to the node with these branches, creating the node if necessary.
    fn decision(&mut self, level: u32, high: Edge, low: Edge) -> Result<Edge, Limit> {
        if high == low {
            return Ok(high);
        }
        let negate = high.is_negated();
        let node = Node {
            level,
            high: high.flipped(negate),
            low: low.flipped(negate),
        };
        let mut place = self.slot(node);
        while let Some(number) = self.slots[place].checked_sub(1) {
            if self.nodes[number as usize] == node {
                return Ok(Edge::to(number as usize).flipped(negate));
            }
            place = (place + 1) & (self.slots.len() - 1);
        }
        let fresh = self.nodes.len();
        if fresh >= self.max_nodes {
            return Err(Limit::Memory);
        }
        if fresh.is_multiple_of(1 << 14) {
            self.limits.check_time()?;
        }
        let is_last = 2 * (fresh + 1) > self.slots.len();
        if is_last {
            let bytes = 2 * size_of_val(&*self.slots) + self.nodes.len() * size_of::<Node>();
            if bytes as u64 > self.limits.deadline.memory_left() {
                return Err(Limit::Memory);
            }
        }
        self.nodes.push(node);
        self.slots[place] = fresh as u32 + 1;
        if is_last {
            self.widen();
        }
        Ok(Edge::to(fresh).flipped(negate))
    }

    /// Returns the slot at which the search for a node starts.
    fn slot(&self, node: Node) -> usize {
        spread(node.level, node.high.0, node.low.0) as usize & (self.slots.len() - 1)
    }

    /// Doubles the number of slots.
    fn widen(&mut self) {
        self.slots = vec![0; 2 * self.slots.len()];
        for number in 0..self.nodes.len() {
            let mut place = self.slot(self.nodes[number]);
            while self.slots[place] != 0 {
                place = (place + 1) & (self.slots.len() - 1);
            }
            self.slots[place] = number as u32 + 1;
        }
    }

    /// Returns the branches of an edge for the values 1 and 0 of the bit at this level. The level
    /// must not be below that of the edge's target.
    fn branches(&self, edge: Edge, level: u32) -> (Edge, Edge) {
        match edge.node().map(|n| self.nodes[n]) {
            Some(node) if node.level == level => {
                let negate = edge.is_negated();
                (node.high.flipped(negate), node.low.flipped(negate))
            }
            _ => (edge, edge),
        }
    }

    /// Counts a unit of work.
    fn spend(&mut self) -> Result<(), Limit> {
        self.work += 1;
        if self.work > self.work_limit {
            return Err(Limit::Size);
        }
        if self.work.is_multiple_of(1 << 14) {
            self.limits.check_time()?;
            self.limits.check_work(self.work)?;
        }
        Ok(())
    }

    fn place((operation, a, b): (Operation, u32, u32)) -> usize {
        spread(operation as u32, a, b) as usize & (CACHED_RESULTS - 1)
    }

    fn cached(&self, key: (Operation, u32, u32)) -> Option<Edge> {
        let (known, result) = self.results.get(Self::place(key))?;
        (*known == key).then_some(*result)
    }

    fn cache(&mut self, key: (Operation, u32, u32), result: Edge) {
        if self.results.is_empty() {
            self.results = vec![(<_>::default(), Edge::FALSE); CACHED_RESULTS];
        }
        let place = Self::place(key);
        self.results[place] = (key, result);
    }

    /// `a ∧ b`
    pub fn and(&mut self, a: Edge, b: Edge) -> Result<Edge, Limit> {
        let (a, b) = (a.min(b), a.max(b));
        // Constants are the smallest edges.
        if a == Edge::FALSE || a == b.negated() {
            return Ok(Edge::FALSE);
        }
        if a == Edge::TRUE || a == b {
            return Ok(b);
        }
        let key = (Operation::And, a.0, b.0);
        if let Some(known) = self.cached(key) {
            return Ok(known);
        }
        self.spend()?;
        let level = self.level(a).min(self.level(b));
        let ((a1, a0), (b1, b0)) = (self.branches(a, level), self.branches(b, level));
        let high = self.and(a1, b1)?;
        let low = self.and(a0, b0)?;
        let result = self.decision(level, high, low)?;
        self.cache(key, result);
        Ok(result)
    }

    /// `a ∨ b`
    pub fn or(&mut self, a: Edge, b: Edge) -> Result<Edge, Limit> {
        Ok(self.and(a.negated(), b.negated())?.negated())
    }

    /// `a ⊕ b`
    pub fn xor(&mut self, a: Edge, b: Edge) -> Result<Edge, Limit> {
        // A negated operand negates the result.
        let negate = a.is_negated() != b.is_negated();
        let (a, b) = (a.flipped(a.is_negated()), b.flipped(b.is_negated()));
        let (a, b) = (a.min(b), a.max(b));
        if a == b {
            return Ok(Edge::FALSE.flipped(negate));
        }
        if a == Edge::FALSE {
            return Ok(b.flipped(negate));
        }
        let key = (Operation::Xor, a.0, b.0);
        if let Some(known) = self.cached(key) {
            return Ok(known.flipped(negate));
        }
        self.spend()?;
        let level = self.level(a).min(self.level(b));
        let ((a1, a0), (b1, b0)) = (self.branches(a, level), self.branches(b, level));
        let high = self.xor(a1, b1)?;
        let low = self.xor(a0, b0)?;
        let result = self.decision(level, high, low)?;
        self.cache(key, result);
        Ok(result.flipped(negate))
    }

    /// Returns the values that a condition allows for one of its bits.
    pub fn choices(&mut self, f: Edge, bit: Bit) -> Result<Choices, Limit> {
        self.choices_at(f, self.level_of(bit))
    }

    fn choices_at(&mut self, f: Edge, level: u32) -> Result<Choices, Limit> {
        let top = self.level(f);
        if top > level {
            return Ok(Choices {
                may_set: f,
                possible: f,
                forced: Edge::FALSE,
            });
        }
        let (high, low) = self.branches(f, top);
        if top == level {
            return Ok(Choices {
                may_set: high,
                possible: self.or(high, low)?,
                forced: self.xor(high, low)?,
            });
        }
        let place = spread(level, f.0, 0) as usize & (CACHED_CHOICES - 1);
        if let Some((known, of, choices)) = self.choices.get(place)
            && (*known, *of) == (f, level)
        {
            return Ok(*choices);
        }
        self.spend()?;
        let high = self.choices_at(high, level)?;
        let low = self.choices_at(low, level)?;
        let choices = Choices {
            may_set: self.decision(top, high.may_set, low.may_set)?,
            possible: self.decision(top, high.possible, low.possible)?,
            forced: self.decision(top, high.forced, low.forced)?,
        };
        if self.choices.is_empty() {
            self.choices = vec![(Edge::FALSE, 0, choices); CACHED_CHOICES];
        }
        self.choices[place] = (f, level, choices);
        Ok(choices)
    }

    /// Returns a function that agrees with `f` wherever `care` holds and is likely to be smaller:
    /// it omits nodes of which only one branch matters.
    fn restrict(&mut self, f: Edge, care: Edge) -> Result<Edge, Limit> {
        if care == Edge::TRUE || care == Edge::FALSE || f.node().is_none() {
            return Ok(f);
        }
        let key = (Operation::Restrict, f.0 & !1, care.0);
        if let Some(known) = self.cached(key) {
            return Ok(known.flipped(f.is_negated()));
        }
        if self.work > self.work_limit {
            return Ok(f);
        }
        let (level, care_level) = (self.level(f), self.level(care));
        let result = if care_level < level {
            let (high, low) = self.branches(care, care_level);
            match self.or(high, low) {
                Err(Limit::Size) => return Ok(f),
                either => self.restrict(f, either?)?,
            }
        } else {
            let ((f1, f0), (c1, c0)) = (self.branches(f, level), self.branches(care, level));
            if c1 == Edge::FALSE {
                self.restrict(f0, c0)?
            } else if c0 == Edge::FALSE {
                self.restrict(f1, c1)?
            } else {
                let high = self.restrict(f1, c1)?;
                let low = self.restrict(f0, c0)?;
                self.decision(level, high, low)?
            }
        };
        self.cache(key, result.flipped(f.is_negated()));
        Ok(result)
    }

    /// Returns a function that agrees with `f` wherever `care` holds and has fewer nodes, or `f` if
    /// none was found within the work limit.
    pub fn simplify(&mut self, f: Edge, care: Edge) -> Result<Edge, Limit> {
        if care == Edge::TRUE || f.node().is_none() {
            return Ok(f);
        }
        let size = self.size(f);
        self.work_limit = self.work + BASE_WORK + WORK_PER_NODE * size as u64;
        let smaller = self.restrict(f, care);
        self.work_limit = u64::MAX;
        let smaller = smaller?;
        let shrinks = smaller != f && self.size(smaller) < size;
        Ok(if shrinks { smaller } else { f })
    }

    /// Returns the number of nodes of a function.
    fn size(&mut self, root: Edge) -> usize {
        self.below(&[root]).len()
    }

    /// Returns those of `bits` on which a function depends, and the function's number of nodes.
    pub fn measure(&mut self, root: Edge, bits: &[Bit]) -> (BitSet, usize) {
        let below = self.below(&[root]);
        let mut tested = vec![false; 2 * self.positions.len()];
        for n in &below {
            tested[self.nodes[*n].level as usize] = true;
        }
        let depends = |bit: &Bit| tested[self.level_of(*bit) as usize];
        let support = BitSet::new(bits.iter().copied().filter(depends));
        (support, below.len())
    }

    /// Returns the numbers of all nodes of these functions.
    fn below(&mut self, roots: &[Edge]) -> Vec<usize> {
        self.marks.resize(self.nodes.len(), 0);
        self.mark += 1;
        let mut found = Vec::new();
        let (marks, mark) = (&mut self.marks, self.mark);
        let mut visit = |edge: Edge, found: &mut Vec<usize>| {
            if let Some(n) = edge.node()
                && marks[n] != mark
            {
                marks[n] = mark;
                found.push(n);
            }
        };
        for root in roots {
            visit(*root, &mut found);
        }
        let mut next = 0;
        while let Some(n) = found.get(next) {
            let Node { high, low, .. } = self.nodes[*n];
            visit(high, &mut found);
            visit(low, &mut found);
            next += 1;
        }
        found
    }

    /// Adds functions of a kernel that has the same order, and returns their edges.
    pub fn add<'a, K: Kernel>(
        &mut self,
        kernel: &K,
        functions: impl IntoIterator<Item = &'a K::Function>,
    ) -> Result<Vec<Edge>, Limit> {
        let functions: Vec<&K::Function> = functions.into_iter().collect();
        let exported = kernel.export(&functions);
        let mut edges: Vec<Edge> = Vec::with_capacity(exported.nodes.len());
        let at = |edges: &[Edge], edge: Edge| match edge.node() {
            None => edge,
            Some(n) => edges[n].flipped(edge.is_negated()),
        };
        for node in &exported.nodes {
            let (high, low) = (at(&edges, node.high), at(&edges, node.low));
            let edge = self.decision(self.level_of(node.bit), high, low)?;
            edges.push(edge);
        }
        Ok(exported.roots.iter().map(|r| at(&edges, *r)).collect())
    }

    /// Adds functions of another builder with the same order, and returns their edges.
    pub fn copy(&mut self, other: &mut Self, roots: &[Edge]) -> Result<Vec<Edge>, Limit> {
        let mut edges: FxHashMap<usize, Edge> = FxHashMap::default();
        let at = |edges: &FxHashMap<usize, Edge>, edge: Edge| match edge.node() {
            None => edge,
            Some(n) => edges[&n].flipped(edge.is_negated()),
        };
        let mut below = other.below(roots);
        // A node is created after its children.
        below.sort_unstable();
        for n in below {
            let Node { level, high, low } = other.nodes[n];
            let edge = self.decision(level, at(&edges, high), at(&edges, low))?;
            edges.insert(n, edge);
        }
        Ok(roots.iter().map(|r| at(&edges, *r)).collect())
    }

    /// Returns all nodes as plain data, without roots.
    pub fn into_diagram(self) -> Diagram {
        let mut pairs = vec![0; self.positions.len()];
        for (pair, position) in self.positions.iter().enumerate() {
            pairs[usize::from(*position)] = pair as u16;
        }
        let nodes = self.nodes.iter().map(|node| DiagramNode {
            bit: Bit(2 * pairs[node.level as usize / 2] + (node.level % 2) as u16),
            high: node.high,
            low: node.low,
        });
        Diagram {
            nodes: nodes.collect(),
            roots: Vec::new(),
        }
    }
}
