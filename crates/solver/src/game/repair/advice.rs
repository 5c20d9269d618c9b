//! Possible repairs of an unrealizable specification, as plain data.

use crate::game::reference::{AssumptionRef, GuaranteeKind, GuaranteeRef};
use linewright_core::gr1::Expr;
use serde::{Deserialize, Serialize};

/// Possible repairs of an unrealizable specification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The assumptions without which a proper subset of the core would already clash.
    pub matters: Vec<AssumptionRef>,
    /// Even a cooperating plant cannot make all guarantees hold: no assumption repairs this.
    pub contradictory: bool,
    /// In that case, a minimal set of guarantees that contradict each other even so. Empty if the
    /// assumptions alone are contradictory.
    pub contradiction: Vec<GuaranteeRef>,
    /// Assumptions, each of which makes it realizable; the least restrictive first.
    pub assumptions: Vec<NewAssumption>,
    /// If no single guarantee can be weakened: a minimal set of guarantees to leave out so that the
    /// rest can be kept.
    pub leave_out: Vec<GuaranteeRef>,
    /// Guarantees of the core, each of which can be weakened to make it realizable; the smallest
    /// loss first.
    pub weakenings: Vec<Weakening>,
}

/// An assumption that would help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewAssumption {
    /// Kind of the assumption.
    pub kind: GuaranteeKind,
    /// The formula.
    pub formula: Expr,
    /// Share (0 to 1) of the environment's steps that it forbids; for justice, of those in which
    /// its condition does not hold.
    pub forbids: f64,
}

/// A guarantee that is weakened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weakening {
    /// The guarantee.
    pub guarantee: GuaranteeRef,
    /// Condition under which it need not hold; `None` if it has to be left out.
    pub unless: Option<Expr>,
    /// Share (0 to 1) of all steps in which it need not hold.
    pub gives_up: f64,
}
