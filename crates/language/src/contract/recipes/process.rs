//! Resolution of recipes: parts, states, transitions and their steps.

use super::findings;
use crate::contract::recipe::{CallPlaces, Recipe, TransitionPlaces};
use crate::contract::scope::{duplicate_name, duplicate_statement};
use linewright_core::diagnostics::{Diagnostic, codes, has_errors};
use linewright_core::source::Span;
use linewright_recipe::model::{self, Guard, OperationCall, Part, RecipeTransition, Step};
use linewright_syntax::ast::{self, RecipeGuard, RecipeItem};
use std::collections::BTreeMap;

/// Resolves a recipe. Returns `None` if there is an error, which is added to the findings.
pub(in crate::contract) fn recipe(
    decl: &ast::Recipe,
    findings: &mut Vec<Diagnostic>,
) -> Option<Recipe> {
    let mut found = Vec::new();
    let mut recipe = Recipe {
        doc: decl.doc.clone(),
        model: model::Recipe {
            name: decl.name.text.clone(),
            ..model::Recipe::default()
        },
        parts: Vec::new(),
        states: Vec::new(),
        transitions: Vec::new(),
        span: decl.name.span,
    };
    declare_parts(decl, &mut recipe, &mut found);
    let start = start(decl, &mut found);
    let mut transitions = Vec::new();
    for item in &decl.items {
        if let RecipeItem::Transition(t) = item {
            transitions.push(t);
        }
    }
    // States are declared by the transitions. A recipe without any has one state.
    let named = transitions.iter().flat_map(|t| [&t.from, &t.to]);
    let first =
        start.filter(|s| transitions.is_empty() || named.clone().any(|state| state.text == s.text));
    let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
    for state in first.into_iter().chain(named) {
        if seen.insert(&state.text, state.span).is_none() {
            recipe.model.states.push(state.text.clone());
            recipe.states.push(state.span);
        }
    }
    recipe.model.start = start.map(|s| s.text.clone()).unwrap_or_default();
    let mut mentioned: Vec<&ast::Name> = start.into_iter().collect();
    for item in &decl.items {
        let (names, list) = match item {
            RecipeItem::Ends(names) => (names, &mut recipe.model.ends),
            RecipeItem::Leftover(names) => (names, &mut recipe.model.leftover),
            _ => continue,
        };
        list.extend(names.iter().map(|n| n.text.clone()));
        mentioned.extend(names);
    }
    for decl in transitions {
        let (transition, places) = transition(decl);
        recipe.model.transitions.push(transition);
        recipe.transitions.push(places);
    }
    // What could not be parsed might contain what would be missing.
    if !decl.broken {
        let problems = recipe.model.problems();
        // Without a start, every state would be reported as unreachable.
        let known = |problem: &&model::Problem| {
            start.is_some()
                || !matches!(
                    problem,
                    model::Problem::Unreachable(_) | model::Problem::UnknownState(_)
                )
        };
        for problem in problems.iter().filter(known) {
            let mut finding = findings::of_recipe(problem, &recipe, None);
            if let Some(name) = findings::subject(problem)
                && let Some(place) = mentioned.iter().find(|m| m.text == name)
            {
                finding.span = Some(place.span);
            }
            found.push(finding);
        }
    }
    let is_usable = !decl.broken && !has_errors(&found);
    findings.append(&mut found);
    is_usable.then_some(recipe)
}

fn declare_parts(decl: &ast::Recipe, recipe: &mut Recipe, found: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
    for item in &decl.items {
        let RecipeItem::Parts(parts) = item else {
            continue;
        };
        for part in parts {
            if let Some(first) = seen.get(part.name.text.as_str()) {
                found.push(duplicate_name(&part.name, *first));
                continue;
            }
            seen.insert(&part.name.text, part.name.span);
            let kind = part.kind.as_ref().unwrap_or(&part.name);
            let part_model = Part::new(&part.name.text, &kind.text);
            recipe.model.parts.push(part_model);
            recipe.parts.push(part.name.span);
        }
    }
}

/// Returns the state at the start. Reports a missing or second one.
fn start<'a>(decl: &'a ast::Recipe, found: &mut Vec<Diagnostic>) -> Option<&'a ast::Name> {
    let mut starts = decl.items.iter().filter_map(|item| match item {
        RecipeItem::Start(state) => Some(state),
        _ => None,
    });
    let first = starts.next();
    let Some(state) = first else {
        if !decl.broken {
            found.push(
                Diagnostic::error(
                    codes::RECIPE_GRAPH,
                    decl.name.span,
                    format!("the recipe `{}` has no start", decl.name.text),
                )
                .with_help("name the state in which it begins: `start a`"),
            );
        }
        return None;
    };
    for second in starts {
        found.push(duplicate_statement(
            "start",
            second.span,
            state.span,
            "keep the state in which the recipe begins",
        ));
    }
    first
}

fn spans(names: &[ast::Name]) -> Vec<Span> {
    names.iter().map(|n| n.span).collect()
}

fn texts(names: &[ast::Name]) -> Vec<String> {
    names.iter().map(|n| n.text.clone()).collect()
}

fn transition(decl: &ast::RecipeTransition) -> (RecipeTransition, TransitionPlaces) {
    let mut places = TransitionPlaces {
        span: decl.span(),
        ..TransitionPlaces::default()
    };
    let guard = match &decl.guard {
        None => Guard::Always,
        Some(RecipeGuard::Otherwise(span)) => {
            places.guard = Some(*span);
            Guard::Otherwise
        }
        Some(RecipeGuard::When { test, parts, at }) => {
            places.guard = Some(test.span);
            places.tested = spans(parts);
            places.testers = spans(at);
            Guard::Test {
                name: test.text.clone(),
                inputs: texts(parts),
                at: texts(at),
            }
        }
    };
    let mut steps = Vec::new();
    for step in &decl.steps {
        let operations = step.iter().map(|call| OperationCall {
            name: call.name.text.clone(),
            inputs: texts(&call.inputs),
            outputs: texts(&call.outputs),
        });
        steps.push(Step::new(operations.collect()));
        let calls = step.iter().map(|call| CallPlaces {
            span: call.span,
            name: call.name.span,
            inputs: spans(&call.inputs),
            outputs: spans(&call.outputs),
        });
        places.steps.push(calls.collect());
    }
    let transition = RecipeTransition {
        from: decl.from.text.clone(),
        to: decl.to.text.clone(),
        guard,
        steps,
    };
    (transition, places)
}
