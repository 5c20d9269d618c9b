//! Requirements: measured values, and whether they meet their bounds.

use super::bottleneck::Bottleneck;
use super::replicate::Estimate;
use super::trace::{End, RequirementResult, Trace};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Comparison, Line, Metric};

const JOULES_PER_KWH: f64 = 3.6e6;

/// Value of a metric in a run, in its unit; `None` if there was nothing to measure, such as the
/// lead time in a run without products.
pub fn measure(metric: &Metric, trace: &Trace) -> Option<f64> {
    let of_products = matches!(
        metric,
        Metric::MakespanSeconds | Metric::LeadTimeMeanSeconds
    );
    (!of_products || trace.products > 0).then(|| value(metric, trace))
}

fn value(metric: &Metric, trace: &Trace) -> f64 {
    match metric {
        Metric::ThroughputPerHour => trace.throughput_per_hour,
        Metric::MakespanSeconds => trace.makespan,
        Metric::LeadTimeMeanSeconds => trace.lead_time.mean,
        Metric::EnergyKwh => trace.joules / JOULES_PER_KWH,
        Metric::Rejected => trace.parts.rejected as f64,
        Metric::Products => trace.products as f64,
        Metric::Violations => trace.violation_count as f64,
        Metric::Busy(nodes) => {
            let stations = trace.stations.iter();
            let busy = stations
                .filter(|station| nodes.contains(&station.node))
                .map(|station| station.shares.busy);
            busy.sum::<f64>() / nodes.len().max(1) as f64
        }
    }
}

fn holds(value: f64, comparison: Comparison, bound: f64) -> bool {
    #[expect(clippy::float_cmp, reason = "the language's own equality")]
    match comparison {
        Comparison::Lt => value < bound,
        Comparison::Le => value <= bound,
        Comparison::Eq => value == bound,
        Comparison::Ge => value >= bound,
        Comparison::Gt => value > bound,
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
fn is(value: Option<f64>) -> String {
    match value {
        Some(value) => format!("is {}", thousandths(value)),
        None => "was not measured, since no product was finished".to_owned(),
    }
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
        let holds = value.is_some_and(|value| holds(value, comparison, bound));
        if !holds {
            let message = format!(
                "the requirement {} does not hold: {} {}, and should be {} {bound}",
                requirement.name,
                describe(&requirement.metric, line),
                is(value),
                words(comparison),
            );
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

/// A requirement over several runs: it holds if it holds in every run.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplicatedRequirement {
    /// Name of the requirement.
    pub name: String,
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
}

impl ReplicatedRequirement {
    /// Whether it holds in every run.
    pub fn holds(&self) -> bool {
        self.held_in == self.runs
    }
}

/// Evaluates the requirements of a line over these runs.
pub(super) fn over(line: &Line, traces: &[Trace]) -> Vec<ReplicatedRequirement> {
    let requirements = line.requirements.iter().enumerate();
    requirements
        .map(|(index, requirement)| {
            let results = || {
                traces
                    .iter()
                    .filter_map(|trace| trace.requirements.get(index))
            };
            let values: Vec<Option<f64>> = results().map(|result| result.value).collect();
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
            let measured: Vec<f64> = values.iter().copied().flatten().collect();
            ReplicatedRequirement {
                name: requirement.name.clone(),
                held_in: results().filter(|result| result.holds).count(),
                runs: values.len(),
                worst,
                worst_value: values.get(worst).copied().flatten(),
                value: Estimate::of(&measured),
            }
        })
        // Runs that were cut off have no results; without any results, there is nothing to report.
        .filter(|result| result.runs > 0)
        .collect()
}

/// One finding for each requirement that does not hold in all of several runs.
pub(super) fn unmet(
    line: &Line,
    traces: &[Trace],
    results: &[ReplicatedRequirement],
) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for (requirement, result) in line.requirements.iter().zip(results) {
        let Some(worst) = traces.get(result.worst).filter(|_| !result.holds()) else {
            continue;
        };
        // Without a value, the sentence ends with the reason, so the seed comes first.
        let with_seed = match result.worst_value {
            Some(_) => format!("{} with seed {}", is(result.worst_value), worst.seed),
            None => format!("with seed {} it {}", worst.seed, is(None)),
        };
        let message = format!(
            "the requirement {} does not hold in {} of {} runs: {} should be {} {}, and {with_seed}",
            requirement.name,
            result.runs - result.held_in,
            result.runs,
            describe(&requirement.metric, line),
            words(requirement.comparison),
            requirement.bound,
        );
        findings.push(
            Diagnostic::error(codes::LINE_REQUIREMENT, requirement.span, message)
                .with_help(advice(&requirement.metric, line, worst)),
        );
    }
    findings
}

fn thousandths(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

/// A metric in words, with its unit.
pub fn describe(metric: &Metric, line: &Line) -> String {
    match metric {
        Metric::ThroughputPerHour => "the throughput in products an hour".to_owned(),
        Metric::MakespanSeconds => "the makespan in seconds".to_owned(),
        Metric::LeadTimeMeanSeconds => "the mean lead time in seconds".to_owned(),
        Metric::EnergyKwh => "the energy in kWh".to_owned(),
        Metric::Rejected => "the number of rejected parts".to_owned(),
        Metric::Products => "the number of products".to_owned(),
        Metric::Violations => "the number of contract violations".to_owned(),
        Metric::Busy(nodes) => format!("the busy share of {}", line.names_of(nodes)),
    }
}

/// Where to begin: at the bottleneck if the metric depends on the pace of the line, at the largest
/// consumer if it is the energy.
fn advice(metric: &Metric, line: &Line, trace: &Trace) -> String {
    let found = match metric {
        Metric::ThroughputPerHour
        | Metric::MakespanSeconds
        | Metric::LeadTimeMeanSeconds
        | Metric::Products => bottleneck(line, &trace.bottleneck),
        Metric::EnergyKwh => largest_consumer(trace).map(|(name, joules)| {
            let share = 100.0 * joules / trace.joules;
            format!("{name} used {share:.0} % of the energy of {}", line.name)
        }),
        Metric::Rejected | Metric::Violations | Metric::Busy(_) => None,
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
        Bottleneck::Source { names, .. } => Some(format!(
            "The line took in all that {} brought",
            names.join(" and ")
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
