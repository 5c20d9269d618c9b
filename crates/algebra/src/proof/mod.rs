//! The proof that parts discharge one another's assumptions, and keep what is claimed of them
//! together.
//!
//! Parts rely on one another in circles, the coordinator and its actions first of all, so that
//! "each assumption follows from guarantees" proves nothing by itself. What is sound:
//!
//! - **Safety, step by step.** No assumption is the first to be broken: up to the step before
//!   everything was kept, and in this step an assumption may rest on guarantees of parts that
//!   answer without waiting for it (Abadi and Lamport, "Conjoining Specifications", TOPLAS 17,
//!   1995). Parts are brought into an order for that; outputs that wait for one another within a
//!   step are refused.
//! - **Justice, in an order.** That each of two parts comes true again and again because the other
//!   does is no reason for either (McMillan, "Circular compositional reasoning about liveness",
//!   CHARME 1999). So a part's justice guarantees are relied on only after all its own justice
//!   assumptions were discharged, turn by turn; what is left waits in circles, which are reported.
//!
//! A premise: that a part which answers first keeps what it says of its own answer is relied on
//! without asking for its assumptions in that step. A part whose assumptions leave its environment
//! no next step at all may say anything there; `check` tells of such contracts (LW206).
//!
//! What a proof rests on is a minimal set: it is first looked for near the obligation, by asking
//! who sets what occurs, and then `QuickXplain` leaves away what is not needed.

mod book;
mod goal;
mod justice;
mod loops;
mod prover;

pub use book::{last_step, latest};

use super::system::{FormulaRef, Half, System, formulas, list_mut};
use linewright_core::gr1::{Formula, Side, VarId};
use linewright_solver::game::{Lasso, Limit, Limits};
use std::collections::{BTreeMap, BTreeSet};

/// What is to be shown of a system.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Claim {
    /// What the environment is known to keep. It counts from the first step on.
    pub given: Side,
    /// What the parts are to keep together, beside each other's assumptions.
    pub goal: Side,
    /// Formulas of the goal that need not be shown: where one can be, others may rest on it.
    pub lemmas: BTreeMap<FormulaRef, Reach>,
    /// What a formula of the goal is tried to be shown from first, and a lemma from nothing else;
    /// formulas of the goal only where they were shown. A proof of many steps, each of which is
    /// about little, is written down so.
    pub from: BTreeMap<FormulaRef, BTreeSet<FormulaRef>>,
    /// Formulas of the goal that were shown before, step by step: they are not shown again.
    pub known: BTreeSet<FormulaRef>,
    /// Whether an assumption that speaks of what comes from outside may be handed on to the
    /// environment.
    pub exports: Exports,
}

impl Claim {
    /// The formulas of the goal, with where they stand.
    pub fn goals(&self) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        formulas(&self.goal).map(|(kind, index, formula)| {
            let at = FormulaRef {
                part: None,
                half: Half::Guarantees,
                kind,
                index,
            };
            (at, formula)
        })
    }

    /// The same claim of fewer formulas, without lemmas.
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

/// Who may rest on a lemma.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reach {
    /// Every formula of the goal that it stands near.
    #[default]
    Near,
    /// Those that name it in [`Claim::from`].
    Named,
}

/// What happens to an assumption that no guarantee discharges and that speaks of what comes from
/// outside.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Exports {
    /// It stays open.
    #[default]
    Never,
    /// The environment has to keep it.
    Always,
    /// The environment has to keep it in the step after one in which this holds (and in step 0);
    /// everywhere else it has to be discharged.
    After(linewright_core::gr1::Expr),
}

/// How an obligation is met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Discharge {
    /// The assumption, or the part of the goal.
    pub what: FormulaRef,
    /// By which rule.
    pub rule: Discharged,
    /// What it rests on: none of these can be left out. Guarantees of parts, and what is given.
    pub by: Vec<FormulaRef>,
}

/// The rules of a discharge, in the order in which they are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Discharged {
    /// It follows from what the environment is known to keep.
    Environment,
    /// It is handed on: the environment has to keep it.
    Exported,
    /// Step by step: it is not broken before a guarantee is.
    Induction,
    /// It comes true again and again, since these guarantees do; parts that were discharged in
    /// earlier turns (from 0) may be relied on.
    Justice {
        /// The turn.
        turn: usize,
    },
}

/// An obligation that is not met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Open {
    /// The assumption, or the part of the goal.
    pub what: FormulaRef,
    /// How it is broken.
    pub why: Broken,
}

/// A counterexample, over all variables of the system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Broken {
    /// The last step breaks it, although every step before kept everything.
    Trace(Vec<Vec<i64>>),
    /// From some step on it is never met again.
    Lasso(Lasso),
}

/// Outputs that wait for one another within a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SameStepLoop {
    /// Each depends on the one after it, the last on the first.
    pub variables: Vec<VarId>,
}

/// Justice assumptions that wait for one another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Circle {
    /// Each is owed by the part of the one after it, which owes it only under its own assumption;
    /// the last waits for the first.
    pub assumptions: Vec<FormulaRef>,
}

/// All that came out.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Proof {
    /// What is met, in the order of the parts and their formulas; the goal's formulas come last.
    pub discharges: Vec<Discharge>,
    /// What is not.
    pub open: Vec<Open>,
    /// Loops within a step. With one of them, nothing else is decided.
    pub loops: Vec<SameStepLoop>,
    /// Circles of justice.
    pub circles: Vec<Circle>,
}

impl Proof {
    /// Whether everything is discharged.
    pub fn holds(&self) -> bool {
        self.open.is_empty() && self.loops.is_empty() && self.circles.is_empty()
    }
}

/// Proves a claim about a system, or says what keeps it from being true.
///
/// # Errors
/// When a limit was reached.
pub fn prove(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.prove()
}

/// Whether a claim holds, as [`prove`] says it, sooner: what a discharge rests on is then enough,
/// and not all of it needed.
///
/// # Errors
/// When a limit was reached.
pub fn decide(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.quick().prove()
}

/// The same, but what is claimed of safety has to be kept step by step: it may not rest on what
/// happens later, nor on runs that cannot go on. Whoever relies on such a claim within a step, as a
/// proof does that knows a machine by the contract that it refines, needs this.
///
/// # Errors
/// When a limit was reached.
pub fn prove_stepwise(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?
        .stepwise()
        .prove()
}
