//! Requirements: whether measured values meet their bounds.
//!
//! One run is judged by its values. Several runs are judged by the confidence interval of the mean,
//! so that the verdict does not change with every further run, and a line whose mean is next to the
//! bound gets no verdict by luck. The batches of a run are judged in the same way.

use super::batches;
use super::bottleneck::Bottleneck;
use super::metric::measure;
use super::replicate::{Estimate, MAX_REPLICATIONS};
use super::trace::{End, RequirementResult, Trace};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Comparison, Line, Requirement};
use linewright_language::contract::metric::{Measure, Metric};

/// Whether a requirement holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// All values of the interval meet the bound.
    Holds,
    /// No value of the interval meets the bound.
    Fails,
    /// The bound lies in the interval.
    Undecided {
        /// Estimated number of further runs, or batches of the same length, after which the
        /// interval no longer contains the bound; `None` if the mean is the bound or has to be
        /// exactly the bound, or if more than [`MAX_REPLICATIONS`] runs are needed.
        more: Option<u64>,
    },
}

impl Verdict {
    /// Returns the verdict's name in output.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided { .. } => "undecided",
        }
    }
}

/// Relative difference up to which a value counts as equal to a bound, and absolute difference for
/// bounds below 1. Measured values are sums and differences of instants, each rounded to 53 bits.
const ROUNDING: f64 = 1e-9;

/// Whether a value is the bound, up to rounding.
fn is_at(value: f64, bound: f64) -> bool {
    (value - bound).abs() <= ROUNDING * bound.abs().max(1.0)
}

fn meets(value: f64, comparison: Comparison, bound: f64) -> bool {
    let is_at_bound = is_at(value, bound);
    match comparison {
        Comparison::Lt => value < bound && !is_at_bound,
        Comparison::Le => value < bound || is_at_bound,
        Comparison::Eq => is_at_bound,
        Comparison::Ge => value > bound || is_at_bound,
        Comparison::Gt => value > bound && !is_at_bound,
    }
}

fn words(comparison: Comparison) -> &'static str {
    match comparison {
        Comparison::Lt => "less than",
        Comparison::Le => "at most",
        Comparison::Eq => "exactly",
        Comparison::Ge => "at least",
        Comparison::Gt => "more than",
    }
}

/// The measured value as the predicate of a sentence.
fn is(metric: &Metric, value: Option<f64>) -> String {
    if let Some(value) = value {
        return format!("is {}", readable(value));
    }
    let why = metric
        .measure
        .info()
        .absent
        .unwrap_or("nothing was counted");
    format!("was not measured, since {why}")
}

/// Checks all requirements of a line in one run. Each requirement that does not hold becomes a
/// finding. A run that was cut off is not checked.
pub(super) fn check(line: &Line, trace: &mut Trace) {
    if trace.end == End::GaveUp {
        return;
    }
    for requirement in &line.requirements {
        let value = measure(&requirement.metric, trace);
        let (comparison, bound) = (requirement.comparison, requirement.bound);
        let holds = value.is_some_and(|value| meets(value, comparison, bound));
        if !holds {
            let message = fails_in_run(line, requirement, value);
            trace.findings.push(
                Diagnostic::error(codes::LINE_REQUIREMENT, requirement.span, message)
                    .with_help(advice(&requirement.metric, line, trace)),
            );
        }
        trace.requirements.push(RequirementResult {
            name: requirement.name.clone(),
            holds,
            value,
        });
    }
}

fn fails_in_run(line: &Line, requirement: &Requirement, value: Option<f64>) -> String {
    format!(
        "the requirement {} does not hold: {} {}, and should be {} {}",
        requirement.name,
        line.subject_of(&requirement.metric),
        is(&requirement.metric, value),
        words(requirement.comparison),
        requirement.bound,
    )
}

impl ReplicatedRequirement {
    /// If it is undecided: estimated number of further runs or batches that would decide it; `None`
    /// if no permitted number would.
    pub fn more(&self) -> Option<u64> {
        match self.verdict {
            Verdict::Undecided { more } => more,
            Verdict::Holds | Verdict::Fails => None,
        }
    }

    /// If it is undecided over batches: how many times as long a run would have to count to decide
    /// it; `None` if no run would.
    pub fn times_as_long(&self) -> Option<f64> {
        let more = self.more()? as f64;
        Some(1.0 + more / self.runs as f64)
    }
}

/// What requirements are judged by.
#[derive(Clone, Copy)]
pub(super) enum Sample<'a> {
    /// Several runs.
    Runs(&'a [Trace]),
    /// The batches of a run.
    Batches(&'a Trace),
}

impl<'a> Sample<'a> {
    /// The values of requirement number `index` in each run or batch.
    fn values(self, index: usize, requirement: &Requirement) -> Vec<Option<f64>> {
        match self {
            Self::Runs(traces) => {
                let results = traces.iter();
                let results = results.filter_map(|trace| trace.requirements.get(index));
                results.map(|result| result.value).collect()
            }
            Self::Batches(trace) => batches::values(&requirement.metric, trace),
        }
    }

    /// The values whose mean and deviation decide on a requirement that has these values.
    fn of_mean(self, requirement: &Requirement, values: &[Option<f64>]) -> Vec<f64> {
        match self {
            Self::Runs(_) => values.iter().copied().flatten().collect(),
            Self::Batches(trace) => batches::weighted(&requirement.metric, trace, values),
        }
    }

    /// The run with this index, or that of the batches.
    fn trace(self, index: usize) -> Option<&'a Trace> {
        match self {
            Self::Runs(traces) => traces.get(index),
            Self::Batches(trace) => Some(trace),
        }
    }

    /// `6 runs`, or `20 batches`.
    fn counted(self, count: usize) -> String {
        let what = match self {
            Self::Runs(_) => "runs",
            Self::Batches(_) => "batches",
        };
        format!("{count} {what}")
    }
}

/// A requirement over several runs, or over the batches of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplicatedRequirement {
    /// Name of the requirement.
    pub name: String,
    /// Whether it holds.
    pub verdict: Verdict,
    /// Number of runs in which it holds.
    pub held_in: usize,
    /// Number of runs.
    pub runs: usize,
    /// Measured value in the metric's unit, over the runs in which it could be measured; `None` if
    /// there is no such run.
    pub value: Option<Estimate>,
    /// Index of the first run in which the value could not be measured. If there is none: index of
    /// the run that violates the bound most or, if no run violates it, comes closest to doing so.
    pub worst: usize,
    /// Measured value in the run `worst`; `None` if it could not be measured.
    pub worst_value: Option<f64>,
    /// Whether the verdict follows from single runs, not from the interval.
    by_run: bool,
}

/// Evaluates the requirements of a line over these runs or batches.
pub(super) fn over(line: &Line, sample: Sample<'_>) -> Vec<ReplicatedRequirement> {
    let requirements = line.requirements.iter().enumerate();
    requirements
        .map(|(index, requirement)| {
            let values = sample.values(index, requirement);
            let worst = worst(requirement, &values);
            let measured: Vec<f64> = values.iter().copied().flatten().collect();
            let mut value = Estimate::of(&sample.of_mean(requirement, &values))
                .map(|value| value.of_measure(requirement.metric.measure));
            let mut in_one = in_one_run(requirement, &values);
            // A batch without a value is too short: it shows nothing about the run.
            let is_short = matches!(sample, Sample::Batches(_)) && measured.len() < values.len();
            if let (Some(value), true) = (&mut value, is_short) {
                value.half_width = None;
                in_one = Some(Verdict::Undecided { more: None });
            }
            let (comparison, bound) = (requirement.comparison, requirement.bound);
            let holds = measured.iter().filter(|v| meets(**v, comparison, bound));
            ReplicatedRequirement {
                name: requirement.name.clone(),
                verdict: match (in_one, value) {
                    (Some(verdict), _) => verdict,
                    (None, Some(value)) => by_interval(requirement, value, measured.len() as u64),
                    (None, None) => Verdict::Fails,
                },
                held_in: holds.count(),
                runs: values.len(),
                worst,
                worst_value: values.get(worst).copied().flatten(),
                value,
                by_run: in_one.is_some(),
            }
        })
        // Runs that were cut off have no results; without any results, there is nothing to report.
        .filter(|result| result.runs > 0)
        .collect()
}

/// Index of the run that misses the bound most.
fn worst(requirement: &Requirement, values: &[Option<f64>]) -> usize {
    let miss = |value: Option<f64>| match (requirement.comparison, value) {
        (_, None) => f64::INFINITY,
        (Comparison::Lt | Comparison::Le, Some(value)) => value - requirement.bound,
        (Comparison::Eq, Some(value)) => (value - requirement.bound).abs(),
        (Comparison::Ge | Comparison::Gt, Some(value)) => requirement.bound - value,
    };
    let mut worst = 0;
    for (run, &value) in values.iter().enumerate() {
        if miss(value) > miss(values[worst]) {
            worst = run;
        }
    }
    worst
}

/// The verdict if single runs give it; `None` if the interval has to.
///
/// - A run in which nothing could be measured fails the requirement.
/// - Contract violations are judged in each run: a rule that is violated once is violated.
/// - A bound that no value can pass (0, or 100 % of a share) is an end of the range. If a single
///   run is not there, neither is the mean.
fn in_one_run(requirement: &Requirement, values: &[Option<f64>]) -> Option<Verdict> {
    let (comparison, bound) = (requirement.comparison, requirement.bound);
    let verdict = |holds: bool| {
        Some(if holds {
            Verdict::Holds
        } else {
            Verdict::Fails
        })
    };
    if values.iter().any(Option::is_none) {
        return verdict(false);
    }
    let measured = || values.iter().copied().flatten();
    if requirement.metric.measure == Measure::Violations {
        return verdict(measured().all(|value| meets(value, comparison, bound)));
    }
    let unit = requirement.metric.measure.info().unit;
    let is_end = bound == 0.0 || unit.greatest() == Some(bound);
    let inside = measured()
        .find(|value| !is_at(*value, bound))
        .filter(|_| is_end)?;
    verdict(meets(inside, comparison, bound))
}

/// The verdict of a confidence interval.
fn by_interval(requirement: &Requirement, value: Estimate, runs: u64) -> Verdict {
    let (comparison, bound) = (requirement.comparison, requirement.bound);
    let half = value.half_width.unwrap_or(0.0);
    let (low, high) = (value.mean - half, value.mean + half);
    let meets = |value: f64| meets(value, comparison, bound);
    let varies = !is_at(low, high);
    if comparison == Comparison::Eq && low <= bound && bound <= high && varies {
        // A mean that varies is never exactly a number.
        return Verdict::Undecided { more: None };
    }
    match (meets(low), meets(high)) {
        (true, true) => Verdict::Holds,
        (false, false) => Verdict::Fails,
        _ => Verdict::Undecided {
            more: value.further_runs(runs, bound),
        },
    }
}

/// One finding for each requirement that fails or is undecided over several runs or batches.
pub(super) fn unmet(
    line: &Line,
    sample: Sample<'_>,
    results: &[ReplicatedRequirement],
) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (requirement, result) in line.requirements.iter().zip(results) {
        let Some(worst) = sample.trace(result.worst) else {
            continue;
        };
        match result.verdict {
            Verdict::Holds => {}
            Verdict::Fails => {
                let message = match sample {
                    Sample::Batches(_) if result.runs == 1 || result.value.is_none() => {
                        fails_in_run(line, requirement, result.worst_value)
                    }
                    _ if result.by_run => fails_in_runs(line, requirement, result, sample),
                    _ => judged(line, requirement, result, sample, "does not hold"),
                };
                findings.push(
                    Diagnostic::error(codes::LINE_REQUIREMENT, requirement.span, message)
                        .with_help(advice(&requirement.metric, line, worst)),
                );
            }
            Verdict::Undecided { more } => {
                findings.push(undecided(line, requirement, result, sample, more));
            }
        }
    }
    findings
}

/// `95 % interval 3589.1 to 3632.4, 6 runs`.
fn interval(result: &ReplicatedRequirement, sample: Sample<'_>) -> String {
    let counted = sample.counted(result.runs);
    let Some((low, high)) = result.value.and_then(|value| value.interval()) else {
        return match sample {
            Sample::Runs(_) => counted,
            Sample::Batches(_) => format!("nothing to measure in some of {counted}"),
        };
    };
    if low >= high {
        return format!("in all {counted}");
    }
    format!(
        "95 % interval {} to {}, {counted}",
        readable(low),
        readable(high),
    )
}

/// The verdict on a requirement with the interval and the bound.
fn judged(
    line: &Line,
    requirement: &Requirement,
    result: &ReplicatedRequirement,
    sample: Sample<'_>,
    verdict: &str,
) -> String {
    format!(
        "the requirement {} {verdict}: {} {} ({}), and should be {} {}",
        requirement.name,
        line.subject_of(&requirement.metric),
        is(&requirement.metric, result.value.map(|value| value.mean)),
        interval(result, sample),
        words(requirement.comparison),
        requirement.bound,
    )
}

fn fails_in_runs(
    line: &Line,
    requirement: &Requirement,
    result: &ReplicatedRequirement,
    sample: Sample<'_>,
) -> String {
    let metric = &requirement.metric;
    let which = match sample {
        Sample::Runs(traces) => {
            let seed = traces.get(result.worst).map_or(0, |trace| trace.seed);
            format!("with seed {seed}")
        }
        Sample::Batches(_) => format!("in batch {}", result.worst + 1),
    };
    // Without a value, the sentence ends with the reason, so the seed comes first.
    let in_worst = match result.worst_value {
        Some(_) => format!("{} {which}", is(metric, result.worst_value)),
        None => format!("{which} it {}", is(metric, None)),
    };
    format!(
        "the requirement {} does not hold in {} of {}: {} should be {} {}, and {in_worst}",
        requirement.name,
        result.runs - result.held_in,
        sample.counted(result.runs),
        line.subject_of(metric),
        words(requirement.comparison),
        requirement.bound,
    )
}

fn undecided(
    line: &Line,
    requirement: &Requirement,
    result: &ReplicatedRequirement,
    sample: Sample<'_>,
    more: Option<u64>,
) -> Diagnostic {
    let message = judged(line, requirement, result, sample, "is undecided");
    let help = match (sample, more) {
        _ if requirement.comparison == Comparison::Eq => {
            "A mean that varies is never exactly a number: use `<=` or `>=`.".to_owned()
        }
        (Sample::Runs(_), Some(more)) => format!(
            "About {more} more {} would decide it: `--replications {}`. Longer runs help, too.",
            if more == 1 {
                "replication"
            } else {
                "replications"
            },
            result.runs as u64 + more
        ),
        (Sample::Runs(_), None) => format!(
            "{MAX_REPLICATIONS} replications would not decide it: let each run last longer, or change the requirement.",
        ),
        (Sample::Batches(_), _) => {
            let times = result.times_as_long().map_or(String::new(), |times| {
                format!(" If it counts about {times:.1} times as long, that would decide it.")
            });
            format!("Let the run last longer, or change the requirement.{times}")
        }
    };
    Diagnostic::warning(codes::LINE_REQUIREMENT, requirement.span, message)
        .with_help(help)
        .giving_up(true)
}

/// Rounds to three decimal places, or to three significant digits if these are smaller.
fn readable(value: f64) -> f64 {
    let magnitude = value.abs().log10().floor();
    let places = if magnitude < -2.0 && value != 0.0 {
        (2.0 - magnitude).min(15.0) as i32
    } else {
        3
    };
    let scale = 10_f64.powi(places);
    (value * scale).round() / scale
}

/// Where to begin: at the bottleneck if the metric depends on the pace of the line, at the largest
/// consumer if it is the energy.
fn advice(metric: &Metric, line: &Line, trace: &Trace) -> String {
    let found = match metric.measure {
        Measure::Throughput
        | Measure::ThroughputOnShift
        | Measure::Makespan
        | Measure::LeadTime
        | Measure::LeadTimeMedian
        | Measure::LeadTimePercentile
        | Measure::LeadTimeMax
        | Measure::Wip
        | Measure::WipMax
        | Measure::Products => bottleneck(line, &trace.bottleneck),
        Measure::Energy | Measure::EnergyPerProduct => {
            largest_consumer(trace).map(|(name, joules)| {
                let share = 100.0 * joules / trace.joules;
                format!("{name} used {share:.0} % of the energy of {}", line.name)
            })
        }
        _ => None,
    };
    match found {
        Some(found) => format!("{found}; look there first, or change the requirement."),
        None => "Change the line or the requirement.".to_owned(),
    }
}

/// Where to begin to make a line faster.
fn bottleneck(line: &Line, bottleneck: &Bottleneck) -> Option<String> {
    match bottleneck {
        Bottleneck::Nothing => None,
        Bottleneck::Station(station) => Some(format!(
            "The bottleneck of {} was {}",
            line.name, station.name
        )),
        Bottleneck::Source {
            names,
            busiest: Some(station),
            parts_wait: true,
        } => Some(format!(
            "{} of {} waited for parts of {}",
            station.name,
            line.name,
            names.join(" and ")
        )),
        Bottleneck::Source { names, .. } => Some(format!(
            "The line took in all that {} brought",
            names.join(" and ")
        )),
        Bottleneck::Deadlock(deadlock) => Some(format!(
            "{} of {} wait for one another for ever",
            deadlock.listed(),
            line.name
        )),
        Bottleneck::Undecided(stations) => {
            let names: Vec<&str> = stations.iter().map(|s| s.name.as_str()).collect();
            Some(format!(
                "{} limited {} alike",
                names.join(" and "),
                line.name
            ))
        }
    }
}

/// The station or conveyor that used the most energy, and its energy in joules.
fn largest_consumer(trace: &Trace) -> Option<(&str, f64)> {
    let stations = trace.stations.iter().map(|s| (s.name.as_str(), s.joules));
    let conveyors = trace.conveyors.iter().map(|c| (c.name.as_str(), c.joules));
    let used = stations
        .chain(conveyors)
        .filter(|(_, joules)| *joules > 0.0);
    used.max_by(|a, b| a.1.total_cmp(&b.1))
}
