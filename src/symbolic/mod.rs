//! Boolean functions as binary decision diagrams, and finite-domain expressions encoded as such.
//!
//! The only module that knows a BDD package. [`Manager`] is deliberately small, and its shape (cheap handles, every
//! operation a `Result`) is that of the trait a second kernel will stand behind. [`Encoding`] lays the variables of a
//! [`Specification`](crate::gr1::Specification) out in bits, a current bit always next to its primed twin, and encodes
//! expressions with exact arithmetic.

mod bits;
mod encoding;
mod limits;
mod manager;
#[cfg(test)]
mod tests;

pub use encoding::Encoding;
pub use limits::{Limit, Limits};
pub use manager::{Bit, BitSet, Function, Manager};
