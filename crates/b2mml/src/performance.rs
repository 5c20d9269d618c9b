//! Performances: what a run did.

use crate::schedule::{Activity, segment_id};
use linewright_recipe::model::{Action, Demand, Layout, Part};
use linewright_recipe::plan::{Entry, EntrySubject, PartOwner};
use linewright_recipe::run::Run;

/// What was done in a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Performance {
    /// Name of the run.
    pub name: String,
    /// Name of the schedule that it carried out, if there was one.
    pub schedule: Option<String>,
    /// Time when the run started: seconds since 1970-01-01T00:00:00Z, without leap seconds. The
    /// years must be 1 to 9999.
    pub started: i64,
    /// Parts that the records name, with their types.
    pub parts: Vec<Part>,
    /// What was done, in the order of its end.
    pub records: Vec<Record>,
}

/// Something that was done.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// What, and by which resource.
    pub activity: Activity,
    /// Name of the recipe.
    pub recipe: String,
    /// Product that it was done for, such as `Hinge 3`.
    pub product: String,
    /// Identifier of the request that asked for it, if there was one.
    pub request: Option<String>,
    /// When it began, in s after the start of the run.
    pub begin: f64,
    /// When it ended, in s after the start of the run, not before it began.
    pub end: f64,
}

/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

impl Performance {
    /// Returns what a timed run did, which started at this time: a record for each operation and
    /// for each transfer. What belongs to no product counts for the first recipe.
    ///
    /// Takes time proportional to the run, and to the logarithm of its length.
    pub fn of(name: &str, layout: &Layout, demands: &[Demand], run: &Run, started: i64) -> Self {
        let mut parts: Vec<Part> = Vec::new();
        for part in demands.iter().flat_map(|d| &d.recipe.parts) {
            if !parts.iter().any(|p| p.name == part.name) {
                parts.push(part.clone());
            }
        }
        let events = run.entries.chunk_by(|a, b| a.event == b.event);
        let recorder = Recorder { layout, demands };
        let mut records: Vec<Record> = events.flat_map(|e| recorder.records(e)).collect();
        records.sort_by(|a, b| a.end.total_cmp(&b.end));
        Self {
            name: name.to_owned(),
            schedule: None,
            started,
            parts,
            records,
        }
    }
}

/// What the entries of a run are about.
struct Recorder<'a> {
    layout: &'a Layout,
    demands: &'a [Demand],
}

impl Recorder<'_> {
    fn action(&self, entry: &Entry) -> &Action {
        &self.layout.resources[entry.resource].transitions[entry.transition].action
    }

    fn resource(&self, entry: &Entry) -> String {
        self.layout.resources[entry.resource].name.clone()
    }

    /// Returns the demand of a product.
    fn demand(&self, product: usize) -> Option<&Demand> {
        let mut first = 0;
        self.demands.iter().find(|demand| {
            first += demand.count;
            product < first
        })
    }

    /// Returns the records of an event: one for each operation, or one for both sides of a
    /// transfer.
    fn records(&self, event: &[Entry]) -> Vec<Record> {
        let gives = |e: &&Entry| matches!(self.action(e), Action::Out(_));
        let taker = event.iter().find(|e| !gives(e));
        if let (Some(giver), Some(taker)) = (event.iter().find(gives), taker) {
            let (part, owner) = match &giver.subject {
                EntrySubject::Part(part) => (Some(part.name.clone()), Some(part.owner)),
                EntrySubject::Operation { .. } | EntrySubject::Internal => (None, None),
            };
            let product = match owner {
                Some(PartOwner::Product(product)) => Some(product),
                _ => None,
            };
            let activity = Activity::Transfer {
                from: self.resource(giver),
                to: self.resource(taker),
                label: self.action(giver).label().unwrap_or_default().to_owned(),
                part,
            };
            return vec![self.record(activity, product, giver.start, taker.end)];
        }
        let records = event.iter().filter_map(|entry| {
            let (activity, product) = self.activity(entry)?;
            Some(self.record(activity, product, entry.start, entry.end))
        });
        records.collect()
    }

    /// Returns an operation, with its product if it has one.
    fn activity(&self, entry: &Entry) -> Option<(Activity, Option<usize>)> {
        let resource = self.resource(entry);
        match (&entry.subject, self.action(entry)) {
            (
                EntrySubject::Operation {
                    product,
                    transition,
                    step,
                    call,
                },
                _,
            ) => {
                let about = &self.demand(*product)?.recipe.transitions[*transition];
                let activity = Activity::Operation {
                    resource: Some(resource),
                    call: about.steps[*step].operations[*call].clone(),
                    segment: segment_id(*transition, *step, *call),
                };
                Some((activity, Some(*product)))
            }
            (_, Action::Internal(name)) => {
                let name = name.clone();
                Some((Activity::Internal { resource, name }, None))
            }
            _ => None,
        }
    }

    fn record(&self, activity: Activity, product: Option<usize>, begin: i64, end: i64) -> Record {
        let demand = product.map_or(self.demands.first(), |p| self.demand(p));
        let recipe = demand.map_or_else(String::new, |d| d.recipe.name.clone());
        Record {
            activity,
            product: product.map_or_else(String::new, |p| format!("{recipe} {}", p + 1)),
            recipe,
            request: None,
            begin: begin as f64 / NANOSECONDS,
            end: end as f64 / NANOSECONDS,
        }
    }
}

/// Seconds of a day.
const DAY: i64 = 86_400;
/// First and last second of the years that a date can have.
const YEARS: std::ops::RangeInclusive<i64> = -62_135_596_800..=253_402_300_799;

/// Returns a time as `2026-11-30T12:00:00.250Z`, to the millisecond. `None` if it is not in the
/// years 1 to 9999.
pub(crate) fn date_time(started: i64, seconds: f64) -> Option<String> {
    let milliseconds = (seconds * 1e3).round();
    if !milliseconds.is_finite() || milliseconds.abs() > 1e15 {
        return None;
    }
    let milliseconds = milliseconds as i64;
    let time = started.checked_add(milliseconds.div_euclid(1_000))?;
    let millisecond = milliseconds.rem_euclid(1_000);
    if !YEARS.contains(&time) {
        return None;
    }
    let (year, month, day) = civil(time.div_euclid(DAY));
    let second = time.rem_euclid(DAY);
    let (hour, minute, second) = (second / 3_600, second / 60 % 60, second % 60);
    let fraction = match millisecond {
        0 => String::new(),
        _ => format!(".{millisecond:03}"),
    };
    let date = format!("{year:04}-{month:02}-{day:02}");
    Some(format!(
        "{date}T{hour:02}:{minute:02}:{second:02}{fraction}Z"
    ))
}

/// Returns year, month and day of a day since 1970-01-01 in the Gregorian calendar.
///
/// Years are counted from March, so that the day of a leap year is their last; 400 of them have
/// 146,097 days. The months from March on have 153 days in each group of five.
fn civil(day: i64) -> (i64, i64, i64) {
    let since_march = day + 719_468; // from 0000-03-01
    let era = since_march.div_euclid(146_097);
    let of_era = since_march.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = (month_from_march + 2) % 12 + 1;
    let year = era * 400 + year_of_era + i64::from(month <= 2);
    (year, month, day)
}

/// Returns the seconds from 1970-01-01T00:00:00Z to a date and time as [`date_time`] writes them,
/// without their fraction.
pub(crate) fn seconds_of(text: &str) -> Option<i64> {
    let number = |range: std::ops::Range<usize>| text.get(range)?.parse::<i64>().ok();
    let (year, month, day) = (number(0..4)?, number(5..7)?, number(8..10)?);
    let (hour, minute, second) = (number(11..13)?, number(14..16)?, number(17..19)?);
    let zone = text
        .get(19..)?
        .trim_start_matches(|c: char| c == '.' || c.is_ascii_digit());
    if !matches!(zone, "" | "Z") {
        return None;
    }
    let from_march = year - i64::from(month <= 2);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days = from_march * 365 + from_march.div_euclid(4) - from_march.div_euclid(100)
        + from_march.div_euclid(400)
        + of_year
        - 719_468;
    Some(days * DAY + hour * 3_600 + minute * 60 + second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (started, seconds, text) in [
            (0, 0.0, "1970-01-01T00:00:00Z"),
            (951_782_400, 0.25, "2000-02-29T00:00:00.250Z"),
            (-1, 0.0, "1969-12-31T23:59:59Z"),
            (1_796_040_000, 3_661.999_6, "2026-11-30T13:01:02Z"),
            (4_107_542_399, 1.0, "2100-03-01T00:00:00Z"),
            (-62_135_596_800, 0.0, "0001-01-01T00:00:00Z"),
        ] {
            assert_eq!(date_time(started, seconds).as_deref(), Some(text));
        }
        assert_eq!(date_time(253_402_300_799, 1.0), None);
        assert_eq!(date_time(0, f64::INFINITY), None);
        assert_eq!(date_time(i64::MAX, 1.0), None);
    }

    /// Each day of 800 years, one after the other.
    #[test]
    fn days_follow_each_other() {
        let mut last = civil(-200_000);
        for day in -199_999..93_000 {
            let next = civil(day);
            let (year, month, of_month) = last;
            let expected = [
                (year, month, of_month + 1),
                (year, month + 1, 1),
                (year + 1, 1, 1),
            ];
            assert!(expected.contains(&next), "{last:?} {next:?}");
            let text = date_time(day * DAY, 0.0).expect("it is in the years");
            assert_eq!(seconds_of(&text), Some(day * DAY));
            last = next;
        }
    }
}
