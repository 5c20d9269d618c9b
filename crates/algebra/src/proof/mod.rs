//! The proof that components discharge one another's assumptions, and together keep the goal of the
//! claim.
//!
//! Components rely on one another in cycles, above all the coordinator and its actions. So it is
//! not sufficient that each assumption follows from guarantees of others. These rules are sound:
//!
//! - **Safety, step by step.** By induction, no assumption is the first formula to be broken: up to
//!   the previous step everything was kept, and in this step an assumption can rest on guarantees
//!   of components whose answers do not depend on it (Abadi and Lamport, "Conjoining
//!   Specifications", TOPLAS 17, 1995). For this, the components are put in an order; outputs that
//!   wait for one another within a step are rejected.
//! - **Justice, in turns.** If each of two components keeps its justice only because the other
//!   does, neither is proved (McMillan, "Circular compositional reasoning about liveness", CHARME
//!   1999). So the proof proceeds in turns: a component's justice guarantees are relied on only
//!   after all its own justice assumptions were discharged. The remaining assumptions wait for one
//!   another in cycles, which are reported. A contract without justice guarantees may still imply
//!   that each request is completed. This is derived from the contract alone, and then counts as
//!   one. Assumptions that were discharged hold on all runs, so later turns can rest on them.
//!
//! The proof has a premise: a component that answers first is relied on to keep its guarantees
//! about its own answer, without checking its assumptions in that step. If the assumptions of a
//! component allow its environment no next step, the component can do anything there; `check`
//! reports such contracts (LW206).
//!
//! Each discharge rests on a minimal set of formulas. A sufficient set is searched near the
//! obligation first, by following variables to the components that set them; then `QuickXplain`
//! removes the formulas that are not needed.

mod book;
mod goal;
mod justice;
mod loops;
mod prover;

pub use book::{last_step, latest};

use super::system::{Component, ContractSide, FormulaRef, System};
use linewright_core::gr1::{Formula, Side, Specification, VarId};
use linewright_solver::game::{Lasso, Limit, Limits};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// A claim about a system, to be proved.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Claim {
    /// Formulas that the environment is known to keep (*givens*).
    pub given: Side,
    /// Formulas that the components together have to keep (*goal*), in addition to each other's
    /// assumptions.
    pub goal: Side,
    /// Formulas of the goal that need not be proved. Once one is proved, other formulas can rest on
    /// it.
    pub lemmas: BTreeMap<FormulaRef, Reach>,
    /// For a formula of the goal: the formulas from which the prover tries to derive it first. A
    /// lemma is derived from these formulas only. Formulas of the goal among them can be used only
    /// once they are proved. In this way, a claim can prescribe a proof in many small steps.
    pub from: BTreeMap<FormulaRef, BTreeSet<FormulaRef>>,
    /// Formulas of the goal that were already proved step by step; they are not proved again.
    pub known: BTreeSet<FormulaRef>,
    /// Whether assumptions about outside inputs are exported to the environment.
    pub exports: Exports,
}

impl Claim {
    /// Returns the formulas of the goal and their references.
    pub fn goals(&self) -> impl Iterator<Item = (FormulaRef, &Formula)> {
        self.goal.formulas().map(|(kind, index, formula)| {
            let at = FormulaRef {
                component: None,
                half: ContractSide::Guarantees,
                kind,
                index,
            };
            (at, formula)
        })
    }

    /// Returns the claim with only the goal formulas for which `wanted` is true, and without
    /// lemmas, sources and known formulas.
    #[must_use]
    pub fn only(&self, wanted: impl Fn(FormulaRef) -> bool) -> Self {
        let mut goal = Side::default();
        for (at, formula) in self.goals().filter(|(at, _)| wanted(*at)) {
            goal.list_mut(at.kind).push(formula.clone());
        }
        Self {
            goal,
            given: self.given.clone(),
            exports: self.exports.clone(),
            ..Self::default()
        }
    }
}

/// Which formulas can rest on a lemma.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reach {
    /// Every formula of the goal whose variables lead to the lemma.
    #[default]
    Near,
    /// Only formulas that name the lemma in [`Claim::from`].
    Named,
}

/// Treatment of an assumption that no guarantee discharges and that mentions outside inputs.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Exports {
    /// The assumption is not exported; it stays open.
    #[default]
    Never,
    /// The environment has to keep the assumption.
    Always,
    /// The environment has to keep the assumption in step 0 and in every step after one in which
    /// this condition holds; in all other steps it has to be discharged.
    After(linewright_core::gr1::Expr),
}

/// Proof of one obligation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Discharge {
    /// Assumption, or formula of the goal.
    pub what: FormulaRef,
    /// Rule that discharges it.
    pub rule: DischargeRule,
    /// Formulas that the proof rests on: guarantees of components and what follows from them,
    /// givens, exported and discharged assumptions, and proved formulas of the goal. The set is
    /// minimal, except with [`decide`] and [`decide_stepwise`].
    pub by: Vec<FormulaRef>,
}

/// Rules of discharge, in the order in which they are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum DischargeRule {
    /// The obligation follows from formulas that the environment keeps: givens and exported
    /// assumptions.
    Environment,
    /// The obligation is exported: the environment has to keep it.
    Exported,
    /// The obligation is proved step by step: it is not broken before a guarantee is.
    Induction,
    /// The obligation recurs because justice guarantees of other components recur.
    Justice {
        /// Turn in which the obligation was discharged, from 0. Only components whose justice
        /// assumptions were discharged in earlier turns are relied on.
        turn: usize,
    },
}

/// An obligation that is not met, with a counterexample.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Open {
    /// Assumption, or formula of the goal.
    pub what: FormulaRef,
    /// Counterexample.
    pub why: Refutation,
}

/// A counterexample, over all variables of the system.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refutation {
    /// A finite run. Its last step breaks the obligation, although everything was kept in all
    /// earlier steps.
    Trace(Vec<Vec<i64>>),
    /// An infinite run on which the obligation never holds again from some step on.
    Lasso(Lasso),
}

/// A loop of outputs that wait for one another within a step.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SameStepLoop {
    /// Variables of the loop: each depends on the next one, the last one on the first.
    pub variables: Vec<VarId>,
}

/// A cycle of justice assumptions that wait for one another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cycle {
    /// Assumptions of the cycle. Each one is kept by the component that makes the next assumption,
    /// and only if that component's own assumption is kept; the last one waits for the first.
    pub assumptions: Vec<FormulaRef>,
}

/// Result of a proof.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Proof {
    /// Obligations that are met, in the order of the components and their formulas; formulas of the
    /// goal come last.
    pub discharges: Vec<Discharge>,
    /// Obligations that are not met.
    pub open: Vec<Open>,
    /// Loops within a step. If the outputs of components form a loop, nothing else is decided.
    pub loops: Vec<SameStepLoop>,
    /// Cycles of justice assumptions.
    pub cycles: Vec<Cycle>,
}

impl Proof {
    /// Returns whether all obligations are discharged.
    pub fn holds(&self) -> bool {
        self.open.is_empty() && self.loops.is_empty() && self.cycles.is_empty()
    }
}

/// Returns the completions of a contract that follow from it: formulas that hold infinitely often,
/// over the contract's variables. See [`Component::completions`].
///
/// # Errors
/// When a limit was reached.
pub fn completions(specification: &Specification, limits: &Limits) -> Result<Vec<Formula>, Limit> {
    let mut component = Component::of(specification);
    let justice = std::mem::take(&mut component.completions).justice;
    if justice.is_empty() {
        return Ok(justice);
    }
    let claim = Claim {
        given: std::mem::take(&mut component.assumptions),
        goal: Side {
            justice: justice.clone(),
            ..Side::default()
        },
        ..Claim::default()
    };
    let system = System {
        variables: specification.variables.clone(),
        components: vec![component],
    };
    let proof = decide(&system, &claim, limits)?;
    let followed = proof.discharges.iter().map(|d| d.what.index);
    Ok(followed.map(|index| justice[index].clone()).collect())
}

/// Proves a claim about a system, or returns counterexamples. Safety of the goal is proved for
/// infinite runs: a step that violates it does not count if it leads to a state from which no run
/// continues. See [`prove_stepwise`] for machines and compositions.
///
/// # Errors
/// When a limit was reached.
pub fn prove(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.prove()
}

/// Decides a claim like [`prove`], but faster: the formulas that a discharge rests on are
/// sufficient, but not minimal.
///
/// # Errors
/// When a limit was reached.
pub fn decide(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?.quick().prove()
}

/// Like [`prove`], but safety of the goal has to be kept step by step: a step counts even if it
/// leads to a state from which no run continues. This is the strict semantics of GR(1): a machine
/// must not break its safety first and rely on an environment that can then no longer keep its
/// assumptions. It is also necessary if another proof relies on the claim within a step, such as a
/// proof that represents a machine by the contract that it refines.
///
/// # Errors
/// When a limit was reached.
pub fn prove_stepwise(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?
        .stepwise()
        .prove()
}

/// Decides a claim like [`prove_stepwise`], but faster: the formulas that a discharge rests on are
/// sufficient, but not minimal.
///
/// # Errors
/// When a limit was reached.
pub fn decide_stepwise(system: &System, claim: &Claim, limits: &Limits) -> Result<Proof, Limit> {
    prover::Prover::new(system, claim, limits)?
        .stepwise()
        .quick()
        .prove()
}
