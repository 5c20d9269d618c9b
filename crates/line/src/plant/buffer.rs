//! Buffers: room for parts that wait.

use super::part::{Part, PartIndex};
use crate::calls::Real;
use crate::statistics::{Level, Waits};
use linewright_language::contract::line::BufferOrder;
use std::collections::{BTreeMap, VecDeque};

/// State of a buffer.
#[derive(Debug)]
pub(super) struct Buffer {
    capacity: usize,
    order: BufferOrder,
    contents: Contents,
    /// Number of parts that have come.
    came: i64,
    pub level: Level,
    pub waits: Waits,
}

/// Parts with the times at which they came.
#[derive(Debug)]
enum Contents {
    /// The first to leave in front.
    Queue(VecDeque<(PartIndex, f64)>),
    /// By rank, then by number: the lowest leaves first.
    Ranked(BTreeMap<(Real, i64), (PartIndex, f64)>),
}

impl Buffer {
    pub(super) fn new(capacity: u32, order: &BufferOrder) -> Self {
        Self {
            capacity: capacity as usize,
            order: order.clone(),
            contents: match order {
                BufferOrder::FirstIn => Contents::Queue(VecDeque::new()),
                _ => Contents::Ranked(BTreeMap::new()),
            },
            came: 0,
            level: Level::new(Some(u64::from(capacity))),
            waits: Waits::default(),
        }
    }

    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        match &self.contents {
            Contents::Queue(queue) => queue.len(),
            Contents::Ranked(ranked) => ranked.len(),
        }
    }

    /// Whether there is room for another part.
    pub(super) fn has_room(&self) -> bool {
        self.len() < self.capacity
    }

    /// The part that leaves next.
    pub(super) fn first(&self) -> Option<PartIndex> {
        match &self.contents {
            Contents::Queue(queue) => queue.front().map(|(part, _)| *part),
            Contents::Ranked(ranked) => ranked.first_key_value().map(|(_, (part, _))| *part),
        }
    }

    pub(super) fn parts(&self) -> Box<dyn Iterator<Item = PartIndex> + '_> {
        match &self.contents {
            Contents::Queue(queue) => Box::new(queue.iter().map(|(part, _)| *part)),
            Contents::Ranked(ranked) => Box::new(ranked.values().map(|(part, _)| *part)),
        }
    }

    /// A part comes. Returns whether it will be the next to leave.
    pub(super) fn put(&mut self, index: PartIndex, part: &Part, now: f64) -> bool {
        self.came += 1;
        self.level.add(now, 1);
        let key = match &self.order {
            BufferOrder::FirstIn => (0.0, self.came),
            BufferOrder::LastIn => (0.0, -self.came),
            BufferOrder::Property { highest, of } => {
                let value = of[part.kind].and_then(|property| part.properties.get(property));
                let value = value.copied().unwrap_or(0.0);
                (if *highest { -value } else { value }, self.came)
            }
        };
        match &mut self.contents {
            Contents::Queue(queue) => queue.push_back((index, now)),
            Contents::Ranked(ranked) => {
                // The sum makes -0 and 0 equal.
                ranked.insert((Real(key.0 + 0.0), key.1), (index, now));
            }
        }
        self.first() == Some(index)
    }

    /// The first part leaves.
    pub(super) fn take(&mut self, now: f64) {
        let taken = match &mut self.contents {
            Contents::Queue(queue) => queue.pop_front(),
            Contents::Ranked(ranked) => ranked.pop_first().map(|(_, taken)| taken),
        };
        if let Some((_, since)) = taken {
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
