//! The GR(1) game: who wins, how, and why not.
//!
//! ```text
//! Specification ─encode→ Arena ─winning_region→ Won ─strategy→ Explorer ─→ explicit states, mealy::extract takes over
//!                                            └→ Lost ─minimal_core→ the guarantees that clash
//! ```
//!
//! The semantics is that of [`linewright_core::gr1`]: Bloem, Jobstmann, Piterman, Pnueli and Sa'ar,
//! "Synthesis of Reactive(1) Designs", Journal of Computer and System Sciences 78(3), 2012; safety
//! first, strictly. No BDD type is public here.

mod arena;
mod attack;
mod clusters;
mod core;
mod cover;
mod diagram_builder;
mod explore;
mod findings;
mod fixpoint;
mod functions;
mod heuristics;
mod lasting;
mod outcome;
mod progress;
mod ranking;
mod reachable;
mod reference;
mod relation;
mod repair;
mod runs;
mod set_up;
mod solver;
mod statistics;
mod strategy;
mod structure;
#[cfg(test)]
mod tests;

pub use self::attack::{Attack, Ending, Play, reduced};
pub use self::core::quick_xplain;
pub use self::explore::{Explicit, Row};
pub use self::findings::requests::Request;
pub use self::findings::shape::{Shape, UnframedOutput};
pub use self::findings::{EnvironmentFindings, Situation};
pub use self::functions::{Aim, Assumed, Certificate, Controls, Mode, Pursuit, Stage};
pub use self::heuristics::{Heuristic, Heuristics};
pub use self::outcome::{LostGame, Outcome, WonGame};
pub use self::progress::{Phase, Progress};
pub use self::ranking::{Rank, Ranking};
pub use self::reference::{AssumptionRef, GuaranteeKind, GuaranteeRef};
pub use self::repair::{Advice, NewAssumption, Weakening, negation};
pub use self::runs::{Lasso, Rule, RuleKind, RunQuery, Runs, SafetyViolationQuery};
pub use self::solver::{
    KernelChoice, Options, Solution, advise, attack, examine_environment, order_of_variables,
    solve, solve_with,
};
pub use self::statistics::Statistics;
pub use self::strategy::Preference;
pub use crate::symbolic::{Budget, Diagram, DiagramNode, Edge, Effort, Limit, Limits, Order};

use linewright_core::gr1::Specification;

/// An initial order of the pairs of bits from the structure of the formulas, for users that encode
/// them without a game.
pub fn order_by_structure(specification: &Specification) -> Order {
    arena::first_order(specification, Heuristics::default())
}
