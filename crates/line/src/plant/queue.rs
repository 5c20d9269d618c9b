//! Requests of waiting parts to a node, and the list of nodes to examine again.

use std::collections::VecDeque;

/// An outlet that waits for a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Request {
    /// Sequence number, assigned when the outlet began to wait or lost its turn.
    pub order: u64,
    /// The outlet.
    pub outlet: u32,
    /// Type of the part at the outlet.
    pub kind: u32,
    /// The node of the outlet.
    pub from: u32,
    /// Whether the outlet is that of a belt that had its turn and did not hand over its part; reset
    /// when the node is examined.
    pub declined: bool,
}

/// The requests to a node, oldest first.
#[derive(Debug, Default)]
pub(super) struct Requests(VecDeque<Request>);

impl Requests {
    /// Whether there are none.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All requests, oldest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Request> {
        self.0.iter()
    }

    /// The request at this position.
    #[inline]
    pub(super) fn get(&self, position: usize) -> Option<&Request> {
        self.0.get(position)
    }

    /// The request at this position.
    pub(super) fn get_mut(&mut self, position: usize) -> Option<&mut Request> {
        self.0.get_mut(position)
    }

    /// Removes and returns the request at this position.
    #[inline]
    pub(super) fn remove(&mut self, position: usize) -> Option<Request> {
        if position == 0 {
            self.0.pop_front()
        } else {
            self.0.remove(position)
        }
    }

    /// Adds the latest request.
    #[inline]
    pub(super) fn push(&mut self, request: Request) {
        self.0.push_back(request);
    }

    /// Adds a request that takes the turn of an earlier one.
    pub(super) fn insert(&mut self, request: Request) {
        let at = self.0.partition_point(|other| other.order < request.order);
        self.0.insert(at, request);
    }

    /// Removes the request of an outlet. Returns it, if there was one.
    pub(super) fn withdraw(&mut self, outlet: usize) -> Option<Request> {
        let mut requests = self.0.iter();
        let at = requests.position(|request| request.outlet as usize == outlet)?;
        self.remove(at)
    }
}

/// Nodes to examine again, first in, first out, each at most once.
#[derive(Debug)]
pub(super) struct Agenda {
    /// A ring with room for all nodes: its length is a power of two.
    nodes: Vec<u32>,
    /// Numbers of nodes that were removed, and that were added.
    removed: usize,
    added: usize,
    listed: Vec<bool>,
}

impl Agenda {
    /// Creates an empty list for this many nodes.
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            nodes: vec![0; nodes.next_power_of_two()],
            removed: 0,
            added: 0,
            listed: vec![false; nodes],
        }
    }

    /// Adds a node, unless it is listed already.
    #[inline]
    pub(super) fn push(&mut self, node: usize) {
        let listed = &mut self.listed[node];
        if !*listed {
            *listed = true;
            let at = self.added & (self.nodes.len() - 1);
            self.nodes[at] = node as u32;
            self.added = self.added.wrapping_add(1);
        }
    }

    /// Removes and returns the next node.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<usize> {
        if self.removed == self.added {
            return None;
        }
        let node = self.nodes[self.removed & (self.nodes.len() - 1)] as usize;
        self.removed = self.removed.wrapping_add(1);
        self.listed[node] = false;
        Some(node)
    }
}
