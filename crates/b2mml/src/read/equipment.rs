//! Layouts from `EquipmentInformation`.
//!
//! Equipment that contains equipment without any more in it is a layout. If there is none, all
//! equipment of the document is one. Equipment without states has one state, in which it may wait
//! and perform an operation for each of its `EquipmentClassID`.

use super::problems;
use super::source::{Property, Source};
use crate::finding::{Rule, quoted};
use crate::name::encode;
use crate::terms::{resource as keys, transition};
use crate::xml::Element;
use linewright_recipe::model::{Action, Layout, Resource, State, Transition};
use rustc_hash::FxHashSet;

/// State of equipment for which no states are given.
const ONLY_STATE: &str = "idle";

/// Reads all layouts of a document.
pub(super) fn layouts(source: &mut Source<'_, '_>) -> Vec<Layout> {
    let name = source.id(0);
    let classes = source.children(0, "EquipmentClass");
    for class in classes {
        source.id(class);
    }
    let tops = source.children(0, "Equipment");
    if tops.is_empty() {
        source.add(0, Rule::Meaning, "there is no equipment");
        return Vec::new();
    }
    let mut layouts = Vec::new();
    if tops.iter().any(|top| source.has(*top, "EquipmentChild")) {
        for top in tops {
            cells(source, top, &mut layouts);
        }
    } else {
        layouts.push(layout(source, 0, name, &tops));
    }
    let mut known = FxHashSet::default();
    for layout in &layouts {
        if !known.insert(&layout.name) {
            let message = format!("two work cells are called {}", quoted(&layout.name));
            source.add(0, Rule::Reference, message);
        }
    }
    layouts
}

/// Reads the layouts in equipment. Its depth is that of the document.
fn cells(source: &mut Source<'_, '_>, element: Element, layouts: &mut Vec<Layout>) {
    let name = source.id(element);
    source.code(element, "EquipmentLevel");
    let children = source.children(element, "EquipmentChild");
    let mut containers = children
        .iter()
        .filter(|c| source.has(**c, "EquipmentChild"));
    if containers.next().is_none() {
        if children.is_empty() {
            let message = format!("{} is in no work cell and contains none", quoted(&name));
            source.add(element, Rule::Meaning, message);
        } else {
            layouts.push(layout(source, element, name, &children));
        }
        return;
    }
    for child in children {
        cells(source, child, layouts);
    }
}

fn layout(
    source: &mut Source<'_, '_>,
    element: Element,
    name: String,
    resources: &[Element],
) -> Layout {
    let layout = Layout {
        name,
        resources: resources.iter().map(|r| resource(source, *r)).collect(),
    };
    problems::of_layout(source, &layout, element, resources);
    layout
}

fn resource(source: &mut Source<'_, '_>, element: Element) -> Resource {
    let name = source.id(element);
    source.code(element, "EquipmentLevel");
    let classes = source.children(element, "EquipmentClassID");
    let properties = source.properties(element, "EquipmentProperty");
    let capacity = source.single(&properties, keys::CAPACITY);
    let capacity = capacity.and_then(|v| source.number(v, "a number of parts"));
    let holds = source.list(&properties, keys::HOLDS);
    let mut resource = Resource {
        name,
        capacity: capacity.unwrap_or(1),
        holds,
        ..Resource::default()
    };
    let has_states = properties.iter().any(|p| p.id == keys::STATES);
    if has_states {
        states(source, element, &properties, &mut resource);
    } else {
        let state = ONLY_STATE.to_owned();
        resource.states.push(State {
            name: state.clone(),
            may_wait: true,
        });
        resource.initial = state;
    }
    let mut offered: FxHashSet<String> = FxHashSet::default();
    for transition in &resource.transitions {
        if let Action::Operation(name) = &transition.action {
            offered.insert(name.clone());
        }
    }
    for class in classes {
        let operation = source.name(class);
        if has_states && !offered.contains(&operation) {
            let message = format!("no transition performs {}", quoted(&operation));
            source.add(class, Rule::Reference, message);
        } else if offered.insert(operation.clone()) {
            let action = Action::Operation(operation);
            resource = resource.with(ONLY_STATE, action, ONLY_STATE);
        }
    }
    resource
}

/// Reads the states and transitions of a resource.
fn states(
    source: &mut Source<'_, '_>,
    element: Element,
    properties: &[Property],
    resource: &mut Resource,
) {
    let states = source.list(properties, keys::STATES);
    let waiting = source.property(properties, keys::WAITING_STATES);
    let waiting = waiting.map(|p| p.values.clone()).unwrap_or_default();
    let known: FxHashSet<&str> = states.iter().map(String::as_str).collect();
    for value in &waiting {
        if !known.contains(value.text.as_str()) {
            let message = format!("there is no state {}", quoted(&value.text));
            source.add(value.element, Rule::Reference, message);
        }
    }
    let waiting: FxHashSet<&str> = waiting.iter().map(|v| v.text.as_str()).collect();
    resource.states = (states.iter())
        .map(|name| State {
            name: name.clone(),
            may_wait: waiting.contains(name.as_str()),
        })
        .collect();
    if let Some(initial) = source.single(properties, keys::INITIAL_STATE) {
        resource.initial.clone_from(&initial.text);
    } else {
        let key = keys::INITIAL_STATE;
        let message = format!("the property `{key}` is missing");
        source.add(element, Rule::Meaning, message);
        resource.initial = states.first().cloned().unwrap_or_default();
    }
    for property in properties {
        if property.id.starts_with(keys::TRANSITION) {
            source.take(property);
            resource
                .transitions
                .extend(read_transition(source, property));
        }
    }
}

fn read_transition(source: &mut Source<'_, '_>, property: &Property) -> Option<Transition> {
    let mut from = None;
    let mut to = None;
    let mut action = None;
    let mut seconds = None;
    let mut watts = None;
    for value in &property.values {
        let text = || value.text.clone();
        let is_second = match value.key.as_str() {
            transition::FROM => from.replace(text()).is_some(),
            transition::TO => to.replace(text()).is_some(),
            transition::OPERATION => action.replace(Action::Operation(text())).is_some(),
            transition::INTERNAL => action.replace(Action::Internal(text())).is_some(),
            transition::IN => action.replace(Action::In(text())).is_some(),
            transition::OUT => action.replace(Action::Out(text())).is_some(),
            transition::DURATION => {
                std::mem::replace(&mut seconds, source.quantity(value, "s")).is_some()
            }
            transition::POWER => {
                std::mem::replace(&mut watts, source.quantity(value, "W")).is_some()
            }
            key => {
                let message = format!("a transition has no value with the key {}", quoted(key));
                source.add(value.element, Rule::Meaning, message);
                false
            }
        };
        if is_second {
            let message = format!("the transition has a second value {}", quoted(&value.key));
            source.add(value.element, Rule::Meaning, message);
        }
    }
    if let (Some(from), Some(to), Some(action)) = (from, to, action) {
        return Some(Transition {
            from,
            to,
            action,
            seconds,
            watts,
        });
    }
    let message = format!(
        "{} needs values with the keys `From`, `To` and what it does",
        quoted(&encode(&property.id))
    );
    source.add(property.element, Rule::Meaning, message);
    None
}
