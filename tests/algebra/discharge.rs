//! The algebra of contracts on the contracts and machines that ship: discharge tables, what happens
//! when a guarantee that one of them names is taken away, the paper's own pair, and circles that
//! are sound or not.

mod machines;
mod mutants;
mod pairs;
mod tables;
