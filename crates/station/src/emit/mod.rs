//! Emits the C source of a machine: one readable C99 file of tables and small functions, which
//! includes the runtime and the adapter of `ffi/` at its end.
//!
//! The file is a single translation unit, so one compiler run builds a library. Definitions are in
//! the order of the machine, so the text does not depend on time, path or hash map order.

mod assumed;
mod component;
pub mod controller;
mod decisions;
mod describe;
pub mod expression;
mod machine;
mod splits;
pub(super) mod text;
mod walks;
pub(super) mod words;

use crate::profile::Profile;
use crate::template::render;
use component::Emitter;
pub use describe::SCHEMA as DESCRIPTION_SCHEMA;
use linewright_core::gr1::Timing;
use linewright_language::contract::machine::Machine;
use linewright_solver::mealy;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fmt::Write;
use text::{comment, identifier, long_string, wrap};

/// The emitted texts of a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmittedMachine {
    /// The C file.
    pub source: String,
    /// The part of the C file that defines the machine, without description, runtime and adapter,
    /// for use with another adapter.
    pub unit: String,
    /// SHA-256 hash over everything that determines the machine's behavior, in hexadecimal.
    /// `station_describe` returns it.
    pub contract_hash: String,
    /// JSON text of `station_describe`.
    pub description: String,
}

/// The fields of `library.c`.
#[derive(Serialize)]
struct Library<'a> {
    name: String,
    doc: String,
    unit: &'a str,
    description: String,
    /// Description for a library that is compiled against the vendor's header.
    vendors_description: String,
}

/// The fields of `unit.c`.
#[derive(Serialize)]
struct Unit<'a> {
    sizes: &'a str,
    mark: u64,
    body: &'a str,
}

/// Emits a machine with the controller of each of its components, in order.
///
/// # Panics
/// Panics if a controller does not fit its component's contract.
pub fn emit(
    machine: &Machine,
    controllers: &[mealy::Controller],
    profile: &Profile,
) -> EmittedMachine {
    super::assert_fit(machine, controllers);
    let wires = machine::wire_names(machine);
    let mut emitters = Vec::new();
    let (mut first_value, mut first_justice) = (machine.plant.len(), 0);
    for (index, component) in machine.components.iter().enumerate() {
        emitters.push(Emitter {
            machine,
            component,
            controller: &controllers[index],
            prefix: format!("c{index}_{}", identifier(&component.name)),
            variables: component::variable_names(component, index),
            wires: &wires,
            first_value,
            first_justice,
        });
        first_value += component.specification.variables.len();
        first_justice += component.specification.assumptions.justice.len();
    }
    let sizes = sizes(machine, controllers, first_value, first_justice);
    let body = machine::definitions(machine, &emitters, &wires);
    let hash = hex(&Sha256::digest(format!("{sizes}{body}")));
    let description = describe::describe(machine, &hash, &profile.describe());
    let vendors = describe::describe(machine, &hash, &Profile::describe_vendor_header());
    // The mark is between 1 and 1023. No handle is therefore 0, and handles of two machines rarely
    // coincide, even if the machines differ only in their names.
    let named = hex(&Sha256::digest(format!("{}\n{hash}", machine.name)));
    let mark = u64::from_str_radix(&named[..8], 16).unwrap_or(0) % 1023 + 1;
    let unit = render(
        "station/unit.c",
        Unit {
            sizes: sizes.trim_end(),
            mark,
            body: body.trim_end(),
        },
    );
    let doc = comment(&machine.doc);
    let source = render(
        "station/library.c",
        Library {
            name: comment(&machine.name),
            doc: wrap(doc.trim(), " * "),
            unit: unit.trim_end(),
            description: long_string(&description, "    "),
            vendors_description: long_string(&vendors, "    "),
        },
    );
    EmittedMachine {
        source,
        unit,
        contract_hash: hash,
        description,
    }
}

/// Size in bytes of a Mealy machine's tables in a station library, without names and formulas. The
/// caller uses it to choose between tables and functions.
pub fn table_bytes(machine: &mealy::Machine) -> usize {
    splits::Decisions::of(machine).bytes()
}

/// The fields of `sizes.h`.
#[derive(Serialize)]
struct Sizes {
    components: usize,
    plant: usize,
    outputs: usize,
    values: usize,
    properties: usize,
    operations: usize,
    justice: usize,
    /// The largest number of variables in one component whose domain does not begin at 0. Only
    /// components with a controller as functions count; `None` if there are none.
    max_shifted: Option<usize>,
    number: &'static str,
    each_component: Vec<usize>,
    each_moore: Vec<usize>,
    each_mealy: Vec<usize>,
    step_limit: String,
    step_limit_text: i64,
    step_seconds: String,
    base_watts: String,
}

/// Renders the macros with the sizes of all tables.
fn sizes(
    machine: &Machine,
    controllers: &[mealy::Controller],
    values: usize,
    justice: usize,
) -> String {
    let functions = machine
        .components
        .iter()
        .zip(controllers)
        .filter(|(_, controller)| controller.functions().is_some());
    let shifted = functions.map(|(c, _)| {
        let variables = c.specification.variables.iter();
        variables.filter(|v| v.domain.low() != 0).count()
    });
    let each = |timing: Timing| {
        let components = machine
            .components
            .iter()
            .enumerate()
            .filter(|(_, c)| c.specification.timing == timing);
        components.map(|(index, _)| index).collect()
    };
    let limit = i64::try_from(machine.step_limit).unwrap_or(i64::MAX);
    render(
        "station/sizes.h",
        Sizes {
            components: machine.components.len(),
            plant: machine.plant.len(),
            outputs: machine.wire_count() - machine.plant.len(),
            values,
            properties: machine.properties.len(),
            operations: machine.operations.len(),
            justice,
            max_shifted: shifted.max(),
            number: number(machine),
            each_component: (0..machine.components.len()).collect(),
            each_moore: each(Timing::Moore),
            each_mealy: each(Timing::Mealy),
            step_limit: expression::literal(limit),
            step_limit_text: limit,
            step_seconds: expression::real_literal(machine.step_seconds),
            base_watts: expression::real_literal(machine.base_watts),
        },
    )
}

/// The smallest C type that holds every value of every variable and plant wire.
fn number(machine: &Machine) -> &'static str {
    let variables = machine
        .components
        .iter()
        .flat_map(|c| &c.specification.variables);
    let domains = variables
        .map(|v| &v.domain)
        .chain(machine.plant.iter().map(|p| &p.domain));
    let (mut low, mut high) = (0, 0);
    for domain in domains {
        low = domain.low().min(low);
        high = domain.high().max(high);
    }
    let fits = |min: i64, max: i64| min <= low && high <= max;
    if fits(i8::MIN.into(), i8::MAX.into()) {
        "int8_t"
    } else if fits(i16::MIN.into(), i16::MAX.into()) {
        "int16_t"
    } else if fits(i32::MIN.into(), i32::MAX.into()) {
        "int32_t"
    } else {
        "int64_t"
    }
}

/// Joins the rows of a table, one per line. C has no empty arrays, so a table without rows gets the
/// row `empty`.
fn rows(rows: &[String], empty: &str) -> String {
    if rows.is_empty() {
        format!("    {empty}")
    } else {
        rows.join("\n")
    }
}

/// Assigns unique names.
#[derive(Debug, Default)]
pub struct Names(BTreeSet<String>);

impl Names {
    /// Returns the preferred name, or that name with the first free number appended.
    pub fn unique(&mut self, preferred: &str) -> String {
        let mut name = preferred.to_owned();
        let mut number = 2;
        while !self.0.insert(name.clone()) {
            name = format!("{preferred}_{number}");
            number += 1;
        }
        name
    }
}

/// Formats bytes in hexadecimal.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut s, b| {
        let _ = write!(s, "{b:02x}");
        s
    })
}
