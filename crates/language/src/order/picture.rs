//! The automaton of a set of rules as graphs: flat, with one state per situation and rule states,
//! or by component, like the paper's hierarchical machine.
//!
//! By component, every component and every rule is a separate region, side by side (Harel,
//! "Statecharts", 1987). The number of states is then the sum and not the product: a call is
//! allowed if every region allows it.

use super::fsm::Fsm;
use super::rule::{self, Alphabet};
use super::supervisor::{Call, Options};
use super::{Level, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::REFUSED;
use linewright_core::drawing::{Edge, Graph, Region};
use std::collections::BTreeMap;

/// Maximum number of calls in an edge label; longer lists are truncated, and the JSON has them all.
const MOST_LINES: usize = 4;

/// Maximum line width; longer lines are broken.
const WIDTH: usize = 40;

/// Returns the graph of all states.
pub fn graph(skills: &Skills, fsm: &Fsm) -> Graph {
    let states = fsm.states.iter().enumerate().map(|(number, state)| {
        let mut label = vec![format!("S{number}")];
        let situation = skills.situation(&state.situation);
        if !situation.is_empty() {
            label.push(situation);
        }
        if !fsm.dfa.is_complete(number as u32) {
            label.push("in the middle of a sequence".to_owned());
        }
        label
    });
    let begin = Edge {
        from: None,
        to: 0,
        label: Vec::new(),
    };
    let edges = fsm.transitions().into_iter().map(|t| Edge {
        from: Some(t.from),
        to: t.to,
        label: lines(t.calls.iter().map(|c| c.text(skills))),
    });
    Graph {
        states: states.collect(),
        edges: [begin].into_iter().chain(edges).collect(),
    }
}

/// Joins texts to lines of limited width, and truncates them.
fn lines(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for text in texts {
        match lines.last_mut() {
            Some(line) if line.len() + text.len() < WIDTH => {
                line.push_str(", ");
                line.push_str(&text);
            }
            _ => lines.push(text),
        }
    }
    if lines.len() > MOST_LINES {
        let more = lines.len() - MOST_LINES;
        lines.truncate(MOST_LINES);
        lines.push(format!("... {more} lines more"));
    }
    lines
}

/// Returns one region per component, and one per kept rule.
///
/// # Errors
/// When a rule's automaton is too large.
pub fn regions(skills: &Skills, options: Options) -> Result<Vec<Region>, BoundExceeded> {
    let mut regions = Vec::new();
    for (number, component) in skills.components.iter().enumerate() {
        regions.push(Region {
            title: component.name.clone(),
            graph: of_component(skills, number, options.level),
        });
    }
    let alphabet = Alphabet::of(skills);
    for rule in skills.rules.iter().filter(|r| r.level <= options.level) {
        let automaton = rule::automaton(rule, skills, &alphabet, options.until)?;
        regions.push(Region {
            title: rule.name.clone(),
            graph: of_rule(skills, &alphabet, &automaton),
        });
    }
    Ok(regions)
}

fn of_component(skills: &Skills, number: usize, level: Level) -> Graph {
    let component = &skills.components[number];
    let own: Vec<_> = skills
        .skills
        .iter()
        .filter(|s| s.component == number)
        .collect();
    let count = component.situations.len().max(1);
    let mut edges = vec![Edge {
        from: None,
        to: component.initial,
        label: Vec::new(),
    }];
    for from in 0..count {
        let mut to: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for skill in &own {
            let target = skill.effect.unwrap_or(from);
            let is_recall = skill.effect == Some(from);
            if !(is_recall && level >= Level::Reasonable) {
                to.entry(target).or_default().push(skill.name.clone());
            }
        }
        edges.extend(to.into_iter().map(|(to, names)| Edge {
            from: Some(from),
            to,
            label: lines(names.into_iter()),
        }));
    }
    let states = match component.situations.as_slice() {
        [] => vec![vec![component.name.clone()]],
        some => some.iter().map(|s| vec![s.clone()]).collect(),
    };
    Graph { states, edges }
}

/// Returns the graph of a rule: its refusals in each state, and its transitions; calls that change
/// nothing are omitted.
fn of_rule(skills: &Skills, alphabet: &Alphabet, automaton: &rule::Automaton) -> Graph {
    let dfa = &automaton.dfa;
    let letter = |letter: usize| alphabet.text(letter, skills);
    let mut states = Vec::new();
    let mut edges: Vec<Edge> = automaton
        .starts
        .iter()
        .map(|start| Edge {
            from: None,
            to: *start as usize,
            label: Vec::new(),
        })
        .collect();
    for state in 0..dfa.states() {
        let mut refused = Vec::new();
        let mut to: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for l in 0..dfa.letters() {
            match dfa.next(state as u32, l) {
                REFUSED => refused.push(letter(l)),
                same if same as usize == state => {}
                other => to.entry(other as usize).or_default().push(letter(l)),
            }
        }
        let mut label = vec![format!("{state}")];
        if !refused.is_empty() {
            let mut refused = lines(refused.into_iter());
            refused[0].insert_str(0, "refuses ");
            label.extend(refused);
        }
        let over = automaton.over[state];
        if over as usize != state {
            let label = "the call is over".to_owned();
            to.entry(over as usize).or_default().push(label);
        }
        states.push(label);
        edges.extend(to.into_iter().map(|(to, names)| Edge {
            from: Some(state),
            to,
            label: lines(names.into_iter()),
        }));
    }
    Graph { states, edges }
}

/// Returns the calls of a transition, as lists of names.
pub fn names(skills: &Skills, calls: &[Call]) -> Vec<Vec<String>> {
    let of = |call: &Call| {
        call.skills()
            .map(|s| skills.skills[s].name.clone())
            .collect()
    };
    calls.iter().map(of).collect()
}
