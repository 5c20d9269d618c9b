//! The variables of a unit: their names, types and values.
//!
//! The names of variables that every unit has are fixed; the names of the machine's variables
//! follow the standard's structured convention: `turn_a.angle`, `part.heights[0]`. In each part of
//! a name, characters other than ASCII letters and digits become `_`, and a duplicate name gets a
//! number, so that every importer can convert names to identifiers. Groups, their indices, and
//! types are those of `ffi/fmi.h`.

use linewright_core::gr1::{Domain, describe_domain};
use linewright_language::contract::machine::{Machine, PlantSource, Property, PropertyKind};
use std::collections::BTreeSet;

/// Role of a variable for the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Causality {
    /// Time.
    Independent,
    /// Set by the host in every step.
    Input,
    /// Set by the host at any time.
    Parameter,
    /// Read by the host.
    Output,
    /// Read by the host for inspection.
    Local,
}

/// The type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A real number.
    Real,
    /// A 32-bit integer.
    Integer,
    /// A 64-bit integer; FMI 2 has none and uses a real number.
    Long,
    /// A truth value.
    Boolean,
    /// An enumeration, by its index in [`Interface::enumerations`].
    Enumeration(usize),
}

/// Start value of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Start value of a real number.
    Real(f64),
    /// Start value of any other type, in the machine's numbering: labels count from 0.
    Whole(i64),
}

/// A variable of a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name of the variable.
    pub name: String,
    /// Value reference.
    pub reference: u32,
    /// Role for the host.
    pub causality: Causality,
    /// Data type.
    pub kind: Kind,
    /// Unit of a real number; empty if it has none.
    pub unit: String,
    /// Smallest and largest value, if known.
    pub limits: Option<(i64, i64)>,
    /// Start value, for inputs and parameters.
    pub start: Option<Start>,
    /// Description for users.
    pub description: String,
}

/// Labels of an enumeration; the host numbers them from 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: String,
    /// Labels in order.
    pub labels: Vec<String>,
    /// Preferred name of the type.
    preferred: String,
}

/// All variables of a unit in the order of its description, and their types.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interface {
    /// Variables in order.
    pub variables: Vec<Variable>,
    /// Enumeration types.
    pub enumerations: Vec<Enumeration>,
    names: Names,
}

/// Returns the value reference of an index in a group.
pub fn reference(group: u32, index: usize) -> u32 {
    group * 0x10_0000 + index as u32
}

/// Groups of value references.
pub mod group {
    /// Variables that every unit has.
    pub const UNIT: u32 = 0;
    /// The plant's signals, by wire.
    pub const SIGNALS: u32 = 1;
    /// Properties and parameters set by the host.
    pub const GIVEN: u32 = 2;
    /// Properties after the last completed operation.
    pub const RESULTS: u32 = 3;
    /// Wires after the last step.
    pub const WIRES: u32 = 4;
}

/// Returns the type of variables with this domain. For an enumeration, the index is 0 until the
/// caller sets it.
pub(super) fn kind(domain: &Domain) -> Kind {
    match domain {
        Domain::Bool => Kind::Boolean,
        Domain::Enum { .. } => Kind::Enumeration(0),
        Domain::Range { low, high } => {
            let fits = |v: &i64| i32::try_from(*v).is_ok();
            if fits(low) && fits(high) {
                Kind::Integer
            } else {
                Kind::Long
            }
        }
    }
}

impl Interface {
    /// Creates the variables of a machine's unit; `first_operation` is the start value of
    /// `operation`.
    pub fn of(machine: &Machine, first_operation: usize) -> Self {
        let mut all = Self::default();
        all.general(machine, first_operation);
        all.inputs(machine);
        all.outputs(machine);
        // Types and variables share a namespace. Variables are named first, because users see them.
        for enumeration in &mut all.enumerations {
            enumeration.name = all.names.unique(&enumeration.preferred);
        }
        all
    }

    /// Finds the variable with a name.
    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|v| v.name == name)
    }

    fn add(
        &mut self,
        preferred: &str,
        reference: u32,
        causality: Causality,
        kind: Kind,
        about: String,
    ) {
        let name = self.names.unique(preferred);
        self.variables.push(Variable {
            name,
            reference,
            causality,
            kind,
            unit: String::new(),
            limits: None,
            start: None,
            description: about,
        });
    }

    fn last(&mut self) -> &mut Variable {
        self.variables
            .last_mut()
            .expect("a variable was just added")
    }

    /// Adds the variables that every unit has, with the indices of `ffi/fmi.h`.
    fn general(&mut self, machine: &Machine, first_operation: usize) {
        use Causality::{Independent, Input, Output};
        // `time` comes first, so that no other variable gets that name.
        type Row = (
            &'static str,
            usize,
            Causality,
            Kind,
            &'static str,
            &'static str,
        );
        let always: [Row; 6] = [
            ("time", 0, Independent, Kind::Real, "s", "simulated time"),
            (
                "enabled",
                1,
                Input,
                Kind::Boolean,
                "",
                "whether the machine works; otherwise it stays in its state, with idle power",
            ),
            (
                "total.seconds",
                2,
                Output,
                Kind::Real,
                "s",
                "duration of all steps by the machine's declared times, including idle steps",
            ),
            (
                "total.joules",
                3,
                Output,
                Kind::Real,
                "J",
                "energy of all steps, including idle steps",
            ),
            (
                "total.steps",
                4,
                Output,
                Kind::Long,
                "",
                "number of steps of the controllers",
            ),
            (
                "verdict",
                5,
                Output,
                Kind::Integer,
                "",
                concat!(
                    "0, or the error code of the last failed step: -3 a value outside its domain, ",
                    "-5 a broken assumption, -6 a broken guarantee, -7 the step limit, ",
                    "-9 a bug of the generator, -10 a skill called against an order"
                ),
            ),
        ];
        let with_operations: [Row; 6] = [
            (
                "operation",
                6,
                Input,
                Kind::Enumeration(0),
                "",
                "operation to begin next; does not affect an operation in progress",
            ),
            (
                "done",
                7,
                Output,
                Kind::Boolean,
                "",
                "whether the last step ended an operation",
            ),
            (
                "completed",
                8,
                Output,
                Kind::Long,
                "",
                "number of completed operations",
            ),
            (
                "last.seconds",
                9,
                Output,
                Kind::Real,
                "s",
                "duration of the last completed operation by the machine's declared times",
            ),
            (
                "last.joules",
                10,
                Output,
                Kind::Real,
                "J",
                "energy of the last completed operation",
            ),
            (
                "last.steps",
                11,
                Output,
                Kind::Long,
                "",
                "number of steps of the last completed operation",
            ),
        ];
        let rows = if machine.operations.is_empty() {
            &with_operations[..0]
        } else {
            &with_operations[..]
        };
        for (name, index, causality, kind, unit, about) in always.iter().chain(rows) {
            self.add(
                name,
                reference(group::UNIT, *index),
                *causality,
                *kind,
                (*about).to_owned(),
            );
            (*unit).clone_into(&mut self.last().unit);
            if *causality == Input {
                self.last().start = Some(Start::Whole(1));
            }
            if *name == "operation" {
                self.last().start = Some(Start::Whole(first_operation as i64));
                let labels: Vec<String> =
                    machine.operations.iter().map(|o| o.name.clone()).collect();
                self.last().kind = Kind::Enumeration(self.enumeration("Operation", &labels));
            }
        }
    }

    fn inputs(&mut self, machine: &Machine) {
        for (wire, input) in machine.plant.iter().enumerate() {
            if let PlantSource::Signal { script } = &input.source {
                let about = format!("signal of the plant: {}", input.describe());
                let reference = reference(group::SIGNALS, wire);
                self.domain(
                    &input.name,
                    reference,
                    Causality::Input,
                    &input.domain,
                    about,
                );
                self.last().start = Some(Start::Whole(script[0]));
            }
        }
        for (index, property) in machine.properties.iter().enumerate() {
            let (name, causality, what) = match property.kind {
                PropertyKind::Part => (
                    format!("part.{}", property.name),
                    Causality::Input,
                    "property of the part, read when an operation begins",
                ),
                PropertyKind::Parameter => (
                    property.name.clone(),
                    Causality::Parameter,
                    "parameter of the operation, read when it begins",
                ),
            };
            self.property(
                property,
                &name,
                reference(group::GIVEN, index),
                causality,
                what,
            );
            self.last().start = Some(Start::Real(property.default));
            let limits = property.domain.as_ref();
            self.last().limits = limits.map(|d| (d.low(), d.high()));
        }
    }

    fn outputs(&mut self, machine: &Machine) {
        let mut wire = machine.plant.len();
        for component in &machine.components {
            for id in component.specification.outputs() {
                let variable = component.specification.variable(id);
                let name = format!("{}.{}", component.name, variable.name);
                let causality = if variable.internal {
                    Causality::Local
                } else {
                    Causality::Output
                };
                let about = format!(
                    "output of `{}`, a {}: {}",
                    component.name,
                    component.contract,
                    variable.describe()
                );
                let reference = reference(group::WIRES, wire);
                self.domain(&name, reference, causality, &variable.domain, about);
                wire += 1;
            }
        }
        if !machine.operations.is_empty() {
            for (index, property) in machine.properties.iter().enumerate() {
                if property.kind == PropertyKind::Part {
                    let name = format!("result.{}", property.name);
                    let what = "property of the part after the last completed operation";
                    let reference = reference(group::RESULTS, index);
                    self.property(property, &name, reference, Causality::Output, what);
                }
            }
        }
        for (wire, input) in machine.plant.iter().enumerate() {
            if matches!(input.source, PlantSource::Property(_)) {
                let about = format!(
                    "property of the part as the controllers see it: {}",
                    input.describe()
                );
                let reference = reference(group::WIRES, wire);
                self.domain(
                    &input.name,
                    reference,
                    Causality::Local,
                    &input.domain,
                    about,
                );
            }
        }
    }

    /// Adds a real variable for a property.
    fn property(
        &mut self,
        property: &Property,
        preferred: &str,
        reference: u32,
        causality: Causality,
        what: &str,
    ) {
        let domain = property.domain.as_ref();
        let about = match domain {
            Some(Domain::Enum { labels, .. }) => {
                let labels = labels.iter().enumerate().map(|(i, l)| format!("{i} {l}"));
                format!("{what}: {}", labels.collect::<Vec<_>>().join(", "))
            }
            Some(domain) => format!("{what}: {}", describe_domain(domain, &property.unit)),
            None => what.to_owned(),
        };
        self.add(preferred, reference, causality, Kind::Real, about);
        self.last().unit.clone_from(&property.unit);
    }

    /// Adds a variable with a finite domain.
    fn domain(
        &mut self,
        preferred: &str,
        reference: u32,
        causality: Causality,
        domain: &Domain,
        about: String,
    ) {
        self.add(preferred, reference, causality, kind(domain), about);
        match domain {
            Domain::Enum { name, labels } => {
                let own = format!("{}_labels", preferred.replace(['.', '[', ']'], "_"));
                let type_name = name.as_deref().unwrap_or(&own);
                self.last().kind = Kind::Enumeration(self.enumeration(type_name, labels));
            }
            Domain::Range { low, high } => self.last().limits = Some((*low, *high)),
            Domain::Bool => {}
        }
    }

    /// Returns the index of the enumeration with this preferred name and these labels, and adds it
    /// if it does not exist.
    fn enumeration(&mut self, preferred: &str, labels: &[String]) -> usize {
        // The rules for names also apply to labels.
        let mut names = Names::default();
        let labels: Vec<String> = labels.iter().map(|l| names.unique(l)).collect();
        let known = |e: &Enumeration| e.labels == labels && e.preferred == preferred;
        if let Some(index) = self.enumerations.iter().position(known) {
            return index;
        }
        self.enumerations.push(Enumeration {
            name: String::new(),
            labels,
            preferred: preferred.to_owned(),
        });
        self.enumerations.len() - 1
    }
}

/// Assigns unique names.
#[derive(Debug, Clone, Default, PartialEq)]
struct Names(BTreeSet<String>);

impl Names {
    fn unique(&mut self, preferred: &str) -> String {
        let (stem, indices) = structured(preferred);
        let mut name = format!("{stem}{indices}");
        let mut number = 2;
        while !self.0.insert(name.clone()) {
            name = format!("{stem}_{number}{indices}");
            number += 1;
        }
        name
    }
}

/// Converts a name to the structured convention and splits off its last indices: `a.b[0].c[1][2]`
/// becomes `a.b[0].c` and `[1,2]`.
fn structured(name: &str) -> (String, String) {
    let segments: Vec<(String, String)> = name.split('.').map(segment).collect();
    let mut stem = String::new();
    for (i, (base, indices)) in segments.iter().enumerate() {
        if i > 0 {
            stem.push('.');
        }
        stem.push_str(base);
        if i + 1 < segments.len() {
            stem.push_str(indices);
        }
    }
    (
        stem,
        segments.last().map(|s| s.1.clone()).unwrap_or_default(),
    )
}

/// Converts one part of a name, and splits it into an identifier and indices.
fn segment(text: &str) -> (String, String) {
    let is_index = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    if let Some((base, rest)) = text.split_once('[')
        && let Some(rest) = rest.strip_suffix(']')
        && rest.split("][").all(is_index)
    {
        return (plain(base), format!("[{}]", rest.replace("][", ",")));
    }
    (plain(text), String::new())
}

/// Converts a text to an identifier that every importer accepts.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if out.is_empty() && !c.is_ascii_alphabetic() && c != '_' {
            out.push('_');
        }
        out.push(if c.is_ascii_alphanumeric() { c } else { '_' });
    }
    if out.is_empty() {
        out.push('_');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn names_are_structured_and_unique() {
        let mut names = Names::default();
        let cases = [
            ("turn_a.angle", "turn_a.angle"),
            ("part.heights[0]", "part.heights[0]"),
            ("grid[1][2]", "grid[1,2]"),
            ("grid[1][2]", "grid_2[1,2]"),
            ("a[0].b", "a[0].b"),
            ("a[x]", "a_x_"),
            ("a<b>&\"c\"", "a_b___c_"),
            ("Fräse 1", "Fr_se_1"),
            ("1st", "_1st"),
            ("", "_"),
            ("", "__2"),
            ("..", "_._._"),
        ];
        for (preferred, name) in cases {
            assert_eq!(names.unique(preferred), name);
        }
    }
}
