//! Queues of waiting parts per node, and the list of nodes to examine again.

use std::collections::VecDeque;

/// An outlet that waits for a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Request {
    /// The outlet.
    pub outlet: usize,
    /// Type of the part at the outlet.
    pub kind: usize,
    /// Sequence number, assigned when the outlet began to wait or lost its turn.
    pub order: u64,
    /// Whether the outlet is that of a belt that had its turn and did not hand over its part; reset
    /// when the node is examined.
    pub declined: bool,
}

/// The requests to each node, oldest first, and their sequence numbers.
#[derive(Debug)]
pub(super) struct Queues {
    waiting: Vec<VecDeque<Request>>,
    /// Last sequence number given to a request or a complete bill.
    last: u64,
}

impl Queues {
    /// Creates empty queues for this many nodes.
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            waiting: vec![VecDeque::new(); nodes],
            last: 0,
        }
    }

    /// Next sequence number for requests and complete bills.
    pub(super) fn next_number(&mut self) -> u64 {
        self.last += 1;
        self.last
    }

    /// The requests to a node, oldest first.
    pub(super) fn of(&self, node: usize) -> &VecDeque<Request> {
        &self.waiting[node]
    }

    /// The requests to a node, oldest first.
    pub(super) fn of_mut(&mut self, node: usize) -> &mut VecDeque<Request> {
        &mut self.waiting[node]
    }

    /// Adds a request: an outlet, whose part has this type, waits for a node. With `since`, it
    /// takes the turn of an earlier request with this sequence number.
    pub(super) fn push(&mut self, node: usize, outlet: usize, kind: usize, since: Option<u64>) {
        let order = since.unwrap_or_else(|| self.next_number());
        let queue = &mut self.waiting[node];
        let at = match since {
            None => queue.len(),
            Some(order) => queue.partition_point(|request| request.order < order),
        };
        queue.insert(
            at,
            Request {
                outlet,
                kind,
                order,
                declined: false,
            },
        );
    }

    /// Removes the request of an outlet. Returns its sequence number, if there was one.
    pub(super) fn withdraw(&mut self, node: usize, outlet: usize) -> Option<u64> {
        let queue = &mut self.waiting[node];
        let at = queue.iter().position(|request| request.outlet == outlet)?;
        queue.remove(at).map(|request| request.order)
    }

    /// Moves an outlet that had its turn to the end of a node's queue. Returns whether the outlet
    /// was in the queue.
    pub(super) fn decline(&mut self, node: usize, outlet: usize) -> bool {
        let queue = &mut self.waiting[node];
        let Some(at) = queue.iter().position(|request| request.outlet == outlet) else {
            return false;
        };
        let Some(request) = queue.remove(at) else {
            return false;
        };
        self.last += 1;
        queue.push_back(Request {
            order: self.last,
            declined: true,
            ..request
        });
        true
    }
}

/// Nodes to examine again, first in, first out, each at most once.
#[derive(Debug)]
pub(super) struct Agenda {
    nodes: VecDeque<u32>,
    listed: Vec<bool>,
}

impl Agenda {
    /// Creates an empty list for this many nodes.
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            nodes: VecDeque::new(),
            listed: vec![false; nodes],
        }
    }

    /// Adds a node, unless it is listed already.
    pub(super) fn push(&mut self, node: usize) {
        if !std::mem::replace(&mut self.listed[node], true) {
            self.nodes.push_back(node as u32);
        }
    }

    /// Removes and returns the next node.
    pub(super) fn pop(&mut self) -> Option<usize> {
        let node = self.nodes.pop_front()? as usize;
        self.listed[node] = false;
        Some(node)
    }
}
