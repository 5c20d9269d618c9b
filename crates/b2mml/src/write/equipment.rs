//! A layout as `EquipmentInformation`.
//!
//! The layout is a work cell, its resources are work units in it. What a resource can do is an
//! `EquipmentClassID` for each operation. No element of B2MML says how states change, so states and
//! transitions are properties.

use super::{Value, WriteError, name, names, property, without_problems};
use crate::name::encode;
use crate::schema::NAMESPACE;
use crate::terms::{resource as keys, transition};
use crate::xml::XmlWriter;
use linewright_recipe::model::{Action, Layout, Resource, Transition};
use rustc_hash::FxHashSet;

const PROPERTY: &str = "EquipmentProperty";

/// Returns a layout as a document with the root `EquipmentInformation`.
///
/// Takes time proportional to the layout.
///
/// # Errors
/// [`WriteError::Problems`].
pub fn equipment(layout: &Layout) -> Result<String, WriteError> {
    without_problems(layout.problems())?;
    let id = encode(&layout.name);
    Ok(XmlWriter::document(
        "EquipmentInformation",
        NAMESPACE,
        |w| {
            w.text("ID", &id);
            w.element("Equipment", |w| {
                w.text("ID", &id);
                w.text("EquipmentLevel", "WorkCell");
                for resource in &layout.resources {
                    w.element("EquipmentChild", |w| write_resource(w, resource));
                }
            });
            let mut known = FxHashSet::default();
            for operation in layout.resources.iter().flat_map(operations) {
                if known.insert(operation) {
                    w.element("EquipmentClass", |w| w.text("ID", &encode(operation)));
                }
            }
        },
    ))
}

/// Returns the operations of a resource, each once, in the order of its transitions.
fn operations(resource: &Resource) -> Vec<&str> {
    let mut known = FxHashSet::default();
    let names = resource.transitions.iter().filter_map(|t| match &t.action {
        Action::Operation(name) => Some(name.as_str()),
        _ => None,
    });
    names.filter(|n| known.insert(*n)).collect()
}

fn write_resource(w: &mut XmlWriter, resource: &Resource) {
    w.text("ID", &encode(&resource.name));
    w.text("EquipmentLevel", "WorkUnit");
    let capacity = resource.capacity.to_string();
    property(w, PROPERTY, keys::CAPACITY, &[Value::count(&capacity)]);
    name(w, PROPERTY, keys::INITIAL_STATE, &resource.initial);
    let states: Vec<String> = resource.states.iter().map(|s| s.name.clone()).collect();
    names(w, PROPERTY, keys::STATES, &states);
    let waiting = resource.states.iter().filter(|s| s.may_wait);
    let waiting: Vec<String> = waiting.map(|s| s.name.clone()).collect();
    names(w, PROPERTY, keys::WAITING_STATES, &waiting);
    names(w, PROPERTY, keys::HOLDS, &resource.holds);
    for (number, transition) in resource.transitions.iter().enumerate() {
        write_transition(w, number, transition);
    }
    for operation in operations(resource) {
        w.text("EquipmentClassID", &encode(operation));
    }
}

fn write_transition(w: &mut XmlWriter, number: usize, of: &Transition) {
    let (key, action) = match &of.action {
        Action::Operation(name) => (transition::OPERATION, name),
        Action::Internal(name) => (transition::INTERNAL, name),
        Action::In(label) => (transition::IN, label),
        Action::Out(label) => (transition::OUT, label),
    };
    let (from, to, action) = (encode(&of.from), encode(&of.to), encode(action));
    let seconds = of.seconds.map(|s| s.to_string());
    let watts = of.watts.map(|s| s.to_string());
    let mut values = vec![
        Value::text(&from).under(transition::FROM),
        Value::text(&to).under(transition::TO),
        Value::text(&action).under(key),
    ];
    if let Some(seconds) = &seconds {
        values.push(Value::number(seconds, "s").under(transition::DURATION));
    }
    if let Some(watts) = &watts {
        values.push(Value::number(watts, "W").under(transition::POWER));
    }
    let id = format!("{}{}", keys::TRANSITION, number + 1);
    property(w, PROPERTY, &id, &values);
}
