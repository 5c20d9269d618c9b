//! Regular expressions over letters: put together in short, and as automata.

mod short;
mod thompson;
mod tree;

pub use thompson::{MOST_PLACES, automaton};
pub use tree::Regex;
