//! The laboratory's line, from its files in `examples/ice-lab` to 50 products: what is shipped, not a fixture.
//!
//! Seven questions, one file each: whether a compiler has anything to say about the C of its machines ([`compile`]), whether
//! library and interpreter agree on random steps ([`steps`]), whether every operation does what its machine's file says
//! ([`operations`]), what a run prints ([`run`]), whether functions do as well as tables ([`functions`]), whether the line runs at
//! real size ([`real`]), and whether the cell in one contract is the cell in parts ([`holistic`]).

#[path = "ice_lab/compile.rs"]
mod compile;
#[path = "station/differential.rs"]
mod differential;
#[path = "ice_lab/functions.rs"]
mod functions;
#[path = "ice_lab/holistic.rs"]
mod holistic;
#[path = "ice_lab/laboratory.rs"]
mod laboratory;
#[path = "ice_lab/operations.rs"]
mod operations;
#[path = "ice_lab/real.rs"]
mod real;
#[path = "ice_lab/run.rs"]
mod run;
#[path = "ice_lab/steps.rs"]
mod steps;
mod support;
