//! Buffers: room for parts that wait, first in, first out.

use super::part::PartIndex;
use crate::statistics::{Level, Waits};
use std::collections::VecDeque;

/// State of a buffer.
#[derive(Debug)]
pub(super) struct Buffer {
    capacity: usize,
    /// Parts with the times at which they came, the first to leave in front.
    parts: VecDeque<(PartIndex, f64)>,
    pub level: Level,
    pub waits: Waits,
}

impl Buffer {
    pub(super) fn new(capacity: u32) -> Self {
        Self {
            capacity: capacity as usize,
            parts: VecDeque::new(),
            level: Level::new(Some(u64::from(capacity))),
            waits: Waits::default(),
        }
    }

    /// Whether there is room for another part.
    pub(super) fn has_room(&self) -> bool {
        self.parts.len() < self.capacity
    }

    /// The part that leaves next.
    pub(super) fn first(&self) -> Option<PartIndex> {
        self.parts.front().map(|(part, _)| *part)
    }

    pub(super) fn parts(&self) -> impl Iterator<Item = PartIndex> {
        self.parts.iter().map(|(part, _)| *part)
    }

    /// A part comes. Returns whether it is the only one.
    pub(super) fn put(&mut self, part: PartIndex, now: f64) -> bool {
        self.parts.push_back((part, now));
        self.level.add(now, 1);
        self.parts.len() == 1
    }

    /// The first part leaves.
    pub(super) fn take(&mut self, now: f64) {
        if let Some((_, since)) = self.parts.pop_front() {
            self.level.add(now, -1);
            self.waits.add(now - since);
        }
    }

    /// Forgets what has been counted.
    pub(super) fn forget(&mut self, now: f64) {
        self.level.forget(now);
        self.waits = Waits::default();
    }
}
