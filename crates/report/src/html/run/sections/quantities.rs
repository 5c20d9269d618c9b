//! Work in progress, lead times, energy, and flow.

use super::super::charts::{Bar, Piece};
use super::super::moments::Moments;
use super::super::picture::{Picture, by_type};
use super::super::series::Curve;
use super::super::{Page, charts, state_class};
use super::{
    STATES, first, idle_name, legend, made, part_class, parts_legend, section_of_first, unpowered,
};
use crate::energy::EnergyUnit;
use crate::html::numbers::{count, figure, percent};
use crate::html::parts::{behind, table};
use linewright_language::contract::line::{NodeKind, declared_name};
use linewright_line::log::Activity;
use linewright_line::trace::{Yields, duration_in_units};
use maud::{Markup, html};

pub(super) fn queues(page: &Page<'_>) -> Markup {
    let (recorder, trace) = (page.recorder, first(page));
    let (units, axis) = (recorder.units(), page.axis());
    let moments = Moments::of(page.line);
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
                duration_in_units(buffer.wait),
                duration_in_units(buffer.longest_wait),
                count(buffer.expired),
            ]
        })
        .collect();
    let inside = html! {
        p { "Work in progress is the number of parts in the line, of all types." }
        (curve_legend(units.width, !buffers.is_empty(), recorder.counting > 0.0))
        (charts::curve("Work in progress over time", &units, axis, None))
        details {
            summary { "Show as a table" }
            @let (seconds, curve) = curve_rows(&units, moments);
            p { "Each row is of " (duration_in_units(seconds)) ", the last one up to the end of the run." }
            (table(&["Time from", "Mean", "Maximum"], &curve))
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
            p { "Products an hour, in bins of " (duration_in_units(width)) "." (last_bin(&throughput, width, recorder.end)) }
            (charts::rate("Throughput over time in products an hour", &throughput, width, axis))
            (behind(&["Time from", "to", "Products an hour"], &throughput.iter().enumerate().map(|(bin, rate)| {
                let (start, stop) = charts::span(bin, throughput.len(), width, recorder.end);
                vec![moments.instant(start), moments.instant(stop), figure(*rate)]
            }).collect::<Vec<_>>()))
        }
        @for (node, capacity, curve) in &buffers {
            h3 { "Parts in " (node.name) }
            (charts::curve(&format!("Parts in {} over time", node.name), curve, axis, Some(*capacity)))
        }
        @if !rows.is_empty() {
            (behind(&["Buffer", "Passed", "Mean length", "Longest", "Full, of all time", "Mean wait of parts that left or expired", "Longest wait of these", "Expired"], &rows))
        }
    };
    section_of_first(page, "queues", "Work in progress and queues", &inside)
}

/// Says how long the last of some bins is, if it is not as long as the others.
fn last_bin(bins: &[f64], width: f64, end: f64) -> String {
    let Some(last) = bins.len().checked_sub(1) else {
        return String::new();
    };
    let (start, stop) = charts::span(last, bins.len(), width, end);
    if (stop - start - width).abs() < 0.5 {
        return String::new();
    }
    format!(" The last one is {} long.", duration_in_units(stop - start))
}

/// The legend of curves with bins of this width in seconds.
fn curve_legend(width: f64, has_capacity: bool, has_warm_up: bool) -> Markup {
    let key = |sign: Markup, text: &str| {
        html! { li { svg.key viewBox="0 0 16 16" aria-hidden="true" { (sign) } (text) } }
    };
    let line = html! { path.line d="M0 8H16" {} };
    let area = html! { rect.area width="16" height="16" {} };
    let capacity = html! { path.capacity d="M0 8H16" {} };
    let warm_up = html! { rect.warmup width="16" height="16" {} };
    let each = duration_in_units(width);
    html! {
        ul.legend aria-label="Curves" {
            (key(line, &format!("the mean of each {each}")))
            (key(area, "up to the maximum in this time"))
            @if has_capacity { (key(capacity, "the capacity of a buffer")) }
            @if has_warm_up { (key(warm_up, "the warm-up")) }
        }
    }
}

/// A curve as some twenty rows of a table, and the seconds of a row.
fn curve_rows(curve: &Curve, moments: Moments) -> (f64, Vec<Vec<String>>) {
    const ROWS: usize = 20;
    let step = curve.means.len().div_ceil(ROWS).max(1);
    let pieces = curve
        .means
        .chunks(step)
        .zip(curve.maxima.chunks(step))
        .enumerate();
    let rows = pieces
        .map(|(index, (means, maxima))| {
            let time = (index * step) as f64 * curve.width;
            let mean = means.iter().sum::<f64>() / means.len() as f64;
            let max = maxima.iter().copied().max().unwrap_or(0);
            let max = u64::try_from(max).unwrap_or(0);
            vec![moments.instant(time), figure(mean), count(max)]
        })
        .collect();
    (step as f64 * curve.width, rows)
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
                format!(
                    "{} to {}",
                    duration_in_units(start),
                    duration_in_units(start + columns.width)
                ),
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
                duration_in_units(product.lead_time.mean),
                duration_in_units(product.lead_time.p50),
                duration_in_units(product.lead_time.p95),
                duration_in_units(product.lead_time.max),
            ]
        })
        .collect();
    let inside = html! {
        p { "From the entry of a product's first part to the completion of the product: mean " (duration_in_units(time.mean)) ", median " (duration_in_units(time.p50)) ", 95th percentile " (duration_in_units(time.p95)) ", maximum " (duration_in_units(time.max)) ". Each column is " (duration_in_units(columns.width)) " wide."
            @if trace.warm_up > 0.0 { " Products that were begun during the warm-up and finished after it count, with all of their time." } }
        @if columns.beyond > 0 { p { (count(columns.beyond)) " products took longer than the chart shows, up to " (duration_in_units(time.max)) "." } }
        (charts::histogram("Number of products by lead time", &columns, "products", &lines))
        (behind(&["Lead time", "Products"], &rows))
        @if !by_type.is_empty() {
            (table(&["Product", "Number", "An hour", "Mean", "Median", "95th percentile", "Maximum"], &by_type))
        }
    };
    section_of_first(page, "lead-times", "Lead times", &inside)
}

pub(super) fn energy(page: &Page<'_>) -> Markup {
    let (trace, recorder) = (first(page), page.recorder);
    if trace.joules <= 0.0 {
        return html! {};
    }
    let joules = recorder.joules.iter();
    let joules = joules.map(|of_node| of_node.iter().sum::<f64>());
    let unit = EnergyUnit::of(joules.fold(0.0, f64::max));
    let symbol = unit.symbol();
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
            all / unit.joules()
        })
    };
    let of_state = |node: usize, state: Activity, name: &'static str| {
        let station = trace.stations.iter().find(|station| station.node == node);
        match station {
            Some(station) if state == Activity::Idle => idle_name(station),
            _ => name,
        }
    };
    let nodes: Vec<(usize, [f64; 6])> = (0..page.line.nodes.len())
        .map(|index| (index, of_node(index)))
        .filter(|(_, energy)| energy.iter().sum::<f64>() > 0.0)
        .collect();
    let total = |energy: &[f64; 6]| energy.iter().sum::<f64>();
    let bars: Vec<Bar> = nodes
        .iter()
        .map(|(index, energy)| Bar {
            name: page.line.nodes[*index].name.clone(),
            pieces: energy
                .iter()
                .zip(STATES)
                .map(|(value, (state, name))| Piece {
                    class: state_class(state).to_owned(),
                    value: *value,
                    title: format!(
                        "{}: {} {symbol}",
                        of_state(*index, state, name),
                        figure(*value)
                    ),
                })
                .collect(),
            total: format!("{} {symbol}", figure(total(energy))),
        })
        .collect();
    let most = nodes
        .iter()
        .map(|(_, energy)| total(energy))
        .fold(0.0, f64::max);
    let rows: Vec<Vec<String>> = nodes
        .iter()
        .map(|(index, energy)| {
            let cells = energy.iter().map(|value| figure(*value));
            let name = page.line.nodes[*index].name.clone();
            std::iter::once(name)
                .chain(cells)
                .chain([figure(total(energy))])
                .collect()
        })
        .collect();
    let mut headings = vec!["Place"];
    headings.extend(STATES.map(|(_, name)| name));
    let all = format!("all, {symbol}");
    headings.push(&all);
    let is_conveyor = |node: usize| matches!(page.line.nodes[node].kind, NodeKind::Conveyor { .. });
    let has_conveyors = nodes.iter().any(|(node, _)| is_conveyor(*node));
    let unpowered = unpowered(page);
    let (watts, width) = recorder.power();
    let kilowatts: Vec<f64> = watts.iter().map(|watts| watts / 1000.0).collect();
    let inside = html! {
        p { "Energy of each place by its state." @if has_conveyors { " All energy of a conveyor is shown as busy: its power while a part moves on it, and its idle power while it stands still." } }
        (charts::bars("Energy of each place by its state", &bars, most))
        (legend())
        (behind(&headings, &rows))
        @if !unpowered.is_empty() { p { "The model gives no power for " (unpowered.join(", ")) ", so their energy is not in these figures." } }
        h3 { "Power over time in kW, mean of each " (duration_in_units(width)) }
        (charts::rate("Power over time in kilowatts", &kilowatts, width, page.axis()))
    };
    section_of_first(page, "energy", "Energy", &inside)
}

pub(super) fn flow(page: &Page<'_>, picture: &Picture) -> Markup {
    let (line, recorder) = (page.line, page.recorder);
    let name = |node: usize| line.nodes[node].name.as_str();
    let ways = picture
        .links
        .iter()
        .map(|&(from, to)| (from, Some(to), recorder.flow(from, to)));
    let scrapped = recorder.scrapped.iter();
    let scrapped = scrapped.map(|(node, numbers)| (*node, None, numbers.as_slice()));
    let flows: Vec<(usize, Option<usize>, &[u64])> = ways.chain(scrapped).collect();
    let bars: Vec<Bar> = flows
        .iter()
        .map(|(from, to, numbers)| Bar {
            name: match to {
                Some(to) => format!("{} to {}", name(*from), name(*to)),
                None => format!("taken out at {}", name(*from)),
            },
            pieces: numbers
                .iter()
                .enumerate()
                .map(|(kind, number)| Piece {
                    class: part_class(kind),
                    value: *number as f64,
                    title: format!("{} {}", count(*number), line.parts[kind].name),
                })
                .collect(),
            total: count(numbers.iter().sum()),
        })
        .collect();
    let most = flows
        .iter()
        .map(|(.., numbers)| numbers.iter().sum::<u64>());
    let most = most.max().unwrap_or(0) as f64;
    let rows: Vec<Vec<String>> = flows
        .iter()
        .map(|(from, to, numbers)| {
            let place = |node: usize| format!("{} {}", line.nodes[node].kind.word(), name(node));
            vec![
                place(*from),
                to.map_or("taken out: scrapped, expired or refused".to_owned(), place),
                count(numbers.iter().sum()),
                by_type(line, numbers),
            ]
        })
        .collect();
    let inside = html! {
        (balance(page))
        (charts::bars("Number of parts that went from place to place, by part type", &bars, most))
        (parts_legend(page, &html! {}))
        (behind(&["From", "To", "Parts", "By part type"], &rows))
        (yields(page))
    };
    section_of_first(page, "flow", "Flow between places", &inside)
}

/// What became of the parts of each type.
fn balance(page: &Page<'_>) -> Markup {
    let kinds = page.line.parts.iter().enumerate();
    let balances = kinds.map(|(kind, part)| {
        let balance = page.recorder.balance(kind);
        let cells = [
            balance.before,
            balance.entered,
            balance.finished,
            balance.rejected + balance.scrapped,
            balance.rejected,
            balance.scrapped,
            balance.joined,
            balance.remaining,
        ];
        (part.name.clone(), cells)
    });
    let balances: Vec<(String, [u64; 8])> = balances.collect();
    let mut all = [0; 8];
    for (_, cells) in &balances {
        for (sum, cell) in all.iter_mut().zip(cells) {
            *sum += cell;
        }
    }
    let rows = balances.into_iter().chain([("all".to_owned(), all)]);
    let rows: Vec<Vec<String>> = rows
        .map(|(name, cells)| std::iter::once(name).chain(cells.map(count)).collect())
        .collect();
    let headings = [
        "Part type",
        "Before",
        "Entered or made",
        "Finished",
        "Rejected",
        "to a reject sink",
        "taken out elsewhere",
        "Joined",
        "At the end",
    ];
    html! {
        p { "Each part was in the line before counting began, or entered it or was made in it later. By the end of the run it had finished, been rejected, or been joined to other parts, or it was still in the line. Rejected parts went to a sink for rejects, or were taken out elsewhere: by a failure, at the end of their shelf life, or because a contract refused them." }
        (table(&headings, &rows))
    }
}

/// First-pass yield and scrap by part type.
fn yields(page: &Page<'_>) -> Markup {
    let of_types = page.line.parts.iter().zip(&first(page).yields_by_type);
    let of_types = of_types.enumerate();
    let products = made(page.line, first(page));
    let row = |name: &str, yields: &Yields, is_product: bool| {
        let share =
            |share: Option<f64>| share.filter(|_| is_product).map_or("-".to_owned(), percent);
        vec![
            name.to_owned(),
            count(yields.finished),
            count(yields.first_pass),
            count(yields.scrapped),
            share(yields.first_pass_yield()),
            share(yields.scrap_ratio()),
        ]
    };
    let rows = of_types.filter(|(_, (_, yields))| yields.finished + yields.scrapped > 0);
    let mut rows: Vec<Vec<String>> = rows
        .map(|(kind, (part, of))| {
            let is_product = products.iter().any(|(product, _)| *product == kind);
            row(&part.name, of, is_product)
        })
        .collect();
    if rows.is_empty() {
        return html! {};
    }
    if rows.len() > 1 {
        rows.push(row("all", &first(page).yields, true));
    }
    let headings = [
        "Left the line as",
        "Worked parts in what finished",
        "of these, without rework",
        "Worked parts in scrap",
        "First-pass yield",
        "Scrap",
    ];
    let nodes = &page.line.nodes;
    let has_copies = nodes
        .iter()
        .any(|node| declared_name(&node.name) != node.name);
    html! {
        h3 { "First-pass yield" }
        p { "Counted are the parts on which a station worked. A joined part counts as the parts in it on which stations worked before they were joined; parts that were only bought and joined do not count. Rework: a station began to work on the part for the second time." @if has_copies { " The copies of a station that is declared with " code { "times" } ", such as " code { "name[1]" } " and " code { "name[2]" } ", count as one station." } " A joined part is a new part: what a station does to it is no rework, even if the same station has worked on a part in it before. If it is reworked itself, so are all parts in it. The yield is the share of the parts without rework in all that finished or were scrapped. Scrap is the share of the scrapped parts in the same total. A type that is no product leaves the line as scrap only, so it has no yield of its own." }
        (table(&headings, &rows))
    }
}
