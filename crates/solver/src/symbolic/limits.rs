//! Limits of time, memory and work. Exceeding one is an error value ([`Limit`]), never a panic or a
//! hang.
//!
//! Only `--timeout` limits time, and it covers a whole command. All other limits count work
//! ([`Budget`]), so that the same question has the same answer on every computer under any load. A
//! test ensures that nothing else depends on a clock.

use linewright_core::deadline::{Deadline, StopReason};
use serde::{Deserialize, Serialize};

/// Limits of one stage of a command.
#[derive(Debug, Clone, Copy, Default)]
pub struct Limits {
    /// Time limit, memory limit and interruption of the command.
    pub deadline: Deadline,
    /// Maximum memory of all nodes, in MiB.
    pub memory_mib: Option<u64>,
    /// Maximum number of nodes that exist at the same time.
    pub max_nodes: Option<u64>,
    /// Maximum number of nodes created in total, for kernels whose functions own their nodes; used
    /// to choose the kernel. Exceeding it is [`Limit::Memory`].
    pub max_created: Option<u64>,
    /// Maximum units of work; see [`super::Kernel::work`].
    pub max_work: Option<u64>,
    /// Factor by which [`Limits::with_budget`] multiplies budgets.
    pub budget_factor: BudgetFactor,
}

/// Why a stage ended without a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
pub enum Limit {
    /// The deadline passed, or the command was interrupted.
    #[error(transparent)]
    Stopped(StopReason),
    /// The nodes do not fit into the memory limit, or the process takes more.
    #[error("the memory limit was reached")]
    Memory,
    /// The machine has too many states or transitions to list them.
    #[error("the machine is too large to be listed state by state")]
    Size,
    /// The variables take more pairs of bits than [`Bit`](super::Bit) can number.
    #[error("its variables take more than {} bits", super::MAX_PAIRS)]
    Bits,
    /// The work budget is used up; carries the budget in units.
    #[error("it took more than {0} units of work")]
    Work(u64),
    /// The node budget is used up; carries the budget.
    #[error("it needed more than {0} nodes at once")]
    Nodes(u64),
}

impl From<StopReason> for Limit {
    fn from(reason: StopReason) -> Self {
        match reason {
            StopReason::Memory => Self::Memory,
            StopReason::Time | StopReason::Interrupt => Self::Stopped(reason),
        }
    }
}

impl Limit {
    /// Whether the limit comes from `--timeout`, `--memory` or Ctrl-C. All other limits depend only
    /// on the question, so a second attempt reaches them again.
    pub fn is_external(self) -> bool {
        matches!(self, Self::Stopped(_) | Self::Memory)
    }

    /// Advice on the option that raises the limit; `None` if only smaller domains help.
    pub fn remedy(self) -> Option<&'static str> {
        match self {
            Self::Stopped(reason) => Some(reason.remedy()),
            Self::Memory => Some("allow more memory with --memory MIB"),
            Self::Size | Self::Bits => None,
            Self::Work(_) | Self::Nodes(_) => Some("raise the work limit with --effort FACTOR"),
        }
    }
}

/// Work and nodes that one question may use before it is abandoned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Maximum units of work; see [`super::Kernel::work`].
    pub work: u64,
    /// Maximum number of nodes that exist at the same time.
    pub nodes: u64,
}

/// The default budgets. An idle computer does about 20 million units of work per second. The
/// shipped examples use less than a third of the work and half of the nodes: before proofs searched
/// backward as well, the most expensive question about the laboratory's line, the premises of its
/// verdict, took 166 million units and fewer than 500,000 nodes. `check` waits for the answer to
/// each question about a line, so [`Budget::LINE`] corresponds to only half a minute.
impl Budget {
    /// For each question about a line: about the calls of its stations, about whether parts keep
    /// moving, and about the premises of these verdicts.
    pub const LINE: Self = Self {
        work: 600_000_000,
        nodes: 1_000_000,
    };
    /// For the closed composition of a machine's controllers.
    pub const CLOSED_COMPOSITION: Self = Self {
        work: 3_000_000_000,
        nodes: 3_000_000,
    };
    /// For the proof of a machine's contract from the contracts of its components.
    pub const MACHINE: Self = Self {
        work: 3_000_000_000,
        nodes: 8_000_000,
    };
    /// For listing the states of a machine if functions are acceptable instead.
    pub const LISTING: Self = Self {
        work: 16_000_000,
        nodes: 500_000,
    };
    /// For examining the assumptions of a realizable contract, and for examining its formulas. Each
    /// may take a quarter of the verdict's work in addition.
    pub const EXAMINATION: Self = Self {
        work: 2_000_000,
        nodes: 400_000,
    };
    /// For finding a minimal set of guarantees that clash.
    pub const CORE: Self = Self {
        work: 300_000_000,
        nodes: 1 << 24,
    };
    /// For the counterstrategy of such guarantees.
    pub const COUNTERSTRATEGY: Self = Self {
        work: 300_000_000,
        nodes: 2_000_000,
    };
    /// For the search for repairs.
    pub const REPAIRS: Self = Self {
        work: 300_000_000,
        nodes: 2_000_000,
    };
    /// For a question about the free places that a conveyor's contract guarantees. Such a contract
    /// is usually small. If it is large, the question is left open rather than taking a long time.
    pub const CONVEYOR: Self = Self {
        work: 200_000_000,
        nodes: 200_000,
    };
    /// For each question about a machine's wiring. The states of the machine's coordinator raise
    /// many of them.
    pub const WIRING: Self = Self {
        work: 200_000_000,
        nodes: 2_000_000,
    };
}

/// Factor by which budgets are multiplied (`--effort`); 1 by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetFactor(f64);

impl BudgetFactor {
    /// The default factor.
    pub const ONE: Self = Self(1.0);

    /// Creates a factor; `None` unless it is finite and above 0.
    pub fn new(factor: f64) -> Option<Self> {
        (factor.is_finite() && factor > 0.0).then_some(Self(factor))
    }

    /// Returns `count` times the factor, at least 1.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "float casts saturate, and the factor is positive"
    )]
    pub fn scale(self, count: u64) -> u64 {
        ((count as f64 * self.0) as u64).max(1)
    }
}

impl Default for BudgetFactor {
    fn default() -> Self {
        Self::ONE
    }
}

impl Limits {
    /// Returns an error once the deadline has passed.
    pub fn check_time(&self) -> Result<(), Limit> {
        Ok(self.deadline.check()?)
    }

    /// Lowers the work and node limits to the budget times [`Self::budget_factor`]. Limits that are
    /// already lower stay.
    #[must_use]
    pub fn with_budget(&self, budget: Budget) -> Self {
        let lower = |limit: Option<u64>, budget: u64| {
            let budget = self.budget_factor.scale(budget);
            Some(limit.map_or(budget, |limit| limit.min(budget)))
        };
        Self {
            max_nodes: lower(self.max_nodes, budget.nodes),
            max_work: lower(self.max_work, budget.work),
            ..*self
        }
    }

    /// Like [`Limits::with_budget`], for a kernel that has already done `done` units of work.
    #[must_use]
    pub fn with_budget_after(&self, done: u64, budget: Budget) -> Self {
        let limits = self.with_budget(budget);
        Self {
            max_work: limits.max_work.map(|most| most.saturating_add(done)),
            ..limits
        }
    }

    /// Returns an error once more work was done than allowed.
    pub(crate) fn check_work(&self, done: u64) -> Result<(), Limit> {
        match self.max_work {
            Some(most) if done > most => Err(Limit::Work(most)),
            _ => Ok(()),
        }
    }

    /// Maximum number of nodes of the given size in bytes: `usual` without a memory limit,
    /// otherwise as many as fit, but at most `most`; in both cases at most [`Self::max_nodes`].
    pub(super) fn nodes(&self, bytes_per_node: u64, usual: u64, most: u64) -> u64 {
        let by_memory = self.memory_mib.map_or(usual, |mib| {
            (mib.saturating_mul(1 << 20) / bytes_per_node).min(most)
        });
        self.max_nodes.map_or(by_memory, |n| n.min(by_memory))
    }

    /// Corrects a reported [`Limit::Memory`] to [`Limit::Nodes`] if the memory has ample room for
    /// the allowed nodes (128 bytes for each) and the process never took too much, so that the node
    /// limit must be the cause.
    pub fn attribute(&self, limit: Limit) -> Limit {
        const BYTES: u64 = 128;
        let has_room = |nodes: u64| {
            let memory = self.memory_mib.map(|mib| mib.saturating_mul(1 << 20));
            memory.is_none_or(|bytes| bytes / BYTES >= nodes)
        };
        match (limit, self.max_nodes) {
            (Limit::Memory, Some(most))
                if has_room(most) && !self.deadline.has_exceeded_memory() =>
            {
                Limit::Nodes(most)
            }
            _ => limit,
        }
    }
}
