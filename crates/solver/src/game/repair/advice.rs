//! Possible repairs of an unrealizable specification, as plain data.

use crate::game::reference::{AssumptionRef, GuaranteeRef};
use linewright_core::gr1::{Expr, FormulaKind};
use serde::{Deserialize, Serialize};

/// Possible repairs of an unrealizable specification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The assumptions that matter: without any one of them, a proper subset of the core would
    /// already clash.
    pub matters: Vec<AssumptionRef>,
    /// Whether the formulas contradict each other: even a cooperating environment cannot make all
    /// guarantees hold, so no assumption repairs the specification.
    pub contradictory: bool,
    /// If the formulas are contradictory, a minimal set of guarantees that cannot hold together
    /// even in a cooperating environment. Empty if the assumptions alone are contradictory.
    pub contradiction: Vec<GuaranteeRef>,
    /// Assumptions, each of which makes the specification realizable; the least restrictive first.
    pub assumptions: Vec<NewAssumption>,
    /// If weakening a single guarantee does not help: a minimal set of guarantees whose omission
    /// makes the specification realizable. Otherwise empty.
    pub leave_out: Vec<GuaranteeRef>,
    /// Weakenings of guarantees of the core, each of which makes the specification realizable; the
    /// smallest loss first.
    pub weakenings: Vec<Weakening>,
}

/// An assumption that makes a specification realizable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewAssumption {
    /// Kind of the assumption.
    pub kind: FormulaKind,
    /// The formula.
    pub formula: Expr,
    /// Share (0 to 1) of the environment's steps that the assumption forbids; for justice, of the
    /// steps that do not satisfy its formula.
    pub forbids: f64,
}

/// A guarantee to weaken or to leave out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weakening {
    /// The guarantee.
    pub guarantee: GuaranteeRef,
    /// Condition under which the guarantee need not hold; `None` to leave it out.
    pub unless: Option<Expr>,
    /// Share (0 to 1) of all steps in which the guarantee need not hold.
    pub gives_up: f64,
}
