//! Conversion of an expression to a deterministic automaton.
//!
//! The expression becomes a nondeterministic automaton with empty moves (Thompson, "Regular
//! expression search algorithm", 1968), which the subset construction makes deterministic.

use super::tree::Regex;
use crate::bound::{BoundExceeded, ExplorationBound};
use crate::dfa::Dfa;
use std::collections::BTreeSet;

/// Maximum number of states of the nondeterministic automaton (*places*), in which repetitions are
/// copied.
pub const MAX_PLACES: usize = 1 << 16;

/// Label of a transition.
enum Move {
    /// The transition reads no letter.
    Empty,
    /// The transition reads one of the letters whose entry is true.
    Letters(Vec<bool>),
}

/// The nondeterministic automaton.
struct Places {
    letters: usize,
    from: Vec<Vec<(Move, usize)>>,
}

impl Places {
    fn new_place(&mut self) -> Result<usize, BoundExceeded> {
        if self.from.len() == MAX_PLACES {
            return Err(BoundExceeded::Count {
                what: "places in a regular expression",
                limit: MAX_PLACES,
            });
        }
        self.from.push(Vec::new());
        Ok(self.from.len() - 1)
    }

    fn letter_move(&self, letters: &[usize], inside: bool) -> Move {
        let mut set = vec![!inside; self.letters];
        for letter in letters {
            set[*letter] = inside;
        }
        Move::Letters(set)
    }

    /// Adds an expression whose words start at `from`; returns the place where they end.
    fn append(&mut self, regex: &Regex, from: usize) -> Result<usize, BoundExceeded> {
        match regex {
            Regex::Nothing => self.new_place(),
            Regex::Empty => Ok(from),
            Regex::Letter(letter) => self.append_move(self.letter_move(&[*letter], true), from),
            Regex::AnyBut(letters) => self.append_move(self.letter_move(letters, false), from),
            Regex::AnyOrder(letters) => self.append_any_order(letters, from),
            Regex::Concat(parts) => parts
                .iter()
                .try_fold(from, |at, part| self.append(part, at)),
            Regex::Either(parts) => {
                let end = self.new_place()?;
                for part in parts {
                    let begin = self.new_place()?;
                    self.from[from].push((Move::Empty, begin));
                    let at = self.append(part, begin)?;
                    self.from[at].push((Move::Empty, end));
                }
                Ok(end)
            }
            Regex::Repeat { of, low, high } => {
                let mut at = from;
                for _ in 0..*low {
                    at = self.append(of, at)?;
                    // Each repetition takes at least one place, even of the empty word, so that the
                    // limit applies to every count.
                    let next = self.new_place()?;
                    self.from[at].push((Move::Empty, next));
                    at = next;
                }
                let end = self.new_place()?;
                if let Some(high) = high {
                    for _ in *low..*high {
                        self.from[at].push((Move::Empty, end));
                        let begin = self.new_place()?;
                        self.from[at].push((Move::Empty, begin));
                        at = self.append(of, begin)?;
                    }
                } else {
                    let around = self.new_place()?;
                    self.from[at].push((Move::Empty, around));
                    let back = self.append(of, around)?;
                    self.from[back].push((Move::Empty, around));
                    at = around;
                }
                self.from[at].push((Move::Empty, end));
                Ok(end)
            }
        }
    }

    fn append_move(&mut self, step: Move, from: usize) -> Result<usize, BoundExceeded> {
        let to = self.new_place()?;
        self.from[from].push((step, to));
        Ok(to)
    }

    /// Adds an expression that reads letters in any order, with one place for every set of letters
    /// already read.
    fn append_any_order(&mut self, letters: &[usize], from: usize) -> Result<usize, BoundExceeded> {
        if letters.len() >= MAX_PLACES.ilog2() as usize {
            return Err(BoundExceeded::Count {
                what: "places in a regular expression",
                limit: MAX_PLACES,
            });
        }
        let mut places = vec![from];
        for _ in 1..1_usize << letters.len() {
            places.push(self.new_place()?);
        }
        for read in 0..places.len() {
            for (i, letter) in letters.iter().enumerate() {
                if read >> i & 1 == 0 {
                    let step = self.letter_move(&[*letter], true);
                    self.from[places[read]].push((step, places[read | 1 << i]));
                }
            }
        }
        Ok(places[places.len() - 1])
    }

    /// Returns these places and all places reachable from them by empty moves, in ascending order.
    fn closure(&self, places: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut waiting: Vec<usize> = places.into_iter().collect();
        let mut seen: BTreeSet<usize> = waiting.iter().copied().collect();
        while let Some(place) = waiting.pop() {
            for (step, to) in &self.from[place] {
                if matches!(step, Move::Empty) && seen.insert(*to) {
                    waiting.push(*to);
                }
            }
        }
        seen.into_iter().collect()
    }
}

/// Returns the minimal automaton of an expression over `letters` letters. It refuses letters after
/// which no word of the expression is possible.
///
/// # Errors
/// When the expression has more than [`MAX_PLACES`] places, when the automaton has more states
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
    let end = places.append(regex, 0)?;
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
