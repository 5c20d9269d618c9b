//! Tables of estimates with their confidence intervals, over replications or batches.

use super::columns::{columns, measured, small};
use super::energy::EnergyUnit;
use super::table::required;
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::{Measure, MeasureUnit};
use linewright_line::estimates::{Estimated, Subject};
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::duration;
use linewright_line::{Batches, Estimate, ReplicatedRequirement, Replications};

/// Writes the requirements over all replications or batches: the verdict, the mean with its
/// confidence interval, and the value in the worst of them.
pub(super) fn requirements_of_all(
    out: &mut String,
    line: &Line,
    requirements: &[ReplicatedRequirement],
) {
    let rows = requirements.iter().enumerate().map(|(index, result)| {
        let [mean, low, high] = ends(result.value).map(|end| end.map_or("-".to_owned(), small));
        vec![
            result.name.clone(),
            result.verdict.word().to_owned(),
            required(line, index),
            mean,
            low,
            high,
            result.worst_value.map_or("-".to_owned(), small),
        ]
    });
    columns(
        out,
        &[
            "requirement",
            "verdict",
            "required",
            "mean",
            "from",
            "to",
            "worst",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

pub(super) fn replicated(out: &mut String, replications: &Replications) {
    let first = [
        (Measure::Throughput, replications.throughput_per_hour),
        (Measure::LeadTime, replications.lead_time),
        (Measure::LeadTimePercentile, replications.lead_time_p95),
        (Measure::Wip, replications.wip),
        (Measure::Makespan, replications.makespan),
        (Measure::Energy, replications.energy_kwh),
    ];
    let further = further_rows(&replications.measures);
    let further = further.map(|of| (of.subject.measure(), of.value));
    let rows = first.into_iter().chain(further);
    let rows = rows.map(|(measure, value)| (measure, estimate_row(measure, value)));
    let rows = in_order(rows.collect());
    let title = match replications.seeds[..] {
        [first, .., last] => format!("seeds {first} to {last}, 95 %"),
        _ => "1 seed, 95 %".to_owned(),
    };
    columns(out, &[&title, "mean", "from", "to"], &rows);
}

/// Writes the means of the batches with their intervals and lag-1 autocorrelations.
pub(super) fn batch_means(out: &mut String, batches: &Batches) {
    let row = |measure, value, lag_1| {
        let mut row = estimate_row(measure, value);
        row.push(measured(lag_1, 2));
        row
    };
    let first = batches.estimates.iter();
    let first = first.map(|e| (e.measure, row(e.measure, e.value, e.lag_1)));
    let further = further_rows(&batches.measures).map(|of| {
        let measure = of.subject.measure();
        (measure, row(measure, of.value, of.lag_1))
    });
    let rows = in_order(first.chain(further).collect());
    let each = batches.seconds.map_or(String::new(), |seconds| {
        format!(" of {}", duration(seconds))
    });
    let title = format!("{} batches{each}, 95 %", batches.count);
    columns(out, &[&title, "mean", "from", "to", "lag 1"], &rows);
}

/// Writes the estimates of all measures.
pub(super) fn measures(out: &mut String, line: &Line, measures: &[Estimated], are_batches: bool) {
    let rows = measures.iter().map(|of| {
        let measure = of.subject.measure();
        let (label, places) = match measure.info().unit {
            MeasureUnit::Share => (of.subject.label(line), 4),
            _ => (of.subject.label(line), 3),
        };
        let mut row = energy_row(measure, label, of.value, places);
        if are_batches {
            row.push(measured(of.lag_1, 2));
        }
        row
    });
    let heads = ["all measures, 95 %", "mean", "from", "to", "lag 1"];
    let heads = if are_batches { &heads[..] } else { &heads[..4] };
    columns(out, heads, &rows.collect::<Vec<_>>());
}

/// The rows of a table of estimates, in the order of the measures; the makespan is the last of the
/// times.
fn in_order(mut rows: Vec<(Measure, Vec<String>)>) -> Vec<Vec<String>> {
    let place = |measure: Measure| match measure {
        Measure::Makespan => Measure::WipMax as usize,
        _ => measure as usize,
    };
    rows.sort_by_key(|(measure, _)| place(*measure));
    rows.into_iter().map(|(_, row)| row).collect()
}

/// Further rows of a table of estimates: those that are not 0 throughout.
fn further_rows(measures: &[Estimated]) -> impl Iterator<Item = &Estimated> {
    let wanted = [
        Measure::ThroughputOnShift,
        Measure::LeadTimeMedian,
        Measure::EnergyPerProduct,
        Measure::FirstPassYield,
        Measure::Scrap,
        Measure::Rejected,
    ];
    let of_line = measures.iter().filter(|of| match &of.subject {
        Subject::Metric(metric) => metric.nodes.is_empty() && metric.product.is_none(),
        Subject::Wait(_) | Subject::Energy { .. } => false,
    });
    of_line.filter(move |of| {
        let measure = of.subject.measure();
        let rejects = |measure| {
            let mut rejected = measures.iter().filter(|of| of.subject.measure() == measure);
            rejected.any(|of| of.value.is_some_and(|value| value.mean > 0.0))
        };
        let is_used = match measure {
            Measure::FirstPassYield => rejects(Measure::Scrap) || rejects(Measure::Rejected),
            _ => of.value.is_some_and(|value| value.mean > 0.0),
        };
        wanted.contains(&measure) && is_used
    })
}

/// Measures of a table of estimates, and their decimal places.
fn estimated(measure: Measure) -> (&'static str, usize) {
    match measure {
        Measure::Throughput => ("throughput an hour", 3),
        Measure::LeadTime => ("mean lead time in s", 3),
        Measure::LeadTimeMedian => ("median in s", 3),
        Measure::LeadTimePercentile => ("95th percentile in s", 3),
        Measure::Wip => ("mean WIP", 3),
        Measure::Makespan => ("makespan in seconds", 1),
        Measure::Energy => ("energy in kWh", 4),
        _ => (measure.info().label, 3),
    }
}

fn estimate_row(measure: Measure, estimate: Option<Estimate>) -> Vec<String> {
    let (label, places) = estimated(measure);
    energy_row(measure, label.to_owned(), estimate, places)
}

/// A row with a mean and its interval, an energy in a unit that shows it.
fn energy_row(
    measure: Measure,
    label: String,
    estimate: Option<Estimate>,
    places: usize,
) -> Vec<String> {
    let (mut label, scale) = match estimate {
        Some(estimate) => shown_in(measure, label, estimate.mean),
        None => (label, 1.0),
    };
    if let Some(missing) = estimate.as_ref().and_then(without_value) {
        label.push_str(", ");
        label.push_str(&missing);
    }
    let estimate = estimate.map(|estimate| estimate.scaled(scale));
    let [mean, low, high] = interval(estimate, places);
    vec![label, mean, low, high]
}

/// The label of a measure with the unit in which this value is shown, and how many of that unit are
/// one of the measure's own.
pub(super) fn shown_in(measure: Measure, label: String, value: f64) -> (String, f64) {
    if measure.info().unit != MeasureUnit::KilowattHours {
        return (label, 1.0);
    }
    let unit = EnergyUnit::of(value * JOULES_PER_KWH);
    let label = label.replace("in kWh", &format!("in {}", unit.symbol()));
    (label, JOULES_PER_KWH / unit.joules())
}

/// `without 2 runs` if nothing could be measured in them, so that they are no part of the mean.
pub(super) fn without_value(estimate: &Estimate) -> Option<String> {
    match estimate.missing {
        0 => None,
        1 => Some("without 1 run".to_owned()),
        missing => Some(format!("without {missing} runs")),
    }
}

/// Returns a mean and the ends of its confidence interval; `-` for each that does not exist.
pub(super) fn interval(estimate: Option<Estimate>, places: usize) -> [String; 3] {
    ends(estimate).map(|value| measured(value, places))
}

/// A mean and the ends of its confidence interval.
fn ends(estimate: Option<Estimate>) -> [Option<f64>; 3] {
    let interval = estimate.and_then(|e| e.interval());
    let (low, high) = interval.unzip();
    [estimate.map(|e| e.mean), low, high]
}
