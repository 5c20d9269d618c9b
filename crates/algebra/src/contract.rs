//! Contracts as pairs of sets of runs, built from the assumptions and guarantees of a system's
//! components.
//!
//! | operation | guarantee (saturated) | assumption |
//! |---|---|---|
//! | a component | Ĝ = ¬A ∨ G | A |
//! | composition C₁ ⊗ C₂ | Ĝ₁ ∧ Ĝ₂ | (A₁ ∧ A₂) ∨ ¬(Ĝ₁ ∧ Ĝ₂) |
//! | conjunction C₁ ∧ C₂ | Ĝ₁ ∧ Ĝ₂ | A₁ ∨ A₂ |
//! | quotient C / C₁ | (Ĝ ∧ A₁) ∨ ¬(A ∧ Ĝ₁) | A ∧ Ĝ₁ |
//! | merging C₁ • C₂ | (Ĝ₁ ∧ Ĝ₂) ∨ ¬(A₁ ∧ A₂) | A₁ ∧ A₂ |

use super::system::ContractSide;

/// A set of infinite runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunSet {
    /// Runs that keep the assumptions, or the guarantees, of the component with this index.
    Side(usize, ContractSide),
    /// Runs that are not in the set.
    Not(Box<RunSet>),
    /// Intersection.
    All(Vec<RunSet>),
    /// Union.
    Any(Vec<RunSet>),
}

impl RunSet {
    /// Returns the complement.
    #[must_use]
    #[expect(
        clippy::should_implement_trait,
        reason = "`not` is the usual name in logic"
    )]
    pub fn not(self) -> Self {
        match self {
            Self::Not(inner) => *inner,
            other => Self::Not(Box::new(other)),
        }
    }

    /// Returns the intersection.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::All(vec![self, other])
    }

    /// Returns the union.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::Any(vec![self, other])
    }
}

/// A saturated contract: assumption and guarantee.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contract {
    /// Runs that the contract allows the environment to make.
    pub assumption: RunSet,
    /// Runs that the contract allows an implementation to make.
    pub guarantee: RunSet,
}

impl Contract {
    /// Returns the saturated contract of the component with this index.
    pub fn component(index: usize) -> Self {
        let assumption = RunSet::Side(index, ContractSide::Assumptions);
        Self {
            guarantee: assumption
                .clone()
                .not()
                .or(RunSet::Side(index, ContractSide::Guarantees)),
            assumption,
        }
    }

    /// Returns the composition C₁ ⊗ C₂ of two components side by side.
    #[must_use]
    pub fn compose(&self, other: &Self) -> Self {
        let both = self.both(other);
        Self {
            assumption: self
                .assumption
                .clone()
                .and(other.assumption.clone())
                .or(both.clone().not()),
            guarantee: both,
        }
    }

    /// Returns the conjunction C₁ ∧ C₂ of two views of one component: the greatest lower bound in
    /// the refinement order.
    #[must_use]
    pub fn conjoin(&self, other: &Self) -> Self {
        Self {
            assumption: self.assumption.clone().or(other.assumption.clone()),
            guarantee: self.both(other),
        }
    }

    /// Returns the quotient C / C₁: the weakest contract that, together with `existing`, keeps this
    /// one.
    #[must_use]
    pub fn quotient(&self, existing: &Self) -> Self {
        let assumption = self.assumption.clone().and(existing.guarantee.clone());
        Self {
            guarantee: self
                .guarantee
                .clone()
                .and(existing.assumption.clone())
                .or(assumption.clone().not()),
            assumption,
        }
    }

    /// Returns the merging C₁ • C₂ of two requirements that hold at the same time, under both
    /// assumptions.
    #[must_use]
    pub fn merge(&self, other: &Self) -> Self {
        let assumption = self.assumption.clone().and(other.assumption.clone());
        Self {
            guarantee: self.both(other).or(assumption.clone().not()),
            assumption,
        }
    }

    fn both(&self, other: &Self) -> RunSet {
        self.guarantee.clone().and(other.guarantee.clone())
    }
}
