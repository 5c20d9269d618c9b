//! The sections of a page, from top to bottom.

use super::charts::{self, Bar, Piece, Range};
use super::numbers::{count, figure, percent};
use super::picture::{Picture, word};
use super::{Page, state_class};
use crate::table::{bottleneck, required};
use crate::{Intervals, Variant};
use anstream::adapter::strip_str;
use linewright_core::diagnostics::render;
use linewright_core::gr1::Formula;
use linewright_core::source::SourceMap;
use linewright_language::contract::line::NodeKind;
use linewright_language::contract::metric::Measure;
use linewright_line::log::Activity;
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::{End, StationStatistics, Violation, duration};
use linewright_line::{Estimate, Trace};
use maud::{Markup, html};
use sha2::{Digest, Sha256};

/// States of a station with their names, in the order of the bars.
const STATES: [(Activity, &str); 6] = [
    (Activity::Busy, "busy"),
    (Activity::Setup, "setup"),
    (Activity::Failed, "failed"),
    (Activity::Blocked, "blocked"),
    (Activity::Starved, "starved"),
    (Activity::Idle, "off shift"),
];

pub(super) fn all(page: &Page<'_>, picture: &Picture) -> Markup {
    html! {
        (header(page))
        main {
            (tiles(page))
            (animation(page, picture))
            (requirements(page))
            (replications(page))
            (comparison(page))
            (stations(page))
            (timeline(page))
            (queues(page))
            (lead_times(page))
            (energy(page))
            (flow(page, picture))
            (violations(page))
            (model(page))
        }
    }
}

/// A section with its heading.
fn section(id: &str, heading: &str, inside: &Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby=(format!("{id}-heading")) {
            h2 id=(format!("{id}-heading")) { (heading) }
            (inside)
        }
    }
}

/// A table behind a chart.
fn behind(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        details {
            summary { "Show as a table" }
            (table(headings, rows))
        }
    }
}

/// A table. The first column names the rows; others that hold numbers are aligned on the right.
fn table(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    let is_number = |column: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(column));
        cells.all(|cell| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-'))
    };
    let class = |column: usize| (column > 0 && is_number(column)).then_some("number");
    html! {
        div.scroll tabindex="0" role="group" aria-label="Table" {
            table {
                thead { tr { @for (column, heading) in headings.iter().enumerate() {
                    th scope="col" class=[class(column)] { (heading) }
                } } }
                tbody { @for row in rows { tr { @for (column, cell) in row.iter().enumerate() {
                    @if column == 0 { th scope="row" { (cell) } } @else { td class=[class(column)] { (cell) } }
                } } } }
            }
        }
    }
}

fn header(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let links = [
        ("line-section", "Line", true),
        (
            "requirements",
            "Requirements",
            !page.line.requirements.is_empty(),
        ),
        ("replications", "Intervals", page.intervals.is_some()),
        ("comparison", "Comparison", page.comparison.is_some()),
        ("stations", "Stations", !trace.stations.is_empty()),
        ("timeline", "Timeline", !trace.stations.is_empty()),
        ("queues", "WIP and queues", true),
        ("lead-times", "Lead times", trace.products > 0),
        ("energy", "Energy", trace.joules > 0.0),
        ("flow", "Flow", true),
        ("violations", "Violations", trace.violation_count > 0),
        ("model", "Model", true),
    ];
    html! {
        header {
            h1 { (page.line.name) }
            @if !page.line.doc.is_empty() { p.doc { (page.line.doc) } }
            p {
                (duration(trace.seconds)) " simulated, random seed " (trace.seed)
                @if page.traces.len() > 1 { "; the first of " (page.traces.len()) " replications" }
                @if trace.warm_up > 0.0 { "; warm-up " (duration(trace.warm_up)) ", not counted" }
                ". " (ending(trace.end))
            }
            nav aria-label="Sections" { @for (id, name, is_there) in links { @if is_there {
                a href=(format!("#{id}")) { (name) }
            } } }
        }
    }
}

fn ending(end: End) -> &'static str {
    match end {
        End::Products => "The run ended with the last product.",
        End::Time => "The run ended at its time.",
        End::Blocked => "The run ended early: the line can no longer advance.",
        End::PartLost => "The run ended early: a conveyor lost a part.",
        End::GaveUp => "The run was cut off at the time limit.",
    }
}

fn first<'a>(page: &Page<'a>) -> &'a Trace {
    &page.traces[0]
}

fn tile(name: &str, value: &str, note: &str) -> Markup {
    html! {
        div.tile { dt { (name) } dd { (value) } dd.note { (note) } }
    }
}

fn tiles(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let estimate = |measure: Measure| {
        let estimate = estimate(page, measure)?;
        let half = estimate.half_width?;
        let show = |value: f64| match measure {
            Measure::LeadTime => duration(value),
            _ => figure(value),
        };
        let (mean, half) = (show(estimate.mean), show(half));
        Some(format!("mean {mean} ± {half} (95 %)"))
    };
    let note = |measure: Measure, otherwise: String| estimate(measure).unwrap_or(otherwise);
    let on_shift = trace.throughput_on_shift;
    let lead_time = trace.lead_time;
    let has_products = trace.products > 0;
    let oees: Vec<f64> = trace
        .stations
        .iter()
        .filter_map(|s| s.oee.map(|oee| oee.index()))
        .collect();
    let per_product = trace.joules / JOULES_PER_KWH / trace.products.max(1) as f64;
    html! {
        dl.tiles {
            (tile("Products", &count(trace.products), &rejected(trace)))
            (tile("Throughput", &format!("{} / h", figure(trace.throughput_per_hour)),
                &note(Measure::Throughput, on_shift.map_or(String::new(), |rate| format!("{} / h on shift", figure(rate))))))
            @if has_products {
                (tile("Lead time", &duration(lead_time.mean),
                    &note(Measure::LeadTime, format!("median {}, 95th percentile {}", duration(lead_time.p50), duration(lead_time.p95)))))
            }
            (tile("Work in progress", &figure(trace.wip.mean), &note(Measure::Wip, format!("at most {}", trace.wip.max))))
            @if !oees.is_empty() {
                (tile("OEE", &percent(oees.iter().sum::<f64>() / oees.len() as f64), "mean of the stations"))
            }
            @if trace.joules > 0.0 {
                (tile("Energy", &format!("{} kWh", figure(trace.joules / JOULES_PER_KWH)),
                    &if has_products { format!("{} kWh a product", figure(per_product)) } else { String::new() }))
            }
            @if let Some(yield_) = trace.yields.first_pass_yield() {
                (tile("First-pass yield", &percent(yield_), &trace.yields.scrap_ratio().map_or(String::new(), |scrap| format!("scrap {}", percent(scrap)))))
            }
            (tile("Violations", &count(trace.violation_count), "of contracts"))
            div.tile.wide { dt { "Bottleneck" } dd.text { (bottleneck(&trace.bottleneck)) } }
        }
    }
}

fn rejected(trace: &Trace) -> String {
    match trace.parts.rejected {
        0 => "none rejected".to_owned(),
        number => format!("{} parts rejected", count(number)),
    }
}

/// The estimate of a measure over replications or batches.
fn estimate(page: &Page<'_>, measure: Measure) -> Option<Estimate> {
    match page.intervals? {
        Intervals::Replications(runs) => match measure {
            Measure::Throughput => runs.throughput_per_hour,
            Measure::LeadTime => runs.lead_time,
            Measure::LeadTimeP95 => runs.lead_time_p95,
            Measure::Wip => runs.wip,
            Measure::Makespan => runs.makespan,
            Measure::Energy => runs.energy_kwh,
            _ => None,
        },
        Intervals::Batches(batches) => {
            let mut estimates = batches.estimates.iter();
            estimates.find(|e| e.measure == measure)?.value
        }
    }
}

fn legend() -> Markup {
    html! {
        ul.legend aria-label="States" { @for (state, name) in STATES {
            li { svg.key viewBox="0 0 16 16" aria-hidden="true" { rect class=(state_class(state)) width="16" height="16" {} } (name) }
        } }
    }
}

fn animation(page: &Page<'_>, picture: &Picture) -> Markup {
    let trace = first(page);
    let inside = html! {
        div.controls role="group" aria-label="Playback" {
            button #play type="button" aria-pressed="false" { "Play" }
            button #back type="button" aria-label="Previous event" { "◀ Event" }
            button #forward type="button" aria-label="Next event" { "Event ▶" }
            label { "Speed " select #speed {} }
            @if trace.violation_count > 0 { button #violation type="button" { "Next violation" } }
            output #clock for="time" { "0:00:00" }
        }
        div.axis {
            input #time type="range" min="0" max="1000" value="0" step="any" aria-label="Time of the run";
            svg #marks viewBox="0 0 1000 10" preserveAspectRatio="none" aria-hidden="true" {}
        }
        div.scroll.picture tabindex="0" role="group" aria-label="Picture" { (picture.draw(page.line, &page.recorder.flow)) }
        p #status role="status" { "Point at a place, or move the focus to it, to see what it does." }
        (legend())
        ul.legend aria-label="Parts" { @for (index, part) in page.line.parts.iter().enumerate() {
            li { svg.key viewBox="-8 -8 16 16" aria-hidden="true" { (part_shape(index)) } (part.name) }
        } }
        svg width="0" height="0" aria-hidden="true" { defs {
            @for index in 0..page.line.parts.len() { g id=(format!("part{index}")) { (part_shape(index)) } }
            (patterns())
        } }
        p.hint #cut {}
    };
    section("line-section", "The line", &inside)
}

/// The shape of a part of this type: shape and colour tell types apart.
fn part_shape(index: usize) -> Markup {
    let class = format!("part part{}", index % 6);
    html! {
        @match index % 4 {
            0 => circle class=(class) r="5" {},
            1 => rect class=(class) x="-4.5" y="-4.5" width="9" height="9" {},
            2 => path class=(class) d="M0 -6L6 4.5H-6Z" {},
            _ => path class=(class) d="M0 -6L6 0L0 6L-6 0Z" {},
        }
    }
}

/// Patterns by which states can be distinguished without colours.
fn patterns() -> Markup {
    let lines = [
        ("blocked-pattern", "M0 8L8 0M-2 2L2 -2M6 10L10 6"),
        ("failed-pattern", "M0 0L8 8M0 8L8 0"),
        ("setup-pattern", "M2 0V8M6 0V8"),
        ("starved-pattern", "M0 4H8"),
    ];
    html! {
        @for (id, path) in lines {
            pattern id=(id) width="8" height="8" patternUnits="userSpaceOnUse" {
                rect.ground width="8" height="8" {}
                path.hatch d=(path) {}
            }
        }
    }
}

fn requirements(page: &Page<'_>) -> Markup {
    let line = page.line;
    if line.requirements.is_empty() {
        return html! {};
    }
    let results = match page.intervals {
        Some(Intervals::Replications(runs)) => Some(&runs.requirements),
        Some(Intervals::Batches(batches)) => Some(&batches.requirements),
        None => None,
    };
    let rows: Vec<Vec<String>> =
        line.requirements
            .iter()
            .enumerate()
            .map(|(index, requirement)| {
                let (verdict, value) = match results {
                    Some(results) => results.get(index).map_or(("-", "-".to_owned()), |result| {
                        (result.verdict.word(), interval(result.value))
                    }),
                    None => first(page).requirements.get(index).map_or(
                        ("-", "-".to_owned()),
                        |result| {
                            let value = result.value.map_or("-".to_owned(), figure);
                            (result.verdict().word(), value)
                        },
                    ),
                };
                vec![
                    requirement.name.clone(),
                    verdict.to_owned(),
                    required(line, index),
                    value,
                ]
            })
            .collect();
    section(
        "requirements",
        "Requirements",
        &table(&["Requirement", "Verdict", "Required", "Measured"], &rows),
    )
}

/// A mean with its interval, as text.
fn interval(estimate: Option<Estimate>) -> String {
    let Some(Estimate { mean, half_width }) = estimate else {
        return "-".to_owned();
    };
    match half_width {
        Some(half) => format!(
            "{} ({} to {})",
            figure(mean),
            figure(mean - half),
            figure(mean + half)
        ),
        None => figure(mean),
    }
}

fn replications(page: &Page<'_>) -> Markup {
    const SHOWN: [Measure; 6] = [
        Measure::Throughput,
        Measure::LeadTime,
        Measure::LeadTimeP95,
        Measure::Wip,
        Measure::Makespan,
        Measure::Energy,
    ];
    let (heading, about) = match page.intervals {
        None => return html! {},
        Some(Intervals::Replications(runs)) => (
            "Replications",
            format!(
                "Means of {} runs with 95 % confidence intervals. Each small dot is a run.",
                runs.seeds.len()
            ),
        ),
        Some(Intervals::Batches(batches)) => (
            "Batch means",
            format!(
                "Means of {} batches of the run with 95 % confidence intervals.",
                batches.count
            ),
        ),
    };
    let is_single = matches!(page.intervals, Some(Intervals::Batches(_)));
    let ranges: Vec<Range> = SHOWN
        .iter()
        .filter_map(|measure| {
            let Estimate { mean, half_width } = estimate(page, *measure)?;
            let half = half_width.unwrap_or(0.0);
            Some(Range {
                name: measure.info().label.to_owned(),
                low: mean - half,
                mean,
                high: mean + half,
                values: if is_single {
                    Vec::new()
                } else {
                    of_runs(*measure, page.traces)
                },
                with_zero: false,
            })
        })
        .collect();
    let rows: Vec<Vec<String>> = page
        .traces
        .iter()
        .map(|trace| {
            let cells = SHOWN.iter().map(|measure| {
                of_runs(*measure, std::slice::from_ref(trace))
                    .first()
                    .map_or("-".to_owned(), |v| figure(*v))
            });
            std::iter::once(trace.seed.to_string())
                .chain(cells)
                .collect()
        })
        .collect();
    let headings: Vec<&str> = std::iter::once("Seed")
        .chain(SHOWN.map(|m| m.info().label))
        .collect();
    let inside = html! {
        p { (about) }
        (charts::ranges(heading, &ranges))
        @if !is_single { (behind(&headings, &rows)) }
    };
    section("replications", heading, &inside)
}

/// Values of a measure in runs that have one.
fn of_runs(measure: Measure, traces: &[Trace]) -> Vec<f64> {
    use linewright_line::metric::Figures as _;
    traces
        .iter()
        .filter_map(|trace| trace.of_line(measure))
        .collect()
}

fn comparison(page: &Page<'_>) -> Markup {
    let Some(compared) = page.comparison else {
        return html! {};
    };
    let shown = compared
        .comparisons
        .iter()
        .filter(|c| c.as_it_is != 0.0 || c.what_if != 0.0);
    let ranges: Vec<Range> = shown
        .clone()
        .map(|c| {
            let half = c.difference.half_width.unwrap_or(0.0);
            Range {
                name: c.measure.info().label.to_owned(),
                low: c.difference.mean - half,
                mean: c.difference.mean,
                high: c.difference.mean + half,
                values: Vec::new(),
                with_zero: true,
            }
        })
        .collect();
    let rows: Vec<Vec<String>> = shown
        .map(|c| {
            let significant = match c.is_significant() {
                Some(true) => "yes",
                Some(false) => "no",
                None => "-",
            };
            vec![
                c.measure.info().label.to_owned(),
                figure(c.as_it_is),
                figure(c.what_if),
                interval(Some(c.difference)),
                significant.to_owned(),
            ]
        })
        .collect();
    let inside = html! {
        p { "What if " (changes(compared.variant)) "? Both lines were run with the same random seeds. The chart shows the differences with their paired 95 % confidence intervals." }
        (charts::ranges("Differences", &ranges))
        (table(&["Measure", "As it is", "What if", "Difference", "More than noise"], &rows))
        @if let Some(other) = compared.traces.first() {
            h3 { "Where the time goes, as it is" }
            (shares(&first(page).stations))
            h3 { "Where the time goes, what if" }
            (shares(&other.stations))
        }
    };
    section("comparison", "Comparison", &inside)
}

fn changes(variant: &Variant) -> String {
    let set = variant
        .set
        .iter()
        .map(|(name, value)| format!("{name} = {value}"));
    let speeds = variant.speeds.iter().map(|(name, speed)| {
        let word = if *speed < 1.0 { "slower" } else { "faster" };
        format!(
            "{name} works {} % {word}",
            figure((speed - 1.0).abs() * 100.0)
        )
    });
    set.chain(speeds).collect::<Vec<_>>().join(" and ")
}

/// Shares of a station's time in the order of [`STATES`].
fn of_states(station: &StationStatistics) -> [f64; 6] {
    let shares = &station.shares;
    [
        shares.busy,
        shares.setup,
        shares.failed,
        shares.blocked,
        shares.starved,
        shares.idle,
    ]
}

fn shares(stations: &[StationStatistics]) -> Markup {
    let bars: Vec<Bar> = stations
        .iter()
        .map(|station| Bar {
            name: station.name.clone(),
            pieces: of_states(station)
                .into_iter()
                .zip(STATES)
                .map(|(value, (state, name))| Piece {
                    class: state_class(state),
                    value,
                    title: format!("{} {name}: {}", station.name, percent(value)),
                })
                .collect(),
            total: percent(station.shares.busy),
        })
        .collect();
    charts::bars("Shares of the time of each station", &bars, 1.0)
}

fn stations(page: &Page<'_>) -> Markup {
    let stations = &first(page).stations;
    if stations.is_empty() {
        return html! {};
    }
    let rows: Vec<Vec<String>> = stations
        .iter()
        .map(|station| {
            let mut row = vec![
                station.name.clone(),
                station
                    .machine
                    .clone()
                    .unwrap_or_else(|| "not controlled".to_owned()),
                count(station.processed),
            ];
            row.extend(of_states(station).map(percent));
            row.push(
                station
                    .work_time
                    .map_or("-".to_owned(), |work| duration(work.seconds)),
            );
            row.extend(match &station.oee {
                Some(oee) => [
                    oee.index(),
                    oee.availability,
                    oee.effectiveness,
                    oee.quality,
                ]
                .map(percent),
                None => ["-"; 4].map(str::to_owned),
            });
            row.push(count(station.scrapped));
            row
        })
        .collect();
    let mut headings = vec!["Station", "Machine", "Processed"];
    headings.extend(STATES.map(|(_, name)| name));
    headings.extend([
        "Work a part",
        "OEE",
        "Availability",
        "Effectiveness",
        "Quality",
        "Scrapped",
    ]);
    let waits: Vec<Vec<String>> = stations
        .iter()
        .flat_map(|station| station.waits.iter().map(move |wait| (station, wait)))
        .filter(|(_, wait)| wait.share >= 0.005)
        .map(|(station, wait)| {
            let kind = match wait.kind {
                linewright_line::trace::WaitKind::Blocked => "blocked by",
                linewright_line::trace::WaitKind::Starved => "starved of parts from",
            };
            vec![
                station.name.clone(),
                format!("{kind} {}", wait.place),
                percent(wait.share),
                percent(wait.failed),
                percent(wait.off_shift),
            ]
        })
        .collect();
    let inside = html! {
        p { "Shares of the time of each station; at the end of each bar is its busy share." }
        (shares(stations))
        (legend())
        (behind(&headings, &rows))
        @if !waits.is_empty() {
            h3 { "What the stations waited for" }
            p { "Causes of at least 0.5 % of a station's time." }
            (table(&["Station", "It was", "Share of the time", "of which failed there", "off shift there"], &waits))
        }
        h3 { "Bottleneck" }
        p { (bottleneck(&first(page).bottleneck)) ". Stations before a bottleneck are blocked, and those behind it are starved." }
    };
    section("stations", "Where the time goes", &inside)
}

fn timeline(page: &Page<'_>) -> Markup {
    if first(page).stations.is_empty() {
        return html! {};
    }
    let inside = html! {
        p { "Drag to move, turn the wheel or press + and − to zoom, 0 to see all. A click sets the time of the picture above." }
        div.controls role="group" aria-label="Zoom" {
            button #zoom-in type="button" { "Zoom in" }
            button #zoom-out type="button" { "Zoom out" }
            button #zoom-all type="button" { "All" }
            output #window {}
        }
        div.timeline {
            canvas #gantt tabindex="0" role="img" aria-label="States of the stations over time. Shares are in the table of the section before." {}
            div #cursor {}
        }
        (legend())
    };
    section("timeline", "Timeline of the stations", &inside)
}

fn queues(page: &Page<'_>) -> Markup {
    let (recorder, trace) = (page.recorder, first(page));
    let units = recorder.units();
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
        p { "Work in progress: the number of parts in the line. The line is the mean of each piece of time, the area its maximum." }
        (charts::curve("Work in progress over time", &units, recorder.counting, None))
        details {
            summary { "Show as a table" }
            (table(&["Time from", "Mean", "Maximum"], &curve_rows(&units)))
        }
        @for (node, capacity, curve) in &buffers {
            h3 { "Parts in " (node.name) }
            (charts::curve(&format!("Parts in {} over time", node.name), curve, recorder.counting, Some(*capacity)))
        }
        @if !rows.is_empty() {
            (behind(&["Buffer", "Passed", "Mean length", "Longest", "Full", "Mean wait", "Longest wait", "Expired"], &rows))
        }
    };
    section("queues", "Work in progress and queues", &inside)
}

/// A curve as some twenty rows of a table.
fn curve_rows(curve: &super::series::Curve) -> Vec<Vec<String>> {
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

fn lead_times(page: &Page<'_>) -> Markup {
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
        @if columns.beyond > 0 { p { (count(columns.beyond)) " products took longer than the chart shows." } }
        (charts::histogram("Number of products by lead time", &columns, &lines))
        (behind(&["Lead time", "Products"], &rows))
        @if !by_type.is_empty() {
            (table(&["Product", "Number", "An hour", "Mean", "Median", "95th percentile", "Maximum"], &by_type))
        }
    };
    section("lead-times", "Lead times", &inside)
}

fn energy(page: &Page<'_>) -> Markup {
    let (trace, recorder) = (first(page), page.recorder);
    if trace.joules <= 0.0 {
        return html! {};
    }
    let of_node = |index: usize| {
        STATES.map(|(state, _)| {
            let joules = &recorder.joules[index];
            let more = if state == Activity::Failed {
                joules[Activity::FailedOffShift as usize]
            } else {
                0.0
            };
            (joules[state as usize] + more) / JOULES_PER_KWH
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
    let (watts, width) = recorder.power();
    let kilowatts: Vec<f64> = watts.iter().map(|watts| watts / 1000.0).collect();
    let inside = html! {
        p { "Energy of each place by its state." }
        (charts::bars("Energy of each place by its state", &bars, most))
        (legend())
        (behind(&headings, &rows))
        h3 { "Power over time in kW" }
        (charts::rate("Power over time in kilowatts", &kilowatts, width, recorder.end, recorder.counting))
    };
    section("energy", "Energy", &inside)
}

fn flow(page: &Page<'_>, picture: &Picture) -> Markup {
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
                class: "busy",
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

fn violations(page: &Page<'_>) -> Markup {
    let trace = first(page);
    if trace.violation_count == 0 {
        return html! {};
    }
    /// Number of violations that the table shows.
    const SHOWN: usize = 200;
    let shown = trace.violations.len().min(SHOWN);
    let inside = html! {
        p {
            (count(trace.violation_count)) " violations of contracts."
            @if (shown as u64) < trace.violation_count { " The table shows the first " (shown) "." }
        }
        div.scroll tabindex="0" role="group" aria-label="Table of violations" {
            table {
                thead { tr { @for heading in ["Time", "Place", "Part", "Rule", "What happened"] { th scope="col" { (heading) } } } }
                tbody { @for violation in &trace.violations[..shown] { tr {
                    th scope="row" { button.jump type="button" data-time=(violation.time) { (duration(violation.time)) } }
                    td { (page.line.nodes[violation.node].name) }
                    td { @if let Some((number, kind)) = violation.part { (page.line.parts[kind].name) " " (number) } }
                    td {
                        (violation.rule.as_deref().unwrap_or("-"))
                        @if let Some((place, text)) = rule_line(page, violation) { br; code { (text) } br; small { (place) } }
                    }
                    td { (violation.message) }
                } } }
            }
        }
    };
    section("violations", "Violations", &inside)
}

/// The formula of the rule that was violated, with its file and line before it.
fn rule_line(page: &Page<'_>, violation: &Violation) -> Option<(String, String)> {
    let rule = violation.rule.as_deref()?;
    let machine = page.line.nodes[violation.node].machine()?;
    let (component, name) = rule.split_once(": ").unwrap_or(("", rule));
    let mut formulas: Vec<&Formula> = Vec::new();
    for of in machine.components.iter().filter(|of| of.name == component) {
        formulas.extend(of.specification.assumptions.all());
        formulas.extend(of.specification.guarantees.all());
    }
    let formula = formulas.into_iter().find(|formula| formula.name == name)?;
    let file = &page.sources.file(formula.span.file).name;
    let line = page.sources.start(formula.span).line;
    Some((format!("{file}:{line}"), formula.text.clone()))
}

fn model(page: &Page<'_>) -> Markup {
    let inside = html! {
        p { "This run can be made again:" }
        pre tabindex="0" { code { (page.command) } }
        (table(&["What", "Value"], &[
            vec!["Version".to_owned(), format!("linewright {}", page.version)],
            vec!["Random seeds".to_owned(), seeds(page.traces)],
            vec!["Hash of the files (SHA-256)".to_owned(), hash(page.sources)],
        ]))
        @if !page.set.is_empty() {
            h3 { "Numbers that were set" }
            (table(&["Name", "Value"], &page.set.iter().map(|(name, value)| vec![(*name).to_owned(), (*value).to_owned()]).collect::<Vec<_>>()))
        }
        @if !page.findings.is_empty() {
            h3 { "Findings" }
            pre tabindex="0" { (strip_str(&render::human(page.sources, page.findings))) }
        }
        h3 { "Files" }
        @for (_, file) in page.sources.files() {
            details {
                summary { (file.name) }
                pre tabindex="0" { code { (&*file.text) } }
            }
        }
    };
    section("model", "The model", &inside)
}

/// SHA-256 of the names and texts of all files, in hexadecimal digits.
fn hash(sources: &SourceMap) -> String {
    let mut hash = Sha256::new();
    for (_, file) in sources.files() {
        // The lengths keep a name from running into a text.
        hash.update((file.name.len() as u64).to_le_bytes());
        hash.update(&file.name);
        hash.update((file.text.len() as u64).to_le_bytes());
        hash.update(file.text.as_bytes());
    }
    hash.finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn seeds(traces: &[Trace]) -> String {
    match traces {
        [first, .., last] => format!("{} to {}", first.seed, last.seed),
        [only] => only.seed.to_string(),
        [] => String::new(),
    }
}
