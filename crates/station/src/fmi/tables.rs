//! Renders the C file of a unit: the definition of the machine, additional tables for the adapters,
//! and the adapter.

use super::variables::{Kind, kind};
use super::{Version, step_seconds};
use crate::emit::expression::{literal, real_literal};
use crate::emit::text::{comment, string};
use crate::template::render;
use linewright_core::gr1::Domain;
use linewright_language::contract::machine::Machine;
use serde::Serialize;

/// The fields of `unit.c`.
#[derive(Serialize)]
struct Source<'a> {
    name: String,
    version: &'static str,
    prefix: &'static str,
    unit: &'a str,
    token: String,
    tables: &'a str,
    adapter: &'static str,
}

/// The fields of `tables.c`.
#[derive(Serialize)]
struct Tables {
    first_operation: usize,
    idle_watts: String,
    step_seconds: String,
    step_text: String,
    wires: Vec<Wire>,
    properties: Vec<Property>,
}

#[derive(Serialize)]
struct Wire {
    kind: &'static str,
    before: String,
    about: String,
}

#[derive(Serialize)]
struct Property {
    default: String,
    about: String,
}

/// Renders the C file of a unit.
pub(super) fn source(
    machine: &Machine,
    unit: &str,
    tables: &str,
    token: &str,
    version: Version,
) -> String {
    let (number, prefix) = match version {
        Version::Two => ("2.0", "FMI2_FUNCTION_PREFIX"),
        Version::Three => ("3.0", "FMI3_FUNCTION_PREFIX"),
    };
    render(
        "fmi/unit.c",
        Source {
            name: comment(&machine.name),
            version: number,
            prefix,
            unit: unit.trim_end(),
            token: string(token),
            tables: tables.trim_end(),
            adapter: version.adapter(),
        },
    )
}

/// Renders the tables that the adapters need in addition to the tables of the machine.
pub(super) fn tables(machine: &Machine, first_operation: usize) -> String {
    let plant = machine.plant.iter().map(|p| &p.domain);
    let outputs = machine.components.iter().flat_map(|c| {
        let ids = c.specification.outputs();
        ids.map(|id| &c.specification.variable(id).domain)
    });
    let wires = plant.chain(outputs).enumerate().map(|(wire, domain)| Wire {
        kind: type_name(domain),
        before: literal(before(domain)),
        about: comment(&machine.wire_name(wire)),
    });
    let properties = machine.properties.iter().map(|property| Property {
        default: real_literal(property.default),
        about: comment(&property.name),
    });
    render(
        "fmi/tables.c",
        Tables {
            first_operation,
            idle_watts: real_literal(machine.idle_watts),
            step_seconds: real_literal(step_seconds(machine)),
            step_text: string(&step_seconds(machine).to_string()),
            wires: wires.collect(),
            properties: properties.collect(),
        },
    )
}

/// Value of a wire before the first step: the value of its domain that is nearest to 0.
fn before(domain: &Domain) -> i64 {
    0.clamp(domain.low(), domain.high())
}

fn type_name(domain: &Domain) -> &'static str {
    match kind(domain) {
        Kind::Real => "LW_FMI_REAL",
        Kind::Integer => "LW_FMI_INTEGER",
        Kind::Long => "LW_FMI_LONG",
        Kind::Boolean => "LW_FMI_BOOLEAN",
        Kind::Enumeration(_) => "LW_FMI_ENUMERATION",
    }
}
