//! A small diagram package used beside a kernel.
//!
//! Functions are derived from a relation in thousands of small operations, most of which recur for
//! the next goal. They are simplified with respect to a care set, which no kernel here supports. So
//! this is a plain diagram package: one thread, one fixed order, no garbage collection (users start
//! a new builder from time to time), with operands and results in a lossy cache.
//!
//! [`DiagramBuilder::restrict`] is from Coudert and Madre, "A unified framework for the formal
//! verification of sequential circuits", ICCAD 1990.

use crate::symbolic::{Bit, BitSet, Diagram, DiagramNode, Edge, Kernel, Limit, Limits, Order};
use rustc_hash::FxHashMap;

/// Maximum number of nodes without a memory limit.
const MOST_NODES: u64 = 1 << 25;

/// Bytes per node, including all references to it.
const NODE_BYTES: u64 = 48;

/// Number of cached results; a power of two.
const REMEMBERED: usize = 1 << 17;

/// Number of cached [`Choices`]; a power of two.
const CHOICES: usize = 1 << 15;

/// A simplification is abandoned after this many conjunctions of decisions, plus
/// [`EFFORT_PER_NODE`] for each node of the function: reducing `care` to the bits that the function
/// depends on has no other bound.
const LEAST_EFFORT: usize = 1_000;

/// See [`LEAST_EFFORT`].
const EFFORT_PER_NODE: usize = 2;

/// Minimum number of node slots; a power of two.
const FEWEST_SLOTS: usize = 1 << 12;

/// Hashes three numbers to a value below 2^32.
fn spread(a: u32, b: u32, c: u32) -> u32 {
    let both = u64::from(b) << 32 | u64::from(c);
    let mixed = (both ^ u64::from(a).wrapping_mul(0x9e37_79b9_7f4a_7c15))
        .wrapping_mul(0xf135_7aea_2e62_a9c5);
    ((mixed ^ mixed >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32
}

/// A decision; the edge for 1 is never negated, so that a function and its negation share a node.
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

/// An operation, its operands, and its result.
type Remembered = ((Operation, u32, u32), Edge);

/// What a condition says about one of its bits, as functions of the others.
#[derive(Debug, Clone, Copy)]
pub struct Choices {
    /// Where it can hold with the bit 1.
    pub may_set: Edge,
    /// Where it can hold with some value.
    pub possible: Edge,
    /// Where it holds with exactly one value.
    pub forced: Edge,
}

/// A store of functions under construction.
#[derive(Debug)]
pub struct DiagramBuilder {
    nodes: Vec<Node>,
    /// Open-addressing hash table of node numbers plus one; 0 is free. Small, so that much of it
    /// stays in the processor's caches. The size is a power of two, at least twice the number of
    /// nodes.
    slots: Vec<u32>,
    remembered: Vec<Remembered>,
    choices: Vec<(Edge, u32, Choices)>,
    /// For every pair, its position in the order.
    positions: Vec<u16>,
    /// For every node, the mark of its last visit.
    marks: Vec<u32>,
    mark: u32,
    limits: Limits,
    most_nodes: usize,
    /// Number of conjunctions of two decisions so far.
    effort: usize,
    /// Effort at which a simplification is abandoned.
    patience: usize,
}

/// Level of constants, below all others.
const BOTTOM: u32 = u32::MAX;

impl DiagramBuilder {
    /// Creates an empty builder.
    pub fn new(order: &Order, limits: &Limits) -> Self {
        let by_memory = limits
            .memory_mib
            .map(|mib| mib.saturating_mul(1 << 20) / NODE_BYTES);
        let bounds = [by_memory, limits.most_nodes].into_iter().flatten();
        Self {
            nodes: Vec::new(),
            slots: vec![0; FEWEST_SLOTS],
            remembered: Vec::new(),
            choices: Vec::new(),
            positions: order.positions(),
            marks: Vec::new(),
            mark: 0,
            limits: *limits,
            most_nodes: bounds.fold(MOST_NODES, u64::min) as usize,
            effort: 0,
            patience: usize::MAX,
        }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    fn level_of(&self, bit: Bit) -> u32 {
        2 * u32::from(self.positions[usize::from(bit.pair())]) + u32::from(bit.0 & 1)
    }

    /// Level of the topmost decision.
    fn level(&self, edge: Edge) -> u32 {
        edge.node().map_or(BOTTOM, |n| self.nodes[n].level)
    }

    /// Returns the edge to a decision.
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
        if fresh >= self.most_nodes {
            return Err(Limit::Memory);
        }
        if fresh.is_multiple_of(1 << 14) {
            self.limits.check_time()?;
        }
        self.nodes.push(node);
        self.slots[place] = fresh as u32 + 1;
        if 2 * self.nodes.len() > self.slots.len() {
            self.widen();
        }
        Ok(Edge::to(fresh).flipped(negate))
    }

    /// First slot to search for a node.
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

    /// Targets of an edge for the bit at this level being 1 and 0; the level is not below its
    /// topmost decision.
    fn branches(&self, edge: Edge, level: u32) -> (Edge, Edge) {
        match edge.node().map(|n| self.nodes[n]) {
            Some(node) if node.level == level => {
                let negate = edge.is_negated();
                (node.high.flipped(negate), node.low.flipped(negate))
            }
            _ => (edge, edge),
        }
    }

    fn place((operation, a, b): (Operation, u32, u32)) -> usize {
        spread(operation as u32, a, b) as usize & (REMEMBERED - 1)
    }

    fn recall(&self, key: (Operation, u32, u32)) -> Option<Edge> {
        let (known, result) = self.remembered.get(Self::place(key))?;
        (*known == key).then_some(*result)
    }

    fn remember(&mut self, key: (Operation, u32, u32), result: Edge) {
        if self.remembered.is_empty() {
            self.remembered = vec![(<_>::default(), Edge::FALSE); REMEMBERED];
        }
        let place = Self::place(key);
        self.remembered[place] = (key, result);
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
        if let Some(known) = self.recall(key) {
            return Ok(known);
        }
        self.effort += 1;
        if self.effort > self.patience {
            return Err(Limit::Size);
        }
        if self.effort.is_multiple_of(1 << 16) {
            self.limits.check_time()?;
        }
        let level = self.level(a).min(self.level(b));
        let ((a1, a0), (b1, b0)) = (self.branches(a, level), self.branches(b, level));
        let high = self.and(a1, b1)?;
        let low = self.and(a0, b0)?;
        let result = self.decision(level, high, low)?;
        self.remember(key, result);
        Ok(result)
    }

    /// `a ∨ b`
    pub fn or(&mut self, a: Edge, b: Edge) -> Result<Edge, Limit> {
        Ok(self.and(a.negated(), b.negated())?.negated())
    }

    /// `a ⊕ b`
    pub fn xor(&mut self, a: Edge, b: Edge) -> Result<Edge, Limit> {
        // Negations pass through.
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
        if let Some(known) = self.recall(key) {
            return Ok(known.flipped(negate));
        }
        let level = self.level(a).min(self.level(b));
        let ((a1, a0), (b1, b0)) = (self.branches(a, level), self.branches(b, level));
        let high = self.xor(a1, b1)?;
        let low = self.xor(a0, b0)?;
        let result = self.decision(level, high, low)?;
        self.remember(key, result);
        Ok(result.flipped(negate))
    }

    /// What a condition says about one of its bits.
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
        let place = spread(level, f.0, 0) as usize & (CHOICES - 1);
        if let Some((known, of, choices)) = self.choices.get(place)
            && (*known, *of) == (f, level)
        {
            return Ok(*choices);
        }
        let high = self.choices_at(high, level)?;
        let low = self.choices_at(low, level)?;
        let choices = Choices {
            may_set: self.decision(top, high.may_set, low.may_set)?,
            possible: self.decision(top, high.possible, low.possible)?,
            forced: self.decision(top, high.forced, low.forced)?,
        };
        if self.choices.is_empty() {
            self.choices = vec![(Edge::FALSE, 0, choices); CHOICES];
        }
        self.choices[place] = (f, level, choices);
        Ok(choices)
    }

    /// Returns a function that agrees with `f` wherever `care` holds, and is likely to be smaller:
    /// omits decisions of which only one side matters.
    fn restrict(&mut self, f: Edge, care: Edge) -> Result<Edge, Limit> {
        if care == Edge::TRUE || care == Edge::FALSE || f.node().is_none() {
            return Ok(f);
        }
        let key = (Operation::Restrict, f.0 & !1, care.0);
        if let Some(known) = self.recall(key) {
            return Ok(known.flipped(f.is_negated()));
        }
        if self.effort > self.patience {
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
        self.remember(key, result.flipped(f.is_negated()));
        Ok(result)
    }

    /// Returns the smaller of `f` and a function that agrees with it wherever `care` holds, within
    /// the limited effort.
    pub fn simplify(&mut self, f: Edge, care: Edge) -> Result<Edge, Limit> {
        if care == Edge::TRUE || f.node().is_none() {
            return Ok(f);
        }
        let size = self.size(f);
        self.patience = self.effort + LEAST_EFFORT + EFFORT_PER_NODE * size;
        let smaller = self.restrict(f, care);
        self.patience = usize::MAX;
        let smaller = smaller?;
        let shrinks = smaller != f && self.size(smaller) < size;
        Ok(if shrinks { smaller } else { f })
    }

    /// Number of nodes of a function.
    fn size(&mut self, root: Edge) -> usize {
        self.below(&[root]).len()
    }

    /// Which of these bits a function depends on, and its number of nodes.
    pub fn measure(&mut self, root: Edge, bits: &[Bit]) -> (BitSet, usize) {
        let below = self.below(&[root]);
        let mut asked = vec![false; 2 * self.positions.len()];
        for n in &below {
            asked[self.nodes[*n].level as usize] = true;
        }
        let depends = |bit: &Bit| asked[self.level_of(*bit) as usize];
        let support = BitSet::new(bits.iter().copied().filter(depends));
        (support, below.len())
    }

    /// All nodes of some functions.
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

    /// Adds functions of a kernel that has the same order.
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

    /// Adds functions of another builder with the same order.
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

    /// Returns everything as plain data, without roots.
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
