//! A formula as a deterministic Büchi automaton.
//!
//! A state is a conjunction of disjunctions of temporal formulas. A disjunction that contains a
//! `weak` or a `release` can be kept for ever; one without, a *debt*, has to be paid eventually.
//! Debts are paid in rounds: the debts at the beginning of a round are watched until none is left,
//! which is accepting (the break-point construction of Miyano and Hayashi, "Alternating finite
//! automata on ω-words", 1984).
//!
//! This is correct for formulas in which no `until` contains a `weak` or a `release`.

use super::formula::{Formulas, Node};
use super::progression::{Condition, Progression, Reading};
use crate::bound::BoundExceeded;
use crate::symbolic::{Automaton, Values};

/// Remaining condition, watched debts, and whether a round has just ended.
type Round = (Condition, Condition, bool);

/// Returns the minimal automaton of a formula over the atoms 0 to `atoms - 1`.
///
/// # Errors
/// When it is too large for [`Automaton::explore`].
pub fn buchi(formulas: &Formulas, formula: Node, atoms: usize) -> Result<Automaton, BoundExceeded> {
    let mut progression = Progression::new(formulas, Reading::Clauses, usize::MAX);
    let lost = progression.constant(false);
    let start: Round = (progression.ahead(formula)?, Condition::none(), false);
    let atoms: Vec<usize> = (0..atoms).collect();
    let step = |(left, watched, _): &Round, values: &Values| {
        let holding = values.iter().filter(|(_, holds)| **holds);
        let letter = holding.fold(0, |letter, (atom, _)| letter | 1 << atom);
        let left = progression.all_after(left, letter)?;
        let mut watched = progression.all_after(watched, letter)?;
        let paid = watched.is_empty() && left != lost;
        if paid {
            watched = left.filter(|clause| !clause.iter().any(|node| formulas.goes_on(*node)));
        }
        Ok((left, watched, paid))
    };
    let found = Automaton::explore(start, |_| atoms.clone(), step, |(_, _, paid)| *paid)?;
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
    fn a_debt_has_to_be_paid() {
        const P: u32 = 1;
        const Q: u32 = 2;
        let mut formulas = Formulas::default();
        let [p, q] = [0, 1].map(|atom| formulas.node(Formula::Atom(atom, true)));
        let some_day = formulas.eventually(q);
        let response = formulas.implies(p, some_day);
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
            // There are fewer states than steps in the second half, so the states seen there recur
            // for ever.
            let half = &last[last.len() / 2..];
            assert_eq!(half.contains(&true), wanted, "{beginning:?} {round:?}");
        }
    }

    /// A formula that a finite run can break is lost in the same states of both automata.
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
            // Step both together: a refused run is never accepting again.
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
