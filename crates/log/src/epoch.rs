//! The date and time at which a run starts.

use linewright_language::contract::calendar::microseconds;
use linewright_language::contract::date::{days_in_month, days_since_1970, format_date};
use linewright_language::contract::line::Line;
use std::str::FromStr;

/// Microseconds of a day.
const DAY: i64 = 86_400_000_000;

/// A date and time in UTC, to which the seconds of a run are added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epoch {
    /// Microseconds since 1970-01-01.
    microseconds: i64,
}

impl Epoch {
    /// The start of a run of a line: midnight of its first day, or of Monday, 2026-01-05, if the
    /// line does not give it.
    pub fn of(line: &Line) -> Self {
        let day = line.first_day.unwrap_or(days_since_1970(2026, 1, 5));
        Self {
            microseconds: day * DAY,
        }
    }
}

impl Epoch {
    /// Returns the seconds since 1970-01-01T00:00:00Z.
    pub fn seconds(self) -> i64 {
        self.microseconds.div_euclid(1_000_000)
    }
}

impl FromStr for Epoch {
    type Err = String;

    /// Parses `2026-01-05`, `2026-01-05T06:00` or `2026-01-05T06:00:00`, each with or without `Z`.
    fn from_str(text: &str) -> Result<Self, String> {
        parse(text.trim()).ok_or_else(|| {
            format!("`{text}` is not a date with a time: write for example `2026-01-05T06:00:00`")
        })
    }
}

fn parse(text: &str) -> Option<Epoch> {
    let text = text.strip_suffix('Z').unwrap_or(text);
    let (date, time) = text.split_once('T').unwrap_or((text, "00:00"));
    let [year, month, day] = numbers(date, '-', [4, 2, 2])?;
    let whole = if time.len() == 5 {
        format!("{time}:00")
    } else {
        time.to_owned()
    };
    let [hours, minutes, seconds] = numbers(&whole, ':', [2, 2, 2])?;
    let exists = (1..=12).contains(&month) && (1..=9000).contains(&year);
    if !exists || day == 0 || day > days_in_month(year, month) {
        return None;
    }
    if hours > 23 || minutes > 59 || seconds > 59 {
        return None;
    }
    let seconds = i64::from(hours * 3600 + minutes * 60 + seconds);
    Some(Epoch {
        microseconds: days_since_1970(year, month, day) * DAY + seconds * 1_000_000,
    })
}

/// Three numbers with these numbers of digits.
fn numbers(text: &str, separator: char, digits: [usize; 3]) -> Option<[u32; 3]> {
    let mut parts = text.split(separator);
    let mut numbers = [0; 3];
    for (number, digits) in numbers.iter_mut().zip(digits) {
        let part = parts.next().filter(|part| part.len() == digits)?;
        if !part.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        *number = part.parse().ok()?;
    }
    parts.next().is_none().then_some(numbers)
}

/// Formats the moments of a run; remembers the day of the last one.
#[derive(Debug)]
pub(crate) struct Dates {
    epoch: Epoch,
    day: i64,
    text: String,
}

impl Dates {
    pub(crate) fn new(epoch: Epoch) -> Self {
        Self {
            epoch,
            day: i64::MIN,
            text: String::new(),
        }
    }

    /// Formats a moment as ISO 8601 with microseconds: `2026-01-05T06:00:00.000000Z`.
    pub(crate) fn format(&mut self, seconds: f64) -> String {
        let moment = self
            .epoch
            .microseconds
            .saturating_add(microseconds(seconds));
        let (day, rest) = (moment.div_euclid(DAY), moment.rem_euclid(DAY));
        if day != self.day {
            self.day = day;
            self.text = format_date(day);
        }
        let (whole, fraction) = (rest / 1_000_000, rest % 1_000_000);
        let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
        format!(
            "{}T{hours:02}:{minutes:02}:{seconds:02}.{fraction:06}Z",
            self.text
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_dates() {
        for (text, seconds, wanted) in [
            ("2026-01-05T06:00:00", 0.0, "2026-01-05T06:00:00.000000Z"),
            ("2026-01-05T06:00Z", 1.5, "2026-01-05T06:00:01.500000Z"),
            ("2024-02-28", 86_400.0, "2024-02-29T00:00:00.000000Z"),
            ("2026-12-31T23:59:59", 1.0, "2027-01-01T00:00:00.000000Z"),
        ] {
            let epoch = text.parse().unwrap();
            assert_eq!(Dates::new(epoch).format(seconds), wanted);
        }
    }

    #[test]
    fn other_texts_are_refused() {
        for text in [
            "",
            "2026",
            "2026-13-01",
            "2026-02-29",
            "2026-1-5",
            "2026-01-05 06:00",
            "2026-01-05T24:00",
            "2026-01-05T06:00:00+01:00",
            "+026-01-05",
            "2026-01-05T",
        ] {
            assert!(text.parse::<Epoch>().is_err(), "{text}");
        }
    }
}
