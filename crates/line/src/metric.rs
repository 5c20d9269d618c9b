//! Values of metrics in a run, and in its batches.

use super::trace::{
    BufferStatistics, ByState, ConveyorStatistics, LeadTime, Oee, Percentiles, StationStatistics,
    Trace, Yields,
};
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::{Measure, Metric};

/// Joules in a kilowatt hour.
pub const JOULES_PER_KWH: f64 = 3.6e6;

/// What metrics are taken from: a run, or a batch of it.
pub trait Figures {
    /// Whether anything was counted: not in a run that ended during its warm-up.
    fn has_counted(&self) -> bool {
        true
    }
    /// Value of a metric of the whole line, in its unit; `None` if there was nothing to measure.
    fn of_line(&self, metric: &Metric) -> Option<f64>;
    /// Value of a metric of an end product.
    fn of_product(&self, metric: &Metric, product: usize) -> Option<f64>;
    /// Value of a metric of the place with this node; `None` if there was nothing to measure.
    fn of_place(&self, metric: &Metric, node: usize) -> Option<f64>;
}

/// Value of a metric in its unit; `None` if there was nothing to measure, such as the lead time in
/// a run without products. Of several places it is the mean over those that have a value.
pub fn measure(metric: &Metric, figures: &impl Figures) -> Option<f64> {
    // Violations count from the start.
    if !figures.has_counted() && metric.measure != Measure::Violations {
        return None;
    }
    if let Some(product) = metric.product {
        return figures.of_product(metric, product);
    }
    if metric.nodes.is_empty() {
        return figures.of_line(metric);
    }
    let nodes = metric.nodes.clone();
    let values: Vec<f64> = nodes
        .filter_map(|node| figures.of_place(metric, node))
        .collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The percentiles of lead times that the requirements of a line speak of.
pub(super) fn percentiles_of_lead_time(line: &Line) -> Vec<u8> {
    percentiles(line, |metric| metric.measure == Measure::LeadTimePercentile)
}

/// The percentiles of the waiting time in a buffer that the requirements of a line speak of.
pub(super) fn percentiles_of_wait(line: &Line, node: usize) -> Vec<u8> {
    percentiles(line, |metric| {
        metric.measure == Measure::WaitPercentile && metric.nodes.contains(&node)
    })
}

fn percentiles(line: &Line, wanted: impl Fn(&Metric) -> bool) -> Vec<u8> {
    let metrics = line.requirements.iter().map(|r| &r.metric);
    let mut numbers: Vec<u8> = metrics
        .filter(|metric| wanted(metric))
        .map(|metric| metric.percentile)
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Value of a measure of lead times; `None` for another measure.
pub(super) fn of_lead_time(
    metric: &Metric,
    times: LeadTime,
    percentiles: &Percentiles,
) -> Option<f64> {
    match (metric.measure, metric.percentile) {
        (Measure::LeadTime, _) => Some(times.mean),
        (Measure::LeadTimeMedian, _) | (Measure::LeadTimePercentile, 50) => Some(times.p50),
        (Measure::LeadTimePercentile, 95) => Some(times.p95),
        (Measure::LeadTimePercentile, number) => percentiles.get(number),
        (Measure::LeadTimeMax, _) => Some(times.max),
        _ => None,
    }
}

impl Figures for Trace {
    fn has_counted(&self) -> bool {
        self.warm_up <= 0.0 || self.seconds > self.warm_up
    }

    fn of_line(&self, metric: &Metric) -> Option<f64> {
        of_line(metric, self)
    }

    fn of_product(&self, metric: &Metric, product: usize) -> Option<f64> {
        if let Some(share) = yield_share(metric.measure) {
            return self.yields_by_type.get(product).and_then(share);
        }
        // Without several products, that of the line is the only one.
        if self.by_type.is_empty() {
            return of_line(metric, self);
        }
        let of = self.by_type.iter().find(|of| of.part == product)?;
        match metric.measure {
            Measure::Throughput => Some(of.throughput_per_hour),
            Measure::ThroughputOnShift => {
                let rate = self.throughput_on_shift.unwrap_or(self.throughput_per_hour);
                let all = self.products.max(1) as f64;
                Some(rate * of.products as f64 / all)
            }
            Measure::Products => Some(of.products as f64),
            _ if of.products == 0 => None,
            _ => of_lead_time(metric, of.lead_time, &of.lead_time_percentiles),
        }
    }

    fn of_place(&self, metric: &Metric, node: usize) -> Option<f64> {
        // All are in line order.
        if let Ok(at) = self.stations.binary_search_by_key(&node, |s| s.node) {
            return of_station_in_run(metric.measure, &self.stations[at]);
        }
        if let Ok(at) = self.buffers.binary_search_by_key(&node, |b| b.node) {
            return of_buffer(metric, &self.buffers[at]);
        }
        if let Ok(at) = self.conveyors.binary_search_by_key(&node, |c| c.node) {
            return Some(of_conveyor(metric.measure, &self.conveyors[at]));
        }
        let at = self.sources.binary_search_by_key(&node, |s| s.node).ok()?;
        let source = &self.sources[at];
        (source.passed > 0).then_some(source.lost)
    }
}

fn of_line(metric: &Metric, trace: &Trace) -> Option<f64> {
    let of_products = |value: f64| (trace.products > 0).then_some(value);
    let kwh = trace.joules / JOULES_PER_KWH;
    match metric.measure {
        Measure::ThroughputOnShift => trace
            .throughput_on_shift
            .or(Some(trace.throughput_per_hour)),
        Measure::Makespan => of_products(trace.makespan),
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
        _ if trace.products == 0 => None,
        _ => of_lead_time(metric, trace.lead_time, &trace.lead_time_percentiles),
    }
}

/// The share of single parts that a measure is; `None` for another measure.
pub(super) fn yield_share(measure: Measure) -> Option<fn(&Yields) -> Option<f64>> {
    match measure {
        Measure::FirstPassYield => Some(Yields::first_pass_yield),
        Measure::Scrap => Some(Yields::scrap_ratio),
        _ => None,
    }
}

fn of_station_in_run(measure: Measure, station: &StationStatistics) -> Option<f64> {
    if let Some(factor) = oee_factor(measure) {
        return station.oee.as_ref().map(factor);
    }
    Some(match measure {
        Measure::Energy => station.joules / JOULES_PER_KWH,
        _ => of_station(measure, station.shares),
    })
}

/// The overall equipment effectiveness, or the factor of it, that a measure is; `None` for another
/// measure.
pub(super) fn oee_factor(measure: Measure) -> Option<fn(&Oee) -> f64> {
    match measure {
        Measure::Oee => Some(Oee::index),
        Measure::Availability => Some(|oee| oee.availability),
        Measure::Effectiveness => Some(|oee| oee.effectiveness),
        Measure::Quality => Some(|oee| oee.quality),
        _ => None,
    }
}

fn of_conveyor(measure: Measure, conveyor: &ConveyorStatistics) -> f64 {
    match measure {
        Measure::Energy => conveyor.joules / JOULES_PER_KWH,
        Measure::Length => conveyor.length,
        Measure::LengthMax => conveyor.longest as f64,
        _ => unreachable!("{measure:?} is not about a conveyor; please report this"),
    }
}

/// The share of a station's time that a measure is about.
pub(super) fn of_station(measure: Measure, shares: ByState) -> f64 {
    match shares.of(measure) {
        Some(share) => share,
        None => unreachable!("{measure:?} is not about a station; please report this"),
    }
}

fn of_buffer(metric: &Metric, buffer: &BufferStatistics) -> Option<f64> {
    let of_departures = |value: f64| (buffer.passed + buffer.expired > 0).then_some(value);
    match metric.measure {
        Measure::Length => Some(buffer.length),
        Measure::LengthMax => Some(buffer.longest as f64),
        Measure::Full => Some(buffer.full),
        Measure::Wait => of_departures(buffer.wait),
        Measure::WaitPercentile => buffer.wait_percentiles.get(metric.percentile),
        Measure::WaitMax => of_departures(buffer.longest_wait),
        Measure::Expired => Some(buffer.expired as f64),
        measure => unreachable!("{measure:?} is not about a buffer; please report this"),
    }
}
