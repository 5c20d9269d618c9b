//! GR(1) games on binary decision diagrams, and the controllers that win them.
//!
//! ```text
//! gr1::Specification ─encode→ symbolic ─solve→ game::Outcome ─extract→ mealy::Machine (verified)
//! ```

// Unit tests share files with the integration tests, in which the library is named `linewright`.
#[cfg(test)]
extern crate self as linewright;
#[cfg(test)]
use linewright_core::{gr1, source};
#[cfg(test)]
#[allow(dead_code, reason = "only the integration tests mutate machines")]
#[path = "../../../tests/solver/random.rs"]
mod random;

pub mod game;
pub mod mealy;
pub mod symbolic;
