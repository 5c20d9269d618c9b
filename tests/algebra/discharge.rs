//! The algebra of contracts on the shipped contracts and machines: discharge tables, the effect of
//! removing a guarantee named in one, the paper's own pair, and sound and unsound circles.

mod machines;
mod mutants;
mod pairs;
mod tables;
