//! Decides which calls are allowed: evaluates the rules of a level call by call.
//!
//! A [`Supervisor`] answers each call with the state after it or the reason for refusal, in the
//! sense of Ramadge and Wonham, "Supervisory control of a class of discrete event processes"
//! (1987): it allows and forbids, and calls nothing itself. It computes states on demand;
//! [`super::fsm`] computes all of them.

use super::rule::{self, Alphabet, Automaton};
use super::serial::{Serial, StateSetId};
use super::{Level, Serialisation, Skills, standing};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::{Dfa, REFUSED};
use linewright_core::deadline::Deadline;

/// One skill or several called at once, as a mask over [`Skills::skills`]. Never 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Call(pub u64);

impl Call {
    /// Creates a call of one skill.
    pub fn one(skill: usize) -> Self {
        Self(1 << skill)
    }

    /// Returns its skills in ascending order.
    pub fn skills(self) -> impl Iterator<Item = usize> {
        (0..u64::BITS as usize).filter(move |s| self.0 >> s & 1 == 1)
    }

    /// Formats the call: `Left & Down`.
    pub fn text(self, skills: &Skills) -> String {
        let names = self.skills().map(|s| skills.skills[s].name.as_str());
        names.collect::<Vec<_>>().join(" & ")
    }
}

/// Options that determine which calls are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Level whose rules, and those of the levels before it, are kept.
    pub level: Level,
    /// When several skills at once are allowed.
    pub serialisation: Serialisation,
    /// Whether rules that list the transitions deleted by a published model are replaced by these
    /// deletions.
    pub paper: bool,
    /// Deadline of the computation.
    pub until: Deadline,
}

impl Options {
    /// Describes the options, after the name of the skills: `at the level valid`.
    pub fn text(&self) -> String {
        let mut text = format!("at the level {}", self.level.word());
        if self.serialisation == Serialisation::Some {
            text.push_str(", several skills at once where some order of them is allowed");
        }
        if self.paper {
            text.push_str(", with the transitions deleted that a published model deletes");
        }
        text
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            level: Level::Valid,
            serialisation: Serialisation::Every,
            paper: false,
            until: Deadline::NONE,
        }
    }
}

/// State after some calls.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct State {
    /// Situation of each component.
    pub situation: Vec<usize>,
    /// States of the automata.
    pub known: Vec<StateSetId>,
}

/// Reason why a call is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// Two skills of one component at once.
    SameComponent {
        /// Index of the component.
        component: usize,
        /// Two of its skills.
        skills: [usize; 2],
    },
    /// A skill whose component is already in its target situation, at the level reasonable.
    Recall {
        /// Index of the skill.
        skill: usize,
    },
    /// A rule forbids the call.
    Rule {
        /// Index in [`Skills::rules`].
        rule: usize,
        /// Order of calling the skills one after the other that the rule refuses, up to the refused
        /// skill; events of several skills are omitted.
        order: Vec<usize>,
    },
    /// The transition was deleted.
    Deleted {
        /// Rule that lists it.
        rule: usize,
    },
}

/// Automata that decide on calls.
#[derive(Debug, Clone)]
enum Automata {
    /// One per rule: (index of the rule, its automaton).
    Each(Vec<(usize, Serial)>),
    /// All rules together, since one order has to be allowed by all of them: the rules, their
    /// states in each state of the product, and the product.
    Together {
        rules: Vec<usize>,
        parts: Vec<Dfa>,
        states: Vec<Vec<u32>>,
        product: Box<Serial>,
    },
}

/// Allows and refuses calls.
#[derive(Debug, Clone)]
pub struct Supervisor<'a> {
    skills: &'a Skills,
    options: Options,
    alphabet: Alphabet,
    automata: Automata,
    /// Rules whose deletions are applied.
    deleting: Vec<usize>,
    /// For every component, whether its situation decides what is allowed.
    decides: Vec<bool>,
    /// Whether only those components are tracked.
    lean: bool,
}

impl<'a> Supervisor<'a> {
    /// Creates a supervisor with the rules of a level.
    ///
    /// # Errors
    /// When a rule's automaton is too large, or the product if one is needed.
    pub fn new(skills: &'a Skills, options: Options) -> Result<Self, BoundExceeded> {
        let alphabet = Alphabet::of(skills);
        let kept = skills
            .rules
            .iter()
            .enumerate()
            .filter(|(_, rule)| rule.level <= options.level);
        let (deleting, kept): (Vec<_>, Vec<_>) =
            kept.partition(|(_, rule)| options.paper && !rule.deletions.is_empty());
        let mut each = Vec::new();
        for (place, rule) in kept {
            each.push((
                place,
                rule::automaton(rule, skills, &alphabet, options.until)?,
            ));
        }
        let automata = match options.serialisation {
            Serialisation::Every => {
                let serial = |(place, a)| (place, Serial::new(a, Serialisation::Every));
                Automata::Each(each.into_iter().map(serial).collect())
            }
            Serialisation::Some => together(each, alphabet.len(), options.until)?,
        };
        let deleting: Vec<usize> = deleting.into_iter().map(|(place, _)| place).collect();
        let mut decides = vec![options.level >= Level::Reasonable; skills.components.len()];
        for deletion in deleting.iter().flat_map(|r| &skills.rules[*r].deletions) {
            for (component, _) in deletion.from.iter().chain(&deletion.to) {
                decides[*component] = true;
            }
        }
        Ok(Self {
            skills,
            options,
            alphabet,
            automata,
            deleting,
            decides,
            lean: false,
        })
    }

    /// Does not track components whose situation decides nothing: the same calls are allowed, with
    /// fewer states.
    #[must_use]
    pub fn lean(mut self) -> Self {
        self.lean = true;
        self
    }

    /// Returns the part of a state that decides what is allowed from there on.
    pub fn essence(&self, state: &State) -> State {
        let situation = state.situation.iter().zip(&self.decides);
        State {
            situation: situation
                .map(|(s, decides)| if *decides { *s } else { 0 })
                .collect(),
            known: state.known.clone(),
        }
    }

    /// Returns the supervised skills.
    pub fn skills(&self) -> &'a Skills {
        self.skills
    }

    /// Returns the options that determine which calls are allowed.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Returns the state before the first call.
    pub fn start(&self) -> State {
        let known = match &self.automata {
            Automata::Each(each) => vec![0; each.len()],
            Automata::Together { .. } => vec![0],
        };
        State {
            situation: self.skills.components.iter().map(|c| c.initial).collect(),
            known,
        }
    }

    /// Returns the situations of the components after a call, whether or not it is allowed.
    pub fn moved(&self, state: &State, call: Call) -> Vec<usize> {
        let mut situation = state.situation.clone();
        for skill in call.skills() {
            let skill = &self.skills.skills[skill];
            if let Some(effect) = skill.effect {
                situation[skill.component] = effect;
            }
        }
        situation
    }

    /// Returns the state after a call, or why it is refused.
    ///
    /// # Errors
    /// When one rule mentions too many of its skills.
    pub fn call(
        &mut self,
        state: &State,
        call: Call,
    ) -> Result<Result<State, Refusal>, BoundExceeded> {
        if let Some(refusal) = self.refused_by_components(state, call) {
            return Ok(Err(refusal));
        }
        let letters = self.alphabet.letters(call.0);
        let mut known = Vec::with_capacity(state.known.len());
        match &mut self.automata {
            Automata::Each(each) => {
                for ((rule, serial), before) in each.iter_mut().zip(&state.known) {
                    let Some(after) = serial.call(*before, &letters)? else {
                        let order = serial.refusing(*before, &letters)?.unwrap_or_default();
                        let order = without_events(order, self.skills);
                        return Ok(Err(Refusal::Rule { rule: *rule, order }));
                    };
                    known.push(after);
                }
            }
            Automata::Together {
                rules,
                parts,
                states,
                product,
            } => {
                let Some(after) = product.call(state.known[0], &letters)? else {
                    let from = product.states(state.known[0])[0];
                    let (rule, order) = first_refusal(parts, &states[from as usize], &letters);
                    let order = without_events(order, self.skills);
                    return Ok(Err(Refusal::Rule {
                        rule: rules[rule],
                        order,
                    }));
                };
                known.push(after);
            }
        }
        let mut situation = self.moved(state, call);
        if self.lean {
            for ((after, before), decides) in situation
                .iter_mut()
                .zip(&state.situation)
                .zip(&self.decides)
            {
                if !decides {
                    *after = *before;
                }
            }
        }
        for &rule in &self.deleting {
            let deletions = &self.skills.rules[rule].deletions;
            let stands = |at: &[(usize, usize)], in_it: &[usize]| {
                at.iter().all(|(component, s)| in_it[*component] == *s)
            };
            let deleted = deletions
                .iter()
                .any(|d| stands(&d.from, &state.situation) && stands(&d.to, &situation));
            if deleted {
                return Ok(Err(Refusal::Deleted { rule }));
            }
        }
        Ok(Ok(State { situation, known }))
    }

    fn refused_by_components(&self, state: &State, call: Call) -> Option<Refusal> {
        let mut called: Vec<Option<usize>> = vec![None; self.skills.components.len()];
        for skill in call.skills() {
            let component = self.skills.skills[skill].component;
            if let Some(other) = called[component].replace(skill) {
                return Some(Refusal::SameComponent {
                    component,
                    skills: [other, skill],
                });
            }
        }
        if self.options.level < Level::Reasonable {
            return None;
        }
        let recalled = call.skills().find(|s| {
            let skill = &self.skills.skills[*s];
            skill.effect == Some(state.situation[skill.component])
        });
        recalled.map(|skill| Refusal::Recall { skill })
    }

    /// Returns whether a program may end here: no sequence is in the middle of a word.
    pub fn is_complete(&self, state: &State) -> bool {
        match &self.automata {
            Automata::Each(each) => {
                let mut automata = each.iter().zip(&state.known);
                automata.all(|((_, serial), known)| serial.is_complete(*known))
            }
            Automata::Together { product, .. } => product.is_complete(state.known[0]),
        }
    }

    /// Returns the rules that prevent a program from ending here, by index: sequences in the middle
    /// of a word. If one order is enough, returns those unfinished after every order; if there are
    /// none, those unfinished after some order.
    pub fn unfinished(&self, state: &State) -> Vec<usize> {
        match &self.automata {
            Automata::Each(each) => {
                let open = each
                    .iter()
                    .zip(&state.known)
                    .filter(|((_, serial), known)| !serial.is_complete(**known));
                open.map(|((rule, _), _)| *rule).collect()
            }
            Automata::Together {
                rules,
                parts,
                states,
                product,
            } if !self.is_complete(state) => {
                let known: Vec<_> = product
                    .states(state.known[0])
                    .iter()
                    .map(|s| &states[*s as usize])
                    .collect();
                let open = |rule: usize| {
                    let states = known.iter().map(move |s| s[rule]);
                    states.map(move |s| !parts[rule].is_complete(s))
                };
                let whatever: Vec<usize> =
                    (0..rules.len()).filter(|r| open(*r).all(|o| o)).collect();
                // Else each can end after some order, but not all after the same one.
                let open: Vec<usize> = if whatever.is_empty() {
                    (0..rules.len()).filter(|r| open(*r).any(|o| o)).collect()
                } else {
                    whatever
                };
                open.into_iter().map(|r| rules[r]).collect()
            }
            Automata::Together { .. } => Vec::new(),
        }
    }
}

fn without_events(mut order: Vec<usize>, skills: &Skills) -> Vec<usize> {
    order.retain(|letter| *letter < skills.skills.len());
    order
}

/// Returns the rule that refuses first when these letters come in the given order, and the letters
/// up to there.
fn first_refusal(parts: &[Dfa], from: &[u32], letters: &[usize]) -> (usize, Vec<usize>) {
    let mut states = from.to_vec();
    for (at, letter) in letters.iter().enumerate() {
        for (rule, state) in states.iter_mut().enumerate() {
            *state = parts[rule].next(*state, *letter);
            if *state == REFUSED {
                return (rule, letters[..=at].to_vec());
            }
        }
    }
    (0, letters.to_vec())
}

/// Builds the product of all rules, if one order has to be allowed by all of them.
fn together(
    each: Vec<(usize, Automaton)>,
    letters: usize,
    until: Deadline,
) -> Result<Automata, BoundExceeded> {
    let (rules, automata): (Vec<usize>, Vec<Automaton>) = each.into_iter().unzip();
    let windows: Vec<_> = automata.iter().map(|a| a.window).collect();
    let starts: Vec<Vec<u32>> = standing::together(&windows)?
        .iter()
        .map(|open| {
            automata
                .iter()
                .zip(open)
                .map(|(a, o)| a.start(*o))
                .collect()
        })
        .collect();
    let (parts, overs): (Vec<Dfa>, Vec<Vec<u32>>) =
        automata.into_iter().map(|a| (a.dfa, a.over)).unzip();
    let step = |state: &Vec<u32>, letter| {
        let next = state
            .iter()
            .zip(&parts)
            .map(|(s, dfa)| dfa.next(*s, letter));
        let next: Vec<u32> = next.collect();
        (!next.contains(&REFUSED)).then_some(next)
    };
    let complete = |state: &Vec<u32>| {
        let mut states = state.iter().zip(&parts);
        states.all(|(s, dfa)| dfa.is_complete(*s))
    };
    let over = |state: &Vec<u32>| {
        let states = state.iter().zip(&overs);
        states.map(|(s, over)| over[*s as usize]).collect()
    };
    let (product, states) = Automaton::explore(letters, &starts, until, step, over, complete)?;
    Ok(Automata::Together {
        rules,
        parts,
        states,
        product: Box::new(Serial::new(product, Serialisation::Some)),
    })
}
