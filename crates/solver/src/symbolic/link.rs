//! Edges of diagrams with complement edges, in which the constant is true and no high edge is
//! negated.

use super::Edge;

/// An edge: twice the number of its target node, plus one if it is negated. Node 0 is the constant
/// true. (An [`Edge`] numbers the nodes of a [`Diagram`](super::Diagram), whose constant is false.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link(pub u32);

impl Link {
    /// The constant true.
    pub const TRUE: Self = Self(0);
    /// The constant false.
    pub const FALSE: Self = Self(1);

    /// Returns the edge to the node with this number, not negated.
    pub fn to(node: u32) -> Self {
        Self(node << 1)
    }

    /// Number of the target node.
    pub fn node(self) -> u32 {
        self.0 >> 1
    }

    /// Whether the edge is negated.
    pub fn is_negated(self) -> bool {
        self.0 & 1 == 1
    }

    /// Returns the negation of the edge.
    pub fn negated(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// Returns the edge, negated if `negate`.
    pub fn flipped(self, negate: bool) -> Self {
        Self(self.0 ^ u32::from(negate))
    }

    /// Returns the edge to the same node that is not negated.
    pub fn plain(self) -> Self {
        Self(self.0 & !1)
    }

    /// Converts the edge of a diagram, where `link` returns the edge to the node with an index.
    pub fn import(edge: Edge, link: impl FnOnce(usize) -> Self) -> Self {
        match edge.node() {
            None => Self::TRUE.flipped(edge == Edge::FALSE),
            Some(node) => link(node).flipped(edge.is_negated()),
        }
    }

    /// Converts to an edge of a diagram, where `place` returns the index of the node with a number.
    pub fn export(self, place: impl FnOnce(u32) -> usize) -> Edge {
        let edge = match self.node() {
            0 => Edge::TRUE,
            node => Edge::to(place(node)),
        };
        edge.flipped(self.is_negated())
    }
}
