//! Emits a machine: its wires, its components one after the other, its plant, operations and
//! properties.

use super::Names;
use super::component::{Emitter, Entry, Rule, unused};
use super::expression;
use super::text::{comment, identifier, string, wrap};
use crate::messages;
use crate::template::render;
use linewright_core::gr1::{Domain, VarId};
use linewright_language::contract::machine::{Machine, PlantInput, PlantSource, RealExpr};
use serde::Serialize;
use std::collections::BTreeMap;

/// The fields of `machine.c`.
#[derive(Serialize)]
struct Body {
    wires: Vec<Wire>,
    /// Definitions of each component.
    definitions: Vec<String>,
    plant: Vec<Plant>,
    operations: Vec<Operation>,
    output_labels: Vec<Labels>,
    outputs: Vec<Output>,
    properties: Vec<Property>,
    /// Lists of labels that properties use but outputs do not.
    property_labels: Vec<Labels>,
    done: Function,
    unused_by_writes: Vec<&'static str>,
    writes: Vec<Write>,
    components: Vec<Entry>,
    justice: Vec<Rule>,
}

#[derive(Serialize)]
struct Wire {
    name: String,
    value: usize,
    about: String,
}

/// An input of the plant.
#[derive(Serialize)]
struct Plant {
    /// Prefix of the input's script and abstraction function: `p1_turned`.
    prefix: String,
    name: String,
    domain: String,
    low: String,
    high: String,
    source: &'static str,
    /// Fields of the input's row in the table of plant inputs.
    fields: String,
    about: String,
    script: Vec<String>,
    abstraction: Option<Function>,
    /// Beginning of the message for a value outside the input's domain.
    message: String,
}

#[derive(Serialize)]
struct Operation {
    name: String,
    value: String,
}

/// A list of labels and its name.
#[derive(Serialize)]
struct Labels {
    name: String,
    labels: Vec<String>,
}

#[derive(Serialize)]
struct Output {
    name: String,
    wire: String,
    labels: String,
}

#[derive(Serialize)]
struct Property {
    name: String,
    unit: String,
    range: Option<Range>,
}

#[derive(Serialize)]
struct Range {
    low: i64,
    high: i64,
    labels: String,
    about: String,
}

/// The value that an operation writes to a property.
#[derive(Serialize)]
struct Write {
    about: String,
    statement: String,
}

/// The body of a C function that returns a value.
#[derive(Serialize)]
pub(super) struct Function {
    /// Parameters that the value does not read.
    unused: Vec<&'static str>,
    value: String,
}

impl Function {
    /// A function of wires that returns a truth value.
    pub fn condition(value: &str) -> Self {
        Self {
            unused: unused([value], &["values"]),
            value: wrap(value, "        "),
        }
    }

    /// A function of type `lw_real`.
    pub fn real(expr: &RealExpr, wires: &[String]) -> Self {
        let value = expression::real(expr, wires);
        Self {
            unused: unused([value.as_str()], &["properties", "values"]),
            value: wrap(&value, "        "),
        }
    }
}

/// Renders all definitions of a machine.
pub(super) fn definitions(machine: &Machine, emitters: &[Emitter<'_>], wires: &[String]) -> String {
    let definitions = emitters.iter().map(Emitter::definitions);
    let plant = machine.plant.iter().enumerate();
    let operations = machine.operations.iter().map(|o| Operation {
        name: string(&o.name),
        value: expression::literal(o.value),
    });
    let mut known = BTreeMap::new();
    let (mut output_labels, mut property_labels) = (Vec::new(), Vec::new());
    let outputs = outputs(machine, wires, &mut known, &mut output_labels);
    let properties = machine.properties.iter().map(|p| Property {
        name: string(&p.name),
        unit: comment(&p.unit),
        range: p.domain.as_ref().map(|d| Range {
            low: d.low(),
            high: d.high(),
            labels: labels(&mut property_labels, &mut known, d),
            about: comment(&d.describe()),
        }),
    });
    let properties = properties.collect();
    let done = machine.done.as_ref().map_or_else(
        || "0".to_owned(),
        |d| expression::truth(d, &|v: VarId, _| format!("values[{}]", wires[v.index()])),
    );
    let writes: Vec<Write> = machine
        .writes
        .iter()
        .map(|(property, expr)| {
            let statement = format!("after[{property}] = {};", expression::real(expr, wires));
            Write {
                about: comment(&machine.properties[*property].name),
                statement: wrap(&statement, "        "),
            }
        })
        .collect();
    render(
        "station/machine.c",
        Body {
            wires: wire_list(machine, wires),
            definitions: definitions.map(|d| d.trim_end().to_owned()).collect(),
            plant: plant
                .map(|(i, input)| plant_input(machine, i, input, wires))
                .collect(),
            operations: operations.collect(),
            output_labels,
            outputs,
            properties,
            property_labels,
            done: Function::condition(&done),
            unused_by_writes: unused(
                writes.iter().map(|w| w.statement.as_str()),
                &["properties", "values", "after"],
            ),
            writes,
            components: emitters.iter().map(Emitter::entry).collect(),
            justice: emitters.iter().flat_map(Emitter::justice_rules).collect(),
        },
    )
}

fn wire_list(machine: &Machine, wires: &[String]) -> Vec<Wire> {
    let wires = wires
        .iter()
        .zip(wire_values(machine))
        .enumerate()
        .map(|(i, (name, value))| Wire {
            name: name.clone(),
            value,
            about: comment(&machine.wire_name(i)),
        });
    wires.collect()
}

/// Index of each wire among all values: the plant's inputs come first, then each component's
/// variables.
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

/// The names of a machine's wires as enumeration constants.
pub(super) fn wire_names(machine: &Machine) -> Vec<String> {
    let mut names = Names::default();
    (0..machine.wire_count())
        .map(|w| names.unique(&format!("w_{}", identifier(&machine.wire_name(w)))))
        .collect()
}

/// Returns the name of an enumeration's list of labels, and adds the list to `out` if it is new;
/// `NULL` for other domains.
fn labels(
    out: &mut Vec<Labels>,
    known: &mut BTreeMap<Vec<String>, String>,
    domain: &Domain,
) -> String {
    let Domain::Enum { labels, .. } = domain else {
        return "NULL".to_owned();
    };
    if let Some(name) = known.get(labels) {
        return name.clone();
    }
    let name = format!("labels_{}", known.len());
    out.push(Labels {
        name: name.clone(),
        labels: labels.iter().map(|label| string(label)).collect(),
    });
    known.insert(labels.clone(), name.clone());
    name
}

/// An input of the plant and its source.
fn plant_input(machine: &Machine, index: usize, input: &PlantInput, wires: &[String]) -> Plant {
    let prefix = format!("p{index}_{}", identifier(&input.name));
    let mut script = Vec::new();
    let mut abstraction = None;
    let (source, fields) = match &input.source {
        PlantSource::Operation => ("operation", "LW_FROM_OPERATION, NULL, 0, NULL".to_owned()),
        PlantSource::Signal { script: values } => {
            script.extend(values.iter().map(|v| expression::literal(*v)));
            let count = values.len().max(1);
            let fields = format!("LW_FROM_SCRIPT, {prefix}_script, {count}, NULL");
            ("script", fields)
        }
        PlantSource::Property(expr) => {
            abstraction = Some(Function::real(expr, wires));
            let fields = format!("LW_FROM_PROPERTY, NULL, 0, {prefix}");
            ("property", fields)
        }
    };
    Plant {
        prefix,
        name: string(&input.name),
        domain: string(&input.describe()),
        low: expression::literal(input.domain.low()),
        high: expression::literal(input.domain.high()),
        source,
        fields,
        about: comment(&input.name),
        script,
        abstraction,
        message: string(&messages::abstraction_prefix(machine, input)),
    }
}

/// Entries of the table of outputs, for all components.
fn outputs(
    machine: &Machine,
    wires: &[String],
    known: &mut BTreeMap<Vec<String>, String>,
    lists: &mut Vec<Labels>,
) -> Vec<Output> {
    let domains = machine.components.iter().flat_map(|c| {
        let specification = &c.specification;
        let outputs = specification.outputs();
        outputs.map(|id| &specification.variable(id).domain)
    });
    let outputs = (machine.plant.len()..machine.wire_count())
        .zip(domains)
        .map(|(wire, domain)| Output {
            name: string(&machine.wire_name(wire)),
            wire: wires[wire].clone(),
            labels: labels(lists, known, domain),
        });
    outputs.collect()
}
