//! A *letter* is a valuation of the variables that guards test. It is chosen variable by variable,
//! and comes with the transitions whose guards it can still satisfy.

use crate::mealy::{Cube, Transition};
use linewright_core::gr1::{Specification, VarId};

/// A valuation of the next step. Of the variables that guards test, the first few have chosen
/// values. All other variables have the smallest value of their domains.
#[derive(Debug)]
pub(super) struct Letter<'a> {
    transitions: &'a [Transition],
    /// For each number of chosen variables, the cubes that the letter can still satisfy, each with
    /// the index of its transition.
    candidates: Vec<Vec<(usize, &'a Cube)>>,
    /// The valuation.
    pub(super) next: Vec<i64>,
}

/// The transitions whose guards a letter satisfies.
#[derive(Debug, Clone, Copy)]
pub(super) enum TransitionMatch<'a> {
    /// Exactly this one.
    One(&'a Transition),
    /// None.
    Nothing,
    /// Several transitions, or one transition by several of its cubes.
    Several,
}

impl<'a> Letter<'a> {
    /// Creates a letter with no variable chosen.
    pub(super) fn new(
        specification: &Specification,
        transitions: &'a [Transition],
        variables: usize,
    ) -> Self {
        let cubes = transitions.iter().enumerate().flat_map(|(t, transition)| {
            let cubes = transition.guard.0.iter();
            cubes.map(move |cube| (t, cube))
        });
        let mut candidates = vec![Vec::new(); variables + 1];
        candidates[0] = cubes.collect();
        let low = specification.variables.iter().map(|v| v.domain.low());
        Self {
            transitions,
            candidates,
            next: low.collect(),
        }
    }

    /// Chooses the value of `variable`, after the values of the first `chosen` variables.
    pub(super) fn choose(&mut self, chosen: usize, variable: VarId, value: i64) {
        self.next[variable.index()] = value;
        let (before, after) = self.candidates.split_at_mut(chosen + 1);
        after[0].clear();
        after[0].extend(before[chosen].iter().filter(|(_, cube)| {
            let mut tests = cube.0.iter().filter(|t| t.input == chosen);
            tests.all(|t| t.low <= value && value <= t.high)
        }));
    }

    /// Returns the cubes that the letter can still satisfy after the choice of the first `chosen`
    /// variables, each with the index of its transition.
    pub(super) fn candidates(&self, chosen: usize) -> &[(usize, &'a Cube)] {
        &self.candidates[chosen]
    }

    /// Returns the transition of the letter; all variables must be chosen.
    pub(super) fn taken(&self) -> TransitionMatch<'a> {
        match self.candidates.last().map(Vec::as_slice) {
            Some([(t, _)]) => TransitionMatch::One(&self.transitions[*t]),
            Some([_, _, ..]) => TransitionMatch::Several,
            _ => TransitionMatch::Nothing,
        }
    }
}
