//! GR(1) games on binary decision diagrams, and the controllers that win them.
//!
//! ```text
//! gr1::Specification ─encode→ symbolic ─solve→ game::Outcome ─extract→ mealy::Machine (verified)
//! ```

// Integration tests, whose files the unit tests share, call the whole library `linewright`.
#[cfg(test)]
extern crate self as linewright;
#[cfg(test)]
use linewright_core::{gr1, source};

pub mod game;
pub mod mealy;
pub mod symbolic;
