//! Shared by the tests: the reconstructed demonstrator, random cells, and an oracle.

#![allow(dead_code, reason = "each test program uses its own part")]

#[path = "../../../../tests/support/external.rs"]
pub mod external;
pub mod floor;
pub mod jobs;
pub mod mutants;
pub mod naive;
pub mod naive_plan;
pub mod naive_timed;
pub mod pad;
pub mod plan_mutants;
pub mod random;
