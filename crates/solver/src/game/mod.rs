//! The GR(1) game: who wins, how, and why not.
//!
//! ```text
//! Specification ─encode→ Arena ─winning_region→ WonGame ─explore→ ExplicitStrategy
//!                                            └→ LostGame, with a minimal core of guarantees
//! ```
//!
//! The semantics is that of [`linewright_core::gr1`]: Bloem, Jobstmann, Piterman, Pnueli and Sa'ar,
//! "Synthesis of Reactive(1) Designs", Journal of Computer and System Sciences 78(3), 2012, with
//! strict precedence of safety over justice. This module exposes no BDD types.

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

pub use self::attack::{Attack, Ending, Play, PlayEnd, select_guarantees};
pub use self::core::quick_xplain;
pub use self::explore::{ExplicitStrategy, Row};
pub use self::findings::requests::{Request, declared_requests};
pub use self::findings::shape::{UnframedOutput, WeaknessFindings};
pub use self::findings::{EnvironmentFindings, PartialValuation};
pub use self::functions::{
    Aim, AssumedFormula, Certificate, CertifiedLayer, GoalStrategy, Mode, StrategyFunctions,
};
pub use self::heuristics::{Heuristic, Heuristics};
pub use self::outcome::{LostGame, Outcome, WonGame};
pub use self::progress::{Phase, Progress};
pub use self::ranking::{Rank, Ranking};
pub use self::reference::{AssumptionRef, GuaranteeRef};
pub use self::repair::{Advice, NewAssumption, Weakening, negation};
pub use self::runs::{Lasso, Rule, RunQuery, Runs, SafetyViolationQuery};
pub use self::solver::{
    KernelChoice, Options, Solution, advise, attack, attack_until, examine_environment,
    order_from_variables, solve, solve_with,
};
pub use self::statistics::Statistics;
pub use self::strategy::Preference;
pub use crate::symbolic::{Budget, BudgetFactor, Diagram, DiagramNode, Edge, Limit, Limits, Order};

use linewright_core::gr1::Specification;

/// Returns a variable order based on the structure of the formulas, for callers that encode the
/// formulas without solving a game.
pub fn order_by_structure(specification: &Specification) -> Order {
    arena::initial_order(specification, Heuristics::default())
}
