//! Texts as values of the types of XML Schema.

use super::table::{Builtin, TextType};
use std::borrow::Cow;

/// Maximum number of digits of a decimal: XML Schema demands that every processor takes as many.
const MAX_DIGITS: usize = 18;
/// Seconds of a day.
const DAY: f64 = 86_400.0;
/// Maximum number of digits before the point of a number in a duration.
const MAX_DURATION_DIGITS: usize = 9;

impl TextType {
    /// Returns whether a text is a value of the type.
    pub(super) fn accepts(&self, text: &str) -> bool {
        let is_listed =
            |value: &str| self.values.is_empty() || self.values.iter().any(|v| v == value);
        self.base.accepts(text) && is_listed(&self.base.normalized(text))
    }
}

impl Builtin {
    /// Returns a text with its white space as the type treats it.
    fn normalized(self, text: &str) -> Cow<'_, str> {
        match self {
            Self::String => Cow::Borrowed(text),
            Self::NormalizedString => replaced(text),
            _ => Cow::Borrowed(collapsed(text)),
        }
    }

    /// Returns whether a text is a value of the type.
    pub(super) fn accepts(self, text: &str) -> bool {
        match self {
            Self::String | Self::NormalizedString => true,
            Self::Boolean => matches!(collapsed(text), "true" | "false" | "1" | "0"),
            Self::Decimal => is_decimal(collapsed(text)),
            Self::DateTime => is_date_time(collapsed(text)).is_some(),
            Self::TimeSpan => duration_seconds(text).is_some(),
            Self::Language => is_language(collapsed(text)),
            Self::AnyUri => is_uri(collapsed(text)),
        }
    }

    /// Returns what the type is called in a message.
    pub(super) fn description(self) -> &'static str {
        match self {
            Self::String | Self::NormalizedString => "a text",
            Self::Boolean => "`true` or `false`",
            Self::Decimal => "a decimal number of at most 18 digits",
            Self::DateTime => "a date and time such as `2026-11-30T12:00:00Z`",
            Self::TimeSpan => "a duration such as `PT12S`",
            Self::Language => "a language such as `en`",
            Self::AnyUri => "a URI",
        }
    }
}

/// Returns a text with tabs and line ends as spaces.
pub(crate) fn replaced(text: &str) -> Cow<'_, str> {
    if text.contains(['\t', '\n', '\r']) {
        Cow::Owned(text.replace(['\t', '\n', '\r'], " "))
    } else {
        Cow::Borrowed(text)
    }
}

/// Returns a text without white space at its ends. No value of the types that collapse white space
/// has any inside.
fn collapsed(text: &str) -> &str {
    text.trim_matches([' ', '\t', '\n', '\r'])
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

fn is_decimal(text: &str) -> bool {
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    let (whole, fraction) = unsigned.split_once('.').unwrap_or((unsigned, ""));
    let parts = [whole, fraction]
        .iter()
        .all(|p| p.is_empty() || is_digits(p));
    parts && (1..=MAX_DIGITS).contains(&(whole.len() + fraction.len()))
}

fn is_language(text: &str) -> bool {
    let mut words = text.split('-');
    let first = words.next().unwrap_or_default();
    let short = |w: &str| (1..=8).contains(&w.len());
    short(first)
        && first.bytes().all(|b| b.is_ascii_alphabetic())
        && words.all(|w| short(w) && w.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// Returns whether a text is a reference of RFC 3986 without brackets, which are for addresses of
/// IPv6 only. A port that is not a number, or a scheme that is not a name, is refused.
fn is_uri(text: &str) -> bool {
    let bytes = text.as_bytes();
    let allowed = |b: u8| b.is_ascii_alphanumeric() || b"-._~:/?#@!$&'()*+,;=%".contains(&b);
    let escapes = (0..bytes.len()).filter(|at| bytes[*at] == b'%');
    let escaped = |at: usize| {
        let digits = bytes.get(at + 1..at + 3);
        digits.is_some_and(|d| d.iter().all(u8::is_ascii_hexdigit))
    };
    if !bytes.iter().all(|b| allowed(*b)) || !escapes.clone().all(escaped) {
        return false;
    }
    let Some((before, _)) = text.split_once(':') else {
        return text.bytes().filter(|b| *b == b'#').count() < 2 && !text.starts_with("//");
    };
    let scheme = before
        .bytes()
        .all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    let rest = &text[before.len() + 1..];
    let host = rest
        .strip_prefix("//")
        .map(|r| r.split(['/', '?', '#']).next());
    let host = host.flatten().unwrap_or("plain");
    scheme
        && before.starts_with(|c: char| c.is_ascii_alphabetic())
        && !host.is_empty()
        && host
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || b"-.".contains(&b))
        && text.bytes().filter(|b| *b == b'#').count() < 2
        && !rest.is_empty()
}

/// Checks a date and time of the years 0001 to 9999.
fn is_date_time(text: &str) -> Option<()> {
    let (date, time) = text.split_once('T')?;
    let mut parts = date.split('-');
    let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() {
        return None;
    }
    let number = |text: &str, digits: usize| -> Option<u32> {
        let right = text.len() == digits && is_digits(text);
        right.then(|| text.parse().ok()).flatten()
    };
    let (year, month, day) = (number(year, 4)?, number(month, 2)?, number(day, 2)?);
    if year == 0 || !(1..=12).contains(&month) || !(1..=days_of(year, month)).contains(&day) {
        return None;
    }
    let (time, zone) = match time.find(['Z', '+', '-']) {
        Some(at) => time.split_at(at),
        None => (time, ""),
    };
    let mut parts = time.split(':');
    let (hour, minute) = (number(parts.next()?, 2)?, number(parts.next()?, 2)?);
    let second = parts.next()?;
    let (second, fraction) = second.split_once('.').unwrap_or((second, "0"));
    let second = number(second, 2)?;
    let is_time = hour < 24 && minute < 60 && second < 60;
    let fits = is_digits(fraction) && fraction.len() <= MAX_DIGITS;
    if parts.next().is_some() || !fits || !is_time {
        return None;
    }
    if let Some(zone) = zone.strip_prefix(['+', '-']) {
        let (hours, minutes) = zone.split_once(':')?;
        let (hours, minutes) = (number(hours, 2)?, number(minutes, 2)?);
        return (minutes < 60 && hours * 60 + minutes <= 14 * 60).then_some(());
    }
    matches!(zone, "" | "Z").then_some(())
}

/// Returns the number of days of a month.
fn days_of(year: u32, month: u32) -> u32 {
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Returns a duration in s, if the text is one. It is not known how long years and months are: 365
/// and 30 days are taken, and [`has_calendar_units`] says whether that matters.
pub(crate) fn duration_seconds(text: &str) -> Option<f64> {
    let text = collapsed(text);
    let (sign, text) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text),
    };
    let text = text.strip_prefix('P')?;
    let (date, time) = match text.split_once('T') {
        Some((_, "")) => return None,
        Some((date, time)) => (date, time),
        None => (text, ""),
    };
    if date.is_empty() && time.is_empty() {
        return None;
    }
    let date = sum(date, &[('Y', 365.0 * DAY), ('M', 30.0 * DAY), ('D', DAY)])?;
    let time = sum(time, &[('H', 3_600.0), ('M', 60.0), ('S', 1.0)])?;
    Some(sign * (date + time))
}

/// Adds numbers with units, which are in their order. Only seconds may have a fraction.
fn sum(mut text: &str, units: &[(char, f64)]) -> Option<f64> {
    let mut total = 0.0;
    for (unit, seconds) in units {
        let Some(at) = text.find(|c: char| !c.is_ascii_digit() && c != '.') else {
            break;
        };
        if !text[at..].starts_with(*unit) {
            continue;
        }
        let number = &text[..at];
        let (whole, fraction) = number.split_once('.').unwrap_or((number, "0"));
        let is_right =
            is_digits(whole) && is_digits(fraction) && whole.len() <= MAX_DURATION_DIGITS;
        if !is_right || (number.contains('.') && *unit != 'S') {
            return None;
        }
        total += number.parse::<f64>().ok()? * seconds;
        text = &text[at + 1..];
    }
    text.is_empty().then_some(total)
}

/// Returns whether a duration counts years or months, whose length depends on the calendar.
pub(crate) fn has_calendar_units(text: &str) -> bool {
    let date = text.split('T').next().unwrap_or_default();
    date.contains(['Y', 'M'])
}

/// Returns a number of s as a duration, if it has at most 9 digits before the point and is not
/// negative. The number is exact.
pub(crate) fn seconds_as_duration(seconds: f64) -> Option<String> {
    (0.0..1e9)
        .contains(&seconds)
        .then(|| format!("PT{seconds}S"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(of: Builtin, right: &[&str], wrong: &[&str]) {
        for text in right {
            assert!(of.accepts(text), "{of:?} {text:?}");
        }
        for text in wrong {
            assert!(!of.accepts(text), "{of:?} {text:?}");
        }
    }

    #[test]
    fn values_are_told_from_others() {
        check(
            Builtin::Decimal,
            &[
                "1",
                " +1.50\n",
                "-.5",
                "5.",
                "123456789012345678",
                "0.00000000000000001",
            ],
            &["", ".", "1e3", "1,5", "--1", "1234567890123456789", "INF"],
        );
        check(
            Builtin::DateTime,
            &[
                "2016-11-24T12:38:50Z",
                "2024-02-29T00:00:00.25+14:00",
                "2000-02-29T23:59:59",
            ],
            &[
                "2016-11-24",
                "2023-02-29T00:00:00",
                "1900-02-29T00:00:00",
                "2016-13-01T00:00:00",
                "2016-11-24T24:00:01",
                "2016-11-24T12:38",
                "2016-11-24T12:38:50+14:01",
                "2016-11-24T12:38:50.Z",
                "0000-01-01T00:00:00",
                "2016-11-24T12:38:50ZZ",
                "2016-11-24t12:38:50",
            ],
        );
        check(
            Builtin::TimeSpan,
            &["PT8S", "P1Y2M3DT4H5M6.7S", "-P1D", "PT0.5S", " P0D "],
            &[
                "", "P", "PT", "P1DT", "8S", "PT8", "P1M1Y", "PT1.5M", "PT.5S", "PT1.S", "P-1D",
            ],
        );
        check(
            Builtin::Language,
            &["en", "de-CH-1996"],
            &["", "e1", "en-", "abcdefghi", "x-123456789"],
        );
        check(
            Builtin::AnyUri,
            &[
                "",
                "http://www.mesa.org/xml/B2MML",
                "a/b?c#d",
                "urn:x:y",
                "%20",
            ],
            &[
                "%2",
                "a b",
                "http://[",
                "#a#b",
                "1:2",
                "http://a:x/",
                "//",
                ":",
            ],
        );
        check(Builtin::Boolean, &["true", " false "], &["True", "yes", ""]);
    }

    #[test]
    fn durations_have_seconds() {
        let close = |text, seconds: f64| {
            let read: f64 = duration_seconds(text).expect("it is one");
            assert!((read - seconds).abs() < 1e-9, "{text}: {read}");
        };
        close("PT1H2M3.5S", 3_723.5);
        close("P2D", 172_800.0);
        close("-PT5S", -5.0);
        for seconds in [0.0, 0.1, 12.0, 1e-7, 123_456_789.125] {
            let text = seconds_as_duration(seconds).expect("it is not too long");
            assert_eq!(
                duration_seconds(&text).map(f64::to_bits),
                Some(f64::to_bits(seconds))
            );
        }
        assert_eq!(seconds_as_duration(1e9), None);
        assert_eq!(seconds_as_duration(f64::NAN), None);
        assert!(has_calendar_units("P1M") && !has_calendar_units("PT1M"));
    }
}
