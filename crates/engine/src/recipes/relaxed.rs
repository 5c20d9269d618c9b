//! Layouts and recipes that permit more: whether a recipe could be made if something were
//! different.
//!
//! Each answer is that of a complete search, so a cause that is named is one: with this change
//! alone, the recipe can be made.

use super::findings::Subject;
use linewright_recipe::model::{Layout, Recipe};
use linewright_recipe::realize::{SearchLimits, is_realizable};

/// Maximum number of single states and of resources that are tried one by one.
const MAX_TRIED: usize = 64;

/// Part of the limits that each of these searches may use.
const SHARE: usize = 8;

/// What alone would make a recipe realizable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Relaxation {
    /// These parts could remain at an end.
    Leftover(Vec<String>),
    /// A resource could wait in one of its states, as indices.
    Waiting(usize, usize),
    /// Several resources could wait wherever they may not.
    WaitingEverywhere,
    /// A resource, as an index, had room for one part more.
    Room(usize),
}

/// Returns what alone would make a recipe realizable that is not. Of each kind, the first is found.
pub(super) fn relaxations(of: &Subject<'_>, limits: SearchLimits) -> Vec<Relaxation> {
    let (layout, recipe) = (&of.layout.model, &of.recipe.model);
    let limits = SearchLimits {
        nodes: limits.nodes / SHARE,
        vectors: limits.vectors / SHARE,
    };
    let could = |layout: &Layout, recipe: &Recipe| {
        is_realizable(layout, recipe, limits).is_ok_and(|verdict| verdict == Some(true))
    };
    let mut found = Vec::new();
    found.extend(leftover(layout, recipe, &could));
    found.extend(waiting(layout, recipe, &could));
    for at in 0..layout.resources.len().min(MAX_TRIED) {
        let mut larger = layout.clone();
        larger.resources[at].capacity += 1;
        if could(&larger, recipe) {
            found.push(Relaxation::Room(at));
            break;
        }
    }
    found
}

/// Whether it could be made if parts could remain, with the fewest that are needed one by one.
fn leftover(
    layout: &Layout,
    recipe: &Recipe,
    could: &dyn Fn(&Layout, &Recipe) -> bool,
) -> Option<Relaxation> {
    let names = recipe.parts.iter().map(|p| p.name.clone());
    let mut relaxed = recipe.clone();
    relaxed.leftover.extend(names.clone());
    if !could(layout, &relaxed) {
        return None;
    }
    // Drops one part after the other that need not remain.
    let mut needed: Vec<String> = names.collect();
    let mut at = 0;
    while at < needed.len() && needed.len() <= MAX_TRIED {
        let part = needed.remove(at);
        let mut fewer = recipe.clone();
        fewer.leftover.extend(needed.iter().cloned());
        if !could(layout, &fewer) {
            needed.insert(at, part);
            at += 1;
        }
    }
    Some(Relaxation::Leftover(needed))
}

/// Whether it could be made if resources could wait.
fn waiting(
    layout: &Layout,
    recipe: &Recipe,
    could: &dyn Fn(&Layout, &Recipe) -> bool,
) -> Option<Relaxation> {
    let restless: Vec<(usize, usize)> = (layout.resources.iter().enumerate())
        .flat_map(|(at, resource)| {
            let states = resource.states.iter().enumerate();
            let restless = states.filter(|(_, s)| !s.may_wait);
            restless.map(move |(state, _)| (at, state))
        })
        .collect();
    if restless.is_empty() {
        return None;
    }
    let with = |states: &[(usize, usize)]| {
        let mut relaxed = layout.clone();
        for (at, state) in states {
            relaxed.resources[*at].states[*state].may_wait = true;
        }
        could(&relaxed, recipe)
    };
    if !with(&restless) {
        return None;
    }
    let mut tried = restless.iter().take(MAX_TRIED);
    let single = tried.find(|pair| with(&[**pair]));
    Some(match single {
        Some((at, state)) => Relaxation::Waiting(*at, *state),
        None => Relaxation::WaitingEverywhere,
    })
}
