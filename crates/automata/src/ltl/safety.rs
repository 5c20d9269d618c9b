//! A safety formula as a deterministic automaton that refuses its bad prefixes.

use super::formula::{Formulas, Node};
use super::progression::{Progression, Reading};
use crate::bound::BoundExceeded;
use crate::dfa::Dfa;

/// Limits on the size of an automaton.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of states before minimization.
    pub states: usize,
    /// Maximum number of alternatives in a state.
    pub alternatives: usize,
}

/// Returns the minimal automaton of a formula without `until`. Its letters are these choices of
/// atoms, as bits. It refuses a step after which no continuation keeps the formula.
///
/// # Errors
/// When it is larger than the limits.
pub fn safety(
    formulas: &Formulas,
    formula: Node,
    letters: &[u32],
    limits: Limits,
) -> Result<Dfa, BoundExceeded> {
    // Each step asks what can still be kept in some way, so states are terms.
    let mut progression = Progression::new(formulas, Reading::Terms, limits.alternatives);
    let start = progression.ahead(formula)?;
    let step = |state: &_, letter: usize| {
        let left = progression.all_after(state, letters[letter])?;
        Ok((!left.is_empty()).then_some(left))
    };
    let dfa = Dfa::try_explore(letters.len(), start, limits.states, step, |_| true)?;
    Ok(dfa.minimal())
}
