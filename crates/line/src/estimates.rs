//! Estimates of all measures, over replications or over the batches of a run.

use super::batches::{self, PlaceFigures};
use super::metric::{Figures as _, JOULES_PER_KWH, measure};
use super::replicate::Estimate;
use super::trace::{ByState, Trace, WaitKind};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::metric::{MEASURES, Measure, Metric, PlaceKind};
use std::collections::BTreeSet;

/// The estimate of a measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// What is measured.
    pub subject: Subject,
    /// The mean with its interval, in the unit of the measure; `None` if nothing was measured.
    pub value: Option<Estimate>,
    /// Over batches: their lag-1 autocorrelation, if it can be measured.
    pub lag_1: Option<f64>,
}

/// What an estimate is of.
#[derive(Debug, Clone, PartialEq)]
pub enum Subject {
    /// A metric, as in a requirement.
    Metric(Metric),
    /// The share of a station's time in which it waited for one place.
    Wait(Cause),
    /// The energy of a station in one state, in kWh.
    Energy {
        /// The station (node).
        node: usize,
        /// The measure of the time in this state.
        state: Measure,
    },
}

/// Why a station waited.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cause {
    /// The station (node) that waited.
    pub node: usize,
    /// How it waited.
    pub kind: WaitKind,
    /// Name of the place that had no room, or from which the missing part came.
    pub place: String,
    /// While blocked: name of the station at or behind that place, if there is one.
    pub station: Option<String>,
}

impl Subject {
    /// The measure. That of a cause, or of a state, is of the whole.
    pub fn measure(&self) -> Measure {
        match self {
            Self::Metric(metric) => metric.measure,
            Self::Wait(cause) => cause.measure(),
            Self::Energy { .. } => Measure::Energy,
        }
    }

    /// The subject with its unit, for tables.
    pub fn label(&self, line: &Line) -> String {
        match self {
            Self::Metric(metric) => line.label_of(metric),
            Self::Wait(cause) => {
                let waits = cause.measure().at(cause.node..cause.node + 1);
                let behind = cause.station.as_ref().filter(|name| **name != cause.place);
                let behind = behind.map_or(String::new(), |name| format!(", before {name}"));
                format!("{}, by {}{behind}", line.label_of(&waits), cause.place)
            }
            Self::Energy { node, state } => {
                let energy = Measure::Energy.at(*node..*node + 1);
                format!("{}, {}", line.label_of(&energy), state.info().name)
            }
        }
    }
}

impl Cause {
    fn measure(&self) -> Measure {
        match self.kind {
            WaitKind::Blocked => Measure::Blocked,
            WaitKind::Starved => Measure::Starved,
        }
    }
}

/// The metrics of a line, its products and its places. Percentiles are the 95th, and those of
/// which a requirement speaks.
fn metrics(line: &Line) -> Vec<Metric> {
    // Violations are not random, and waiting times are only kept for the percentiles that are
    // required.
    let is_shown = |measure: Measure| match measure {
        Measure::Violations | Measure::WaitPercentile => false,
        Measure::ThroughputOnShift => line.calendar.is_some(),
        _ => true,
    };
    let measures = || MEASURES.iter().filter(|info| is_shown(info.measure));
    let of_line = measures().filter(|info| info.of_line);
    let mut metrics: Vec<Metric> = of_line.map(|info| info.measure.into()).collect();
    if line.only_product().is_none() {
        for product in &line.products {
            let of_product = measures().filter(|info| info.of_product);
            metrics.extend(of_product.map(|info| info.measure.of(*product)));
        }
    }
    for (node, place) in line.nodes.iter().enumerate() {
        let kind = match place.kind {
            NodeKind::Station(_) => PlaceKind::Station,
            NodeKind::Buffer { .. } => PlaceKind::Buffer,
            NodeKind::Conveyor { .. } => PlaceKind::Conveyor,
            NodeKind::Source { .. } => PlaceKind::Source,
            NodeKind::Sink { .. } | NodeKind::Store { .. } => continue,
        };
        let of_place = measures().filter(|info| info.places.contains(&kind));
        metrics.extend(of_place.map(|info| info.measure.at(node..node + 1)));
    }
    for requirement in &line.requirements {
        let metric = &requirement.metric;
        if metric.measure.is_percentile() && !metrics.contains(metric) {
            metrics.push(metric.clone());
        }
    }
    metrics
}

/// The estimates over several runs; empty for a single one.
pub(super) fn of_runs(line: &Line, traces: &[Trace]) -> Vec<Estimated> {
    if traces.len() < 2 {
        return Vec::new();
    }
    let estimate = |subject: Subject, value: &dyn Fn(&Trace) -> Option<f64>| {
        let values = traces.iter().map(|trace| {
            let counted = Some(trace).filter(|trace| trace.has_counted());
            counted.and_then(value)
        });
        Estimated {
            value: Estimate::over_runs(subject.measure(), values),
            subject,
            lag_1: None,
        }
    };
    let mut all: Vec<Estimated> = Vec::new();
    for metric in metrics(line) {
        let value = |trace: &Trace| measure(&metric, trace);
        all.push(estimate(Subject::Metric(metric.clone()), &value));
    }
    let stations = traces.first().map_or(&[][..], |trace| &trace.stations);
    for (index, station) in stations.iter().enumerate() {
        let node = station.node;
        let of_station = traces.iter().map(|trace| &trace.stations[index]);
        let causes = of_station.flat_map(|station| &station.waits);
        let causes: BTreeSet<Cause> = causes
            .map(|wait| Cause {
                node,
                kind: wait.kind,
                place: wait.place.clone(),
                station: wait.station.clone(),
            })
            .collect();
        for cause in causes {
            let share = |trace: &Trace| {
                let mut waits = trace.stations[index].waits.iter();
                let wait = waits.find(|wait| {
                    (wait.kind, &wait.place, &wait.station)
                        == (cause.kind, &cause.place, &cause.station)
                });
                Some(wait.map_or(0.0, |wait| wait.share))
            };
            all.push(estimate(Subject::Wait(cause.clone()), &share));
        }
        for state in ByState::STATES {
            let kwh = |trace: &Trace| Some(kwh_in(state, trace.stations[index].joules_by_state));
            all.push(estimate(Subject::Energy { node, state }, &kwh));
        }
    }
    all
}

/// The estimates over the batches of a run, without figures of the whole run.
pub(super) fn of_batches(line: &Line, trace: &Trace) -> Vec<Estimated> {
    let mut all: Vec<Estimated> = Vec::new();
    let metrics = metrics(line).into_iter();
    for metric in metrics.filter(|metric| !batches::is_of_run(metric.measure)) {
        let (value, lag_1) = batches::estimate(&metric, trace);
        all.push(Estimated {
            subject: Subject::Metric(metric),
            value,
            lag_1,
        });
    }
    let name = |node: u32| line.nodes[node as usize].name.clone();
    for station in &trace.stations {
        let node = station.node;
        let batches = trace.batches.iter();
        let of_batches = batches.filter_map(|batch| match batch.places.get(node) {
            Some(PlaceFigures::Station(station)) => Some(station),
            _ => None,
        });
        let causes = of_batches.flat_map(|station| &station.causes);
        let causes: BTreeSet<_> = causes
            .map(|cause| (cause.kind, cause.place, cause.station))
            .collect();
        for cause in causes {
            let (value, lag_1) = batches::estimate_over_time(trace, false, |batch| {
                let Some(PlaceFigures::Station(station)) = batch.places.get(node) else {
                    return 0.0;
                };
                let waits = station.causes.iter();
                let seconds = waits
                    .filter(|wait| (wait.kind, wait.place, wait.station) == cause)
                    .map(|wait| wait.seconds);
                seconds.sum::<f64>() / batch.seconds.max(f64::MIN_POSITIVE)
            });
            let (kind, place, behind) = cause;
            let cause = Cause {
                node,
                kind,
                place: name(place),
                station: behind.map(name),
            };
            let measure = cause.measure();
            all.push(Estimated {
                subject: Subject::Wait(cause),
                value: value.map(|value| value.of_measure(measure)),
                lag_1,
            });
        }
        for state in ByState::STATES {
            let (value, lag_1) = batches::estimate_over_time(trace, true, |batch| {
                let Some(PlaceFigures::Station(station)) = batch.places.get(node) else {
                    return 0.0;
                };
                let kwh = kwh_in(state, station.joules);
                batch.in_all(kwh).unwrap_or(kwh)
            });
            all.push(Estimated {
                subject: Subject::Energy { node, state },
                value: value.map(|value| value.of_measure(Measure::Energy)),
                lag_1,
            });
        }
    }
    all
}

fn kwh_in(state: Measure, joules: ByState) -> f64 {
    joules.of(state).unwrap_or(0.0) / JOULES_PER_KWH
}
