//! Emits a controller that consists of functions: a table of decisions with shared parts, which a
//! loop evaluates.
//!
//! A block cannot call itself and should not need other blocks, so the loop is repeated in each of
//! the four places that evaluate a function: assumptions, modes, outputs, goals.

use super::interface::{Interface, Port};
use super::tables::{element, table};
use super::text::indented;
use super::{Initial, Parts, Type, Variable, Width, codes, literal};
use crate::template::render;
use linewright_solver::mealy::functions::Functions;
use linewright_solver::symbolic::{Bit, Edge};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Tables of the decisions, and of the edges at which the functions begin.
struct Tables {
    assumption: Variable,
    assumption_error: Variable,
    node_signal: Variable,
    node_high: Variable,
    node_low: Variable,
    output_signal: Variable,
    output_edge: Variable,
    mode_when: Variable,
    mode_first: Variable,
    goal_mode: Variable,
    goal_reached: Variable,
}

impl Tables {
    fn new(interface: &mut Interface<'_>, functions: &Functions) -> Self {
        let controls = &functions.controls;
        let numbers = |edges: &mut dyn Iterator<Item = u32>| edges.map(i64::from).collect();
        let assumed = controls.assumed_first.iter().chain(&controls.assumed);
        let assumptions: Vec<i64> = numbers(&mut assumed.map(|(_, e)| e.0));
        let names = functions.names_first.iter().chain(&functions.names);
        let mut errors: Vec<String> = names.map(|n| interface.assumption_error(n)).collect();
        if errors.is_empty() {
            errors.push(interface.own().no_error.clone());
        }
        let assumption_error = Variable {
            initial: Initial::Values(errors.clone()),
            ..Variable::new(
                &interface.fresh("assumption_error"),
                Type::Array(
                    0,
                    errors.len() as i64 - 1,
                    Box::new(Type::Enumeration(interface.error_type())),
                ),
                "error if the assumption does not hold",
            )
        };
        let nodes = &controls.diagram.nodes;
        let signals = numbers(&mut nodes.iter().map(|n| u32::from(n.bit.0)));
        let highs = numbers(&mut nodes.iter().map(|n| n.high.0));
        let lows = numbers(&mut nodes.iter().map(|n| n.low.0));

        // The outputs of step 0 come first, then those of the modes; equal lists are shared.
        let count = controls.first.len();
        let mut rows: Vec<&[(Bit, Edge)]> = vec![&controls.first];
        let mut known: BTreeMap<&[(Bit, Edge)], usize> = BTreeMap::new();
        let (mut when, mut first) = (Vec::new(), Vec::new());
        let (mut modes, mut reached) = (Vec::new(), Vec::new());
        for goal in &controls.goals {
            modes.push(when.len() as i64);
            reached.push(i64::from(goal.reached.0));
            for mode in &goal.modes {
                let fresh = rows.len();
                let place = *known.entry(&mode.outputs).or_insert(fresh);
                if place == fresh {
                    rows.push(&mode.outputs);
                }
                when.push(i64::from(mode.when.0));
                first.push((place * count) as i64);
            }
        }
        modes.push(when.len() as i64);
        let outputs = || rows.iter().copied().flatten();
        let output_signals = outputs().map(|(b, _)| i64::from(b.0)).collect();
        let output_edges = outputs().map(|(_, e)| i64::from(e.0)).collect();

        let mut make = |name: &str, values: Vec<i64>, first: i64, about: &str| {
            table(interface, name, values, first, about)
        };
        Self {
            assumption: make(
                "assumption",
                assumptions,
                0,
                "assumptions about step 0, then about later steps",
            ),
            assumption_error,
            node_signal: make(
                "node_signal",
                signals,
                1,
                concat!(
                    "signal that a decision tests; edge 2n leads to decision n, ",
                    "2n + 1 to its negation, 0 is FALSE and 1 is TRUE"
                ),
            ),
            node_high: make("node_high", highs, 1, "edge if the signal is TRUE"),
            node_low: make("node_low", lows, 1, "edge if the signal is FALSE"),
            output_signal: make(
                "output_signal",
                output_signals,
                0,
                "signals of the outputs, for step 0 and for every mode",
            ),
            output_edge: make(
                "output_edge",
                output_edges,
                0,
                "values of the outputs, in the order of computation",
            ),
            mode_when: make(
                "mode_when",
                when,
                0,
                "condition of a mode of pursuing a goal",
            ),
            mode_first: make("mode_first", first, 0, "first output of the mode"),
            goal_mode: make(
                "goal_mode",
                modes,
                0,
                "first mode of every goal, then the number of modes",
            ),
            goal_reached: make(
                "goal_reached",
                reached,
                0,
                "condition that the goal is reached",
            ),
        }
    }

    fn into_list(self) -> Vec<Variable> {
        vec![
            self.assumption,
            self.assumption_error,
            self.node_signal,
            self.node_high,
            self.node_low,
            self.output_signal,
            self.output_edge,
            self.mode_when,
            self.mode_first,
            self.goal_mode,
            self.goal_reached,
        ]
    }
}

/// The fields of `functions_reset.st`.
#[derive(Serialize)]
struct Reset<'a> {
    goal: &'a str,
    row: &'a str,
    last: i64,
    memory: &'a str,
}

/// The fields of `functions.st`.
#[derive(Serialize)]
struct Step<'a> {
    row: &'a str,
    last: &'a str,
    value: &'a str,
    goal: &'a str,
    memory: &'a str,
    signals: &'a str,
    refused: &'a str,
    no_error: &'a str,
    /// Number of bits of the values in a step.
    pairs: usize,
    /// Statements that write the inputs to their signals.
    inputs: Vec<String>,
    /// Number of assumptions about step 0.
    first_assumptions: usize,
    /// Number of assumptions about step 0 and about later steps.
    assumptions: usize,
    assumption_error: &'a str,
    evaluate_assumption: String,
    first_mode: String,
    end_of_modes: String,
    evaluate_mode: String,
    first_output: String,
    /// Number of outputs computed in a step.
    count: usize,
    evaluate_output: String,
    output_signal: &'a str,
    evaluate_reached: String,
    goals: usize,
    /// Statements that set the outputs from their signals.
    outputs: Vec<String>,
}

/// The fields of `evaluate.st`.
#[derive(Serialize)]
struct Evaluate<'a> {
    edge: &'a str,
    value: &'a str,
    start: String,
    signal: String,
    high: String,
    low: String,
}

/// Temporary variables of a step.
struct Scratch {
    signals: Variable,
    at: Variable,
    last: Variable,
    edge: Variable,
    value: Variable,
    code: Variable,
}

/// Emits tables, memory and step.
pub(super) fn parts(interface: &mut Interface<'_>, functions: &Functions) -> Parts {
    let pairs = functions.pairs().max(1) as i64;
    let goal = interface.fresh("goal");
    let goal = Variable::new(
        &goal,
        Type::Integer(Width::of(0, functions.controls.goals.len() as i64)),
        "pursued goal; -1 before step 0",
    )
    .with_initial_value("-1");
    let memory = Variable::new(
        &interface.fresh("memory"),
        Type::Array(0, pairs - 1, Box::new(Type::Bool)),
        "bits of the values in the last step",
    );
    let tables = Tables::new(interface, functions);
    let all = [
        &tables.node_high,
        &tables.node_low,
        &tables.assumption,
        &tables.output_edge,
        &tables.mode_when,
        &tables.mode_first,
        &tables.goal_reached,
        &tables.goal_mode,
        &tables.output_signal,
    ];
    // Indices and edges have the same type, which must also hold the index after a table's last
    // row.
    let rows = all.iter().map(|t| match t.kind {
        Type::Array(_, last, _) => Width::of(0, last + 1),
        _ => Width::Lint,
    });
    let index = all
        .iter()
        .map(|t| element(t))
        .chain(rows)
        .max()
        .unwrap_or(Width::Dint)
        .max(Width::of(0, 2 * pairs));
    let code = Type::Integer(code_width(interface));
    let mut scratch =
        |name: &str, kind: Type, about: &str| Variable::new(&interface.fresh(name), kind, about);
    let scratch = Scratch {
        signals: scratch(
            "signals",
            Type::Array(0, 2 * pairs - 1, Box::new(Type::Bool)),
            "2k is a bit of the values in the last step, 2k + 1 the same bit in this step",
        ),
        at: scratch("row", Type::Integer(index), ""),
        last: scratch("last", Type::Integer(index), ""),
        edge: scratch("edge", Type::Integer(index), ""),
        value: scratch("value", Type::Bool, ""),
        code: scratch("code", code, ""),
    };
    let step = step(
        interface, functions, &tables, &scratch, &goal, &memory, index,
    );
    let reset = render(
        "structured_text/functions_reset.st",
        Reset {
            goal: &goal.name,
            row: &scratch.at.name,
            last: pairs - 1,
            memory: &memory.name,
        },
    );
    let Scratch {
        signals,
        at,
        last,
        edge,
        value,
        code,
    } = scratch;
    Parts {
        locals: vec![goal, memory],
        constants: tables.into_list(),
        temporaries: vec![signals, at, last, edge, value, code],
        reset,
        step,
    }
}

/// Width of the variable that is used to split values into bits.
fn code_width(interface: &Interface<'_>) -> Width {
    let ports = || interface.inputs.iter().chain(&interface.outputs);
    let widths = ports().map(|p| {
        let domain = &p.of.domain;
        let size = domain.high().saturating_sub(domain.low());
        Width::of(domain.low().min(0), domain.high().max(size))
    });
    let widths = widths.chain([
        codes::width(&interface.inputs),
        codes::width(&interface.outputs),
    ]);
    widths.max().unwrap_or(Width::Int)
}

fn step(
    interface: &Interface<'_>,
    functions: &Functions,
    tables: &Tables,
    scratch: &Scratch,
    goal: &Variable,
    memory: &Variable,
    index: Width,
) -> String {
    let own = interface.own();
    let controls = &functions.controls;
    let (at, edge, goal_name) = (&scratch.at.name, &scratch.edge.name, &goal.name);
    let signals = &scratch.signals.name;
    let get = |table: &Variable, place: &str| {
        element(table).convert(index, &format!("{}[{place}]", table.name))
    };
    // Statements that evaluate the function whose edge is in row `place` of a table.
    let evaluate = |table: &Variable, place: &str, levels: usize| {
        let node = format!("{edge} / 2");
        let statements = render(
            "structured_text/evaluate.st",
            Evaluate {
                edge,
                value: &scratch.value.name,
                start: get(table, place),
                signal: format!("{signals}[{}[{node}]]", tables.node_signal.name),
                high: get(&tables.node_high, &node),
                low: get(&tables.node_low, &node),
            },
        );
        indented(&statements, levels).trim_end().to_owned()
    };
    let inputs = interface
        .inputs
        .iter()
        .zip(&functions.input_bits)
        .map(|(port, bits)| write_signals(port, bits, scratch))
        .filter(|statements| !statements.is_empty());
    let outputs = interface
        .outputs
        .iter()
        .zip(&functions.output_bits)
        .map(|(port, bits)| indented(&read_signals(port, bits, scratch), 1));
    render(
        "structured_text/functions.st",
        Step {
            row: at,
            last: &scratch.last.name,
            value: &scratch.value.name,
            goal: goal_name,
            memory: &memory.name,
            signals,
            refused: &own.refused,
            no_error: &own.no_error,
            pairs: functions.pairs(),
            inputs: inputs.map(|s| s.trim_end().to_owned()).collect(),
            first_assumptions: controls.assumed_first.len(),
            assumptions: controls.assumed_first.len() + controls.assumed.len(),
            assumption_error: &tables.assumption_error.name,
            evaluate_assumption: evaluate(&tables.assumption, at, 1),
            first_mode: get(&tables.goal_mode, goal_name),
            end_of_modes: get(&tables.goal_mode, &format!("{goal_name} + 1")),
            evaluate_mode: evaluate(&tables.mode_when, at, 3),
            first_output: get(&tables.mode_first, at),
            count: controls.first.len(),
            evaluate_output: evaluate(&tables.output_edge, at, 2),
            output_signal: &tables.output_signal.name,
            evaluate_reached: evaluate(&tables.goal_reached, goal_name, 2),
            goals: controls.goals.len(),
            outputs: outputs.map(|s| s.trim_end().to_owned()).collect(),
        },
    )
}

/// Statements that write the bits of an input to its signals in this step, least significant first.
fn write_signals(port: &Port<'_>, bits: &[Bit], scratch: &Scratch) -> String {
    let signal = |bit: &Bit| format!("{}[{}]", scratch.signals.name, bit.primed().0);
    if let ([bit], Type::Bool) = (bits, &port.kind) {
        return format!("{} := {};\n", signal(bit), port.name);
    }
    let Type::Integer(width) = scratch.code.kind else {
        unreachable!("a code is a number")
    };
    let code = &scratch.code.name;
    let mut out = String::new();
    if bits.is_empty() {
        return out;
    }
    out.push_str(&codes::read(port, code, width));
    let low = port.of.domain.low();
    if low != 0 {
        let _ = writeln!(out, "{code} := {code} - ({});", literal(low));
    }
    for (place, bit) in bits.iter().rev().enumerate() {
        if place > 0 {
            let _ = writeln!(out, "{code} := {code} / 2;");
        }
        let _ = writeln!(out, "{} := ({code} MOD 2 = 1);", signal(bit));
    }
    out
}

/// Statements that set an output from its signals in this step.
fn read_signals(port: &Port<'_>, bits: &[Bit], scratch: &Scratch) -> String {
    let signal = |bit: &Bit| format!("{}[{}]", scratch.signals.name, bit.primed().0);
    if let ([bit], Type::Bool) = (bits, &port.kind) {
        return format!("{} := {};\n", port.name, signal(bit));
    }
    let Type::Integer(width) = scratch.code.kind else {
        unreachable!("a code is a number")
    };
    let code = &scratch.code.name;
    let mut out = format!("{code} := 0;\n");
    for (place, bit) in bits.iter().enumerate() {
        if place > 0 {
            let _ = writeln!(out, "{code} := 2 * {code};");
        }
        let _ = writeln!(out, "IF {} THEN {code} := {code} + 1; END_IF;", signal(bit));
    }
    let low = port.of.domain.low();
    if low != 0 {
        let _ = writeln!(out, "{code} := {code} + ({});", literal(low));
    }
    out + &codes::write(port, code, width)
}
