//! Work in progress, lead times, energy, and flow.

use super::super::charts::{Bar, Piece};
use super::super::picture::{Picture, word};
use super::super::series::Curve;
use super::super::{Page, charts, state_class};
use super::{STATES, first, legend};
use crate::html::numbers::{count, figure, percent};
use crate::html::parts::{behind, section, table};
use linewright_language::contract::line::NodeKind;
use linewright_line::log::Activity;
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::duration;
use maud::{Markup, html};

pub(super) fn queues(page: &Page<'_>) -> Markup {
    let (recorder, trace) = (page.recorder, first(page));
    let (units, axis) = (recorder.units(), page.axis());
    let (throughput, width) = recorder.throughput();
    let types = page.line.parts.iter().enumerate();
    let types: Vec<_> = types
        .map(|(kind, part)| (&part.name, recorder.units_of(kind)))
        .filter(|(_, curve)| curve.maxima.iter().any(|max| *max > 0))
        .collect();
    let buffers: Vec<_> = page
        .line
        .nodes
        .iter()
        .enumerate()
        .filter_map(|(index, node)| match node.kind {
            NodeKind::Buffer { capacity, .. } => Some((node, capacity, recorder.buffer(index)?)),
            _ => None,
        })
        .collect();
    let rows: Vec<Vec<String>> = trace
        .buffers
        .iter()
        .map(|buffer| {
            vec![
                buffer.name.clone(),
                count(buffer.passed),
                figure(buffer.length),
                count(buffer.longest),
                percent(buffer.full),
                duration(buffer.wait),
                duration(buffer.longest_wait),
                count(buffer.expired),
            ]
        })
        .collect();
    let inside = html! {
        p { "Work in progress is the number of parts in the line, of all types. Dark: the mean of each " (duration(units.width)) "; light: the maximum. Dashed: the capacity of a buffer."
            @if recorder.counting > 0.0 { " Grey: the warm-up." } }
        (charts::curve("Work in progress over time", &units, axis, None))
        details {
            summary { "Show as a table" }
            (table(&["Time from", "Mean", "Maximum"], &curve_rows(&units)))
        }
        @if types.len() > 1 { details {
            summary { "By part type" }
            @for (name, curve) in &types {
                h3 { (name) }
                (charts::curve(&format!("Parts of type {name} over time"), curve, axis, None))
            }
        } }
        @if trace.products > 0 {
            h3 { "Throughput" }
            p { "Products an hour, in bins of " (duration(width)) "." }
            (charts::rate("Throughput over time in products an hour", &throughput, width, axis))
            (behind(&["Time from", "Products an hour"], &throughput.iter().enumerate().map(|(bin, rate)| {
                vec![duration(bin as f64 * width), figure(*rate)]
            }).collect::<Vec<_>>()))
        }
        @for (node, capacity, curve) in &buffers {
            h3 { "Parts in " (node.name) }
            (charts::curve(&format!("Parts in {} over time", node.name), curve, axis, Some(*capacity)))
        }
        @if !rows.is_empty() {
            (behind(&["Buffer", "Passed", "Mean length", "Longest", "Full", "Mean wait", "Longest wait", "Expired"], &rows))
        }
    };
    section("queues", "Work in progress and queues", &inside)
}

/// A curve as some twenty rows of a table.
fn curve_rows(curve: &Curve) -> Vec<Vec<String>> {
    const ROWS: usize = 20;
    let step = curve.means.len().div_ceil(ROWS).max(1);
    let pieces = curve
        .means
        .chunks(step)
        .zip(curve.maxima.chunks(step))
        .enumerate();
    pieces
        .map(|(index, (means, maxima))| {
            let time = (index * step) as f64 * curve.width;
            let mean = means.iter().sum::<f64>() / means.len() as f64;
            let max = maxima.iter().copied().max().unwrap_or(0);
            vec![duration(time), figure(mean), max.to_string()]
        })
        .collect()
}

pub(super) fn lead_times(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let columns = page.recorder.lead_times.columns();
    if trace.products == 0 || columns.counts.is_empty() {
        return html! {};
    }
    let time = trace.lead_time;
    let lines = [
        ("median", time.p50),
        ("mean", time.mean),
        ("95th percentile", time.p95),
    ];
    let rows: Vec<Vec<String>> = columns
        .counts
        .iter()
        .enumerate()
        .map(|(class, number)| {
            let start = class as f64 * columns.width;
            vec![
                format!("{} to {}", duration(start), duration(start + columns.width)),
                count(*number),
            ]
        })
        .collect();
    let by_type: Vec<Vec<String>> = trace
        .by_type
        .iter()
        .map(|product| {
            vec![
                page.line.parts[product.part].name.clone(),
                count(product.products),
                figure(product.throughput_per_hour),
                duration(product.lead_time.mean),
                duration(product.lead_time.p50),
                duration(product.lead_time.p95),
                duration(product.lead_time.max),
            ]
        })
        .collect();
    let inside = html! {
        p { "From the entry of a product's first part to the completion of the product: mean " (duration(time.mean)) ", median " (duration(time.p50)) ", 95th percentile " (duration(time.p95)) ", maximum " (duration(time.max)) "." }
        @if columns.beyond > 0 { p { (count(columns.beyond)) " products took longer than the chart shows, up to " (duration(time.max)) "." } }
        (charts::histogram("Number of products by lead time", &columns, &lines))
        (behind(&["Lead time", "Products"], &rows))
        @if !by_type.is_empty() {
            (table(&["Product", "Number", "An hour", "Mean", "Median", "95th percentile", "Maximum"], &by_type))
        }
    };
    section("lead-times", "Lead times", &inside)
}

pub(super) fn energy(page: &Page<'_>) -> Markup {
    let (trace, recorder) = (first(page), page.recorder);
    if trace.joules <= 0.0 {
        return html! {};
    }
    let of_node = |index: usize| {
        STATES.map(|(state, _)| {
            let joules = &recorder.joules[index];
            let of = |more: Activity| joules[more as usize];
            let unused = recorder.waiting(index) == Activity::Idle;
            let all = match state {
                Activity::Failed => of(state) + of(Activity::FailedOffShift),
                Activity::Idle if unused => of(state) + of(Activity::Starved),
                Activity::Starved if unused => 0.0,
                _ => of(state),
            };
            all / JOULES_PER_KWH
        })
    };
    let nodes: Vec<(usize, [f64; 6])> = (0..page.line.nodes.len())
        .map(|index| (index, of_node(index)))
        .filter(|(_, kwh)| kwh.iter().sum::<f64>() > 0.0)
        .collect();
    let total = |kwh: &[f64; 6]| kwh.iter().sum::<f64>();
    let bars: Vec<Bar> = nodes
        .iter()
        .map(|(index, kwh)| Bar {
            name: page.line.nodes[*index].name.clone(),
            pieces: kwh
                .iter()
                .zip(STATES)
                .map(|(value, (state, name))| Piece {
                    class: state_class(state),
                    value: *value,
                    title: format!("{name}: {} kWh", figure(*value)),
                })
                .collect(),
            total: format!("{} kWh", figure(total(kwh))),
        })
        .collect();
    let most = nodes.iter().map(|(_, kwh)| total(kwh)).fold(0.0, f64::max);
    let rows: Vec<Vec<String>> = nodes
        .iter()
        .map(|(index, kwh)| {
            let cells = kwh.iter().map(|value| figure(*value));
            let name = page.line.nodes[*index].name.clone();
            std::iter::once(name)
                .chain(cells)
                .chain([figure(total(kwh))])
                .collect()
        })
        .collect();
    let mut headings = vec!["Place"];
    headings.extend(STATES.map(|(_, name)| name));
    headings.push("all, kWh");
    let unpowered: Vec<&str> = trace
        .stations
        .iter()
        .filter(|station| nodes.iter().all(|(index, _)| *index != station.node))
        .map(|station| station.name.as_str())
        .collect();
    let (watts, width) = recorder.power();
    let kilowatts: Vec<f64> = watts.iter().map(|watts| watts / 1000.0).collect();
    let inside = html! {
        p { "Energy of each place by its state." }
        (charts::bars("Energy of each place by its state", &bars, most))
        (legend())
        (behind(&headings, &rows))
        @if !unpowered.is_empty() { p { "No power is given for " (unpowered.join(", ")) "." } }
        h3 { "Power over time in kW, mean of each " (duration(width)) }
        (charts::rate("Power over time in kilowatts", &kilowatts, width, page.axis()))
    };
    section("energy", "Energy", &inside)
}

pub(super) fn flow(page: &Page<'_>, picture: &Picture) -> Markup {
    let line = page.line;
    let of = |link: &(usize, usize)| page.recorder.flow.get(link).copied().unwrap_or(0);
    let most = picture.links.iter().map(of).max().unwrap_or(0) as f64;
    let name = |node: usize| line.nodes[node].name.as_str();
    let bars: Vec<Bar> = picture
        .links
        .iter()
        .map(|link| Bar {
            name: format!("{} to {}", name(link.0), name(link.1)),
            pieces: vec![Piece {
                class: "column",
                value: of(link) as f64,
                title: format!("{} parts", count(of(link))),
            }],
            total: count(of(link)),
        })
        .collect();
    let rows: Vec<Vec<String>> = picture
        .links
        .iter()
        .map(|link| {
            let kinds = [
                word(&line.nodes[link.0].kind),
                word(&line.nodes[link.1].kind),
            ];
            vec![
                format!("{} {}", kinds[0], name(link.0)),
                format!("{} {}", kinds[1], name(link.1)),
                count(of(link)),
            ]
        })
        .collect();
    let parts = first(page).parts;
    let inside = html! {
        p {
            (count(parts.before)) " parts were in the line when counting began, and " (count(parts.entered)) " entered. "
            (count(parts.finished)) " finished, " (count(parts.rejected)) " were rejected, " (count(parts.consumed))
            " were joined to others, and " (count(parts.in_progress)) " were in the line at the end."
        }
        (charts::bars("Number of parts that went from place to place", &bars, most))
        (behind(&["From", "To", "Parts"], &rows))
    };
    section("flow", "Flow between places", &inside)
}
