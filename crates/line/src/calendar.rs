//! Event calendar: future events in time order.
//!
//! A binary heap by time, then priority, then sequence number. Simulated seconds are never negative
//! and never NaN, and the bit patterns of such numbers have the same order as the numbers. Keys are
//! therefore compared as integers. The sequence number makes the order total: two events with the
//! same time and priority happen in the order in which they were scheduled, on every platform.
//!
//! Most events schedule another one. Taking an event therefore leaves a gap at the top of the heap.
//! The next event that is scheduled fills the gap, so that the heap is put in order once, not
//! twice.

/// Future events, sorted by time; see the module documentation.
#[derive(Debug, Clone)]
pub struct Calendar<E> {
    heap: Vec<Entry<E>>,
    /// Whether the first entry was taken.
    gap: bool,
    scheduled: u64,
}

#[derive(Debug, Clone, Copy)]
struct Entry<E> {
    key: u128,
    event: E,
}

/// Number of key bits for the sequence number; the eight bits above hold the priority.
const NUMBER_BITS: u32 = 56;

impl<E: Copy> Calendar<E> {
    /// Creates an empty calendar.
    pub fn new() -> Self {
        Self {
            heap: Vec::new(),
            gap: false,
            scheduled: 0,
        }
    }

    /// Adds an event. Events at the same time are ordered by priority, smallest first, then by
    /// insertion. A negative time counts as 0, and a time that is not finite as `f64::MAX`. Takes
    /// time logarithmic in the number of events.
    #[inline]
    pub fn schedule(&mut self, time: f64, priority: u8, event: E) {
        let time = if time.is_finite() {
            time.max(0.0) + 0.0
        } else {
            f64::MAX
        };
        let order = u64::from(priority) << NUMBER_BITS | self.scheduled;
        self.scheduled = (self.scheduled + 1) & ((1 << NUMBER_BITS) - 1);
        let entry = Entry {
            key: u128::from(time.to_bits()) << 64 | u128::from(order),
            event,
        };
        if self.gap {
            self.gap = false;
            self.put_down(entry);
        } else {
            self.put_up(entry);
        }
    }

    /// Removes the next event and returns it with its time; `None` if there are no events. Takes
    /// time logarithmic in the number of events.
    #[inline]
    pub fn take(&mut self) -> Option<(f64, E)> {
        if self.gap {
            self.gap = false;
            let last = self.heap.pop()?;
            if !self.heap.is_empty() {
                self.put_down(last);
            }
        }
        let first = self.heap.first()?;
        self.gap = true;
        Some((time_of(first.key), first.event))
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.heap.len() - usize::from(self.gap)
    }

    /// Whether there are no events.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Puts an entry in place of the first one.
    fn put_down(&mut self, entry: Entry<E>) {
        let heap = &mut self.heap[..];
        let mut at = 0;
        loop {
            let mut child = 2 * at + 1;
            if child + 1 < heap.len() && heap[child + 1].key < heap[child].key {
                child += 1;
            }
            if child >= heap.len() || entry.key <= heap[child].key {
                break;
            }
            heap[at] = heap[child];
            at = child;
        }
        heap[at] = entry;
    }

    /// Adds an entry at the end.
    fn put_up(&mut self, entry: Entry<E>) {
        let mut at = self.heap.len();
        self.heap.push(entry);
        let heap = &mut self.heap[..];
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
}
