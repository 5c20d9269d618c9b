//! Moments of a run as texts: clock times, with weekdays and dates if the line has them.
//!
//! The script of the page writes them in the same way, so both change together.

use crate::html::numbers::{instants, time_marks};
use linewright_language::contract::date::{WEEKDAYS, format_date, weekday};
use linewright_language::contract::line::Line;
use linewright_line::trace::clock;

const DAY: f64 = 86_400.0;

/// How the moments of a line are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Moments {
    /// As the time since the start, since the line has no calendar.
    Elapsed,
    /// With the weekday. The run starts on this one, 0 for Monday.
    Weekdays(u8),
    /// With weekday and date. The run starts on this day, in days since 1970-01-01.
    Dates(i64),
}

impl Moments {
    pub fn of(line: &Line) -> Self {
        if let Some(day) = line.first_day {
            return Self::Dates(day);
        }
        let of_stations = (0..line.nodes.len()).filter_map(|node| line.calendar_of(node));
        let calendar = line.calendar.iter().chain(of_stations).next();
        calendar.map_or(Self::Elapsed, |calendar| {
            Self::Weekdays(calendar.first_weekday)
        })
    }

    /// The day on which a moment is, such as `Mon 5 Jan`; `None` for a line without a calendar.
    fn day(self, seconds: f64) -> Option<String> {
        let day = (seconds / DAY).floor() as i64;
        let name = |number: i64| &WEEKDAYS[number.rem_euclid(7) as usize][..3];
        match self {
            Self::Elapsed => None,
            Self::Weekdays(first) => {
                let name = name(i64::from(first) + day);
                Some(if day < 7 {
                    name.to_owned()
                } else {
                    format!("{name} week {}", day / 7 + 1)
                })
            }
            Self::Dates(first) => {
                let date = format_date(first + day);
                let mut numbers = date.split('-').skip(1).filter_map(|n| n.parse().ok());
                let month: usize = numbers.next().unwrap_or(1);
                let of_month = numbers.next().unwrap_or(1);
                let name = name(i64::from(weekday(first + day)));
                Some(format!("{name} {of_month} {}", MONTHS[(month - 1) % 12]))
            }
        }
    }

    /// A moment: `Mon 5 Jan 6:28:05`, or only `6:28:05`.
    pub fn instant(self, seconds: f64) -> String {
        // The day is that of the second to which the clock is rounded.
        let seconds = seconds.round();
        match self.day(seconds) {
            Some(day) => format!("{day} {}", clock(seconds.rem_euclid(DAY))),
            None => clock(seconds),
        }
    }

    /// Round marks of time from 0 up to `seconds`, some `count` of them, with their texts: days,
    /// and clock times between them.
    pub fn marks(self, seconds: f64, count: usize) -> Vec<(f64, String)> {
        let (marks, step) = instants(seconds, count);
        if self == Self::Elapsed || step < 1.0 {
            return time_marks(seconds, count);
        }
        let text = |at: f64| {
            let of_day = at.rem_euclid(DAY);
            let text = clock(of_day);
            match text.strip_suffix(":00") {
                _ if of_day <= 0.0 => self.day(at).unwrap_or(text),
                Some(short) if step >= 60.0 => short.to_owned(),
                _ => text,
            }
        };
        marks.into_iter().map(|at| (at, text(at))).collect()
    }
}

const MONTHS: [&str; 12] = [
    "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_have_days() {
        for (moments, seconds, wanted) in [
            (Moments::Elapsed, 97_205.0, "27:00:05"),
            (Moments::Weekdays(0), 97_205.0, "Tue 3:00:05"),
            (Moments::Weekdays(0), 86_399.7, "Tue 0:00:00"),
            (Moments::Weekdays(6), 8.0 * DAY, "Mon week 2 0:00:00"),
            // 2026-02-28 is a Saturday.
            (Moments::Dates(20_512), 97_205.0, "Sun 1 Mar 3:00:05"),
        ] {
            assert_eq!(moments.instant(seconds), wanted);
        }
    }

    #[test]
    fn marks_of_an_axis_are_days_and_hours() {
        let texts = |moments: Moments, seconds: f64| {
            let marks = moments.marks(seconds, 8).into_iter();
            marks.map(|(_, text)| text).collect::<Vec<_>>()
        };
        let monday = Moments::Dates(20_458);
        assert_eq!(
            texts(monday, 2.0 * DAY)[..5],
            ["Mon 5 Jan", "6:00", "12:00", "18:00", "Tue 6 Jan"]
        );
        assert_eq!(
            texts(Moments::Weekdays(0), 7.0 * DAY)[..3],
            ["Mon", "Tue", "Wed"]
        );
        assert_eq!(texts(monday, 60.0)[..2], ["Mon 5 Jan", "0:00:10"]);
        assert_eq!(texts(Moments::Elapsed, 7200.0)[..2], ["0 min", "15 min"]);
    }
}
