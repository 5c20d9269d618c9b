//! Finite automata.

pub mod bound;
pub mod dfa;
mod partition;
pub mod search;
