//! The laboratory's line, from its files in `examples/ice-lab` to 50 products: the shipped line,
//! not a fixture.
//!
//! Seven questions, one file each: whether a compiler has warnings about the C of its machines
//! ([`compile`]), whether library and interpreter agree on random steps ([`steps`]), whether every
//! operation does what its machine's file says ([`operations`]), the output of a run ([`run`]),
//! whether functions are equivalent to tables ([`functions`]), whether the line runs at real size
//! ([`real`]), and whether the cell in one contract matches the cell in parts ([`holistic`]).

mod compile;
mod functions;
mod holistic;
mod operations;
mod real;
mod run;
mod steps;
