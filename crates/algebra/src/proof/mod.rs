//! The proof that parts discharge one another's assumptions, and together keep the goal of the
//! claim.
//!
//! Parts rely on one another in circles, above all the coordinator and its actions, so "each
//! assumption follows from guarantees" proves nothing by itself. These rules are sound:
//!
//! - **Safety, step by step.** No assumption is the first to be broken: up to the previous step
//!   everything was kept, and in this step an assumption may rest on guarantees of parts that
//!   answer without waiting for it (Abadi and Lamport, "Conjoining Specifications", TOPLAS 17,
//!   1995). For that, parts are put in an order; outputs that wait for one another within a step
//!   are rejected.
//! - **Justice, in an order.** If each of two parts keeps its justice only because the other does,
//!   neither is proved (McMillan, "Circular compositional reasoning about liveness", CHARME 1999).
//!   So a part's justice guarantees are relied on only after all its own justice assumptions were
//!   discharged, turn by turn. The rest wait in circles, which are reported.
//!
//! A premise: a part that answers first is relied on to keep its guarantees about its own answer,
//! without checking its assumptions in that step. A part whose assumptions leave its environment no
//! next step at all may do anything there; `check` reports such contracts (LW206).
//!
//! Each discharge rests on a minimal set: it is first searched near the obligation, by following
//! the variables to the parts that set them; then `QuickXplain` removes what is not needed.

mod book;
mod goal;
mod justice;
mod loops;
mod prover;

pub use book::{last_step, latest};

use super::system::{ContractSide, FormulaRef, System, formulas, list_mut};
use linewright_core::gr1::{Formula, Side, VarId};
use linewright_solver::game::{Lasso, Limit, Limits};
use std::collections::{BTreeMap, BTreeSet};

/// What is to be shown about a system.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Claim {
    /// What the environment is known to keep, from the first step on.
    pub given: Side,
    /// What the parts have to keep together, in addition to each other's assumptions.
    pub goal: Side,
    /// Formulas of the goal that need not be shown; if one can be, others may rest on it.
    pub lemmas: BTreeMap<FormulaRef, Reach>,
    /// Formulas from which a formula of the goal is tried to be shown first, and a lemma
    /// exclusively; formulas of the goal only if they were shown. Lets the claim spell out a proof
    /// of many small steps.
    pub from: BTreeMap<FormulaRef, BTreeSet<FormulaRef>>,
    /// Formulas of the goal that were already shown step by step; they are not shown again.
    pub known: BTreeSet<FormulaRef>,
    /// Whether an assumption about outside inputs may be handed on to the environment.
    pub exports: Exports,
}

impl Claim {
    /// Returns the formulas of the goal and their references.
    pub fn goals(&self) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        formulas(&self.goal).map(|(kind, index, formula)| {
            let at = FormulaRef {
                part: None,
                half: ContractSide::Guarantees,
                kind,
                index,
            };
            (at, formula)
        })
    }

    /// Returns the same claim with fewer formulas and without lemmas.
    #[must_use]
    pub fn only(&self, wanted: impl Fn(FormulaRef) -> bool) -> Self {
        let mut goal = Side::default();
        for (at, formula) in self.goals().filter(|(at, _)| wanted(*at)) {
            list_mut(&mut goal, at.kind).push(formula.clone());
        }
        Self {
            goal,
            given: self.given.clone(),
            exports: self.exports.clone(),
            ..Self::default()
        }
    }
}

/// Formulas that may rest on a lemma.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reach {
    /// Every formula of the goal near it.
    #[default]
    Near,
    /// Those that name it in [`Claim::from`].
    Named,
}

/// Treatment of an assumption that no guarantee discharges and that mentions outside inputs.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Exports {
    /// It stays open.
    #[default]
    Never,
    /// The environment has to keep it.
    Always,
    /// The environment has to keep it in a step after one in which this holds (and in step 0);
    /// everywhere else it has to be discharged.
    After(linewright_core::gr1::Expr),
}

/// How an obligation is met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Discharge {
    /// Assumption, or formula of the goal.
    pub what: FormulaRef,
    /// Rule that discharges it.
    pub rule: DischargeRule,
    /// Minimal set of formulas that it rests on: guarantees of parts, and givens.
    pub by: Vec<FormulaRef>,
}

/// Rules of discharge, in the order in which they are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DischargeRule {
    /// It follows from the environment's givens.
    Environment,
    /// It is handed on: the environment has to keep it.
    Exported,
    /// Step by step: it is not broken before a guarantee is.
    Induction,
    /// It recurs because these guarantees do; parts discharged in earlier turns (from 0) may be
    /// relied on.
    Justice {
        /// Turn in which it was discharged.
        turn: usize,
    },
}

/// An obligation that is not met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Open {
    /// Assumption, or formula of the goal.
    pub what: FormulaRef,
    /// Counterexample.
    pub why: Refutation,
}

/// A counterexample, over all variables of the system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refutation {
    /// The last step breaks it, although everything was kept in every earlier step.
    Trace(Vec<Vec<i64>>),
    /// From some step on it is never met again.
    Lasso(Lasso),
}

/// Outputs that wait for one another within a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SameStepLoop {
    /// Each variable depends on the next one, the last on the first.
    pub variables: Vec<VarId>,
}

/// Justice assumptions that wait for one another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Circle {
    /// Each assumption has to be met by the part of the next one, which does so only under its own
    /// assumption; the last waits for the first.
    pub assumptions: Vec<FormulaRef>,
}

/// Result of a proof.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Proof {
    /// Obligations that are met, in the order of the parts and their formulas; the goal's formulas
    /// come last.
    pub discharges: Vec<Discharge>,
    /// Obligations that are not met.
    pub open: Vec<Open>,
    /// Loops within a step. If there are any, nothing else is decided.
    pub loops: Vec<SameStepLoop>,
    /// Circles of justice.
    pub circles: Vec<Circle>,
}

impl Proof {
    /// Returns whether everything is discharged.
    pub fn holds(&self) -> bool {
        self.open.is_empty() && self.loops.is_empty() && self.circles.is_empty()
    }
}

/// Proves a claim about a system, or returns counterexamples.
///
/// # Errors
/// When a limit was reached.
pub fn prove(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.prove()
}

/// Decides a claim like [`prove`], but faster: the reasons of a discharge are sufficient, not
/// minimal.
///
/// # Errors
/// When a limit was reached.
pub fn decide(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.quick().prove()
}

/// Like [`decide`], but claimed safety has to be kept step by step: it may not rest on later steps,
/// nor on runs that cannot go on. This is needed if the claim is relied on within a step, as in a
/// proof that knows a machine by the contract that it refines.
///
/// # Errors
/// When a limit was reached.
pub fn prove_stepwise(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?
        .stepwise()
        .prove()
}
