//! Recipes from `OperationsDefinition`.
//!
//! With a segment of declarations, each other segment is a transition of the recipe. Without one,
//! all segments form one transition: those without children are operations.

use super::activity::{Parts, call, materials};
use super::order::groups;
use super::problems::{self, Places};
use super::source::{Property, Source};
use crate::finding::{Rule, quoted};
use crate::linear::linear_recipe;
use crate::terms::recipe as keys;
use crate::xml::Element;
use linewright_recipe::model::{Guard, OperationCall, Part, Recipe, RecipeTransition, Step};
use rustc_hash::FxHashMap;

const PARAMETER: &str = "ParameterSpecification";

/// Reads a recipe from its element.
pub(super) fn definition(source: &mut Source<'_, '_>, element: Element) -> Recipe {
    let name = source.id(element);
    source.code(element, "OperationsType");
    let segments = source.children(element, "OperationsSegment");
    let mut declarations = Vec::new();
    let mut others = Vec::new();
    for segment in segments {
        let kind = source.code(segment, "OperationsType");
        if kind.is_some_and(|(_, other)| other.as_deref() == Some(keys::DECLARATIONS)) {
            declarations.push(segment);
        } else {
            others.push(segment);
        }
    }
    let Some((declared, more)) = declarations.split_first() else {
        return without_declarations(source, element, &name, &others);
    };
    for second in more {
        let message = "the recipe has second declarations";
        source.add(*second, Rule::Reference, message);
    }
    let mut places = Places {
        whole: element,
        ..Places::default()
    };
    let mut recipe = declaration(source, *declared, &mut places);
    recipe.name = name;
    for segment in others {
        let transition = transition(source, segment);
        places.transitions.push(segment);
        recipe.transitions.push(transition);
    }
    problems::of_recipe(source, &recipe, &places);
    recipe
}

/// Reads parts, states and what is left over.
fn declaration(source: &mut Source<'_, '_>, segment: Element, places: &mut Places) -> Recipe {
    source.id(segment);
    let properties = source.properties(segment, PARAMETER);
    let states = source.property(&properties, keys::STATES);
    for state in states.into_iter().flat_map(|p| &p.values) {
        places.states.insert(state.text.clone(), state.element);
    }
    let mut parts = Vec::new();
    for material in source.children(segment, "MaterialSpecification") {
        let name = source.id(material);
        let kinds = source.names(material, "MaterialDefinitionID");
        if kinds.len() > 1 {
            let message = format!("part {} has several types", quoted(&name));
            source.add(material, Rule::Meaning, message);
        }
        let kind = kinds.first().unwrap_or(&name);
        parts.push(Part::new(&name, kind));
    }
    let start = source.single(&properties, keys::START);
    Recipe {
        name: String::new(),
        parts,
        states: source.list(&properties, keys::STATES),
        start: start.map(|s| s.text.clone()).unwrap_or_default(),
        ends: source.list(&properties, keys::ENDS),
        leftover: source.list(&properties, keys::LEFTOVER),
        transitions: Vec::new(),
    }
}

/// Reads a transition of a recipe from its segment.
fn transition(source: &mut Source<'_, '_>, segment: Element) -> RecipeTransition {
    source.id(segment);
    let properties = source.properties(segment, PARAMETER);
    let mut state = |key| {
        let value = source.single(&properties, key);
        if value.is_none() {
            let message = format!("the parameter `{key}` is missing");
            source.add(segment, Rule::Meaning, message);
        }
        value.map(|v| v.text.clone()).unwrap_or_default()
    };
    let (from, to) = (state(keys::FROM), state(keys::TO));
    // Between transitions, dependencies only repeat what their states say.
    for dependency in source.children(segment, "SegmentDependency") {
        source.take_all(dependency);
    }
    let guard = guard(source, segment, &properties);
    let children = source.children(segment, "OperationsSegmentChild");
    let mut parts = Parts::default();
    let mut steps = Vec::new();
    for group in groups(source, &children) {
        let calls = group.into_iter().map(|s| operation(source, s, &mut parts));
        steps.push(Step::new(calls.collect()));
    }
    RecipeTransition {
        from,
        to,
        guard,
        steps,
    }
}

/// Reads a guard from parameters or properties.
pub(super) fn guard(
    source: &mut Source<'_, '_>,
    element: Element,
    properties: &[Property],
) -> Guard {
    let test = source
        .single(properties, keys::TEST)
        .map(|v| v.text.clone());
    let inputs = source.list(properties, keys::TESTED);
    let at = source.list(properties, keys::TESTED_AT);
    let otherwise = source.single(properties, keys::OTHERWISE);
    if let Some(value) = otherwise.filter(|v| v.text != "true") {
        source.add(value.element, Rule::Meaning, "`true` is expected");
    }
    match (test, otherwise) {
        (Some(name), None) => Guard::Test { name, inputs, at },
        (None, Some(_)) if inputs.is_empty() && at.is_empty() => Guard::Otherwise,
        (None, None) if inputs.is_empty() && at.is_empty() => Guard::Always,
        _ => {
            let message = "a guard is either a test or otherwise";
            source.add(element, Rule::Meaning, message);
            Guard::Always
        }
    }
}

/// Reads an operation.
fn operation(source: &mut Source<'_, '_>, segment: Element, parts: &mut Parts) -> OperationCall {
    let id = source.id(segment);
    source.code(segment, "OperationsType");
    let names = source.names(segment, "ProcessSegmentID");
    if names.len() > 1 {
        let message = "an operation has one process segment";
        source.add(segment, Rule::Meaning, message);
    }
    for equipment in source.children(segment, "EquipmentSpecification") {
        source.id(equipment);
        source.children(equipment, "EquipmentClassID");
    }
    if source.has(segment, "OperationsSegmentChild") {
        let message = "an operation that begins with others has no segments of its own";
        source.add(segment, Rule::Meaning, message);
    }
    let materials = materials(source, segment, "MaterialSpecification", parts);
    let name = names.into_iter().next().unwrap_or(id);
    call(source, segment, name, materials)
}

/// Reads a recipe whose segments are all operations, or groups of them.
fn without_declarations(
    source: &mut Source<'_, '_>,
    element: Element,
    name: &str,
    segments: &[Element],
) -> Recipe {
    if segments.is_empty() {
        source.add(element, Rule::Meaning, "the recipe has no segments");
    }
    let mut parts = Parts::default();
    let mut steps = Vec::new();
    add_steps(source, segments, &mut parts, &mut steps);
    let kinds: FxHashMap<&str, &Part> = parts.list.iter().map(|p| (p.name.as_str(), p)).collect();
    let recipe = linear_recipe(name, &kinds, steps);
    let places = Places {
        whole: element,
        ..Places::default()
    };
    problems::of_recipe(source, &recipe, &places);
    recipe
}

/// Adds the steps of segments. The depth is that of the document.
fn add_steps(
    source: &mut Source<'_, '_>,
    segments: &[Element],
    parts: &mut Parts,
    steps: &mut Vec<Step>,
) {
    for group in groups(source, segments) {
        if let [only] = group.as_slice()
            && source.has(*only, "OperationsSegmentChild")
        {
            source.child(*only, "ProcessSegmentID");
            source.code(*only, "OperationsType");
            let children = source.children(*only, "OperationsSegmentChild");
            add_steps(source, &children, parts, steps);
            continue;
        }
        let calls = group.into_iter().map(|s| operation(source, s, parts));
        steps.push(Step::new(calls.collect()));
    }
}
