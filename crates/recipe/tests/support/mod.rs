//! Shared by the tests: the reconstructed demonstrator, random cells, and an oracle.

#![allow(dead_code, reason = "each test program uses its own part")]

pub mod jobs;
pub mod mutants;
pub mod naive;
pub mod naive_plan;
pub mod naive_timed;
pub mod pad;
pub mod random;
