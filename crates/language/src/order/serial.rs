//! Calls of several skills at once, treated as all orders of calling them one after the other.
//!
//! Brandenbourger et al. try all n! orders of n skills. This module computes the same result from
//! sets of skills: for each set, the states that a rule can be in after exactly these skills have
//! been called. There are 2^n sets, each computed from those with one skill less (Held and Karp, "A
//! dynamic programming approach to sequencing problems", 1962). Since different orders can end in
//! different states, the state of a rule is a set of states.

use super::Serialisation;
use super::rule::Automaton;
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::{Dfa, REFUSED};
use rustc_hash::FxHashMap;

/// Maximum number of letters in a call that have an influence on one rule.
pub const MAX_AT_ONCE: usize = 16;

/// Number of a set of states of a rule's automaton, assigned by [`Serial`].
pub type StateSetId = u32;

/// Wraps the automaton of a rule so that it reads calls instead of letters. A state of the wrapper
/// is a set of states of the wrapped automaton, and is created on demand. The result of each call
/// is cached.
#[derive(Debug, Clone)]
pub struct Serial {
    dfa: Dfa,
    /// For every state, the state after the end of the call.
    after_call: Vec<u32>,
    serialisation: Serialisation,
    /// Letters that leave every state as it is.
    idle: Vec<bool>,
    /// Sets of states, each in ascending order.
    sets: Vec<Vec<u32>>,
    numbers: FxHashMap<Vec<u32>, StateSetId>,
    calls: FxHashMap<(StateSetId, Vec<usize>), Option<StateSetId>>,
}

impl Serial {
    /// Wraps a rule's automaton. Set number 0 contains the states before the first call.
    pub fn new(automaton: Automaton, serialisation: Serialisation) -> Self {
        let Automaton {
            dfa,
            starts,
            after_call,
            ..
        } = automaton;
        let idle = (0..dfa.letter_count()).map(|l| dfa.is_idle(l)).collect();
        Self {
            dfa,
            after_call,
            serialisation,
            idle,
            numbers: FxHashMap::from_iter([(starts.clone(), 0)]),
            sets: vec![starts],
            calls: FxHashMap::default(),
        }
    }

    /// Returns the number of sets of states found so far.
    pub fn set_count(&self) -> usize {
        self.sets.len()
    }

    /// Returns the states of a set, ascending.
    pub fn states(&self, known: StateSetId) -> &[u32] {
        &self.sets[known as usize]
    }

    /// Returns whether a letter leaves every state unchanged.
    pub fn is_idle(&self, letter: usize) -> bool {
        self.idle[letter]
    }

    /// Returns whether a program can end in this set. With [`Serialisation::Every`], it has to be
    /// able to end in every state of the set; with [`Serialisation::Some`], in one of them.
    pub fn is_complete(&self, known: StateSetId) -> bool {
        let mut states = self.states(known).iter();
        match self.serialisation {
            Serialisation::Every => states.all(|s| self.dfa.is_complete(*s)),
            Serialisation::Some => states.any(|s| self.dfa.is_complete(*s)),
        }
    }

    /// Returns the set after a call of these letters at once; `None` if the call is refused.
    ///
    /// # Errors
    /// When more than [`MAX_AT_ONCE`] letters are not idle.
    pub fn call(
        &mut self,
        known: StateSetId,
        letters: &[usize],
    ) -> Result<Option<StateSetId>, BoundExceeded> {
        let letters: Vec<usize> = letters.iter().copied().filter(|l| !self.idle[*l]).collect();
        let key = (known, letters);
        if let Some(after) = self.calls.get(&key) {
            return Ok(*after);
        }
        let letters = &key.1;
        let after = if let [letter] = letters.as_slice() {
            self.one(known, *letter)
        } else {
            let reached = self.reached(known, letters)?;
            reached.ok().and_then(|mut sets| sets.pop())
        };
        let after = after.map(|mut states| {
            for state in &mut states {
                *state = self.after_call[*state as usize];
            }
            states.sort_unstable();
            states.dedup();
            let new = self.sets.len() as StateSetId;
            let number = *self.numbers.entry(states.clone()).or_insert(new);
            if number == new {
                self.sets.push(states);
            }
            number
        });
        self.calls.insert(key, after);
        Ok(after)
    }

    fn one(&self, known: StateSetId, letter: usize) -> Option<Vec<u32>> {
        let states = self.states(known).iter();
        let mut reached: Vec<u32> = states.map(|s| self.dfa.next(*s, letter)).collect();
        reached.sort_unstable();
        reached.dedup();
        if reached.last() == Some(&REFUSED) {
            match self.serialisation {
                Serialisation::Every => return None,
                Serialisation::Some => reached.pop(),
            };
        }
        (!reached.is_empty()).then_some(reached)
    }

    /// Returns, for every subset of these letters (by mask), the states after calling exactly those
    /// letters. If the call is refused, returns instead where an order of the letters is refused.
    fn reached(
        &self,
        known: StateSetId,
        letters: &[usize],
    ) -> Result<Result<Vec<Vec<u32>>, Refused>, BoundExceeded> {
        if letters.len() > MAX_AT_ONCE {
            return Err(BoundExceeded::Count {
                what: "skills at once that one rule mentions",
                limit: MAX_AT_ONCE,
            });
        }
        let mut sets: Vec<Vec<u32>> = vec![Vec::new(); 1 << letters.len()];
        sets[0] = self.states(known).to_vec();
        for called in 0..sets.len() {
            sets[called].sort_unstable();
            sets[called].dedup();
            for (i, letter) in letters.iter().enumerate() {
                if called >> i & 1 == 1 {
                    continue;
                }
                for at in 0..sets[called].len() {
                    let state = sets[called][at];
                    let to = self.dfa.next(state, *letter);
                    if to != REFUSED {
                        sets[called | 1 << i].push(to);
                    } else if self.serialisation == Serialisation::Every {
                        return Ok(Err(Refused {
                            called,
                            state,
                            letter: i,
                        }));
                    }
                }
            }
        }
        if sets.last().is_some_and(Vec::is_empty) {
            return Ok(Err(Refused {
                called: 0,
                state: REFUSED,
                letter: 0,
            }));
        }
        Ok(Ok(sets))
    }

    /// Returns a refused order of these letters, up to the refused letter; `None` if the call is
    /// allowed. With [`Serialisation::Some`], it is the order of `letters`.
    ///
    /// # Errors
    /// When more than [`MAX_AT_ONCE`] letters are not idle.
    pub fn refused_order(
        &self,
        known: StateSetId,
        letters: &[usize],
    ) -> Result<Option<Vec<usize>>, BoundExceeded> {
        let letters: Vec<usize> = letters.iter().copied().filter(|l| !self.idle[*l]).collect();
        let Err(refused) = self.reached(known, &letters)? else {
            return Ok(None);
        };
        if refused.state == REFUSED {
            return Ok(Some(self.refused_in_order(known, &letters)));
        }
        // The order is found backwards from the refusing state: one of the letters called before
        // led to that state, from a state in which the other letters had been called.
        let mut order = vec![letters[refused.letter]];
        let (mut called, mut state) = (refused.called, refused.state);
        while called != 0 {
            let inside: Vec<usize> = (0..letters.len())
                .filter(|i| called >> i & 1 == 1)
                .collect();
            let before = inside.into_iter().find_map(|i| {
                let rest = called & !(1 << i);
                let others: Vec<usize> = (0..letters.len())
                    .filter(|j| rest >> j & 1 == 1)
                    .map(|j| letters[j])
                    .collect();
                let sets = self.reached(known, &others).ok()?.ok()?;
                let from = sets.last()?.iter().copied();
                let from = from
                    .filter(|s| self.dfa.next(*s, letters[i]) == state)
                    .min()?;
                Some((i, rest, from))
            });
            let (i, rest, from) =
                before.expect("a state was not reached from an earlier one; please report this");
            order.push(letters[i]);
            (called, state) = (rest, from);
        }
        order.reverse();
        Ok(Some(order))
    }

    fn refused_in_order(&self, known: StateSetId, letters: &[usize]) -> Vec<usize> {
        let mut state = self.states(known)[0];
        let mut order = Vec::new();
        for letter in letters {
            order.push(*letter);
            state = self.dfa.next(state, *letter);
            if state == REFUSED {
                break;
            }
        }
        order
    }
}

/// Where an order is refused: mask of the letters called before, the state after them, and the
/// index of the refused letter. The state is [`REFUSED`] if all orders are refused.
struct Refused {
    called: usize,
    state: u32,
    letter: usize,
}
