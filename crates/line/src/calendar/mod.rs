//! Event calendar: future events in time order.
//!
//! Events are ordered by time, then priority, then sequence number. Simulated seconds are never
//! negative and never NaN, and the bit patterns of such numbers have the same order as the numbers.
//! Keys are therefore compared as integers. The sequence number makes the order total: two events
//! with the same time and priority happen in the order in which they were scheduled, on every
//! platform.
//!
//! The next few events lie in an array of fixed size, and a small line has no others. The events of
//! the array stay where they are; their order is kept beside it, in the digits of one number. A new
//! event gets its place in this order by comparisons whose results no branch depends on: when an
//! event happens cannot be predicted, so branches would often be mispredicted.
//!
//! The later events lie in a heap, whose way down has no such branches either. In a large line,
//! most of them lie in a `Year` instead, and come to the array a day at a time. Then only the
//! events of a crowded day and those after the end of the year are in the heap. So an event takes
//! constant time on average if the events are spread over time, and logarithmic time at most.

mod year;

use year::Year;

/// Future events, sorted by time; see the module documentation.
#[derive(Debug, Clone)]
pub struct Calendar<E> {
    /// The keys of the next events, and [`NONE`] in the slots without one; all are `NONE` only if
    /// there are no events.
    keys: [u128; NEAR],
    /// The next events, in the same slots.
    events: [Option<E>; NEAR],
    /// All slots, the one with the first event in the lowest digit, those without one at the end.
    order: u32,
    /// Number of next events.
    near: usize,
    /// Later events than the next ones, as a heap in which an entry has [`CHILDREN`].
    heap: Vec<Entry<E>>,
    /// All other events, each later than the next ones.
    year: Year<E>,
    scheduled: u64,
}

#[derive(Debug, Clone, Copy)]
struct Entry<E> {
    key: u128,
    event: E,
}

/// Number of key bits for the sequence number; the eight bits above hold the priority.
const NUMBER_BITS: u32 = 56;

/// Maximum number of events in the array: as many as an `order` has digits.
const NEAR: usize = 8;

/// Number of children of an entry of the heap.
const CHILDREN: usize = 4;

/// Number of bits of a digit of an `order`.
const DIGIT_BITS: u32 = u32::BITS / NEAR as u32;

/// The order of slots without events.
const SLOTS: u32 = 0x7654_3210;

/// A key later than that of any event.
const NONE: u128 = u128::MAX;

impl<E: Copy> Calendar<E> {
    /// Creates an empty calendar.
    pub fn new() -> Self {
        Self {
            keys: [NONE; NEAR],
            events: [None; NEAR],
            order: SLOTS,
            near: 0,
            heap: Vec::new(),
            year: Year::new(),
            scheduled: 0,
        }
    }

    /// Adds an event. Events at the same time are ordered by priority, smallest first, then by
    /// insertion. A negative time counts as 0, and infinity or no number as `f64::MAX`. Takes
    /// constant time on average if the events are spread over time, and time logarithmic in their
    /// number otherwise.
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
        if self.others() == 0 {
            self.put_near(key, event);
        } else {
            self.put_among(Entry { key, event });
        }
    }

    /// Removes the next event and returns it with its time; `None` if there are no events. Takes
    /// as much time as [`schedule`](Self::schedule).
    #[inline]
    pub fn take(&mut self) -> Option<(f64, E)> {
        let next = first_slot(self.order);
        let (key, event) = (self.keys[next], self.events[next]?);
        self.keys[next] = NONE;
        self.events[next] = None;
        self.order = self.order.rotate_right(DIGIT_BITS);
        self.near -= 1;
        if self.near == 0 && self.others() > 0 {
            self.bring_near(time_of(key));
        }
        Some((time_of(key), event))
    }

    /// The next event, which stays.
    #[inline]
    pub fn peek(&self) -> Option<E> {
        self.events[first_slot(self.order)]
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.near + self.others()
    }

    /// Number of events other than the next ones.
    #[inline]
    fn others(&self) -> usize {
        self.heap.len() + self.year.len()
    }

    /// Whether there are no events.
    pub fn is_empty(&self) -> bool {
        self.near == 0
    }

    /// Adds an event when there are others than the next ones.
    #[inline(never)]
    fn put_among(&mut self, entry: Entry<E>) {
        if self.year.has_begun() {
            let day = self.year.day_of(entry.key);
            if self.year.is_later(day) {
                if !self.year.note(day, entry) {
                    self.push(entry);
                }
                return;
            }
        }
        if self.heap.first().is_some_and(|first| first.key < entry.key) {
            self.push(entry);
        } else {
            self.put_near(entry.key, entry.event);
        }
    }

    /// Adds an event that is earlier than all others but the next ones.
    #[inline]
    fn put_near(&mut self, key: u128, event: E) {
        if self.near == NEAR {
            self.exchange(key, event);
            return;
        }
        self.insert(key, event);
        self.near += 1;
    }

    /// Puts an event that is earlier than that of the last slot, if there is one, into this slot.
    #[inline]
    fn insert(&mut self, key: u128, event: E) {
        let last = last_slot(self.order);
        self.order = inserted(self.order, self.position(key), last);
        self.keys[last] = key;
        self.events[last] = Some(event);
    }

    /// Number of events in the array that are earlier than this key.
    #[inline]
    fn position(&self, key: u128) -> usize {
        self.keys.iter().map(|near| usize::from(*near < key)).sum()
    }

    /// Adds an event to a full array, and puts the latest event on the heap.
    #[inline(never)]
    fn exchange(&mut self, key: u128, event: E) {
        let last = last_slot(self.order);
        let latest = self.keys[last];
        match self.events[last] {
            Some(near) if key < latest => {
                self.push(Entry {
                    key: latest,
                    event: near,
                });
                self.insert(key, event);
            }
            _ => self.push(Entry { key, event }),
        }
        if self.others() == 1 {
            // Until now, events of any day were near.
            let day = self.year.day_of(self.heap[0].key);
            self.year.advance(day);
        }
    }

    /// Makes the first of the other events near ones, when there are no near ones. `now` is the
    /// time of the event that was taken last.
    #[inline(never)]
    fn bring_near(&mut self, now: f64) {
        let others = self.others();
        let happened = self.scheduled - others as u64;
        if self.year.is_outdated(others, happened) {
            self.begin_year(now);
        }
        if !self.year.has_begun() {
            for _ in 0..NEAR / 2 {
                self.bring();
            }
            return;
        }
        let Some(day) = self.year.next_day() else {
            return self.bring_first(u64::MAX);
        };
        let first = self.heap.first().map(|first| self.year.day_of(first.key));
        if first.is_some_and(|first| first < day) {
            return self.bring_first(day - 1);
        }
        self.year.advance(day);
        if first == Some(day) || self.year.has_more(day, NEAR) {
            while let Some(entry) = self.year.take(day) {
                self.push(entry);
            }
            return self.bring_first(day);
        }
        while let Some(Entry { key, event }) = self.year.take(day) {
            self.insert(key, event);
            self.near += 1;
        }
    }

    /// Makes the first events of the heap near ones, if they are on this day or earlier, when there
    /// are no near ones.
    #[inline]
    fn bring_first(&mut self, day: u64) {
        for _ in 0..NEAR / 2 {
            if let Some(first) = self.heap.first()
                && let first = self.year.day_of(first.key)
                && first <= day
            {
                self.year.advance(first);
                self.bring();
            }
        }
    }

    /// Makes the first event of the heap a near one, if there is one.
    #[inline]
    fn bring(&mut self) {
        if let Some(Entry { key, event }) = self.pop() {
            self.insert(key, event);
            self.near += 1;
        }
    }

    /// Begins a year that fits the events, when there are no near ones.
    #[cold]
    #[inline(never)]
    fn begin_year(&mut self, now: f64) {
        let mut entries = std::mem::take(&mut self.heap);
        self.year.end(&mut entries);
        self.year.begin(&mut entries, now);
        for entry in entries {
            self.push(entry);
        }
    }

    /// Removes and returns the first entry of the heap. The gap that it leaves goes down to the end
    /// of the heap, and the last entry comes up from there: it mostly belongs near the end.
    fn pop(&mut self) -> Option<Entry<E>> {
        let last = self.heap.pop()?;
        let Some(&first) = self.heap.first() else {
            return Some(last);
        };
        let heap = &mut self.heap[..];
        let mut gap = 0;
        while let Some(children) = heap.get(CHILDREN * gap + 1..).and_then(<[_]>::first_chunk) {
            let earliest = CHILDREN * gap + 1 + earliest_of(children);
            heap[gap] = heap[earliest];
            gap = earliest;
        }
        let rest = CHILDREN * gap + 1..heap.len();
        if let Some(earliest) = rest.min_by_key(|child| heap[*child].key) {
            heap[gap] = heap[earliest];
            gap = earliest;
        }
        rise(heap, gap, last);
        Some(first)
    }

    /// Adds an entry to the heap.
    #[inline(never)]
    fn push(&mut self, entry: Entry<E>) {
        let gap = self.heap.len();
        self.heap.push(entry);
        rise(&mut self.heap, gap, entry);
    }
}

impl<E: Copy> Default for Calendar<E> {
    fn default() -> Self {
        Self::new()
    }
}

/// Puts an entry into a gap of the heap, or further up, in place of later entries.
#[inline]
fn rise<E: Copy>(heap: &mut [Entry<E>], mut gap: usize, entry: Entry<E>) {
    while gap > 0 {
        let parent = (gap - 1) / CHILDREN;
        if heap[parent].key <= entry.key {
            break;
        }
        heap[gap] = heap[parent];
        gap = parent;
    }
    heap[gap] = entry;
}

/// The position of the earliest entry, without branches; see the module documentation.
#[inline]
fn earliest_of<E>(entries: &[Entry<E>; CHILDREN]) -> usize {
    let [a, b, c, d] = entries;
    let left = usize::from(b.key < a.key);
    let right = 2 + usize::from(d.key < c.key);
    left + (right - left) * usize::from(entries[right].key < entries[left].key)
}

/// The first slot of an order.
#[inline]
fn first_slot(order: u32) -> usize {
    order as usize % NEAR
}

/// The last slot of an order.
#[inline]
fn last_slot(order: u32) -> usize {
    first_slot(order.rotate_left(DIGIT_BITS))
}

/// An order in which the last slot has moved to this position, which is less than [`NEAR`].
#[inline]
fn inserted(order: u32, position: usize, last: usize) -> u32 {
    let shift = position as u32 * DIGIT_BITS;
    let earlier = order & ((1 << shift) - 1);
    let later = (order - earlier) << DIGIT_BITS;
    earlier | (last as u32) << shift | later
}

fn time_of(key: u128) -> f64 {
    f64::from_bits((key >> 64) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use std::collections::BTreeMap;

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

    /// Lets events come and go, and compares their order with that of a sorted map. `delay` draws
    /// after which time a new event happens. Returns the number of events that were taken while a
    /// year had begun.
    fn compare(seed: u64, most: usize, delay: impl Fn(&mut Stream) -> f64) -> usize {
        let mut chance = Stream::from_seed(seed);
        let mut calendar = Calendar::new();
        let mut pending = BTreeMap::new();
        let mut now = 0.0_f64;
        let mut len = 0;
        let mut in_years = 0;
        for number in 0..30_000_u32 {
            // Grows, stays, and shrinks again to nothing.
            let wanted = match number / 1000 % 6 {
                0 | 1 => 3,
                2 | 3 => 1,
                _ => 0,
            };
            for _ in 0..wanted {
                if calendar.len() < most {
                    let time = now + delay(&mut chance);
                    let priority = chance.below(5) as u8;
                    calendar.schedule(time, priority, number);
                    // Numbers do not decrease, and equal ones need no order.
                    let order = (time.to_bits(), priority, number);
                    *pending.entry(order).or_insert(0) += 1;
                    len += 1;
                }
            }
            in_years += usize::from(calendar.year.has_begun());
            let next = pending.first_entry().map(|mut first| {
                let (time, _, number) = *first.key();
                *first.get_mut() -= 1;
                if *first.get() == 0 {
                    first.remove();
                }
                (f64::from_bits(time), number)
            });
            assert_eq!(calendar.take(), next);
            len -= usize::from(next.is_some());
            assert_eq!(calendar.len(), len);
            assert_eq!(calendar.is_empty(), pending.is_empty());
            let peeked = pending.first_key_value().map(|((_, _, number), _)| *number);
            assert_eq!(calendar.peek(), peeked);
            now = next.map_or(now, |(time, _)| time);
        }
        in_years
    }

    #[test]
    fn events_spread_over_time_come_in_order() {
        for seed in 0..5 {
            let in_years = [
                compare(seed, 2000, |chance| chance.exponential(1.0)),
                compare(seed, 200, |chance| chance.exponential(1e6)),
                // Some events lie far beyond the year.
                compare(seed, 2000, |chance| match chance.below(20) {
                    0 => 1e5 * chance.unit(),
                    _ => chance.unit(),
                }),
                // The rate of events changes by a factor of a million.
                compare(seed, 2000, |chance| {
                    10.0_f64.powf(6.0 * chance.unit() - 3.0)
                }),
            ];
            assert!(in_years.iter().all(|events| *events > 2000), "{in_years:?}");
        }
    }

    #[test]
    fn events_at_few_instants_come_in_order() {
        for seed in 0..5 {
            compare(seed, 2000, |chance| chance.below(50) as f64);
            compare(seed, 2000, |chance| chance.below(500) as f64);
            compare(seed, 2000, |chance| match chance.below(10) {
                0 => chance.exponential(1.0),
                _ => 1.0,
            });
            compare(seed, 2000, |chance| 1e300 * chance.unit());
            compare(seed, 6, |chance| chance.exponential(1.0));
            compare(seed, 12, |chance| chance.exponential(1.0));
            assert_eq!(compare(seed, 2000, |_| 1.0), 0);
            assert_eq!(compare(seed, 2000, |_| 0.0), 0);
            assert_eq!(compare(seed, 20, |chance| chance.exponential(1.0)), 0);
        }
    }
}
