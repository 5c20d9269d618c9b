//! Refinement between two contracts, with reasons: from which old assumptions each new assumption
//! follows, and from which new guarantees each old guarantee follows.
//!
//! `C₁ ≼ C₂` holds if `A₂ ⊆ A₁` and `A₂ ∧ G₁ ⊆ G₂`: every environment of the old contract C₂ is
//! also one of the new contract C₁, and in such an environment the new contract keeps the old
//! guarantees. This is decided exactly on infinite runs.

use super::proof::{Claim, Exports, Proof, prove};
use super::system::{Component, System};
use linewright_core::gr1::{Expr, Formula, Side};
use linewright_core::source::Span;
use linewright_solver::game::{Limit, Limits};

/// Result of a refinement check. In both proofs, the givens are the assumptions of the refined
/// contract.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refinement {
    /// Proof whose goal is the refining contract's assumptions; they have to follow from the
    /// givens.
    pub assumptions: Question,
    /// Proof whose goal is the refined contract's guarantees.
    pub guarantees: Question,
    /// Whether no run keeps the refined contract's assumptions, so that every contract refines it.
    pub is_vacuous: bool,
}

/// A proof together with its system and claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// System of the proof.
    pub system: System,
    /// Claim of the proof.
    pub claim: Claim,
    /// Result of the proof.
    pub proof: Proof,
}

impl Refinement {
    /// Returns whether the refinement holds.
    pub fn holds(&self) -> bool {
        self.assumptions.proof.holds() && self.guarantees.proof.holds()
    }
}

/// Decides whether component `small` of a system refines component `large`.
///
/// # Errors
/// When a limit was reached.
pub fn refine(
    system: &System,
    small: usize,
    large: usize,
    limits: &Limits,
) -> Result<Refinement, Limit> {
    let (new, old) = (&system.components[small], &system.components[large]);
    // Both views keep the definitions of their monitors, whatever guarantees are used.
    let views = |guaranteed: &Side| {
        let view = |component: &Component, guarantees: &Side| Component {
            assumptions: Side::default(),
            guarantees: guarantees.clone(),
            completions: Side::default(),
            ..component.clone()
        };
        vec![view(new, guaranteed), view(old, &Side::default())]
    };
    let question = |guaranteed: &Side, goal: &Side| -> Result<Question, Limit> {
        let system = System {
            variables: system.variables.clone(),
            components: views(guaranteed),
        };
        let claim = Claim {
            given: old.assumptions.clone(),
            goal: goal.clone(),
            exports: Exports::Never,
            ..Claim::default()
        };
        let proof = prove(&system, &claim, limits)?;
        Ok(Question {
            system,
            claim,
            proof,
        })
    };
    Ok(Refinement {
        assumptions: question(&Side::default(), &new.assumptions)?,
        guarantees: question(&new.guarantees, &old.guarantees)?,
        is_vacuous: lacks_environment(system, large, limits)?,
    })
}

/// Returns whether no run keeps the assumptions of a component of a system.
///
/// # Errors
/// When a limit was reached.
pub fn lacks_environment(
    system: &System,
    component: usize,
    limits: &Limits,
) -> Result<bool, Limit> {
    let component = &system.components[component];
    if component.assumptions == Side::default() {
        return Ok(false);
    }
    let alone = System {
        variables: system.variables.clone(),
        components: vec![Component {
            assumptions: Side::default(),
            guarantees: Side::default(),
            ..component.clone()
        }],
    };
    let no_run = Formula {
        defines: false,
        name: "no run".to_owned(),
        requirement: None,
        expr: Expr::Const(0),
        span: Span::default(),
        text: "false".to_owned(),
    };
    let claim = Claim {
        given: component.assumptions.clone(),
        goal: Side {
            initial: vec![no_run],
            ..Side::default()
        },
        exports: Exports::Never,
        ..Claim::default()
    };
    Ok(prove(&alone, &claim, limits)?.holds())
}
