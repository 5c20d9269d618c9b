//! Batch means: confidence intervals from one long run.
//!
//! After the warm-up, a run is cut into batches. If they are long, their means are nearly
//! independent of each other, and Student's t interval is that of the mean over all time. Some 10
//! to 30 batches suffice: more of them hardly make the interval narrower, and make the batches
//! shorter (Schmeiser, "Batch size effects in the analysis of simulation output", Operations
//! Research 30(3), 1982). Compared with replications, there is only one warm-up.
//!
//! Whether the batches are long enough is tested by von Neumann's ratio, which is the lag-1
//! autocorrelation of the batch means apart from the ends (Fishman, "Grouping observations in
//! digital simulation", Management Science 24(5), 1978).
//!
//! # What a batch gives
//!
//! Means over time are those of the batch, and so are means over parts, such as lead times. Totals
//! (products, rejected and expired parts, energy) are multiplied by the number of batches. Maxima,
//! makespan and violations are of the whole run: they have no interval. A wait of a station is
//! charged to its cause when it ends, and so belongs to the batch in which it ends; a rejected part
//! belongs to that in which it is rejected.
//!
//! Batches differ in what their means are taken over: in the number of parts, or in time if
//! products end them. The mean over all batches is therefore weighted, by parts or time, and is the
//! figure of the run. It is a ratio of two sums, and its interval that of the usual linear
//! approximation of such a ratio (Law, "Simulation Modeling and Analysis", section 9.5.3): the
//! value `v` of a batch with weight `w` counts as `r + w (v - r) / w'`, where `r` is the weighted
//! mean and `w'` the mean weight. Only percentiles are means of the batches, not those of the run.

use super::bottleneck::Bottleneck;
use super::estimates::{self, Estimated};
use super::metric::{
    Figures, JOULES_PER_KWH, measure, oee_factor, of_lead_time, of_station, yield_share,
};
use super::replicate::Estimate;
use super::requirement::{self, ReplicatedRequirement, Sample};
use super::trace::{ByState, End, LeadTime, Oee, Percentiles, Trace, WaitKind, Yields, duration};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::calendar::WorkCalendar;
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::{Measure, Metric};

/// Minimum number of batches: with fewer, the test of their correlation says nothing.
pub const MIN_BATCHES: u32 = 8;
/// Maximum number of batches.
pub const MAX_BATCHES: u32 = 1000;

/// The measures of a line by which batches are tested. The requirements have others.
pub const ESTIMATED: [Measure; 5] = [
    Measure::Throughput,
    Measure::LeadTime,
    Measure::LeadTimePercentile,
    Measure::Wip,
    Measure::Energy,
];

/// The 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.644_853_627;

/// One of the batches of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Number of batches of the run.
    pub(super) count: usize,
    /// Simulated seconds.
    pub seconds: f64,
    /// Seconds of working time; `None` if the line has no calendar.
    pub(super) on_shift_seconds: Option<f64>,
    /// Number of end products.
    pub products: u64,
    pub(super) rejected: u64,
    pub(super) yields: Yields,
    /// By part type.
    pub(super) yields_by_type: Vec<Yields>,
    pub(super) lead_time: LeadTime,
    pub(super) percentiles: Percentiles,
    /// One entry for each type of end products, if there are several.
    pub(super) by_type: Vec<ProductFigures>,
    /// Mean number of parts in the line.
    pub(super) wip: f64,
    pub(super) joules: f64,
    /// By node.
    pub(super) places: Vec<PlaceFigures>,
}

/// End products of one type in a batch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ProductFigures {
    pub part: usize,
    pub products: u64,
    pub lead_time: LeadTime,
    pub percentiles: Percentiles,
}

/// The figures of a place in a batch.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PlaceFigures {
    Station(Box<StationFigures>),
    Conveyor {
        joules: f64,
        /// Mean number of parts over time.
        length: f64,
    },
    Buffer {
        /// Number of parts that left or expired.
        waited: u64,
        /// Mean number of parts over time.
        length: f64,
        /// Share of the time in which it was full.
        full: f64,
        /// Mean waiting time in seconds of these parts.
        wait: f64,
        percentiles: Percentiles,
        expired: u64,
    },
    Source {
        /// Number of parts that left.
        passed: u64,
        /// Number of these that found no room.
        lost: u64,
    },
    Other,
}

/// The figures of a station in a batch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StationFigures {
    pub shares: ByState,
    pub oee: Option<Oee>,
    /// Planned time in seconds.
    pub planned: f64,
    /// Time in work in seconds.
    pub busy: f64,
    /// Number of parts whose work ended, or that a failure scrapped.
    pub parts: u64,
    pub joules: ByState,
    /// Waits that ended.
    pub causes: Vec<CauseTime>,
}

/// Seconds in which a station waited, by cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CauseTime {
    pub kind: WaitKind,
    /// The place (node) for which it waited.
    pub place: u32,
    /// While blocked: the station at or behind that place.
    pub station: Option<u32>,
    pub seconds: f64,
}

impl Figures for Batch {
    fn of_line(&self, metric: &Metric) -> Option<f64> {
        let of_products = |value: f64| (self.products > 0).then_some(value);
        let kwh = self.joules / JOULES_PER_KWH;
        match metric.measure {
            Measure::Throughput => self.per_hour(self.products),
            Measure::ThroughputOnShift => self.per_hour_on_shift(self.products),
            Measure::Wip => Some(self.wip),
            Measure::EnergyPerProduct => of_products(kwh / self.products as f64),
            Measure::Energy => self.in_all(kwh),
            Measure::Rejected => self.in_all(self.rejected as f64),
            Measure::FirstPassYield => self.yields.first_pass_yield(),
            Measure::Scrap => self.yields.scrap_ratio(),
            Measure::Products => self.in_all(self.products as f64),
            _ if self.products == 0 => None,
            _ => of_lead_time(metric, self.lead_time, &self.percentiles),
        }
    }

    fn of_product(&self, metric: &Metric, product: usize) -> Option<f64> {
        if let Some(share) = yield_share(metric.measure) {
            return self.yields_by_type.get(product).and_then(share);
        }
        if self.by_type.is_empty() {
            return self.of_line(metric);
        }
        let of = self.by_type.iter().find(|of| of.part == product)?;
        match metric.measure {
            Measure::Throughput => self.per_hour(of.products),
            Measure::ThroughputOnShift => self.per_hour_on_shift(of.products),
            Measure::Products => self.in_all(of.products as f64),
            _ if of.products == 0 => None,
            _ => of_lead_time(metric, of.lead_time, &of.percentiles),
        }
    }

    fn of_place(&self, metric: &Metric, node: usize) -> Option<f64> {
        match (metric.measure, self.places.get(node)?) {
            (measure, PlaceFigures::Station(station)) => match oee_factor(measure) {
                Some(factor) => station.oee.as_ref().map(factor),
                None if measure == Measure::Energy => self.in_all(station.kwh()),
                None => Some(of_station(measure, station.shares)),
            },
            (Measure::Energy, PlaceFigures::Conveyor { joules, .. }) => {
                self.in_all(joules / JOULES_PER_KWH)
            }
            (
                Measure::Length,
                PlaceFigures::Buffer { length, .. } | PlaceFigures::Conveyor { length, .. },
            ) => Some(*length),
            (Measure::Full, PlaceFigures::Buffer { full, .. }) => Some(*full),
            (Measure::Wait, PlaceFigures::Buffer { waited, wait, .. }) => {
                (*waited > 0).then_some(*wait)
            }
            (Measure::WaitPercentile, PlaceFigures::Buffer { percentiles, .. }) => {
                percentiles.get(metric.percentile)
            }
            (Measure::Expired, PlaceFigures::Buffer { expired, .. }) => {
                self.in_all(*expired as f64)
            }
            (Measure::Lost, PlaceFigures::Source { passed, lost }) => {
                (*passed > 0).then(|| *lost as f64 / *passed as f64)
            }
            _ => None,
        }
    }
}

impl StationFigures {
    fn kwh(&self) -> f64 {
        self.joules.figures().iter().sum::<f64>() / JOULES_PER_KWH
    }
}

impl Batch {
    fn per_hour(&self, products: u64) -> Option<f64> {
        (self.seconds > 0.0).then(|| products as f64 * 3600.0 / self.seconds)
    }

    fn per_hour_on_shift(&self, products: u64) -> Option<f64> {
        let seconds = self.on_shift_seconds.unwrap_or(self.seconds);
        (seconds > 0.0).then(|| products as f64 * 3600.0 / seconds)
    }

    /// The total of the run, if all batches had this one.
    #[expect(clippy::unnecessary_wraps, reason = "every figure may be missing")]
    pub(super) fn in_all(&self, total: f64) -> Option<f64> {
        Some(total * self.count as f64)
    }

    /// Over how much a metric is a mean in the batch: seconds, or a number of parts. 1 for totals.
    fn weight(&self, metric: &Metric) -> f64 {
        let products = || {
            let mut by_type = self.by_type.iter();
            let of_type = by_type.find(|of| Some(of.part) == metric.product);
            of_type.map_or(self.products, |of| of.products) as f64
        };
        let of_places = || {
            let places = metric.nodes.clone();
            let weights = places.filter_map(|node| match self.places.get(node)? {
                PlaceFigures::Buffer { waited: parts, .. }
                | PlaceFigures::Source { passed: parts, .. } => Some(*parts as f64),
                PlaceFigures::Station(station) => Some(match metric.measure {
                    Measure::Effectiveness => station.busy,
                    Measure::Quality => station.parts as f64,
                    _ => station.planned,
                }),
                _ => None,
            });
            weights.sum::<f64>()
        };
        match metric.measure {
            Measure::LeadTime
            | Measure::LeadTimeMedian
            | Measure::LeadTimePercentile
            | Measure::EnergyPerProduct => products(),
            Measure::ThroughputOnShift => self.on_shift_seconds.unwrap_or(self.seconds),
            Measure::Energy | Measure::Rejected | Measure::Products | Measure::Expired => 1.0,
            Measure::FirstPassYield | Measure::Scrap => {
                let of_product = metric.product.and_then(|of| self.yields_by_type.get(of));
                let yields = of_product.unwrap_or(&self.yields);
                (yields.finished + yields.scrapped) as f64
            }
            Measure::Wait
            | Measure::WaitPercentile
            | Measure::Lost
            | Measure::Oee
            | Measure::Availability
            | Measure::Effectiveness
            | Measure::Quality => of_places(),
            _ => self.seconds,
        }
    }
}

/// Whether a measure is of the whole run, so that batches have no values of it.
pub(super) fn is_of_run(measure: Measure) -> bool {
    matches!(
        measure,
        Measure::Makespan
            | Measure::LeadTimeMax
            | Measure::WipMax
            | Measure::Violations
            | Measure::LengthMax
            | Measure::WaitMax
    )
}

/// The values of a metric in the batches of a run; the value of the whole run, if batches have
/// none.
pub(super) fn values(metric: &Metric, trace: &Trace) -> Vec<Option<f64>> {
    if is_of_run(metric.measure) {
        return vec![measure(metric, trace)];
    }
    let batches = trace.batches.iter();
    batches.map(|batch| measure(metric, batch)).collect()
}

/// Statistics over the batches of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Batches {
    /// Number of batches.
    pub count: usize,
    /// Seconds of each batch; `None` if products ended them.
    pub seconds: Option<f64>,
    /// The measures of the line, in the order of [`ESTIMATED`].
    pub estimates: Vec<BatchEstimate>,
    /// All measures of the line, its products and its places.
    pub measures: Vec<Estimated>,
    /// The line's requirements, in line order. Their `runs` are batches; a requirement on a figure
    /// of the whole run has one.
    pub requirements: Vec<ReplicatedRequirement>,
    /// By requirement: the lag-1 autocorrelation of its values.
    pub lags_1: Vec<Option<f64>>,
    /// The lag-1 autocorrelation above which batches are too short; see [`critical_lag_1`].
    pub critical_lag_1: f64,
    /// One finding for each requirement that fails or is undecided, and one if neighboring batches
    /// are correlated.
    pub findings: Vec<Diagnostic>,
}

/// The mean of a measure over the batches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatchEstimate {
    /// What is measured.
    pub measure: Measure,
    /// The mean, with an interval if all batches have a value; `None` if none has one.
    pub value: Option<Estimate>,
    /// Lag-1 autocorrelation of the batches; `None` if it cannot be measured.
    pub lag_1: Option<f64>,
}

/// Lag-1 autocorrelation of successive values, by von Neumann's ratio: near 0 for independent ones.
/// `None` for fewer than [`MIN_BATCHES`] values, and if all are equal.
pub fn lag_1(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    // Less than rounding errors of equal values.
    let is_constant = squares <= (1e-12 * mean).powi(2) * count;
    if values.len() < MIN_BATCHES as usize || is_constant {
        return None;
    }
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    Some(1.0 - steps.sum::<f64>() / (2.0 * squares))
}

/// The value of [`lag_1`] above which it is significantly positive: this many independent normal
/// values exceed it in 5 % of all cases. The statistic is then nearly normal, with mean 0 and
/// variance (n - 2) / (n^2 - 1).
pub fn critical_lag_1(count: usize) -> f64 {
    let count = count as f64;
    NORMAL_95 * ((count - 2.0) / (count * count - 1.0)).sqrt()
}

/// The values whose mean and deviation are those of the weighted mean of these values; without
/// those that are missing.
pub(super) fn weighted(metric: &Metric, trace: &Trace, values: &[Option<f64>]) -> Vec<f64> {
    let batches = trace.batches.iter();
    let weights: Vec<f64> = batches.map(|batch| batch.weight(metric)).collect();
    weighted_by(&weights, values)
}

/// The same with these weights of the batches.
fn weighted_by(weights: &[f64], values: &[Option<f64>]) -> Vec<f64> {
    let batches = values.iter().zip(weights);
    let measured: Vec<(f64, f64)> = batches
        .filter_map(|(value, weight)| Some(((*value)?, *weight)))
        .collect();
    let total: f64 = measured.iter().map(|(_, weight)| weight).sum();
    let plain: Vec<f64> = values.iter().copied().flatten().collect();
    let is_constant = plain
        .iter()
        .all(|value| value.to_bits() == plain[0].to_bits());
    if is_constant || total <= 0.0 || measured.len() < plain.len() {
        return plain;
    }
    let mean = measured.iter().map(|(v, weight)| v * weight).sum::<f64>() / total;
    let mean_weight = total / measured.len() as f64;
    let linear = |(value, weight): &(f64, f64)| mean + weight * (value - mean) / mean_weight;
    measured.iter().map(linear).collect()
}

/// The mean of a metric over the batches of a run, and how they depend on each other. If some have
/// no value, there is no interval.
pub(super) fn estimate(metric: &Metric, trace: &Trace) -> (Option<Estimate>, Option<f64>) {
    let values = values(metric, trace);
    let measured = weighted(metric, trace, &values);
    let (value, lag_1) = mean_and_lag(&measured, values.len());
    (value.map(|value| value.of_measure(metric.measure)), lag_1)
}

/// The same for a figure that is a mean over time, or a total.
pub(super) fn estimate_over_time(
    trace: &Trace,
    is_total: bool,
    value: impl Fn(&Batch) -> f64,
) -> (Option<Estimate>, Option<f64>) {
    let batches = || trace.batches.iter();
    let values: Vec<Option<f64>> = batches().map(|batch| Some(value(batch))).collect();
    let weight = |batch: &Batch| if is_total { 1.0 } else { batch.seconds };
    let weights: Vec<f64> = batches().map(weight).collect();
    mean_and_lag(&weighted_by(&weights, &values), values.len())
}

fn mean_and_lag(measured: &[f64], count: usize) -> (Option<Estimate>, Option<f64>) {
    let mean = Estimate::of(measured);
    if measured.len() < count {
        let mean = mean.map(|mean| Estimate {
            missing: 0,
            half_width: None,
            ..mean
        });
        return (mean, None);
    }
    (mean, lag_1(measured))
}

impl Batches {
    /// Evaluates the batches of a run of a line; `None` if it has none.
    pub fn of(line: &Line, trace: &Trace) -> Option<Self> {
        let first = trace.batches.first()?;
        let estimates = ESTIMATED.iter().map(|estimated| {
            let (value, lag_1) = estimate(&(*estimated).into(), trace);
            BatchEstimate {
                measure: *estimated,
                value,
                lag_1,
            }
        });
        let estimates: Vec<BatchEstimate> = estimates.collect();
        let sample = Sample::Batches(trace);
        let requirements = requirement::over(line, sample);
        let metrics = line
            .requirements
            .iter()
            .map(|requirement| &requirement.metric);
        let lags_1: Vec<Option<f64>> = metrics.map(|metric| estimate(metric, trace).1).collect();
        let mut findings = requirement::unmet(line, sample, &requirements);
        // A deadlock in a part of the line shows in the batches after it.
        if !matches!(trace.bottleneck, Bottleneck::Deadlock(_)) {
            findings.extend(correlated(line, trace, &estimates, &lags_1));
        }
        let seconds = (trace.end == End::Time).then_some(first.seconds);
        findings.extend(out_of_step(line, trace, seconds));
        Some(Self {
            count: trace.batches.len(),
            seconds,
            estimates,
            measures: estimates::of_batches(line, trace),
            requirements,
            lags_1,
            critical_lag_1: critical_lag_1(trace.batches.len()),
            findings,
        })
    }
}

/// The finding that neighboring batches are correlated.
fn correlated(
    line: &Line,
    trace: &Trace,
    estimates: &[BatchEstimate],
    lags_1: &[Option<f64>],
) -> Option<Diagnostic> {
    let of_line = estimates.iter();
    let of_line = of_line.map(|e| (e.measure.info().subject.to_owned(), e.lag_1));
    let required = line.requirements.iter().zip(lags_1);
    let required = required.map(|(r, lag_1)| (line.subject_of(&r.metric), *lag_1));
    let critical = critical_lag_1(trace.batches.len());
    let mut found: Vec<(String, f64)> = Vec::new();
    for (subject, lag_1) in of_line.chain(required) {
        if let Some(lag_1) = lag_1.filter(|lag_1| *lag_1 > critical)
            && found.iter().all(|(known, _)| *known != subject)
        {
            found.push((subject, lag_1));
        }
    }
    if found.is_empty() {
        return None;
    }
    let subjects = found.iter();
    let subjects = subjects.map(|(subject, lag_1)| format!("{subject} ({lag_1:.2})"));
    let subjects: Vec<String> = subjects.collect();
    let message = format!(
        "the batches of {} may be too short, and the intervals too narrow: neighboring batches are correlated in {}, where {critical:.2} is significant",
        line.name,
        subjects.join(", "),
    );
    let count = trace.batches.len() as u32;
    let fewer = if count > 10 {
        "take fewer batches, such as `--batches 10`, "
    } else {
        ""
    };
    Some(
        Diagnostic::warning(codes::LINE_LIMIT, line.span, message).with_help(format!(
            "Let the run last longer, {fewer}or make replications instead: `--replications 10`. If all batches are as long as they should be, the line may not be steady: give a longer --warm-up."
        )),
    )
}

/// The finding that batches see different parts of the shifts: each has to last whole days, or
/// whole weeks if the shifts are not the same on all days.
fn out_of_step(line: &Line, trace: &Trace, seconds: Option<f64>) -> Option<Diagnostic> {
    const DAY: f64 = 86_400.0;
    let calendars = (0..line.nodes.len()).filter_map(|node| line.calendar_of(node));
    let has_weeks = |calendar: &WorkCalendar| {
        let mut shifts = calendar.shifts.iter();
        shifts.any(|shift| shift.days.contains(&false))
    };
    let weekly = calendars.map(has_weeks).reduce(|a, b| a || b)?;
    let (period, word) = if weekly {
        (7.0 * DAY, "weeks")
    } else {
        (DAY, "days")
    };
    let each = seconds.unwrap_or(0.0);
    let whole = (each / period).round();
    if whole >= 1.0 && (each - whole * period).abs() < 1e-3 {
        return None;
    }
    let count = trace.batches.len() as f64;
    let until = trace.warm_up + count * period * (each / period).ceil().max(1.0);
    let message = match seconds {
        Some(seconds) => format!(
            "the batches of {} last {}, not whole {word}: each sees other shifts, so that the intervals are not reliable",
            line.name,
            duration(seconds)
        ),
        None => format!(
            "the batches of {} end with a product, not after whole {word}: each sees other shifts, so that the intervals are not reliable",
            line.name
        ),
    };
    Some(
        Diagnostic::warning(codes::LINE_LIMIT, line.span, message).with_help(format!(
            "Let each batch last whole {word}: `--until {until}`."
        )),
    )
}
