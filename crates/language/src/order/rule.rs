//! Conversion of a rule to its automaton over single skills.
//!
//! The letters are the skills, followed by every event of several skills that a rule mentions: if
//! `Left & Down` are called at once, the letters `Left`, `Down` and `Left & Down` come in any
//! order. Only the `in a row` rules use the skills alone: `Left & Down` occurs where the two follow
//! each other in one call, so nothing comes between it and its predecessor.

use super::standing::{Window, standing};
use super::{Event, Kind, Rule, Skills};
use linewright_automata::bound::{BoundExceeded, ExplorationBound, MOST_STATES};
use linewright_automata::dfa::Dfa;
use linewright_automata::regex::{self, Regex};
use linewright_core::deadline::Deadline;
use std::hash::Hash;

/// Letters of a set of skills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alphabet {
    /// Number of skills.
    skills: usize,
    /// Events of several skills, as masks, in ascending order.
    at_once: Vec<u64>,
}

fn mask(event: &Event) -> u64 {
    event.0.iter().fold(0, |mask, skill| mask | 1 << skill)
}

fn masks(events: &[Event]) -> Vec<u64> {
    events.iter().map(mask).collect()
}

impl Alphabet {
    /// Returns the letters that the rules of these skills mention.
    pub fn of(skills: &Skills) -> Self {
        let mut at_once = Vec::new();
        for rule in &skills.rules {
            rule.kind.for_each_event(&mut |event| {
                if event.0.len() > 1 {
                    at_once.push(mask(event));
                }
            });
        }
        at_once.sort_unstable();
        at_once.dedup();
        Self {
            skills: skills.skills.len(),
            at_once,
        }
    }

    /// Returns the number of letters.
    pub fn len(&self) -> usize {
        self.skills + self.at_once.len()
    }

    /// Returns whether there are no letters.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the letters of a call: its skills, and the events of several skills that it
    /// contains.
    pub fn letters(&self, call: u64) -> Vec<usize> {
        let skills = (0..self.skills).filter(|s| call >> s & 1 == 1);
        let events = self
            .at_once
            .iter()
            .enumerate()
            .filter(|(_, e)| *e & call == **e);
        skills.chain(events.map(|(i, _)| self.skills + i)).collect()
    }

    /// Returns the skills of a letter: one, or those of an event of several.
    pub fn skills_of(&self, letter: usize) -> Vec<usize> {
        match letter.checked_sub(self.skills) {
            None => vec![letter],
            Some(event) => super::supervisor::Call(self.at_once[event])
                .skills()
                .collect(),
        }
    }

    /// Formats a letter: `Left`, or `Left & Down` for an event of several skills.
    pub fn text(&self, letter: usize, skills: &Skills) -> String {
        match letter.checked_sub(self.skills) {
            None => skills.skills[letter].name.clone(),
            Some(event) => super::supervisor::Call(self.at_once[event]).text(skills),
        }
    }

    fn letter(&self, event: &Event) -> usize {
        if let [skill] = event.0.as_slice() {
            return *skill;
        }
        let place = self.at_once.binary_search(&mask(event));
        self.skills + place.expect("an event of these rules; please report this")
    }

    /// Returns, for every letter, whether it is one of these events.
    fn set(&self, events: &[Event]) -> Vec<bool> {
        let mut set = vec![false; self.len()];
        for event in events {
            set[self.letter(event)] = true;
        }
        set
    }
}

impl Kind {
    /// Calls `seen` with every event, except those of regular expressions.
    pub fn for_each_event(&self, seen: &mut impl FnMut(&Event)) {
        let lists: Vec<&Vec<Event>> = match self {
            Self::Never(events) => vec![events],
            Self::After { from, until, never } => vec![from, until, never],
            Self::Before { first, then } => vec![first, then],
            Self::OnlyAfter { what, after } => vec![what, after],
            Self::AtMost {
                of, from, until, ..
            } => vec![of, from, until],
            Self::InARow(words) => words.iter().flatten().collect(),
            Self::Sequence(_) => Vec::new(),
        };
        lists.into_iter().flatten().for_each(seen);
    }
}

/// A rule as an automaton.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Automaton {
    /// Automaton over the letters of an [`Alphabet`]. Its state 0 is not always the start.
    pub dfa: Dfa,
    /// Possible start states, ascending: with a closed and with an open window if the initial
    /// situation does not determine which skill was called last, else one state.
    pub starts: Vec<u32>,
    /// Window at the start.
    pub window: Window,
    /// For every state, the state after the end of the call.
    pub over: Vec<u32>,
}

impl Automaton {
    /// Returns the start state for an open or closed window.
    pub(super) fn start(&self, open: bool) -> u32 {
        self.starts[usize::from(open).min(self.starts.len() - 1)]
    }

    /// Creates an automaton for which the end of a call does not matter.
    fn of_letters(dfa: Dfa, starts: Vec<u32>) -> Self {
        let over = (0..dfa.states() as u32).collect();
        Self {
            dfa,
            starts,
            window: Window::default(),
            over,
        }
    }

    /// Explores states from several starts; `over` gives the state after the end of a call.
    ///
    /// # Errors
    /// When there are more than [`MOST_STATES`] states, or the deadline has passed.
    pub(super) fn explore<S: Clone + Eq + Hash>(
        letters: usize,
        starts: &[S],
        until: Deadline,
        step: impl Fn(&S, usize) -> Option<S>,
        over: impl Fn(&S) -> S,
        complete: impl Fn(&S) -> bool,
    ) -> Result<(Self, Vec<S>), BoundExceeded> {
        // The end of a call is an additional letter, so that its successors are found as well.
        let step = |state: &S, letter: usize| {
            if letter == letters {
                Some(over(state))
            } else {
                step(state, letter)
            }
        };
        let found = Dfa::explore_all(
            letters + 1,
            starts,
            ExplorationBound::new(MOST_STATES, until),
            step,
            complete,
        )?;
        let (dfa, over) = found.dfa.without_last_letter();
        let automaton = Self {
            dfa,
            starts: found.starts,
            window: Window::default(),
            over,
        };
        Ok((automaton, found.states))
    }
}

/// Returns the automaton of a rule.
///
/// # Errors
/// When it would have more than [`MOST_STATES`] states, or the deadline has passed.
pub fn automaton(
    rule: &Rule,
    skills: &Skills,
    alphabet: &Alphabet,
    until: Deadline,
) -> Result<Automaton, BoundExceeded> {
    let letters = alphabet.len();
    let set = |events: &[Event]| alphabet.set(events);
    // Whether one of these counts as called at the start.
    let called = |events: &[Event]| standing(events, skills) != 0;
    match &rule.kind {
        Kind::Never(never) => {
            let never = set(never);
            one(letters, &[()], |(), l| (!never[l]).then_some(()))
        }
        Kind::After { from, until, never } => {
            let window = Window::new(from, until, skills);
            let (from, until, never) = (set(from), set(until), set(never));
            let automaton = one(letters, &window.starts(), |open, l| {
                (!(*open && never[l])).then(|| from[l] || *open && !until[l])
            })?;
            Ok(Automaton {
                window,
                ..automaton
            })
        }
        Kind::Before { first, then } => {
            let start = called(first);
            let (first, then) = (set(first), set(then));
            one(letters, &[start], |met, l| {
                (*met || first[l] || !then[l]).then(|| *met || first[l])
            })
        }
        Kind::OnlyAfter { what, after } => {
            let start = called(after);
            let (what, after) = (set(what), set(after));
            one(letters, &[start], |ready, l| {
                (*ready || !what[l]).then(|| after[l] || *ready && !what[l])
            })
        }
        Kind::AtMost {
            count,
            of,
            from,
            until,
        } => {
            let window = Window::new(from, until, skills);
            let starts = if from.is_empty() {
                vec![true]
            } else {
                window.starts()
            };
            let starts: Vec<Option<u32>> =
                starts.into_iter().map(|open| open.then_some(0)).collect();
            let (of, from, until) = (set(of), set(from), set(until));
            let automaton = one(letters, &starts, |counted, l| {
                let counted = match *counted {
                    Some(n) if of[l] && n == *count => return None,
                    Some(n) if of[l] => Some(n + 1),
                    other => other,
                };
                Some(match counted {
                    Some(_) if until[l] => from[l].then_some(0),
                    None if from[l] => Some(0),
                    other => other,
                })
            })?;
            Ok(Automaton {
                window,
                ..automaton
            })
        }
        Kind::InARow(words) => in_a_row(words, alphabet, until),
        Kind::Sequence(regex) => sequence(regex, skills, letters, until),
    }
}

/// Creates an automaton all of whose states are complete, with several starts.
fn one<S: Clone + Eq + Hash>(
    letters: usize,
    starts: &[S],
    step: impl Fn(&S, usize) -> Option<S>,
) -> Result<Automaton, BoundExceeded> {
    let explored = Dfa::explore_all(letters, starts, MOST_STATES, step, |_| true)?;
    Ok(Automaton::of_letters(explored.dfa, explored.starts))
}

/// Progress in a word: the word, the position in it, and the missing skills of an event of several
/// skills whose other skills have just been called.
type WordProgress = (usize, usize, u64);

/// Builds the automaton of words in a row. A state is the progress in each word: the suffixes of
/// the calls that begin a word (Aho and Corasick, "Efficient string matching", 1975, by sets).
fn in_a_row(
    words: &[Vec<Vec<Event>>],
    alphabet: &Alphabet,
    until: Deadline,
) -> Result<Automaton, BoundExceeded> {
    let words: Vec<Vec<Vec<u64>>> = words
        .iter()
        .map(|word| word.iter().map(|place| masks(place)).collect())
        .collect();
    let step = |reached: &Vec<WordProgress>, letter: usize| {
        if letter >= alphabet.skills {
            // The skills of an event of several are sufficient.
            return Some(reached.clone());
        }
        let skill = 1 << letter;
        let mut next = Vec::new();
        let starts = (0..words.len()).map(|w| (w, 0, 0));
        for (word, at, missing) in reached.iter().copied().chain(starts) {
            let begun = [missing];
            let events = if missing == 0 {
                words[word][at].as_slice()
            } else {
                &begun
            };
            for event in events.iter().filter(|e| *e & skill != 0) {
                match event & !skill {
                    0 if at + 1 == words[word].len() => return None,
                    0 => next.push((word, at + 1, 0)),
                    missing => next.push((word, at, missing)),
                }
            }
        }
        next.sort_unstable();
        next.dedup();
        Some(next)
    };
    // The missing skills of an event have to come in the same call.
    let over = |reached: &Vec<WordProgress>| {
        let whole = reached.iter().filter(|(_, _, missing)| *missing == 0);
        whole.copied().collect()
    };
    let explored = Automaton::explore(alphabet.len(), &[Vec::new()], until, step, over, |_| true);
    explored.map(|(automaton, _)| automaton)
}

/// Builds the automaton of the prefixes of a regular expression's words. An event of several skills
/// changes nothing here.
fn sequence(
    regex: &Regex,
    skills: &Skills,
    letters: usize,
    until: Deadline,
) -> Result<Automaton, BoundExceeded> {
    let dfa = regex::automaton(
        regex,
        skills.skills.len(),
        ExplorationBound::new(MOST_STATES, until),
    )?;
    let count = skills.skills.len();
    let step = |state: &u32, letter: usize| {
        if letter >= count {
            return Some(*state);
        }
        dfa.step(*state, letter)
    };
    let dfa = Dfa::explore(letters, 0, MOST_STATES, step, |s| dfa.is_complete(*s))?;
    Ok(Automaton::of_letters(dfa, vec![0]))
}
