//! Accumulating conveyors, that is, conveyors without a contract.
//!
//! Parts are not moved from place to place. The times at which parts come on and off describe a
//! belt of `n` places with a period of `d` seconds per place exactly:
//!
//! - A part needs at least `n d` seconds from end to end.
//! - A part comes off at least `d` seconds after the part ahead of it, because it follows that part
//!   at a distance of at least one pitch.
//! - A part can come on if fewer than `n` parts are on the belt and `d` seconds have passed since
//!   the part ahead of it came on. By then, that part has moved up by one pitch: nothing has
//!   stopped it, because fewer than `n` parts were ahead of it.
//! - When the first part leaves, all parts that had closed up start moving together.

use super::{Event, Place, Run, WORK};
use crate::plant::part::PartIndex;
use crate::statistics::Level;
use std::collections::VecDeque;

/// State of a conveyor.
#[derive(Debug)]
pub(super) struct Conveyor {
    /// Number of places, and seconds per place.
    places: usize,
    period: f64,
    /// Parts, the first to leave in front, each with the time at which it would reach the end if
    /// its way were free.
    pub parts: VecDeque<(PartIndex, f64)>,
    /// Time at which the next part can come on.
    opens: f64,
    /// Time at which the next part can come off.
    closes: f64,
    /// Whether the event for the first part's arrival is scheduled, and whether that for the first
    /// place is.
    arriving: bool,
    reopening: bool,
    /// Time until which something moves; moving time has been counted up to `booked`.
    moving_until: f64,
    booked: f64,
    moving_seconds: f64,
    pub carried: u64,
    /// Number of parts over time.
    pub level: Level,
}

impl Conveyor {
    /// Creates a conveyor with this number of places, and seconds per place.
    pub(super) fn new(places: usize, period: f64) -> Self {
        Self {
            places,
            period,
            parts: VecDeque::new(),
            opens: 0.0,
            closes: 0.0,
            arriving: false,
            reopening: false,
            moving_until: 0.0,
            booked: 0.0,
            moving_seconds: 0.0,
            carried: 0,
            level: Level::new(places as u32),
        }
    }

    /// Whether a part can come on at `now`.
    pub(super) fn admits(&self, now: f64) -> bool {
        self.parts.len() < self.places && now >= self.opens
    }

    /// Whether there is a part on each place.
    pub(super) fn is_full(&self) -> bool {
        self.parts.len() >= self.places
    }

    /// The first part has left.
    pub(super) fn left(&mut self, now: f64) {
        self.book(now);
        self.parts.pop_front();
        self.level.decrease(now);
        self.carried += 1;
        self.closes = now + self.period;
        // Without the part that left, the remaining parts can move up by one more pitch.
        self.moving_until = if self.parts.is_empty() {
            now
        } else {
            self.moving_until.max(now) + self.period
        };
    }

    /// Counts the time in which something moved.
    fn book(&mut self, now: f64) {
        self.moving_seconds = self.moving_seconds(now);
        self.booked = now;
    }

    /// Forgets what has been counted.
    pub(super) fn forget(&mut self, now: f64) {
        self.book(now);
        self.moving_seconds = 0.0;
        self.carried = 0;
        self.level.forget(now);
    }

    /// Seconds in which something moved, up to `now`.
    pub(super) fn moving_seconds(&self, now: f64) -> f64 {
        self.moving_seconds + (self.moving_until.min(now) - self.booked).max(0.0)
    }
}

impl Run<'_> {
    pub(super) fn conveyor_arrival(&mut self, node: usize, part: PartIndex) {
        let now = self.now;
        let Place::Conveyor(conveyor) = &mut self.nodes[node].place else {
            return;
        };
        let (places, period) = (conveyor.places, conveyor.period);
        conveyor.book(now);
        conveyor.level.increase(now);
        let ahead = conveyor.parts.len();
        conveyor.moving_until = conveyor
            .moving_until
            .max(now + (places - ahead.min(places)) as f64 * period);
        conveyor.opens = now + period;
        conveyor
            .parts
            .push_back((part, now + places as f64 * period));
        if ahead == 0 {
            self.look_at(node);
        }
    }

    /// Returns the first part if it has reached the end; otherwise schedules its arrival.
    pub(super) fn conveyor_end(&mut self, node: usize) -> Option<PartIndex> {
        let now = self.now;
        let Place::Conveyor(conveyor) = &mut self.nodes[node].place else {
            return None;
        };
        let &(part, arrival) = conveyor.parts.front()?;
        let arrival = arrival.max(conveyor.closes);
        if arrival <= now {
            return Some(part);
        }
        if !std::mem::replace(&mut conveyor.arriving, true) {
            self.schedule(arrival, WORK, Event::Arrival(node as u32));
        }
        None
    }

    pub(super) fn arrival(&mut self, node: usize) {
        if let Place::Conveyor(conveyor) = &mut self.nodes[node].place {
            conveyor.arriving = false;
        }
        self.look_at(node);
    }

    /// Ensures that waiting parts are let on as soon as the first place is free.
    pub(super) fn reopen_later(&mut self, node: usize) {
        let now = self.now;
        if self.nodes[node].requests.is_empty() {
            return;
        }
        let Place::Conveyor(conveyor) = &mut self.nodes[node].place else {
            return;
        };
        let has_room = conveyor.parts.len() < conveyor.places;
        if has_room && now < conveyor.opens && !conveyor.reopening {
            conveyor.reopening = true;
            let opens = conveyor.opens;
            self.schedule(opens, WORK, Event::Reopen(node as u32));
        }
    }

    pub(super) fn reopen(&mut self, node: usize) {
        if let Place::Conveyor(conveyor) = &mut self.nodes[node].place {
            conveyor.reopening = false;
        }
        self.look_at(node);
    }
}
