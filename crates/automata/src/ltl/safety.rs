//! Conversion of a safety formula to a deterministic automaton that refuses its bad prefixes.

use super::formula::{Formulas, Node};
use super::progression::{Progression, Reading};
use crate::bound::BoundExceeded;
use crate::dfa::Dfa;

/// Limits on the size of an automaton.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of states before minimization.
    pub states: usize,
    /// Maximum number of alternatives in a state, that is, of terms in its condition.
    pub alternatives: usize,
}

/// Returns the minimal automaton of a formula without `until`. Letter `i` stands for a step in
/// which exactly the atoms in the bits of `letters[i]` hold. It refuses a letter if no continuation
/// after it satisfies the formula.
///
/// # Errors
/// When the automaton exceeds the limits.
pub fn safety(
    formulas: &Formulas,
    formula: Node,
    letters: &[u32],
    limits: Limits,
) -> Result<Dfa, BoundExceeded> {
    // The conditions are terms, because a false condition then has no alternatives, which is easy
    // to check.
    let mut progression = Progression::new(formulas, Reading::Terms, limits.alternatives);
    let start = progression.as_condition(formula)?;
    let step = |state: &_, letter: usize| {
        let left = progression.progress_condition(state, letters[letter])?;
        Ok((!left.is_empty()).then_some(left))
    };
    let dfa = Dfa::try_explore(letters.len(), start, limits.states, step, |_| true)?;
    Ok(dfa.minimal())
}
