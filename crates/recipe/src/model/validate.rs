//! Validation: reports all problems at once, in the order of the text.

use super::{Action, Guard, Layout, Problem, Recipe, RecipeTransition, Resource};
use rustc_hash::FxHashSet;

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
        if self.resources.is_empty() {
            problems.push(Problem::EmptyLayout(self.name.clone()));
        }
        repeated(self.resources.iter().map(|r| r.name.as_str()), |name| {
            problems.push(Problem::DuplicateResource(name.to_owned()));
        });
        let mut offers: FxHashSet<(bool, &str, usize)> = FxHashSet::default();
        let mut counts = rustc_hash::FxHashMap::<(bool, &str), usize>::default();
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
    /// Returns all problems of the recipe. Takes time proportional to the product of the numbers
    /// of states and transitions.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        repeated(self.parts.iter().map(|p| p.name.as_str()), |name| {
            problems.push(Problem::DuplicatePart(name.to_owned()));
        });
        repeated(self.states.iter().map(String::as_str), |name| {
            problems.push(Problem::DuplicateState(name.to_owned()));
        });
        let mut missing = FxHashSet::default();
        let named = (self.transitions.iter()).flat_map(|t| [&t.from, &t.to]);
        for state in std::iter::once(&self.start).chain(named).chain(&self.ends) {
            if self.state(state).is_none() && missing.insert(state) {
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
        for (number, transition) in self.transitions.iter().enumerate() {
            self.add_transition_problems(number, transition, &mut problems);
        }
        for state in &self.states {
            self.add_state_problems(state, &mut problems);
        }
        if missing.is_empty() {
            let reached = self.reached(|_| true, &self.start);
            for state in self.states.iter().filter(|s| !reached.contains(s.as_str())) {
                problems.push(Problem::Unreachable(state.clone()));
            }
            let idle = |t: &RecipeTransition| t.steps.is_empty();
            for transition in self.transitions.iter().filter(|t| idle(t)) {
                // One report for each state that such a loop enters by this transition.
                if self
                    .reached(idle, &transition.to)
                    .contains(transition.from.as_str())
                {
                    problems.push(Problem::IdleLoop(transition.to.clone()));
                }
            }
        }
        problems
    }

    /// Returns the states that are reached from a state by the transitions that `along` selects.
    fn reached<'a>(
        &'a self,
        along: impl Fn(&RecipeTransition) -> bool,
        from: &'a str,
    ) -> FxHashSet<&'a str> {
        let mut reached = FxHashSet::from_iter([from]);
        let mut open = vec![from];
        while let Some(state) = open.pop() {
            for t in self
                .transitions
                .iter()
                .filter(|t| t.from == state && along(t))
            {
                if reached.insert(&t.to) {
                    open.push(&t.to);
                }
            }
        }
        reached
    }

    fn add_transition_problems(
        &self,
        number: usize,
        transition: &RecipeTransition,
        problems: &mut Vec<Problem>,
    ) {
        let mut missing = FxHashSet::default();
        let mut parts: Vec<&String> = Vec::new();
        if let Guard::Test { inputs, .. } = &transition.guard {
            parts.extend(inputs);
        }
        for (at, step) in transition.steps.iter().enumerate() {
            if step.operations.is_empty() {
                problems.push(Problem::EmptyStep {
                    transition: number,
                    step: at,
                });
            }
            let calls = step.operations.iter();
            parts.extend(calls.flat_map(|c| c.inputs.iter().chain(&c.outputs)));
        }
        for part in parts {
            if self.part(part).is_none() && missing.insert(part) {
                problems.push(Problem::UnknownPart {
                    transition: number,
                    part: part.clone(),
                });
            }
        }
        if self.ends.contains(&transition.from) {
            problems.push(Problem::LeavesEnd {
                transition: number,
                state: transition.from.clone(),
            });
        }
    }

    fn add_state_problems(&self, state: &str, problems: &mut Vec<Problem>) {
        let leaving = || self.transitions.iter().filter(|t| t.from == state);
        if leaving().next().is_none() {
            if !self.ends.iter().any(|e| e == state) {
                problems.push(Problem::NoWayOn(state.to_owned()));
            }
            return;
        }
        if leaving().all(|t| matches!(t.guard, Guard::Test { .. })) {
            problems.push(Problem::NotCovered(state.to_owned()));
        }
        if leaving().filter(|t| t.guard == Guard::Otherwise).count() > 1 {
            problems.push(Problem::TwoOtherwise(state.to_owned()));
        }
    }

    /// Returns the problems that the recipe has on a layout, beside those that each has alone.
    pub fn problems_on(&self, layout: &Layout) -> Vec<Problem> {
        let mut problems = Vec::new();
        for (number, transition) in self.transitions.iter().enumerate() {
            let Guard::Test { at, .. } = &transition.guard else {
                continue;
            };
            for resource in at.iter().filter(|r| layout.resource(r).is_none()) {
                problems.push(Problem::UnknownTester {
                    transition: number,
                    resource: resource.clone(),
                });
            }
        }
        problems
    }
}
