//! Statistics of a solve.

use crate::symbolic::Order;
use linewright_core::gr1::VarId;

/// Time, nodes and iterations that a verdict took.
#[derive(Debug, Clone, Default)]
pub struct Statistics {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Number of pairs of a current and a next bit.
    pub pairs: usize,
    /// Wall-clock seconds spent on encoding all formulas.
    pub encode_seconds: f64,
    /// Wall-clock seconds spent on the variable order before the fixpoint.
    pub order_seconds: f64,
    /// Wall-clock seconds spent on the fixpoint.
    pub fixpoint_seconds: f64,
    /// Peak number of live nodes.
    pub peak_nodes: u64,
    /// Iterations of the outermost fixpoint, one per goal and round.
    pub outer: u64,
    /// Iterations of the middle fixpoints, one per assumption and round.
    pub middle: u64,
    /// Iterations of the innermost fixpoints.
    pub inner: u64,
    /// Number of controllable predecessors computed.
    pub predecessors: u64,
    /// Whether the game is too large for checks beyond its verdict. Depends on the numbers of bits
    /// and nodes, never on time.
    pub large: bool,
    /// Variables in the initial order, from the top of the diagrams to the bottom, by the position
    /// of their topmost bit.
    pub order_before: Vec<VarId>,
    /// Variables in the final order; empty before the end.
    pub order_after: Vec<VarId>,
    /// Final order of the pairs of bits; `None` before the end.
    pub last_order: Option<Order>,
}
