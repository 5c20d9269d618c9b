//! What a verdict took.

use crate::symbolic::Order;
use linewright_core::gr1::VarId;

/// What a verdict took.
#[derive(Debug, Clone, Default)]
pub struct Statistics {
    /// The kernel it was found on.
    pub kernel: &'static str,
    /// Pairs of a current and a next bit.
    pub pairs: usize,
    /// Seconds of the clock until all formulas were functions.
    pub encode_seconds: f64,
    /// Seconds spent on the order before the fixpoint.
    pub order_seconds: f64,
    /// Seconds of the fixpoint.
    pub fixpoint_seconds: f64,
    /// The largest number of nodes that were kept at once.
    pub peak_nodes: u64,
    /// Steps of the outermost fixpoint: one a goal and round.
    pub outer: u64,
    /// Steps of the middle fixpoints: one an assumption and round.
    pub middle: u64,
    /// Steps of the innermost fixpoints.
    pub inner: u64,
    /// Controllable predecessors that were computed.
    pub predecessors: u64,
    /// Whether the game is too large to be examined further beside a verdict. By its bits and
    /// nodes, never by the clock.
    pub large: bool,
    /// The variables from the top of the diagrams to their bottom at the start, by the place of
    /// their first bit.
    pub order_before: Vec<VarId>,
    /// The same at the end.
    pub order_after: Vec<VarId>,
    /// The order at the end; `None` until then.
    pub last_order: Option<Order>,
}
