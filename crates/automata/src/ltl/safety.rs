//! A safety formula as a deterministic automaton that refuses its bad prefixes.

use super::formula::{Formulas, Node};
use super::progression::{Progression, Reading};
use crate::bound::TooLarge;
use crate::dfa::Dfa;

/// How large an automaton may become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// So many states before it is made minimal.
    pub states: usize,
    /// So many alternatives in a state.
    pub alternatives: usize,
}

/// The smallest automaton of a formula without `until`. Its letters are these choices of atoms, as
/// bits; it refuses the steps that break the formula, whatever comes.
///
/// # Errors
/// When it is larger than the limits.
pub fn safety(
    formulas: &Formulas,
    formula: Node,
    letters: &[u32],
    limits: Limits,
) -> Result<Dfa, TooLarge> {
    // What can still be kept in some way is what is asked at every step, so states are terms.
    let mut progression = Progression::new(formulas, Reading::Terms, limits.alternatives);
    let start = progression.ahead(formula)?;
    let step = |state: &_, letter: usize| {
        let left = progression.all_after(state, letters[letter])?;
        Ok((!left.is_empty()).then_some(left))
    };
    let dfa = Dfa::try_explore(letters.len(), start, limits.states, step, |_| true)?;
    Ok(dfa.minimal())
}
