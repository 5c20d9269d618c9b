//! A machine as a graph, for Graphviz and as a picture.
//!
//! An edge is labelled `guard / assignments`. To keep labels short, an output is written on an edge
//! only if the state it enters does not already show it: outputs on which all edges into a state
//! agree are written once, in the state. Transitions between the same two states form one edge, and
//! long guards are broken into lines.

use super::text::guard_parts;
use super::{Guard, Machine, Port, Transition};
use linewright_core::drawing::{Edge, Graph, dot, svg};
use linewright_core::gr1::{Domain, shown};
use std::collections::BTreeMap;

/// Maximum number of cubes of a guard in a label; the JSON has them all.
const MOST_LINES: usize = 3;

/// Maximum number of combinations of outputs on an edge.
const MOST_GROUPS: usize = 3;

/// Line length above which a line is broken at a conjunction.
const WIDTH: usize = 40;

/// States and edges with their labels.
pub fn graph(machine: &Machine) -> Graph {
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
            for (output, guards) in outputs.into_iter().take(MOST_GROUPS) {
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
            if groups > MOST_GROUPS {
                label.push(format!("... {} more", groups - MOST_GROUPS));
            }
            edges.push(Edge { from, to, label });
        }
    }
    Graph { states, edges }
}

/// The text of the graph.
pub fn to_dot(machine: &Machine) -> String {
    dot::of(&machine.name, &graph(machine))
}

/// The picture.
pub fn to_svg(machine: &Machine) -> String {
    svg::of(&machine.name, &graph(machine))
}

/// For each state, the outputs that all transitions into it agree on.
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

/// `turning`, `!turning`, `angle = 3`
fn assignment(port: &Port, value: i64) -> String {
    let name = &port.name;
    match &port.domain {
        Domain::Bool if value == 0 => format!("!{name}"),
        Domain::Bool => name.to_owned(),
        domain => format!("{name} = {}", shown(domain, value, &port.unit)),
    }
}

/// One line per cube, broken if it is too long.
fn guard_lines(machine: &Machine, guards: &[&Guard]) -> Vec<String> {
    let cubes = guard_parts(machine, guards);
    let mut lines = Vec::new();
    for (i, tests) in cubes.iter().take(MOST_LINES).enumerate() {
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
    if cubes.len() > MOST_LINES {
        lines.push(format!("| ... {} more", cubes.len() - MOST_LINES));
    }
    lines
}

/// Joins parts with a separator into lines of at most [`WIDTH`] characters, if the parts allow it.
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
