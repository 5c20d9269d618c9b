//! Durations on the command line: `3600`, `90m`, `90min`, `8h`, `1d`, `1h30m`.

/// Parses a positive duration in seconds: a plain number, or numbers each with one of the units
/// `d h m s` in descending order; `min` means `m`. Spaces may stand around a unit.
pub fn seconds(text: &str) -> Result<f64, String> {
    parse(text.trim()).ok_or_else(|| {
        let why = match text.trim().parse::<f64>() {
            Ok(number) if number <= 0.0 => "a duration is more than 0",
            _ => "write seconds (`3600`), or use units (`90m`, `8h`, `5d`, `1h30m`)",
        };
        format!("`{text}` is not a valid duration: {why}")
    })
}

fn parse(text: &str) -> Option<f64> {
    let number = |digits: &str| {
        let plain = digits.chars().all(|c| c.is_ascii_digit() || c == '.');
        let value = digits.parse::<f64>().ok()?;
        (plain && value.is_finite()).then_some(value)
    };
    // A number without a unit can have an exponent: `1e6`.
    let is_number = text.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    if is_number && let Ok(seconds) = text.parse::<f64>() {
        return (seconds > 0.0 && seconds.is_finite()).then_some(seconds);
    }
    let (mut rest, mut total, mut last) = (text, 0.0, f64::INFINITY);
    while !rest.is_empty() {
        let end = rest.find(|c: char| c.is_ascii_alphabetic())?;
        let word = &rest[end..];
        let word = &word[..word
            .find(|c: char| !c.is_ascii_alphabetic())
            .unwrap_or(word.len())];
        let unit = match word {
            "d" => 86_400.0,
            "h" => 3_600.0,
            "m" | "min" => 60.0,
            "s" => 1.0,
            _ => return None,
        };
        if unit >= last {
            return None;
        }
        total += number(rest[..end].trim())? * unit;
        last = unit;
        rest = &rest[end + word.len()..];
    }
    (total > 0.0 && total.is_finite()).then_some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_parsed() {
        for (text, wanted) in [
            ("3600", 3600.0),
            ("0.5", 0.5),
            ("1e6", 1_000_000.0),
            ("90m", 5400.0),
            ("90min", 5400.0),
            ("1h30min5s", 5405.0),
            ("8h", 28_800.0),
            ("1d", 86_400.0),
            ("1h30m", 5400.0),
            ("1.5h", 5400.0),
            ("1d2h3m4s", 93_784.0),
            ("5 d", 432_000.0),
            ("1 h 30 min", 5400.0),
        ] {
            assert_eq!(seconds(text), Ok(wanted), "{text}");
        }
    }

    #[test]
    fn other_texts_are_rejected() {
        for text in [
            "", "0", "0h", "h", "-1", "1x", "1m2h", "1h2h", "1 2h", "1h30", "nan", "inf", "1e999",
            "ü", "1hü",
        ] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
