//! The ways of a single part through a layout, if nothing hinders it.
//!
//! A node is a resource that holds the part, in one of its states. The resource moves as it likes;
//! what its partners do and where other parts are is ignored, so a part can get at most to the
//! nodes that are found.

use super::flow::Site;
use crate::model::{Action, Layout};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// The graph of the ways of a part.
pub(super) struct Ways {
    /// Number of the first node of each resource.
    first: Vec<usize>,
    /// Nodes to which each node leads.
    next: Vec<Vec<usize>>,
}

impl Ways {
    /// Builds the graph. Takes time proportional to the number of transfers with the same label,
    /// and of transitions.
    pub fn new(layout: &Layout) -> Self {
        let mut first = Vec::with_capacity(layout.resources.len());
        let mut nodes = 0;
        for resource in &layout.resources {
            first.push(nodes);
            nodes += resource.states.len();
        }
        // Who takes a part under a label, and the node where it is then.
        let mut takers: FxHashMap<&str, Vec<(usize, usize)>> = FxHashMap::default();
        for (at, resource) in layout.resources.iter().enumerate() {
            for transition in &resource.transitions {
                if let (Action::In(label), Some(to)) =
                    (&transition.action, resource.state(&transition.to))
                {
                    takers.entry(label).or_default().push((at, first[at] + to));
                }
            }
        }
        let mut next = vec![Vec::new(); nodes];
        for (at, resource) in layout.resources.iter().enumerate() {
            for transition in &resource.transitions {
                let (Some(from), Some(to)) = (
                    resource.state(&transition.from),
                    resource.state(&transition.to),
                ) else {
                    continue;
                };
                let next: &mut Vec<usize> = &mut next[first[at] + from];
                // A resource with room for one part gives this one, and takes no other.
                let stays = match &transition.action {
                    Action::Operation(_) | Action::Internal(_) => true,
                    Action::In(_) | Action::Out(_) => resource.capacity > 1,
                };
                next.extend(stays.then_some(first[at] + to));
                if let Action::Out(label) = &transition.action {
                    let others = takers.get(label.as_str()).into_iter().flatten();
                    next.extend(
                        others
                            .filter(|(other, _)| *other != at)
                            .map(|(_, node)| node),
                    );
                }
            }
        }
        Self { first, next }
    }

    /// Returns whether a part can get from one of these places to one of those.
    pub fn leads(&self, from: &BTreeSet<Site>, to: &[Site]) -> bool {
        let mut is_target = vec![false; self.next.len()];
        for (resource, state) in to {
            is_target[self.first[*resource] + state] = true;
        }
        let mut seen = vec![false; self.next.len()];
        let mut open: Vec<usize> = from.iter().map(|(r, s)| self.first[*r] + s).collect();
        while let Some(node) = open.pop() {
            if is_target[node] {
                return true;
            }
            if !std::mem::replace(&mut seen[node], true) {
                open.extend(&self.next[node]);
            }
        }
        false
    }
}
