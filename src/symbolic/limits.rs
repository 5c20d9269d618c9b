//! When to give up, and that something was given up: values, never a panic and never a hang.

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

impl Limits {
    /// An error once the time has run out.
    pub fn check_time(&self) -> Result<(), Limit> {
        match self.deadline {
            Some(deadline) if Instant::now() >= deadline => Err(Limit::Time),
            _ => Ok(()),
        }
    }
}
