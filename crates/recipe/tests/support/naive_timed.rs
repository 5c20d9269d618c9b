//! Oracle for timed plans: a simulation of the cell in steps of one second, with everything that
//! the resources can begin in each of them, and the least worst-case cost over all that can happen.
//! Durations are whole seconds. Recipes have no loops.

use super::naive::{Cell, consume};
use super::naive_plan::{Products, Status, separate};
use linewright_recipe::model::{Action, Demand, Guard, Layout, Recipe, Transition};
use linewright_recipe::plan::Objective;
use std::collections::HashMap;

/// Answer of the oracle.
#[derive(Debug, PartialEq, Eq)]
pub enum Timed {
    /// Least time in seconds, energy in joules, or number of transfers in the worst case.
    Realizable(usize),
    Unrealizable,
    TooLarge,
}

/// A cell at an instant.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Instant {
    status: Vec<Status>,
    /// Seconds until the last step of each product ends.
    ready: Vec<u8>,
    cell: Cell,
    /// Seconds until each resource is free.
    busy: Vec<u8>,
    /// The transition and the part with which each resource is on its way to another one.
    gives: Vec<Option<(usize, String)>>,
}

enum Next {
    End,
    All(Vec<usize>),
    /// Nodes and what it costs to get there.
    One(Vec<(usize, usize)>),
}

fn seconds(transition: &Transition) -> u8 {
    transition.seconds.unwrap_or(0.0) as u8
}

/// Returns the least worst-case time, energy or number of transfers of the products.
pub fn least(layout: &Layout, demands: &[Demand], objective: Objective, max_nodes: usize) -> Timed {
    let products = separate(layout, demands);
    let resources = products.layout.resources.len();
    let (status, cell) = products.start();
    let start = Instant {
        status,
        ready: vec![0; products.recipes.len()],
        cell,
        busy: vec![0; resources],
        gives: vec![None; resources],
    };
    let mut number: HashMap<Instant, usize> = HashMap::from([(start.clone(), 0)]);
    let mut order = vec![start];
    let mut next: Vec<Next> = Vec::new();
    while let Some(node) = order.get(next.len()).cloned() {
        let mut know = |node: Instant| {
            *number.entry(node.clone()).or_insert_with(|| {
                order.push(node);
                order.len() - 1
            })
        };
        let follows = Naive {
            products: &products,
            objective,
            at: &node,
        };
        next.push(follows.next(&mut know));
        if order.len() > max_nodes {
            return Timed::TooLarge;
        }
    }
    let mut cost = vec![usize::MAX; next.len()];
    loop {
        let mut changed = false;
        for n in (0..next.len()).rev() {
            let new = match &next[n] {
                Next::End => 0,
                Next::All(all) => all.iter().map(|to| cost[*to]).max().unwrap_or(usize::MAX),
                Next::One(all) => {
                    let each = all.iter().map(|(to, time)| cost[*to].saturating_add(*time));
                    each.min().unwrap_or(usize::MAX)
                }
            };
            changed |= new != cost[n];
            cost[n] = new;
        }
        if !changed {
            return match cost[0] {
                usize::MAX => Timed::Unrealizable,
                time => Timed::Realizable(time),
            };
        }
    }
}

fn leaving(recipe: &Recipe, state: &str) -> Vec<usize> {
    let all = recipe.transitions.iter().enumerate();
    all.filter(|(_, t)| t.from == state)
        .map(|(n, _)| n)
        .collect()
}

struct Naive<'a> {
    products: &'a Products,
    objective: Objective,
    at: &'a Instant,
}

impl Naive<'_> {
    fn next(&self, know: &mut dyn FnMut(Instant) -> usize) -> Next {
        let at = self.at;
        if let Some((product, state)) = self.asked() {
            let recipe = &self.products.recipes[product];
            let children = leaving(recipe, &state);
            let children = children
                .iter()
                .map(|n| know(self.with(product, Status::Task(*n, 0))));
            return Next::All(children.collect());
        }
        let is_end = |(p, s): (usize, &Status)| match s {
            Status::At(state) => self.products.recipes[p].ends.contains(state),
            Status::Task(..) => false,
        };
        let all_end = at.status.iter().enumerate().all(is_end);
        let rest = at.busy.iter().chain(&at.ready).all(|b| *b == 0);
        if all_end && rest && at.gives.iter().all(Option::is_none) {
            return Next::End;
        }
        // Who is on the way and has arrived hands over before anything else.
        let arrived = |r: &usize| at.gives[*r].is_some() && at.busy[*r] == 0;
        if let Some(giver) = (0..at.busy.len()).find(arrived) {
            return Next::One(self.hand_over(giver, know));
        }
        // What a state of the recipe leads to without a choice.
        for (product, recipe) in self.products.recipes.iter().enumerate() {
            if at.ready[product] > 0 {
                continue;
            }
            match &at.status[product] {
                Status::Task(n, done) if *done == recipe.transitions[*n].steps.len() => {
                    let to = &recipe.transitions[*n].to;
                    if recipe.ends.contains(to) && self.remains(recipe) {
                        return Next::One(Vec::new());
                    }
                    let after = self.with(product, Status::At(to.clone()));
                    return Next::One(vec![(know(after), 0)]);
                }
                Status::At(state) => {
                    if let [only] = leaving(recipe, state)[..] {
                        let after = self.with(product, Status::Task(only, 0));
                        return Next::One(vec![(know(after), 0)]);
                    }
                }
                Status::Task(..) => {}
            }
        }
        let mut edges = Vec::new();
        self.begin_transitions(know, &mut edges);
        self.begin_steps(know, &mut edges);
        // A test: a node of its own, since only whether it takes place now is a choice.
        for (product, recipe) in self.products.recipes.iter().enumerate() {
            let Status::At(state) = &at.status[product] else {
                continue;
            };
            if at.ready[product] > 0 || recipe.ends.contains(state) || !self.testable(recipe, state)
            {
                continue;
            }
            let mut asked = at.clone();
            asked.status[product] = Status::At(format!("?{state}"));
            edges.push((know(asked), 0));
        }
        if self.may_pass() {
            let mut later = at.clone();
            for left in later.busy.iter_mut().chain(&mut later.ready) {
                *left = left.saturating_sub(1);
            }
            if later != *at {
                edges.push((know(later), usize::from(self.objective == Objective::Time)));
            }
        }
        Next::One(edges)
    }

    /// Returns the joules of a transition, if they count.
    fn energy(&self, transition: &Transition) -> usize {
        if self.objective == Objective::Energy {
            usize::from(seconds(transition)) * transition.watts.unwrap_or(0.0) as usize
        } else {
            0
        }
    }

    /// Returns the product that is being tested, and its state.
    fn asked(&self) -> Option<(usize, String)> {
        let each = self.at.status.iter().enumerate();
        each.into_iter().find_map(|(p, s)| match s {
            Status::At(state) => Some((p, state.strip_prefix('?')?.to_owned())),
            Status::Task(..) => None,
        })
    }

    fn with(&self, product: usize, status: Status) -> Instant {
        let mut after = self.at.clone();
        after.status[product] = status;
        after
    }

    fn remains(&self, recipe: &Recipe) -> bool {
        let forbidden = |part: &String| {
            let own = recipe.parts.iter().find(|p| p.name == *part);
            own.is_some_and(|p| {
                !recipe.leftover.contains(&p.name) && !recipe.leftover.contains(&p.kind)
            })
        };
        self.at
            .cell
            .iter()
            .any(|(_, parts)| parts.iter().any(forbidden))
    }

    /// Returns whether a second may pass: nobody waits where this is not possible.
    fn may_pass(&self) -> bool {
        let waits = |r: usize| self.at.busy[r] == 0;
        let may = |r: usize| {
            let state = &self.at.cell[r].0;
            self.products.layout.resources[r]
                .states
                .iter()
                .any(|s| s.name == *state && s.may_wait)
        };
        (0..self.at.busy.len()).all(|r| !waits(r) || may(r))
    }

    fn testable(&self, recipe: &Recipe, state: &str) -> bool {
        let at = self.at;
        leaving(recipe, state)
            .iter()
            .all(|n| match &recipe.transitions[*n].guard {
                Guard::Test {
                    inputs,
                    at: testers,
                    ..
                } if !testers.is_empty() => (0..at.busy.len()).any(|r| {
                    testers.contains(&self.products.layout.resources[r].name)
                        && at.busy[r] == 0
                        && at.gives[r].is_none()
                        && consume(recipe, &at.cell, &at.cell[r].1, inputs).is_some()
                }),
                _ => true,
            })
    }

    fn is_free(&self, r: usize) -> bool {
        self.at.busy[r] == 0 && self.at.gives[r].is_none()
    }

    fn hand_over(
        &self,
        giver: usize,
        know: &mut dyn FnMut(Instant) -> usize,
    ) -> Vec<(usize, usize)> {
        let at = self.at;
        let layout = &self.products.layout;
        let (transition, part) = at.gives[giver].as_ref().expect("it gives");
        let given = &layout.resources[giver].transitions[*transition];
        let mut edges = Vec::new();
        for (taker, resource) in layout.resources.iter().enumerate() {
            if taker == giver || !self.is_free(taker) || at.cell[taker].1.len() >= resource.capacity
            {
                continue;
            }
            for taken in &resource.transitions {
                let fits = matches!((&taken.action, &given.action),
                    (Action::In(a), Action::Out(b)) if a == b);
                if taken.from != at.cell[taker].0 || !fits {
                    continue;
                }
                let mut after = at.clone();
                let place = after.cell[giver].1.iter().position(|p| p == part);
                let part = after.cell[giver].1.remove(place.expect("it is held"));
                after.cell[giver].0.clone_from(&given.to);
                after.gives[giver] = None;
                after.cell[taker].0.clone_from(&taken.to);
                after.cell[taker].1.push(part);
                after.cell[taker].1.sort();
                after.busy[taker] = seconds(taken);
                let transfer = usize::from(self.objective == Objective::Transfers);
                let cost = transfer + self.energy(given) + self.energy(taken);
                edges.push((know(after), cost));
            }
        }
        edges
    }

    fn begin_transitions(
        &self,
        know: &mut dyn FnMut(Instant) -> usize,
        edges: &mut Vec<(usize, usize)>,
    ) {
        let at = self.at;
        for (r, resource) in self.products.layout.resources.iter().enumerate() {
            if !self.is_free(r) {
                continue;
            }
            for (number, transition) in resource.transitions.iter().enumerate() {
                if transition.from != at.cell[r].0 {
                    continue;
                }
                match &transition.action {
                    Action::Internal(_) => {
                        let mut after = at.clone();
                        after.cell[r].0.clone_from(&transition.to);
                        after.busy[r] = seconds(transition);
                        edges.push((know(after), self.energy(transition)));
                    }
                    Action::Out(_) => {
                        let mut parts = at.cell[r].1.clone();
                        parts.dedup();
                        for part in parts {
                            let mut after = at.clone();
                            after.gives[r] = Some((number, part));
                            after.busy[r] = seconds(transition);
                            edges.push((know(after), 0));
                        }
                    }
                    Action::In(_) | Action::Operation(_) => {}
                }
            }
        }
    }

    fn begin_steps(&self, know: &mut dyn FnMut(Instant) -> usize, edges: &mut Vec<(usize, usize)>) {
        let at = self.at;
        for (product, recipe) in self.products.recipes.iter().enumerate() {
            let Status::Task(n, done) = at.status[product] else {
                continue;
            };
            let Some(step) = recipe.transitions[n].steps.get(done) else {
                continue;
            };
            if at.ready[product] > 0 {
                continue;
            }
            // Assign a transition to each operation, one after the other.
            let mut open: Vec<(Instant, Vec<usize>, usize)> = vec![(at.clone(), Vec::new(), 0)];
            for call in &step.operations {
                let mut longer = Vec::new();
                for (so_far, used, cost) in &open {
                    for (r, resource) in self.products.layout.resources.iter().enumerate() {
                        if used.contains(&r) || !self.is_free(r) {
                            continue;
                        }
                        for transition in &resource.transitions {
                            let fits = transition.action == Action::Operation(call.name.clone());
                            if !fits || transition.from != at.cell[r].0 {
                                continue;
                            }
                            let rest = consume(recipe, &at.cell, &at.cell[r].1, &call.inputs);
                            let Some(mut rest) = rest else { continue };
                            rest.extend(call.outputs.iter().cloned());
                            rest.sort();
                            if rest.len() > resource.capacity {
                                continue;
                            }
                            let mut after = so_far.clone();
                            after.cell[r] = (transition.to.clone(), rest);
                            after.busy[r] = seconds(transition);
                            after.ready[product] = after.ready[product].max(seconds(transition));
                            let mut used = used.clone();
                            used.push(r);
                            longer.push((after, used, cost + self.energy(transition)));
                        }
                    }
                }
                open = longer;
            }
            for (mut after, _, cost) in open {
                after.status[product] = Status::Task(n, done + 1);
                edges.push((know(after), cost));
            }
        }
    }
}
