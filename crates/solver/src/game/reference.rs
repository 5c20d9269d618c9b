//! References to the formulas of a specification, by side and list.

use linewright_core::gr1::{Formula, FormulaKind, Side};
use serde::{Deserialize, Serialize};

/// A reference to a guarantee of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct GuaranteeRef {
    /// Kind of the formula. It selects one of the lists of [`Side`].
    pub kind: FormulaKind,
    /// Index of the formula in that list.
    pub index: usize,
}

/// A reference to an assumption of a specification. It has the same form as a reference to a
/// guarantee.
pub type AssumptionRef = GuaranteeRef;

impl GuaranteeRef {
    /// Returns the referenced formula of this side.
    pub fn formula(self, side: &Side) -> &Formula {
        &side.list(self.kind)[self.index]
    }
}

/// Returns the guarantees that only define monitors, and the other guarantees.
pub fn split_definitions(guarantees: &Side) -> (Vec<GuaranteeRef>, Vec<GuaranteeRef>) {
    let (definitions, demands): (Vec<_>, Vec<_>) = all(guarantees).partition(|(_, f)| f.defines);
    let refs = |list: Vec<(GuaranteeRef, &Formula)>| list.into_iter().map(|(at, _)| at).collect();
    (refs(definitions), refs(demands))
}

/// Returns all formulas of a side with their references.
pub fn all(side: &Side) -> impl Iterator<Item = (GuaranteeRef, &Formula)> {
    let formulas = side.formulas();
    formulas.map(|(kind, index, formula)| (GuaranteeRef { kind, index }, formula))
}
