//! Conversion of a formula to a deterministic Büchi automaton.
//!
//! A state is a conjunction of disjunctions of temporal formulas. A disjunction that contains a
//! `weak` or a `release` can remain for ever. Any other disjunction is a *debt*, which has to
//! disappear eventually. The automaton works in rounds: it watches the debts that exist at the
//! beginning of a round until all of them have disappeared; then the state is accepting and the
//! next round begins (the break-point construction of Miyano and Hayashi, "Alternating finite
//! automata on ω-words", 1984).
//!
//! This is correct for formulas in which no `until` contains a `weak` or a `release`.

use super::formula::{Formulas, Node};
use super::progression::{Condition, Progression, Reading};
use crate::bound::BoundExceeded;
use crate::symbolic::{Automaton, Values};

/// Remaining condition, watched debts, and whether the last step ended a round.
type Round = (Condition, Condition, bool);

/// Returns the minimal automaton of a formula over the atoms `0..atoms`. It accepts a run that
/// visits accepting states infinitely often.
///
/// # Errors
/// When the automaton exceeds the limits of [`Automaton::explore`].
pub fn buchi(formulas: &Formulas, formula: Node, atoms: usize) -> Result<Automaton, BoundExceeded> {
    let mut progression = Progression::new(formulas, Reading::Clauses, usize::MAX);
    let falsum = progression.constant(false);
    let start: Round = (progression.as_condition(formula)?, Condition::none(), false);
    let atoms: Vec<usize> = (0..atoms).collect();
    let step = |(left, watched, _): &Round, values: &Values| {
        let holding = values.iter().filter(|(_, holds)| **holds);
        let letter = holding.fold(0, |letter, (atom, _)| letter | 1 << atom);
        let left = progression.progress_condition(left, letter)?;
        let mut watched = progression.progress_condition(watched, letter)?;
        let round_ends = watched.is_empty() && left != falsum;
        if round_ends {
            watched =
                left.filter(|clause| !clause.iter().any(|node| formulas.can_hold_forever(*node)));
        }
        Ok((left, watched, round_ends))
    };
    let is_accepting = |(_, _, round_ended): &Round| *round_ended;
    let found = Automaton::explore(start, |_| atoms.clone(), step, is_accepting)?;
    Ok(found.minimal())
}

#[cfg(test)]
mod tests {
    use super::super::formula::Formula;
    use super::super::safety::{Limits, safety};
    use super::*;
    use crate::symbolic::Decision;
    use std::collections::BTreeSet;

    /// Returns the state after a step in which these atoms hold, as bits.
    fn after(automaton: &Automaton, state: usize, letter: u32) -> usize {
        let mut decision = &automaton.steps[state];
        loop {
            match decision {
                Decision::To(next) => return *next,
                Decision::If(atom, yes, _) if letter >> atom & 1 == 1 => decision = yes,
                Decision::If(_, _, no) => decision = no,
            }
        }
    }

    /// `G (p -> F q)`: accepting states recur for ever, unless the last `p` is never answered.
    #[test]
    fn a_debt_has_to_disappear() {
        const P: u32 = 1;
        const Q: u32 = 2;
        let mut formulas = Formulas::default();
        let [p, q] = [0, 1].map(|atom| formulas.node(Formula::Atom(atom, true)));
        let answered = formulas.eventually(q);
        let response = formulas.implies(p, answered);
        let response = formulas.always(response);
        let automaton = buchi(&formulas, response, 2).expect("it is small");
        let rounds: [(&[u32], &[u32], bool); 5] = [
            (&[], &[0], true),
            (&[P], &[0], false),
            (&[P, 0, Q], &[0], true),
            (&[], &[P, 0, Q], true),
            (&[Q], &[P], false),
        ];
        for (beginning, round, wanted) in rounds {
            let mut state = 0;
            let run = round.iter().cycle().take(round.len() * 20);
            let mut last = Vec::new();
            for letter in beginning.iter().chain(run) {
                state = after(&automaton, state, *letter);
                last.push(automaton.accepting[state]);
            }
            // The second half of the run has more steps than the automaton has states, so the
            // states that it visits recur for ever.
            let half = &last[last.len() / 2..];
            assert_eq!(half.contains(&true), wanted, "{beginning:?} {round:?}");
        }
    }

    /// The Büchi automaton of a safety formula is no longer accepting exactly when the safety
    /// automaton has refused a step.
    #[test]
    fn both_automata_of_a_safety_formula_agree() {
        let mut formulas = Formulas::default();
        let [p, q] = [0, 1].map(|atom| formulas.node(Formula::Atom(atom, true)));
        let later = formulas.node(Formula::Next(q));
        let weak = formulas.node(Formula::Weak(later, p));
        let release = formulas.node(Formula::Release(q, p));
        let either = formulas.node(Formula::Or(vec![weak, release]));
        let always = formulas.always(either);
        let letters: Vec<u32> = (0..4).collect();
        let limits = Limits {
            states: 100,
            alternatives: 100,
        };
        for formula in [weak, release, either, always] {
            let words = safety(&formulas, formula, &letters, limits).expect("it is small");
            let runs = buchi(&formulas, formula, 2).expect("it is small");
            // Run both automata together: after a refused step, no state is accepting.
            let mut open = vec![(Some(0), 0)];
            let mut seen = BTreeSet::new();
            while let Some((word, run)) = open.pop() {
                if !seen.insert((word, run)) {
                    continue;
                }
                assert!(run == 0 || runs.accepting[run] == word.is_some());
                for letter in letters.iter().copied() {
                    let next_word = word.and_then(|w| words.step(w, letter as usize));
                    open.push((next_word, after(&runs, run, letter)));
                }
            }
        }
    }
}
