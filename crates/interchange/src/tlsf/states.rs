//! States of an automaton over subformulas: what is still to be kept, and which of them cannot be told apart.

use std::collections::{BTreeMap, BTreeSet};

/// So many conjunctions make a state.
const MAX_TERMS: usize = 48;

/// A disjunction of conjunctions of obligations: none is false, an empty conjunction true.
pub(super) type State = BTreeSet<BTreeSet<u32>>;

pub(super) fn and(a: &State, b: &State) -> Option<State> {
    let mut all = State::new();
    for p in a {
        for q in b {
            all.insert(p.union(q).copied().collect());
        }
    }
    least(&all)
}

pub(super) fn or(mut a: State, b: State) -> Option<State> {
    a.extend(b);
    least(&a)
}

/// Without conjunctions that ask more than another one.
fn least(all: &State) -> Option<State> {
    let kept: State = all
        .iter()
        .filter(|p| !all.iter().any(|q| q != *p && q.is_subset(p)))
        .cloned()
        .collect();
    (kept.len() <= MAX_TERMS).then_some(kept)
}

/// States that cannot be told apart as one (Moore, Gedanken-experiments on sequential machines, 1956), those that always break as
/// broken. State 0 stays the first.
pub(super) fn joined(steps: &[BTreeMap<u32, Option<usize>>]) -> Vec<BTreeMap<u32, Option<usize>>> {
    let mut class: Vec<Option<usize>> = vec![Some(0); steps.len()];
    // A state all of whose steps break is broken itself, one step late: it stays a state, since breaking is seen at its step.
    loop {
        let mut names = BTreeMap::new();
        let next: Vec<Option<usize>> = (0..steps.len())
            .map(|s| {
                let row: Vec<Option<Option<usize>>> =
                    steps[s].values().map(|t| t.map(|t| class[t])).collect();
                let count = names.len();
                Some(*names.entry((class[s], row)).or_insert(count))
            })
            .collect();
        let stable = next == class;
        class = next;
        if stable {
            break;
        }
    }
    let count = class.iter().flatten().max().map_or(0, |m| m + 1);
    let mut result = vec![BTreeMap::new(); count];
    for (s, row) in steps.iter().enumerate() {
        if let Some(c) = class[s] {
            let row = row.iter().map(|(l, t)| (*l, t.and_then(|t| class[t])));
            result[c] = row.collect();
        }
    }
    result
}
