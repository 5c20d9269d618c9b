//! Comparison of a line with a variant of it, under common random numbers.
//!
//! Both are run with the same seeds. Each random quantity has a stream of its own (see
//! [`random`](super::random)), so that both get the same arrivals, defects and failures as far as
//! they draw as many. The differences of the pairs vary less than the runs do, and their paired t
//! interval is narrower than one from independent runs (Law, "Simulation Modeling and Analysis",
//! sections 10.2.1 and 11.2).

use super::metric::measure;
use super::replicate::Estimate;
use super::trace::Trace;
use linewright_language::contract::metric::Measure;

/// The measures that are compared.
pub const COMPARED: [Measure; 9] = [
    Measure::Throughput,
    Measure::ThroughputOnShift,
    Measure::LeadTime,
    Measure::LeadTimePercentile,
    Measure::Wip,
    Measure::Makespan,
    Measure::Rejected,
    Measure::Energy,
    Measure::EnergyPerProduct,
];

/// A measure of the line and of its variant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub measure: Measure,
    /// Number of pairs of runs in which both could be measured.
    pub pairs: usize,
    /// Mean of the line as it is, in the unit of the measure.
    pub as_it_is: f64,
    /// Mean of the variant.
    pub what_if: f64,
    /// The variant minus the line as it is, with a paired t interval.
    pub difference: Estimate,
}

impl Comparison {
    /// Whether the interval of the difference excludes 0; `None` without an interval.
    pub fn is_significant(&self) -> Option<bool> {
        let half = self.difference.half_width?;
        Some(self.difference.mean.abs() > half)
    }
}

/// Compares runs of a line with runs of its variant, in pairs of the same seed. Runs without a
/// partner do not count. The throughput on shift is compared if the line has a calendar.
pub fn compare(as_it_is: &[Trace], what_if: &[Trace]) -> Vec<Comparison> {
    let pairs: Vec<(&Trace, &Trace)> = as_it_is
        .iter()
        .filter_map(|one| Some((one, what_if.iter().find(|other| other.seed == one.seed)?)))
        .collect();
    let has_calendar = as_it_is.iter().any(|t| t.throughput_on_shift.is_some());
    COMPARED
        .iter()
        .filter(|measure| **measure != Measure::ThroughputOnShift || has_calendar)
        .filter_map(|compared| {
            let metric = (*compared).into();
            let values: Vec<(f64, f64)> = pairs
                .iter()
                .filter_map(|(one, other)| {
                    Some((measure(&metric, *one)?, measure(&metric, *other)?))
                })
                .collect();
            let of = |value: fn(&(f64, f64)) -> f64| {
                Estimate::of(&values.iter().map(value).collect::<Vec<_>>())
            };
            Some(Comparison {
                measure: *compared,
                pairs: values.len(),
                as_it_is: of(|pair| pair.0)?.mean,
                what_if: of(|pair| pair.1)?.mean,
                difference: of(|pair| pair.1 - pair.0)?,
            })
        })
        .collect()
}
