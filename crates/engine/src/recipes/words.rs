//! Recipes, layouts and what resources do, in the words of the language.

use linewright_language::contract::recipe::Realization;
use linewright_recipe::controller::{Leg, Move, Subject, Vector};
use linewright_recipe::model::{Action, Guard, Layout, OperationCall, Recipe, RecipeTransition};
use linewright_recipe::repair::Change;

/// `Hinge on Pad`, or `3 Hinge, 2 Plate on Pad`.
pub fn title(realization: &Realization) -> String {
    let recipes = realization.recipes.iter().map(|wanted| match wanted.count {
        1 => wanted.name.clone(),
        count => format!("{count} {}", wanted.name),
    });
    let recipes: Vec<String> = recipes.collect();
    format!("{} on {}", recipes.join(", "), realization.layout)
}

/// `insert(p, h)(h2)`
pub fn call(call: &OperationCall) -> String {
    format!(
        "{}({})({})",
        call.name,
        call.inputs.join(", "),
        call.outputs.join(", ")
    )
}

/// `a -> b when visionOk(h2)`
pub fn transition(transition: &RecipeTransition) -> String {
    let guard = match &transition.guard {
        Guard::Always => String::new(),
        Guard::Otherwise => " otherwise".to_owned(),
        Guard::Test { name, inputs, at } => {
            let at = if at.is_empty() {
                String::new()
            } else {
                format!(" at {}", at.join(", "))
            };
            format!(" when {name}({}){at}", inputs.join(", "))
        }
    };
    format!("{} -> {}{guard}", transition.from, transition.to)
}

/// `glue`, `internal turn`, `in:3` or `out:3`.
pub fn action(action: &Action) -> String {
    match action {
        Action::Operation(name) => name.clone(),
        Action::Internal(name) => format!("internal {name}"),
        Action::In(label) => format!("in:{label}"),
        Action::Out(label) => format!("out:{label}"),
    }
}

/// A vector: operations as `r3: glue(p)(p)`, internal operations as `r3: turn`, and transfers as
/// `r3 => r5: p`. `transition` is the one of the recipe, and `step` the number of its steps that
/// were performed before.
pub fn vector(
    layout: &Layout,
    recipe: &Recipe,
    transition: usize,
    step: usize,
    vector: &Vector,
) -> Vec<String> {
    let of = |m: &Move| {
        let resource = &layout.resources[m.resource];
        (resource.name.as_str(), &resource.transitions[m.transition])
    };
    let mut shown = Vec::new();
    for m in &vector.moves {
        let (name, taken) = of(m);
        match &m.subject {
            Subject::Operation(number) => {
                let steps = &recipe.transitions[transition].steps;
                let shown_call = steps
                    .get(step)
                    .and_then(|s| s.operations.get(*number))
                    .map_or_else(|| action(&taken.action), call);
                shown.push(format!("{name}: {shown_call}"));
            }
            Subject::Internal => shown.push(format!("{name}: {}", action(&taken.action))),
            Subject::Part(part) => {
                let Action::Out(label) = &taken.action else {
                    continue;
                };
                let taker = vector
                    .moves
                    .iter()
                    .map(of)
                    .find(|(_, t)| matches!(&t.action, Action::In(other) if other == label));
                let taker = taker.map_or("?", |(name, _)| name);
                shown.push(format!("{name} => {taker}: {part}"));
            }
        }
    }
    shown
}

/// Returns the vectors of a leg, each with the number of the recipe's steps before it.
pub fn numbered(leg: &Leg) -> impl Iterator<Item = (usize, &Vector)> {
    let mut performed = 0;
    leg.vectors.iter().map(move |vector| {
        let step = performed;
        performed += usize::from(performs_step(vector));
        (step, vector)
    })
}

/// Whether a vector performs operations of the recipe, and so one of its steps.
fn performs_step(vector: &Vector) -> bool {
    let is_operation = |m: &Move| matches!(m.subject, Subject::Operation(_));
    vector.moves.iter().any(is_operation)
}

/// A change of a layout as a line of the language: `r3: s1 -> s2: glue`, `r5: r3 -> r2`,
/// `r3 holds 3` or `resource r3_2 = r3`.
pub fn change(layout: &Layout, is_transport: &dyn Fn(&str) -> bool, change: &Change) -> String {
    match change {
        Change::Operation {
            resource,
            from,
            operation,
            to,
        } => format!("{resource}: {from} -> {to}: {operation}"),
        Change::Route {
            resource,
            from,
            label,
            to,
        } => {
            let takers = takers(layout, label, resource);
            if is_transport(resource) && !takers.is_empty() {
                format!("transport {resource}: {from} -> {}", takers.join(", "))
            } else {
                format!("{resource}: {from} -> {to}: out:{label}")
            }
        }
        Change::Connection {
            resource,
            take,
            give,
            ..
        } => {
            let from = givers(layout, take, resource);
            let to = takers(layout, give, resource);
            format!(
                "transport {resource}: {} -> {}",
                from.join(", "),
                to.join(", ")
            )
        }
        Change::Capacity { resource } => {
            let capacity = layout
                .resource(resource)
                .map_or(0, |at| layout.resources[at].capacity);
            format!("{resource} holds {}", capacity + 1)
        }
        Change::Duplicate { resource } => {
            let mut number = 2;
            while layout.resource(&format!("{resource}_{number}")).is_some() {
                number += 1;
            }
            format!("resource {resource}_{number} = {resource}")
        }
    }
}

/// Names of the resources that give parts under a label, without this one.
fn givers<'m>(layout: &'m Layout, label: &str, without: &str) -> Vec<&'m str> {
    let gives = |action: &Action| matches!(action, Action::Out(other) if other == label);
    (layout.resources.iter())
        .filter(|r| r.name != without && r.transitions.iter().any(|t| gives(&t.action)))
        .map(|r| r.name.as_str())
        .collect()
}

/// Names of the resources that take parts under a label, without this one.
fn takers<'m>(layout: &'m Layout, label: &str, without: &str) -> Vec<&'m str> {
    let takes = |action: &Action| matches!(action, Action::In(other) if other == label);
    (layout.resources.iter())
        .filter(|r| r.name != without && r.transitions.iter().any(|t| takes(&t.action)))
        .map(|r| r.name.as_str())
        .collect()
}

/// A list in a sentence: `a`, `a and b`, `a, b and c`, each in code marks.
pub fn quoted<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    crate::findings::list(&names)
}
