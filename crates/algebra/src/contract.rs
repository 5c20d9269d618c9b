//! Contracts as sets of runs, made of the halves of a system's parts.
//!
//! | operation | guarantee (saturated) | assumption |
//! |---|---|---|
//! | a part | Ĝ = ¬A ∨ G | A |
//! | composition C₁ ⊗ C₂ | Ĝ₁ ∧ Ĝ₂ | (A₁ ∧ A₂) ∨ ¬(Ĝ₁ ∧ Ĝ₂) |
//! | conjunction C₁ ∧ C₂ | Ĝ₁ ∧ Ĝ₂ | A₁ ∨ A₂ |
//! | quotient C / C₁ | (Ĝ ∧ A₁) ∨ ¬(A ∧ Ĝ₁) | A ∧ Ĝ₁ |
//! | merging C₁ • C₂ | (Ĝ₁ ∧ Ĝ₂) ∨ ¬(A₁ ∧ A₂) | A₁ ∧ A₂ |

use super::system::Half;

/// A set of runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Words {
    /// The runs that keep one half of a part.
    Side(usize, Half),
    /// Those that are not in it.
    Not(Box<Words>),
    /// Those that are in all of them.
    All(Vec<Words>),
    /// Those that are in one of them.
    Any(Vec<Words>),
}

impl Words {
    /// The complement.
    #[must_use]
    #[expect(clippy::should_implement_trait, reason = "the logic's own word")]
    pub fn not(self) -> Self {
        match self {
            Self::Not(inner) => *inner,
            other => Self::Not(Box::new(other)),
        }
    }

    /// What both have.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self::All(vec![self, other])
    }

    /// What one of them has.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self::Any(vec![self, other])
    }
}

/// A contract: what is assumed, and what is guaranteed; saturated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contract {
    /// The environments it is made for.
    pub assumption: Words,
    /// What an implementation may do.
    pub guarantee: Words,
}

impl Contract {
    /// A part by itself.
    pub fn part(index: usize) -> Self {
        let assumption = Words::Side(index, Half::Assumptions);
        Self {
            guarantee: assumption
                .clone()
                .not()
                .or(Words::Side(index, Half::Guarantees)),
            assumption,
        }
    }

    /// Both side by side: C₁ ⊗ C₂.
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

    /// Two viewpoints of one component: C₁ ∧ C₂, the greatest lower bound.
    #[must_use]
    pub fn conjoin(&self, other: &Self) -> Self {
        Self {
            assumption: self.assumption.clone().or(other.assumption.clone()),
            guarantee: self.both(other),
        }
    }

    /// What has to be added to `existing` so that both together keep this one: C / C₁, the weakest
    /// such contract.
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

    /// Two requirements that hold at once, under both assumptions: C₁ • C₂.
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
