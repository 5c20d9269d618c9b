//! Causes why a recipe cannot be made that are found without a search.
//!
//! Each is exact: every transition of the recipe that can be reached has to be realized, so one
//! step that no configuration permits suffices. What is examined is more than the cell can do:
//! parts move one at a time through resources that do not hinder each other ([`Ways`]).

use super::flow::{Site, Supply, supplies};
use super::ways::Ways;
use crate::model::{Action, Guard, Layout, Recipe, Step};
use rustc_hash::FxHashSet;

/// Cause that is found without a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Obstacle {
    /// No resource performs an operation.
    NoPerformer {
        /// Index of the transition of the recipe.
        transition: usize,
        /// Index of the step.
        step: usize,
        /// Name of the operation.
        operation: String,
    },
    /// An operation needs a part that no operation before it has made, or that another one has
    /// consumed, and the layout does not hold one like it.
    NoSource {
        /// Index of the transition of the recipe.
        transition: usize,
        /// Index of the step.
        step: usize,
        /// Name of the part.
        part: String,
    },
    /// No resource that performs an operation has room for the parts that it needs or makes.
    NoRoom {
        /// Index of the transition of the recipe.
        transition: usize,
        /// Index of the step.
        step: usize,
        /// Index of the operation in the step.
        operation: usize,
        /// Number of parts for which there would have to be room.
        parts: usize,
    },
    /// The operations of a step need different resources, but there are not enough.
    TooFewPerformers {
        /// Index of the transition of the recipe.
        transition: usize,
        /// Index of the step.
        step: usize,
        /// Indices of the resources that perform one of the operations.
        performers: Vec<usize>,
    },
    /// A part cannot get to a resource that performs the operation or the test that needs it,
    /// however the resources move.
    NoWay {
        /// Index of the transition of the recipe.
        transition: usize,
        /// Index of the step; `None` for the test of the transition.
        step: Option<usize>,
        /// Name of the part.
        part: String,
        /// Indices of the resources where the part can be made or is at the start.
        from: Vec<usize>,
        /// Indices of the resources where it would have to be.
        to: Vec<usize>,
    },
}

/// Returns the causes that are found without a search; each name once. Takes time proportional to
/// the number of operations in the recipe times the size of the layout.
pub(crate) fn obstacles(layout: &Layout, recipe: &Recipe) -> Vec<Obstacle> {
    let supply = supplies(layout, recipe);
    let mut search = Search {
        layout,
        recipe,
        ways: None,
        found: Vec::new(),
        named: FxHashSet::default(),
    };
    for (number, transition) in recipe.transitions.iter().enumerate() {
        let Some(points) = &supply[number] else {
            continue;
        };
        if let Guard::Test { inputs, at, .. } = &transition.guard {
            search.test(number, inputs, at, &points[0]);
        }
        for (index, step) in transition.steps.iter().enumerate() {
            search.step(number, index, step, &points[index]);
        }
    }
    search.found
}

struct Search<'m> {
    layout: &'m Layout,
    recipe: &'m Recipe,
    /// Built when it is needed first.
    ways: Option<Ways>,
    found: Vec<Obstacle>,
    /// Operations and parts about which something was found.
    named: FxHashSet<&'m str>,
}

impl<'m> Search<'m> {
    fn step(&mut self, transition: usize, index: usize, step: &'m Step, supply: &Supply) {
        let mut performers: Vec<Vec<Site>> = Vec::new();
        for call in &step.operations {
            let of = performers_of(self.layout, &call.name);
            if of.is_empty() && self.named.insert(&call.name) {
                self.found.push(Obstacle::NoPerformer {
                    transition,
                    step: index,
                    operation: call.name.clone(),
                });
            }
            performers.push(of);
        }
        let before = self.found.len();
        for (number, call) in step.operations.iter().enumerate() {
            let parts = call.inputs.len().max(call.outputs.len());
            let has_room = |at: &Site| self.layout.resources[at.0].capacity >= parts;
            let of = &performers[number];
            if !of.is_empty() && !of.iter().any(has_room) && self.named.insert(&call.name) {
                self.found.push(Obstacle::NoRoom {
                    transition,
                    step: index,
                    operation: number,
                    parts,
                });
            }
            for part in &call.inputs {
                self.input(transition, Some(index), part, supply, of);
            }
        }
        let all_exist = performers.iter().all(|p| !p.is_empty());
        if all_exist && before == self.found.len() && !can_be_matched(&performers) {
            let mut all: Vec<usize> = performers.iter().flatten().map(|p| p.0).collect();
            all.sort_unstable();
            all.dedup();
            self.found.push(Obstacle::TooFewPerformers {
                transition,
                step: index,
                performers: all,
            });
        }
    }

    fn test(&mut self, transition: usize, inputs: &'m [String], at: &[String], supply: &Supply) {
        let mut testers: Vec<Site> = Vec::new();
        for resource in at.iter().filter_map(|name| self.layout.resource(name)) {
            let states = 0..self.layout.resources[resource].states.len();
            testers.extend(states.map(|state| (resource, state)));
        }
        for part in inputs {
            if !testers.is_empty() {
                self.input(transition, None, part, supply, &testers);
            }
        }
    }

    /// Examines whether a part exists, and can get to one of these places.
    fn input(
        &mut self,
        transition: usize,
        step: Option<usize>,
        part: &'m str,
        supply: &Supply,
        targets: &[Site],
    ) {
        let Some(number) = self.recipe.part(part) else {
            return;
        };
        let sources = &supply.sources[number];
        if sources.is_empty() {
            // Operations without a performer make no parts; that is reported for them.
            if let (Some(step), true) = (step, supply.counts[number] == 0)
                && self.named.insert(part)
            {
                self.found.push(Obstacle::NoSource {
                    transition,
                    step,
                    part: part.to_owned(),
                });
            }
            return;
        }
        if targets.is_empty() {
            return;
        }
        let ways = self.ways.get_or_insert_with(|| Ways::new(self.layout));
        if ways.leads(sources, targets) || !self.named.insert(part) {
            return;
        }
        let resources = |sites: &mut dyn Iterator<Item = &Site>| {
            let mut all: Vec<usize> = sites.map(|site| site.0).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        self.found.push(Obstacle::NoWay {
            transition,
            step,
            part: part.to_owned(),
            from: resources(&mut sources.iter()),
            to: resources(&mut targets.iter()),
        });
    }
}

/// Returns the resources that perform an operation, each with the state that it leaves.
fn performers_of(layout: &Layout, operation: &str) -> Vec<Site> {
    let mut performers = Vec::new();
    for (at, resource) in layout.resources.iter().enumerate() {
        for transition in &resource.transitions {
            if matches!(&transition.action, Action::Operation(name) if name == operation) {
                performers.extend(resource.state(&transition.from).map(|state| (at, state)));
            }
        }
    }
    performers
}

/// Returns whether each operation can have a resource of its own: a bipartite matching by
/// augmenting paths.
fn can_be_matched(performers: &[Vec<Site>]) -> bool {
    fn augment(
        of: usize,
        performers: &[Vec<Site>],
        seen: &mut FxHashSet<usize>,
        taken: &mut Vec<(usize, usize)>,
    ) -> bool {
        for (resource, _) in &performers[of] {
            if !seen.insert(*resource) {
                continue;
            }
            let by = taken.iter().position(|(r, _)| r == resource);
            let is_free = by.is_none_or(|at| augment(taken[at].1, performers, seen, taken));
            if is_free {
                taken.retain(|(r, _)| r != resource);
                taken.push((*resource, of));
                return true;
            }
        }
        false
    }
    let mut taken = Vec::new();
    (0..performers.len()).all(|of| augment(of, performers, &mut FxHashSet::default(), &mut taken))
}
