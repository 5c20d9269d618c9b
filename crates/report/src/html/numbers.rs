//! Numbers and scales for people: thousands apart, as many digits as matter, round marks on axes.

/// A number with groups of three digits: `12,345.6`. Whole numbers have no decimal places; others
/// show three significant digits, and all digits before the point.
pub fn figure(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    let magnitude = if value == 0.0 {
        0
    } else {
        value.abs().log10().floor() as i32
    };
    let places = if value.fract() == 0.0 {
        0
    } else {
        (2 - magnitude).clamp(0, 6) as usize
    };
    let text = fixed(value, places);
    if places == 0 {
        return text;
    }
    let text = text.trim_end_matches('0');
    text.strip_suffix('.').unwrap_or(text).to_owned()
}

/// A number with the decimal places that give the half-width of its interval two significant
/// digits.
pub(super) fn rounded(value: f64, half_width: f64) -> String {
    if !(value.is_finite() && half_width.is_finite() && half_width > 0.0) {
        return figure(value);
    }
    let magnitude = half_width.log10().floor() as i32;
    fixed(value, (1 - magnitude).clamp(0, 6) as usize)
}

/// A number with this many decimal places, and groups of three digits before the point.
fn fixed(value: f64, places: usize) -> String {
    let text = format!("{:.places$}", value.abs());
    let is_negative = value < 0.0 && text.bytes().any(|digit| (b'1'..=b'9').contains(&digit));
    let sign = if is_negative { "-" } else { "" };
    match text.split_once('.') {
        Some((whole, fraction)) => format!("{sign}{}.{fraction}", grouped(whole)),
        None => format!("{sign}{}", grouped(&text)),
    }
}

/// A number with all of its digits, in groups of three before the point.
pub(super) fn exact(value: f64) -> String {
    let text = value.abs().to_string();
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let sign = if value < 0.0 { "-" } else { "" };
    let point = if fraction.is_empty() { "" } else { "." };
    format!("{sign}{}{point}{fraction}", grouped(whole))
}

/// A count with groups of three digits.
pub(super) fn count(value: u64) -> String {
    grouped(&value.to_string())
}

fn grouped(digits: &str) -> String {
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A share from 0 to 1 as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

/// Round marks from 0 up to `max`, some `count` of them.
pub(super) fn marks(max: f64, count: usize) -> Vec<f64> {
    if !(max.is_finite() && max > 0.0) {
        return vec![0.0];
    }
    let raw = max / count.max(1) as f64;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * power)
        .into_iter()
        .find(|step| *step >= raw * 0.999)
        .unwrap_or(10.0 * power);
    multiples(step, max)
}

/// Round times in seconds, from a second to two weeks.
const ROUND_TIMES: [f64; 22] = [
    1.0,
    2.0,
    5.0,
    10.0,
    15.0,
    30.0,
    60.0,
    120.0,
    300.0,
    600.0,
    900.0,
    1800.0,
    3600.0,
    7200.0,
    10_800.0,
    14_400.0,
    21_600.0,
    43_200.0,
    86_400.0,
    172_800.0,
    604_800.0,
    1_209_600.0,
];

/// The least round time in seconds that is at least `seconds` and a multiple of `unit`: 1, 2 or 5
/// times a power of ten below a minute, and parts of an hour, a day or a fortnight above. Beyond
/// that, all multiples are round.
pub(super) fn round_time(seconds: f64, unit: f64) -> f64 {
    const WEEK: f64 = 604_800.0;
    let least = seconds.max(unit) * 0.999_999;
    let is_multiple = |time: f64| {
        let count = time / unit;
        count > 0.5 && (count - count.round()).abs() < 1e-9 * count.max(1000.0)
    };
    let short = (-6..0).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
    let mut times = short.chain(ROUND_TIMES);
    let found = times.find(|time| *time >= least && is_multiple(*time));
    found.unwrap_or_else(|| {
        let step = if is_multiple(WEEK) { WEEK } else { unit };
        (least / step).ceil() * step
    })
}

/// Round marks of time from 0 up to `seconds`, some `count` of them, and their distance.
pub(super) fn instants(seconds: f64, count: usize) -> (Vec<f64>, f64) {
    let step = round_time(seconds / count.max(1) as f64 * 0.999, 1e-6);
    (multiples(step, seconds), step)
}

/// Round marks of time from 0 up to `seconds`, some `count` of them, with their texts.
pub fn time_marks(seconds: f64, count: usize) -> Vec<(f64, String)> {
    let (marks, step) = instants(seconds, count);
    let (unit, word) = if step >= 86_400.0 {
        (86_400.0, "d")
    } else if step >= 3600.0 {
        (3600.0, "h")
    } else if step >= 60.0 {
        (60.0, "min")
    } else {
        (1.0, "s")
    };
    marks
        .into_iter()
        .map(|at| (at, format!("{} {word}", figure(at / unit))))
        .collect()
}

fn multiples(step: f64, max: f64) -> Vec<f64> {
    let count = (max / step * 1.000_001).floor() as usize;
    (0..=count).map(|index| index as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_show_what_matters() {
        for (value, wanted) in [
            (0.0, "0"),
            (12_345.678, "12,346"),
            (1234.0, "1,234"),
            (17.294_117, "17.3"),
            (0.049_87, "0.0499"),
            (-0.5, "-0.5"),
            (-0.000_000_01, "0"),
            (1e6, "1,000,000"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(figure(value), wanted);
        }
        for (value, half_width, wanted) in [
            (11.7547, 0.0766, "11.755"),
            (11.7, 0.25, "11.70"),
            (-0.0004, 0.05, "0.000"),
            (1808.64, 8.2, "1,808.6"),
            (1808.64, 35.0, "1,809"),
            (17.294_117, 0.0, "17.3"),
        ] {
            assert_eq!(rounded(value, half_width), wanted);
        }
        assert_eq!(exact(1_632_096.5), "1,632,096.5");
        assert_eq!(exact(-1000.0), "-1,000");
        assert_eq!(exact(0.005), "0.005");
    }

    #[test]
    fn marks_are_round() {
        assert_eq!(marks(93.0, 5), [0.0, 20.0, 40.0, 60.0, 80.0]);
        assert_eq!(marks(0.0, 5), [0.0]);
        let of_day: Vec<String> = time_marks(86_400.0, 6)
            .into_iter()
            .map(|(_, text)| text)
            .collect();
        assert_eq!(
            of_day,
            ["0 h", "4 h", "8 h", "12 h", "16 h", "20 h", "24 h"]
        );
        let short: Vec<String> = time_marks(2.0, 4)
            .into_iter()
            .map(|(_, text)| text)
            .collect();
        assert_eq!(short, ["0 s", "0.5 s", "1 s", "1.5 s", "2 s"]);
    }

    #[test]
    fn times_are_round() {
        for (seconds, unit, wanted) in [
            (0.003, 1e-6, 0.005),
            (0.03, 0.01, 0.05),
            (13.0, 1.0, 15.0),
            (13.0, 10.0, 30.0),
            (172.8, 60.0, 300.0),
            (700.0, 600.0, 1800.0),
            (4000.0, 3600.0, 7200.0),
            (90_000.0, 86_400.0, 172_800.0),
            (1_300_000.0, 86_400.0, 1_814_400.0),
            (1_300_000.0, 864_000.0, 1_728_000.0),
        ] {
            let time = round_time(seconds, unit);
            assert!((time / wanted - 1.0).abs() < 1e-9, "{seconds}: {time}");
        }
    }
}
