//! Deterministic finite automata over the letters `0..letters`. A state can refuse letters; refused
//! letters do not lead to a sink state.
//!
//! This module provides breadth-first exploration of a transition function, minimization by
//! partition refinement (Hopcroft, "An n log n algorithm for minimizing states in a finite
//! automaton", 1971), and comparison of two automata by their product.

use crate::bound::{BoundExceeded, ExplorationBound};
use crate::partition::Partition;
use crate::search::shortest;
use rustc_hash::FxHashMap;
use std::hash::Hash;

/// Number of explored states between two checks of the deadline.
const DEADLINE_CHECK_INTERVAL: usize = 64;

/// Value that takes the place of the next state if a letter is refused.
pub const REFUSED: u32 = u32::MAX;

/// A deterministic automaton. States are numbered in breadth-first order from the start, with
/// letters in ascending order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dfa {
    letters: usize,
    /// Next states in row-major order: one row per state.
    next: Vec<u32>,
    /// Whether a word can end in each state.
    complete: Vec<bool>,
}

/// Result of an exploration.
#[derive(Debug, Clone)]
pub struct Exploration<S> {
    /// Automaton.
    pub dfa: Dfa,
    /// Distinct numbers of the start states, in ascending order.
    pub starts: Vec<u32>,
    /// Explored value of each state.
    pub states: Vec<S>,
}

impl Dfa {
    /// Explores all states that are reachable from `start`, which becomes state 0. `step` returns
    /// the state after a letter, or `None` to refuse the letter; `complete` returns whether a word
    /// can end in a state.
    ///
    /// # Errors
    /// When there are more states than `bound` allows, or the deadline has passed.
    pub fn explore<S: Clone + Eq + Hash>(
        letters: usize,
        start: S,
        bound: impl Into<ExplorationBound>,
        step: impl FnMut(&S, usize) -> Option<S>,
        complete: impl Fn(&S) -> bool,
    ) -> Result<Self, BoundExceeded> {
        Self::explore_all(letters, &[start], bound, step, complete).map(|found| found.dfa)
    }

    /// Like [`explore`](Self::explore), but from several starts. The first one becomes state 0.
    ///
    /// # Errors
    /// When there are more states than `bound` allows, or the deadline has passed.
    pub fn explore_all<S: Clone + Eq + Hash>(
        letters: usize,
        starts: &[S],
        bound: impl Into<ExplorationBound>,
        mut step: impl FnMut(&S, usize) -> Option<S>,
        complete: impl Fn(&S) -> bool,
    ) -> Result<Exploration<S>, BoundExceeded> {
        let step = |state: &S, letter: usize| Ok(step(state, letter));
        Self::explore_within(letters, starts, bound.into(), step, complete)
    }

    /// Like [`explore`](Self::explore), but with a `step` that can itself exceed a limit.
    ///
    /// # Errors
    /// When `step` fails, when there are more states than `bound` allows, or when the deadline has
    /// passed.
    pub fn try_explore<S: Clone + Eq + Hash>(
        letters: usize,
        start: S,
        bound: impl Into<ExplorationBound>,
        step: impl FnMut(&S, usize) -> Result<Option<S>, BoundExceeded>,
        complete: impl Fn(&S) -> bool,
    ) -> Result<Self, BoundExceeded> {
        let found = Self::explore_within(letters, &[start], bound.into(), step, complete)?;
        Ok(found.dfa)
    }

    fn explore_within<S: Clone + Eq + Hash>(
        letters: usize,
        starts: &[S],
        bound: ExplorationBound,
        mut step: impl FnMut(&S, usize) -> Result<Option<S>, BoundExceeded>,
        complete: impl Fn(&S) -> bool,
    ) -> Result<Exploration<S>, BoundExceeded> {
        let ExplorationBound {
            max_states: limit,
            deadline,
        } = bound;
        let mut numbers: FxHashMap<S, u32> = FxHashMap::default();
        let mut states: Vec<S> = Vec::new();
        let mut number = |state: S, states: &mut Vec<S>| match numbers.get(&state) {
            Some(number) => Ok(*number),
            None if states.len() == limit => Err(BoundExceeded::Count {
                what: "states",
                limit,
            }),
            None => {
                let number = states.len() as u32;
                states.push(state.clone());
                numbers.insert(state, number);
                Ok(number)
            }
        };
        let mut start_numbers = Vec::new();
        for start in starts {
            start_numbers.push(number(start.clone(), &mut states)?);
        }
        start_numbers.sort_unstable();
        start_numbers.dedup();
        let mut next = Vec::new();
        let mut at = 0;
        while at < states.len() {
            if at.is_multiple_of(DEADLINE_CHECK_INTERVAL) {
                deadline.check()?;
            }
            for letter in 0..letters {
                next.push(match step(&states[at], letter)? {
                    Some(to) => number(to, &mut states)?,
                    None => REFUSED,
                });
            }
            at += 1;
        }
        let dfa = Self {
            letters,
            next,
            complete: states.iter().map(complete).collect(),
        };
        Ok(Exploration {
            dfa,
            starts: start_numbers,
            states,
        })
    }

    /// Returns the number of letters.
    pub fn letter_count(&self) -> usize {
        self.letters
    }

    /// Returns the number of states; at least 1.
    pub fn state_count(&self) -> usize {
        self.complete.len()
    }

    /// Returns the state after a letter, or [`REFUSED`].
    pub fn next(&self, state: u32, letter: usize) -> u32 {
        self.next[state as usize * self.letters + letter]
    }

    /// Returns the state after a letter, or `None` if the letter is refused.
    pub fn step(&self, state: u32, letter: usize) -> Option<u32> {
        let to = self.next(state, letter);
        (to != REFUSED).then_some(to)
    }

    /// Returns whether a word can end in this state.
    pub fn is_complete(&self, state: u32) -> bool {
        self.complete[state as usize]
    }

    /// Returns the state after a word, or `None` if one of its letters is refused.
    pub fn run(&self, word: &[usize]) -> Option<u32> {
        word.iter()
            .try_fold(0, |state, letter| self.step(state, *letter))
    }

    /// Returns whether a letter changes no state and is never refused.
    pub fn is_idle(&self, letter: usize) -> bool {
        (0..self.state_count() as u32).all(|state| self.next(state, letter) == state)
    }

    /// Replaces the set of states in which a word can end; `complete` has one value per state.
    ///
    /// # Panics
    /// When the number of values differs from the number of states.
    #[must_use]
    pub fn with_complete(mut self, complete: Vec<bool>) -> Self {
        assert_eq!(complete.len(), self.complete.len(), "one value per state");
        self.complete = complete;
        self
    }

    /// Removes the letter with the highest number. Also returns, for every state, the state after
    /// that letter, or [`REFUSED`].
    ///
    /// # Panics
    /// When there are no letters.
    #[must_use]
    pub fn without_last_letter(self) -> (Self, Vec<u32>) {
        let letters = self.letters.checked_sub(1).expect("there is a letter");
        let rows = self.next.chunks_exact(self.letters);
        let dfa = Self {
            letters,
            next: rows
                .clone()
                .flat_map(|row| &row[..letters])
                .copied()
                .collect(),
            complete: self.complete,
        };
        (dfa, rows.map(|row| row[letters]).collect())
    }

    /// Lets a word end in every state, so that every prefix of a word is a word.
    #[must_use]
    pub fn prefix_closed(mut self) -> Self {
        self.complete.fill(true);
        self
    }

    /// Refuses letters after which no complete word is possible, and removes unreachable states.
    /// The start state always remains.
    #[must_use]
    pub fn trimmed(self) -> Self {
        let states = self.state_count();
        let mut alive = self.complete.clone();
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); states];
        for state in 0..states {
            for letter in 0..self.letters {
                let to = self.next(state as u32, letter);
                if to != REFUSED {
                    before[to as usize].push(state);
                }
            }
        }
        let mut waiting: Vec<usize> = (0..states).filter(|s| alive[*s]).collect();
        while let Some(state) = waiting.pop() {
            for &from in &before[state] {
                if !alive[from] {
                    alive[from] = true;
                    waiting.push(from);
                }
            }
        }
        let step =
            |state: &u32, letter: usize| self.step(*state, letter).filter(|to| alive[*to as usize]);
        Self::explore(self.letters, 0, states, step, |s| self.is_complete(*s))
            .expect("trimming added states; please report this")
    }

    /// Returns the minimal automaton with the same words and the same refused letters.
    #[must_use]
    pub fn minimal(&self) -> Self {
        let states = self.state_count();
        let (class, count) = self.classes();
        let mut member = vec![0; count];
        for state in (0..states).rev() {
            member[class[state] as usize] = state as u32;
        }
        let step = |c: &u32, letter: usize| {
            let to = self.step(member[*c as usize], letter);
            to.map(|to| class[to as usize])
        };
        let complete = |c: &u32| self.is_complete(member[*c as usize]);
        Self::explore(self.letters, class[0], states, step, complete)
            .expect("minimization added states; please report this")
    }

    /// Returns the equivalence class of every state, and the number of classes. States of one class
    /// have the same words and the same refused letters.
    fn classes(&self) -> (Vec<u32>, usize) {
        let states = self.state_count();
        // Refused letters lead to an additional sink state.
        let sink = states as u32;
        let to = |state: usize, letter: usize| match self.next[state * self.letters + letter] {
            REFUSED => sink,
            to => to,
        };
        // The predecessors of each state, letter by letter. The sink's transitions to itself are
        // omitted, since they never split a block.
        let places = states + 1;
        let mut first = vec![0_u32; self.letters * places + 1];
        for state in 0..states {
            for letter in 0..self.letters {
                first[letter * places + to(state, letter) as usize + 1] += 1;
            }
        }
        for at in 1..first.len() {
            first[at] += first[at - 1];
        }
        let mut before = vec![0_u32; states * self.letters];
        let mut filled = first.clone();
        for state in 0..states {
            for letter in 0..self.letters {
                let at = &mut filled[letter * places + to(state, letter) as usize];
                before[*at as usize] = state as u32;
                *at += 1;
            }
        }
        let kind = |state: usize| match self.complete.get(state) {
            None => 2,
            Some(complete) => usize::from(*complete),
        };
        let mut partition = Partition::new(places, kind);
        let mut waiting: Vec<u32> = (0..partition.count() as u32).collect();
        let mut waits = vec![true; waiting.len()];
        while let Some(splitter) = waiting.pop() {
            waits[splitter as usize] = false;
            let members = partition.members(splitter).to_vec();
            for letter in 0..self.letters {
                for &member in &members {
                    let at = letter * places + member as usize;
                    let (from, until) = (first[at] as usize, first[at + 1] as usize);
                    for &state in &before[from..until] {
                        partition.mark(state);
                    }
                }
                partition.split(|old, new, new_is_smaller| {
                    waits.push(false);
                    // If the block is in the worklist, both halves must be; otherwise the smaller
                    // half is sufficient.
                    let next = if waits[old as usize] || new_is_smaller {
                        new
                    } else {
                        old
                    };
                    waits[next as usize] = true;
                    waiting.push(next);
                });
            }
        }
        // Number the classes in the order of their smallest states.
        let mut numbers: Vec<Option<u32>> = vec![None; partition.count()];
        let mut count = 0;
        let class = (0..states).map(|state| {
            let block = partition.block_of(state) as usize;
            *numbers[block].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        });
        let class: Vec<u32> = class.collect();
        (class, count as usize)
    }

    /// Returns the shortest word that only one of the two automata accepts; of several, the
    /// lexicographically smallest. Returns `None` if they accept the same words. The time is
    /// proportional to the product of the numbers of states.
    ///
    /// # Panics
    /// When the numbers of letters differ.
    pub fn difference(&self, other: &Self) -> Option<Vec<usize>> {
        assert_eq!(
            self.letters, other.letters,
            "both automata must have the same letters"
        );
        let complete = |dfa: &Self, state: u32| state != REFUSED && dfa.is_complete(state);
        let after = |dfa: &Self, state: u32, letter| {
            if state == REFUSED {
                REFUSED
            } else {
                dfa.next(state, letter)
            }
        };
        let successors = |&(a, b): &(u32, u32)| {
            let letters = 0..self.letters;
            let pairs = letters.map(|l| (l, (after(self, a, l), after(other, b, l))));
            pairs
                .filter(|(_, pair)| *pair != (REFUSED, REFUSED))
                .collect()
        };
        shortest((0, 0), successors, |&(a, b)| {
            complete(self, a) != complete(other, b)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds an automaton over two letters whose words have a number of ones divisible by `n`; a
    /// zero is refused after `most` zeros in a row.
    fn counting(n: u32, most: u32) -> Dfa {
        let step = |&(ones, zeros): &(u32, u32), letter: usize| match letter {
            0 if zeros == most => None,
            0 => Some((ones, zeros + 1)),
            _ => Some(((ones + 1) % n, 0)),
        };
        Dfa::explore(2, (0, 0), 1000, step, |s| s.0 == 0).expect("it is small")
    }

    #[test]
    fn the_minimal_automaton_has_the_same_words() {
        let doubled = Dfa::explore(
            2,
            (0, false),
            100,
            |&(n, odd), letter| Some(((n + letter) % 3, !odd)),
            |s| s.0 == 0,
        )
        .expect("it is small");
        assert_eq!(doubled.state_count(), 6);
        let minimal = doubled.minimal();
        assert_eq!(minimal.state_count(), 3);
        assert_eq!(doubled.difference(&minimal), None);
    }

    #[test]
    fn a_difference_is_shortest() {
        assert_eq!(counting(2, 3).difference(&counting(2, 4)), Some(vec![0; 4]));
        assert_eq!(counting(2, 3).difference(&counting(4, 3)), Some(vec![1, 1]));
        assert_eq!(counting(2, 3).difference(&counting(2, 3)), None);
    }

    #[test]
    fn dead_ends_are_trimmed() {
        // A word may end only after a one, and after two zeros no one may follow.
        let step = |&(zeros, one): &(u32, bool), letter: usize| match letter {
            _ if one => None,
            0 => Some(((zeros + 1).min(2), false)),
            _ => (zeros < 2).then_some((zeros, true)),
        };
        let dfa = Dfa::explore(2, (0, false), 100, step, |s| s.1).expect("it is small");
        assert!(dfa.run(&[0, 0]).is_some());
        let trimmed = dfa.trimmed();
        assert!(trimmed.run(&[0, 0]).is_none());
        assert!(trimmed.run(&[0, 1]).is_some_and(|s| trimmed.is_complete(s)));
    }

    #[test]
    fn the_limit_is_respected() {
        let counter = Dfa::explore(1, 0_u32, 10, |n, _| Some(n + 1), |_| true);
        assert_eq!(
            counter.map(|d| d.state_count()),
            Err(BoundExceeded::Count {
                what: "states",
                limit: 10
            })
        );
    }
}
