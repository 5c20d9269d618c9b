//! Conversion of an expression to a deterministic automaton.
//!
//! The expression becomes a nondeterministic automaton with empty moves (Thompson, "Regular
//! expression search algorithm", 1968), which the subset construction makes deterministic.

use super::tree::Regex;
use crate::bound::{BoundExceeded, ExplorationBound};
use crate::dfa::Dfa;
use std::collections::BTreeSet;

/// Maximum number of places of an expression with its repetitions written out.
pub const MOST_PLACES: usize = 1 << 16;

/// What is read on a transition.
enum Move {
    Nothing,
    Letters(Vec<bool>),
}

struct Places {
    letters: usize,
    from: Vec<Vec<(Move, usize)>>,
}

impl Places {
    fn new_place(&mut self) -> Result<usize, BoundExceeded> {
        if self.from.len() == MOST_PLACES {
            return Err(BoundExceeded::Count {
                what: "places in a regular expression",
                limit: MOST_PLACES,
            });
        }
        self.from.push(Vec::new());
        Ok(self.from.len() - 1)
    }

    fn only(&self, letters: &[usize], inside: bool) -> Move {
        let mut set = vec![!inside; self.letters];
        for letter in letters {
            set[*letter] = inside;
        }
        Move::Letters(set)
    }

    /// Adds the expression behind `from`; returns the place where its words end.
    fn lay(&mut self, regex: &Regex, from: usize) -> Result<usize, BoundExceeded> {
        match regex {
            Regex::Nothing => self.new_place(),
            Regex::Empty => Ok(from),
            Regex::Letter(letter) => self.lay_one(self.only(&[*letter], true), from),
            Regex::AnyBut(letters) => self.lay_one(self.only(letters, false), from),
            Regex::AnyOrder(letters) => self.lay_any_order(letters, from),
            Regex::Concat(parts) => parts.iter().try_fold(from, |at, part| self.lay(part, at)),
            Regex::Either(parts) => {
                let end = self.new_place()?;
                for part in parts {
                    let begin = self.new_place()?;
                    self.from[from].push((Move::Nothing, begin));
                    let at = self.lay(part, begin)?;
                    self.from[at].push((Move::Nothing, end));
                }
                Ok(end)
            }
            Regex::Repeat { of, low, high } => {
                let mut at = from;
                for _ in 0..*low {
                    at = self.lay(of, at)?;
                    // An empty repetition takes a place too, so every number can be too large.
                    let next = self.new_place()?;
                    self.from[at].push((Move::Nothing, next));
                    at = next;
                }
                let end = self.new_place()?;
                if let Some(high) = high {
                    for _ in *low..*high {
                        self.from[at].push((Move::Nothing, end));
                        let begin = self.new_place()?;
                        self.from[at].push((Move::Nothing, begin));
                        at = self.lay(of, begin)?;
                    }
                } else {
                    let around = self.new_place()?;
                    self.from[at].push((Move::Nothing, around));
                    let back = self.lay(of, around)?;
                    self.from[back].push((Move::Nothing, around));
                    at = around;
                }
                self.from[at].push((Move::Nothing, end));
                Ok(end)
            }
        }
    }

    fn lay_one(&mut self, step: Move, from: usize) -> Result<usize, BoundExceeded> {
        let to = self.new_place()?;
        self.from[from].push((step, to));
        Ok(to)
    }

    /// Adds a place for every set of letters read so far.
    fn lay_any_order(&mut self, letters: &[usize], from: usize) -> Result<usize, BoundExceeded> {
        if letters.len() >= MOST_PLACES.ilog2() as usize {
            return Err(BoundExceeded::Count {
                what: "places in a regular expression",
                limit: MOST_PLACES,
            });
        }
        let mut places = vec![from];
        for _ in 1..1_usize << letters.len() {
            places.push(self.new_place()?);
        }
        for read in 0..places.len() {
            for (i, letter) in letters.iter().enumerate() {
                if read >> i & 1 == 0 {
                    let step = self.only(&[*letter], true);
                    self.from[places[read]].push((step, places[read | 1 << i]));
                }
            }
        }
        Ok(places[places.len() - 1])
    }

    /// Returns these places and all that are reached by empty moves, in ascending order.
    fn closure(&self, places: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut waiting: Vec<usize> = places.into_iter().collect();
        let mut seen: BTreeSet<usize> = waiting.iter().copied().collect();
        while let Some(place) = waiting.pop() {
            for (step, to) in &self.from[place] {
                if matches!(step, Move::Nothing) && seen.insert(*to) {
                    waiting.push(*to);
                }
            }
        }
        seen.into_iter().collect()
    }
}

/// Returns the minimal automaton of an expression over `letters` letters. Letters after which no
/// word is possible are refused.
///
/// # Errors
/// When the expression has more than [`MOST_PLACES`] places, when the automaton has more states
/// than `bound` allows, or when the deadline has passed.
pub fn automaton(
    regex: &Regex,
    letters: usize,
    bound: impl Into<ExplorationBound>,
) -> Result<Dfa, BoundExceeded> {
    let mut places = Places {
        letters,
        from: vec![Vec::new()],
    };
    let end = places.lay(regex, 0)?;
    let step = |state: &Vec<usize>, letter: usize| {
        let moves = state.iter().flat_map(|place| &places.from[*place]);
        let reached = moves.filter_map(|(step, to)| match step {
            Move::Letters(set) if set[letter] => Some(*to),
            _ => None,
        });
        let reached = places.closure(reached);
        (!reached.is_empty()).then_some(reached)
    };
    let start = places.closure([0]);
    let dfa = Dfa::explore(letters, start, bound, step, |s| s.contains(&end))?;
    Ok(dfa.trimmed().minimal())
}
