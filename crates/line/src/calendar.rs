//! Event calendar: future events in time order.
//!
//! Events are ordered by time, then priority, then sequence number. Simulated seconds are never
//! negative and never NaN, and the bit patterns of such numbers have the same order as the numbers.
//! Keys are therefore compared as integers. The sequence number makes the order total: two events
//! with the same time and priority happen in the order in which they were scheduled, on every
//! platform.
//!
//! The next few events lie in an array of fixed size, the later ones in a heap. The events of the
//! array stay where they are; their order is kept beside it, in the digits of one number. A new
//! event gets its place in this order by comparisons whose results no branch depends on: when an
//! event happens cannot be predicted, so branches would often be mispredicted. The same is true of
//! the way down the heap. In a small line, there are no later events; in a large one, an event
//! takes logarithmic time.

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
    /// All other events, each later than the next ones, as a heap in which an entry has
    /// [`CHILDREN`].
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
        let next = first_slot(self.order);
        let (key, event) = (self.keys[next], self.events[next]?);
        self.keys[next] = NONE;
        self.events[next] = None;
        self.order = self.order.rotate_right(DIGIT_BITS);
        self.near -= 1;
        if self.near == 0 && !self.far.is_empty() {
            self.bring_near();
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

    /// Adds an event to a full array, and puts the latest event with the far ones.
    #[inline(never)]
    fn exchange(&mut self, key: u128, event: E) {
        let last = last_slot(self.order);
        let latest = self.keys[last];
        match self.events[last] {
            Some(near) if key < latest => {
                self.put_far(Entry {
                    key: latest,
                    event: near,
                });
                self.insert(key, event);
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

    /// Removes and returns the first entry of the heap. The gap that it leaves goes down to the end
    /// of the heap, and the last entry comes up from there: it mostly belongs near the end.
    fn take_far(&mut self) -> Option<Entry<E>> {
        let last = self.far.pop()?;
        let Some(&first) = self.far.first() else {
            return Some(last);
        };
        let heap = &mut self.far[..];
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
    fn put_far(&mut self, entry: Entry<E>) {
        let gap = self.far.len();
        self.far.push(entry);
        rise(&mut self.far, gap, entry);
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
