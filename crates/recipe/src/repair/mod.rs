//! Repairs: the smallest changes of a layout that make a recipe realizable.
//!
//! More transitions, more capacity and more resources never make a recipe unrealizable. So if a set
//! of changes does not suffice, each repair has a change from outside every such set. Repairs are
//! therefore the minimal hitting sets of the complements of the insufficient sets, and are found
//! with a tree of hitting sets (R. Reiter, "A theory of diagnosis from first principles", 1987):
//! a set of changes that does not suffice is enlarged as far as it still does not, and is then
//! tried with each of the remaining changes.

mod changes;

pub use changes::{Change, apply, capacities, duplicates, operations, routes};

use crate::model::{Layout, Problem, Recipe};
use crate::realize::{SearchLimits, decide, problems};
use rustc_hash::{FxHashMap, FxHashSet};

/// Maximum number of nodes of a search that only serves to enlarge an insufficient set.
const ENLARGING_NODES: usize = 20_000;

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
/// Takes one search for each set tried; their number is at most that of the sets up to the size,
/// and far smaller if few candidates matter.
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
    let mut tree = Tree {
        layout,
        recipe,
        candidates,
        limits,
        searches: 0,
    };
    let mut repairs = Repairs {
        is_complete: true,
        ..Repairs::default()
    };
    let mut found: Vec<Vec<usize>> = Vec::new();
    // Sets that do not suffice, with what remains to be tried with them.
    let mut open: Vec<Vec<usize>> = vec![Vec::new()];
    for size in 0..=max_changes {
        let mut insufficient = Vec::new();
        for set in std::mem::take(&mut open) {
            match tree.suffices(&set, limits) {
                Some(true) => found.push(set),
                verdict => {
                    repairs.is_complete &= verdict.is_some();
                    insufficient.push((set, verdict.is_some()));
                }
            }
        }
        if size == max_changes || found == [Vec::new()] {
            break;
        }
        let mut seen = FxHashSet::default();
        for (set, is_proved) in insufficient {
            let remaining = if is_proved {
                tree.remaining(&set, size + 1 < max_changes)
            } else {
                (0..candidates.len()).filter(|c| !set.contains(c)).collect()
            };
            for candidate in remaining {
                let mut larger = set.clone();
                larger.push(candidate);
                larger.sort_unstable();
                let is_superset = |f: &Vec<usize>| f.iter().all(|c| larger.contains(c));
                if !found.iter().any(is_superset) && seen.insert(larger.clone()) {
                    open.push(larger);
                }
            }
        }
        open.sort_unstable();
    }
    repairs.searches = tree.searches;
    let changes = |set: &Vec<usize>| set.iter().map(|c| candidates[*c].clone()).collect();
    repairs.sets = found.iter().map(changes).collect();
    Ok(repairs)
}

/// What is needed to try sets of changes.
struct Tree<'a> {
    layout: &'a Layout,
    recipe: &'a Recipe,
    candidates: &'a [Change],
    limits: SearchLimits,
    searches: usize,
}

impl Tree<'_> {
    /// Returns whether a set of candidates suffices, if this is decided within the limits.
    fn suffices(&mut self, set: &[usize], limits: SearchLimits) -> Option<bool> {
        self.searches += 1;
        let changed = apply(self.layout, set.iter().map(|c| &self.candidates[*c]));
        decide(&changed, self.recipe, limits)
    }

    /// Enlarges a set that does not suffice. Returns the candidates that remain outside.
    ///
    /// Candidates are added by group; with `is_fine`, a group that cannot be added is halved.
    fn remaining(&mut self, set: &[usize], is_fine: bool) -> Vec<usize> {
        let limits = SearchLimits {
            nodes: self.limits.nodes.min(ENLARGING_NODES),
            vectors: self.limits.vectors.min(20 * ENLARGING_NODES),
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut numbers = FxHashMap::default();
        for (at, candidate) in self.candidates.iter().enumerate() {
            if set.contains(&at) {
                continue;
            }
            let number = *numbers.entry(candidate.group()).or_insert_with(|| {
                groups.push(Vec::new());
                groups.len() - 1
            });
            groups[number].push(at);
        }
        let mut enlarged = set.to_vec();
        let mut remaining = Vec::new();
        groups.reverse();
        while let Some(mut group) = groups.pop() {
            let before = enlarged.len();
            enlarged.extend(&group);
            if self.suffices(&enlarged, limits) == Some(false) {
                continue;
            }
            enlarged.truncate(before);
            if is_fine && group.len() > 1 {
                let half = group.split_off(group.len() / 2);
                groups.extend([half, group]);
            } else {
                remaining.extend(group);
            }
        }
        remaining.sort_unstable();
        remaining
    }
}
