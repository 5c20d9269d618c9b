//! Refinement, with its reasons: which assumption of the new contract follows from which of the old
//! one, and which guarantee of the old contract is kept by which of the new one.
//!
//! `C₁ ≼ C₂` when `A₂ ⊆ A₁` and `A₂ ∧ G₁ ⊆ G₂`: the old environments are sufficient for the new
//! contract, and under them it keeps the old guarantees. Decided exactly on infinite runs.

use super::proof::{Claim, Exports, Proof, prove};
use super::system::{Part, System};
use linewright_core::gr1::{Expr, Formula, Side};
use linewright_core::source::Span;
use linewright_solver::game::{Limit, Limits};

/// Result of the check. In both proofs the environment is that of the refined contract.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refinement {
    /// The refining contract's assumptions are the goal; the environment alone has to meet them.
    pub assumptions: Question,
    /// The refined contract's guarantees are the goal.
    pub guarantees: Question,
    /// Whether no run keeps the refined contract's assumptions: then every contract refines it.
    pub is_vacuous: bool,
}

/// A proof together with its system and claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// System of the proof.
    pub system: System,
    /// Claim of the proof.
    pub claim: Claim,
    /// Result.
    pub proof: Proof,
}

impl Refinement {
    /// Returns whether the refinement holds.
    pub fn holds(&self) -> bool {
        self.assumptions.proof.holds() && self.guarantees.proof.holds()
    }
}

/// Decides whether one part of a system refines another.
///
/// # Errors
/// When a limit was reached.
pub fn refine(
    system: &System,
    small: usize,
    large: usize,
    limits: &Limits,
) -> Result<Refinement, Limit> {
    let (new, old) = (&system.parts[small], &system.parts[large]);
    // Both keep their monitors, independent of the promises.
    let views = |promised: &Side| {
        let view = |part: &Part, guarantees: &Side| Part {
            assumptions: Side::default(),
            guarantees: guarantees.clone(),
            ..part.clone()
        };
        vec![view(new, promised), view(old, &Side::default())]
    };
    let question = |promised: &Side, goal: &Side| -> Result<Question, Limit> {
        let system = System {
            variables: system.variables.clone(),
            parts: views(promised),
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
