//! The SimTalk 2 text that calls a station library from Plant Simulation, and the page with import
//! instructions.
//!
//! Little of SimTalk is public: `loadLibrary`, `callLibrary`, `freeLibrary`, `@` for the part, `?`
//! for the station, and `?.Failed := true` (Spellini et al. 2021, Listing 2). The methods use as
//! few other built-ins as possible, and list those that they assume. Unlike Listing 2, the methods
//! load the library once, when the model starts, create one instance per station, pass every
//! argument that an export reads, and check for every negative code.
//!
//! Names that the user has to create begin with `LW_`, so that they do not clash with an existing
//! attribute of a station or part.

use super::package::Package;
use super::probe::Value;
use super::profile::Profile;
use super::template::render;
use super::toolchain;
use linewright_core::gr1::Domain;
use linewright_language::contract::machine::{Machine, PropertyKind};
use serde::Serialize;
use std::collections::BTreeSet;

/// Texts for one machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Texts {
    /// The methods.
    pub methods: String,
    /// The page with import instructions, in Markdown.
    pub page: String,
}

/// Endings of the file names of methods and page, which follow the library's name without
/// extension.
pub const ENDINGS: [&str; 2] = [".simtalk.txt", ".import.md"];

/// Form of the library that the texts accompany.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LibraryForm<'a> {
    /// A compiled library, and a folder that holds its C source.
    Library {
        /// File name of the library.
        library: &'a str,
        /// Name of the source folder.
        source: &'a str,
    },
    /// The C source, which the user compiles into the library.
    Source {
        /// File name of the library.
        library: &'a str,
    },
}

impl<'a> LibraryForm<'a> {
    fn library(self) -> &'a str {
        match self {
            Self::Library { library, .. } | Self::Source { library } => library,
        }
    }
}

/// Formats a value as a SimTalk literal.
pub fn literal(value: &Value) -> String {
    match value {
        Value::Integer(i) => i.to_string(),
        Value::Real(x) | Value::Time(x) => format!("{x:?}"),
        Value::Text(t) => quoted(t),
        Value::Boolean(b) => b.to_string(),
    }
}

/// Puts a text in quotes. Names in contracts contain no quotes; quotes in other texts become
/// apostrophes.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "'"))
}

/// Renders the texts for a machine.
pub fn texts(
    machine: &Machine,
    package: &Package,
    profile: &Profile,
    form: LibraryForm<'_>,
) -> Texts {
    let names = Names::of(machine);
    let writer = Writer {
        machine,
        package,
        profile,
        library: form.library(),
        form,
        names,
    };
    Texts {
        methods: writer.methods(),
        page: writer.page(),
    }
}

/// Names that the user creates.
struct Names {
    /// The machine's name as part of a name: `AssemblyCell`.
    machine: String,
    /// The variable that holds the library's handle.
    library: String,
    /// Attributes, one per property.
    attributes: Vec<String>,
}

impl Names {
    fn of(machine: &Machine) -> Self {
        let own = plain(&machine.name);
        // SimTalk does not distinguish `A` from `a`.
        let mut taken: BTreeSet<String> = ["lw_handle", "lw_operation", "lw_energy"]
            .map(str::to_owned)
            .into();
        let attributes = machine.properties.iter().map(|property| {
            let base = format!("LW_{}", plain(&property.name));
            let mut name = base.clone();
            let mut number = 2;
            while !taken.insert(name.to_lowercase()) {
                name = format!("{base}_{number}");
                number += 1;
            }
            name
        });
        Self {
            attributes: attributes.collect(),
            library: format!("LW_{own}"),
            machine: own,
        }
    }
}

/// Reduces a name to ASCII letters, digits and single underscores: `heights[2]` becomes
/// `heights_2`.
fn plain(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            c if c.is_ascii_alphanumeric() => out.push(c),
            ']' => {}
            _ if !out.ends_with('_') => out.push('_'),
            _ => {}
        }
    }
    out
}

struct Writer<'a> {
    machine: &'a Machine,
    package: &'a Package,
    profile: &'a Profile,
    library: &'a str,
    form: LibraryForm<'a>,
    names: Names,
}

/// The fields of `methods.txt`.
#[derive(Serialize)]
struct Methods<'a> {
    name: &'a str,
    library: &'a str,
    library_file: &'a str,
    profile: String,
    verified: bool,
    page: String,
    operations: String,
    properties: Vec<Property<'a>>,
    /// Properties that an operation writes.
    written: Vec<Property<'a>>,
}

/// The fields of `import.md`.
#[derive(Serialize)]
struct Page<'a> {
    name: &'a str,
    library: &'a str,
    library_file: &'a str,
    methods: String,
    source: &'a str,
    /// Name of the source folder, for a compiled library.
    source_folder: Option<&'a str>,
    /// Commands that compile the source manually.
    commands: [String; 2],
    profile: String,
    verified: bool,
    /// SimTalk type of a handle.
    handle: &'static str,
    operations: String,
    parameters: Vec<AttributeRow<'a>>,
    part_properties: Vec<AttributeRow<'a>>,
    /// Number of the first instruction after those about attributes.
    step: usize,
    contract_hash: &'a str,
}

/// A property in the methods.
#[derive(Serialize)]
struct Property<'a> {
    /// `@` for the part, `?` for the station.
    holder: &'static str,
    attribute: &'a str,
    name: &'a str,
    unit: &'a str,
    /// Name of the property's result in the library, in quotes.
    result: String,
}

/// A property as an attribute that the user creates.
#[derive(Serialize)]
struct AttributeRow<'a> {
    attribute: &'a str,
    name: &'a str,
    /// `, in mm`, or empty.
    unit: String,
    /// `, 0..3`, or empty.
    values: String,
    default: String,
}

impl Writer<'_> {
    fn methods(&self) -> String {
        let machine = self.machine;
        let property = |index: usize| {
            let property = &machine.properties[index];
            Property {
                holder: holder(property.kind),
                attribute: &self.names.attributes[index],
                name: &property.name,
                unit: &property.unit,
                result: quoted(&format!("property.{}", property.name)),
            }
        };
        let written = machine.writes.iter().map(|(index, _)| property(*index));
        render(
            "simtalk/methods.txt",
            Methods {
                name: &self.names.machine,
                library: &self.names.library,
                library_file: self.library,
                profile: self.profile.label(),
                verified: self.profile.is_verified(),
                page: page_name(self.library),
                operations: self.operations(),
                properties: (0..machine.properties.len()).map(property).collect(),
                written: written.collect(),
            },
        )
    }

    /// Lists the operations: `0 turn, 1 hold`. Empty if there are no operations.
    fn operations(&self) -> String {
        let operations: Vec<String> = self
            .machine
            .operations
            .iter()
            .enumerate()
            .map(|(i, o)| format!("{i} {}", o.name))
            .collect();
        operations.join(", ")
    }

    fn page(&self) -> String {
        let source = format!("{}.c", self.package.stem);
        let part_properties = self.attributes(PropertyKind::Part);
        render(
            "simtalk/import.md",
            Page {
                name: &self.names.machine,
                library: &self.names.library,
                library_file: self.library,
                methods: methods_name(self.library),
                source: &source,
                source_folder: match self.form {
                    LibraryForm::Library { source, .. } => Some(source),
                    LibraryForm::Source { .. } => None,
                },
                commands: toolchain::manual_commands(&source, self.library),
                profile: self.profile.label(),
                verified: self.profile.is_verified(),
                handle: if self.profile.layout.integer_bits == 16 {
                    "real"
                } else {
                    "integer"
                },
                operations: self.operations(),
                parameters: self.attributes(PropertyKind::Parameter),
                step: if part_properties.is_empty() { 5 } else { 6 },
                part_properties,
                contract_hash: &self.package.contract_hash,
            },
        )
    }

    /// Attributes for the properties of one kind.
    fn attributes(&self, kind: PropertyKind) -> Vec<AttributeRow<'_>> {
        let properties = self
            .machine
            .properties
            .iter()
            .zip(&self.names.attributes)
            .filter(|(p, _)| p.kind == kind);
        let attributes = properties.map(|(p, attribute)| AttributeRow {
            attribute,
            name: &p.name,
            unit: match p.unit.as_str() {
                "" => String::new(),
                unit => format!(", in {unit}"),
            },
            values: p
                .domain
                .as_ref()
                .map_or(String::new(), |d| format!(", {}", numbers(d))),
            default: p.default.to_string(),
        });
        attributes.collect()
    }
}

/// Lists the numbers that stand for a property's values: `0 false, 1 true`.
fn numbers(domain: &Domain) -> String {
    match domain {
        Domain::Bool => "0 false, 1 true".to_owned(),
        Domain::Range { .. } => domain.describe(),
        Domain::Enum { labels, .. } => {
            let numbered = labels.iter().enumerate();
            let words: Vec<String> = numbered.map(|(i, l)| format!("{i} {l}")).collect();
            words.join(", ")
        }
    }
}

/// SimTalk symbol of the object that holds a property.
fn holder(kind: PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Part => "@",
        PropertyKind::Parameter => "?",
    }
}

/// The library's name without extension.
pub fn stem(library: &str) -> &str {
    library.rsplit_once('.').map_or(library, |(stem, _)| stem)
}

/// File name of the methods for a library's file name.
pub fn methods_name(library: &str) -> String {
    format!("{}{}", stem(library), ENDINGS[0])
}

/// File name of the page for a library's file name.
pub fn page_name(library: &str) -> String {
    format!("{}{}", stem(library), ENDINGS[1])
}
