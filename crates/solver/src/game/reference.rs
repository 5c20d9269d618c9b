//! References to the formulas of a specification, by side and list.

use linewright_core::gr1::{Formula, Side};
use serde::{Deserialize, Serialize};

/// A reference to a guarantee of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct GuaranteeRef {
    /// Kind of formula, that is, its list.
    pub kind: GuaranteeKind,
    /// Index in that list.
    pub index: usize,
}

/// A reference to an assumption of a specification.
pub type AssumptionRef = GuaranteeRef;

/// The lists of [`Side`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum GuaranteeKind {
    /// [`Side::initial`]
    Initial,
    /// [`Side::invariants`]
    Invariant,
    /// [`Side::safety`]
    Safety,
    /// [`Side::justice`]
    Justice,
}

impl GuaranteeRef {
    /// Returns the referenced formula.
    pub fn formula(self, guarantees: &Side) -> &Formula {
        match self.kind {
            GuaranteeKind::Initial => &guarantees.initial[self.index],
            GuaranteeKind::Invariant => &guarantees.invariants[self.index],
            GuaranteeKind::Safety => &guarantees.safety[self.index],
            GuaranteeKind::Justice => &guarantees.justice[self.index],
        }
    }
}

/// Separates guarantees that only define monitors from those that demand something.
pub fn definitions(guarantees: &Side) -> (Vec<GuaranteeRef>, Vec<GuaranteeRef>) {
    let (definitions, asked): (Vec<_>, Vec<_>) = all(guarantees).partition(|(_, f)| f.defines);
    let refs = |list: Vec<(GuaranteeRef, &Formula)>| list.into_iter().map(|(at, _)| at).collect();
    (refs(definitions), refs(asked))
}

/// All formulas of a side with their references.
pub fn all(side: &Side) -> impl Iterator<Item = (GuaranteeRef, &Formula)> {
    let lists = [
        (GuaranteeKind::Initial, &side.initial),
        (GuaranteeKind::Invariant, &side.invariants),
        (GuaranteeKind::Safety, &side.safety),
        (GuaranteeKind::Justice, &side.justice),
    ];
    lists.into_iter().flat_map(|(kind, list)| {
        let list = list.iter().enumerate();
        list.map(move |(index, formula)| (GuaranteeRef { kind, index }, formula))
    })
}
