//! Labelled state graphs as Graphviz text and as pictures. The callers decide what the graphs show.

mod canvas;
pub mod dot;
pub mod fold;
mod layered;
pub mod layers;
mod legend;
mod outline;
pub mod svg;
mod table;
mod text;

/// States and edges with their labels, independent of the output format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Graph {
    /// Label of each state, as lines.
    pub states: Vec<Vec<String>>,
    /// Edges, including those that lead to the initial states.
    pub edges: Vec<Edge>,
}

/// An edge of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    /// Source state; `None` for an edge to an initial state, which is drawn from a dot.
    pub from: Option<usize>,
    /// Target state.
    pub to: usize,
    /// Label, as lines.
    pub label: Vec<String>,
}

/// One of several graphs shown side by side, such as the parallel regions of a statechart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Title shown on the region.
    pub title: String,
    /// Graph shown in the region.
    pub graph: Graph,
}
