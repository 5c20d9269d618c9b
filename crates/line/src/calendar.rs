//! The event calendar: what will happen, in the order in which it will.
//!
//! A binary heap over one 128-bit key: the time, then a priority, then a running number. Simulated
//! seconds are never negative and never NaN, and the bit patterns of such numbers sort as the
//! numbers do, so that the whole comparison is one of integers. The running number makes the order
//! total: two events of one instant and priority happen in the order in which they were scheduled,
//! on every platform.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Events by time; see the module.
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

/// How many bits of the key hold the running number; the eight above them hold the priority.
const NUMBER_BITS: u32 = 56;

impl<E> Calendar<E> {
    /// An empty calendar.
    pub fn new() -> Self {
        Self {
            heap: BinaryHeap::new(),
            scheduled: 0,
        }
    }

    /// Enters an event. Of two at the same time the one with the smaller priority comes first, and
    /// of two with the same priority the one that was entered first. A time that is negative counts
    /// as 0, and one that is not finite as the last of all times.
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

    /// Takes the next event out, with its time.
    pub fn take(&mut self) -> Option<(f64, E)> {
        self.heap
            .pop()
            .map(|entry| (time_of(entry.key), entry.event))
    }

    /// The time of the next event.
    pub fn next_time(&self) -> Option<f64> {
        self.heap.peek().map(|entry| time_of(entry.key))
    }

    /// How many events are entered.
    pub fn len(&self) -> usize {
        self.heap.len()
    }

    /// Whether nothing is entered.
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

// The standard heap gives its greatest element first, hence the order the other way round.
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
