//! Finite automata.

pub mod bound;
pub mod dfa;
pub mod eliminate;
mod partition;
pub mod regex;
pub mod search;
