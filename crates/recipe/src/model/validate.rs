//! Validation: reports all problems at once, in the order of the text.

use super::recipe::closing_edges;
use super::{Action, Guard, Layout, Problem, Recipe, RecipeTransition, Resource};
use rustc_hash::{FxHashMap, FxHashSet};

/// Maximum number of resources, of states and transitions of a resource or recipe, of parts, and of
/// steps of a transition: the search stores them in 16 bits.
const MAX_SIZE: usize = 60_000;

/// Calls `report` with each name that has occurred before.
fn repeated<'a>(names: impl Iterator<Item = &'a str>, mut report: impl FnMut(&'a str)) {
    let mut seen = FxHashSet::default();
    for name in names {
        if !seen.insert(name) {
            report(name);
        }
    }
}

impl Layout {
    /// Returns all problems of the layout. Takes time proportional to its size.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        too_large(&[("resources", self.resources.len())], &mut problems);
        if self.resources.is_empty() {
            problems.push(Problem::EmptyLayout(self.name.clone()));
        }
        repeated(self.resources.iter().map(|r| r.name.as_str()), |name| {
            problems.push(Problem::DuplicateResource(name.to_owned()));
        });
        let mut offers: FxHashSet<(bool, &str, usize)> = FxHashSet::default();
        let mut counts = FxHashMap::<(bool, &str), usize>::default();
        for (at, resource) in self.resources.iter().enumerate() {
            for transition in &resource.transitions {
                let (is_in, label) = match &transition.action {
                    Action::In(label) => (true, label),
                    Action::Out(label) => (false, label),
                    _ => continue,
                };
                if offers.insert((is_in, label, at)) {
                    *counts.entry((is_in, label)).or_default() += 1;
                }
            }
        }
        for (at, resource) in self.resources.iter().enumerate() {
            resource.add_problems(&mut problems);
            let mut reported = FxHashSet::default();
            for transition in &resource.transitions {
                let (is_in, label) = match &transition.action {
                    Action::In(label) => (true, label),
                    Action::Out(label) => (false, label),
                    _ => continue,
                };
                let own = usize::from(offers.contains(&(!is_in, label, at)));
                let partners = counts.get(&(!is_in, label)).copied().unwrap_or(0) - own;
                if partners == 0 && reported.insert((is_in, label)) {
                    problems.push(Problem::NoPartner {
                        resource: resource.name.clone(),
                        label: format!("{}:{label}", if is_in { "in" } else { "out" }),
                    });
                }
            }
        }
        problems
    }
}

impl Resource {
    fn add_problems(&self, problems: &mut Vec<Problem>) {
        let resource = || self.name.clone();
        let sizes = [
            ("states of a resource", self.states.len()),
            ("transitions of a resource", self.transitions.len()),
            ("parts of a resource", self.holds.len()),
        ];
        too_large(&sizes, problems);
        repeated(self.states.iter().map(|s| s.name.as_str()), |state| {
            problems.push(Problem::DuplicateResourceState {
                resource: resource(),
                state: state.to_owned(),
            });
        });
        let known: FxHashSet<&str> = self.states.iter().map(|s| s.name.as_str()).collect();
        let mut missing = FxHashSet::default();
        let named = (self.transitions.iter()).flat_map(|t| [&t.from, &t.to]);
        for state in std::iter::once(&self.initial).chain(named) {
            if !known.contains(state.as_str()) && missing.insert(state) {
                problems.push(Problem::UnknownResourceState {
                    resource: resource(),
                    state: state.clone(),
                });
            }
        }
        for transition in &self.transitions {
            let quantities = [
                ("duration", transition.seconds),
                ("power", transition.watts),
            ];
            for (what, value) in quantities {
                if value.is_some_and(|v| !v.is_finite() || v < 0.0) {
                    problems.push(Problem::BadQuantity {
                        resource: resource(),
                        what,
                        from: transition.from.clone(),
                        to: transition.to.clone(),
                    });
                }
            }
        }
        if self.holds.len() > self.capacity {
            problems.push(Problem::TooManyParts {
                resource: resource(),
                parts: self.holds.len(),
                capacity: self.capacity,
            });
        }
        let left: FxHashSet<&str> = self.transitions.iter().map(|t| t.from.as_str()).collect();
        for state in &self.states {
            if !state.may_wait && !left.contains(state.name.as_str()) {
                problems.push(Problem::Stuck {
                    resource: resource(),
                    state: state.name.clone(),
                });
            }
        }
    }
}

impl Recipe {
    /// Returns all problems of the recipe. Takes time proportional to its size.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        let sizes = [
            ("parts", self.parts.len()),
            ("states of the recipe", self.states.len()),
            ("transitions of the recipe", self.transitions.len()),
        ];
        too_large(&sizes, &mut problems);
        repeated(self.parts.iter().map(|p| p.name.as_str()), |name| {
            problems.push(Problem::DuplicatePart(name.to_owned()));
        });
        repeated(self.states.iter().map(String::as_str), |name| {
            problems.push(Problem::DuplicateState(name.to_owned()));
        });
        let known: FxHashSet<&str> = self.states.iter().map(String::as_str).collect();
        let mut missing = FxHashSet::default();
        let named = (self.transitions.iter()).flat_map(|t| [&t.from, &t.to]);
        for state in std::iter::once(&self.start).chain(named).chain(&self.ends) {
            if !known.contains(state.as_str()) && missing.insert(state) {
                problems.push(Problem::UnknownState(state.clone()));
            }
        }
        if self.ends.is_empty() {
            problems.push(Problem::NoEnd(self.name.clone()));
        }
        for name in &self.leftover {
            if !self
                .parts
                .iter()
                .any(|p| p.name == *name || p.kind == *name)
            {
                problems.push(Problem::UnknownLeftover(name.clone()));
            }
        }
        let parts: FxHashSet<&str> = self.parts.iter().map(|p| p.name.as_str()).collect();
        let ends: FxHashSet<&str> = self.ends.iter().map(String::as_str).collect();
        let mut leaving: FxHashMap<&str, Vec<&Guard>> = FxHashMap::default();
        for (number, transition) in self.transitions.iter().enumerate() {
            transition.add_problems(number, &parts, &mut problems);
            if ends.contains(transition.from.as_str()) {
                problems.push(Problem::LeavesEnd {
                    transition: number,
                    state: transition.from.clone(),
                });
            }
            leaving
                .entry(&transition.from)
                .or_default()
                .push(&transition.guard);
        }
        for state in &self.states {
            match leaving.get(state.as_str()) {
                Some(guards) => add_guard_problems(state, guards, &mut problems),
                None if ends.contains(state.as_str()) => {}
                None => problems.push(Problem::NoWayOn(state.clone())),
            }
        }
        if missing.is_empty() {
            self.add_graph_problems(&mut problems);
        }
        problems
    }

    /// Adds states that cannot be reached, and loops without operations.
    fn add_graph_problems(&self, problems: &mut Vec<Problem>) {
        let mut edges = self.edges();
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); self.states.len()];
        for (from, to) in edges.iter().flatten() {
            leaving[*from].push(*to);
        }
        let mut reached = vec![false; self.states.len()];
        let mut open: Vec<usize> = self.state(&self.start).into_iter().collect();
        while let Some(state) = open.pop() {
            if !std::mem::replace(&mut reached[state], true) {
                open.extend(&leaving[state]);
            }
        }
        for (state, _) in self
            .states
            .iter()
            .zip(&reached)
            .filter(|(_, reached)| !**reached)
        {
            problems.push(Problem::Unreachable(state.clone()));
        }
        for (edge, transition) in edges.iter_mut().zip(&self.transitions) {
            if !transition.steps.is_empty() {
                *edge = None;
            }
        }
        let roots: Vec<usize> = (0..self.states.len()).collect();
        let closing = closing_edges(self.states.len(), &edges, &roots);
        for (transition, _) in self
            .transitions
            .iter()
            .zip(closing)
            .filter(|(_, closes)| *closes)
        {
            problems.push(Problem::IdleLoop(transition.to.clone()));
        }
    }

    /// Returns the problems that the recipe has on a layout, beside those that each has alone.
    pub fn problems_on(&self, layout: &Layout) -> Vec<Problem> {
        let names: FxHashSet<&str> = layout.resources.iter().map(|r| r.name.as_str()).collect();
        let mut problems = Vec::new();
        for (number, transition) in self.transitions.iter().enumerate() {
            let Guard::Test { at, .. } = &transition.guard else {
                continue;
            };
            for resource in at.iter().filter(|r| !names.contains(r.as_str())) {
                problems.push(Problem::UnknownTester {
                    transition: number,
                    resource: resource.clone(),
                });
            }
        }
        problems
    }
}

impl RecipeTransition {
    fn add_problems(&self, number: usize, known: &FxHashSet<&str>, problems: &mut Vec<Problem>) {
        let mut parts: Vec<&String> = Vec::new();
        if let Guard::Test { inputs, .. } = &self.guard {
            parts.extend(inputs);
        }
        too_large(&[("steps of a transition", self.steps.len())], problems);
        for (at, step) in self.steps.iter().enumerate() {
            if step.operations.is_empty() {
                problems.push(Problem::EmptyStep {
                    transition: number,
                    step: at,
                });
            }
            let calls = step.operations.iter();
            parts.extend(calls.flat_map(|c| c.inputs.iter().chain(&c.outputs)));
        }
        let mut missing = FxHashSet::default();
        for part in parts {
            if !known.contains(part.as_str()) && missing.insert(part) {
                problems.push(Problem::UnknownPart {
                    transition: number,
                    part: part.clone(),
                });
            }
        }
    }
}

/// Adds the problems of the guards of the transitions that leave a state.
fn add_guard_problems(state: &str, guards: &[&Guard], problems: &mut Vec<Problem>) {
    if guards.iter().all(|g| matches!(g, Guard::Test { .. })) {
        problems.push(Problem::NotCovered(state.to_owned()));
    }
    if guards.iter().filter(|g| ***g == Guard::Otherwise).count() > 1 {
        problems.push(Problem::TwoOtherwise(state.to_owned()));
    }
}

/// Adds a problem for each number that is too large for the search.
fn too_large(sizes: &[(&'static str, usize)], problems: &mut Vec<Problem>) {
    for (what, _) in sizes.iter().filter(|(_, size)| *size > MAX_SIZE) {
        problems.push(Problem::TooLarge {
            what,
            limit: MAX_SIZE,
        });
    }
}
