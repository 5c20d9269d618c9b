//! Several skills at once, as all the orders in which they may be called one after the other.
//!
//! The paper tries all n! orders of n skills. This module computes the same set by set: which
//! states can a rule be in after exactly these skills have been called? That is 2^n sets, each
//! computed from those with one skill less (Held and Karp, "A dynamic programming approach to
//! sequencing problems", 1962). Since orders may end in different states, the state of a rule is a
//! set of states.

use super::Serialisation;
use super::rule::Automaton;
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::{Dfa, REFUSED};
use rustc_hash::FxHashMap;

/// Maximum number of letters at once, without those that the rule does not distinguish.
pub const MOST_AT_ONCE: usize = 16;

/// Number of a set of states of one rule's automaton.
pub type StateSetId = u32;

/// A rule's automaton, read call by call. The result of each call is cached, so a call is computed
/// once.
#[derive(Debug, Clone)]
pub struct Serial {
    dfa: Dfa,
    /// For every state, the state after the end of the call.
    over: Vec<u32>,
    serialisation: Serialisation,
    /// Letters that leave every state as it is.
    idle: Vec<bool>,
    /// Sets of states, each in ascending order.
    sets: Vec<Vec<u32>>,
    numbers: FxHashMap<Vec<u32>, StateSetId>,
    calls: FxHashMap<(StateSetId, Vec<usize>), Option<StateSetId>>,
}

impl Serial {
    /// Creates a rule's automaton before the first call: the set of number 0.
    pub fn new(automaton: Automaton, serialisation: Serialisation) -> Self {
        let Automaton {
            dfa, starts, over, ..
        } = automaton;
        let idle = (0..dfa.letters()).map(|l| dfa.is_idle(l)).collect();
        Self {
            dfa,
            over,
            serialisation,
            idle,
            numbers: FxHashMap::from_iter([(starts.clone(), 0)]),
            sets: vec![starts],
            calls: FxHashMap::default(),
        }
    }

    /// Returns the number of sets of states found so far.
    pub fn met(&self) -> usize {
        self.sets.len()
    }

    /// Returns the states that the rule may be in.
    pub fn states(&self, known: StateSetId) -> &[u32] {
        &self.sets[known as usize]
    }

    /// Returns whether a letter never matters.
    pub fn is_idle(&self, letter: usize) -> bool {
        self.idle[letter]
    }

    /// Returns whether a program may end here: in every state of the set, or in some.
    pub fn is_complete(&self, known: StateSetId) -> bool {
        let mut states = self.states(known).iter();
        match self.serialisation {
            Serialisation::Every => states.all(|s| self.dfa.is_complete(*s)),
            Serialisation::Some => states.any(|s| self.dfa.is_complete(*s)),
        }
    }

    /// Returns the set after these letters at once; `None` if they are refused.
    ///
    /// # Errors
    /// When there are more than [`MOST_AT_ONCE`] that matter.
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
                *state = self.over[*state as usize];
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

    /// Returns, for every set of these letters, by mask, the states after calling exactly those. If
    /// an order is refused and every one has to be allowed, returns the set before, the state and
    /// the letter instead.
    fn reached(
        &self,
        known: StateSetId,
        letters: &[usize],
    ) -> Result<Result<Vec<Vec<u32>>, Refused>, BoundExceeded> {
        if letters.len() > MOST_AT_ONCE {
            return Err(BoundExceeded::Count {
                what: "skills at once that one rule refers to",
                limit: MOST_AT_ONCE,
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

    /// Returns a refused order of these letters, up to the refused letter; `None` if they are
    /// allowed. With [`Serialisation::Some`], if all orders are refused, returns the given one up
    /// to the refused letter.
    ///
    /// # Errors
    /// When there are more than [`MOST_AT_ONCE`] that matter.
    pub fn refusing(
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
        // Backwards from the state: some letter of the set led to it from a state of the set
        // without it.
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
                before.expect("a state is reached from one before; please report this");
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

/// Where an order is refused: the letters called before, by mask, the state after them, and the
/// index of the letter.
struct Refused {
    called: usize,
    state: u32,
    letter: usize,
}
