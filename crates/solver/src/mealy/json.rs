//! Converts machines to JSON with the schema `linewright/machine/1`, for `synth --emit json`.
//!
//! A guard is written twice: as text for readers, and as data in the field `cubes`, a disjunction
//! of objects. Each object is a conjunction with the lowest and the highest value of every input
//! that it mentions. Outputs are objects from names to values.

use super::{Cube, Guard, Machine, Port, Transition};
use linewright_core::gr1::{Domain, Timing};
use serde_json::{Map, Value, json};

/// JSON Schema of the document.
pub const SCHEMA: &str = include_str!("machine.schema.json");

/// Returns the document. `verified` tells whether [`super::verify::verify`] accepted the machine.
pub fn to_json(machine: &Machine, verified: bool) -> Value {
    let ports = |ports: &[Port]| -> Vec<Value> { ports.iter().map(port).collect() };
    let initial = machine.initial.iter().map(|t| transition(machine, None, t));
    let states = machine.states.iter().enumerate();
    let transitions = states
        .flat_map(|(from, list)| list.iter().map(move |t| transition(machine, Some(from), t)));
    json!({
        "schema": "linewright/machine/1",
        "name": machine.name,
        "kind": match machine.timing { Timing::Mealy => "mealy", Timing::Moore => "moore" },
        "inputs": ports(&machine.inputs),
        "outputs": ports(&machine.outputs),
        "states": machine.states.len(),
        "initial": initial.collect::<Vec<_>>(),
        "transitions": transitions.collect::<Vec<_>>(),
        "verified": verified,
    })
}

/// Formats the document with one line per port and transition, for readers and line-based tools.
pub fn to_text(document: &Value) -> String {
    let Value::Object(fields) = document else {
        return document.to_string();
    };
    let fields = fields.iter().map(|(name, value)| match value {
        Value::Array(items) if !items.is_empty() => {
            let items: Vec<String> = items.iter().map(|i| format!("    {i}")).collect();
            format!("  \"{name}\": [\n{}\n  ]", items.join(",\n"))
        }
        other => format!("  \"{name}\": {other}"),
    });
    format!("{{\n{}\n}}\n", fields.collect::<Vec<_>>().join(",\n"))
}

/// Returns a port in JSON.
pub(super) fn port(port: &Port) -> Value {
    let domain = match &port.domain {
        Domain::Bool => json!({"type": "bool"}),
        Domain::Range { low, high } => json!({"type": "range", "low": low, "high": high}),
        Domain::Enum { name, labels } => json!({"type": "enum", "name": name, "labels": labels}),
    };
    let mut result = json!({"name": port.name, "domain": domain});
    if !port.unit.is_empty() {
        result["unit"] = json!(port.unit);
    }
    if port.internal {
        result["internal"] = json!(true);
    }
    result
}

fn transition(machine: &Machine, from: Option<usize>, transition: &Transition) -> Value {
    let pairs = machine.outputs.iter().zip(&transition.output);
    let output: Map<String, Value> = pairs
        .map(|(port, v)| (port.name.clone(), value(&port.domain, *v)))
        .collect();
    let mut result = Map::new();
    if let Some(from) = from {
        result.insert("from".to_owned(), json!(from));
    }
    result.insert(
        "guard".to_owned(),
        json!(machine.show_guard(&transition.guard)),
    );
    result.insert("cubes".to_owned(), json!(cubes(machine, &transition.guard)));
    result.insert("output".to_owned(), Value::Object(output));
    result.insert("to".to_owned(), json!(transition.to));
    Value::Object(result)
}

fn cubes(machine: &Machine, guard: &Guard) -> Vec<Value> {
    let cube = |cube: &Cube| -> Value {
        let tests = cube.0.iter().map(|t| {
            let port = &machine.inputs[t.input];
            let range = [value(&port.domain, t.low), value(&port.domain, t.high)];
            (port.name.clone(), json!(range))
        });
        Value::Object(tests.collect())
    };
    guard.0.iter().map(cube).collect()
}

/// Returns a value in JSON: a boolean, a number or a label.
fn value(domain: &Domain, value: i64) -> Value {
    match domain {
        Domain::Bool => json!(value != 0),
        Domain::Range { .. } => json!(value),
        Domain::Enum { .. } => json!(domain.show(value)),
    }
}
