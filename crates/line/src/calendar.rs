//! Event calendar: future events in time order.
//!
//! Events are ordered by time, then priority, then sequence number. Simulated seconds are never
//! negative and never NaN, and the bit patterns of such numbers have the same order as the numbers.
//! Keys are therefore compared as integers. The sequence number makes the order total: two events
//! with the same time and priority happen in the order in which they were scheduled, on every
//! platform.
//!
//! The next few events are kept in an array of fixed size, the later ones in a binary heap. The
//! least key of the array is found by comparisons whose results no branch depends on: which event
//! is next cannot be predicted, so each branch would be mispredicted half of the time. In a small
//! line, there are no later events; in a large one, an event takes logarithmic time.

use std::hint::select_unpredictable;

/// Future events, sorted by time; see the module documentation.
#[derive(Debug, Clone)]
pub struct Calendar<E> {
    /// The keys of the next events, followed by [`NONE`]; all are `NONE` only if there are no
    /// events.
    keys: [u128; NEAR],
    /// The next events, in the order of `keys`.
    events: [Option<E>; NEAR],
    /// Number of next events.
    near: usize,
    /// All other events, each later than the next ones, as a binary heap.
    far: Vec<Entry<E>>,
    scheduled: u64,
}

#[derive(Debug, Clone, Copy)]
struct Entry<E> {
    key: u128,
    event: E,
}

/// Number of key bits for the sequence number; the eight bits above hold the priority.
const NUMBER_BITS: u32 = 56;

/// Maximum number of events in the array.
const NEAR: usize = 8;

/// A key later than that of any event.
const NONE: u128 = u128::MAX;

impl<E: Copy> Calendar<E> {
    /// Creates an empty calendar.
    pub fn new() -> Self {
        Self {
            keys: [NONE; NEAR],
            events: [None; NEAR],
            near: 0,
            far: Vec::new(),
            scheduled: 0,
        }
    }

    /// Adds an event. Events at the same time are ordered by priority, smallest first, then by
    /// insertion. A negative time counts as 0, and infinity or no number as `f64::MAX`. Takes time
    /// logarithmic in the number of events.
    #[inline]
    pub fn schedule(&mut self, time: f64, priority: u8, event: E) {
        let time = match time {
            _ if time > 0.0 => time.min(f64::MAX),
            _ if time.is_nan() => f64::MAX,
            _ => 0.0,
        };
        let order = u64::from(priority) << NUMBER_BITS | self.scheduled;
        self.scheduled += 1;
        let key = u128::from(time.to_bits()) << 64 | u128::from(order);
        if self.far.first().is_some_and(|first| first.key < key) {
            self.put_far(Entry { key, event });
        } else {
            self.put_near(key, event);
        }
    }

    /// Removes the next event and returns it with its time; `None` if there are no events. Takes
    /// time logarithmic in the number of events.
    #[inline]
    pub fn take(&mut self) -> Option<(f64, E)> {
        let next = least(&self.keys);
        let (key, event) = (self.keys[next], self.events[next]?);
        self.remove_near(next);
        if self.near == 0 && !self.far.is_empty() {
            self.bring_near();
        }
        Some((time_of(key), event))
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.near + self.far.len()
    }

    /// Whether there are no events.
    pub fn is_empty(&self) -> bool {
        self.near == 0
    }

    /// Adds an event that is earlier than all far ones.
    #[inline]
    fn put_near(&mut self, key: u128, event: E) {
        if self.near == NEAR {
            self.exchange(key, event);
            return;
        }
        self.keys[self.near] = key;
        self.events[self.near] = Some(event);
        self.near += 1;
    }

    /// Removes an event from the array.
    #[inline]
    fn remove_near(&mut self, at: usize) {
        self.near -= 1;
        self.keys[at] = self.keys[self.near];
        self.events[at] = self.events[self.near];
        self.keys[self.near] = NONE;
        self.events[self.near] = None;
    }

    /// Adds an event to a full array, and puts the latest event with the far ones.
    #[inline(never)]
    fn exchange(&mut self, key: u128, event: E) {
        let latest = (0..NEAR).max_by_key(|at| self.keys[*at]).unwrap_or(0);
        match self.events[latest] {
            Some(near) if key < self.keys[latest] => {
                self.put_far(Entry {
                    key: self.keys[latest],
                    event: near,
                });
                self.keys[latest] = key;
                self.events[latest] = Some(event);
            }
            _ => self.put_far(Entry { key, event }),
        }
    }

    /// Makes the first far events near ones.
    #[inline(never)]
    fn bring_near(&mut self) {
        for _ in 0..NEAR / 2 {
            let Some(Entry { key, event }) = self.take_far() else {
                break;
            };
            self.put_near(key, event);
        }
    }

    /// Removes and returns the first entry of the heap.
    fn take_far(&mut self) -> Option<Entry<E>> {
        let last = self.far.pop()?;
        let Some(&first) = self.far.first() else {
            return Some(last);
        };
        let heap = &mut self.far[..];
        let mut at = 0;
        loop {
            let mut child = 2 * at + 1;
            if child + 1 < heap.len() && heap[child + 1].key < heap[child].key {
                child += 1;
            }
            if child >= heap.len() || last.key <= heap[child].key {
                break;
            }
            heap[at] = heap[child];
            at = child;
        }
        heap[at] = last;
        Some(first)
    }

    /// Adds an entry to the heap.
    #[inline(never)]
    fn put_far(&mut self, entry: Entry<E>) {
        let mut at = self.far.len();
        self.far.push(entry);
        let heap = &mut self.far[..];
        while at > 0 {
            let parent = (at - 1) / 2;
            if heap[parent].key <= entry.key {
                break;
            }
            heap[at] = heap[parent];
            at = parent;
        }
        heap[at] = entry;
    }
}

impl<E: Copy> Default for Calendar<E> {
    fn default() -> Self {
        Self::new()
    }
}

/// Index of the least key.
#[inline]
fn least(keys: &[u128; NEAR]) -> usize {
    let earlier = |a: (u128, usize), b: (u128, usize)| {
        let is_later = b.0 < a.0;
        (
            select_unpredictable(is_later, b.0, a.0),
            select_unpredictable(is_later, b.1, a.1),
        )
    };
    let of_two = |first: usize| earlier((keys[first], first), (keys[first + 1], first + 1));
    let of_four = |first: usize| earlier(of_two(first), of_two(first + 2));
    earlier(of_four(0), of_four(4)).1
}

fn time_of(key: u128) -> f64 {
    f64::from_bits((key >> 64) as u64)
}

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

    #[test]
    fn many_events_come_in_order() {
        let mut chance = crate::random::Stream::from_seed(5);
        let mut calendar = Calendar::new();
        let mut pending = Vec::new();
        let mut now = 0.0;
        for number in 0..20_000_u32 {
            // Grows to hundreds of events, and shrinks again.
            for _ in 0..chance.below(if number % 2000 < 1000 { 4 } else { 2 }) {
                let time = now + chance.below(50) as f64;
                calendar.schedule(time, 0, number);
                pending.push((time, number));
            }
            let next = (0..pending.len()).min_by(|a, b| pending[*a].0.total_cmp(&pending[*b].0));
            let next = next.map(|index| pending.remove(index));
            assert_eq!(calendar.take(), next);
            assert_eq!(calendar.len(), pending.len());
            now = next.map_or(now, |(time, _)| time);
        }
    }
}
