//! When to give up, and that something was given up: values, never a panic and never a hang.

use std::time::Instant;

/// When to give up.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Not after this instant.
    pub deadline: Option<Instant>,
    /// Not with more than this many mebibytes of nodes.
    pub memory_mib: Option<u64>,
    /// Not with more than this many nodes.
    pub most_nodes: Option<u64>,
    /// Not after so many nodes were made in all, where functions own their nodes: a measure of work that is no clock. Running out of
    /// it is [`Limit::Memory`].
    pub most_made: Option<u64>,
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

impl Limits {
    /// How many nodes there may be, if a node costs this many bytes: `usual` without a memory limit, never more than `most`.
    pub(super) fn nodes(&self, bytes_per_node: u64, usual: u64, most: u64) -> u64 {
        let by_memory = self.memory_mib.map_or(usual, |mib| {
            (mib.saturating_mul(1 << 20) / bytes_per_node).min(most)
        });
        self.most_nodes.map_or(by_memory, |n| n.min(by_memory))
    }
}
