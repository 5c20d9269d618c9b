//! Boolean functions as binary decision diagrams, and the encoding of finite-domain expressions.
//!
//! Only this module uses a BDD package. The trait [`Kernel`] lists the operations that a GR(1) game
//! needs. It has two implementations. [`Biodivine`], whose functions own their nodes, is for the
//! many small contracts of a library. [`SharedStore`], with complement edges, a common store and a
//! persistent cache, is for large contracts. [`Encoding`] assigns pairs of bits to the variables of
//! a [`Specification`](linewright_core::gr1::Specification), each current bit next to its primed
//! twin, and encodes expressions with exact arithmetic. [`Diagram`] holds functions as plain data.

mod biodivine;
mod bits;
mod diagram;
mod encoding;
mod kernel;
mod limits;
mod link;
mod shared;
mod sift;
#[cfg(test)]
mod tests;

pub use biodivine::Biodivine;
pub use diagram::{Diagram, DiagramNode, Edge};
pub use encoding::Encoding;
pub use kernel::{Bit, BitSet, Kernel, MAX_PAIRS, Order};
pub use limits::{Budget, BudgetFactor, Limit, Limits};
pub use shared::SharedStore;
