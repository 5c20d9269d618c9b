//! Values and times of plans in words.

use crate::cli::console::count;
use crate::line::trace::{duration, duration_in_units};
use crate::recipe::plan::{Execution, Objective, Plan};
use crate::report::html::parts::figure;

/// Nanoseconds in a second, and microjoules in a joule.
pub(super) const NANOSECONDS: f64 = 1e9;
const MICROJOULES: f64 = 1e6;

/// Joules in a watt-hour and in a kilowatt-hour.
const WATT_HOUR: f64 = 3600.0;
const KILOWATT_HOUR: f64 = 3.6e6;

/// A value in the unit of the documents: steps, seconds, joules or transfers.
pub(in crate::cli::recipe) fn number(objective: Objective, value: i64) -> f64 {
    let value = value as f64;
    match objective {
        Objective::Steps | Objective::Transfers => value,
        Objective::Time => value / NANOSECONDS,
        Objective::Energy => value / MICROJOULES,
    }
}

/// A value with its unit: `41 steps`, `1 min 21 s`, `2.42 Wh`, `14 transfers`.
pub(in crate::cli::recipe) fn value(objective: Objective, value: i64) -> String {
    let number = number(objective, value);
    match objective {
        Objective::Steps => count(number as usize, "step"),
        Objective::Transfers => count(number as usize, "transfer"),
        Objective::Time => duration_in_units(number),
        Objective::Energy => {
            let (unit, name) = if number < WATT_HOUR {
                (1.0, "J")
            } else if number < KILOWATT_HOUR {
                (WATT_HOUR, "Wh")
            } else {
                (KILOWATT_HOUR, "kWh")
            };
            format!("{} {name}", figure(number / unit))
        }
    }
}

/// A time of a plan in the unit of the documents: steps or seconds.
pub(super) fn time(plan: &Plan, time: i64) -> f64 {
    match plan.execution() {
        Execution::Lockstep => time as f64,
        Execution::Timed => time as f64 / NANOSECONDS,
    }
}

/// An instant in a table, in seconds: `68 s`, `7200.5 s`. From 1 s on, it is rounded to ms.
pub(in crate::cli::recipe) fn instant(nanoseconds: i64) -> String {
    if nanoseconds < 1_000_000_000 {
        return duration(nanoseconds as f64 / NANOSECONDS);
    }
    let milliseconds = (nanoseconds + 500_000) / 1_000_000;
    let digits = format!("{}.{:03}", milliseconds / 1000, milliseconds % 1000);
    format!("{} s", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// How much of a value is above its lower bound, from 0 to 1.
pub(super) fn gap(plan: &Plan) -> f64 {
    if plan.value > 0 {
        (plan.value - plan.lower_bound) as f64 / plan.value as f64
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_a_unit_that_shows_them() {
        for (objective, raw, wanted) in [
            (Objective::Steps, 1, "1 step"),
            (Objective::Time, 81_000_000_000, "1 min 21 s"),
            (Objective::Energy, 450_000_000, "450 J"),
            (Objective::Energy, 8_700_000_000, "2.42 Wh"),
            (Objective::Energy, 7_200_000_000_000, "2 kWh"),
            (Objective::Transfers, 14, "14 transfers"),
        ] {
            assert_eq!(value(objective, raw), wanted);
        }
    }

    #[test]
    fn instants_keep_their_milliseconds() {
        for (nanoseconds, wanted) in [
            (0, "0 s"),
            (2_500_000, "2.5 ms"),
            (5_000_000_000, "5 s"),
            (100_500_000_000, "100.5 s"),
            (3_600_333_333_333, "3600.333 s"),
        ] {
            assert_eq!(instant(nanoseconds), wanted);
        }
    }
}
