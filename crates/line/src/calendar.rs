//! Event calendar: future events in time order.
//!
//! Events are ordered by time, then priority, then sequence number. Simulated seconds are never
//! negative and never NaN, and the bit patterns of such numbers have the same order as the numbers.
//! Keys are therefore compared as integers. The sequence number makes the order total: two events
//! with the same time and priority happen in the order in which they were scheduled, on every
//! platform.
//!
//! The next few events are kept in order, the later ones in a binary heap. So the calendar of a
//! small line is a short sorted list, which is faster than a heap, and that of a large line takes
//! logarithmic time.

/// Future events, sorted by time; see the module documentation.
#[derive(Debug, Clone)]
pub struct Calendar<E> {
    /// The next events, the very next one last. Empty only if there are no events.
    near: Vec<Entry<E>>,
    /// All other events, none of them earlier than one that is near, as a binary heap.
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

/// Maximum number of events that are kept in order.
const NEAR: usize = 12;

impl<E: Copy> Calendar<E> {
    /// Creates an empty calendar.
    pub fn new() -> Self {
        Self {
            near: Vec::with_capacity(NEAR + 1),
            far: Vec::new(),
            scheduled: 0,
        }
    }

    /// Adds an event. Events at the same time are ordered by priority, smallest first, then by
    /// insertion. A negative time counts as 0, and a time that is infinite or no number as `f64::MAX`. Takes
    /// time logarithmic in the number of events.
    #[inline]
    pub fn schedule(&mut self, time: f64, priority: u8, event: E) {
        let time = match time {
            _ if time > 0.0 => time.min(f64::MAX),
            _ if time.is_nan() => f64::MAX,
            _ => 0.0,
        };
        let order = u64::from(priority) << NUMBER_BITS | self.scheduled;
        self.scheduled += 1;
        let entry = Entry {
            key: u128::from(time.to_bits()) << 64 | u128::from(order),
            event,
        };
        if self.far.first().is_some_and(|first| first.key < entry.key) {
            self.put_far(entry);
        } else {
            self.put_near(entry);
        }
    }

    /// Removes the next event and returns it with its time; `None` if there are no events. Takes
    /// time logarithmic in the number of events.
    #[inline]
    pub fn take(&mut self) -> Option<(f64, E)> {
        let first = self.near.pop()?;
        if self.near.is_empty() && !self.far.is_empty() {
            self.bring_near();
        }
        Some((time_of(first.key), first.event))
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.near.len() + self.far.len()
    }

    /// Whether there are no events.
    pub fn is_empty(&self) -> bool {
        self.near.is_empty()
    }

    /// Adds an entry that is earlier than all far ones.
    #[inline]
    fn put_near(&mut self, entry: Entry<E>) {
        self.near.push(entry);
        let mut open = &mut self.near[..];
        while let [.., later, gap] = open
            && later.key < entry.key
        {
            *gap = *later;
            let count = open.len() - 1;
            open = &mut open[..count];
        }
        if let [.., gap] = open {
            *gap = entry;
        }
        if self.near.len() > NEAR {
            self.put_away();
        }
    }

    /// Puts the latest of too many near entries with the far ones.
    #[inline(never)]
    fn put_away(&mut self) {
        let latest = self.near.remove(0);
        self.put_far(latest);
    }

    /// Makes some far entries the near ones.
    #[inline(never)]
    fn bring_near(&mut self) {
        for _ in 0..NEAR / 2 {
            let Some(next) = self.take_far() else { break };
            self.near.push(next);
        }
        self.near.reverse();
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
