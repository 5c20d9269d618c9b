//! The JSON text that `station_describe` returns: the data that a host needs to call the library.

use crate::profile::ProfileEntry;
use linewright_core::gr1::Domain;
use linewright_language::contract::machine::{Machine, PlantSource, PropertyKind};
use serde_json::{Map, Value, json};

/// The JSON Schema of the description. It refers to the definition of `ProfileEntry`.
pub const SCHEMA: &str = include_str!("station.schema.json");

/// Describes a machine whose library was built with this profile. Every call passes values as
/// numbers; `labels` lists the names of an enumeration's values, from 0 on.
pub(super) fn describe(machine: &Machine, contract_hash: &str, profile: &ProfileEntry) -> String {
    let plant: Vec<Value> = machine
        .plant
        .iter()
        .map(|input| {
            let source = match &input.source {
                PlantSource::Operation => "operation",
                PlantSource::Signal { .. } => "signal",
                PlantSource::Property(_) => "property",
            };
            let mut port = port(&input.name, &input.domain, &input.unit);
            port.insert("source".to_owned(), json!(source));
            Value::Object(port)
        })
        .collect();
    let outputs: Vec<Value> = machine
        .components
        .iter()
        .flat_map(|component| {
            component.specification.outputs().map(|id| {
                let variable = component.specification.variable(id);
                let name = format!("{}.{}", component.name, variable.name);
                let mut port = port(&name, &variable.domain, &variable.unit);
                port.insert("internal".to_owned(), json!(variable.internal));
                Value::Object(port)
            })
        })
        .collect();
    let properties: Vec<Value> = machine
        .properties
        .iter()
        .map(|p| {
            let kind = match p.kind {
                PropertyKind::Part => "part",
                PropertyKind::Parameter => "parameter",
            };
            json!({"name": p.name, "unit": p.unit, "default": p.default, "kind": kind})
        })
        .collect();
    let operations: Vec<Value> = machine
        .operations
        .iter()
        .enumerate()
        .map(|(index, o)| {
            let codes: Vec<&str> = o.codes.iter().map(|c| c.text.as_str()).collect();
            let sequence: Vec<&str> = o
                .sequence
                .iter()
                .map(|&c| machine.components[c].name.as_str())
                .collect();
            json!({"index": index, "name": o.name, "codes": codes, "sequence": sequence})
        })
        .collect();
    let arity = json!({
        "instantiate": 0, "simulate": machine.properties.len() + 2, "get_real": 2, "get_integer": 2,
        "get_string": 2, "reset": 1,
        "deinstantiate": 1, "last_error": 1, "station_describe": 0,
    });
    json!({
        "schema": "linewright/station/1",
        "machine": machine.name,
        "contract_hash": contract_hash,
        "profile": profile,
        "plant": plant,
        "outputs": outputs,
        "properties": properties,
        "operations": operations,
        "exports": arity,
        "results": ["verdict", "rule", "time", "energy", "steps", "control_time"],
        "units": {"time": "s", "energy": "J", "seconds": "s", "joules": "J", "steps": "", "control_time": "s"},
        "step_seconds": machine.step_seconds,
        "base_watts": machine.base_watts,
        "idle_watts": machine.idle_watts,
        "step_limit": machine.step_limit,
    })
    .to_string()
}

fn port(name: &str, domain: &Domain, unit: &str) -> Map<String, Value> {
    let mut port = Map::new();
    port.insert("name".to_owned(), json!(name));
    port.insert("domain".to_owned(), json!(domain.describe()));
    if !unit.is_empty() {
        port.insert("unit".to_owned(), json!(unit));
    }
    port.insert("low".to_owned(), json!(domain.low()));
    port.insert("high".to_owned(), json!(domain.high()));
    if let Domain::Enum { labels, .. } = domain {
        port.insert("labels".to_owned(), json!(labels));
    }
    port
}
