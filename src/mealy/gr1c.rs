//! A machine in the JSON that `gr1c -t json` writes (format version 1, see `doc/formats.md` of tulip-control/gr1c).
//!
//! gr1c's automaton labels *nodes* with valuations: a node is a state together with the inputs and outputs by which it was
//! entered, and `trans` lists where the next step may lead. So every guard is written out letter by letter, and above
//! [`MOST_NODES`] this gives up. gr1c's variables are boolean or `[0, n]`; a range that begins elsewhere is shifted to 0, and
//! labels are their numbers. What the shift was, and the labels, stand in `extra`. `mode` (the goal pursued) and `rgrad` (the
//! distance to it) are not known of a minimised machine: every node has mode 0 and gr1c's own "not available", -1. `gr1c` (the
//! version whose format this is) and `date` are constant, so that the same machine gives the same bytes; `extra` also says who
//! wrote it.

use super::{Machine, Port, Transition};
use crate::game::Limit;
use crate::gr1::Domain;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// More nodes than this are not written.
pub const MOST_NODES: usize = 100_000;

/// More edges than this are not written.
const MOST_EDGES: usize = 5_000_000;

/// Nodes by their valuation and the machine's state.
#[derive(Default)]
struct Nodes {
    /// The machine's state, the valuation, whether it is initial.
    list: Vec<(usize, Vec<i64>, bool)>,
    numbers: HashMap<(usize, Vec<i64>), usize>,
}

impl Nodes {
    fn number(&mut self, state: usize, valuation: Vec<i64>) -> Result<usize, Limit> {
        if let Some(number) = self.numbers.get(&(state, valuation.clone())) {
            return Ok(*number);
        }
        if self.list.len() >= MOST_NODES {
            return Err(Limit::Size);
        }
        self.list.push((state, valuation.clone(), false));
        self.numbers.insert((state, valuation), self.list.len() - 1);
        Ok(self.list.len() - 1)
    }
}

/// The document, or [`Limit::Size`] above [`MOST_NODES`].
pub fn to_json(machine: &Machine) -> Result<Value, Limit> {
    let mut nodes = Nodes::default();
    for node in successors(machine, &machine.initial, &mut nodes)? {
        nodes.list[node].2 = true;
    }
    let mut edges: Vec<Vec<usize>> = Vec::new();
    // All nodes of a state have the same successors.
    let mut known: Vec<Option<Vec<usize>>> = vec![None; machine.states.len()];
    let mut room = MOST_EDGES;
    while edges.len() < nodes.list.len() {
        let state = nodes.list[edges.len()].0;
        let targets = if let Some(targets) = &known[state] {
            targets.clone()
        } else {
            let targets = successors(machine, &machine.states[state], &mut nodes)?;
            known[state].insert(targets).clone()
        };
        room = room.checked_sub(targets.len()).ok_or(Limit::Size)?;
        edges.push(targets);
    }

    let name = |number: usize| format!("{number:#x}");
    let mut written = Map::new();
    for (number, ((_, valuation, initial), targets)) in nodes.list.iter().zip(&edges).enumerate() {
        let targets: Vec<String> = targets.iter().map(|t| name(*t)).collect();
        written.insert(
            name(number),
            json!({
                "state": valuation,
                "mode": 0,
                "rgrad": -1,
                "initial": initial,
                "trans": targets,
            }),
        );
    }
    Ok(json!({
        "version": 1,
        "gr1c": "0.13.0",
        "date": "1970-01-01 00:00:00",
        "extra": extra(machine),
        "ENV": machine.inputs.iter().map(variable).collect::<Vec<_>>(),
        "SYS": machine.outputs.iter().map(variable).collect::<Vec<_>>(),
        "nodes": written,
    }))
}

/// The nodes that some transitions lead to, in ascending order.
fn successors(
    machine: &Machine,
    transitions: &[Transition],
    nodes: &mut Nodes,
) -> Result<Vec<usize>, Limit> {
    let mut found = Vec::new();
    for transition in transitions {
        for cube in &transition.guard.0 {
            let mut ranges: Vec<(i64, i64)> = machine
                .inputs
                .iter()
                .map(|p| (p.domain.low(), p.domain.high()))
                .collect();
            for test in &cube.0 {
                ranges[test.input] = (test.low, test.high);
            }
            let mut letter: Vec<i64> = ranges.iter().map(|r| r.0).collect();
            loop {
                let ports = machine.inputs.iter().chain(&machine.outputs);
                let values = letter.iter().chain(&transition.output);
                let valuation = ports.zip(values).map(|(p, v)| v - p.domain.low()).collect();
                found.push(nodes.number(transition.to, valuation)?);
                // The next letter, the last input fastest.
                let Some(i) = (0..letter.len()).rev().find(|i| letter[*i] < ranges[*i].1) else {
                    break;
                };
                letter[i] += 1;
                for k in i + 1..letter.len() {
                    letter[k] = ranges[k].0;
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

fn variable(port: &Port) -> Value {
    let domain = match &port.domain {
        Domain::Bool => json!("boolean"),
        other => json!([0, other.high() - other.low()]),
    };
    json!({ port.name.as_str(): domain })
}

/// What gr1c's domains cannot say.
fn extra(machine: &Machine) -> String {
    let ports = machine.inputs.iter().chain(&machine.outputs);
    let notes = ports.filter_map(|port| match &port.domain {
        Domain::Range { low, .. } if *low != 0 => {
            Some(format!("{} is shifted by {low}", port.name))
        }
        Domain::Enum { .. } => Some(format!("{}: {}", port.name, port.domain.describe())),
        _ => None,
    });
    let written = std::iter::once("written by linewright".to_owned());
    written.chain(notes).collect::<Vec<_>>().join("; ")
}
