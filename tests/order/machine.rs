//! The pick-and-place unit with its orders: a synthesized coordinator keeps them; a mutant is
//! detected by the proof, in a run, and by the library's return code.

mod mutant;
mod operations;
mod unit;
