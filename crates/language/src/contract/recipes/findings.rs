//! Findings for the problems that the crate `recipe` finds in a model.

use super::super::skills::near_or_all;
use crate::contract::recipe::{Layout, Recipe};
use linewright_core::diagnostics::{Code, Diagnostic, codes, nearest};
use linewright_core::source::Span;
use linewright_recipe::model::{Action, Guard, Problem};

/// Returns the name that a problem of a recipe is about, if it is in the statements `start`, `end`
/// or `leftover`.
pub(super) fn subject(problem: &Problem) -> Option<&str> {
    match problem {
        Problem::UnknownState(name) | Problem::UnknownLeftover(name) => Some(name),
        _ => None,
    }
}

/// Text of a finding.
struct Text {
    code: Code,
    span: Span,
    message: String,
    help: String,
}

impl Text {
    fn new(code: Code, span: Span, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            code,
            span,
            message: message.into(),
            help: help.into(),
        }
    }

    fn finding(self, problem: &Problem) -> Diagnostic {
        let Self {
            code,
            span,
            message,
            help,
        } = self;
        let finding = if problem.is_warning() {
            Diagnostic::warning(code, span, message)
        } else {
            Diagnostic::error(code, span, message)
        };
        finding.with_help(help)
    }
}

/// Returns the finding for a problem of a recipe, or of a recipe on a layout.
pub(super) fn of_recipe(problem: &Problem, recipe: &Recipe, layout: Option<&Layout>) -> Diagnostic {
    let model = &recipe.model;
    let state_span = |name: &str| {
        let at = model.state(name);
        at.map_or(recipe.span, |at| recipe.states[at])
    };
    let other_states = |name: &str| {
        let name = name.to_owned();
        let states = model.states.iter().map(String::as_str);
        states.filter(move |s| *s != name)
    };
    let places = |number: usize| recipe.transitions.get(number).cloned().unwrap_or_default();
    let text = match problem {
        Problem::UnknownState(name) => Text::new(
            codes::NAME_UNKNOWN,
            recipe.span,
            format!("no transition leads to or from a state `{name}`"),
            near_or_all(name, other_states(name), "the states are"),
        ),
        Problem::UnknownPart { transition, part } => {
            let known = model.parts.iter().map(|p| p.name.as_str());
            Text::new(
                codes::NAME_UNKNOWN,
                part_span(recipe, *transition, part),
                format!("`{}` has no part `{part}`", model.name),
                if model.parts.is_empty() {
                    format!("declare it, with its type: `part {part}: Pin`")
                } else {
                    near_or_all(part, known, "its parts are")
                },
            )
        }
        Problem::UnknownLeftover(name) => {
            let known = (model.parts.iter()).flat_map(|p| [p.name.as_str(), p.kind.as_str()]);
            Text::new(
                codes::NAME_UNKNOWN,
                recipe.span,
                format!("`{name}` is neither a part nor a type of a part"),
                near_or_all(name, known, "the parts and types are"),
            )
        }
        Problem::UnknownTester {
            transition,
            resource,
        } => {
            let places = places(*transition);
            let at = match model.transitions.get(*transition).map(|t| &t.guard) {
                Some(Guard::Test { at, .. }) => at.iter().position(|r| r == resource),
                _ => None,
            };
            let known = layout.iter().flat_map(|l| &l.model.resources);
            let name = layout.map_or("", |l| &l.model.name);
            Text::new(
                codes::NAME_UNKNOWN,
                at.map_or(places.span, |at| places.testers[at]),
                format!("the layout `{name}` has no resource `{resource}` for this test"),
                near_or_all(
                    resource,
                    known.map(|r| r.name.as_str()),
                    "its resources are",
                ),
            )
        }
        Problem::NoEnd(name) => Text::new(
            codes::RECIPE_GRAPH,
            recipe.span,
            format!("the recipe `{name}` has no end"),
            "name the states in which it ends: `end d`",
        ),
        Problem::LeavesEnd { transition, state } => Text::new(
            codes::RECIPE_GRAPH,
            places(*transition).span,
            format!("the recipe ends in state `{state}`, but a transition leaves it"),
            format!("remove the transition, or take `{state}` out of `end`"),
        ),
        Problem::NoWayOn(state) => {
            let near = nearest(state, other_states(state));
            let help = "end the recipe there, or write a transition that leaves it";
            Text::new(
                codes::RECIPE_GRAPH,
                state_span(state),
                format!("no transition leaves state `{state}`, and the recipe does not end there"),
                match near {
                    Some(near) => format!("did you mean `{near}`? Otherwise {help}"),
                    None => format!("{help}: `end {state}`"),
                },
            )
        }
        Problem::Unreachable(state) => Text::new(
            codes::RECIPE_GRAPH,
            state_span(state),
            format!("no way leads from the start of the recipe to state `{state}`"),
            "write a transition that enters it, or remove it",
        ),
        Problem::IdleLoop(state) => {
            let entering = model
                .transitions
                .iter()
                .position(|t| t.to == *state && t.steps.is_empty());
            Text::new(
                codes::RECIPE_GRAPH,
                entering.map_or_else(|| state_span(state), |at| recipe.transitions[at].span),
                format!("a loop through state `{state}` has no operation"),
                "write an operation into the loop, such as the work that is to be repeated",
            )
        }
        Problem::NotCovered(state) => Text::new(
            codes::RECIPE_GUARDS,
            state_span(state),
            format!("all tests in state `{state}` can fail, and then nothing follows"),
            format!("say what follows then: `{state} -> d otherwise: remove(h)()`"),
        ),
        Problem::TwoOtherwise(state) => {
            let mut of_state = (model.transitions.iter().zip(&recipe.transitions))
                .filter(|(t, _)| t.from == *state && t.guard == Guard::Otherwise)
                .filter_map(|(_, places)| places.guard);
            let first = of_state.next().unwrap_or(recipe.span);
            let second = of_state.next().unwrap_or(first);
            return Text::new(
                codes::RECIPE_GUARDS,
                second,
                format!("two transitions with `otherwise` leave state `{state}`"),
                "keep one of them, or give one a test: `when visionOk(h)`",
            )
            .finding(problem)
            .with_label(first, "the first");
        }
        Problem::TooLarge { .. } => too_large(problem, recipe.span),
        // The resolver reports these itself, or the grammar excludes them.
        Problem::EmptyStep { transition, .. } => other(problem, places(*transition).span),
        _ => other(problem, recipe.span),
    };
    text.finding(problem)
}

fn too_large(problem: &Problem, span: Span) -> Text {
    Text::new(
        codes::DOMAIN_EMPTY,
        span,
        problem.to_string(),
        "divide it into several smaller ones",
    )
}

fn other(problem: &Problem, span: Span) -> Text {
    Text::new(
        codes::NAME_UNKNOWN,
        span,
        problem.to_string(),
        "correct this name",
    )
}

/// Returns the first place of a part in a transition.
fn part_span(recipe: &Recipe, transition: usize, part: &str) -> Span {
    let (Some(model), Some(places)) = (
        recipe.model.transitions.get(transition),
        recipe.transitions.get(transition),
    ) else {
        return recipe.span;
    };
    let tested = match &model.guard {
        Guard::Test { inputs, .. } => inputs.as_slice(),
        _ => &[],
    };
    let mut named = tested.iter().zip(&places.tested).collect::<Vec<_>>();
    for (step, places) in model.steps.iter().zip(&places.steps) {
        for (call, places) in step.operations.iter().zip(places) {
            named.extend(call.inputs.iter().zip(&places.inputs));
            named.extend(call.outputs.iter().zip(&places.outputs));
        }
    }
    let found = named.into_iter().find(|(name, _)| *name == part);
    found.map_or(places.span, |(_, span)| *span)
}

/// Returns the finding for a problem of a layout.
pub(super) fn of_layout(problem: &Problem, layout: &Layout) -> Diagnostic {
    let model = &layout.model;
    let find = |name: &str| {
        let at = model.resource(name)?;
        Some((&model.resources[at], &layout.resources[at]))
    };
    let text = match problem {
        Problem::EmptyLayout(name) => Text::new(
            codes::DOMAIN_EMPTY,
            layout.span,
            format!("the layout `{name}` has no resources"),
            "declare them: `resource r1 at s0 { s0 -> s0: drill }`",
        ),
        Problem::Stuck { resource, state } => {
            let place = find(resource).and_then(|(model, info)| {
                let at = model.state(state)?;
                Some(info.states[at])
            });
            Text::new(
                codes::LAYOUT_STUCK,
                place.unwrap_or(layout.span),
                format!("`{resource}` cannot wait in state `{state}` and cannot leave it"),
                format!("write a transition that leaves it, or let it wait there: `nop {state}`"),
            )
        }
        Problem::NoPartner { resource, label } => {
            let place = find(resource).and_then(|(model, info)| {
                let at = model
                    .transitions
                    .iter()
                    .position(|t| shown(&t.action) == *label)?;
                Some(info.transitions[at])
            });
            Text::new(
                codes::LAYOUT_PARTNER,
                place.unwrap_or(layout.span),
                format!(
                    "no other resource is the partner of `{resource}` in the transfer `{label}`"
                ),
                partner_help(layout, resource, label),
            )
        }
        Problem::TooManyParts {
            resource,
            parts,
            capacity,
        } => {
            let place = find(resource).and_then(|(_, info)| info.holds.get(*capacity).copied());
            Text::new(
                codes::LAYOUT_CAPACITY,
                place.unwrap_or(layout.span),
                format!(
                    "`{resource}` has room for {capacity}, but would hold {parts} at the start"
                ),
                format!("give it room, `holds {parts}`, or let it hold less at the start"),
            )
        }
        Problem::TooLarge { .. } => too_large(problem, layout.span),
        Problem::BadQuantity { resource, .. } | Problem::UnknownResourceState { resource, .. } => {
            other(problem, find(resource).map_or(layout.span, |(_, i)| i.name))
        }
        _ => other(problem, layout.span),
    };
    text.finding(problem)
}

/// Returns a transfer as the layout writes it: `in:3`.
fn shown(action: &Action) -> String {
    match action {
        Action::In(label) => format!("in:{label}"),
        Action::Out(label) => format!("out:{label}"),
        Action::Operation(_) | Action::Internal(_) => String::new(),
    }
}

/// Returns what can be written so that a transfer has a partner.
fn partner_help(layout: &Layout, resource: &str, label: &str) -> String {
    let takes = label.starts_with("in:");
    let (_, name) = label.split_once(':').unwrap_or(("", label));
    let wanted = format!("{}:{name}", if takes { "out" } else { "in" });
    let others = layout.model.resources.iter().filter(|r| r.name != resource);
    let offered: Vec<String> = (others.flat_map(|r| &r.transitions))
        .filter(|t| matches!(t.action, Action::Out(_)) == takes && t.action.label().is_some())
        .map(|t| shown(&t.action))
        .collect();
    let route = if takes {
        format!("a route of a transport that ends at `{resource}`")
    } else {
        format!("a route of a transport that begins at `{resource}`")
    };
    let write = format!("write `{wanted}` at another resource, or {route}");
    match nearest(&wanted, offered.iter().map(String::as_str)) {
        Some(near) if near != wanted => {
            format!("{write}; is `{near}` of another resource meant for it?")
        }
        _ => write,
    }
}
