//! Boolean functions as binary decision diagrams, and finite-domain expressions encoded as such.
//!
//! The only module that knows a BDD package. [`Kernel`] says what a GR(1) game needs of one; its
//! implementations are [`Biodivine`], whose functions own their nodes, for the many small contracts
//! of a library, and [`OxiDd`], with complement edges, a shared store and a persistent cache, for
//! large ones. [`Encoding`] lays the variables of a
//! [`Specification`](linewright_core::gr1::Specification) out in pairs of bits, a current bit
//! always next to its primed twin, and encodes expressions with exact arithmetic. [`Diagram`] is a
//! function as plain data.

mod biodivine;
mod bits;
mod diagram;
mod encoding;
mod kernel;
mod limits;
mod oxidd;
mod sift;
#[cfg(test)]
mod tests;

pub use biodivine::Biodivine;
pub use diagram::{Diagram, DiagramNode, Edge};
pub use encoding::Encoding;
pub use kernel::{Bit, BitSet, Kernel, Order};
pub use limits::{Budget, Effort, Limit, Limits};
pub use oxidd::OxiDd;
