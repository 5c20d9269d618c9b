//! Problems of a layout or a recipe as findings: at the element that they concern.

use super::source::Source;
use crate::finding::Rule;
use crate::xml::Element;
use linewright_recipe::model::{Layout, Problem, Recipe};
use rustc_hash::FxHashMap;

/// Maximum number of bytes of the longest name, times the number of states and transitions. Each
/// problem has copies of names.
const MAX_NAMES: usize = 128 << 20;

/// Elements of a recipe.
#[derive(Default)]
pub(super) struct Places {
    /// The whole.
    pub whole: Element,
    /// Where a state is named first.
    pub states: FxHashMap<String, Element>,
    /// Transitions.
    pub transitions: Vec<Element>,
}

/// Adds the problems of a layout, except warnings. `resources` are its elements.
pub(super) fn of_layout(
    source: &mut Source<'_, '_>,
    layout: &Layout,
    whole: Element,
    resources: &[Element],
) {
    let resources_names = layout.resources.iter().map(|r| r.name.len());
    let states = layout.resources.iter().flat_map(|r| &r.states);
    let labels = layout.resources.iter().flat_map(|r| &r.transitions);
    let lengths = resources_names.chain(states.map(|s| s.name.len()));
    let lengths = lengths.chain(labels.map(|t| {
        let label = t.action.label().map_or(0, str::len);
        label.max(t.from.len()).max(t.to.len())
    }));
    if !names_fit(source, whole, lengths) {
        return;
    }
    for problem in layout.problems().iter().filter(|p| !p.is_warning()) {
        let resource = match problem {
            Problem::DuplicateResource(name) => {
                layout.resources.iter().rposition(|r| r.name == *name)
            }
            Problem::DuplicateResourceState { resource, .. }
            | Problem::UnknownResourceState { resource, .. }
            | Problem::BadQuantity { resource, .. }
            | Problem::TooManyParts { resource, .. } => layout.resource(resource),
            _ => None,
        };
        let place = resource.and_then(|r| resources.get(r)).copied();
        source.add(place.unwrap_or(whole), rule(problem), problem.to_string());
    }
}

/// Adds the problems of a recipe, except warnings.
pub(super) fn of_recipe(source: &mut Source<'_, '_>, recipe: &Recipe, places: &Places) {
    let transitions = recipe.transitions.iter();
    let lengths = transitions.map(|t| t.from.len().max(t.to.len()));
    let lengths = lengths.chain(recipe.states.iter().map(String::len));
    let calls = recipe.transitions.iter().flat_map(|t| &t.steps);
    let calls = calls.flat_map(|s| &s.operations);
    let parts = calls.flat_map(|c| c.inputs.iter().chain(&c.outputs));
    let lengths = lengths.chain(parts.map(String::len));
    if !names_fit(source, places.whole, lengths) {
        return;
    }
    for problem in recipe.problems().iter().filter(|p| !p.is_warning()) {
        let place = match problem {
            Problem::UnknownPart { transition, .. }
            | Problem::LeavesEnd { transition, .. }
            | Problem::EmptyStep { transition, .. } => places.transitions.get(*transition),
            Problem::DuplicateState(state)
            | Problem::UnknownState(state)
            | Problem::NoWayOn(state)
            | Problem::NotCovered(state)
            | Problem::TwoOtherwise(state)
            | Problem::IdleLoop(state) => places.states.get(state),
            _ => None,
        };
        let place = place.copied().unwrap_or(places.whole);
        source.add(place, rule(problem), problem.to_string());
    }
}

/// Returns whether names of these lengths can be copied for each problem. Otherwise adds a finding.
fn names_fit(
    source: &mut Source<'_, '_>,
    whole: Element,
    lengths: impl Iterator<Item = usize>,
) -> bool {
    let (mut longest, mut count) = (0, 0_usize);
    for length in lengths {
        longest = longest.max(length);
        count += 1;
    }
    let fits = count.saturating_mul(longest) <= MAX_NAMES;
    if !fits {
        let message = format!("there are {count} names, and the longest one has {longest} bytes");
        source.add(whole, Rule::Size, message);
    }
    fits
}

/// Returns the rule that a problem breaks.
fn rule(problem: &Problem) -> Rule {
    match problem {
        Problem::DuplicateResource(_)
        | Problem::DuplicateResourceState { .. }
        | Problem::UnknownResourceState { .. }
        | Problem::DuplicatePart(_)
        | Problem::DuplicateState(_)
        | Problem::UnknownState(_)
        | Problem::UnknownPart { .. }
        | Problem::UnknownLeftover(_) => Rule::Reference,
        Problem::TooLarge { .. } => Rule::Size,
        _ => Rule::Meaning,
    }
}
