//! A recipe as `OperationsDefinition`.
//!
//! The first segment declares parts and states. Each transition of the recipe is a segment, and
//! each of its operations a child of that. A dependency says what B2MML can say of their order: a
//! step follows the one before it (`AfterEnd`), and operations of a step begin together
//! (`AtStart`).

use super::{WriteError, name, names, one_piece, property, shown, without_problems};
use crate::name::encode;
use crate::schedule::segment_id;
use crate::schema::NAMESPACE;
use crate::terms::{activity, recipe as keys};
use crate::write::Value;
use crate::xml::XmlWriter;
use linewright_recipe::model::{Guard, OperationCall, Part, Recipe, RecipeTransition};
use rustc_hash::FxHashMap;

const PARAMETER: &str = "ParameterSpecification";

/// Returns a recipe as a document with the root `OperationsDefinition`.
///
/// Takes time proportional to the recipe.
///
/// # Errors
/// [`WriteError::Problems`].
pub fn definition(recipe: &Recipe) -> Result<String, WriteError> {
    without_problems(recipe.problems())?;
    let writer = DefinitionWriter::new(recipe);
    Ok(XmlWriter::document(
        "OperationsDefinition",
        NAMESPACE,
        |w| {
            w.text("ID", &encode(&recipe.name));
            w.text("OperationsType", "Production");
            w.element("OperationsSegment", |w| declarations(w, recipe));
            for (number, transition) in recipe.transitions.iter().enumerate() {
                w.element("OperationsSegment", |w| {
                    writer.transition(w, number, transition);
                });
            }
        },
    ))
}

fn declarations(w: &mut XmlWriter, recipe: &Recipe) {
    w.text("ID", keys::DECLARATIONS);
    let other = [("OtherValue", keys::DECLARATIONS)];
    w.text_with("OperationsType", &other, "Other");
    names(w, PARAMETER, keys::STATES, &recipe.states);
    name(w, PARAMETER, keys::START, &recipe.start);
    names(w, PARAMETER, keys::ENDS, &recipe.ends);
    names(w, PARAMETER, keys::LEFTOVER, &recipe.leftover);
    for part in &recipe.parts {
        w.element("MaterialSpecification", |w| {
            w.text("ID", &encode(&part.name));
            w.text("MaterialDefinitionID", &encode(&part.kind));
        });
    }
}

/// Writes a guard as parameters or properties.
pub(super) fn guard(w: &mut XmlWriter, element: &str, guard: &Guard) {
    match guard {
        Guard::Always => {}
        Guard::Test {
            name: test,
            inputs,
            at,
        } => {
            name(w, element, keys::TEST, test);
            names(w, element, keys::TESTED, inputs);
            names(w, element, keys::TESTED_AT, at);
        }
        Guard::Otherwise => {
            let value = Value {
                kind: "boolean",
                ..Value::text("true")
            };
            property(w, element, keys::OTHERWISE, &[value]);
        }
    }
}

/// Returns the dependency that says when a transition is taken: its text and its other value.
pub(super) fn dependency(guard: &Guard) -> (&'static str, Option<String>) {
    match guard {
        Guard::Always => ("AfterEnd", None),
        Guard::Test { name, inputs, .. } => {
            let inputs: Vec<String> = inputs.iter().map(|i| encode(i)).collect();
            let text = format!("{}({})", encode(name), inputs.join(", "));
            ("Other", Some(text))
        }
        Guard::Otherwise => ("Other", Some("otherwise".to_owned())),
    }
}

/// Writes the dependency of a guard.
pub(super) fn write_dependency(w: &mut XmlWriter, guard: &Guard) {
    let (text, other) = dependency(guard);
    match &other {
        Some(other) => w.text_with("Dependency", &[("OtherValue", other)], text),
        None => w.text("Dependency", text),
    }
}

struct DefinitionWriter<'a> {
    /// Parts by their names.
    parts: FxHashMap<&'a str, &'a Part>,
    /// The only transition that enters a state, if there is only one. The start is entered by the
    /// beginning, too.
    entering: FxHashMap<&'a str, Option<usize>>,
}

impl<'a> DefinitionWriter<'a> {
    fn new(recipe: &'a Recipe) -> Self {
        let mut entering = FxHashMap::default();
        entering.insert(recipe.start.as_str(), None);
        for (number, transition) in recipe.transitions.iter().enumerate() {
            let to = transition.to.as_str();
            let only = (!entering.contains_key(to)).then_some(number);
            entering.insert(to, only);
        }
        Self {
            parts: recipe.parts.iter().map(|p| (p.name.as_str(), p)).collect(),
            entering,
        }
    }

    fn transition(&self, w: &mut XmlWriter, number: usize, transition: &RecipeTransition) {
        w.text("ID", &format!("T{}", number + 1));
        let (from, to) = (encode(&transition.from), encode(&transition.to));
        let (_, condition) = dependency(&transition.guard);
        let condition = condition.map(|c| format!(" if {c}")).unwrap_or_default();
        w.text("Description", &format!("{from} to {to}{condition}"));
        w.text("OperationsType", "Production");
        name(w, PARAMETER, keys::FROM, &transition.from);
        name(w, PARAMETER, keys::TO, &transition.to);
        guard(w, PARAMETER, &transition.guard);
        if let Some(Some(before)) = self.entering.get(transition.from.as_str()) {
            w.element("SegmentDependency", |w| {
                w.text("ID", "1");
                write_dependency(w, &transition.guard);
                w.text("SegmentID", &format!("T{}", before + 1));
            });
        }
        for (step, of) in transition.steps.iter().enumerate() {
            for (operation, call) in of.operations.iter().enumerate() {
                w.element("OperationsSegmentChild", |w| {
                    w.text("ID", &segment_id(number, step, operation));
                    w.text("Description", &shown(call));
                    w.text("OperationsType", "Production");
                    w.text("ProcessSegmentID", &encode(&call.name));
                    self.operation(w, call);
                    let mut dependency = |id: &str, kind: &str, on: &str| {
                        w.element("SegmentDependency", |w| {
                            w.text("ID", id);
                            w.text("Dependency", kind);
                            w.text("SegmentID", on);
                        });
                    };
                    if step > 0 {
                        dependency("1", "AfterEnd", &segment_id(number, step - 1, 0));
                    }
                    if operation > 0 {
                        dependency("2", "AtStart", &segment_id(number, step, 0));
                    }
                });
            }
        }
    }

    fn operation(&self, w: &mut XmlWriter, call: &OperationCall) {
        w.element("EquipmentSpecification", |w| {
            w.text("ID", "1");
            w.text("EquipmentClassID", &encode(&call.name));
        });
        for (usage, parts) in [("Consumed", &call.inputs), ("Produced", &call.outputs)] {
            for (number, part) in parts.iter().enumerate() {
                let kind = self.parts.get(part.as_str()).map_or(part, |p| &p.kind);
                w.element("MaterialSpecification", |w| {
                    w.text("ID", &format!("{usage}-{}", number + 1));
                    w.text("MaterialDefinitionID", &encode(kind));
                    w.text("MaterialUse", usage);
                    one_piece(w);
                    name(w, "MaterialSpecificationProperty", activity::PART, part);
                });
            }
        }
    }
}
