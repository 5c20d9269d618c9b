//! Conversion of a rule to its automaton over single skills.
//!
//! The letters are the skills, followed by every event of several skills that a rule mentions: if
//! `Left & Down` are called at once, the letters `Left`, `Down` and `Left & Down` come in any
//! order. The `in a row` rules ignore the letters of events, because such a letter would separate
//! two skills that follow each other directly. For these rules, `Left & Down` occurs where the two
//! skills follow each other within one call.

use super::standing::{Window, initially_called};
use super::{Event, Kind, Rule, Skills};
use linewright_automata::bound::{BoundExceeded, ExplorationBound, MAX_DFA_STATES};
use linewright_automata::dfa::Dfa;
use linewright_automata::regex::{self, Regex};
use linewright_core::deadline::Deadline;
use std::hash::Hash;

/// Alphabet of the automata for the rules of a skill set.
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
    /// Creates the alphabet of a skill set: its skills, and each combination of simultaneous skills
    /// that one of its rules mentions.
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

    /// Returns the skills of a letter: one skill, or those of an event of several.
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
        self.skills + place.expect("the event is not one of these rules; please report this")
    }

    /// Returns, for every letter, whether the letter is one of these events.
    fn set(&self, events: &[Event]) -> Vec<bool> {
        let mut set = vec![false; self.len()];
        for event in events {
            set[self.letter(event)] = true;
        }
        set
    }
}

impl Kind {
    /// Calls `visit` with every event, except those of regular expressions.
    pub fn for_each_event(&self, visit: &mut impl FnMut(&Event)) {
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
        lists.into_iter().flatten().for_each(visit);
    }
}

/// A rule as an automaton.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Automaton {
    /// Automaton over the letters of an [`Alphabet`]. Its state 0 is not always the start.
    pub dfa: Dfa,
    /// Possible start states. Usually there is one. If the window can be closed or open at the
    /// start, there are two: the state for the closed window, then the state for the open window.
    pub starts: Vec<u32>,
    /// Window of the rule at the start; the default for a rule without a window.
    pub window: Window,
    /// For every state, the state after the end of the call.
    pub after_call: Vec<u32>,
}

impl Automaton {
    /// Returns the start state for an open or closed window.
    pub(super) fn start(&self, open: bool) -> u32 {
        self.starts[usize::from(open).min(self.starts.len() - 1)]
    }

    /// Creates an automaton that ignores the end of a call.
    fn of_letters(dfa: Dfa, starts: Vec<u32>) -> Self {
        let after_call = (0..dfa.state_count() as u32).collect();
        Self {
            dfa,
            starts,
            window: Window::default(),
            after_call,
        }
    }

    /// Explores the automaton from several starts; `end_call` returns the state after the end of a
    /// call. Also returns the value `S` for which each state stands.
    ///
    /// # Errors
    /// When there are more than [`MAX_DFA_STATES`] states, or the deadline has passed.
    pub(super) fn explore<S: Clone + Eq + Hash>(
        letters: usize,
        starts: &[S],
        until: Deadline,
        step: impl Fn(&S, usize) -> Option<S>,
        end_call: impl Fn(&S) -> S,
        complete: impl Fn(&S) -> bool,
    ) -> Result<(Self, Vec<S>), BoundExceeded> {
        // The end of a call is an additional letter, so that the states after it are found as well.
        let step = |state: &S, letter: usize| {
            if letter == letters {
                Some(end_call(state))
            } else {
                step(state, letter)
            }
        };
        let found = Dfa::explore_all(
            letters + 1,
            starts,
            ExplorationBound::new(MAX_DFA_STATES, until),
            step,
            complete,
        )?;
        let (dfa, after_call) = found.dfa.without_last_letter();
        let automaton = Self {
            dfa,
            starts: found.starts,
            window: Window::default(),
            after_call,
        };
        Ok((automaton, found.states))
    }
}

/// Returns the automaton of a rule.
///
/// # Errors
/// When it would have more than [`MAX_DFA_STATES`] states, or the deadline has passed.
pub fn automaton(
    rule: &Rule,
    skills: &Skills,
    alphabet: &Alphabet,
    until: Deadline,
) -> Result<Automaton, BoundExceeded> {
    let letters = alphabet.len();
    let set = |events: &[Event]| alphabet.set(events);
    // Whether one of these events counts as called at the start.
    let called = |events: &[Event]| initially_called(events, skills) != 0;
    match &rule.kind {
        Kind::Never(never) => {
            let never = set(never);
            always_complete(letters, &[()], |(), l| (!never[l]).then_some(()))
        }
        Kind::After { from, until, never } => {
            let window = Window::new(from, until, skills);
            let (from, until, never) = (set(from), set(until), set(never));
            let automaton = always_complete(letters, &window.starts(), |open, l| {
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
            always_complete(letters, &[start], |met, l| {
                (*met || first[l] || !then[l]).then(|| *met || first[l])
            })
        }
        Kind::OnlyAfter { what, after } => {
            let start = called(after);
            let (what, after) = (set(what), set(after));
            always_complete(letters, &[start], |ready, l| {
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
            let automaton = always_complete(letters, &starts, |counted, l| {
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

/// Explores an automaton whose states are all complete.
fn always_complete<S: Clone + Eq + Hash>(
    letters: usize,
    starts: &[S],
    step: impl Fn(&S, usize) -> Option<S>,
) -> Result<Automaton, BoundExceeded> {
    let explored = Dfa::explore_all(letters, starts, MAX_DFA_STATES, step, |_| true)?;
    Ok(Automaton::of_letters(explored.dfa, explored.starts))
}

/// Progress in a word: index of the word, position in it, and a mask of the missing skills if an
/// event of several skills has only been called in part.
type WordProgress = (usize, usize, u64);

/// Builds the automaton of words in a row. A state is a set of positions in the words, one for each
/// suffix of the previous calls that is the beginning of a word. These are the states of Aho and
/// Corasick, "Efficient string matching", 1975, represented as sets.
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
            // Events of several skills are recognized by their single skills.
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
    // Events with missing skills are dropped at the end of a call, because all skills of an event
    // have to come in the same call.
    let end_call = |reached: &Vec<WordProgress>| {
        let whole = reached.iter().filter(|(_, _, missing)| *missing == 0);
        whole.copied().collect()
    };
    let explored = Automaton::explore(alphabet.len(), &[Vec::new()], until, step, end_call, |_| {
        true
    });
    explored.map(|(automaton, _)| automaton)
}

/// Builds the automaton of the prefixes of a regular expression's words. Letters of events of
/// several skills change nothing.
fn sequence(
    regex: &Regex,
    skills: &Skills,
    letters: usize,
    until: Deadline,
) -> Result<Automaton, BoundExceeded> {
    let dfa = regex::automaton(
        regex,
        skills.skills.len(),
        ExplorationBound::new(MAX_DFA_STATES, until),
    )?;
    let count = skills.skills.len();
    let step = |state: &u32, letter: usize| {
        if letter >= count {
            return Some(*state);
        }
        dfa.step(*state, letter)
    };
    let dfa = Dfa::explore(letters, 0, MAX_DFA_STATES, step, |s| dfa.is_complete(*s))?;
    Ok(Automaton::of_letters(dfa, vec![0]))
}
