//! Event calendar: future events in time order.
//!
//! A binary heap with one 128-bit key: time, then priority, then a sequence number. Simulated
//! seconds are never negative and never NaN, and the bit patterns of such numbers have the same
//! order as the numbers. Keys are therefore compared as integers. The sequence number makes the
//! order total: two events with the same time and priority happen in the order in which they were
//! scheduled, on every platform.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Future events, sorted by time; see the module documentation.
#[derive(Debug, Clone)]
pub struct Calendar<E> {
    heap: BinaryHeap<Entry<E>>,
    scheduled: u64,
}

#[derive(Debug, Clone)]
struct Entry<E> {
    key: u128,
    event: E,
}

/// Number of key bits for the sequence number; the eight bits above hold the priority.
const NUMBER_BITS: u32 = 56;

impl<E> Calendar<E> {
    /// Creates an empty calendar.
    pub fn new() -> Self {
        Self {
            heap: BinaryHeap::new(),
            scheduled: 0,
        }
    }

    /// Adds an event. Events at the same time are ordered by priority, smallest first, then by
    /// insertion. A negative time counts as 0, and a time that is not finite as `f64::MAX`.
    pub fn schedule(&mut self, time: f64, priority: u8, event: E) {
        let time = if time.is_finite() {
            time.max(0.0) + 0.0
        } else {
            f64::MAX
        };
        let order = u64::from(priority) << NUMBER_BITS | self.scheduled;
        self.scheduled = (self.scheduled + 1) & ((1 << NUMBER_BITS) - 1);
        self.heap.push(Entry {
            key: u128::from(time.to_bits()) << 64 | u128::from(order),
            event,
        });
    }

    /// Removes the next event and returns it with its time; `None` if there are no events.
    pub fn take(&mut self) -> Option<(f64, E)> {
        self.heap
            .pop()
            .map(|entry| (time_of(entry.key), entry.event))
    }

    /// Time of the next event; `None` if there are no events.
    pub fn next_time(&self) -> Option<f64> {
        self.heap.peek().map(|entry| time_of(entry.key))
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.heap.len()
    }

    /// Whether there are no events.
    pub fn is_empty(&self) -> bool {
        self.heap.is_empty()
    }
}

impl<E> Default for Calendar<E> {
    fn default() -> Self {
        Self::new()
    }
}

fn time_of(key: u128) -> f64 {
    f64::from_bits((key >> 64) as u64)
}

// The standard heap returns its greatest element first, so the order is reversed.
impl<E> Ord for Entry<E> {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key.cmp(&self.key)
    }
}

impl<E> PartialOrd for Entry<E> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<E> PartialEq for Entry<E> {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl<E> Eq for Entry<E> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_then_priority_then_order_of_entry() {
        let mut calendar = Calendar::new();
        calendar.schedule(2.0, 0, "e");
        calendar.schedule(1.0, 1, "c");
        calendar.schedule(1.0, 0, "a");
        calendar.schedule(1.0, 1, "d");
        calendar.schedule(1.0, 0, "b");
        calendar.schedule(f64::NAN, 0, "f");
        calendar.schedule(-0.0, 0, "first");
        let order: Vec<_> = std::iter::from_fn(|| calendar.take()).collect();
        assert_eq!(
            order.iter().map(|(_, e)| *e).collect::<Vec<_>>(),
            ["first", "a", "b", "c", "d", "e", "f"]
        );
        assert_eq!(order[1].0.to_bits(), 1.0_f64.to_bits());
    }
}
