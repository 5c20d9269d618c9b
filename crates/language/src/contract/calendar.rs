//! Working calendars: when a line or a station works.
//!
//! A calendar is a weekly pattern of shifts without those of the closed days. All its moments are
//! whole microseconds, the resolution of a run's clock, so that shifts that adjoin are recognized
//! exactly. A moment as a double, in seconds, is computed in one place, `seconds`; the same
//! moment is therefore always the same double.
//!
//! No function steps through time. What happens on a day depends only on its weekday, and on
//! whether it and the day before are open: a shift ends at the latest on the day after it began.
//! Working time is therefore counted by weeks, and corrected for the days at the ends of each
//! closed period.

/// Microseconds in a second.
const MICROSECONDS: f64 = 1e6;
/// Number of days in a week.
const WEEK: i64 = 7;
/// Number of days that are searched at once for the next change. It covers each weekday, and the
/// shifts of the day before.
const WINDOW: i64 = 8;

/// When a line or station works.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkCalendar {
    /// Weekday of the day on which a run starts, at midnight: 0 for Monday, 6 for Sunday.
    pub first_weekday: u8,
    /// Shifts; work goes on while any of them does.
    pub shifts: Vec<Shift>,
    /// Periods of closed days as pairs (first day, last day), in order, with at least one open day
    /// between two of them. Day 0 is the day on which a run starts. No shift begins on a closed
    /// day.
    pub closed: Vec<(i64, i64)>,
}

/// Working hours of a day. Times are microseconds from the start of the day on which the shift
/// begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shift {
    /// Start of work, before the end of the day.
    pub from: i64,
    /// End of work, less than a day after its start, or a whole day after midnight. A shift over
    /// midnight ends after [`WorkCalendar::DAY_MICROSECONDS`].
    pub to: i64,
    /// Weekdays on which the shift begins, from Monday to Sunday.
    pub days: [bool; 7],
    /// Breaks within the shift, as pairs (start, end).
    pub breaks: Vec<(i64, i64)>,
    /// Whether stations finish the part that they have begun, when the shift or the work before a
    /// break ends.
    pub finishes_work: bool,
}

/// A moment at which work begins or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Time in seconds from the start of the run.
    pub time: f64,
    /// Whether work begins.
    pub works: bool,
    /// Whether work ends, and stations finish the part that they have begun.
    pub finishes_work: bool,
}

/// Time in which work goes on, in microseconds from the start of the run.
#[derive(Debug, Clone, Copy)]
struct Period {
    from: i64,
    to: i64,
    finishes_work: bool,
}

/// Returns a moment of a calendar in seconds.
fn seconds(microseconds: i64) -> f64 {
    microseconds as f64 / MICROSECONDS
}

/// Returns a number of seconds in whole microseconds.
pub fn microseconds(seconds: f64) -> i64 {
    (seconds * MICROSECONDS).round() as i64
}

impl Shift {
    /// A shift on all days without breaks, from and to a time of day in seconds. If it ends before
    /// it begins, it ends on the next day.
    pub fn daily(from: f64, to: f64) -> Self {
        let (from, to) = (microseconds(from), microseconds(to));
        Self {
            from,
            to: after(from, to),
            days: [true; 7],
            breaks: Vec::new(),
            finishes_work: false,
        }
    }

    /// The time of the shift without its breaks, as periods in order. Those that adjoin are united.
    fn periods(&self) -> Vec<Period> {
        let mut breaks = self.breaks.clone();
        breaks.sort_unstable();
        let mut periods = Vec::new();
        let mut from = self.from;
        for (start, end) in breaks.into_iter().chain([(self.to, self.to)]) {
            if start > from {
                periods.push(Period {
                    from,
                    to: start,
                    finishes_work: self.finishes_work,
                });
            }
            from = from.max(end);
        }
        periods
    }

    /// Working time of the shift without its breaks, in microseconds.
    pub fn working_microseconds(&self) -> i64 {
        self.periods().iter().map(|p| p.to - p.from).sum()
    }

    /// Returns whether the times of the shift are as documented.
    pub fn is_valid(&self) -> bool {
        const DAY: i64 = WorkCalendar::DAY_MICROSECONDS;
        let length = self.to - self.from;
        let breaks =
            |&(start, end): &(i64, i64)| self.from <= start && start < end && end <= self.to;
        (0..DAY).contains(&self.from)
            && (0 < length && length < DAY || (self.from, self.to) == (0, DAY))
            && self.days.contains(&true)
            && self.breaks.iter().all(breaks)
            && self.working_microseconds() > 0
    }
}

/// Returns the moment `time`, or the same time on the next day if that is not after `start`.
pub fn after(start: i64, time: i64) -> i64 {
    if time > start {
        time
    } else {
        time + WorkCalendar::DAY_MICROSECONDS
    }
}

impl WorkCalendar {
    /// Number of seconds in a day.
    pub const DAY: f64 = 86_400.0;
    /// Number of microseconds in a day.
    pub const DAY_MICROSECONDS: i64 = 86_400_000_000;

    /// A calendar of one shift on all days, from and to a time of day in seconds.
    pub fn daily(from: f64, to: f64) -> Self {
        Self {
            first_weekday: 0,
            shifts: vec![Shift::daily(from, to)],
            closed: Vec::new(),
        }
    }

    /// Returns whether the shifts and closed days are as documented.
    pub fn is_valid(&self) -> bool {
        let ordered = |pair: &[(i64, i64)]| pair[0].1 + 1 < pair[1].0;
        self.first_weekday < 7
            && !self.shifts.is_empty()
            && self.shifts.iter().all(Shift::is_valid)
            && self.closed.iter().all(|(first, last)| first <= last)
            && self.closed.windows(2).all(ordered)
    }

    /// Returns whether work goes on at this time, in seconds. At the start of a shift it does, and
    /// at the end it does not.
    pub fn works_at(&self, second: f64) -> bool {
        let day = day_of(second);
        self.periods(day - 2, day + 1)
            .iter()
            .any(|p| seconds(p.from) <= second && second < seconds(p.to))
    }

    /// Returns the first time after `second` at which work begins or ends. `None` if it goes on, or
    /// rests, for ever.
    pub fn next_change(&self, second: f64) -> Option<Change> {
        let works = self.works_at(second);
        let mut day = day_of(second);
        let mut from = second;
        loop {
            let periods = self.periods(day - 2, day + WINDOW);
            let found = if works {
                let current = periods.iter().find(|p| from < seconds(p.to));
                current.map(|p| (p.to, p.finishes_work))
            } else {
                let next = periods.iter().find(|p| from < seconds(p.from));
                next.map(|p| (p.from, false))
            };
            // A period that lasts to the end of the window, or begins there, may go on.
            let end = (day + WINDOW + 1) * Self::DAY_MICROSECONDS;
            if let Some((time, finishes_work)) = found.filter(|(time, _)| *time < end) {
                return Some(Change {
                    time: seconds(time),
                    works: !works,
                    finishes_work,
                });
            }
            // Nothing changes for more than a week. Without closed days, that lasts for ever.
            day = if works {
                let next = self.closed_from(day + WINDOW + 1)?;
                next.0 - 1
            } else {
                let next = self.closed_from(day)?;
                let inside = next.0 <= day + WINDOW && day + WINDOW <= next.1;
                if inside { next.1 } else { day + WINDOW }
            };
            from = second.max(seconds(day * Self::DAY_MICROSECONDS));
        }
    }

    /// The first period of closed days that ends on this day or later.
    fn closed_from(&self, day: i64) -> Option<(i64, i64)> {
        let index = self.closed.partition_point(|(_, last)| *last < day);
        self.closed.get(index).copied()
    }

    /// Returns the working time from the start of a run until `second`, in seconds.
    pub fn worked_until(&self, second: f64) -> f64 {
        let day = day_of(second);
        let today = second - seconds(day * Self::DAY_MICROSECONDS);
        let begun: f64 = self
            .periods_of_day(day, self.is_open(day - 1), self.is_open(day))
            .iter()
            .map(|p| (today.min(seconds(p.to)) - seconds(p.from)).max(0.0))
            .sum();
        seconds(self.worked_before(day)) + begun
    }

    /// Working time on the days before `day`, in microseconds.
    fn worked_before(&self, day: i64) -> i64 {
        // By weekday of the run, as if every day were open.
        let full: Vec<i64> = (0..WEEK).map(|d| self.worked_on(d, true, true)).collect();
        let sum = |first: i64, end: i64| -> i64 {
            let days = (end - first).max(0);
            let rest = (0..days % WEEK).map(|d| full[(first + d).rem_euclid(WEEK) as usize]);
            days / WEEK * full.iter().sum::<i64>() + rest.sum::<i64>()
        };
        let mut worked = sum(0, day);
        for &(first, last) in &self.closed {
            // The day after a closed one lacks what goes on over midnight. The first closed day
            // still has it.
            let (begin, end) = (first.max(0), (last + 2).min(day));
            if begin >= end {
                continue;
            }
            worked -= sum(begin, end);
            if begin == first {
                worked += self.worked_on(first, true, false);
            }
            if end == last + 2 {
                worked += self.worked_on(last + 1, false, true);
            }
        }
        worked
    }

    /// Working time on a day, in microseconds, if it and the day before are open or not.
    fn worked_on(&self, day: i64, open_before: bool, open: bool) -> i64 {
        let periods = self.periods_of_day(day, open_before, open);
        periods.iter().map(|p| p.to - p.from).sum()
    }

    /// Working time within a day, in microseconds from its start.
    fn periods_of_day(&self, day: i64, open_before: bool, open: bool) -> Vec<Period> {
        let mut periods = Vec::new();
        for (begins, is_open, start) in [
            (day - 1, open_before, -Self::DAY_MICROSECONDS),
            (day, open, 0),
        ] {
            if is_open {
                self.add_shifts(begins, start, &mut periods);
            }
        }
        let clipped = unite(periods).into_iter().map(|p| Period {
            from: p.from.max(0),
            to: p.to.min(Self::DAY_MICROSECONDS),
            ..p
        });
        clipped.filter(|p| p.from < p.to).collect()
    }

    /// Working time of the shifts that begin on these days: in order, with at least a microsecond
    /// between two periods.
    fn periods(&self, first: i64, last: i64) -> Vec<Period> {
        let mut periods = Vec::new();
        for day in (first..=last).filter(|day| self.is_open(*day)) {
            self.add_shifts(day, day * Self::DAY_MICROSECONDS, &mut periods);
        }
        unite(periods)
    }

    /// Adds the periods of the shifts that begin on a day that starts at this moment.
    fn add_shifts(&self, day: i64, start: i64, periods: &mut Vec<Period>) {
        let weekday = (day + i64::from(self.first_weekday)).rem_euclid(WEEK) as usize;
        for shift in self.shifts.iter().filter(|shift| shift.days[weekday]) {
            periods.extend(shift.periods().into_iter().map(|p| Period {
                from: start + p.from,
                to: start + p.to,
                ..p
            }));
        }
    }

    fn is_open(&self, day: i64) -> bool {
        self.closed_from(day).is_none_or(|(first, _)| first > day)
    }
}

/// Unites periods that overlap or adjoin. Work that ends with several of them is finished if one of
/// them says so.
fn unite(mut periods: Vec<Period>) -> Vec<Period> {
    periods.sort_unstable_by_key(|p| (p.from, p.to));
    let mut united: Vec<Period> = Vec::new();
    for period in periods {
        match united.last_mut().filter(|last| period.from <= last.to) {
            Some(last) if period.to > last.to => {
                last.to = period.to;
                last.finishes_work = period.finishes_work;
            }
            Some(last) if period.to == last.to => last.finishes_work |= period.finishes_work,
            Some(_) => {}
            None => united.push(period),
        }
    }
    united
}

/// The day that contains a time in seconds.
fn day_of(second: f64) -> i64 {
    (second / WorkCalendar::DAY).floor() as i64
}
