//! The C text of a machine: one readable C99 file of tables and small functions, which includes the runtime and the adapter
//! of `ffi/` at its end.
//!
//! The file is one translation unit, so that a library takes one run of the compiler. Everything in it is ordered as the
//! machine is; nothing depends on time, place or a hash map.

mod assumed;
mod component;
pub mod controller;
mod decisions;
mod describe;
pub mod expression;
mod splits;
pub(super) mod text;
mod walks;
pub(super) mod words;

use crate::profile::Profile;
use component::Emitter;
use linewright_core::gr1::{Domain, Timing, VarId};
use linewright_language::contract::machine::{Machine, PlantSource, RealExpr};
use linewright_solver::mealy;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use text::{comment, identifier, long_string, string, wrap};

/// What was emitted for a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Emitted {
    /// The C file.
    pub source: String,
    /// The machine in it, without its description, the runtime and the adapter: what another adapter is put behind.
    pub unit: String,
    /// The contract hash that `station_describe` shows: of everything that decides how the machine behaves.
    pub contract_hash: String,
    /// The JSON text of `station_describe`.
    pub description: String,
}

/// Emits a machine with the controller of each of its components, in order.
///
/// # Panics
/// When they do not belong together.
pub fn emit(machine: &Machine, controllers: &[mealy::Controller], profile: &Profile) -> Emitted {
    super::assert_fit(machine, controllers);
    let wires = wire_names(machine);
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
    let body = body(machine, &emitters, &wires);
    let hash = hex(&Sha256::digest(format!("{sizes}{body}")));
    let description = describe::describe(machine, &hash, &profile.describe());
    let vendors = describe::describe(machine, &hash, &Profile::describe_vendors());
    // 1 to 1023: no handle is 0, and those of two machines hardly ever agree, even where only their names differ.
    let named = hex(&Sha256::digest(format!("{}\n{hash}", machine.name)));
    let mark = u64::from_str_radix(&named[..8], 16).unwrap_or(0) % 1023 + 1;
    let name = comment(&machine.name);
    let doc = comment(&machine.doc);
    let doc = if doc.trim().is_empty() {
        String::new()
    } else {
        format!(" *\n * {}\n", wrap(doc.trim(), " * "))
    };
    let unit = format!("{sizes}#define LW_HANDLE_MARK {mark}\n\n#include \"machine.h\"\n\n{body}");
    let source = format!(
        "/* The machine {name}, emitted by linewright from its contracts.\n{doc} *\n * Compile this file alone, with the files of ffi/ beside it:\n *\n *     cc -std=c99 -O2 -fPIC -shared -fvisibility=hidden -ffp-contract=off -pthread THIS.c -o THIS.so -lm\n */\n\
         {unit}#ifndef UF_USE_VENDOR_HEADER\nstatic const char lw_description[] =\n    {};\n#else\nstatic const char lw_description[] =\n    {};\n#endif\n\n\
         #include \"runtime.c\"\n#include \"plant_simulation.c\"\n",
        long_string(&description, "    "),
        long_string(&vendors, "    ")
    );
    Emitted {
        source,
        unit,
        contract_hash: hash,
        description,
    }
}

/// How many bytes of tables a machine takes in a station library, without names and formulas: what decides whether it had better be
/// functions.
pub fn table_bytes(machine: &mealy::Machine) -> usize {
    splits::Decisions::of(machine).bytes()
}

/// The sizes of all tables.
fn sizes(
    machine: &Machine,
    controllers: &[mealy::Controller],
    values: usize,
    justice: usize,
) -> String {
    let mut out = String::new();
    let sizes = [
        ("LW_COMPONENTS", machine.components.len()),
        ("LW_PLANT", machine.plant.len()),
        ("LW_OUTPUTS", machine.wire_count() - machine.plant.len()),
        ("LW_VALUES", values),
        ("LW_PROPERTIES", machine.properties.len()),
        ("LW_OPERATIONS", machine.operations.len()),
        ("LW_JUSTICE", justice),
    ];
    for (name, size) in sizes {
        let _ = writeln!(out, "#define {name} {size}");
    }
    let functions = machine.components.iter().zip(controllers);
    let functions = functions.filter(|(_, controller)| controller.functions().is_some());
    let shifted = functions.map(|(c, _)| {
        let variables = c.specification.variables.iter();
        variables.filter(|v| v.domain.low() != 0).count()
    });
    if let Some(most) = shifted.max() {
        let _ = writeln!(out, "#define LW_MOST_SHIFTED {most}");
    }
    let _ = writeln!(out, "#define LW_NUMBER {}", number(machine));
    let components = machine.components.iter().enumerate();
    let mut kinds = [
        ("LW_EACH_COMPONENT", String::new()),
        ("LW_EACH_MOORE", String::new()),
        ("LW_EACH_MEALY", String::new()),
    ];
    for (index, component) in components {
        let kind = match component.specification.timing {
            Timing::Moore => 1,
            Timing::Mealy => 2,
        };
        for kind in [0, kind] {
            let _ = write!(kinds[kind].1, " DO({index})");
        }
    }
    for (name, list) in kinds {
        let _ = writeln!(out, "#define {name}(DO){list}");
    }
    let limit = i64::try_from(machine.step_limit).unwrap_or(i64::MAX);
    let _ = writeln!(out, "#define LW_STEP_LIMIT {}", expression::literal(limit));
    let _ = writeln!(out, "#define LW_STEP_LIMIT_TEXT \"{limit}\"");
    let _ = writeln!(
        out,
        "#define LW_STEP_SECONDS {}",
        expression::real_literal(machine.step_seconds)
    );
    let _ = writeln!(
        out,
        "#define LW_BASE_WATTS {}",
        expression::real_literal(machine.base_watts)
    );
    out
}

/// The smallest type that holds every value of every variable and plant wire.
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
    let fits = |least: i64, most: i64| least <= low && high <= most;
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

fn body(machine: &Machine, emitters: &[Emitter<'_>], wires: &[String]) -> String {
    let mut out = String::new();
    if !wires.is_empty() {
        out.push_str("/* Where the plant's inputs and the components' outputs are among all values. */\nenum {\n");
        for (i, (name, value)) in wires.iter().zip(wire_values(machine)).enumerate() {
            let shown = comment(&machine.wire_name(i));
            let _ = writeln!(out, "    {name} = {value}, /* {shown} */");
        }
        out.push_str("};\n\n");
    }
    for emitter in emitters {
        out.push_str(&emitter.definitions());
    }
    let _ = writeln!(out, "/* ---- The machine {} */\n", "-".repeat(88));
    plant(&mut out, machine, wires);
    operations(&mut out, machine, wires);
    let components: Vec<String> = emitters.iter().map(Emitter::descriptor).collect();
    table(
        &mut out,
        "lw_component",
        "lw_component_table",
        &components,
        "{ 0 }",
    );
    let justice: Vec<String> = emitters.iter().flat_map(Emitter::justice_rules).collect();
    table(
        &mut out,
        "lw_rule",
        "lw_justice_table",
        &justice,
        "{ NULL, NULL }",
    );
    out
}

/// Where each wire is among all values: the plant's inputs come first, then each component's variables.
fn wire_values(machine: &Machine) -> Vec<usize> {
    let mut places: Vec<usize> = (0..machine.plant.len()).collect();
    let mut first = machine.plant.len();
    for component in &machine.components {
        let specification = &component.specification;
        places.extend(specification.outputs().map(|id| first + id.index()));
        first += specification.variables.len();
    }
    places
}

fn wire_names(machine: &Machine) -> Vec<String> {
    let mut names = Names::default();
    (0..machine.wire_count())
        .map(|w| names.unique(&format!("w_{}", identifier(&machine.wire_name(w)))))
        .collect()
}

/// A table of an enumeration's labels, each list once, and its name; `NULL` for other domains.
fn labels(out: &mut String, known: &mut BTreeMap<Vec<String>, String>, domain: &Domain) -> String {
    let Domain::Enum { labels, .. } = domain else {
        return "NULL".to_owned();
    };
    if let Some(name) = known.get(labels) {
        return name.clone();
    }
    let name = format!("labels_{}", known.len());
    let rows: Vec<String> = labels
        .iter()
        .map(|label| format!("    {},\n", string(label)))
        .collect();
    table(out, "char *const", &name, &rows, "NULL");
    known.insert(labels.clone(), name.clone());
    name
}

/// The plant's inputs and where they come from.
fn plant(out: &mut String, machine: &Machine, wires: &[String]) {
    let mut entries = Vec::new();
    for (i, input) in machine.plant.iter().enumerate() {
        let name = identifier(&input.name);
        let source = match &input.source {
            PlantSource::Operation => "LW_FROM_OPERATION, NULL, 0, NULL".to_owned(),
            PlantSource::Signal { script } => {
                let values: Vec<String> = script
                    .iter()
                    .map(|v| format!("    {},\n", expression::literal(*v)))
                    .collect();
                table(out, "int64_t", &format!("p{i}_{name}_script"), &values, "0");
                format!(
                    "LW_FROM_SCRIPT, p{i}_{name}_script, {}, NULL",
                    script.len().max(1)
                )
            }
            PlantSource::Property(expr) => {
                let _ = writeln!(
                    out,
                    "/* The property abstraction of {}. */",
                    comment(&input.name)
                );
                real_function(out, &format!("p{i}_{name}"), expr, wires);
                format!("LW_FROM_PROPERTY, NULL, 0, p{i}_{name}")
            }
        };
        entries.push(format!(
            "    {{ {}, {}, {}, {}, {source},\n        {} }},\n",
            string(&input.name),
            string(&input.describe()),
            expression::literal(input.domain.low()),
            expression::literal(input.domain.high()),
            string(&super::messages::about_abstraction(machine, input))
        ));
    }
    table(out, "lw_plant_input", "lw_plant_table", &entries, "{ 0 }");
}

/// Operations, properties, the end of an operation and what it leaves.
fn operations(out: &mut String, machine: &Machine, wires: &[String]) {
    let operations: Vec<String> = machine
        .operations
        .iter()
        .map(|o| {
            format!(
                "    {{ {}, {} }},\n",
                string(&o.name),
                expression::literal(o.value)
            )
        })
        .collect();
    table(
        out,
        "lw_operation",
        "lw_operation_table",
        &operations,
        "{ NULL, 0 }",
    );
    let mut known = BTreeMap::new();
    let outputs: Vec<String> = (machine.plant.len()..machine.wire_count())
        .zip(machine.components.iter().flat_map(|c| {
            let specification = &c.specification;
            specification
                .outputs()
                .map(|id| &specification.variable(id).domain)
        }))
        .map(|(wire, domain)| {
            let labels = labels(out, &mut known, domain);
            let name = string(&machine.wire_name(wire));
            format!("    {{ {name}, {}, {labels} }},\n", wires[wire])
        })
        .collect();
    table(
        out,
        "lw_wire",
        "lw_output_table",
        &outputs,
        "{ NULL, 0, NULL }",
    );
    let properties: Vec<String> = machine
        .properties
        .iter()
        .map(|p| format!("    {}, /* {} */\n", string(&p.name), comment(&p.unit)))
        .collect();
    table(out, "char *const", "lw_property_names", &properties, "NULL");
    let ranges: Vec<String> = machine
        .properties
        .iter()
        .map(|p| match &p.domain {
            Some(d) => format!(
                "    {{ 1, {}.0, {}.0, {} }}, /* {} */\n",
                d.low(),
                d.high(),
                labels(out, &mut known, d),
                comment(&d.describe())
            ),
            None => "    { 0, 0.0, 0.0, NULL },\n".to_owned(),
        })
        .collect();
    table(
        out,
        "lw_range",
        "lw_property_ranges",
        &ranges,
        "{ 0, 0.0, 0.0, NULL }",
    );
    let done = machine.done.as_ref().map_or_else(
        || "0".to_owned(),
        |d| expression::truth(d, &|v: VarId, _| format!("values[{}]", wires[v.index()])),
    );
    let unused = if done.contains("values[") {
        ""
    } else {
        "    (void)values;\n"
    };
    let _ = writeln!(
        out,
        "/* Whether the operation has ended. */\nstatic int machine_done(const int64_t *values)\n{{\n{unused}    return {};\n}}\n",
        wrap(&done, "        ")
    );
    let mut writes = String::new();
    for (property, expr) in &machine.writes {
        let value = expression::real(expr, wires);
        let line = format!("after[{property}] = {value};");
        let _ = writeln!(
            writes,
            "    /* {} */\n    {}",
            comment(&machine.properties[*property].name),
            wrap(&line, "        ")
        );
    }
    let _ = writeln!(
        out,
        "/* What an operation leaves in the part. */\nstatic void machine_write(const double *properties, const int64_t *values, double *after)\n{{\n{}{writes}}}\n",
        unused_parameters(&writes, &["properties", "values", "after"])
    );
}

/// A function of type `lw_real`.
fn real_function(out: &mut String, name: &str, expr: &RealExpr, wires: &[String]) {
    let value = expression::real(expr, wires);
    let _ = writeln!(
        out,
        "static double {name}(const double *properties, const int64_t *values)\n{{\n{}    return {};\n}}\n",
        unused_parameters(&value, &["properties", "values"]),
        wrap(&value, "        ")
    );
}

fn unused_parameters(body: &str, names: &[&str]) -> String {
    names
        .iter()
        .filter(|name| !body.contains(&format!("{name}[")))
        .fold(String::new(), |s, name| s + &format!("    (void){name};\n"))
}

/// A constant table. C has no empty arrays: one without rows holds `empty`.
fn table(out: &mut String, of: &str, name: &str, rows: &[String], empty: &str) {
    let rows = if rows.is_empty() {
        format!("    {empty}\n")
    } else {
        rows.concat()
    };
    let _ = writeln!(out, "static const {of} {name}[] = {{\n{rows}}};\n");
}

/// Hands out names, each once.
#[derive(Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    pub(super) fn unique(&mut self, wish: &str) -> String {
        let mut name = wish.to_owned();
        let mut number = 2;
        while !self.0.insert(name.clone()) {
            name = format!("{wish}_{number}");
            number += 1;
        }
        name
    }
}

/// Bytes in hexadecimal.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut s, b| {
        let _ = write!(s, "{b:02x}");
        s
    })
}
