//! Dates of the Gregorian calendar, as days since 1970-01-01.

/// Names of the weekdays, by [`weekday`].
pub const WEEKDAYS: [&str; 7] = [
    "Monday",
    "Tuesday",
    "Wednesday",
    "Thursday",
    "Friday",
    "Saturday",
    "Sunday",
];

fn is_leap(year: u32) -> bool {
    year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400)
}

/// Number of days in a month.
pub fn days_in_month(year: u32, month: u32) -> u32 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01 to a date in the Gregorian calendar.
pub fn days_since_1970(year: u32, month: u32, day: u32) -> i64 {
    let before = i64::from(year) - 1;
    let years = before * 365 + before / 4 - before / 100 + before / 400;
    let months: u32 = (1..month).map(|month| days_in_month(year, month)).sum();
    // 719162 days lie between 0001-01-01 and 1970-01-01.
    years + i64::from(months + day) - 1 - 719_162
}

/// Weekday of a day since 1970-01-01, a Thursday: 0 for Monday.
pub fn weekday(day: i64) -> u8 {
    (day + 3).rem_euclid(7) as u8
}

/// Formats a day since 1970-01-01: `2026-11-30`.
pub fn format_date(day: i64) -> String {
    let mut left = day + 719_162;
    let mut year = (left / 366 + 1) as u32;
    left = day - days_since_1970(year, 1, 1);
    while left >= 365 + i64::from(is_leap(year)) {
        left -= 365 + i64::from(is_leap(year));
        year += 1;
    }
    let mut month = 1;
    while left >= i64::from(days_in_month(year, month)) {
        left -= i64::from(days_in_month(year, month));
        month += 1;
    }
    format!("{year:04}-{month:02}-{:02}", left + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_weekdays() {
        assert_eq!(days_since_1970(1970, 1, 1), 0);
        assert_eq!(days_since_1970(2000, 2, 29), 11_016);
        assert_eq!(weekday(days_since_1970(2026, 11, 30)), 0);
        assert_eq!(weekday(days_since_1970(2024, 2, 29)), 3);
        let mut expected = days_since_1970(1, 1, 1);
        for year in 1..=2400 {
            for month in 1..=12 {
                for day in 1..=days_in_month(year, month) {
                    assert_eq!(days_since_1970(year, month, day), expected);
                    if day == 1 || day > 27 {
                        let text = format!("{year:04}-{month:02}-{day:02}");
                        assert_eq!(format_date(expected), text);
                    }
                    expected += 1;
                }
            }
        }
        assert!(!is_leap(2100) && is_leap(2000) && is_leap(2028));
    }
}
