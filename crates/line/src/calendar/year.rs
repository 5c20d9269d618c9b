//! The year of a calendar: later events by day.
//!
//! This is the calendar queue of Brown (*Calendar Queues: A Fast O(1) Priority Queue Implementation
//! for the Simulation Event Set Problem*, Communications of the ACM 31, 1988). An event is noted on
//! its day without being sorted there; a day is read when it comes. The length of a day is fitted
//! to the events, so that a day has a few of them.

use super::{Entry, time_of};

/// Later events by day, each day unsorted.
#[derive(Debug, Clone)]
pub(super) struct Year<E> {
    /// Days a second.
    rate: f64,
    /// The current day. The year has only events of later days.
    today: u64,
    /// By day, from any day to the same day of the next year: the place of the event that was noted
    /// last, or [`NOWHERE`]. The number of days is a power of two; there are none if the year has
    /// not begun.
    days: Vec<u32>,
    /// By day, in one bit: whether it has an event.
    busy: Vec<u64>,
    places: Vec<Place<E>>,
    /// A place without an event, from which all others can be reached; [`NOWHERE`] if there is
    /// none.
    free: u32,
    /// Number of events.
    len: usize,
    /// Number of days that were asked for since the length of a day was last examined.
    asked: usize,
    /// Number of days to ask for before it is examined again.
    interval: usize,
    /// The day, and the number of events that had happened, when it was last examined.
    examined: (u64, u64),
}

/// A place for an event.
#[derive(Debug, Clone, Copy)]
struct Place<E> {
    key: u128,
    event: E,
    /// The place of the next event of the same day, or the next place without an event.
    next: u32,
}

/// No place.
const NOWHERE: u32 = u32::MAX;

/// Minimum number of events for which a year is begun.
const MIN_EVENTS: usize = 32;

/// Number of events that a day should have.
const EVENTS_A_DAY: f64 = 3.0;

/// Maximum number of events a day, on average, with which the length of a day is kept.
const MAX_EVENTS_A_DAY: u64 = 8;

/// Minimum number of days to ask for before the length of a day is examined.
const MIN_INTERVAL: usize = 256;

/// The same after examinations that were in vain.
const MAX_INTERVAL: usize = 1 << 14;

impl<E: Copy> Year<E> {
    pub(super) fn new() -> Self {
        Self {
            rate: 0.0,
            today: 0,
            days: Vec::new(),
            busy: Vec::new(),
            places: Vec::new(),
            free: NOWHERE,
            len: 0,
            asked: 0,
            interval: MIN_INTERVAL,
            examined: (0, 0),
        }
    }

    /// Whether there are days on which events are noted.
    #[inline]
    pub(super) fn has_begun(&self) -> bool {
        !self.days.is_empty()
    }

    /// Number of events.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The day of an event. It is never earlier than that of an earlier event.
    #[inline]
    pub(super) fn day_of(&self, key: u128) -> u64 {
        (time_of(key) * self.rate) as u64
    }

    /// Whether a day is later than the current one.
    #[inline]
    pub(super) fn is_later(&self, day: u64) -> bool {
        day > self.today
    }

    /// Notes an event on its day, which is later than the current one. Returns false if it comes
    /// after the end of the year, and is not noted.
    #[inline]
    pub(super) fn note(&mut self, day: u64, entry: Entry<E>) -> bool {
        if day - self.today >= self.days.len() as u64 {
            return false;
        }
        let at = self.index(day);
        let next = std::mem::replace(&mut self.days[at], self.free);
        let Entry { key, event } = entry;
        let noted = Place { key, event, next };
        if let Some(place) = self.places.get_mut(self.free as usize) {
            self.free = place.next;
            *place = noted;
        } else {
            self.days[at] = self.places.len() as u32;
            self.places.push(noted);
        }
        self.busy[at / 64] |= 1 << (at % 64);
        self.len += 1;
        true
    }

    /// The next day that has an event.
    #[inline]
    pub(super) fn next_day(&self) -> Option<u64> {
        if self.len == 0 {
            return None;
        }
        let first = self.index(self.today + 1);
        let mut word = first / 64;
        let mut bits = self.busy[word] & u64::MAX << (first % 64);
        while bits == 0 {
            word = (word + 1) % self.busy.len();
            bits = self.busy[word];
        }
        let at = word * 64 + bits.trailing_zeros() as usize;
        let days = at.wrapping_sub(first) % self.days.len();
        Some(self.today + 1 + days as u64)
    }

    /// Whether a day has more than this number of events.
    #[inline]
    pub(super) fn has_more(&self, day: u64, count: usize) -> bool {
        let mut place = self.days[self.index(day)];
        for _ in 0..count {
            match self.places.get(place as usize) {
                Some(noted) => place = noted.next,
                None => return false,
            }
        }
        place != NOWHERE
    }

    /// Makes a day the current one, unless it is past. All events of earlier days must have been
    /// removed, and those of this day must be next.
    #[inline]
    pub(super) fn advance(&mut self, day: u64) {
        self.today = self.today.max(day);
    }

    /// Removes and returns an event of a day.
    #[inline]
    pub(super) fn take(&mut self, day: u64) -> Option<Entry<E>> {
        let at = self.index(day);
        let first = self.days[at];
        let place = self.places.get_mut(first as usize)?;
        let Place { key, event, next } = *place;
        place.next = std::mem::replace(&mut self.free, first);
        self.days[at] = next;
        if next == NOWHERE {
            self.busy[at / 64] &= !(1 << (at % 64));
        }
        self.len -= 1;
        Some(Entry { key, event })
    }

    #[inline]
    fn index(&self, day: u64) -> usize {
        day as usize & (self.days.len() - 1)
    }

    /// Counts that a day is asked for. Returns whether the year should begin anew, with days of
    /// another length. `others` is the number of events that are not next, `happened` that of the
    /// events that have happened so far.
    ///
    /// This is seldom true: so that its cost for each event is constant, as many days as there are
    /// events are asked for before, and twice as many if the last time was in vain.
    #[inline]
    pub(super) fn is_outdated(&mut self, others: usize, happened: u64) -> bool {
        self.asked += 1;
        if self.asked < self.interval || self.asked < others {
            return false;
        }
        self.asked = 0;
        let days = self.today - self.examined.0;
        let events = happened - self.examined.1;
        self.examined = (self.today, happened);
        let fits = days <= events && events / MAX_EVENTS_A_DAY <= days;
        if self.has_begun() && fits && others / 2 <= self.days.len() {
            self.interval = MIN_INTERVAL;
            return false;
        }
        self.interval = (2 * self.interval).min(MAX_INTERVAL);
        self.has_begun() || others >= MIN_EVENTS
    }

    /// Removes all events, and adds them to `entries`. Ends the year.
    pub(super) fn end(&mut self, entries: &mut Vec<Entry<E>>) {
        for day in 0..self.days.len() as u64 {
            entries.extend(std::iter::from_fn(|| self.take(day)));
        }
        self.places.clear();
        self.free = NOWHERE;
        self.days.clear();
        self.busy.clear();
        self.rate = 0.0;
        self.today = 0;
        self.examined.0 = 0;
    }

    /// Begins a year that fits these events, after which `entries` has those that are not noted.
    /// The year does not begin if there are few events, or if most happen at the same instants.
    /// `now` is the current time in seconds.
    pub(super) fn begin(&mut self, entries: &mut Vec<Entry<E>>, now: f64) {
        if entries.len() < MIN_EVENTS {
            return;
        }
        let quarter = entries.len() / 4;
        let (_, last, _) = entries.select_nth_unstable_by_key(quarter, |entry| entry.key);
        let rate = quarter as f64 / (time_of(last.key) - now) / EVENTS_A_DAY;
        if !(rate.is_finite() && rate > 0.0) {
            return;
        }
        let days = entries.len().next_power_of_two().max(64);
        self.days.resize(days, NOWHERE);
        self.busy.resize(days / 64, 0);
        self.rate = rate;
        self.today = (now * rate) as u64;
        self.examined.0 = self.today;
        entries.retain(|entry| {
            let day = self.day_of(entry.key);
            !(self.is_later(day) && self.note(day, *entry))
        });
        let busy: u32 = self.busy.iter().map(|days| days.count_ones()).sum();
        if self.len as u64 > u64::from(busy) * MAX_EVENTS_A_DAY {
            self.end(entries);
        }
    }
}
