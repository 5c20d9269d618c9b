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
    /// Whether the outlet is that of a belt, which hands over its part only when it is stepped.
    pub is_belt: bool,
    /// Whether it is that of a belt that had its turn and did not hand over its part; reset when
    /// the node is examined.
    pub declined: bool,
}

/// The requests to a node, oldest first. Most nodes never have more than one.
#[derive(Debug, Default)]
pub(super) struct Requests {
    first: Option<Request>,
    /// Those after the first one; empty if there is none. Apart, because this is large and rarely
    /// needed.
    #[expect(
        clippy::box_collection,
        reason = "a node has to fit into one line of the cache"
    )]
    others: Option<Box<VecDeque<Request>>>,
}

impl Requests {
    /// Whether there are none.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.first.is_none()
    }

    /// All requests, oldest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Request> {
        let others = self.others.iter().flat_map(|others| others.iter());
        self.first.iter().chain(others)
    }

    /// The request at this position.
    pub(super) fn get(&self, position: usize) -> Option<&Request> {
        match position {
            0 => self.first.as_ref(),
            _ => self.others.as_ref()?.get(position - 1),
        }
    }

    /// The only request; `None` if there are none or several.
    #[inline]
    pub(super) fn only(&self) -> Option<&Request> {
        let others = self.others.as_ref();
        let only = others.is_none_or(|others| others.is_empty());
        self.first.as_ref().filter(|_| only)
    }

    /// Removes the only request.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.first = None;
    }

    /// The request at this position.
    pub(super) fn get_mut(&mut self, position: usize) -> Option<&mut Request> {
        match position {
            0 => self.first.as_mut(),
            _ => self.others.as_mut()?.get_mut(position - 1),
        }
    }

    /// Removes and returns the request at this position.
    pub(super) fn remove(&mut self, position: usize) -> Option<Request> {
        let others = self.others.as_mut();
        match position {
            0 => {
                let next = others.and_then(|others| others.pop_front());
                std::mem::replace(&mut self.first, next)
            }
            _ => others?.remove(position - 1),
        }
    }

    /// Adds a request where its sequence number belongs: at the end, unless it takes the turn of an
    /// earlier one.
    #[inline]
    pub(super) fn insert(&mut self, request: Request) {
        if self.first.is_none() {
            self.insert_only(request);
        } else {
            self.insert_among_others(request);
        }
    }

    /// Adds a request if there is none.
    #[inline]
    pub(super) fn insert_only(&mut self, request: Request) {
        self.first = Some(request);
    }

    #[cold]
    #[inline(never)]
    fn insert_among_others(&mut self, mut request: Request) {
        if let Some(first) = &mut self.first
            && request.order < first.order
        {
            std::mem::swap(first, &mut request);
        }
        let others = self.others.get_or_insert_default();
        let at = others.partition_point(|other| other.order < request.order);
        others.insert(at, request);
    }

    /// Removes the request of an outlet. Returns it, if there was one.
    pub(super) fn withdraw(&mut self, outlet: usize) -> Option<Request> {
        let at = self
            .iter()
            .position(|request| request.outlet as usize == outlet)?;
        self.remove(at)
    }
}

/// Nodes to examine again, first in, first out, each at most once.
#[derive(Debug, Default)]
pub(super) struct Agenda {
    nodes: Vec<u32>,
    /// Number of entries that were removed; their places are used again when the list is full.
    removed: usize,
}

impl Agenda {
    /// Adds a node, unless it is listed already, as `is_listed` states from now on. Whoever
    /// examines the node resets this.
    #[inline]
    pub(super) fn push(&mut self, node: usize, is_listed: &mut bool) {
        if !std::mem::replace(is_listed, true) {
            if self.nodes.len() == self.nodes.capacity() {
                self.make_room();
            }
            self.nodes.push(node as u32);
        }
    }

    /// Forgets the entries that were removed, and makes room for at least as many.
    #[cold]
    fn make_room(&mut self) {
        self.nodes.drain(..std::mem::take(&mut self.removed));
        self.nodes.reserve(self.nodes.len().max(64));
    }

    /// Removes and returns the next node.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<usize> {
        let node = *self.nodes.get(self.removed)?;
        self.removed += 1;
        Some(node as usize)
    }
}
