//! Breadth-first search: shortest paths in any transition system.

use rustc_hash::FxHashSet;
use std::hash::Hash;

/// A state found by a search, with its predecessor and the label from there; `None` for the start.
pub type SearchNode<S, L> = (S, Option<(usize, L)>);

/// Returns the labels on the path from the start to the state at index `at`.
pub fn way<S, L: Copy>(found: &[SearchNode<S, L>], mut at: usize) -> Vec<L> {
    let mut way = Vec::new();
    while let Some((from, label)) = found[at].1 {
        way.push(label);
        at = from;
    }
    way.reverse();
    way
}

/// Returns the labels of a shortest path from `start` to a state that is `wanted`; the smallest one
/// if labels are given in ascending order.
pub fn shortest<S: Clone + Eq + Hash, L: Copy>(
    start: S,
    successors: impl Fn(&S) -> Vec<(L, S)>,
    wanted: impl Fn(&S) -> bool,
) -> Option<Vec<L>> {
    let mut order = vec![(start.clone(), None)];
    let mut seen = FxHashSet::from_iter([start]);
    let mut at = 0;
    while at < order.len() {
        let state = order[at].0.clone();
        if wanted(&state) {
            return Some(way(&order, at));
        }
        for (label, to) in successors(&state) {
            if seen.insert(to.clone()) {
                order.push((to, Some((at, label))));
            }
        }
        at += 1;
    }
    None
}
