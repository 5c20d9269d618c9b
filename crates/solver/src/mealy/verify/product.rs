//! The product built by both checkers, node by node: what is checked, against everything that may
//! play against it.

use super::residual::Place;
use std::collections::HashMap;

/// A step of the product.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge {
    pub(super) to: usize,
    /// Which justice formulas the transition satisfies.
    pub(super) label: u32,
}

/// A state of the product.
#[derive(Debug)]
struct Node {
    /// `None` before step 0.
    state: Option<usize>,
    context: Place,
    /// How it was first reached: source node and valuation.
    from: Option<(usize, Vec<i64>)>,
}

/// The reached nodes, and the steps between those examined. Node 0 is the start of every play.
#[derive(Debug)]
pub(super) struct Product {
    nodes: Vec<Node>,
    numbers: HashMap<(usize, Place), usize>,
    /// Edges by node, only for the nodes examined so far.
    pub(super) edges: Vec<Vec<Edge>>,
    /// By label number, whether each justice formula is satisfied.
    pub(super) labels: Vec<Vec<bool>>,
    label_numbers: HashMap<Vec<bool>, u32>,
}

impl Product {
    /// Creates the start node.
    pub(super) fn new(start: Place) -> Self {
        Self {
            nodes: vec![Node {
                state: None,
                context: start,
                from: None,
            }],
            numbers: HashMap::new(),
            edges: Vec::new(),
            labels: Vec::new(),
            label_numbers: HashMap::new(),
        }
    }

    /// The next node to examine; `None` once all have been.
    pub(super) fn next(&self) -> Option<usize> {
        let next = self.edges.len();
        (next < self.nodes.len()).then_some(next)
    }

    /// Stores the steps from the node that [`Self::next`] returned.
    pub(super) fn close(&mut self, mut edges: Vec<Edge>) {
        edges.sort_unstable();
        edges.dedup();
        self.edges.push(edges);
    }

    /// The state of a node, and what the formulas still say there.
    pub(super) fn node(&self, node: usize) -> (Option<usize>, Place) {
        let Node { state, context, .. } = self.nodes[node];
        (state, context)
    }

    /// The step with this valuation and label from one node to a state and a context, whose node is
    /// created if necessary.
    pub(super) fn edge(
        &mut self,
        from: usize,
        valuation: &[i64],
        label: &[bool],
        (state, context): (usize, Place),
    ) -> Edge {
        let label = if let Some(number) = self.label_numbers.get(label) {
            *number
        } else {
            let number = self.labels.len() as u32;
            self.labels.push(label.to_vec());
            self.label_numbers.insert(label.to_vec(), number);
            number
        };
        let fresh = self.nodes.len();
        let to = *self.numbers.entry((state, context)).or_insert(fresh);
        if to == fresh {
            self.nodes.push(Node {
                state: Some(state),
                context,
                from: Some((from, valuation.to_vec())),
            });
        }
        Edge { to, label }
    }

    /// Whether a label says that the justice formula with this index is satisfied.
    pub(super) fn satisfies(&self, label: u32, place: usize) -> bool {
        self.labels[label as usize][place]
    }

    /// The valuations of the play by which a node was first reached.
    pub(super) fn trace_to(&self, mut node: usize) -> Vec<Vec<i64>> {
        let mut trace = Vec::new();
        while let Some((from, valuation)) = &self.nodes[node].from {
            trace.push(valuation.clone());
            node = *from;
        }
        trace.reverse();
        trace
    }
}
