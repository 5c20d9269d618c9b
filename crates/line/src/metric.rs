//! Values of metrics in a run, and in its batches.

use super::trace::{BufferStatistics, Oee, Shares, Trace};
use linewright_language::contract::metric::{Measure, Metric, PlaceKind};

/// Joules in a kilowatt hour.
pub const JOULES_PER_KWH: f64 = 3.6e6;

/// What metrics are taken from: a run, or a batch of it.
pub trait Figures {
    /// Value of a measure of the whole line, in its unit; `None` if there was nothing to measure.
    fn of_line(&self, measure: Measure) -> Option<f64>;
    /// Value of a measure of the place with this node; `None` if there was nothing to measure.
    fn of_place(&self, measure: Measure, node: usize) -> Option<f64>;
}

/// Value of a metric in its unit; `None` if there was nothing to measure, such as the lead time in
/// a run without products. Of several places it is the mean over those that have a value.
pub fn measure(metric: &Metric, figures: &impl Figures) -> Option<f64> {
    if metric.measure.info().place.is_none() {
        return figures.of_line(metric.measure);
    }
    let nodes = metric.nodes.clone();
    let values: Vec<f64> = nodes
        .filter_map(|node| figures.of_place(metric.measure, node))
        .collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl Figures for Trace {
    fn of_line(&self, measure: Measure) -> Option<f64> {
        of_line(measure, self)
    }

    fn of_place(&self, measure: Measure, node: usize) -> Option<f64> {
        match measure.info().place? {
            PlaceKind::Station => {
                let station = self.stations.iter().find(|s| s.node == node)?;
                match measure {
                    Measure::Oee => station.oee.as_ref().map(Oee::index),
                    _ => Some(of_station(measure, station.shares)),
                }
            }
            PlaceKind::Buffer => {
                let buffer = self.buffers.iter().find(|b| b.node == node)?;
                of_buffer(measure, buffer)
            }
            PlaceKind::Source => {
                let source = self.sources.iter().find(|s| s.node == node)?;
                (source.passed > 0).then_some(source.lost)
            }
        }
    }
}

fn of_line(measure: Measure, trace: &Trace) -> Option<f64> {
    let of_products = |value: f64| (trace.products > 0).then_some(value);
    let kwh = trace.joules / JOULES_PER_KWH;
    match measure {
        Measure::ThroughputOnShift => trace
            .throughput_on_shift
            .or(Some(trace.throughput_per_hour)),
        Measure::Makespan => of_products(trace.makespan),
        Measure::LeadTime => of_products(trace.lead_time.mean),
        Measure::LeadTimeMedian => of_products(trace.lead_time.p50),
        Measure::LeadTimeP95 => of_products(trace.lead_time.p95),
        Measure::LeadTimeMax => of_products(trace.lead_time.max),
        Measure::Wip => Some(trace.wip.mean),
        Measure::WipMax => Some(trace.wip.max as f64),
        Measure::Energy => Some(kwh),
        Measure::EnergyPerProduct => of_products(kwh / trace.products as f64),
        Measure::Rejected => Some(trace.parts.rejected as f64),
        Measure::FirstPassYield => trace.yields.first_pass_yield(),
        Measure::Scrap => trace.yields.scrap_ratio(),
        Measure::Products => Some(trace.products as f64),
        Measure::Violations => Some(trace.violation_count as f64),
        Measure::Throughput => Some(trace.throughput_per_hour),
        _ => unreachable!("{measure:?} is about a place; please report this"),
    }
}

/// The share of a station's time that a measure is about.
pub(super) fn of_station(measure: Measure, shares: Shares) -> f64 {
    let Shares {
        busy,
        starved,
        blocked,
        failed,
        idle,
        setup,
    } = shares;
    match measure {
        Measure::Busy => busy,
        Measure::Starved => starved,
        Measure::Blocked => blocked,
        Measure::Failed => failed,
        Measure::Idle => idle,
        Measure::Setup => setup,
        _ => unreachable!("{measure:?} is not about a station; please report this"),
    }
}

fn of_buffer(measure: Measure, buffer: &BufferStatistics) -> Option<f64> {
    let of_departures = |value: f64| (buffer.passed > 0).then_some(value);
    match measure {
        Measure::Length => Some(buffer.length),
        Measure::LengthMax => Some(buffer.longest as f64),
        Measure::Full => Some(buffer.full),
        Measure::Wait => of_departures(buffer.wait),
        Measure::WaitMax => of_departures(buffer.longest_wait),
        _ => unreachable!("{measure:?} is not about a buffer; please report this"),
    }
}
