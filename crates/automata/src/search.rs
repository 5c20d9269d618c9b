//! Breadth-first search for shortest paths in a transition system.

use rustc_hash::FxHashSet;
use std::hash::Hash;

/// A state found by a search, with the index of its predecessor and the label of the transition
/// from there; `None` for the start.
pub type SearchNode<S, L> = (S, Option<(usize, L)>);

/// Returns the labels on the path from the start to the state at index `at`.
pub fn path_labels<S, L: Copy>(found: &[SearchNode<S, L>], mut at: usize) -> Vec<L> {
    let mut labels = Vec::new();
    while let Some((from, label)) = found[at].1 {
        labels.push(label);
        at = from;
    }
    labels.reverse();
    labels
}

/// Returns the labels of a shortest path from `start` to a state for which `is_target` is true. If
/// `successors` returns labels in ascending order, it is the lexicographically smallest such path.
/// Returns `None` if no target is reachable.
pub fn shortest<S: Clone + Eq + Hash, L: Copy>(
    start: S,
    successors: impl Fn(&S) -> Vec<(L, S)>,
    is_target: impl Fn(&S) -> bool,
) -> Option<Vec<L>> {
    let mut order = vec![(start.clone(), None)];
    let mut seen = FxHashSet::from_iter([start]);
    let mut at = 0;
    while at < order.len() {
        let state = order[at].0.clone();
        if is_target(&state) {
            return Some(path_labels(&order, at));
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
