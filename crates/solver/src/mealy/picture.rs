//! Draws a machine as a graph, in Graphviz's language or as SVG.
//!
//! An edge is labeled `guard / assignments`. To keep labels short, outputs on which all edges into
//! a state agree are written once, in the state, and not on the edges. Transitions between the same
//! two states form one edge, and long guards are broken into lines.

use super::text::guard_parts;
use super::{Guard, Machine, Port, Transition};
use linewright_core::drawing::{Edge, Frame, Graph, dot, svg};
use linewright_core::gr1::{Domain, Specification, show_value};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Maximum number of cubes of a guard in a label; the JSON output has all of them.
const MAX_LINES: usize = 3;

/// Maximum number of output combinations in the label of an edge.
const MAX_GROUPS: usize = 3;

/// Maximum line length in characters. A single part that is longer is not broken.
const WIDTH: usize = 40;

/// Converts a machine to a graph with labeled states and edges. If there are several goals, which
/// are the justice guarantees with these names, the states that work for one of them alone are in a
/// frame.
pub fn to_graph(machine: &Machine, goals: &[&str]) -> Graph {
    let common = common_outputs(machine);
    let mut states = Vec::new();
    for (number, values) in common.iter().enumerate() {
        let mut label = vec![format!("S{number}")];
        let pairs = machine.outputs.iter().zip(values);
        let shown = pairs.filter_map(|(port, v)| v.map(|v| assignment(port, v)));
        label.extend(wrap(&shown.collect::<Vec<_>>(), ", "));
        states.push(label);
    }
    let mut edges = Vec::new();
    let lists = std::iter::once((None, &machine.initial))
        .chain(machine.states.iter().enumerate().map(|(i, t)| (Some(i), t)));
    for (from, transitions) in lists {
        // One edge per target, with one group of lines per combination of outputs.
        let mut merged: BTreeMap<usize, BTreeMap<&[i64], Vec<&Guard>>> = BTreeMap::new();
        for Transition { guard, output, to } in transitions {
            let outputs = merged.entry(*to).or_default();
            outputs.entry(output).or_default().push(guard);
        }
        for (to, outputs) in merged {
            let groups = outputs.len();
            let mut label = Vec::new();
            for (output, guards) in outputs.into_iter().take(MAX_GROUPS) {
                // An empty line separates the groups.
                if !label.is_empty() {
                    label.push(String::new());
                }
                label.extend(guard_lines(machine, &guards));
                let pairs = machine.outputs.iter().zip(output).zip(&common[to]);
                let own: Vec<String> = pairs
                    .filter(|(_, known)| known.is_none())
                    .map(|((port, v), _)| assignment(port, *v))
                    .collect();
                if !own.is_empty() {
                    let mut lines = wrap(&own, ", ");
                    lines[0].insert_str(0, "/ ");
                    label.extend(lines);
                }
            }
            if groups > MAX_GROUPS {
                label.push(format!("... {} more", groups - MAX_GROUPS));
            }
            edges.push(Edge { from, to, label });
        }
    }
    Graph {
        states,
        edges,
        frames: frames(machine, goals),
        ..Graph::default()
    }
}

/// Converts a machine to a graph of the values of some outputs: an edge leads from the values in
/// one step to different values in the next. States with the same values become one box, and guards
/// are left out. `outputs` are indices of [`Machine::outputs`].
///
/// # Panics
/// If the machine has no output with such an index.
pub fn to_graph_of_outputs(machine: &Machine, outputs: &[usize]) -> Graph {
    let values =
        |t: &Transition| -> Vec<i64> { outputs.iter().map(|output| t.output[*output]).collect() };
    let mut boxes: BTreeMap<Vec<i64>, usize> = BTreeMap::new();
    let mut states = Vec::new();
    let mut edges: BTreeSet<(Option<usize>, usize)> = BTreeSet::new();
    // Each state with the values of the step that led to it.
    let mut reached: BTreeSet<(usize, usize)> = BTreeSet::new();
    let mut left: VecDeque<(Option<usize>, &[Transition])> = [(None, &*machine.initial)].into();
    while let Some((from, transitions)) = left.pop_front() {
        for transition in transitions {
            let values = values(transition);
            let to = *boxes.entry(values.clone()).or_insert_with(|| {
                let pairs = outputs.iter().zip(&values);
                let shown = pairs.map(|(output, v)| assignment(&machine.outputs[*output], *v));
                states.push(wrap(&shown.collect::<Vec<_>>(), ", "));
                states.len() - 1
            });
            if from != Some(to) {
                edges.insert((from, to));
            }
            if reached.insert((transition.to, to)) {
                left.push_back((Some(to), &machine.states[transition.to]));
            }
        }
    }
    let edges = edges.into_iter().map(|(from, to)| Edge {
        from,
        to,
        label: Vec::new(),
    });
    Graph {
        states,
        edges: edges.collect(),
        ..Graph::default()
    }
}

/// Frames around the states that work for the same goal.
fn frames(machine: &Machine, goals: &[&str]) -> Vec<Frame> {
    if goals.len() < 2 {
        return Vec::new();
    }
    let frames = goals.iter().enumerate().map(|(goal, name)| {
        let own = machine.goals.iter().enumerate();
        let own = own.filter(|(_, goals)| **goals == [goal]);
        Frame {
            title: format!("for {name}"),
            parent: None,
            states: own.map(|(state, _)| state).collect(),
        }
    });
    frames.filter(|frame| !frame.states.is_empty()).collect()
}

/// The names of the goals of a specification: its justice guarantees.
pub fn goals(specification: &Specification) -> Vec<&str> {
    let justice = specification.guarantees.justice.iter();
    justice.map(|formula| formula.name.as_str()).collect()
}

/// Returns the graph in Graphviz's language.
pub fn to_dot(machine: &Machine) -> String {
    dot::render(&machine.name, &to_graph(machine, &[]))
}

/// Returns the graph as SVG. The specification is that of the machine; `None` for a
/// counterstrategy.
pub fn to_svg(machine: &Machine, specification: Option<&Specification>) -> String {
    let goals = specification.map_or(Vec::new(), goals);
    svg::render(&machine.name, &to_graph(machine, &goals))
}

/// Returns, for each state, the outputs on which all transitions into it agree.
fn common_outputs(machine: &Machine) -> Vec<Vec<Option<i64>>> {
    let mut common: Vec<Option<Vec<Option<i64>>>> = vec![None; machine.states.len()];
    for transition in machine
        .initial
        .iter()
        .chain(machine.states.iter().flatten())
    {
        let output = transition.output.iter().map(|v| Some(*v));
        match &mut common[transition.to] {
            Some(known) => {
                for (known, v) in known.iter_mut().zip(output) {
                    if *known != v {
                        *known = None;
                    }
                }
            }
            unknown => *unknown = Some(output.collect()),
        }
    }
    let none = vec![None; machine.outputs.len()];
    common
        .into_iter()
        .map(|c| c.unwrap_or_else(|| none.clone()))
        .collect()
}

/// Formats the value of an output: `turning`, `!turning`, `angle = 3`.
fn assignment(port: &Port, value: i64) -> String {
    let name = &port.name;
    match &port.domain {
        Domain::Bool if value == 0 => format!("!{name}"),
        Domain::Bool => name.to_owned(),
        domain => format!("{name} = {}", show_value(domain, value, &port.unit)),
    }
}

/// Formats guards with one line per cube. A line that is too long is broken.
fn guard_lines(machine: &Machine, guards: &[&Guard]) -> Vec<String> {
    let cubes = guard_parts(machine, guards);
    let mut lines = Vec::new();
    for (i, tests) in cubes.iter().take(MAX_LINES).enumerate() {
        let mut broken = if tests.is_empty() {
            vec!["true".to_owned()]
        } else {
            wrap(tests, " & ")
        };
        if i > 0 {
            broken[0].insert_str(0, "| ");
        }
        lines.extend(broken);
    }
    if cubes.len() > MAX_LINES {
        lines.push(format!("| ... {} more", cubes.len() - MAX_LINES));
    }
    lines
}

/// Joins parts with a separator into lines of at most [`WIDTH`] characters. A single part that is
/// longer is not broken.
fn wrap(parts: &[String], separator: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let mut piece = part.clone();
        if i + 1 < parts.len() {
            piece.push_str(separator);
        }
        match lines.last_mut() {
            Some(line) if line.len() + part.len() <= WIDTH => line.push_str(&piece),
            _ => lines.push(piece),
        }
    }
    for line in &mut lines {
        line.truncate(line.trim_end().len());
    }
    lines
}
