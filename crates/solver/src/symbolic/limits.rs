//! When to give up, and that something was given up: values, never a panic and never a hang.
//!
//! Seconds come from `--timeout` alone, and speak of a whole command. What gives up by itself
//! counts its work ([`Budget`]), so that the same question has the same answer on every computer,
//! however busy it is. A clock decides nothing else; a test keeps it so.

use linewright_core::deadline::{Deadline, StopReason};

/// When to give up.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Not after this.
    pub deadline: Deadline,
    /// Not with more than this many mebibytes of nodes.
    pub memory_mib: Option<u64>,
    /// Not with more than this many nodes.
    pub most_nodes: Option<u64>,
    /// Not after so many nodes were made in all, where functions own their nodes: it decides on the
    /// kernel. Running out of it is [`Limit::Memory`].
    pub most_made: Option<u64>,
    /// Not after so many units of work; see [`super::Kernel::work`].
    pub most_work: Option<u64>,
    /// What every budget is multiplied by.
    pub effort: Effort,
}

/// Why a stage gave up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Limit {
    /// The time ran out, or it was interrupted.
    #[error(transparent)]
    Late(#[from] StopReason),
    /// The nodes would not fit.
    #[error("the memory limit was reached")]
    Memory,
    /// The machine is too large to be written down state by state.
    #[error("the machine is too large to be written down state by state")]
    Size,
    /// The work of a budget was done.
    #[error("the proof took more than {0} units of work")]
    Work(u64),
    /// The nodes of a budget are in use.
    #[error("the proof needed more than {0} nodes at once")]
    Nodes(u64),
}

impl Limit {
    /// Whether `--timeout`, `--memory` or Ctrl-C is to blame. All else depends on the question
    /// alone, and is the same wherever it is asked.
    pub fn is_of_command(self) -> bool {
        matches!(self, Self::Late(_) | Self::Memory)
    }

    /// What lets it come to its end; nothing but smaller domains where it is too large.
    pub fn remedy(self) -> Option<&'static str> {
        match self {
            Self::Late(late) => Some(late.remedy()),
            Self::Memory => Some("give it more memory with --memory MIB"),
            Self::Size => None,
            Self::Work(_) | Self::Nodes(_) => Some("let it do more work with --effort FACTOR"),
        }
    }
}

/// What one question may take before it is given up by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Units of work; see [`super::Kernel::work`].
    pub work: u64,
    /// Nodes at once.
    pub nodes: u64,
}

/// The default limits of work, all of them. A quiet computer does some 20 million units a second.
/// What ships takes less than a quarter of the work, and half of the nodes: the dearest question
/// about the laboratory's line, what rests on what, 145 million and less than 500,000. Who waits
/// for `check` waits for the budget of a line, so it is half a minute's.
impl Budget {
    /// Each question about a line: what is asked of its stations, whether parts move on, what rests
    /// on what.
    pub const LINE: Self = Self {
        work: 600_000_000,
        nodes: 1_000_000,
    };
    /// The controllers of a machine put together.
    pub const CLOSED: Self = Self {
        work: 3_000_000_000,
        nodes: 3_000_000,
    };
    /// A machine's proof from contracts.
    pub const MACHINE: Self = Self {
        work: 3_000_000_000,
        nodes: 8_000_000,
    };
    /// What the contract of a belt says about the room on it. Such a contract is small; one that is
    /// not gets no answer, instead of a late one.
    pub const BELT: Self = Self {
        work: 200_000_000,
        nodes: 200_000,
    };
    /// One question about a machine's wires, of the many that a coordinator's states ask.
    pub const WIRES: Self = Self {
        work: 200_000_000,
        nodes: 2_000_000,
    };
}

/// A factor of budgets, 1 by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort(f64);

impl Effort {
    /// What is usual.
    pub const ONE: Self = Self(1.0);

    /// `None` unless it is a number above 0.
    pub fn new(factor: f64) -> Option<Self> {
        (factor.is_finite() && factor > 0.0).then_some(Self(factor))
    }

    /// So many times as much, at least 1.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "casts of floats saturate, and a factor is positive"
    )]
    pub fn of(self, count: u64) -> u64 {
        ((count as f64 * self.0) as u64).max(1)
    }
}

impl Default for Effort {
    fn default() -> Self {
        Self::ONE
    }
}

impl Limits {
    /// An error once the time has run out.
    pub fn check_time(&self) -> Result<(), Limit> {
        Ok(self.deadline.check()?)
    }

    /// These limits, and those of a budget, as often as the effort says.
    #[must_use]
    pub fn within(&self, budget: Budget) -> Self {
        let least = |given: Option<u64>, own: u64| {
            let own = self.effort.of(own);
            Some(given.map_or(own, |given| given.min(own)))
        };
        Self {
            most_nodes: least(self.most_nodes, budget.nodes),
            most_work: least(self.most_work, budget.work),
            ..*self
        }
    }

    /// An error once more work was done than there may be.
    pub(super) fn check_work(&self, done: u64) -> Result<(), Limit> {
        match self.most_work {
            Some(most) if done > most => Err(Limit::Work(most)),
            _ => Ok(()),
        }
    }

    /// How many nodes there may be, if a node costs this many bytes: `usual` without a memory
    /// limit, never more than `most`.
    pub(super) fn nodes(&self, bytes_per_node: u64, usual: u64, most: u64) -> u64 {
        let by_memory = self.memory_mib.map_or(usual, |mib| {
            (mib.saturating_mul(1 << 20) / bytes_per_node).min(most)
        });
        self.most_nodes.map_or(by_memory, |n| n.min(by_memory))
    }

    /// The reason by its right name: nodes that do not fit although the memory has room for twice
    /// as many are those of a budget.
    pub(crate) fn name(&self, limit: Limit) -> Limit {
        const BYTES: u64 = 128;
        let has_room = |nodes: u64| {
            let memory = self.memory_mib.map(|mib| mib.saturating_mul(1 << 20));
            memory.is_none_or(|bytes| bytes / BYTES >= nodes)
        };
        match (limit, self.most_nodes) {
            (Limit::Memory, Some(most)) if has_room(most) => Limit::Nodes(most),
            _ => limit,
        }
    }
}
