//! Decides which calls are allowed: evaluates the rules of a level call by call.
//!
//! A [`Supervisor`] answers each call with the state after the call or the reason why it is
//! refused. It is a supervisor in the sense of Ramadge and Wonham, "Supervisory control of a class
//! of discrete event processes" (1987): it allows and forbids calls, but makes none itself. It
//! computes states on demand; [`super::fsm`] computes all of them.

use super::rule::{self, Alphabet, Automaton};
use super::serial::{Serial, StateSetId};
use super::{Level, Serialisation, Skills, standing};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::{Dfa, REFUSED};
use linewright_core::deadline::Deadline;

/// One skill, or several called at once, as a mask over [`Skills::skills`]. Never 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Call(pub u64);

impl Call {
    /// Creates a call of one skill.
    pub fn one(skill: usize) -> Self {
        Self(1 << skill)
    }

    /// Returns the skills of the call in ascending order.
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
    /// Level: its rules and those of the lower levels apply.
    pub level: Level,
    /// Condition under which several skills called at once are allowed.
    pub serialisation: Serialisation,
    /// Whether to reproduce a published model, which deletes transitions instead of applying rules.
    /// A rule that lists such deletions is then replaced by them.
    pub paper: bool,
    /// Deadline of the computation.
    pub until: Deadline,
}

impl Options {
    /// Formats the options: `at the level valid`.
    pub fn text(&self) -> String {
        let mut text = format!("at the level {}", self.level.keyword());
        if self.serialisation == Serialisation::Some {
            text.push_str(", several skills at once if some order of them is allowed");
        }
        if self.paper {
            text.push_str(", with the deletions of a published model instead of its rules");
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
    /// For each rule that applies, the number of the set of states in which its automaton can be.
    /// With [`Serialisation::Some`], there is a single number for all rules together.
    pub rule_states: Vec<StateSetId>,
}

/// Reason why a call is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// Two skills of one component at once.
    SameComponent {
        /// Index of the component.
        component: usize,
        /// Two of its skills that are called, by index.
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
        /// An order of the skills that the rule refuses, up to the refused skill. Events of several
        /// skills are omitted.
        order: Vec<usize>,
    },
    /// A published model deletes the transition.
    Deleted {
        /// Index of the rule that lists the deletion in [`Skills::rules`].
        rule: usize,
    },
}

/// Automata of the rules.
#[derive(Debug, Clone)]
enum Automata {
    /// One automaton per rule: (index of the rule, automaton).
    Each(Vec<(usize, Serial)>),
    /// One product for all rules, because all of them have to allow the same order. Contains the
    /// indices of the rules, their automata, their states in each state of the product, and the
    /// product itself.
    Together {
        rules: Vec<usize>,
        parts: Vec<Dfa>,
        states: Vec<Vec<u32>>,
        product: Box<Serial>,
    },
}

/// Decides which calls the rules of a level allow.
#[derive(Debug, Clone)]
pub struct Supervisor<'a> {
    skills: &'a Skills,
    options: Options,
    alphabet: Alphabet,
    automata: Automata,
    /// Indices of the rules that are replaced by their deletions.
    deleting: Vec<usize>,
    /// For every component, whether its situation has an influence on what is allowed.
    is_relevant: Vec<bool>,
    /// Whether only relevant components are tracked.
    relevant_only: bool,
}

impl<'a> Supervisor<'a> {
    /// Creates a supervisor with the rules of a level.
    ///
    /// # Errors
    /// When the automaton of a rule is too large, or the product of all rules if it is needed.
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
            Serialisation::Some => product_of(each, alphabet.len(), options.until)?,
        };
        let deleting: Vec<usize> = deleting.into_iter().map(|(place, _)| place).collect();
        let mut is_relevant = vec![options.level >= Level::Reasonable; skills.components.len()];
        for deletion in deleting.iter().flat_map(|r| &skills.rules[*r].deletions) {
            for (component, _) in deletion.from.iter().chain(&deletion.to) {
                is_relevant[*component] = true;
            }
        }
        Ok(Self {
            skills,
            options,
            alphabet,
            automata,
            deleting,
            is_relevant,
            relevant_only: false,
        })
    }

    /// Tracks only components whose situation has an influence on what is allowed: the same calls
    /// are allowed, with fewer states.
    #[must_use]
    pub fn track_relevant_only(mut self) -> Self {
        self.relevant_only = true;
        self
    }

    /// Returns the state with the situations of irrelevant components set to 0. Two states with the
    /// same result allow the same sequences of calls.
    pub fn relevant_part(&self, state: &State) -> State {
        let situation = state.situation.iter().zip(&self.is_relevant);
        State {
            situation: situation
                .map(|(s, is_relevant)| if *is_relevant { *s } else { 0 })
                .collect(),
            rule_states: state.rule_states.clone(),
        }
    }

    /// Returns the skill set.
    pub fn skills(&self) -> &'a Skills {
        self.skills
    }

    /// Returns the options.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Returns the state before the first call.
    pub fn start(&self) -> State {
        let rule_states = match &self.automata {
            Automata::Each(each) => vec![0; each.len()],
            Automata::Together { .. } => vec![0],
        };
        State {
            situation: self.skills.components.iter().map(|c| c.initial).collect(),
            rule_states,
        }
    }

    /// Returns the situations of the components after a call, whether or not it is allowed.
    pub fn situation_after(&self, state: &State, call: Call) -> Vec<usize> {
        let mut situation = state.situation.clone();
        for skill in call.skills() {
            let skill = &self.skills.skills[skill];
            if let Some(effect) = skill.effect {
                situation[skill.component] = effect;
            }
        }
        situation
    }

    /// Returns the state after a call, or the reason why the call is refused.
    ///
    /// # Errors
    /// When one rule mentions more than [`MAX_AT_ONCE`](super::serial::MAX_AT_ONCE) of the call's
    /// skills and events.
    pub fn call(
        &mut self,
        state: &State,
        call: Call,
    ) -> Result<Result<State, Refusal>, BoundExceeded> {
        if let Some(refusal) = self.refused_by_components(state, call) {
            return Ok(Err(refusal));
        }
        let letters = self.alphabet.letters(call.0);
        let mut rule_states = Vec::with_capacity(state.rule_states.len());
        match &mut self.automata {
            Automata::Each(each) => {
                for ((rule, serial), before) in each.iter_mut().zip(&state.rule_states) {
                    let Some(after) = serial.call(*before, &letters)? else {
                        let order = serial.refused_order(*before, &letters)?.unwrap_or_default();
                        let order = without_events(order, self.skills);
                        return Ok(Err(Refusal::Rule { rule: *rule, order }));
                    };
                    rule_states.push(after);
                }
            }
            Automata::Together {
                rules,
                parts,
                states,
                product,
            } => {
                let Some(after) = product.call(state.rule_states[0], &letters)? else {
                    let from = product.states(state.rule_states[0])[0];
                    let (rule, order) = first_refusal(parts, &states[from as usize], &letters);
                    let order = without_events(order, self.skills);
                    return Ok(Err(Refusal::Rule {
                        rule: rules[rule],
                        order,
                    }));
                };
                rule_states.push(after);
            }
        }
        let mut situation = self.situation_after(state, call);
        if self.relevant_only {
            for ((after, before), is_relevant) in situation
                .iter_mut()
                .zip(&state.situation)
                .zip(&self.is_relevant)
            {
                if !is_relevant {
                    *after = *before;
                }
            }
        }
        for &rule in &self.deleting {
            let deletions = &self.skills.rules[rule].deletions;
            let matches = |conditions: &[(usize, usize)], situation: &[usize]| {
                conditions
                    .iter()
                    .all(|(component, s)| situation[*component] == *s)
            };
            let deleted = deletions
                .iter()
                .any(|d| matches(&d.from, &state.situation) && matches(&d.to, &situation));
            if deleted {
                return Ok(Err(Refusal::Deleted { rule }));
            }
        }
        Ok(Ok(State {
            situation,
            rule_states,
        }))
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

    /// Returns whether a program can end in this state, because no sequence is in the middle of a
    /// word.
    pub fn is_complete(&self, state: &State) -> bool {
        match &self.automata {
            Automata::Each(each) => {
                let mut automata = each.iter().zip(&state.rule_states);
                automata.all(|((_, serial), rule_states)| serial.is_complete(*rule_states))
            }
            Automata::Together { product, .. } => product.is_complete(state.rule_states[0]),
        }
    }

    /// Returns the indices of the rules that prevent a program from ending in this state: sequences
    /// in the middle of a word. With [`Serialisation::Some`], returns the rules that are unfinished
    /// after every order; if there are none, those that are unfinished after some order.
    pub fn unfinished(&self, state: &State) -> Vec<usize> {
        match &self.automata {
            Automata::Each(each) => {
                let open = each
                    .iter()
                    .zip(&state.rule_states)
                    .filter(|((_, serial), rule_states)| !serial.is_complete(**rule_states));
                open.map(|((rule, _), _)| *rule).collect()
            }
            Automata::Together {
                rules,
                parts,
                states,
                product,
            } if !self.is_complete(state) => {
                let rule_states: Vec<_> = product
                    .states(state.rule_states[0])
                    .iter()
                    .map(|s| &states[*s as usize])
                    .collect();
                let open = |rule: usize| {
                    let states = rule_states.iter().map(move |s| s[rule]);
                    states.map(move |s| !parts[rule].is_complete(s))
                };
                let in_every_order: Vec<usize> =
                    (0..rules.len()).filter(|r| open(*r).all(|o| o)).collect();
                // Otherwise each rule can end after some order, but not all after the same one.
                let open: Vec<usize> = if in_every_order.is_empty() {
                    (0..rules.len()).filter(|r| open(*r).any(|o| o)).collect()
                } else {
                    in_every_order
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
/// up to the refused one.
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

/// Builds the product of all rules, for [`Serialisation::Some`].
fn product_of(
    each: Vec<(usize, Automaton)>,
    letters: usize,
    until: Deadline,
) -> Result<Automata, BoundExceeded> {
    let (rules, automata): (Vec<usize>, Vec<Automaton>) = each.into_iter().unzip();
    let windows: Vec<_> = automata.iter().map(|a| a.window).collect();
    let starts: Vec<Vec<u32>> = standing::joint_starts(&windows)?
        .iter()
        .map(|open| {
            automata
                .iter()
                .zip(open)
                .map(|(a, o)| a.start(*o))
                .collect()
        })
        .collect();
    let (parts, ends): (Vec<Dfa>, Vec<Vec<u32>>) =
        automata.into_iter().map(|a| (a.dfa, a.after_call)).unzip();
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
    let end_call = |state: &Vec<u32>| {
        let states = state.iter().zip(&ends);
        states
            .map(|(s, after_call)| after_call[*s as usize])
            .collect()
    };
    let (product, states) = Automaton::explore(letters, &starts, until, step, end_call, complete)?;
    Ok(Automata::Together {
        rules,
        parts,
        states,
        product: Box::new(Serial::new(product, Serialisation::Some)),
    })
}
