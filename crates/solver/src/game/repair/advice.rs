//! What could be done about an unrealizable specification, in plain data.

use crate::game::reference::{AssumptionRef, GuaranteeKind, GuaranteeRef};
use linewright_core::gr1::Expr;
use serde::{Deserialize, Serialize};

/// What could be done about an unrealizable specification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// The assumptions without which fewer guarantees than the core's would clash already.
    pub matters: Vec<AssumptionRef>,
    /// Not even a plant that helps could make all guarantees hold: no assumption mends it.
    pub contradictory: bool,
    /// Then: guarantees that contradict each other even so, none of which can be left out. None, if
    /// the assumptions do by themselves.
    pub contradiction: Vec<GuaranteeRef>,
    /// Assumptions, any of which makes it realizable, the one that forbids least first.
    pub assumptions: Vec<NewAssumption>,
    /// Where no single guarantee can be weakened: a minimal set of guarantees without which the
    /// rest can be kept.
    pub leave_out: Vec<GuaranteeRef>,
    /// Guarantees of the core, any of which can be weakened to make it realizable, the one that
    /// gives up least first.
    pub weakenings: Vec<Weakening>,
}

/// An assumption that would help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewAssumption {
    /// Which kind it is.
    pub kind: GuaranteeKind,
    /// The formula.
    pub formula: Expr,
    /// The share of the environment's steps that it forbids; of a justice assumption, in which its
    /// condition does not hold.
    pub forbids: f64,
}

/// A guarantee that need not hold in every case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Weakening {
    /// Which guarantee.
    pub guarantee: GuaranteeRef,
    /// When it need not hold; `None` where it has to be left out.
    pub unless: Option<Expr>,
    /// The share of all steps in which it need not hold.
    pub gives_up: f64,
}
