//! Oracle: realizability by a greatest fixpoint over everything that can happen, written from the
//! definitions, without regard for speed.
//!
//! It tries every combination of transitions of all resources, every assignment of the operations
//! of a step, and every part of every transfer; vectors may follow the last step; and sets are
//! iterated until they no longer change.

use linewright_recipe::model::{Action, Guard, Layout, Recipe, Resource, Step, Transition};
use std::collections::{BTreeSet, HashMap};

/// State name and sorted parts of each resource.
pub type Cell = Vec<(String, Vec<String>)>;

/// What happens in the cell while a recipe is made.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Node {
    Place(String, Cell),
    Task(usize, usize, Cell),
}

/// Answer of the oracle.
#[derive(Debug, PartialEq, Eq)]
pub enum Answer {
    /// Number of vectors in the worst case.
    Realizable(usize),
    Unrealizable,
    /// There are more nodes than the oracle wants to look at.
    TooLarge,
}

/// Decides whether a recipe can be made.
pub fn decide(layout: &Layout, recipe: &Recipe, max_nodes: usize) -> Answer {
    let start: Cell = (layout.resources.iter())
        .map(|r| (r.initial.clone(), sorted(r.holds.clone())))
        .collect();
    let start = Node::Place(recipe.start.clone(), start);
    let mut number: HashMap<Node, usize> = HashMap::from([(start.clone(), 0)]);
    let mut order = vec![start];
    let mut next: Vec<Vec<(usize, usize)>> = Vec::new();
    while let Some(node) = order.get(next.len()).cloned() {
        let mut targets = Vec::new();
        for (to, cost) in edges(layout, recipe, &node) {
            let known = number.get(&to).copied().unwrap_or_else(|| {
                number.insert(to.clone(), order.len());
                order.push(to);
                order.len() - 1
            });
            targets.push((known, cost));
        }
        next.push(targets);
        if order.len() > max_nodes {
            return Answer::TooLarge;
        }
    }
    let start = 0;

    // Greatest fixpoint of the places that are all right.
    let is_task = |n: usize| matches!(order[n], Node::Task(..));
    let mut good: Vec<bool> = (order.iter())
        .map(|node| match node {
            Node::Place(state, cell) => acceptable(layout, recipe, state, cell),
            Node::Task(..) => false,
        })
        .collect();
    loop {
        // Tasks that reach a good place in finitely many vectors.
        let mut reach = vec![false; order.len()];
        loop {
            let mut changed = false;
            for n in (0..order.len()).filter(|n| is_task(*n)) {
                if !reach[n] && next[n].iter().any(|(to, _)| good[*to] || reach[*to]) {
                    reach[n] = true;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        let still = |n: usize| good[n] && next[n].iter().all(|(to, _)| reach[*to]);
        let rest: Vec<bool> = (0..order.len()).map(still).collect();
        if rest == good {
            break;
        }
        good = rest;
    }
    if !good[start] {
        return Answer::Unrealizable;
    }
    // Costs, iterated downward from infinity.
    let closes = closing(recipe);
    let mut cost = vec![usize::MAX; order.len()];
    loop {
        let mut changed = false;
        for n in 0..order.len() {
            let new = match &order[n] {
                Node::Place(..) if !good[n] => usize::MAX,
                Node::Place(..) => next[n].iter().map(|(to, _)| cost[*to]).max().unwrap_or(0),
                Node::Task(transition, ..) => (next[n].iter())
                    .map(|(to, vectors)| {
                        let rest = match &order[*to] {
                            Node::Place(..) if !good[*to] => usize::MAX,
                            Node::Place(..) if closes[*transition] => 0,
                            _ => cost[*to],
                        };
                        rest.saturating_add(*vectors)
                    })
                    .min()
                    .unwrap_or(usize::MAX),
            };
            changed |= new != cost[n];
            cost[n] = new;
        }
        if !changed {
            return Answer::Realizable(cost[start]);
        }
    }
}

/// Returns the transitions that enter a state which is still open in a depth-first search.
pub fn closing(recipe: &Recipe) -> Vec<bool> {
    fn visit(recipe: &Recipe, state: &str, path: &mut Vec<String>, out: &mut Search) {
        if !out.seen.insert(state.to_owned()) {
            return;
        }
        path.push(state.to_owned());
        for (n, t) in recipe.transitions.iter().enumerate() {
            if t.from == state {
                out.closes[n] = path.contains(&t.to);
                visit(recipe, &t.to, path, out);
            }
        }
        path.pop();
    }
    struct Search {
        seen: BTreeSet<String>,
        closes: Vec<bool>,
    }
    let mut search = Search {
        seen: BTreeSet::new(),
        closes: vec![false; recipe.transitions.len()],
    };
    visit(recipe, &recipe.start, &mut Vec::new(), &mut search);
    search.closes
}

/// Returns whether the recipe may be in a state: tests can be performed, nothing remains.
pub fn acceptable(layout: &Layout, recipe: &Recipe, state: &str, cell: &Cell) -> bool {
    if recipe.ends.iter().any(|e| e == state) {
        let forbidden = |part: &String| {
            let own = recipe.parts.iter().find(|p| p.name == *part);
            own.is_some_and(|p| {
                !recipe.leftover.contains(&p.name) && !recipe.leftover.contains(&p.kind)
            })
        };
        return !cell.iter().any(|(_, parts)| parts.iter().any(forbidden));
    }
    let leaving = recipe.transitions.iter().filter(|t| t.from == state);
    leaving.into_iter().all(|t| match &t.guard {
        Guard::Test { inputs, at, .. } if !at.is_empty() => {
            let able = |n: usize| consume(recipe, cell, &cell[n].1, inputs).is_some();
            let named = |n: &usize| at.contains(&layout.resources[*n].name);
            (0..cell.len()).filter(named).any(able)
        }
        _ => true,
    })
}

/// Returns the parts without some inputs, if they are all there.
pub fn consume(
    recipe: &Recipe,
    cell: &Cell,
    parts: &[String],
    inputs: &[String],
) -> Option<Vec<String>> {
    let is_part = |name: &String| recipe.parts.iter().any(|p| p.name == *name);
    let mut rest = parts.to_vec();
    for input in inputs {
        let there = cell.iter().any(|(_, held)| held.contains(input));
        let kind = &recipe.parts.iter().find(|p| p.name == *input)?.kind;
        let wanted = if there || is_part(kind) { input } else { kind };
        let at = rest.iter().position(|p| p == wanted)?;
        rest.remove(at);
    }
    Some(rest)
}

fn sorted(mut parts: Vec<String>) -> Vec<String> {
    parts.sort();
    parts
}

/// Returns what can follow, each with its number of vectors.
fn edges(layout: &Layout, recipe: &Recipe, node: &Node) -> Vec<(Node, usize)> {
    match node {
        Node::Place(state, cell) => (recipe.transitions.iter().enumerate())
            .filter(|(_, t)| t.from == *state)
            .map(|(n, _)| (Node::Task(n, 0, cell.clone()), 0))
            .collect(),
        Node::Task(n, done, cell) => {
            let transition = &recipe.transitions[*n];
            let mut edges = Vec::new();
            if *done == transition.steps.len() {
                edges.push((Node::Place(transition.to.clone(), cell.clone()), 0));
            }
            let step = transition.steps.get(*done);
            for (after, performs) in vectors(layout, recipe, cell, step) {
                edges.push((Node::Task(*n, done + usize::from(performs), after), 1));
            }
            edges
        }
    }
}

/// Returns all combinations of one element of each list.
fn combinations<T: Clone>(lists: &[Vec<T>]) -> Vec<Vec<T>> {
    let mut all = vec![Vec::new()];
    for list in lists {
        all = (all.iter())
            .flat_map(|begin| {
                list.iter().map(move |last| {
                    let mut longer = begin.clone();
                    longer.push(last.clone());
                    longer
                })
            })
            .collect();
    }
    all
}

/// Returns the cell after each vector, and whether it performs the step.
pub fn vectors(
    layout: &Layout,
    recipe: &Recipe,
    cell: &Cell,
    step: Option<&Step>,
) -> Vec<(Cell, bool)> {
    fn options<'a>(resource: &'a Resource, state: &str) -> Vec<Option<&'a Transition>> {
        let own = resource.transitions.iter().filter(|t| t.from == state);
        let mut options: Vec<Option<&Transition>> = own.map(Some).collect();
        if resource
            .states
            .iter()
            .any(|s| s.name == state && s.may_wait)
        {
            options.push(None);
        }
        options
    }
    let lists: Vec<_> = (layout.resources.iter().zip(cell))
        .map(|(resource, (state, _))| options(resource, state))
        .collect();
    let mut found = Vec::new();
    for vector in combinations(&lists) {
        let select = |wanted: fn(&Action) -> bool| -> Vec<usize> {
            let is = |n: &usize| vector[*n].is_some_and(|t| wanted(&t.action));
            (0..vector.len()).filter(is).collect()
        };
        let givers = select(|a| matches!(a, Action::Out(_)));
        let takers = select(|a| matches!(a, Action::In(_)));
        let performers = select(|a| matches!(a, Action::Operation(_)));
        let label = |n: usize| vector[n].and_then(|t| t.action.label());
        let partners =
            |n: usize, of: &[usize]| of.iter().filter(|m| label(**m) == label(n)).count();
        if !givers.iter().all(|n| partners(*n, &takers) == 1)
            || !takers.iter().all(|n| partners(*n, &givers) == 1)
        {
            continue;
        }
        let calls = step.map_or(0, |s| s.operations.len());
        if !performers.is_empty() && performers.len() != calls {
            continue;
        }
        let assigned: Vec<Vec<usize>> = vec![(0..calls).collect(); performers.len()];
        let moved: Vec<Vec<String>> = givers.iter().map(|n| cell[*n].1.clone()).collect();
        for assignment in combinations(&assigned) {
            let distinct: BTreeSet<usize> = assignment.iter().copied().collect();
            if distinct.len() != assignment.len() {
                continue;
            }
            'parts: for parts in combinations(&moved) {
                let mut after = cell.clone();
                for (n, transition) in vector.iter().enumerate() {
                    if let Some(transition) = transition {
                        after[n].0.clone_from(&transition.to);
                    }
                }
                for (n, call) in performers.iter().zip(&assignment) {
                    let call = &step.expect("there are calls").operations[*call];
                    let named = vector[*n].map(|t| &t.action);
                    let Some(mut rest) = consume(recipe, cell, &cell[*n].1, &call.inputs) else {
                        continue 'parts;
                    };
                    if named != Some(&Action::Operation(call.name.clone())) {
                        continue 'parts;
                    }
                    rest.extend(call.outputs.iter().cloned());
                    after[*n].1 = rest;
                }
                for (n, part) in givers.iter().zip(&parts) {
                    let at = after[*n]
                        .1
                        .iter()
                        .position(|p| p == part)
                        .expect("it is held");
                    after[*n].1.remove(at);
                    let taker = takers.iter().find(|m| label(**m) == label(*n));
                    after[*taker.expect("it has a partner")]
                        .1
                        .push(part.clone());
                }
                let room = |(n, (_, held)): (usize, &(String, Vec<String>))| {
                    held.len() <= layout.resources[n].capacity
                };
                if after.iter().enumerate().all(room) {
                    let after = after.into_iter().map(|(s, p)| (s, sorted(p))).collect();
                    found.push((after, !performers.is_empty()));
                }
            }
        }
    }
    found.sort();
    found.dedup();
    found
}
