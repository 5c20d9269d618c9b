//! From a rule to its automaton over single skills.
//!
//! The letters are the skills, and behind them every event of several skills that a rule speaks of: where `Left & Down` are called at once,
//! the letters `Left`, `Down` and `Left & Down` come in any order.

use super::dfa::{Dfa, TooLarge};
use super::{Event, Kind, Regex, Rule, Skills, regex};

/// A rule's automaton has so many states at most.
pub const MOST_STATES: usize = 1 << 16;

/// The letters of a set of skills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alphabet {
    /// How many skills there are.
    skills: usize,
    /// The events of several skills, as masks, in ascending order.
    at_once: Vec<u64>,
}

fn mask(event: &Event) -> u64 {
    event.0.iter().fold(0, |mask, skill| mask | 1 << skill)
}

impl Alphabet {
    /// The letters that the rules of these skills speak of.
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

    /// How many letters there are.
    pub fn len(&self) -> usize {
        self.skills + self.at_once.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The letters of a call: its skills, and the events of several skills that it contains.
    pub fn letters(&self, call: u64) -> Vec<usize> {
        let skills = (0..self.skills).filter(|s| call >> s & 1 == 1);
        let events = self.at_once.iter().enumerate();
        let events = events.filter(|(_, e)| *e & call == **e);
        skills.chain(events.map(|(i, _)| self.skills + i)).collect()
    }

    /// The skills of a letter: one, or those of an event of several.
    pub fn skills_of(&self, letter: usize) -> Vec<usize> {
        match letter.checked_sub(self.skills) {
            None => vec![letter],
            Some(event) => super::supervisor::Call(self.at_once[event])
                .skills()
                .collect(),
        }
    }

    /// A letter as a person writes it: `Left`, or `Left & Down` for an event of several skills.
    pub fn text(&self, letter: usize, skills: &Skills) -> String {
        match letter.checked_sub(self.skills) {
            None => skills.skills[letter].name.clone(),
            Some(event) => super::supervisor::Call(self.at_once[event]).text(skills),
        }
    }

    fn letter(&self, event: &Event) -> usize {
        match event.0.as_slice() {
            [skill] => *skill,
            _ => {
                let place = self.at_once.binary_search(&mask(event));
                self.skills + place.expect("an event of these rules; please report this")
            }
        }
    }

    /// For every letter, whether it is one of these events.
    fn set(&self, events: &[Event]) -> Vec<bool> {
        let mut set = vec![false; self.len()];
        for event in events {
            set[self.letter(event)] = true;
        }
        set
    }
}

impl Kind {
    /// Calls `seen` with every event in it; those of regular expressions are none.
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
    /// Over the letters of an [`Alphabet`]. Its state 0 is not always the start.
    pub dfa: Dfa,
    /// Where it may be at the start, ascending: more than one state where the initial situation does not say what was called last.
    pub starts: Vec<u32>,
}

/// The automaton of a rule.
///
/// # Errors
/// When it would have more than [`MOST_STATES`] states.
pub fn automaton(rule: &Rule, skills: &Skills, alphabet: &Alphabet) -> Result<Automaton, TooLarge> {
    let letters = alphabet.len();
    let set = |events: &[Event]| alphabet.set(events);
    // Whether one of these counts as called at the start.
    let called = |events: &[Event]| {
        events.iter().any(|e| match e.0.as_slice() {
            [skill] => {
                let skill = &skills.skills[*skill];
                skill.effect == Some(skills.components[skill.component].initial)
            }
            _ => false,
        })
    };
    match &rule.kind {
        Kind::Never(never) => {
            let never = set(never);
            one(letters, &[()], |(), l| (!never[l]).then_some(()))
        }
        Kind::After { from, until, never } => {
            let starts = opened(called(from), called(until));
            let (from, until, never) = (set(from), set(until), set(never));
            one(letters, &starts, |open, l| {
                (!(*open && never[l])).then(|| from[l] || *open && !until[l])
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
            let starts = if from.is_empty() {
                vec![true]
            } else {
                opened(called(from), called(until))
            };
            let starts: Vec<Option<u32>> = { starts.into_iter() }
                .map(|open| open.then_some(0))
                .collect();
            let (of, from, until) = (set(of), set(from), set(until));
            one(letters, &starts, |counted, l| {
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
            })
        }
        Kind::InARow(words) => in_a_row(words, alphabet),
        Kind::Sequence(regex) => sequence(regex, skills, letters),
    }
}

/// Whether a window stands open at the start: both where it may have been opened or closed last.
fn opened(from: bool, until: bool) -> Vec<bool> {
    match (from, until) {
        (true, true) => vec![false, true],
        (open, _) => vec![open],
    }
}

/// An automaton all of whose states are complete, with several starts.
fn one<S: Clone + Ord>(
    letters: usize,
    starts: &[S],
    step: impl Fn(&S, usize) -> Option<S>,
) -> Result<Automaton, TooLarge> {
    let explored = Dfa::explore_all(letters, starts, MOST_STATES, step, |_| true)?;
    Ok(Automaton {
        dfa: explored.dfa,
        starts: explored.starts,
    })
}

/// Where in each word one is: the ends of what was called that begin a word (Aho and Corasick, "Efficient string matching", 1975, by
/// sets).
fn in_a_row(words: &[Vec<Vec<Event>>], alphabet: &Alphabet) -> Result<Automaton, TooLarge> {
    let words: Vec<Vec<Vec<bool>>> = words
        .iter()
        .map(|word| word.iter().map(|place| alphabet.set(place)).collect())
        .collect();
    // An event of several skills comes beside its skills, and is not what follows them; only words that speak of it see it.
    let mut spoken = vec![false; alphabet.len()];
    spoken[..alphabet.skills].fill(true);
    for place in words.iter().flatten() {
        for (letter, is) in place.iter().enumerate() {
            spoken[letter] |= is;
        }
    }
    one(
        alphabet.len(),
        &[Vec::new()],
        |reached: &Vec<(usize, usize)>, letter| {
            if !spoken[letter] {
                return Some(reached.clone());
            }
            let mut next = Vec::new();
            let starts = (0..words.len()).map(|w| (w, 0));
            for (word, at) in reached.iter().copied().chain(starts) {
                if words[word][at][letter] {
                    if at + 1 == words[word].len() {
                        return None;
                    }
                    next.push((word, at + 1));
                }
            }
            next.sort_unstable();
            next.dedup();
            Some(next)
        },
    )
}

/// The beginnings of the words of a regular expression. An event of several skills changes nothing here.
fn sequence(regex: &Regex, skills: &Skills, letters: usize) -> Result<Automaton, TooLarge> {
    let dfa = regex::automaton(regex, skills.skills.len(), MOST_STATES)?;
    let count = skills.skills.len();
    let step = |state: &u32, letter: usize| {
        if letter >= count {
            return Some(*state);
        }
        let to = dfa.next(*state, letter);
        (to != super::dfa::REFUSED).then_some(to)
    };
    let dfa = Dfa::explore(letters, 0, MOST_STATES, step, |s| dfa.is_complete(*s))?;
    Ok(Automaton {
        dfa,
        starts: vec![0],
    })
}
