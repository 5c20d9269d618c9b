//! Graphs of states with labels, as Graphviz text and as pictures. What they show is the business
//! of others.

pub mod dot;
pub mod svg;

/// States and edges with their labels, ready to be written down in any way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Graph {
    /// For each state: the lines of its label.
    pub states: Vec<Vec<String>>,
    /// The edges; `from` is `None` for the step before the first state.
    pub edges: Vec<Edge>,
}

/// One edge of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    /// Where from; `None`: from before the start.
    pub from: Option<usize>,
    /// Where to.
    pub to: usize,
    /// The lines of its label.
    pub label: Vec<String>,
}

/// One of several graphs that are read side by side, as the parallel regions of a statechart are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// What it is about.
    pub title: String,
    /// What it shows.
    pub graph: Graph,
}
