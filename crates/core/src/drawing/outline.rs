//! The outline of a large graph: states whose labels agree except for the heading, which are those
//! with the same outputs, form one group.

use super::legend::{Entry, WIDTH};
use super::{Edge, Graph, text};
use std::collections::BTreeMap;

/// Maximum number of characters in a box for the names of the states of a group.
const NAMES: usize = 40;

/// Maximum number of characters of a name that stands in front of its row.
const KEY: usize = 24;

/// States in groups of equal outputs.
pub(super) struct Outline {
    /// The states of each group, in ascending order. The groups are in the order of their first
    /// states.
    groups: Vec<Vec<usize>>,
    /// The graph of the groups.
    pub graph: Graph,
}

impl Outline {
    /// Groups the states of a graph.
    pub fn new(graph: &Graph) -> Self {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut group_of = Vec::new();
        let mut known: BTreeMap<&[String], usize> = BTreeMap::new();
        for (number, label) in graph.states.iter().enumerate() {
            let group = *known.entry(outputs(label)).or_insert(groups.len());
            if group == groups.len() {
                groups.push(Vec::new());
            }
            groups[group].push(number);
            group_of.push(group);
        }
        let states = groups.iter().map(|states| label(graph, states)).collect();

        let mut merged: BTreeMap<(Option<usize>, usize), Vec<&Edge>> = BTreeMap::new();
        for edge in &graph.edges {
            let ends = (edge.from.map(|from| group_of[from]), group_of[edge.to]);
            merged.entry(ends).or_default().push(edge);
        }
        let edges = merged.into_iter().map(|((from, to), edges)| Edge {
            from,
            to,
            label: match edges.as_slice() {
                [edge] => edge.label.clone(),
                edges => vec![format!("{} edges", edges.len())],
            },
        });
        let edges = edges.collect();
        Self {
            groups,
            graph: Graph {
                states,
                edges,
                ..Graph::default()
            },
        }
    }

    /// Whether the outline says more than one box would, and less than the graph.
    pub fn is_useful(&self, graph: &Graph) -> bool {
        self.groups.len() > 1 && self.groups.len() < graph.states.len()
    }

    /// Says what the outline shows.
    pub fn caption(&self, graph: &Graph) -> String {
        let (states, groups) = (graph.states.len(), self.groups.len());
        let groups = match groups {
            1 => "1 group".to_owned(),
            more => format!("{more} groups"),
        };
        format!("{states} states in {groups} of equal outputs")
    }

    /// Returns a row for each group: the name of its only state, or the number and the names of its
    /// states; and their outputs.
    pub fn rows(&self, graph: &Graph, names: &[String]) -> Vec<Entry> {
        let row = |states: &Vec<usize>| {
            let own: Vec<&str> = states.iter().map(|state| names[*state].as_str()).collect();
            let outputs = text::wrap(outputs(&graph.states[states[0]]), WIDTH);
            if let [name] = own.as_slice()
                && name.chars().count() <= KEY
            {
                return Entry {
                    key: (*name).to_owned(),
                    lines: outputs,
                };
            }
            let mut lines = text::wrap(&[own.join(", ")], WIDTH);
            lines.extend(outputs);
            Entry {
                key: count(own.len()),
                lines,
            }
        };
        self.groups.iter().map(row).collect()
    }
}

/// The lines of a label without its heading.
fn outputs(label: &[String]) -> &[String] {
    label.get(1..).unwrap_or_default()
}

fn count(states: usize) -> String {
    match states {
        1 => "1 state".to_owned(),
        more => format!("{more} states"),
    }
}

/// The label of a group: that of its only state, or the number and the names of its states, as many
/// as fit in a line, and their outputs.
fn label(graph: &Graph, states: &[usize]) -> Vec<String> {
    if let [state] = states {
        return graph.states[*state].clone();
    }
    let mut names = String::new();
    for (index, state) in states.iter().enumerate() {
        let name = graph.states[*state].first().map_or("", String::as_str);
        if names.len() + name.len() > NAMES {
            names.push_str(if index > 0 { ", ..." } else { "..." });
            break;
        }
        if index > 0 {
            names.push_str(", ");
        }
        names.push_str(name);
    }
    let mut label = vec![count(states.len()), names];
    label.extend_from_slice(outputs(&graph.states[states[0]]));
    label
}
