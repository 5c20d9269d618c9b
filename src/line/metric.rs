//! Requirements: what is measured, and whether it is as it should be.

use super::trace::{RequirementResult, Trace};
use crate::contract::line::{Comparison, Line, Metric};
use crate::diagnostics::{Diagnostic, codes};

const JOULES_PER_KWH: f64 = 3.6e6;

/// A metric of a run, in its unit.
pub fn measure(metric: &Metric, trace: &Trace) -> f64 {
    match metric {
        Metric::ThroughputPerHour => trace.throughput_per_hour,
        Metric::MakespanSeconds => trace.makespan,
        Metric::LeadTimeMeanSeconds => trace.lead_time.mean,
        Metric::EnergyKwh => trace.joules / JOULES_PER_KWH,
        Metric::Rejected => trace.parts.rejected as f64,
        Metric::Products => trace.products as f64,
        Metric::Violations => trace.violation_count as f64,
        Metric::Busy(node) => trace
            .stations
            .iter()
            .find(|station| station.node == *node)
            .map_or(0.0, |station| station.shares.busy),
    }
}

/// Whether a comparison holds, and the words for it.
fn compare(value: f64, comparison: Comparison, bound: f64) -> (bool, &'static str) {
    #[expect(clippy::float_cmp, reason = "the language's own equality")]
    match comparison {
        Comparison::Lt => (value < bound, "less than"),
        Comparison::Le => (value <= bound, "at most"),
        Comparison::Eq => (value == bound, "exactly"),
        Comparison::Ge => (value >= bound, "at least"),
        Comparison::Gt => (value > bound, "more than"),
    }
}

/// Checks all requirements of a line; each that does not hold is a finding.
pub(super) fn check(line: &Line, trace: &mut Trace) {
    for requirement in &line.requirements {
        let value = measure(&requirement.metric, trace);
        let (holds, words) = compare(value, requirement.comparison, requirement.bound);
        if !holds {
            let what = describe(&requirement.metric, line);
            let message = format!(
                "the requirement {} does not hold: {what} is {}, and should be {words} {}",
                requirement.name,
                (value * 1000.0).round() / 1000.0,
                requirement.bound
            );
            trace.findings.push(
                Diagnostic::error(codes::LINE_REQUIREMENT, requirement.span, message)
                    .with_help(advice(line, trace)),
            );
        }
        trace.requirements.push(RequirementResult {
            name: requirement.name.clone(),
            holds,
            value,
        });
    }
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
        Metric::Busy(node) => format!(
            "the busy share of {}",
            line.nodes.get(*node).map_or("a station", |n| &n.name)
        ),
    }
}

fn advice(line: &Line, trace: &Trace) -> String {
    match trace.bottleneck.and_then(|index| trace.stations.get(index)) {
        Some(station) => format!(
            "The bottleneck of {} was {}; look there first, or change the requirement.",
            line.name, station.name
        ),
        None => "Change the line or the requirement.".to_owned(),
    }
}
