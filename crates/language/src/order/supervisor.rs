//! What may be called when: the rules of a level, read call by call.
//!
//! A [`Supervisor`] answers each call with the state after it or with why it is refused, in the
//! sense of Ramadge and Wonham, "Supervisory control of a class of discrete event processes"
//! (1987): it allows and forbids, and calls nothing itself. It works out states as they are asked
//! for; [`super::fsm`] works out all of them.

use super::rule::{self, Alphabet, Automaton};
use super::serial::{Known, Serial};
use super::{Level, Serialisation, Skills, standing};
use linewright_automata::bound::TooLarge;
use linewright_automata::dfa::{Dfa, REFUSED};
use linewright_core::deadline::Deadline;

/// One skill or several called at once, as a mask over [`Skills::skills`]. Never 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Call(pub u64);

impl Call {
    /// One skill.
    pub fn one(skill: usize) -> Self {
        Self(1 << skill)
    }

    /// Its skills in ascending order.
    pub fn skills(self) -> impl Iterator<Item = usize> {
        (0..u64::BITS as usize).filter(move |s| self.0 >> s & 1 == 1)
    }

    /// As a person writes it: `Left & Down`.
    pub fn text(self, skills: &Skills) -> String {
        let names = self.skills().map(|s| skills.skills[s].name.as_str());
        names.collect::<Vec<_>>().join(" & ")
    }
}

/// Which calls are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// The rules of this level and those before it.
    pub level: Level,
    /// When several skills at once are allowed.
    pub serialisation: Serialisation,
    /// Rules that list the transitions that a published model deletes are replaced by these
    /// deletions.
    pub paper: bool,
    /// When to give up.
    pub until: Deadline,
}

impl Options {
    /// In words, behind the name of the skills: `at the level valid`.
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

/// What is known after some calls.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct State {
    /// The situation of each component.
    pub situation: Vec<usize>,
    /// What is known of the automata.
    pub known: Vec<Known>,
}

/// Why a call is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// Two skills of one component at once.
    SameComponent {
        /// The component.
        component: usize,
        /// Two of its skills.
        skills: [usize; 2],
    },
    /// A skill whose component is where it leads already, at the level reasonable.
    Recall {
        /// The skill.
        skill: usize,
    },
    /// A rule.
    Rule {
        /// By its place in [`Skills::rules`].
        rule: usize,
        /// The order of calling them one after the other that it refuses, up to the skill that it
        /// refuses; events of several skills are left out.
        order: Vec<usize>,
    },
    /// A deleted transition.
    Deleted {
        /// The rule that lists it.
        rule: usize,
    },
}

/// The automata that calls are put to.
#[derive(Debug, Clone)]
enum Automata {
    /// One a rule: (place of the rule, its automaton).
    Each(Vec<(usize, Serial)>),
    /// All rules together, since one order has to suit all of them: the rules, their states in each
    /// state of the product, and the product.
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
    /// The rules whose deletions hold.
    deleting: Vec<usize>,
    /// For every component, whether where it stands decides what is allowed.
    decides: Vec<bool>,
    /// Whether only those are followed that do.
    lean: bool,
}

impl<'a> Supervisor<'a> {
    /// The rules of a level.
    ///
    /// # Errors
    /// When a rule's automaton is too large, or the product where one is needed.
    pub fn new(skills: &'a Skills, options: Options) -> Result<Self, TooLarge> {
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

    /// The same, but components whose situation decides nothing are taken to stay where they are.
    /// The same calls are allowed, in fewer states.
    #[must_use]
    pub fn lean(mut self) -> Self {
        self.lean = true;
        self
    }

    /// As much of a state as decides what is allowed from there on.
    pub fn essence(&self, state: &State) -> State {
        let situation = state.situation.iter().zip(&self.decides);
        State {
            situation: situation
                .map(|(s, decides)| if *decides { *s } else { 0 })
                .collect(),
            known: state.known.clone(),
        }
    }

    /// The skills.
    pub fn skills(&self) -> &'a Skills {
        self.skills
    }

    /// What it allows and refuses.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Before the first call.
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

    /// Where the components stand after a call, whether or not it is allowed.
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

    /// The state after a call, or why it is refused.
    ///
    /// # Errors
    /// When one rule speaks of too many of its skills.
    pub fn call(&mut self, state: &State, call: Call) -> Result<Result<State, Refusal>, TooLarge> {
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

    /// Whether a program may end here: no sequence is in the middle of a word.
    pub fn is_complete(&self, state: &State) -> bool {
        match &self.automata {
            Automata::Each(each) => {
                let mut automata = each.iter().zip(&state.known);
                automata.all(|((_, serial), known)| serial.is_complete(*known))
            }
            Automata::Together { product, .. } => product.is_complete(state.known[0]),
        }
    }

    /// The rules that a program must not leave here, by their places: sequences in the middle of a
    /// word. Where one order has to suit, those that every order leaves there; if there are none,
    /// those that some order does.
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

/// The rule that refuses first when these letters come in the given order, and the letters up to
/// there.
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

/// The product of all rules, for what one order has to suit.
fn together(
    each: Vec<(usize, Automaton)>,
    letters: usize,
    until: Deadline,
) -> Result<Automata, TooLarge> {
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
