//! Values of metrics in a run.

use super::trace::{BufferStatistics, Shares, StationStatistics, Trace};
use linewright_language::contract::metric::{Measure, Metric, PlaceKind};

/// Joules in a kilowatt hour.
pub const JOULES_PER_KWH: f64 = 3.6e6;

/// Value of a metric in a run, in its unit; `None` if there was nothing to measure, such as the
/// lead time in a run without products. Of several places it is the mean over those that have a
/// value.
pub fn measure(metric: &Metric, trace: &Trace) -> Option<f64> {
    let nodes = &metric.nodes;
    let values: Vec<f64> = match metric.measure.info().place {
        None => return of_line(metric.measure, trace),
        Some(PlaceKind::Station) => {
            let stations = trace.stations.iter().filter(|s| nodes.contains(&s.node));
            stations
                .map(|station| of_station(metric.measure, station))
                .collect()
        }
        Some(PlaceKind::Buffer) => {
            let buffers = trace.buffers.iter().filter(|b| nodes.contains(&b.node));
            buffers
                .filter_map(|buffer| of_buffer(metric.measure, buffer))
                .collect()
        }
        Some(PlaceKind::Source) => {
            let sources = trace.sources.iter().filter(|s| nodes.contains(&s.node));
            let served = sources.filter(|source| source.passed > 0);
            served.map(|source| source.lost).collect()
        }
    };
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
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
        Measure::Products => Some(trace.products as f64),
        Measure::Violations => Some(trace.violation_count as f64),
        Measure::Throughput => Some(trace.throughput_per_hour),
        _ => unreachable!("{measure:?} is about a place; please report this"),
    }
}

fn of_station(measure: Measure, station: &StationStatistics) -> f64 {
    let Shares {
        busy,
        starved,
        blocked,
        failed,
        idle,
        setup,
    } = station.shares;
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
