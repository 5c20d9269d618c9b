//! Boolean functions as plain data, to be exchanged between kernels, stored in files, or emitted as
//! code.

use super::{Bit, Kernel, Limit};
use serde::{Deserialize, Serialize};

/// An edge of a [`Diagram`]: a node or a constant, possibly negated.
///
/// Number 0 is the constant `false` ([`Edge::FALSE`]), 1 is `true` ([`Edge::TRUE`]), `2n` is node
/// `n - 1`, and `2n + 1` its negation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Edge(pub u32);

impl Edge {
    /// `false`
    pub const FALSE: Self = Self(0);
    /// `true`
    pub const TRUE: Self = Self(1);

    /// Creates the edge to the node with this index.
    pub fn to(node: usize) -> Self {
        Self(2 * (node as u32 + 1))
    }

    /// Returns the negation of the edge.
    #[must_use]
    pub fn negated(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// Whether the edge is negated.
    pub fn is_negated(self) -> bool {
        self.0 & 1 == 1
    }

    /// Index of the target node; `None` for a constant.
    pub fn node(self) -> Option<usize> {
        (self.0 > 1).then(|| (self.0 / 2 - 1) as usize)
    }

    /// Returns the edge, negated if `negate`.
    #[must_use]
    pub fn flipped(self, negate: bool) -> Self {
        Self(self.0 ^ u32::from(negate))
    }
}

/// One decision node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct DiagramNode {
    /// The tested bit.
    pub bit: Bit,
    /// Target if the bit is 1.
    pub high: Edge,
    /// Target if the bit is 0.
    pub low: Edge,
}

/// Functions over bits. Functions share equal nodes, and every node comes after its children.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagram {
    /// The decision nodes.
    pub nodes: Vec<DiagramNode>,
    /// The functions, each as an edge to its topmost node.
    pub roots: Vec<Edge>,
}

impl Diagram {
    /// Evaluates the root with this index. `bits` holds the values of all bits, indexed by [`Bit`].
    pub fn evaluate(&self, root: usize, bits: &[bool]) -> bool {
        let mut edge = self.roots[root];
        let mut value = false;
        loop {
            value ^= edge.is_negated();
            let Some(node) = edge.node() else {
                return value;
            };
            let node = &self.nodes[node];
            edge = if bits[node.bit.index()] {
                node.high
            } else {
                node.low
            };
        }
    }

    /// Returns, for every root, the share (0 to 1) of all valuations that satisfy it.
    pub fn shares(&self) -> Vec<f64> {
        // The shares of satisfying and of falsifying valuations are both kept: computing one as 1
        // minus the other would lose small values.
        let share = |known: &[(f64, f64)], edge: Edge| {
            let (yes, no) = edge.node().map_or((0.0, 1.0), |n| known[n]);
            if edge.is_negated() {
                (no, yes)
            } else {
                (yes, no)
            }
        };
        let mut known: Vec<(f64, f64)> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let (high, low) = (share(&known, node.high), share(&known, node.low));
            known.push((f64::midpoint(high.0, low.0), f64::midpoint(high.1, low.1)));
        }
        self.roots.iter().map(|r| share(&known, *r).0).collect()
    }

    /// Returns a diagram with these functions as roots and only the nodes that they reach.
    #[must_use]
    pub fn extract_roots(&self, roots: &[Edge]) -> Self {
        let mut needed = vec![false; self.nodes.len()];
        for root in roots {
            if let Some(node) = root.node() {
                needed[node] = true;
            }
        }
        for (index, node) in self.nodes.iter().enumerate().rev() {
            if needed[index] {
                for child in [node.high, node.low] {
                    if let Some(node) = child.node() {
                        needed[node] = true;
                    }
                }
            }
        }
        let mut places = vec![0; self.nodes.len()];
        let moved = |places: &[usize], edge: Edge| match edge.node() {
            Some(node) => Edge::to(places[node]).flipped(edge.is_negated()),
            None => edge,
        };
        let mut nodes = Vec::new();
        for (index, node) in self.nodes.iter().enumerate() {
            if needed[index] {
                places[index] = nodes.len();
                nodes.push(DiagramNode {
                    bit: node.bit,
                    high: moved(&places, node.high),
                    low: moved(&places, node.low),
                });
            }
        }
        Self {
            roots: roots.iter().map(|r| moved(&places, *r)).collect(),
            nodes,
        }
    }

    /// Whether every edge of a node leads to an earlier node, every root to an existing one, and
    /// every bit is below `bits`, as [`Diagram::build`] requires.
    pub fn is_sound(&self, bits: usize) -> bool {
        let below = |edge: Edge, limit: usize| edge.node().is_none_or(|n| n < limit);
        let nodes = self.nodes.iter().enumerate();
        nodes
            .into_iter()
            .all(|(i, n)| n.bit.index() < bits && below(n.high, i) && below(n.low, i))
            && self.roots.iter().all(|r| below(*r, self.nodes.len()))
    }

    /// Builds the roots as functions of `kernel`.
    ///
    /// # Panics
    /// Panics if the diagram is not [sound](Diagram::is_sound) for the kernel's bits.
    pub fn build<K: Kernel>(&self, kernel: &K) -> Result<Vec<K::Function>, Limit> {
        let mut built: Vec<K::Function> = Vec::with_capacity(self.nodes.len());
        let get = |built: &[K::Function], edge: Edge| -> Result<K::Function, Limit> {
            match edge.node() {
                None => Ok(kernel.constant(edge.is_negated())),
                Some(n) if edge.is_negated() => kernel.not(&built[n]),
                Some(n) => Ok(built[n].clone()),
            }
        };
        for node in &self.nodes {
            let (high, low) = (get(&built, node.high)?, get(&built, node.low)?);
            let bit = kernel.literal(node.bit, true);
            built.push(kernel.ite(&bit, &high, &low)?);
        }
        self.roots.iter().map(|r| get(&built, *r)).collect()
    }
}
