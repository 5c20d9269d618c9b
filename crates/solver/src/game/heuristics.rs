//! Switchable heuristics of the solver.
//!
//! No heuristic changes a verdict; the tests disable each in turn. The ablation table in
//! `tests/bench/README.md` shows their effect.

use std::fmt;
use std::str::FromStr;

/// A heuristic of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Heuristic {
    /// Start from an order that places variables that occur together near each other, instead of
    /// the declaration order.
    Structure,
    /// Sift once before the fixpoint.
    Sifting,
    /// Sift again at safe points when the functions have grown.
    Resifting,
    /// Combine the conjuncts of a relation up to a size, instead of keeping them separate.
    Clusters,
    /// Quantify a bit as soon as no later cluster mentions it.
    EarlyQuantification,
    /// Conjoin and quantify in one operation.
    Fusion,
    /// Compute the predecessors of states, not of transitions, if no justice formula mentions next
    /// values.
    StatePredecessors,
    /// Start with the states from which the machine can keep its safety for ever.
    SafetyFirst,
    /// Start each goal from the region left by the previous one, instead of intersecting the
    /// results of all goals after each round.
    Carrying,
    /// Process goals with the fewest bits first. They shrink the region most often, and when it
    /// shrinks late in a round, all earlier goals need another round.
    GoalOrder,
    /// Start every inner greatest fixpoint at the region, instead of at all states.
    InnerStart,
    /// Start every inner greatest fixpoint at the result of the same fixpoint in the previous
    /// round.
    Recycling,
    /// Cache the last controllable predecessors.
    PredecessorCache,
    /// Stop as soon as the machine loses from some initial choice of the environment.
    EarlyStop,
}

impl Heuristic {
    /// All heuristics with their `--without` names.
    pub const ALL: [(Self, &'static str); 14] = [
        (Self::Structure, "structure"),
        (Self::Sifting, "sifting"),
        (Self::Resifting, "resifting"),
        (Self::Clusters, "clusters"),
        (Self::EarlyQuantification, "early-quantification"),
        (Self::Fusion, "fusion"),
        (Self::StatePredecessors, "state-predecessors"),
        (Self::SafetyFirst, "safety-first"),
        (Self::Carrying, "carrying"),
        (Self::GoalOrder, "goal-order"),
        (Self::InnerStart, "inner-start"),
        (Self::Recycling, "recycling"),
        (Self::PredecessorCache, "predecessor-cache"),
        (Self::EarlyStop, "early-stop"),
    ];
}

impl fmt::Display for Heuristic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(h, _)| h == self);
        f.write_str(name.map_or("", |(_, name)| name))
    }
}

impl FromStr for Heuristic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|(_, name)| *name == text);
        known.map(|(h, _)| *h).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|(_, name)| *name).collect();
            format!(
                "unknown heuristic `{text}`: choose one of {}",
                names.join(", ")
            )
        })
    }
}

/// The set of enabled heuristics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heuristics(u16);

impl Default for Heuristics {
    /// Returns all heuristics, because each of them helps overall; see the ablation table in
    /// `tests/bench/README.md`.
    fn default() -> Self {
        Self::all()
    }
}

impl Heuristics {
    /// Returns the set of all heuristics.
    pub fn all() -> Self {
        Self((1 << Heuristic::ALL.len()) - 1)
    }

    /// Returns the empty set.
    pub fn none() -> Self {
        Self(0)
    }

    /// Returns the set without a heuristic.
    #[must_use]
    pub fn without(self, heuristic: Heuristic) -> Self {
        Self(self.0 & !(1 << heuristic as u16))
    }

    /// Returns the set with a heuristic.
    #[must_use]
    pub fn with(self, heuristic: Heuristic) -> Self {
        Self(self.0 | 1 << heuristic as u16)
    }

    /// Whether a heuristic is enabled.
    pub fn has(self, heuristic: Heuristic) -> bool {
        self.0 >> heuristic as u16 & 1 == 1
    }
}
