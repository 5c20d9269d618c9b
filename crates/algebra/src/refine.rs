//! Refinement between two contracts, with reasons: from which old assumptions each new assumption
//! follows, and from which new guarantees each old guarantee follows.
//!
//! `C₁ ≼ C₂` holds if `A₂ ⊆ A₁` and `A₂ ∧ G₁ ⊆ G₂`: every environment of the old contract is one of
//! the new contract, and in it the new contract keeps the old guarantees. This is decided exactly
//! on infinite runs.

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
    let never = Side {
        initial: vec![Formula {
            defines: false,
            name: "no run".to_owned(),
            requirement: None,
            expr: Expr::Const(0),
            span: Span::default(),
            text: "false".to_owned(),
        }],
        ..Side::default()
    };
    Ok(Refinement {
        assumptions: question(&Side::default(), &new.assumptions)?,
        guarantees: question(&new.guarantees, &old.guarantees)?,
        is_vacuous: old.assumptions != Side::default()
            && question(&Side::default(), &never)?.proof.holds(),
    })
}
