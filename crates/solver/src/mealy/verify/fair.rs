//! Searches for fair cycles: strongly connected components (Tarjan 1972, without recursion) that
//! meet every justice assumption.

use super::product::Edge;
use crate::game::{Limit, Limits};
use rustc_hash::FxHashMap;
use std::collections::VecDeque;

/// Returns a cycle of edges whose labels are `bad`, as edges with their source nodes. For every
/// assumption, given by index, the cycle has an edge whose label is `fair`. Returns `None` if there
/// is no such cycle.
pub fn fair_cycle(
    edges: &[Vec<Edge>],
    assumptions: usize,
    bad: &impl Fn(u32) -> bool,
    fair: &impl Fn(u32, usize) -> bool,
    limits: &Limits,
) -> Result<Option<Vec<(usize, Edge)>>, Limit> {
    let part = components(edges, bad, limits)?;
    let inner = |from: usize, edge: &Edge| bad(edge.label) && part[from] == part[edge.to];
    // The assumptions met in each component that has an edge.
    let mut seen: FxHashMap<usize, Vec<bool>> = FxHashMap::default();
    for (from, out) in edges.iter().enumerate() {
        for edge in out.iter().filter(|e| inner(from, e)) {
            let seen = seen
                .entry(part[from])
                .or_insert_with(|| vec![false; assumptions]);
            for (i, seen) in seen.iter_mut().enumerate() {
                *seen |= fair(edge.label, i);
            }
        }
    }
    let complete = |from: usize| seen.get(&part[from]).is_some_and(|s| s.iter().all(|b| *b));
    let Some(entry) = (0..edges.len()).find(|n| complete(*n)) else {
        return Ok(None);
    };

    // Walks to an edge that meets each assumption in turn, and back to the entry.
    let mut cycle = Vec::new();
    let mut at = entry;
    for i in 0..assumptions {
        limits.check_time()?;
        let path = path(edges, at, &inner, &|_, edge| fair(edge.label, i));
        at = path.last().map_or(at, |(_, edge)| edge.to);
        cycle.extend(path);
    }
    if at != entry || cycle.is_empty() {
        cycle.extend(path(edges, at, &inner, &|_, edge| edge.to == entry));
    }
    Ok(Some(cycle))
}

/// Returns a shortest path of `inner` edges that ends with a `wanted` edge; empty if none exists.
#[expect(
    clippy::map_entry,
    reason = "the mutation tests change the condition and the insertion separately"
)]
fn path(
    edges: &[Vec<Edge>],
    from: usize,
    inner: &impl Fn(usize, &Edge) -> bool,
    wanted: &impl Fn(usize, &Edge) -> bool,
) -> Vec<(usize, Edge)> {
    let mut before: FxHashMap<usize, (usize, Edge)> = FxHashMap::default();
    let mut queue = VecDeque::from([from]);
    while let Some(node) = queue.pop_front() {
        for edge in edges[node].iter().filter(|e| inner(node, e)) {
            if wanted(node, edge) {
                let mut path = vec![(node, *edge)];
                let mut at = node;
                while at != from {
                    let (previous, edge) = before[&at];
                    path.push((previous, edge));
                    at = previous;
                }
                path.reverse();
                return path;
            }
            if !before.contains_key(&edge.to) {
                before.insert(edge.to, (node, *edge));
                queue.push_back(edge.to);
            }
        }
    }
    Vec::new()
}

/// Returns the strongly connected component of each node, using only `bad` edges.
fn components(
    edges: &[Vec<Edge>],
    bad: &impl Fn(u32) -> bool,
    limits: &Limits,
) -> Result<Vec<usize>, Limit> {
    const NEW: usize = usize::MAX;
    let count = edges.len();
    let mut part = vec![NEW; count];
    let mut index = vec![NEW; count];
    let mut low = vec![0; count];
    let mut open = Vec::new();
    let mut next = 0;
    for root in 0..count {
        if index[root] != NEW {
            continue;
        }
        limits.check_time()?;
        let mut calls = vec![(root, 0)];
        while let Some((node, position)) = calls.last_mut() {
            let node = *node;
            if *position == 0 {
                index[node] = next;
                low[node] = next;
                next += 1;
                open.push(node);
            }
            if let Some(edge) = edges[node].get(*position) {
                *position += 1;
                if !bad(edge.label) {
                    // Skips the edge. `position` is now above 0, so the node is not opened again.
                } else if index[edge.to] == NEW {
                    calls.push((edge.to, 0));
                } else if part[edge.to] == NEW {
                    low[node] = low[node].min(index[edge.to]);
                }
                continue;
            }
            calls.pop();
            if let Some((parent, _)) = calls.last() {
                low[*parent] = low[*parent].min(low[node]);
            }
            if low[node] == index[node] {
                while let Some(member) = open.pop() {
                    part[member] = node;
                    if member == node {
                        break;
                    }
                }
            }
        }
    }
    Ok(part)
}
