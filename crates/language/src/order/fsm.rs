//! The automaton of a set of rules. A state combines the situation of each component with the state
//! of each rule; the transitions are the allowed calls.

use super::Skills;
use super::supervisor::{Call, Options, State, Supervisor};
use linewright_automata::bound::{BoundExceeded, ExplorationBound};
use linewright_automata::dfa::{Dfa, REFUSED};
use linewright_automata::search::shortest;
use std::collections::BTreeMap;

/// Maximum number of columns of an automaton. Each column is a call of one skill or of several
/// skills at once.
pub const MAX_CALLS: usize = 4096;

/// Maximum number of entries of an automaton's table.
pub const MAX_ENTRIES: usize = 1 << 24;

/// Returns the calls of up to `most` skills at once. The single skills come first, then calls of
/// two skills, and so on; calls of equal size are in ascending order of their masks. No call
/// contains two skills of one component. Stops at a smaller size if there would be more than
/// [`MAX_CALLS`] calls.
pub fn calls(skills: &Skills, most: usize) -> Vec<Call> {
    let own: Vec<u64> = skills
        .components
        .iter()
        .enumerate()
        .map(|(c, _)| {
            let own = skills.skills.iter().enumerate();
            own.filter(|(_, s)| s.component == c)
                .fold(0, |mask, (s, _)| mask | 1 << s)
        })
        .collect();
    let count = skills.skills.len();
    let mut all: Vec<Call> = (0..count).map(Call::one).collect();
    let mut last = all.clone();
    for _ in 1..most {
        let mut larger = Vec::new();
        for call in &last {
            // Only skills with a larger index are added, so that each set is found once.
            let above = call.0.ilog2() as usize + 1;
            for skill in above..count {
                let component = skills.skills[skill].component;
                if call.0 & own[component] == 0 {
                    larger.push(Call(call.0 | 1 << skill));
                }
            }
            if all.len() + larger.len() > MAX_CALLS {
                return all;
            }
        }
        if larger.is_empty() {
            break;
        }
        larger.sort_unstable();
        all.extend(&larger);
        last = larger;
    }
    all
}

/// Returns the calls that rules distinguish: the single skills, each combination of simultaneous
/// skills that a rule mentions, and any two of these at once. They are in the order of [`calls`].
/// The pairs are omitted if there would be more than [`MAX_CALLS`] calls.
pub fn distinguished_calls(skills: &Skills) -> Vec<Call> {
    let count = skills.skills.len();
    let mut parts: Vec<u64> = (0..count).map(|s| 1 << s).collect();
    for rule in &skills.rules {
        rule.kind.for_each_event(&mut |event| {
            parts.push(event.0.iter().fold(0, |mask, skill| mask | 1 << skill));
        });
    }
    parts.sort_unstable();
    parts.dedup();
    let fits = |mask: &u64| {
        let mut seen = vec![false; skills.components.len()];
        let mut own = Call(*mask).skills().map(|s| skills.skills[s].component);
        own.all(|c| !std::mem::replace(&mut seen[c], true))
    };
    let both = parts.iter().flat_map(|a| parts.iter().map(move |b| a | b));
    let mut all: Vec<u64> = both.filter(fits).collect();
    all.sort_unstable_by_key(|mask| (mask.count_ones(), *mask));
    all.dedup();
    if all.len() > MAX_CALLS {
        all.retain(|mask| parts.binary_search(mask).is_ok());
    }
    all.into_iter().map(Call).collect()
}

/// Returns whether `calls`, which the function [`calls`] returned for `most`, is incomplete because
/// there would have been too many calls.
pub fn is_truncated(calls: &[Call], skills: &Skills, most: usize) -> bool {
    let used = |c: usize| skills.skills.iter().any(|s| s.component == c);
    let components = (0..skills.components.len()).filter(|c| used(*c)).count();
    let known = calls.iter().map(|c| c.skills().count()).max().unwrap_or(0);
    known < most.min(components)
}

/// Automaton of a skill set: all states that are reachable from the start.
#[derive(Debug, Clone)]
pub struct Fsm {
    /// Columns; see [`calls`].
    pub calls: Vec<Call>,
    /// States; the first is the start.
    pub states: Vec<State>,
    /// Transitions, as an automaton whose letters are the columns.
    pub dfa: Dfa,
}

/// All transitions from one state to another, represented by their minimal calls: a call is omitted
/// if some of its skills alone are a call with the same target state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transition {
    /// Source state.
    pub from: usize,
    /// Target state.
    pub to: usize,
    /// Minimal calls, in the order of the columns; at least one.
    pub calls: Vec<Call>,
}

impl Fsm {
    /// Explores the states of a supervisor under these calls.
    ///
    /// # Errors
    /// When the table would have more than [`MAX_ENTRIES`] entries, or the deadline has passed.
    pub fn explore(
        supervisor: &mut Supervisor<'_>,
        calls: Vec<Call>,
    ) -> Result<Self, BoundExceeded> {
        Self::explore_within(supervisor, calls, MAX_ENTRIES)
    }

    /// Like [`explore`](Self::explore), with at most `entries` entries in the table.
    ///
    /// # Errors
    /// When the table would have more entries, or the deadline has passed.
    pub fn explore_within(
        supervisor: &mut Supervisor<'_>,
        calls: Vec<Call>,
        entries: usize,
    ) -> Result<Self, BoundExceeded> {
        let limit = entries / calls.len().max(1);
        let start = supervisor.start();
        let until = supervisor.options().until;
        let mut too_large = None;
        // Completeness is checked afterwards, because exploring needs exclusive access to the
        // supervisor.
        let explored = Dfa::explore_all(
            calls.len(),
            &[start],
            ExplorationBound::new(limit, until),
            |state, column| match supervisor.call(state, calls[column]) {
                Ok(after) => after.ok(),
                Err(error) => {
                    too_large = Some(error);
                    None
                }
            },
            |_| true,
        )?;
        if let Some(error) = too_large {
            return Err(error);
        }
        let complete: Vec<bool> = explored
            .states
            .iter()
            .map(|s| supervisor.is_complete(s))
            .collect();
        Ok(Self {
            calls,
            states: explored.states,
            dfa: explored.dfa.with_complete(complete),
        })
    }

    /// Explores the automaton of a skill set, with calls of at most `most` skills at once.
    ///
    /// # Errors
    /// When the automaton is too large, or the deadline has passed.
    pub fn of(skills: &Skills, options: Options, most: usize) -> Result<Self, BoundExceeded> {
        let mut supervisor = Supervisor::new(skills, options)?;
        Self::explore(&mut supervisor, calls(skills, most))
    }

    /// Like [`of`](Self::of), but does not track components whose situation has no influence on
    /// what is allowed: the automaton has fewer states, and accepts the same words.
    ///
    /// # Errors
    /// When the automaton is too large, or the deadline has passed.
    pub fn of_language(
        skills: &Skills,
        options: Options,
        most: usize,
    ) -> Result<Self, BoundExceeded> {
        let mut supervisor = Supervisor::new(skills, options)?.track_relevant_only();
        Self::explore(&mut supervisor, calls(skills, most))
    }

    /// Returns the automaton restricted to calls of single skills; its letters are the skills.
    ///
    /// # Panics
    /// Never: the first columns are the single skills.
    pub fn one_by_one(&self) -> Dfa {
        let singles = self.calls.iter().filter(|c| c.0.is_power_of_two()).count();
        let step = |state: &u32, skill: usize| self.dfa.step(*state, skill);
        Dfa::explore(singles, 0, self.states.len(), step, |s| {
            self.dfa.is_complete(*s)
        })
        .expect("no more states than before; please report this")
    }

    /// Returns a shortest sequence of calls that leads to a state.
    pub fn path_to(&self, state: usize) -> Vec<Call> {
        let successors = |from: &u32| {
            let columns = self.calls.iter().enumerate();
            let to = columns.map(|(column, call)| (*call, self.dfa.next(*from, column)));
            to.filter(|(_, to)| *to != REFUSED).collect()
        };
        let way = shortest(0, successors, |s| *s as usize == state);
        way.expect("a state was not reached; please report this")
    }

    /// Returns the transitions, sorted by `from`, then by `to`. There is at most one for each pair
    /// of states, regardless of the number of calls. Brandenbourger et al. count transitions in
    /// this way.
    pub fn transitions(&self) -> Vec<Transition> {
        let mut between: BTreeMap<(usize, usize), Vec<Call>> = BTreeMap::new();
        for from in 0..self.states.len() {
            for (column, call) in self.calls.iter().enumerate() {
                let to = self.dfa.next(from as u32, column);
                if to == REFUSED {
                    continue;
                }
                let calls = between.entry((from, to as usize)).or_default();
                // Smaller calls come first, so it suffices to compare with the earlier ones.
                if calls.iter().all(|c| c.0 & call.0 != c.0) {
                    calls.push(*call);
                }
            }
        }
        let transitions = between.into_iter();
        transitions
            .map(|((from, to), calls)| Transition { from, to, calls })
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::order::{Component, Deletion, Event, Kind, Level, Rule, Serialisation, Skill};
    use linewright_core::source::Span;

    /// Returns skills of components with two situations each; the first one is initial.
    pub fn two_each(components: &[(&str, [(&str, &str); 2])]) -> Skills {
        let mut skills = Skills {
            name: "Unit".to_owned(),
            doc: String::new(),
            components: Vec::new(),
            skills: Vec::new(),
            rules: Vec::new(),
            span: Span::default(),
        };
        for (component, (name, both)) in components.iter().enumerate() {
            skills.components.push(Component {
                name: (*name).to_owned(),
                doc: String::new(),
                situations: both.iter().map(|(_, s)| (*s).to_owned()).collect(),
                initial: 0,
                span: Span::default(),
            });
            for (effect, (skill, _)) in both.iter().enumerate() {
                skills.skills.push(Skill {
                    name: (*skill).to_owned(),
                    doc: String::new(),
                    component,
                    effect: Some(effect),
                    span: Span::default(),
                });
            }
        }
        skills
    }

    pub const LEFT: usize = 0;
    pub const RIGHT: usize = 1;
    pub const UP: usize = 2;
    pub const DOWN: usize = 3;
    pub const RELEASE: usize = 4;

    pub fn rule(name: &str, kind: Kind) -> Rule {
        Rule {
            name: name.to_owned(),
            requirement: None,
            doc: String::new(),
            level: Level::Valid,
            kind,
            deletions: Vec::new(),
            span: Span::default(),
            text: String::new(),
        }
    }

    pub fn events(skills: &[usize]) -> Vec<Event> {
        skills.iter().map(|s| Event(vec![*s])).collect()
    }

    /// Returns the paper's pick-and-place unit, with its two rules.
    pub fn pick_and_place() -> Skills {
        let mut skills = two_each(&[
            ("x", [("Left", "left"), ("Right", "right")]),
            ("z", [("Up", "up"), ("Down", "down")]),
            ("gripper", [("Release", "open"), ("Grip", "closed")]),
        ]);
        let (x, z, gripper) = (0, 1, 2);
        let delete = |from: &[(usize, usize)], to: &[(usize, usize)]| Deletion {
            from: from.to_vec(),
            to: to.to_vec(),
        };
        skills.rules = vec![
            Rule {
                deletions: vec![
                    delete(&[(z, 1), (x, 0)], &[(x, 1)]),
                    delete(&[(z, 1), (x, 1)], &[(x, 0)]),
                ],
                ..rule(
                    "trays",
                    Kind::After {
                        from: events(&[DOWN]),
                        until: events(&[UP]),
                        never: events(&[LEFT, RIGHT]),
                    },
                )
            },
            Rule {
                deletions: vec![
                    delete(&[(z, 0), (gripper, 1)], &[(gripper, 0)]),
                    delete(&[(z, 1), (gripper, 1)], &[(z, 0), (gripper, 0)]),
                ],
                ..rule(
                    "transport",
                    Kind::After {
                        from: events(&[UP]),
                        until: events(&[DOWN]),
                        never: events(&[RELEASE]),
                    },
                )
            },
        ];
        skills
    }

    fn counts(rules: &[usize], options: Options) -> (usize, usize) {
        let mut skills = pick_and_place();
        skills.rules = rules.iter().map(|r| skills.rules[*r].clone()).collect();
        let fsm = Fsm::of(&skills, options, 3).expect("it is small");
        (fsm.states.len(), fsm.transitions().len())
    }

    /// Numbers of states and transitions of the paper's automata (`facts/other-seeds.md`).
    #[test]
    fn the_papers_unit_has_the_published_number_of_transitions() {
        let every = Options::default();
        let paper = Options {
            paper: true,
            ..every
        };
        let rules: [&[usize]; 4] = [&[], &[0], &[1], &[0, 1]];
        let of = |options| rules.map(|rules| counts(rules, options));
        assert_eq!(of(every), [(8, 64), (8, 40), (8, 52), (8, 32)]);
        assert_eq!(of(paper), [(8, 64), (8, 48), (8, 52), (8, 38)]);
        // Situations that deletions mention are tracked, even if irrelevant situations are not.
        let skills = pick_and_place();
        for (options, states) in [(every, 2), (paper, 8)] {
            let whole = Fsm::of(&skills, options, 3).expect("it is small");
            let reduced = Fsm::of_language(&skills, options, 3).expect("it is small");
            assert_eq!(reduced.states.len(), states);
            assert_eq!(reduced.dfa.difference(&whole.dfa), None);
        }
    }

    #[test]
    fn one_order_allows_more_than_every_order() {
        let options = Options {
            serialisation: Serialisation::Some,
            ..Options::default()
        };
        // `Down` and then `Right` is refused, `Right` and then `Down` is allowed.
        let (_, some) = counts(&[0], options);
        assert!(some > 40, "{some}");
    }

    #[test]
    fn all_combinations_of_skills_of_different_components_are_called() {
        assert_eq!(calls(&pick_and_place(), 3).len(), 26);
        assert_eq!(calls(&pick_and_place(), 2).len(), 18);
        assert_eq!(calls(&pick_and_place(), 1).len(), 6);
    }
}
