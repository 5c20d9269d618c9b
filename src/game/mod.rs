//! The GR(1) game.

use crate::gr1::Specification;
use std::time::Instant;

/// When to give up.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Not after this instant.
    pub deadline: Option<Instant>,
    /// Not with more than this many mebibytes of nodes.
    pub memory_mib: Option<u64>,
}

/// Why a stage gave up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Limit {
    /// The time ran out.
    #[error("the time limit was reached")]
    Time,
    /// The nodes would not fit.
    #[error("the memory limit was reached")]
    Memory,
    /// The machine is too large to be written down state by state.
    #[error("the machine is too large to be written down state by state")]
    Size,
}

/// The verdict on a specification.
#[derive(Debug)]
pub enum Outcome {
    /// There is a machine.
    Realizable(Won),
    /// There is none.
    Unrealizable(Lost),
    /// A limit was reached; nothing is known.
    GaveUp(Limit),
}

/// What is known of a specification that is realizable.
#[derive(Debug)]
pub struct Won {}

/// What is known of a specification that is not.
#[derive(Debug)]
pub struct Lost {}

/// Decides whether a machine exists.
pub fn solve(specification: &Specification, limits: &Limits) -> Outcome {
    let _ = (specification, limits);
    todo!("solver")
}
