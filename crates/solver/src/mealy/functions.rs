//! Controllers as functions of bits, for contracts whose machine is too large to be listed state by
//! state.
//!
//! The value of every port is encoded in bits. A step computes the next output bits one after the
//! other, each with a decision diagram over the signals: the bits of the current inputs and
//! outputs, of the next inputs, and of the next outputs computed so far. The memory between steps
//! consists of the current values and the pursued goal. A goal can have several modes; the first
//! mode whose condition holds determines the outputs.
//!
//! Signal `2k` is a current bit, and `2k + 1` the same bit in the next step. Step 0 has no current
//! values; its inputs and outputs are next bits, too. [`Edge`] defines the edges of the diagrams.

use super::Port;
use super::extract::ports;
use crate::game::{AssumedFormula, Limit, Limits, StrategyFunctions, WonGame};
use crate::symbolic::{Bit, Diagram, Edge, Encoding};
use linewright_core::gr1::{Specification, Time, Timing, VarId};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// JSON Schema of the document; see [`Functions::to_json`].
pub const SCHEMA: &str = include_str!("functions.schema.json");

/// A controller as functions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Functions {
    /// Name of the contract.
    pub name: String,
    /// Which side moves first.
    pub timing: Timing,
    /// Inputs in the order of the specification.
    pub inputs: Vec<Port>,
    /// Outputs and internal variables in the order of the specification.
    pub outputs: Vec<Port>,
    /// Current bits of every input, most significant first. They encode the value minus the
    /// smallest value of the domain.
    pub input_bits: Vec<Vec<Bit>>,
    /// Current bits of every output, in the same form.
    pub output_bits: Vec<Vec<Bit>>,
    /// Names of the assumptions about step 0, in the order of [`StrategyFunctions::assumed_first`].
    pub names_first: Vec<String>,
    /// Names of the assumptions about later steps, in the order of [`StrategyFunctions::assumed`].
    pub names: Vec<String>,
    /// The functions and their certificate.
    pub controls: StrategyFunctions,
}

/// State of a controller between two steps.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct State {
    /// The signals; the current ones hold the values of the last step.
    signals: Vec<bool>,
    /// Index of the pursued goal; `None` before step 0.
    goal: Option<usize>,
}

/// Why a step was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// An input, by index, has a value outside its domain.
    Domain(usize),
    /// The assumption with this name is broken.
    Assumption(String),
}

impl Functions {
    /// Extracts the functions of a won game. They are not certified yet.
    pub fn extract(
        specification: &Specification,
        won: &WonGame,
        limits: &Limits,
    ) -> Result<Self, Limit> {
        let controls = won.functions(specification, limits)?;
        let encoding = Encoding::new(specification);
        let bits = |v: VarId| encoding.bits(v, Time::Now).collect();
        let side = &specification.assumptions;
        let name = |(assumed, _): &(AssumedFormula, Edge)| match assumed {
            AssumedFormula::Initial(i) => side.initial[*i].name.clone(),
            AssumedFormula::Invariant(i) => side.invariants[*i].name.clone(),
            AssumedFormula::Safety(i) => side.safety[*i].name.clone(),
        };
        Ok(Self {
            name: specification.name.clone(),
            timing: specification.timing,
            inputs: ports(specification, specification.inputs()),
            outputs: ports(specification, specification.outputs()),
            input_bits: specification.inputs().map(bits).collect(),
            output_bits: specification.outputs().map(bits).collect(),
            names_first: controls.assumed_first.iter().map(name).collect(),
            names: controls.assumed.iter().map(name).collect(),
            controls,
        })
    }

    /// Returns the state before step 0.
    pub fn initial_state(&self) -> State {
        State {
            signals: vec![false; 2 * self.pairs()],
            goal: None,
        }
    }

    /// Returns the number of pairs of a current and a next bit.
    pub fn pairs(&self) -> usize {
        let bits = self.input_bits.iter().chain(&self.output_bits);
        bits.map(Vec::len).sum()
    }

    /// Returns the number of modes, summed over all goals.
    pub fn mode_count(&self) -> usize {
        self.controls.goals.iter().map(|g| g.modes.len()).sum()
    }

    /// Takes a step and returns the outputs, one per entry of [`Self::outputs`]. A refused step
    /// leaves the state unchanged.
    pub fn step(&self, state: &mut State, inputs: &[i64]) -> Result<Vec<i64>, Refusal> {
        let outside = |(port, value): (&Port, &i64)| !port.domain.contains(*value);
        if let Some(input) = self.inputs.iter().zip(inputs).position(outside) {
            return Err(Refusal::Domain(input));
        }
        let mut signals = state.signals.clone();
        self.write_inputs(&mut signals, Time::Next, inputs);
        let (assumed, names) = match state.goal {
            None => (&self.controls.assumed_first, &self.names_first),
            Some(_) => (&self.controls.assumed, &self.names),
        };
        let broken = assumed.iter().position(|(_, e)| !self.holds(*e, &signals));
        if let Some(broken) = broken {
            return Err(Refusal::Assumption(names[broken].clone()));
        }
        let values = self.compute_outputs(state.goal, &mut signals);
        let goal = self.next_goal(state.goal, &signals);
        for pair in signals.chunks_exact_mut(2) {
            pair[0] = pair[1];
        }
        *state = State {
            signals,
            goal: Some(goal),
        };
        Ok(values)
    }

    /// Returns the outputs of a Moore controller in the next step, which do not depend on the
    /// inputs of that step.
    pub fn moore_output(&self, state: &State) -> Vec<i64> {
        debug_assert_eq!(self.timing, Timing::Moore);
        self.compute_outputs(state.goal, &mut state.signals.clone())
    }

    /// Writes values of the inputs to their current or next signals.
    pub fn write_inputs(&self, signals: &mut [bool], time: Time, values: &[i64]) {
        write_values(&self.inputs, &self.input_bits, signals, time, values);
    }

    /// Writes values of the outputs to their current or next signals.
    pub fn write_outputs(&self, signals: &mut [bool], time: Time, values: &[i64]) {
        write_values(&self.outputs, &self.output_bits, signals, time, values);
    }

    /// Computes the outputs of a step in pursuit of a goal, or of step 0 if `goal` is `None`.
    /// `signals` must hold the current values and, for Mealy, the next inputs. Also writes the next
    /// outputs to `signals`.
    pub fn compute_outputs(&self, goal: Option<usize>, signals: &mut [bool]) -> Vec<i64> {
        let controls = &self.controls;
        let roots = match goal {
            None => &controls.first,
            Some(goal) => {
                let modes = &controls.goals[goal].modes;
                let mode = modes.iter().find(|m| self.holds(m.when, signals));
                &mode.unwrap_or(&modes[modes.len() - 1]).outputs
            }
        };
        for (bit, root) in roots {
            signals[bit.index()] = self.holds(*root, signals);
        }
        let ports = self.outputs.iter().zip(&self.output_bits);
        let values = ports.map(|(port, bits)| {
            let code = bits.iter().fold(0i64, |code, bit| {
                code << 1 | i64::from(signals[bit.primed().index()])
            });
            port.domain.low() + code
        });
        values.collect()
    }

    /// Returns the goal that is pursued after a step with these signals. `goal` is the goal pursued
    /// in the step, `None` in step 0.
    pub fn next_goal(&self, goal: Option<usize>, signals: &[bool]) -> usize {
        let goals = &self.controls.goals;
        match goal {
            None => 0,
            Some(goal) if self.holds(goals[goal].reached, signals) => (goal + 1) % goals.len(),
            Some(goal) => goal,
        }
    }

    fn holds(&self, edge: Edge, signals: &[bool]) -> bool {
        evaluate(&self.controls.diagram, edge, signals)
    }

    /// Returns the document with the schema `linewright/functions/1`.
    ///
    /// `nodes` are decisions `[signal, edge if it is 1, edge if it is 0]`. Edge 0 is false, 1 is
    /// true, `2n` is node `n - 1`, and `2n + 1` its negation. `outputs` are pairs of a next
    /// output's signal and its edge, in the order of computation.
    pub fn to_json(&self, verified: bool) -> Value {
        let ports = |ports: &[Port], bits: &[Vec<Bit>]| -> Vec<Value> {
            let pairs = ports.iter().zip(bits);
            pairs
                .map(|(port, bits)| {
                    let mut value = super::json::port(port);
                    value["signals"] = bits.iter().map(|b| json!(b.0)).collect();
                    value
                })
                .collect()
        };
        let edges = |outputs: &[(Bit, Edge)]| -> Value {
            outputs.iter().map(|(b, e)| json!([b.0, e.0])).collect()
        };
        let assumed = |assumed: &[(AssumedFormula, Edge)], names: &[String]| -> Vec<Value> {
            let pairs = assumed.iter().zip(names);
            pairs
                .map(|((_, edge), name)| json!({"name": name, "holds": edge.0}))
                .collect()
        };
        let controls = &self.controls;
        let goals = controls.goals.iter().map(|goal| {
            let modes = goal
                .modes
                .iter()
                .map(|m| json!({"when": m.when.0, "outputs": edges(&m.outputs)}));
            json!({"modes": modes.collect::<Vec<_>>(), "reached": goal.reached.0})
        });
        let nodes = controls.diagram.nodes.iter();
        json!({
            "schema": "linewright/functions/1",
            "name": self.name,
            "kind": match self.timing { Timing::Mealy => "mealy", Timing::Moore => "moore" },
            "inputs": ports(&self.inputs, &self.input_bits),
            "outputs": ports(&self.outputs, &self.output_bits),
            "first_assumed": assumed(&controls.assumed_first, &self.names_first),
            "first_outputs": edges(&controls.first),
            "assumed": assumed(&controls.assumed, &self.names),
            "goals": goals.collect::<Vec<_>>(),
            "nodes": nodes.map(|n| json!([n.bit.0, n.high.0, n.low.0])).collect::<Vec<_>>(),
            "verified": verified,
        })
    }
}

/// Writes values of ports to their current or next signals.
fn write_values(
    ports: &[Port],
    bits: &[Vec<Bit>],
    signals: &mut [bool],
    time: Time,
    values: &[i64],
) {
    for ((port, bits), value) in ports.iter().zip(bits).zip(values) {
        let code = value.wrapping_sub(port.domain.low()) as u64;
        for (place, bit) in bits.iter().rev().enumerate() {
            let bit = match time {
                Time::Now => *bit,
                Time::Next => bit.primed(),
            };
            signals[bit.index()] = code >> place & 1 == 1;
        }
    }
}

/// Returns the value of an edge.
fn evaluate(diagram: &Diagram, mut edge: Edge, signals: &[bool]) -> bool {
    let mut value = edge.is_negated();
    while let Some(node) = edge.node() {
        let node = &diagram.nodes[node];
        edge = if signals[node.bit.index()] {
            node.high
        } else {
            node.low
        };
        value ^= edge.is_negated();
    }
    value
}
