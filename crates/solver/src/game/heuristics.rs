//! What makes the solver fast, each part with a switch.
//!
//! No heuristic changes a verdict; the tests turn each of them off in turn. What each is worth
//! stands in the ablation table of `tests/bench/README.md`.

use std::fmt;
use std::str::FromStr;

/// One of the things that make the solver fast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Heuristic {
    /// Start from an order in which variables that occur together are near each other, instead of
    /// the declaration's.
    Structure,
    /// Sift once before the fixpoint.
    Sifting,
    /// Sift again at safe points when the functions have grown.
    Resifting,
    /// Put the conjuncts of a relation together up to a size, instead of keeping them apart.
    Clusters,
    /// Quantify a bit as soon as no later cluster mentions it.
    EarlyQuantification,
    /// Conjoin and quantify in one operation.
    Fusion,
    /// Compute the predecessors of states, not of transitions, where no justice formula speaks of
    /// next values.
    StatePredecessors,
    /// Begin with the states from which the machine can keep its safety for ever.
    SafetyFirst,
    /// Feed the region that one goal leaves to the next goal, instead of intersecting a round of
    /// all goals.
    Carrying,
    /// Take the goals of the fewest bits first: they shrink the region most often, and whatever
    /// shrinks it late sends all the goals before through another round.
    GoalOrder,
    /// Begin every inner greatest fixpoint at the region, instead of at all states.
    InnerStart,
    /// Begin every inner greatest fixpoint where the one of the previous round ended.
    Recycling,
    /// Remember the last controllable predecessors.
    PredecessorCache,
    /// Stop as soon as an initial choice of the environment is lost.
    EarlyStop,
}

impl Heuristic {
    /// All of them, with the name that `--without` takes.
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
                "there is no heuristic `{text}`: give one of {}",
                names.join(", ")
            )
        })
    }
}

/// Which of them are on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heuristics(u16);

impl Default for Heuristics {
    /// All that help on the whole, see the ablation table.
    fn default() -> Self {
        Self::all()
    }
}

impl Heuristics {
    /// All of them.
    pub fn all() -> Self {
        Self((1 << Heuristic::ALL.len()) - 1)
    }

    /// None of them.
    pub fn none() -> Self {
        Self(0)
    }

    /// The same without one.
    #[must_use]
    pub fn without(self, heuristic: Heuristic) -> Self {
        Self(self.0 & !(1 << heuristic as u16))
    }

    /// The same with one.
    #[must_use]
    pub fn with(self, heuristic: Heuristic) -> Self {
        Self(self.0 | 1 << heuristic as u16)
    }

    /// Whether one is on.
    pub fn has(self, heuristic: Heuristic) -> bool {
        self.0 >> heuristic as u16 & 1 == 1
    }
}
