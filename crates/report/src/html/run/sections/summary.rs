//! Head of a page, figures, and requirements.

use super::super::Page;
use super::first;
use super::intervals::{estimate, interval};
use crate::Intervals;
use crate::html::numbers::{count, figure, percent};
use crate::html::parts::{links, section, table, tile};
use crate::table::{bottleneck, required};
use linewright_language::contract::date::{WEEKDAYS, format_date, weekday};
use linewright_language::contract::line::declared_name;
use linewright_language::contract::metric::Measure;
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::{End, Oee, duration};
use linewright_line::{Bottleneck, Estimate, Trace, Verdict};
use maud::{Markup, html};

pub(super) fn header(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let sections = [
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
                @if page.traces.len() > 1 { "; the first of " (page.traces.len()) " runs, of which pictures, charts and tables are, unless they have intervals" }
                @if trace.warm_up > 0.0 { "; the first " (duration(trace.warm_up)) " are the warm-up and do not count" }
                ". " (ending(trace.end))
                @if let Some(day) = page.line.first_day {
                    " It begins on " (WEEKDAYS[usize::from(weekday(day))]) ", " (format_date(day)) ", at 0:00."
                }
            }
            p.conclusion { (conclusion(page)) }
            (links(sections.into_iter().filter(|(.., is_there)| *is_there).map(|(id, name, _)| (id, name))))
        }
    }
}

/// What came out, in words: products, the bottleneck, requirements, violations.
fn conclusion(page: &Page<'_>) -> String {
    let trace = first(page);
    let throughput =
        estimate(page, Measure::Throughput).map_or(trace.throughput_per_hour, |of| of.mean);
    let has_products = trace.products > 0;
    let mut sentences = vec![if has_products {
        format!(
            "The line makes {} products an hour; half of them are in it for less than {}.",
            figure(throughput),
            duration(trace.lead_time.p50)
        )
    } else {
        "The line made no product.".to_owned()
    }];
    match &trace.bottleneck {
        _ if !has_products => {}
        Bottleneck::Station(candidate) => sentences.push(format!("{} limits it.", candidate.name)),
        Bottleneck::Source { .. } => {
            sentences.push("The sources limit it: no part had to wait for a station.".to_owned());
        }
        _ => {}
    }
    let judged = judged(page);
    let requirements = page.line.requirements.iter().zip(&judged);
    let failed = requirements.filter(|(_, (verdict, _))| *verdict == Verdict::Fails);
    let failed: Vec<&str> = failed
        .map(|(requirement, _)| requirement.name.as_str())
        .collect();
    if !failed.is_empty() {
        sentences.push(format!("It does not meet: {}.", failed.join(", ")));
    } else if judged.iter().any(|(verdict, _)| *verdict != Verdict::Holds) {
        sentences.push("No requirement fails, but not all are decided.".to_owned());
    } else if !judged.is_empty() {
        sentences.push("All requirements hold.".to_owned());
    }
    sentences.push(match trace.violation_count {
        0 => "No contract was violated.".to_owned(),
        1 => "A contract was violated once.".to_owned(),
        number => format!("Contracts were violated {} times.", count(number)),
    });
    sentences.join(" ")
}

fn ending(end: End) -> &'static str {
    match end {
        End::Products => "The run ended with the last product that was asked for.",
        End::Time => "The run ended at the time that was asked for.",
        End::Blocked => "The run ended early: the line can no longer advance.",
        End::PartLost => "The run ended early: a conveyor lost a part.",
        End::GaveUp => "The run was cut off at the time limit.",
    }
}

/// A tile for a measure: its mean with the interval if there is one, otherwise the value of the run
/// with a note.
fn measured(page: &Page<'_>, measure: Measure, name: &str, value: f64, note: &str) -> Markup {
    let show = |value: f64| match measure {
        Measure::LeadTime => duration(value),
        Measure::Throughput => format!("{} / h", figure(value)),
        Measure::Energy => format!("{} kWh", figure(value)),
        _ => figure(value),
    };
    match estimate(page, measure) {
        Some(Estimate {
            mean,
            half_width: Some(half),
        }) => {
            let of = match page.intervals {
                Some(Intervals::Batches(batches)) => format!("{} batches", batches.count),
                _ => format!("{} runs", page.traces.len()),
            };
            tile(
                name,
                &show(mean),
                &format!("mean of {of}, ± {} (95 %)", show(half)),
            )
        }
        _ => tile(name, &show(value), note),
    }
}

pub(super) fn tiles(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let lead_time = trace.lead_time;
    let has_products = trace.products > 0;
    let kwh = trace.joules / JOULES_PER_KWH;
    let on_shift = trace.throughput_on_shift;
    let on_shift = on_shift.map_or(String::new(), |rate| {
        format!("{} / h on shift", figure(rate))
    });
    let quantiles = format!(
        "median {}, 95th percentile {}",
        duration(lead_time.p50),
        duration(lead_time.p95)
    );
    html! {
        dl.tiles {
            (tile("Products", &count(trace.products), &rejected(trace)))
            (measured(page, Measure::Throughput, "Throughput", trace.throughput_per_hour, &on_shift))
            @if has_products { (measured(page, Measure::LeadTime, "Lead time", lead_time.mean, &quantiles)) }
            (measured(page, Measure::Wip, "Work in progress", trace.wip.mean, &format!("parts of all types; at most {}", trace.wip.max)))
            @if let Some((name, oee)) = bottleneck_oee(trace) {
                (tile(&format!("OEE of {name}"), &percent(oee.index()), &format!(
                    "availability {}, effectiveness {}, quality {}",
                    percent(oee.availability), percent(oee.effectiveness), percent(oee.quality)
                )))
            }
            @if trace.joules > 0.0 {
                (measured(page, Measure::Energy, "Energy", kwh, &if has_products {
                    format!("{} kWh a product", figure(kwh / trace.products as f64))
                } else {
                    String::new()
                }))
            }
            @if let (true, Some(first_pass)) = (has_products, trace.yields.first_pass_yield()) {
                (tile("First-pass yield", &percent(first_pass), &trace.yields.scrap_ratio().map_or(String::new(), |scrap| format!("of all single parts; scrap {}", percent(scrap)))))
            }
            (tile("Violations", &count(trace.violation_count), "of contracts"))
            div.tile.wide { dt { "Bottleneck" } dd.text {
                @if has_products { (bottleneck(&trace.bottleneck)) } @else { "none: no product was made" }
            } }
        }
        (warnings(page))
    }
}

/// The bottleneck's OEE, with its name, if it is one station.
fn bottleneck_oee(trace: &Trace) -> Option<(&str, Oee)> {
    let Bottleneck::Station(candidate) = &trace.bottleneck else {
        return None;
    };
    let mut stations = trace.stations.iter();
    let station = stations.find(|station| declared_name(&station.name) == candidate.name)?;
    Some((&station.name, station.oee?))
}

/// What the run found, in short. The whole findings are with the model.
fn warnings(page: &Page<'_>) -> Markup {
    if page.origin.findings.is_empty() {
        return html! {};
    }
    html! {
        div.warnings role="note" {
            p { strong { "Findings" } " (in full " a href="#model" { "with the model" } "):" }
            ul { @for finding in page.origin.findings { li { (finding.severity.word()) " " (finding.code.id) ": " (finding.message) } } }
        }
    }
}

fn rejected(trace: &Trace) -> String {
    match trace.parts.rejected {
        0 => "none rejected".to_owned(),
        number => format!("{} parts rejected", count(number)),
    }
}

/// Verdict and measured value of each requirement.
fn judged(page: &Page<'_>) -> Vec<(Verdict, String)> {
    let results = match page.intervals {
        Some(Intervals::Replications(runs)) => Some(&runs.requirements),
        Some(Intervals::Batches(batches)) => Some(&batches.requirements),
        None => None,
    };
    match results {
        Some(results) => results
            .iter()
            .map(|result| (result.verdict, interval(result.value)))
            .collect(),
        None => first(page)
            .requirements
            .iter()
            .map(|result| {
                let value = result.value.map_or("-".to_owned(), figure);
                (result.verdict(), value)
            })
            .collect(),
    }
}

pub(super) fn requirements(page: &Page<'_>) -> Markup {
    let line = page.line;
    if line.requirements.is_empty() {
        return html! {};
    }
    let judged = judged(page);
    let requirements = line.requirements.iter().enumerate();
    let rows: Vec<Vec<String>> = requirements
        .map(|(index, requirement)| {
            let result = judged.get(index);
            vec![
                requirement.name.clone(),
                result.map_or("-", |(verdict, _)| verdict.word()).to_owned(),
                required(line, index),
                result.map_or("-".to_owned(), |(_, value)| value.clone()),
            ]
        })
        .collect();
    section(
        "requirements",
        "Requirements",
        &table(&["Requirement", "Verdict", "Required", "Measured"], &rows),
    )
}
