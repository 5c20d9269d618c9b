//! Limits, and the errors that report them: a result value, never a panic or a hang.
//!
//! Only `--timeout` limits time, and it covers a whole command. Everything that gives up by itself
//! counts its work ([`Budget`]), so that the same question has the same answer on every computer
//! under any load. Nothing else depends on a clock; a test ensures this.

use linewright_core::deadline::{Deadline, StopReason};

/// Limits of a stage.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Deadline.
    pub deadline: Deadline,
    /// Maximum size of all nodes in MiB.
    pub memory_mib: Option<u64>,
    /// Maximum number of nodes.
    pub most_nodes: Option<u64>,
    /// Maximum number of nodes made in total, for kernels whose functions own their nodes; used to
    /// choose the kernel. Exceeding it is [`Limit::Memory`].
    pub most_made: Option<u64>,
    /// Maximum units of work; see [`super::Kernel::work`].
    pub most_work: Option<u64>,
    /// Factor for every budget.
    pub effort: Effort,
}

/// Why a stage gave up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Limit {
    /// The deadline passed, or the command was interrupted.
    #[error(transparent)]
    Late(#[from] StopReason),
    /// The nodes do not fit into memory.
    #[error("the memory limit was reached")]
    Memory,
    /// The machine is too large to be written state by state.
    #[error("the machine is too large to be written down state by state")]
    Size,
    /// A budget of work is used up; carries its units.
    #[error("the proof took more than {0} units of work")]
    Work(u64),
    /// A budget of nodes is used up; carries its number.
    #[error("the proof needed more than {0} nodes at once")]
    Nodes(u64),
}

impl Limit {
    /// Whether the limit comes from `--timeout`, `--memory` or Ctrl-C. All others depend only on
    /// the question, and are always the same.
    pub fn is_of_command(self) -> bool {
        matches!(self, Self::Late(_) | Self::Memory)
    }

    /// The option that raises the limit; `None` if only smaller domains help.
    pub fn remedy(self) -> Option<&'static str> {
        match self {
            Self::Late(late) => Some(late.remedy()),
            Self::Memory => Some("give it more memory with --memory MIB"),
            Self::Size => None,
            Self::Work(_) | Self::Nodes(_) => Some("let it do more work with --effort FACTOR"),
        }
    }
}

/// Budget of one question, after which it is abandoned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Maximum units of work; see [`super::Kernel::work`].
    pub work: u64,
    /// Maximum number of nodes at once.
    pub nodes: u64,
}

/// All default limits of work. An idle computer does some 20 million units per second. The shipped
/// examples use less than a quarter of the work and half of the nodes: the most expensive question
/// on the laboratory's line, what rests on what, takes 145 million units and less than 500,000
/// nodes. `check` waits for the budget of a line, so it corresponds to half a minute.
impl Budget {
    /// Each question about a line: calls of its stations, whether parts keep moving, what rests on
    /// what.
    pub const LINE: Self = Self {
        work: 600_000_000,
        nodes: 1_000_000,
    };
    /// The closed composition of a machine's controllers.
    pub const CLOSED: Self = Self {
        work: 3_000_000_000,
        nodes: 3_000_000,
    };
    /// A machine's proof from contracts.
    pub const MACHINE: Self = Self {
        work: 3_000_000_000,
        nodes: 8_000_000,
    };
    /// What a belt's contract says about the room on it. Such a contract is small; one that is not
    /// gets no answer rather than a late one.
    pub const BELT: Self = Self {
        work: 200_000_000,
        nodes: 200_000,
    };
    /// One of the many questions about a machine's wires that a coordinator's states raise.
    pub const WIRES: Self = Self {
        work: 200_000_000,
        nodes: 2_000_000,
    };
}

/// A factor for budgets, 1 by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort(f64);

impl Effort {
    /// The default factor.
    pub const ONE: Self = Self(1.0);

    /// Creates a factor; `None` unless it is a number above 0.
    pub fn new(factor: f64) -> Option<Self> {
        (factor.is_finite() && factor > 0.0).then_some(Self(factor))
    }

    /// The amount times the factor, at least 1.
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
    /// Returns an error once the deadline has passed.
    pub fn check_time(&self) -> Result<(), Limit> {
        Ok(self.deadline.check()?)
    }

    /// Adds a budget, multiplied by the effort, to these limits.
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

    /// Returns an error once more work was done than allowed.
    pub(super) fn check_work(&self, done: u64) -> Result<(), Limit> {
        match self.most_work {
            Some(most) if done > most => Err(Limit::Work(most)),
            _ => Ok(()),
        }
    }

    /// Maximum number of nodes of the given size in bytes: `usual` without a memory limit, never
    /// more than `most`.
    pub(super) fn nodes(&self, bytes_per_node: u64, usual: u64, most: u64) -> u64 {
        let by_memory = self.memory_mib.map_or(usual, |mib| {
            (mib.saturating_mul(1 << 20) / bytes_per_node).min(most)
        });
        self.most_nodes.map_or(by_memory, |n| n.min(by_memory))
    }

    /// Corrects the reported limit: if nodes do not fit although memory has room for twice as many,
    /// a budget is the cause.
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
