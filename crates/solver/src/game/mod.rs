//! The GR(1) game: who wins, how, and why not.
//!
//! ```text
//! Specification ─encode→ Arena ─winning_region→ Won ─strategy→ Explorer ─→ explicit states, mealy::extract takes over
//!                                            └→ Lost ─minimal_core→ the guarantees that clash
//! ```
//!
//! The semantics is that of [`linewright_core::gr1`]: Bloem, Jobstmann, Piterman, Pnueli and Sa'ar, "Synthesis of Reactive(1) Designs",
//! Journal of Computer and System Sciences 78(3), 2012; safety first, strictly. No BDD type is public here.

mod arena;
mod attack;
mod clusters;
mod core;
mod cover;
mod explore;
mod findings;
mod fixpoint;
mod functions;
mod heuristics;
mod lasting;
mod progress;
mod ranking;
mod relation;
mod repair;
mod runs;
mod set_up;
mod solver;
mod strategy;
mod structure;
#[cfg(test)]
mod tests;
mod workbench;

pub use self::attack::{Attack, Ending, Play, reduced};
pub use self::core::quick_xplain;
pub use self::explore::{Explicit, Row};
pub use self::findings::requests::Request;
pub use self::findings::shape::{Shape, Unframed};
pub use self::findings::{EnvironmentFindings, examine_environment};
pub use self::functions::{Aim, Assumed, Certificate, Controls, Mode, Pursuit, Stage};
pub use self::heuristics::{Heuristic, Heuristics};
pub use self::progress::{Phase, Progress};
pub use self::ranking::{Rank, Ranking};
pub use self::repair::{Advice, NewAssumption, Weakening, negation};
pub use self::runs::{Lasso, Rule, RuleKind, Runs, Slip, Wanted};
pub use self::solver::{
    KernelChoice, Options, Solved, Statistics, advise, attack, order_of_variables, solve,
    solve_with,
};
pub use self::strategy::Preference;
pub use crate::symbolic::{Budget, Diagram, DiagramNode, Edge, Effort, Limit, Limits, Order};

use linewright_core::gr1::{Side, Specification};
use serde::{Deserialize, Serialize};

/// An order of the pairs of bits to begin with, from the structure of the formulas, for whoever encodes them without a game.
pub fn order_by_structure(specification: &Specification) -> Order {
    arena::first_order(specification, Heuristics::default())
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

/// What is known of a specification that is realizable. [`Won::explore`] makes a strategy of it.
#[derive(Debug)]
pub struct Won {
    game: Box<dyn solver::Game>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// What is known of a specification that is not.
#[derive(Debug)]
pub struct Lost {
    /// Guarantees that cannot be kept together under the assumptions, although any smaller set of them could: a minimal core.
    /// `None` when a limit was reached before it was known.
    pub core: Option<Vec<GuaranteeRef>>,
    /// The largest number of nodes that were alive at once.
    pub peak_nodes: u64,
}

/// Points at one guarantee of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct GuaranteeRef {
    /// Its list.
    pub kind: GuaranteeKind,
    /// Its place in that list.
    pub index: usize,
}

/// Points at one assumption of a specification.
pub type AssumptionRef = GuaranteeRef;

/// The lists of [`Side`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum GuaranteeKind {
    /// [`Side::initial`]
    Initial,
    /// [`Side::invariants`]
    Invariant,
    /// [`Side::safety`]
    Safety,
    /// [`Side::justice`]
    Justice,
}

impl GuaranteeRef {
    /// The formula it points at.
    pub fn formula(self, guarantees: &Side) -> &linewright_core::gr1::Formula {
        match self.kind {
            GuaranteeKind::Initial => &guarantees.initial[self.index],
            GuaranteeKind::Invariant => &guarantees.invariants[self.index],
            GuaranteeKind::Safety => &guarantees.safety[self.index],
            GuaranteeKind::Justice => &guarantees.justice[self.index],
        }
    }
}

impl Lost {
    /// The names of the core's formulas; empty when the core is not known.
    pub fn core_names(&self, specification: &Specification) -> Vec<String> {
        let core = self.core.iter().flatten();
        core.map(|r| r.formula(&specification.guarantees).name.clone())
            .collect()
    }
}

impl Won {
    /// A strategy as explicit states with guards, in plain data.
    pub fn explore(
        &self,
        specification: &Specification,
        preference: Preference,
        limits: &Limits,
    ) -> Result<Explicit, Limit> {
        self.game.explore(specification, preference, limits)
    }

    /// A strategy as functions, in plain data: for machines that are too large for [`Won::explore`].
    pub fn functions(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Controls, Limit> {
        self.game.functions(specification, limits)
    }

    /// What is odd about the assumptions; see [`examine_environment`].
    pub fn examine_environment(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<EnvironmentFindings, Limit> {
        self.game.examine_environment(specification, limits)
    }

    /// Where it asks for less than it seems to; see [`Shape`].
    pub fn shape(&self, specification: &Specification, limits: &Limits) -> Result<Shape, Limit> {
        self.game.shape(specification, limits)
    }

    /// Why it is won, for whoever wants to check it.
    pub fn ranking(
        &self,
        specification: &Specification,
        limits: &Limits,
    ) -> Result<Ranking, Limit> {
        self.game.ranking(specification, limits)
    }

    /// The states from which the machine wins, over current bits, as the only root.
    pub fn region(&self) -> Diagram {
        self.game.region()
    }
}
