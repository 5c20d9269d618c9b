//! Converts machines to the JSON format of `gr1c -t json` (format version 1, see `doc/formats.md`
//! of tulip-control/gr1c).
//!
//! gr1c's automaton labels *nodes* with valuations: a node is a state together with the inputs and
//! outputs of the step that entered it, and `trans` lists the possible next nodes. So every input
//! valuation that keeps the assumptions is written separately; above [`MAX_NODES`] nodes or 5
//! million edges, the conversion fails. gr1c's variables are boolean or `[0, n]`: a range with
//! another lower bound is shifted to 0, and labels become their numbers; `extra` records the shift
//! and the labels. `mode` (the pursued goal) and `rgrad` (the distance to it) are unknown for a
//! minimized machine. So every node has `mode` 0 and `rgrad` -1, which means "not available" in
//! gr1c. `gr1c` (the version of gr1c) and `date` are constant, so that the same machine gives the
//! same bytes; `extra` also names this program.

use super::{Machine, Port};
use crate::game::Limit;
use linewright_core::gr1::{Domain, Expr, Specification, Time, VarId, eval};
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// Maximum number of nodes.
pub const MAX_NODES: usize = 100_000;

/// Maximum number of edges.
const MAX_EDGES: usize = 5_000_000;

/// Numbered nodes.
#[derive(Default)]
struct Nodes {
    /// Machine state and valuation of each node, and whether it is initial.
    list: Vec<(usize, Vec<i64>, bool)>,
    /// Number of each node by machine state and valuation.
    numbers: HashMap<(usize, Vec<i64>), usize>,
}

impl Nodes {
    /// Finds or adds a node and returns its number.
    fn number(&mut self, state: usize, valuation: Vec<i64>) -> Result<usize, Limit> {
        if let Some(number) = self.numbers.get(&(state, valuation.clone())) {
            return Ok(*number);
        }
        if self.list.len() >= MAX_NODES {
            return Err(Limit::Size);
        }
        self.list.push((state, valuation.clone(), false));
        self.numbers.insert((state, valuation), self.list.len() - 1);
        Ok(self.list.len() - 1)
    }
}

/// Returns the document, or [`Limit::Size`] if it has too many nodes or edges. The machine must
/// belong to the specification.
pub fn to_json(machine: &Machine, specification: &Specification) -> Result<Value, Limit> {
    let assumptions = Assumptions::new(specification);
    let mut nodes = Nodes::default();
    for node in successors(machine, &assumptions, None, &mut nodes)? {
        nodes.list[node].2 = true;
    }
    let mut edges: Vec<Vec<usize>> = Vec::new();
    let mut room = MAX_EDGES;
    while let Some((state, valuation, _)) = nodes.list.get(edges.len()).cloned() {
        let targets = successors(machine, &assumptions, Some((state, &valuation)), &mut nodes)?;
        room = room.checked_sub(targets.len()).ok_or(Limit::Size)?;
        edges.push(targets);
    }

    let shifted = |valuation: &[i64]| -> Vec<i64> {
        let ports = machine.inputs.iter().chain(&machine.outputs);
        let pairs = ports.zip(valuation);
        pairs
            .map(|(port, value)| value - port.domain.low())
            .collect()
    };
    let name = |number: usize| format!("{number:#x}");
    let mut written = Map::new();
    for (number, ((_, valuation, initial), targets)) in nodes.list.iter().zip(&edges).enumerate() {
        let targets: Vec<String> = targets.iter().map(|t| name(*t)).collect();
        written.insert(
            name(number),
            json!({
                "state": shifted(valuation),
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

/// Returns the successors of a node, or the initial nodes, in ascending order.
fn successors(
    machine: &Machine,
    assumptions: &Assumptions<'_>,
    from: Option<(usize, &[i64])>,
    nodes: &mut Nodes,
) -> Result<Vec<usize>, Limit> {
    let mut found = Vec::new();
    assumptions.letters(from.map(|(_, valuation)| valuation), &mut |letter| {
        if let Some(step) = machine.step(from.map(|(state, _)| state), letter) {
            let valuation = letter.iter().chain(&step.output).copied().collect();
            found.push(nodes.number(step.to, valuation)?);
        }
        Ok(())
    })?;
    found.sort_unstable();
    Ok(found)
}

/// The assumptions, grouped by the number of chosen inputs after which each formula can be
/// evaluated.
struct Assumptions<'a> {
    specification: &'a Specification,
    inputs: Vec<VarId>,
    outputs: Vec<VarId>,
    /// Initial conditions; their current values are those of the chosen inputs.
    first: Vec<Vec<&'a Expr>>,
    /// Invariants; their current values are those of the chosen inputs.
    always: Vec<Vec<&'a Expr>>,
    /// Safety formulas.
    later: Vec<Vec<&'a Expr>>,
}

impl<'a> Assumptions<'a> {
    fn new(specification: &'a Specification) -> Self {
        let inputs: Vec<VarId> = specification.inputs().collect();
        let by_place = |formulas: &'a [linewright_core::gr1::Formula], letter: Time| {
            let mut places = vec![Vec::new(); inputs.len() + 1];
            for formula in formulas {
                let mut last = 0;
                formula.expr.for_each_var(&mut |variable, time| {
                    let place = inputs.iter().position(|i| *i == variable);
                    if let (Some(place), true) = (place, time == letter) {
                        last = last.max(place + 1);
                    }
                });
                places[last].push(&formula.expr);
            }
            places
        };
        let side = &specification.assumptions;
        Self {
            first: by_place(&side.initial, Time::Now),
            always: by_place(&side.invariants, Time::Now),
            later: by_place(&side.safety, Time::Next),
            outputs: specification.outputs().collect(),
            inputs,
            specification,
        }
    }

    /// Calls `visit` with all input valuations that keep the assumptions: after the valuation
    /// `from` of inputs and outputs, or in step 0 if `from` is `None`. The last input varies
    /// fastest.
    fn letters(
        &self,
        from: Option<&[i64]>,
        visit: &mut impl FnMut(&[i64]) -> Result<(), Limit>,
    ) -> Result<(), Limit> {
        let mut now = vec![0; self.specification.variables.len()];
        if let Some(valuation) = from {
            for (variable, value) in self.inputs.iter().chain(&self.outputs).zip(valuation) {
                now[variable.index()] = *value;
            }
        }
        let mut next = vec![0; now.len()];
        let mut letter: Vec<i64> = Vec::new();
        loop {
            if self.keeps(letter.len(), from.is_none(), &now, &next) {
                if letter.len() == self.inputs.len() {
                    visit(&letter)?;
                } else {
                    let low = self
                        .specification
                        .variable(self.inputs[letter.len()])
                        .domain
                        .low();
                    letter.push(low);
                    next[self.inputs[letter.len() - 1].index()] = low;
                    continue;
                }
            }
            loop {
                let Some(value) = letter.pop() else {
                    return Ok(());
                };
                let input = self.inputs[letter.len()];
                if value < self.specification.variable(input).domain.high() {
                    letter.push(value + 1);
                    next[input.index()] = value + 1;
                    break;
                }
            }
        }
    }

    /// Whether those assumptions hold that can be evaluated once `chosen` inputs are chosen, but
    /// not earlier.
    fn keeps(&self, chosen: usize, first: bool, now: &[i64], next: &[i64]) -> bool {
        let own = if first {
            self.first[chosen].iter().all(|e| eval::holds(e, next, &[]))
        } else {
            self.later[chosen].iter().all(|e| eval::holds(e, now, next))
        };
        own && self.always[chosen]
            .iter()
            .all(|e| eval::holds(e, next, &[]))
    }
}

fn variable(port: &Port) -> Value {
    let domain = match &port.domain {
        Domain::Bool => json!("boolean"),
        other => json!([0, other.high() - other.low()]),
    };
    json!({ port.name.as_str(): domain })
}

/// Returns the information that gr1c's domains cannot express, as text.
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
