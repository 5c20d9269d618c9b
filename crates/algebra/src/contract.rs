//! Contracts as sets of runs, built from the assumptions and guarantees of a system's parts.
//!
//! | operation | guarantee (saturated) | assumption |
//! |---|---|---|
//! | a part | Ĝ = ¬A ∨ G | A |
//! | composition C₁ ⊗ C₂ | Ĝ₁ ∧ Ĝ₂ | (A₁ ∧ A₂) ∨ ¬(Ĝ₁ ∧ Ĝ₂) |
//! | conjunction C₁ ∧ C₂ | Ĝ₁ ∧ Ĝ₂ | A₁ ∨ A₂ |
//! | quotient C / C₁ | (Ĝ ∧ A₁) ∨ ¬(A ∧ Ĝ₁) | A ∧ Ĝ₁ |
//! | merging C₁ • C₂ | (Ĝ₁ ∧ Ĝ₂) ∨ ¬(A₁ ∧ A₂) | A₁ ∧ A₂ |

use super::system::ContractSide;

/// A set of runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Words {
    /// The runs that keep one half of a part.
    Side(usize, ContractSide),
    /// Runs that are not in the set.
    Not(Box<Words>),
    /// Intersection.
    All(Vec<Words>),
    /// Union.
    Any(Vec<Words>),
}

impl Words {
    /// Returns the complement.
    #[must_use]
    #[expect(clippy::should_implement_trait, reason = "the logic's own word")]
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
    /// Environments the contract is made for.
    pub assumption: Words,
    /// Behaviour allowed to an implementation.
    pub guarantee: Words,
}

impl Contract {
    /// Returns the contract of a single part.
    pub fn part(index: usize) -> Self {
        let assumption = Words::Side(index, ContractSide::Assumptions);
        Self {
            guarantee: assumption
                .clone()
                .not()
                .or(Words::Side(index, ContractSide::Guarantees)),
            assumption,
        }
    }

    /// Returns the composition C₁ ⊗ C₂: both side by side.
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

    /// Returns the conjunction C₁ ∧ C₂ of two viewpoints of one component: the greatest lower
    /// bound.
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

    /// Returns the merging C₁ • C₂: two requirements that hold at once, under both assumptions.
    #[must_use]
    pub fn merge(&self, other: &Self) -> Self {
        let assumption = self.assumption.clone().and(other.assumption.clone());
        Self {
            guarantee: self.both(other).or(assumption.clone().not()),
            assumption,
        }
    }

    fn both(&self, other: &Self) -> Words {
        self.guarantee.clone().and(other.guarantee.clone())
    }
}
