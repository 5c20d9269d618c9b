//! Repairs: the smallest changes of a layout that make a recipe realizable.
//!
//! Sets of changes are tried in order of size. A set that does not suffice is extended by each
//! change that is *usable* with it: the search reaches a configuration where the new transition
//! could be taken. No repair is missed: when a controller uses one of the changes that the set
//! lacks for the first time, it has come there without them. Whether a larger capacity, a
//! connection or a duplicate is usable is not examined; they always count as usable. So does every
//! change once a set has a duplicate, since the duplicate and its routes get the other changes,
//! too.

mod changes;

pub use changes::{Change, apply, capacities, connections, duplicates, operations, routes};

use crate::model::{Layout, Problem, Recipe};
use crate::realize::{Reached, SearchLimits, decide, problems, reached};
use rustc_hash::FxHashSet;

/// Repairs of a layout.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Repairs {
    /// Minimal sets of changes that make the recipe realizable: smaller sets first, each in the
    /// order of the candidates. The empty set alone if the recipe is realizable as it is.
    pub sets: Vec<Vec<Change>>,
    /// Whether these are all minimal sets up to the size asked for. If not, some searches reached
    /// their limits.
    pub is_complete: bool,
    /// Number of searches.
    pub searches: usize,
}

/// Finds all minimal sets of at most `max_changes` candidates that make the recipe realizable.
///
/// Takes two searches for each set tried; their number is at most that of the sets up to the size,
/// and far smaller if few candidates are usable.
///
/// # Errors
/// All problems of the layout and the recipe, if any of them is more than a warning.
pub fn repairs(
    layout: &Layout,
    recipe: &Recipe,
    candidates: &[Change],
    max_changes: usize,
    limits: SearchLimits,
) -> Result<Repairs, Vec<Problem>> {
    let problems = problems(layout, recipe);
    if problems.iter().any(|p| !p.is_warning()) {
        return Err(problems);
    }
    let mut repairs = Repairs {
        is_complete: true,
        ..Repairs::default()
    };
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut open: Vec<Vec<usize>> = vec![Vec::new()];
    for size in 0..=max_changes {
        let mut seen = FxHashSet::default();
        let mut larger_sets = Vec::new();
        let before = found.len();
        for set in std::mem::take(&mut open) {
            let changed = apply(layout, set.iter().map(|c| &candidates[*c]));
            repairs.searches += 1;
            let verdict = decide(&changed, recipe, limits);
            if verdict == Some(true) {
                found.push(set);
                continue;
            }
            repairs.is_complete &= verdict.is_some();
            if size == max_changes {
                continue;
            }
            repairs.searches += 1;
            let is_copied = |c: &usize| matches!(candidates[*c], Change::Duplicate { .. });
            let reached = if set.iter().any(is_copied) {
                None
            } else {
                reached(&changed, recipe, limits)
            };
            for (candidate, change) in candidates.iter().enumerate() {
                let is_usable = reached.as_ref().is_none_or(|r| usable(change, &changed, r));
                if is_usable && !set.contains(&candidate) {
                    let mut larger = set.clone();
                    larger.push(candidate);
                    larger.sort_unstable();
                    if seen.insert(larger.clone()) {
                        larger_sets.push(larger);
                    }
                }
            }
        }
        found[before..].sort_unstable();
        let is_within = |set: &Vec<usize>, f: &Vec<usize>| f.iter().all(|c| set.contains(c));
        larger_sets.retain(|set| !found.iter().any(|f| is_within(set, f)));
        open = larger_sets;
    }
    let changes = |set: &Vec<usize>| set.iter().map(|c| candidates[*c].clone()).collect();
    repairs.sets = found.iter().map(changes).collect();
    Ok(repairs)
}

/// Returns whether the transition that a change adds could be taken somewhere.
fn usable(change: &Change, layout: &Layout, reached: &Reached<'_>) -> bool {
    let place = |resource: &str, state: &str| {
        let at = layout.resource(resource)?;
        Some((at, layout.resources[at].state(state)?))
    };
    match change {
        Change::Route { resource, from, .. } => {
            place(resource, from).is_some_and(|p| reached.holding.contains(&p))
        }
        Change::Operation {
            resource,
            from,
            operation,
            ..
        } => place(resource, from)
            .is_some_and(|(r, s)| reached.asked.contains(&(r, s, operation.as_str()))),
        Change::Capacity { .. } | Change::Connection { .. } | Change::Duplicate { .. } => true,
    }
}
