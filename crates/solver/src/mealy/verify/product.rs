//! The product graph of both checkers: the checked machine in all plays against its opponent. It is
//! built node by node.

use super::residual::Place;
use rustc_hash::FxHashMap;

/// A step of the product graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge {
    /// Index of the target node.
    pub(super) to: usize,
    /// Number of the label, that is, of the set of justice formulas that the step satisfies.
    pub(super) label: u32,
}

/// A node of the product graph.
#[derive(Debug)]
struct Node {
    /// State of the machine; `None` before step 0.
    state: Option<usize>,
    /// The formulas that remain once the current values are known.
    context: Place,
    /// Source node and valuation of the step that first reached the node.
    from: Option<(usize, Vec<i64>)>,
}

/// The nodes reached so far, and the steps from those nodes that have been examined. Node 0 is the
/// start of every play.
#[derive(Debug)]
pub(super) struct Product {
    nodes: Vec<Node>,
    numbers: FxHashMap<(usize, Place), usize>,
    /// Edges of each node examined so far.
    pub(super) edges: Vec<Vec<Edge>>,
    /// For each label, whether each justice formula is satisfied.
    pub(super) labels: Vec<Vec<bool>>,
    label_numbers: FxHashMap<Vec<bool>, u32>,
}

impl Product {
    /// Creates the graph with its start node.
    pub(super) fn new(start: Place) -> Self {
        Self {
            nodes: vec![Node {
                state: None,
                context: start,
                from: None,
            }],
            numbers: FxHashMap::default(),
            edges: Vec::new(),
            labels: Vec::new(),
            label_numbers: FxHashMap::default(),
        }
    }

    /// Returns the next node to examine; `None` once all reached nodes are examined.
    pub(super) fn next(&self) -> Option<usize> {
        let next = self.edges.len();
        (next < self.nodes.len()).then_some(next)
    }

    /// Stores the steps from the node that [`Self::next`] returned. The node then counts as
    /// examined.
    pub(super) fn close(&mut self, mut edges: Vec<Edge>) {
        edges.sort_unstable();
        edges.dedup();
        self.edges.push(edges);
    }

    /// Returns the state and the context of a node.
    pub(super) fn node(&self, node: usize) -> (Option<usize>, Place) {
        let Node { state, context, .. } = self.nodes[node];
        (state, context)
    }

    /// Returns the step with this valuation and label from a node to the node of a state and a
    /// context, which is created if necessary.
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

    /// Whether the steps with a label satisfy the justice formula with this index.
    pub(super) fn satisfies(&self, label: u32, place: usize) -> bool {
        self.labels[label as usize][place]
    }

    /// Returns the valuations of the play that first reached a node.
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
