//! Where the parts that a step needs can have been made: reaching definitions on the recipe.
//!
//! For each place in the recipe and each part, this computes an upper bound of the number of its
//! copies, and the places where they can have been made. An operation that needs all copies that
//! there can be ends what was made before it (A. V. Aho et al., *Compilers*, section 9.2.4, where a
//! definition is killed by the next).

use crate::model::{Action, Layout, Recipe, Step};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// A resource and one of its states, as indices.
pub(super) type Site = (usize, usize);

/// Number of copies from which on they are not counted.
const MANY: usize = 64;

/// What there can be of each part of the recipe at one of its places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Supply {
    /// Upper bound of the number of copies; `MANY` stands for any number. Stock of the part's type
    /// is not counted.
    pub counts: Vec<usize>,
    /// Where they can have been made: a resource, and the state in which it was then. Stock is
    /// always among them.
    pub sources: Vec<BTreeSet<Site>>,
}

impl Supply {
    /// Adds what there can be on another way to the same place. Returns whether this is more.
    fn join(&mut self, other: &Self) -> bool {
        let mut is_more = false;
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            is_more |= more > count;
            *count = (*count).max(*more);
        }
        for (sources, more) in self.sources.iter_mut().zip(&other.sources) {
            let before = sources.len();
            sources.extend(more);
            is_more |= sources.len() > before;
        }
        is_more
    }
}

/// What the places of a recipe have in common.
struct Flow<'m> {
    recipe: &'m Recipe,
    /// Stock of the type of each part.
    stock: Vec<BTreeSet<Site>>,
    /// For each operation, the resources that perform it and the states that they enter.
    performed: FxHashMap<&'m str, Vec<Site>>,
}

impl Flow<'_> {
    fn after(&self, before: &Supply, step: &Step) -> Supply {
        let mut after = before.clone();
        for (number, part) in self.recipe.parts.iter().enumerate() {
            let copies = |names: &[String]| names.iter().filter(|n| **n == part.name).count();
            let needed: usize = step.operations.iter().map(|c| copies(&c.inputs)).sum();
            let made: usize = step.operations.iter().map(|c| copies(&c.outputs)).sum();
            let count = &mut after.counts[number];
            let sources = &mut after.sources[number];
            if *count < MANY {
                if needed > 0 && *count <= needed {
                    sources.clone_from(&self.stock[number]);
                }
                *count = (count.saturating_sub(needed) + made).min(MANY);
            }
            for call in &step.operations {
                if copies(&call.outputs) > 0 {
                    sources.extend(self.performed.get(call.name.as_str()).into_iter().flatten());
                }
            }
        }
        after
    }
}

/// Returns, for each transition of the recipe, what there can be before each of its steps and after
/// the last; `None` if the start does not lead to it.
pub(super) fn supplies(layout: &Layout, recipe: &Recipe) -> Vec<Option<Vec<Supply>>> {
    let mut start = Supply {
        counts: vec![0; recipe.parts.len()],
        sources: vec![BTreeSet::new(); recipe.parts.len()],
    };
    let mut stock = vec![BTreeSet::new(); recipe.parts.len()];
    let mut performed: FxHashMap<&str, Vec<Site>> = FxHashMap::default();
    for (at, resource) in layout.resources.iter().enumerate() {
        for name in &resource.holds {
            let site = (at, resource.state(&resource.initial).unwrap_or(0));
            if let Some(part) = recipe.part(name) {
                start.counts[part] = (start.counts[part] + 1).min(MANY);
                start.sources[part].insert(site);
                continue;
            }
            for (number, part) in recipe.parts.iter().enumerate() {
                if part.kind == *name {
                    stock[number].insert(site);
                    start.sources[number].insert(site);
                }
            }
        }
        for transition in &resource.transitions {
            if let (Action::Operation(name), Some(to)) =
                (&transition.action, resource.state(&transition.to))
            {
                performed.entry(name).or_default().push((at, to));
            }
        }
    }
    let flow = Flow {
        recipe,
        stock,
        performed,
    };
    let mut at_state: Vec<Option<Supply>> = vec![None; recipe.states.len()];
    let mut open = Vec::new();
    if let Some(first) = recipe.state(&recipe.start) {
        at_state[first] = Some(start);
        open.push(first);
    }
    // Ends because counts and sets only grow, and are bounded.
    while let Some(state) = open.pop() {
        for (from, to, transition) in edges(recipe) {
            if from != state {
                continue;
            }
            let Some(mut supply) = at_state[from].clone() else {
                continue;
            };
            for step in &transition.steps {
                supply = flow.after(&supply, step);
            }
            let is_more = match &mut at_state[to] {
                Some(known) => known.join(&supply),
                unknown => {
                    *unknown = Some(supply);
                    true
                }
            };
            if is_more && !open.contains(&to) {
                open.push(to);
            }
        }
    }
    let of_transitions = recipe.transitions.iter().map(|transition| {
        let from = recipe.state(&transition.from)?;
        let mut points = vec![at_state[from].clone()?];
        for step in &transition.steps {
            let next = points.last().map(|before| flow.after(before, step));
            points.extend(next);
        }
        Some(points)
    });
    of_transitions.collect()
}

/// Returns the transitions with the states that they leave and enter.
fn edges(recipe: &Recipe) -> impl Iterator<Item = (usize, usize, &crate::model::RecipeTransition)> {
    let numbered = recipe.edges().into_iter().zip(&recipe.transitions);
    numbered.filter_map(|(edge, transition)| edge.map(|(from, to)| (from, to, transition)))
}
