//! Where parts come from and where they go: sources, stores and sinks.

use super::{Event, Place, Run, WORK, stream};
use crate::log::EventKind;
use crate::plant::part::PartIndex;
use crate::random::Purpose;
use crate::sampler::Sampler;
use linewright_language::contract::line::{NodeKind, Supply};
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// State of a source. The part that it has made and that waits to leave is at its outlet.
#[derive(Debug)]
pub(super) struct Source {
    /// Number of parts made.
    made: u64,
    /// Number of parts still to make; `None` if unlimited.
    left_to_make: Option<u64>,
    timing: Timing,
    /// Number of replacements still to make; only with given instants, which they do not use up.
    replacements: u64,
    /// Whether the next part is due; if not, it is due at `next_due`.
    due: bool,
    next_due: f64,
    /// Time since which the part at the outlet waits.
    waits_since: f64,
    /// Seconds in which a part waited, until the last one left.
    blocked_seconds: f64,
    /// Number of parts that have left, and of those that went into a sink with `rejects`.
    passed: u64,
    lost: u64,
}

/// When the parts of a source are due.
#[derive(Debug)]
enum Timing {
    /// Whenever there is room.
    AtOnce,
    /// When a time that is drawn has passed since the previous part was made.
    Interval(Sampler),
    /// At these instants.
    At {
        /// Seconds, in ascending order.
        instants: Arc<[f64]>,
        /// Index of the next part that is due, or will be.
        next: usize,
    },
}

impl Source {
    /// Creates a source. `orders` is the number of parts to make if the source is on order; `None`
    /// if unlimited.
    pub(super) fn new(name: &str, supply: &Supply, seed: u64, orders: Option<u64>) -> Self {
        let (left_to_make, timing) = match supply {
            Supply::OnOrder => (orders, Timing::AtOnce),
            Supply::Every { interval, limit } if interval.is_zero() => (*limit, Timing::AtOnce),
            Supply::Every { interval, limit } => {
                let draws = Sampler::new(interval, stream(seed, Purpose::Arrivals, name));
                (*limit, Timing::Interval(draws))
            }
            Supply::At { instants } => {
                let instants = Arc::clone(instants);
                (
                    Some(instants.len() as u64),
                    Timing::At { instants, next: 0 },
                )
            }
        };
        let first = match &timing {
            Timing::At { instants, .. } => instants.first().copied().unwrap_or(0.0),
            Timing::AtOnce | Timing::Interval(_) => 0.0,
        };
        Self {
            made: 0,
            left_to_make,
            timing,
            replacements: 0,
            due: first <= 0.0,
            next_due: first,
            waits_since: 0.0,
            blocked_seconds: 0.0,
            passed: 0,
            lost: 0,
        }
    }

    /// The part at the outlet leaves, perhaps for a sink with `rejects`.
    pub(super) fn left(&mut self, now: f64, is_lost: bool) {
        self.blocked_seconds += now - self.waits_since;
        self.passed += 1;
        self.lost += u64::from(is_lost);
    }

    /// Forgets what has been counted.
    pub(super) fn forget(&mut self, now: f64) {
        self.waits_since = now;
        self.blocked_seconds = 0.0;
        self.passed = 0;
        self.lost = 0;
    }

    /// Closes the accounts of a run of this many seconds. `waits` states whether a part is at the
    /// outlet. Returns the number of parts that have left, the share of the time in which a part
    /// waited, and the share of the parts that were lost.
    pub(super) fn close(&self, now: f64, seconds: f64, waits: bool) -> (u64, f64, f64) {
        let waiting = if waits { now - self.waits_since } else { 0.0 };
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        (
            self.passed,
            share(self.blocked_seconds + waiting, seconds),
            share(self.lost as f64, self.passed as f64),
        )
    }

    /// Number of parts that have left, and of those that went into a sink with `rejects`.
    pub(super) fn passed_and_lost(&self) -> (u64, u64) {
        (self.passed, self.lost)
    }

    /// Sets the number of parts that are still to be made on order.
    pub(super) fn limit_orders(&mut self, count: u64) {
        self.left_to_make = Some(count);
    }

    /// Determines when the next part is due, after one that was not a replacement was made.
    fn plan(&mut self, now: f64) {
        match &mut self.timing {
            Timing::AtOnce => {}
            Timing::Interval(interval) => {
                self.due = false;
                self.next_due = now + interval.draw();
            }
            Timing::At { instants, next } => {
                *next += 1;
                let instant = instants.get(*next).copied();
                self.due = instant.is_some_and(|instant| instant <= now);
                self.next_due = instant.unwrap_or(now);
            }
        }
    }

    /// Whether a part will be due at `next_due`.
    fn is_planned(&self) -> bool {
        match &self.timing {
            Timing::AtOnce => false,
            Timing::Interval(_) => !self.exhausted(),
            Timing::At { instants, next } => *next < instants.len(),
        }
    }

    /// Whether the source will never make another part unless more are ordered.
    pub(super) fn exhausted(&self) -> bool {
        self.left_to_make == Some(0)
    }

    /// Number of parts made.
    pub(super) fn made(&self) -> u64 {
        self.made
    }
}

/// State of a store: what is left of its initial stock, and parts that came in and will leave
/// again.
#[derive(Debug)]
pub(super) struct Store {
    /// Its outlets, of those of all stores.
    pub outlets: Range<usize>,
    stock: Vec<u64>,
    parts: Vec<VecDeque<PartIndex>>,
    /// By type: whether the part at the outlet was taken from the stock.
    from_stock: Vec<bool>,
}

impl Store {
    pub(super) fn new(stock: &[(usize, u64)], types: usize, outlets: Range<usize>) -> Self {
        let mut counts = vec![0_u64; types];
        for &(part, count) in stock {
            counts[part] = counts[part].saturating_add(count);
        }
        Self {
            outlets,
            stock: counts,
            parts: vec![VecDeque::new(); types],
            from_stock: vec![false; types],
        }
    }

    /// Updates the store when the part of this type at its outlet has left.
    pub(super) fn left(&mut self, kind: usize) {
        if !std::mem::take(&mut self.from_stock[kind]) {
            self.parts[kind].pop_front();
        }
    }

    /// Number of parts of this type in stock, without the one at the outlet.
    pub(super) fn stock(&self, kind: usize) -> u64 {
        self.stock[kind]
    }

    /// The parts that came in and will leave again.
    pub(super) fn parts(&self) -> impl Iterator<Item = PartIndex> {
        self.parts.iter().flatten().copied()
    }
}

impl Run<'_> {
    /// Makes the next part of a source, if it is due and no limit is reached.
    pub(super) fn make(&mut self, node: usize) -> Option<PartIndex> {
        let NodeKind::Source { part, most, .. } = self.line.nodes[node].kind else {
            return None;
        };
        let Place::Source(source) = &mut self.nodes[node].place else {
            return None;
        };
        let full = most.is_some_and(|most| self.counters.in_line[part] >= u64::from(most));
        let is_replacement = source.replacements > 0;
        if !(source.due || is_replacement) || source.exhausted() || full {
            return None;
        }
        source.made += 1;
        source.waits_since = self.now;
        if let Some(left) = &mut source.left_to_make {
            *left -= 1;
        }
        if is_replacement {
            source.replacements -= 1;
        } else {
            source.plan(self.now);
            if !source.due {
                self.schedule_arrival(node);
            }
        }
        self.counters.in_line[part] += 1;
        let part = self.parts.create(self.line, part, |_| None);
        self.record(node, Some(part), EventKind::Made);
        Some(part)
    }

    /// Schedules the next part of a source, if it is not due yet. Called at the start, and when a
    /// part was made.
    pub(super) fn schedule_arrival(&mut self, node: usize) {
        if let Place::Source(source) = &self.nodes[node].place
            && !source.due
            && source.is_planned()
        {
            let time = source.next_due;
            self.schedule(time, WORK, Event::Due(node as u32));
        }
    }

    /// Counts a part of this type, with everything it was joined from, as in the line. Parts that
    /// still wait to enter the line count, too.
    fn count_in(&mut self, kind: usize) {
        for (part, count) in self.counters.in_line.iter_mut().enumerate() {
            *count += self.setup.contents[kind * self.line.parts.len() + part];
        }
    }

    /// Counts a part that has left the line. Sources that waited for this can continue.
    pub(super) fn count_out(&mut self, kind: usize) {
        for (part, count) in self.counters.in_line.iter_mut().enumerate() {
            let content = self.setup.contents[kind * self.line.parts.len() + part];
            *count = count.saturating_sub(content);
        }
        let setup = self.setup;
        for &node in &setup.limited_sources {
            self.look_at(node);
        }
    }

    /// Orders more parts from a source, in addition to its limit. A source with an interval keeps
    /// to the interval; one with given instants makes replacements as soon as it can. An unlimited
    /// source makes the parts anyway.
    pub(super) fn order(&mut self, node: usize, count: u64) {
        let now = self.now;
        let Place::Source(source) = &mut self.nodes[node].place else {
            return;
        };
        let has_instants = matches!(source.timing, Timing::At { .. });
        let stopped = source.exhausted() && !source.due && !has_instants;
        if has_instants {
            source.replacements = source.replacements.saturating_add(count);
        }
        if let Some(left) = &mut source.left_to_make {
            *left = left.saturating_add(count);
        }
        if stopped {
            let time = source.next_due.max(now);
            self.schedule(time, WORK, Event::Due(node as u32));
        }
        self.look_at(node);
    }

    /// Handles the event that a source's next part is due.
    pub(super) fn due(&mut self, node: usize) {
        if let Place::Source(source) = &mut self.nodes[node].place {
            source.due = true;
        }
        self.look_at(node);
    }

    /// Returns the next part that a store gives out: first from its stock, then in order of
    /// arrival.
    pub(super) fn give_out(&mut self, node: usize, outlet: usize) -> Option<PartIndex> {
        let (_, kind) = self.setup.store_outlets[outlet - self.nodes.len()];
        let Place::Store(store) = &mut self.nodes[node].place else {
            return None;
        };
        if store.stock[kind] > 0 {
            store.stock[kind] -= 1;
            store.from_stock[kind] = true;
            self.count_in(kind);
            return Some(self.parts.create(self.line, kind, |_| None));
        }
        store.parts[kind].front().copied()
    }

    /// Puts a part into a store: either it is complete and stays, or it waits to leave again.
    pub(super) fn store(&mut self, node: usize, part: PartIndex) {
        let kind = self.parts[part].kind;
        if self.setup.ways.from(node, kind).is_empty() {
            self.complete(node, part);
        } else if let Place::Store(store) = &mut self.nodes[node].place {
            store.parts[kind].push_back(part);
            self.look_at(node);
        }
    }

    /// A part enters a sink.
    pub(super) fn sink(&mut self, node: usize, part: PartIndex) {
        match self.line.nodes[node].kind {
            NodeKind::Sink {
                reject: true,
                reorder,
            } => self.reject(node, part, reorder),
            _ => self.complete(node, part),
        }
    }
}
