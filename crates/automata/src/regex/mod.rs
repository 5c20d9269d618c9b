//! Regular expressions over letters: simplifying constructors, and conversion to automata.

mod short;
mod thompson;
mod tree;

pub use thompson::{MAX_PLACES, automaton};
pub use tree::Regex;
