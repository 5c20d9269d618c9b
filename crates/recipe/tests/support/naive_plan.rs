//! Oracle for several products in lockstep: the fixpoint of [`super::naive`], with the progress of
//! each product. Parts have the names of their products: `a@1` is the part `a` of product 1.

use super::naive::{self, Answer, Cell, acceptable, closing, vectors};
use linewright_recipe::model::{Demand, Layout, Recipe, Step};
use std::collections::HashMap;

/// Products with recipes and parts of their own.
pub struct Products {
    /// The layout; its parts have the names of their owners.
    pub layout: Layout,
    /// The recipe of each product.
    pub recipes: Vec<Recipe>,
    /// A recipe that has all parts.
    pub merged: Recipe,
}

/// Gives each product a recipe with parts of its own.
pub fn separate(layout: &Layout, demands: &[Demand]) -> Products {
    let mut originals: Vec<&Recipe> = Vec::new();
    for demand in demands {
        originals.extend(vec![&demand.recipe; demand.count]);
    }
    let own = |name: &str, product: usize| format!("{name}@{product}");
    let mut layout = layout.clone();
    let mut given: Vec<String> = Vec::new();
    for name in layout.resources.iter_mut().flat_map(|r| &mut r.holds) {
        let has = |p: &usize| originals[*p].parts.iter().any(|part| part.name == *name);
        let owners: Vec<usize> = (0..originals.len()).filter(has).collect();
        let without = owners.iter().find(|p| !given.contains(&own(name, **p)));
        if let Some(product) = without.or(owners.first()) {
            *name = own(name, *product);
            given.push(name.clone());
        }
    }
    let renamed = |(product, original): (usize, &&Recipe)| {
        let mut recipe = (*original).clone();
        let is_part = |name: &String| original.parts.iter().any(|p| p.name == *name);
        for part in &mut recipe.parts {
            part.name = own(&part.name, product);
        }
        let left: Vec<String> = (original.leftover.iter())
            .filter(|l| is_part(l))
            .map(|l| own(l, product))
            .collect();
        recipe.leftover.extend(left);
        for transition in &mut recipe.transitions {
            if let linewright_recipe::model::Guard::Test { inputs, .. } = &mut transition.guard {
                for input in inputs {
                    *input = own(input, product);
                }
            }
            for call in transition.steps.iter_mut().flat_map(|s| &mut s.operations) {
                let names = call.inputs.iter_mut().chain(&mut call.outputs);
                for name in names {
                    *name = own(name, product);
                }
            }
        }
        recipe
    };
    let recipes: Vec<Recipe> = originals.iter().enumerate().map(renamed).collect();
    let merged = Recipe {
        parts: recipes.iter().flat_map(|r| r.parts.clone()).collect(),
        ..Recipe::default()
    };
    Products {
        layout,
        recipes,
        merged,
    }
}

impl Products {
    /// Returns the progress of all products, and states and parts of all resources, at the start.
    pub fn start(&self) -> (Vec<Status>, Cell) {
        let resources = self.layout.resources.iter();
        let cell = resources.map(|r| {
            let mut holds = r.holds.clone();
            holds.sort();
            (r.initial.clone(), holds)
        });
        let begins = self.recipes.iter().map(|r| Status::At(r.start.clone()));
        (begins.collect(), cell.collect())
    }
}

/// Progress of a product.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Status {
    At(String),
    Task(usize, usize),
}

type Node = (Vec<Status>, Cell);

/// What follows a node.
enum Next {
    End,
    /// All of these have to be realizable.
    All(Vec<usize>),
    /// One of these: its node, the number of vectors, and whether a loop is closed.
    One(Vec<(usize, usize, bool)>),
}

/// Decides whether the products can be made, with how many vectors.
pub fn decide(layout: &Layout, demands: &[Demand], max_nodes: usize) -> Answer {
    let products = separate(layout, demands);
    let start: Node = products.start();
    for recipe in &products.recipes {
        if !acceptable(&products.layout, recipe, &recipe.start, &start.1) {
            return Answer::Unrealizable;
        }
    }
    let mut number: HashMap<Node, usize> = HashMap::from([(start.clone(), 0)]);
    let mut order = vec![start];
    let mut next: Vec<Next> = Vec::new();
    while let Some(node) = order.get(next.len()).cloned() {
        let mut know = |node: Node| {
            *number.entry(node.clone()).or_insert_with(|| {
                order.push(node);
                order.len() - 1
            })
        };
        next.push(follow(&products, &node, &mut know));
        if order.len() > max_nodes {
            return Answer::TooLarge;
        }
    }
    // Greatest fixpoint of what the loops lead to.
    let count = order.len();
    let mut good = vec![true; count];
    loop {
        let cost = costs(&next, &good);
        let still: Vec<bool> = (0..count)
            .map(|n| good[n] && cost[n] < usize::MAX)
            .collect();
        if still == good {
            return if cost[0] == usize::MAX {
                Answer::Unrealizable
            } else {
                Answer::Realizable(cost[0])
            };
        }
        good = still;
    }
}

/// Returns the costs if loops may lead to the good nodes, iterated downward from infinity.
fn costs(next: &[Next], good: &[bool]) -> Vec<usize> {
    let mut cost = vec![usize::MAX; next.len()];
    loop {
        let mut changed = false;
        for n in (0..next.len()).rev() {
            let new = match &next[n] {
                Next::End => 0,
                Next::All(all) => all.iter().map(|to| cost[*to]).max().unwrap_or(usize::MAX),
                Next::One(all) => {
                    let each = all.iter().map(|(to, vectors, closes)| match closes {
                        true if good[*to] => *vectors,
                        true => usize::MAX,
                        false => cost[*to].saturating_add(*vectors),
                    });
                    each.min().unwrap_or(usize::MAX)
                }
            };
            changed |= new != cost[n];
            cost[n] = new;
        }
        if !changed {
            return cost;
        }
    }
}

fn follow(products: &Products, node: &Node, know: &mut dyn FnMut(Node) -> usize) -> Next {
    let (status, cell) = node;
    let with = |product: usize, new: Status| {
        let mut status = status.clone();
        status[product] = new;
        status
    };
    let mut ended = 0;
    for (product, recipe) in products.recipes.iter().enumerate() {
        if let Status::At(state) = &status[product] {
            if recipe.ends.contains(state) {
                ended += 1;
                continue;
            }
            let leaving = recipe.transitions.iter().enumerate();
            let leaving = leaving.filter(|(_, t)| t.from == *state);
            let children =
                leaving.map(|(n, _)| know((with(product, Status::Task(n, 0)), cell.clone())));
            return Next::All(children.collect());
        }
    }
    if ended == products.recipes.len() {
        return Next::End;
    }
    let mut edges = Vec::new();
    let mut steps: Vec<(usize, Step)> = Vec::new();
    for (product, recipe) in products.recipes.iter().enumerate() {
        let Status::Task(n, done) = status[product] else {
            continue;
        };
        let transition = &recipe.transitions[n];
        match transition.steps.get(done) {
            Some(step) => steps.push((product, step.clone())),
            None if acceptable(&products.layout, recipe, &transition.to, cell) => {
                let to = with(product, Status::At(transition.to.clone()));
                edges.push((know((to, cell.clone())), 0, closing(recipe)[n]));
            }
            None => {}
        }
    }
    for chosen in 0..1_usize << steps.len() {
        let is_in = |at: &usize| chosen & (1 << at) != 0;
        let members: Vec<usize> = (0..steps.len()).filter(is_in).collect();
        let calls = members.iter().flat_map(|m| steps[*m].1.operations.clone());
        let step = Step::new(calls.collect());
        let wanted = (!members.is_empty()).then_some(&step);
        for (after, performs) in vectors(&products.layout, &products.merged, cell, wanted) {
            if performs == members.is_empty() {
                continue;
            }
            let mut status = status.clone();
            for member in &members {
                if let Status::Task(_, done) = &mut status[steps[*member].0] {
                    *done += 1;
                }
            }
            edges.push((know((status, after)), 1, false));
        }
    }
    Next::One(edges)
}

/// Decides with one product.
pub fn single(layout: &Layout, recipe: &Recipe, max_nodes: usize) -> Answer {
    naive::decide(layout, recipe, max_nodes)
}
