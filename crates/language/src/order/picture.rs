//! The automaton of a set of rules as graphs: either one flat graph of all states, or one graph for
//! each component and each rule, like the hierarchical machine of Brandenbourger et al.
//!
//! In the second form, the components and rules are parallel regions (Harel, "Statecharts", 1987),
//! and the numbers of states add up instead of multiplying: a call is allowed if every region
//! allows it.

use super::fsm::Fsm;
use super::rule::{self, Alphabet};
use super::supervisor::{Call, Options};
use super::{Level, Skills};
use linewright_automata::bound::BoundExceeded;
use linewright_automata::dfa::REFUSED;
use linewright_core::drawing::{Edge, Graph, Region};
use std::collections::BTreeMap;

/// Maximum number of lines in an edge label; longer labels are truncated. The JSON output lists all
/// calls.
const MAX_LABEL_LINES: usize = 4;

/// Maximum width of a line of a label in bytes; longer lines are broken between texts.
const WIDTH: usize = 40;

/// Returns the graph of all states.
pub fn graph(skills: &Skills, fsm: &Fsm) -> Graph {
    let states = fsm.states.iter().enumerate().map(|(number, state)| {
        let mut label = vec![format!("S{number}")];
        let situation = skills.situation_text(&state.situation);
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
        ..Graph::default()
    }
}

/// Joins texts into lines of limited width, and truncates the list of lines.
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
    if lines.len() > MAX_LABEL_LINES {
        let more = lines.len() - MAX_LABEL_LINES;
        lines.truncate(MAX_LABEL_LINES);
        lines.push(format!("... {more} more lines"));
    }
    lines
}

/// Returns one region per component, and one per rule of the level.
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
    Graph {
        states,
        edges,
        ..Graph::default()
    }
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
    for state in 0..dfa.state_count() {
        let mut refused = Vec::new();
        let mut to: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for l in 0..dfa.letter_count() {
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
        let after_call = automaton.after_call[state];
        if after_call as usize != state {
            let label = "end of the call".to_owned();
            to.entry(after_call as usize).or_default().push(label);
        }
        states.push(label);
        edges.extend(to.into_iter().map(|(to, names)| Edge {
            from: Some(state),
            to,
            label: lines(names.into_iter()),
        }));
    }
    Graph {
        states,
        edges,
        ..Graph::default()
    }
}

/// Returns calls as lists of skill names.
pub fn call_names(skills: &Skills, calls: &[Call]) -> Vec<Vec<String>> {
    let of = |call: &Call| {
        call.skills()
            .map(|s| skills.skills[s].name.clone())
            .collect()
    };
    calls.iter().map(of).collect()
}
