//! Statistics of a solve.

use crate::symbolic::Order;
use linewright_core::gr1::VarId;

/// Effort for a verdict.
#[derive(Debug, Clone, Default)]
pub struct Statistics {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Number of pairs of a current and a next bit.
    pub pairs: usize,
    /// Wall-clock seconds for encoding all formulas.
    pub encode_seconds: f64,
    /// Seconds spent on the order before the fixpoint.
    pub order_seconds: f64,
    /// Seconds for the fixpoint.
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
    /// Whether the game is too large for further checks beside its verdict. Decided by bits and
    /// nodes, never by time.
    pub large: bool,
    /// Variables from the top of the diagrams to the bottom at the start, by the position of their
    /// first bit.
    pub order_before: Vec<VarId>,
    /// Variables from top to bottom at the end.
    pub order_after: Vec<VarId>,
    /// The final order; `None` before the end.
    pub last_order: Option<Order>,
}
