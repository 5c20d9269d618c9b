//! GR(1) games on binary decision diagrams, and the controllers that win them.
//!
//! ```text
//! gr1::Specification ─encode→ symbolic ─solve→ game::Outcome ─extract→ mealy::Machine (verified)
//! ```

// Unit tests share files with integration tests, which name the whole library.
#[cfg(test)]
extern crate self as linewright;
#[cfg(test)]
use linewright_core::{gr1, source};

pub mod game;
pub mod mealy;
pub mod symbolic;
