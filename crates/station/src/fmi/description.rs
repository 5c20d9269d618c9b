//! Writes `modelDescription.xml`, from which a host gets the data about a unit before loading it.
//! There is one text per version of the standard, because the versions use different names.
//!
//! An output never depends on an input of the same instant, because outputs change only in steps.
//! The description declares this, so that hosts detect no algebraic loops. The build time is
//! omitted, so that the same contract gives the same bytes.

use super::units::definition;
use super::variables::{Causality, Enumeration, Kind, Start, Variable};
use super::{Unit, Version};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::collections::BTreeSet;

/// Names and values of an element's attributes, in order.
type Attributes = Vec<(&'static str, String)>;

/// Name and version of this program, as written into files.
pub(super) const TOOL: &str = concat!("Linewright ", env!("CARGO_PKG_VERSION"));

/// Number of machine steps in the default experiment, which hosts use if no duration is set.
const EXPERIMENT_STEPS: f64 = 100.0;

/// Writes elements sequentially. Writing to memory cannot fail.
pub(super) struct Xml(Writer<Vec<u8>>);

impl Xml {
    pub fn new() -> Self {
        let mut xml = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.write(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        xml
    }

    fn write(&mut self, event: Event<'_>) {
        self.0
            .write_event(event)
            .expect("writing into memory does not fail");
    }

    fn start(name: &str, attributes: &Attributes) -> BytesStart<'static> {
        let mut start = BytesStart::new(name.to_owned());
        for (key, value) in attributes {
            start.push_attribute((*key, printable(value).as_str()));
        }
        start
    }

    /// Writes an element without content.
    pub fn element(&mut self, name: &str, attributes: &Attributes) {
        self.write(Event::Empty(Self::start(name, attributes)));
    }

    /// Writes an element with content.
    pub fn within(&mut self, name: &str, attributes: &Attributes, content: impl FnOnce(&mut Self)) {
        self.write(Event::Start(Self::start(name, attributes)));
        content(self);
        self.write(Event::End(BytesEnd::new(name.to_owned())));
    }

    pub fn text(self) -> String {
        let mut bytes = self.0.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).expect("only text was written")
    }
}

/// Replaces line breaks by spaces, and characters that XML does not allow by `?`.
pub(super) fn printable(text: &str) -> String {
    let visible = |c: char| match c {
        '\n' | '\t' | '\r' => ' ',
        c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => '?',
        c => c,
    };
    text.chars().map(visible).collect()
}

/// Renders the description of a unit.
pub(super) fn description(unit: &Unit) -> String {
    let two = unit.version == Version::Two;
    let mut head: Attributes = vec![
        ("fmiVersion", if two { "2.0" } else { "3.0" }.to_owned()),
        ("modelName", unit.name.clone()),
        (
            if two { "guid" } else { "instantiationToken" },
            unit.token.clone(),
        ),
    ];
    let doc = unit.doc.trim();
    if !doc.is_empty() {
        head.push(("description", doc.to_owned()));
    }
    head.push(("generationTool", TOOL.to_owned()));
    head.push(("variableNamingConvention", "structured".to_owned()));
    let mut xml = Xml::new();
    xml.within("fmiModelDescription", &head, |xml| {
        interface(xml, unit);
        units(xml, unit);
        types(xml, unit);
        xml.within("LogCategories", &vec![], |xml| {
            let about = "rejected calls, with the reason";
            xml.element(
                "Category",
                &vec![
                    ("name", "logStatusError".to_owned()),
                    ("description", about.to_owned()),
                ],
            );
        });
        let step = unit.step_seconds;
        xml.element(
            "DefaultExperiment",
            &vec![
                ("startTime", number(0.0)),
                ("stopTime", number(step * EXPERIMENT_STEPS)),
                ("stepSize", number(step)),
            ],
        );
        let variables: Vec<&Variable> = variables(unit).collect();
        xml.within("ModelVariables", &vec![], |xml| {
            for variable in &variables {
                if two {
                    variable_two(xml, variable, &unit.interface.enumerations);
                } else {
                    variable_three(xml, variable, &unit.interface.enumerations);
                }
            }
        });
        xml.within("ModelStructure", &vec![], |xml| {
            structure(xml, two, &variables);
        });
    });
    xml.text()
}

/// Returns the variables that the description lists. Only FMI 3 lists time.
pub(super) fn variables(unit: &Unit) -> impl Iterator<Item = &Variable> {
    let two = unit.version == Version::Two;
    let all = unit.interface.variables.iter();
    all.filter(move |v| !(two && v.causality == Causality::Independent))
}

/// Formats a real number for XML.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Writes the capabilities of the unit.
fn interface(xml: &mut Xml, unit: &Unit) {
    let yes = || "true".to_owned();
    let mut can: Attributes = vec![("modelIdentifier", unit.package.stem.clone())];
    if unit.version == Version::Two {
        can.extend([
            ("canHandleVariableCommunicationStepSize", yes()),
            // The unit allocates memory only for saved states, with malloc of the C library.
            ("canNotUseMemoryManagementFunctions", yes()),
            ("canGetAndSetFMUstate", yes()),
            ("canSerializeFMUstate", yes()),
        ]);
        xml.within("CoSimulation", &can, |xml| {
            xml.within("SourceFiles", &vec![], |xml| {
                xml.element("File", &vec![("name", format!("{}.c", unit.package.stem))]);
            });
        });
    } else {
        can.extend([
            ("canGetAndSetFMUState", yes()),
            ("canSerializeFMUState", yes()),
            ("canHandleVariableCommunicationStepSize", yes()),
            ("fixedInternalStepSize", number(unit.step_seconds)),
            ("hasEventMode", "false".to_owned()),
            ("providesIntermediateUpdate", "false".to_owned()),
        ]);
        xml.element("CoSimulation", &can);
    }
}

fn units(xml: &mut Xml, unit: &Unit) {
    let names: BTreeSet<&str> = variables(unit)
        .map(|v| v.unit.as_str())
        .filter(|u| !u.is_empty())
        .collect();
    xml.within("UnitDefinitions", &vec![], |xml| {
        for name in names {
            let own = vec![("name", name.to_owned())];
            let Some(known) = definition(name) else {
                xml.element("Unit", &own);
                continue;
            };
            let exponents = known.exponents.iter().map(|(k, v)| (*k, (*v).to_owned()));
            let mut base: Attributes = exponents.collect();
            #[expect(clippy::float_cmp, reason = "only a factor of exactly 1 is omitted")]
            if known.factor != 1.0 {
                base.push(("factor", number(known.factor)));
            }
            xml.within("Unit", &own, |xml| xml.element("BaseUnit", &base));
        }
    });
}

fn types(xml: &mut Xml, unit: &Unit) {
    if unit.interface.enumerations.is_empty() {
        return;
    }
    let items = |xml: &mut Xml, enumeration: &Enumeration| {
        for (index, label) in enumeration.labels.iter().enumerate() {
            xml.element(
                "Item",
                &vec![("name", label.clone()), ("value", (index + 1).to_string())],
            );
        }
    };
    xml.within("TypeDefinitions", &vec![], |xml| {
        for enumeration in &unit.interface.enumerations {
            let name = vec![("name", enumeration.name.clone())];
            if unit.version == Version::Two {
                xml.within("SimpleType", &name, |xml| {
                    xml.within("Enumeration", &vec![], |xml| items(xml, enumeration));
                });
            } else {
                xml.within("EnumerationType", &name, |xml| items(xml, enumeration));
            }
        }
    });
}

/// Attributes of a variable common to both versions, in the order of FMI 2.
fn common(variable: &Variable) -> Attributes {
    let (causality, variability) = match variable.causality {
        Causality::Independent => ("independent", "continuous"),
        Causality::Input => ("input", "discrete"),
        Causality::Parameter => ("parameter", "tunable"),
        Causality::Output => ("output", "discrete"),
        Causality::Local => ("local", "discrete"),
    };
    vec![
        ("name", variable.name.clone()),
        ("valueReference", variable.reference.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality.to_owned()),
        ("variability", variability.to_owned()),
    ]
}

/// Returns the `initial` attribute: `exact` for a parameter, `calculated` for an output or a local
/// variable. Inputs need none, because the standard implies it.
fn initial(variable: &Variable) -> Option<&'static str> {
    match variable.causality {
        Causality::Parameter => Some("exact"),
        Causality::Output | Causality::Local => Some("calculated"),
        Causality::Input | Causality::Independent => None,
    }
}

/// Formats the start value, in the host's numbering.
fn start(variable: &Variable) -> Option<String> {
    Some(match (variable.start?, variable.kind) {
        (Start::Real(value), _) => number(value),
        (Start::Whole(value), Kind::Boolean) => (value != 0).to_string(),
        (Start::Whole(value), Kind::Enumeration(_)) => (value + 1).to_string(),
        (Start::Whole(value), _) => value.to_string(),
    })
}

/// Attributes for type, unit, limits and start of a variable.
fn typed(variable: &Variable, enumerations: &[Enumeration]) -> Attributes {
    let mut attributes = Attributes::new();
    if let Kind::Enumeration(index) = variable.kind {
        attributes.push(("declaredType", enumerations[index].name.clone()));
    }
    if !variable.unit.is_empty() && variable.kind == Kind::Real {
        attributes.push(("unit", variable.unit.clone()));
    }
    if let (Some((low, high)), Kind::Real | Kind::Integer | Kind::Long) =
        (variable.limits, variable.kind)
    {
        attributes.extend([("min", low.to_string()), ("max", high.to_string())]);
    }
    attributes.extend(start(variable).map(|s| ("start", s)));
    attributes
}

fn variable_two(xml: &mut Xml, variable: &Variable, enumerations: &[Enumeration]) {
    let mut attributes = common(variable);
    attributes.extend(initial(variable).map(|i| ("initial", i.to_owned())));
    let kind = match variable.kind {
        Kind::Real | Kind::Long => "Real",
        Kind::Integer => "Integer",
        Kind::Boolean => "Boolean",
        Kind::Enumeration(_) => "Enumeration",
    };
    xml.within("ScalarVariable", &attributes, |xml| {
        xml.element(kind, &typed(variable, enumerations));
    });
}

fn variable_three(xml: &mut Xml, variable: &Variable, enumerations: &[Enumeration]) {
    let kind = match variable.kind {
        Kind::Real => "Float64",
        Kind::Integer => "Int32",
        Kind::Long => "Int64",
        Kind::Boolean => "Boolean",
        Kind::Enumeration(_) => "Enumeration",
    };
    let mut attributes = common(variable);
    attributes.extend(initial(variable).map(|i| ("initial", i.to_owned())));
    attributes.extend(typed(variable, enumerations));
    xml.element(kind, &attributes);
}

/// Writes the outputs, all without dependencies. FMI 2 refers to a variable by its number, counted
/// from 1; FMI 3 refers to it by its value reference.
fn structure(xml: &mut Xml, two: bool, variables: &[&Variable]) {
    let unknowns: Vec<String> = variables
        .iter()
        .enumerate()
        .filter(|(_, v)| v.causality == Causality::Output)
        .map(|(i, v)| {
            if two {
                (i + 1).to_string()
            } else {
                v.reference.to_string()
            }
        })
        .collect();
    let key = if two { "index" } else { "valueReference" };
    let attributes =
        |unknown: &String| vec![(key, unknown.clone()), ("dependencies", String::new())];
    if two {
        for list in ["Outputs", "InitialUnknowns"] {
            xml.within(list, &vec![], |xml| {
                for unknown in &unknowns {
                    xml.element("Unknown", &attributes(unknown));
                }
            });
        }
    } else {
        for element in ["Output", "InitialUnknown"] {
            for unknown in &unknowns {
                xml.element(element, &attributes(unknown));
            }
        }
    }
}

/// Renders `buildDescription.xml` of FMI 3, which lists the sources to compile.
pub(super) fn build_description(unit: &Unit) -> String {
    let stem = &unit.package.stem;
    let mut xml = Xml::new();
    xml.within(
        "fmiBuildDescription",
        &vec![("fmiVersion", "3.0".to_owned())],
        |xml| {
            xml.within(
                "BuildConfiguration",
                &vec![("modelIdentifier", stem.clone())],
                |xml| {
                    xml.within(
                        "SourceFileSet",
                        &vec![("language", "C99".to_owned())],
                        |xml| {
                            xml.element("SourceFile", &vec![("name", format!("{stem}.c"))]);
                        },
                    );
                },
            );
        },
    );
    xml.text()
}
