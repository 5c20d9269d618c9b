//! Head of a page, figures, and requirements.

use super::super::Page;
use super::conclusion::{conclusion, limit, most_frequent};
use super::intervals::{estimate, heading_of, interval, mean_of_runs, value_of};
use super::{first, has_contracts, has_shifts, made, unpowered};
use crate::Intervals;
use crate::energy::EnergyUnit;
use crate::html::numbers::{count, exact, figure, percent, rounded};
use crate::html::parts::{links, section, table_of, tile};
use crate::table::{bottleneck, required_with};
use linewright_language::contract::date::{WEEKDAYS, format_date, weekday};
use linewright_language::contract::line::declared_name;
use linewright_language::contract::metric::Measure;
use linewright_line::metric::JOULES_PER_KWH;
use linewright_line::trace::{End, LeadTime, Oee, duration_in_units};
use linewright_line::{Trace, Verdict};
use maud::{Markup, html};

pub(super) fn header(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let sections = [
        ("line-section", "The line", true),
        (
            "requirements",
            "Requirements",
            !page.line.requirements.is_empty(),
        ),
        (
            "replications",
            page.intervals.map_or("", heading_of),
            page.intervals.is_some(),
        ),
        ("comparison", "Comparison", !page.comparisons.is_empty()),
        (
            "stations",
            "Where the time goes",
            !trace.stations.is_empty(),
        ),
        (
            "timeline",
            "Timeline of the stations",
            !trace.stations.is_empty(),
        ),
        ("queues", "Work in progress and queues", true),
        ("lead-times", "Lead times", trace.products > 0),
        ("energy", "Energy", trace.joules > 0.0),
        ("flow", "Flow between places", true),
        ("violations", "Violations", trace.violation_count > 0),
        ("model", "The model", true),
    ];
    html! {
        header {
            h1 { (page.line.name) }
            @if !page.line.doc.is_empty() { p.doc { (page.line.doc) } }
            p {
                (duration_in_units(trace.seconds)) " simulated, random seed " (trace.seed)
                @if trace.warm_up > 0.0 { "; the first " (duration_in_units(trace.warm_up)) " are the warm-up" @if trace.warm_up_products > 0 { ", until " (trace.warm_up_products) " products were made," } " and do not count" }
                ". " (ending(trace.end))
                @if page.traces.len() > 1 { " This is run 1 of " (page.traces.len()) ". The conclusion, the figures below it, and the intervals are of all runs; sections that are of run 1 alone say so." }
                @if let Some(day) = page.line.first_day {
                    " It begins on " (WEEKDAYS[usize::from(weekday(day))]) ", " (format_date(day)) ", at 0:00."
                }
            }
            p.conclusion {
                (conclusion(page))
                @if page.intervals.is_none() { " One run has no confidence interval: add " code.option { "--replications 10" } " to get one." }
            }
            p.hint { "Figures are rounded, so sums of them can differ in the last digit." }
            (links(sections.into_iter().filter(|(.., is_there)| *is_there).map(|(id, name, _)| (id, name))))
        }
    }
}

fn ending(end: End) -> &'static str {
    match end {
        End::Products => "The run ended with the last product that was asked for.",
        End::Time => "The run ended at its end time.",
        End::Blocked => "The run ended early: the line can no longer advance.",
        End::NoProgress => "The run ended early: the line makes no progress.",
        End::PartLost => "The run ended early: a conveyor lost a part.",
        End::GaveUp => "The run was cut off at the time limit.",
    }
}

/// A tile for a measure: its mean with the interval if there is one, otherwise the value of the run
/// with a note.
fn measured(page: &Page<'_>, measure: Measure, name: &str, value: f64, note: &str) -> Markup {
    let show = |value: f64, half: f64| match measure {
        Measure::Throughput => format!("{} / h", rounded(value, half)),
        Measure::Energy => {
            let unit = EnergyUnit::of(value * JOULES_PER_KWH);
            let scale = JOULES_PER_KWH / unit.joules();
            format!("{} {}", rounded(value * scale, half * scale), unit.symbol())
        }
        Measure::FirstPassYield if half > 0.0 => {
            format!("{} %", rounded(value * 100.0, half * 100.0))
        }
        Measure::FirstPassYield => percent(value),
        _ => value_of(measure, value, half),
    };
    let found = estimate(page, measure);
    let Some((found, (low, high))) = found.and_then(|found| Some((found, found.interval()?)))
    else {
        return tile(name, &show(value, 0.0), note);
    };
    let (mean, half) = (found.mean, found.half_width.unwrap_or(0.0));
    let of = match page.intervals {
        Some(Intervals::Batches(batches)) => format!("{} batches", batches.count),
        _ => format!("{} runs", page.traces.len()),
    };
    let is_cut = low > mean - half || high < mean + half;
    let mut text = if is_cut {
        let (low, high) = (show(low, half), show(high, half));
        format!("mean of {of}, {low} to {high} (95 %)")
    } else {
        format!("mean of {of}, ± {} (95 %)", show(half, half))
    };
    if !note.is_empty() {
        text = format!("{text}; {note}");
    }
    tile(name, &show(mean, half), &text)
}

pub(super) fn tiles(page: &Page<'_>) -> Markup {
    let trace = first(page);
    let mean = |figure: fn(&Trace) -> Option<f64>| mean_of_runs(page, figure);
    let has_products = page.traces.iter().any(|trace| trace.products > 0);
    let on_shift = mean(|trace| trace.throughput_on_shift);
    let on_shift = on_shift.map_or(String::new(), |rate| {
        format!("{} / h on shift", figure(rate))
    });
    let of_products = |trace: &Trace, value: f64| (trace.products > 0).then_some(value);
    let lead_time = |quantile: fn(&LeadTime) -> f64| {
        let mean = mean_of_runs(page, |t| of_products(t, quantile(&t.lead_time)));
        duration_in_units(mean.unwrap_or(0.0))
    };
    let with_time_off = if has_shifts(page.line) {
        "clock time, off shift included; "
    } else {
        ""
    };
    let quantiles = format!(
        "{with_time_off}median {}, 95th percentile {}",
        lead_time(|time| time.p50),
        lead_time(|time| time.p95)
    );
    let product = page.line.only_product();
    let product = product.map_or("product", |product| &page.line.parts[product].name);
    let most_units = page.traces.iter().map(|trace| trace.wip.max).max();
    let kwh = trace.joules / JOULES_PER_KWH;
    let per_product = mean_of_runs(page, |t| of_products(t, t.joules / t.products as f64));
    let unpowered = unpowered(page).len();
    let unpowered = if unpowered > 0 {
        format!(
            "; the model gives no power for {unpowered} of {} stations, so their energy is not included",
            trace.stations.len()
        )
    } else {
        String::new()
    };
    let violations: u64 = page.traces.iter().map(|trace| trace.violation_count).sum();
    let of_contracts = if violations > 0 || has_contracts(page.line) {
        "of contracts"
    } else {
        "no station or conveyor has a contract"
    };
    html! {
        dl.tiles {
            (measured(page, Measure::Products, "Products", trace.products as f64, &made_and_rejected(page)))
            (measured(page, Measure::Throughput, "Throughput", trace.throughput_per_hour, &on_shift))
            @if has_products { (measured(page, Measure::LeadTime, "Lead time", trace.lead_time.mean, &quantiles)) }
            (measured(page, Measure::Wip, "Work in progress", trace.wip.mean, &format!("{with_time_off}parts of all types; at most {}", count(most_units.unwrap_or(0)))))
            @if let Some((name, oee)) = busiest_oee(page) {
                (tile(&format!("OEE of {name}"), &percent(oee.index()), &format!(
                    "{}availability {} (busy share of its time on shift), effectiveness {}, quality {}",
                    if page.traces.len() > 1 { format!("mean of {} runs; ", page.traces.len()) } else { String::new() },
                    percent(oee.availability), percent(oee.effectiveness), percent(oee.quality)
                )))
            }
            @if trace.joules > 0.0 {
                (measured(page, Measure::Energy, "Energy", kwh, &per_product.map_or(String::new(), |joules| {
                    let unit = EnergyUnit::of(joules);
                    format!("{} {} a {product}{unpowered}", figure(joules / unit.joules()), unit.symbol())
                })))
            }
            @if let (true, Some(first_pass)) = (has_products, mean(|trace| trace.yields.first_pass_yield())) {
                (measured(page, Measure::FirstPassYield, "First-pass yield", first_pass, &mean(|trace| trace.yields.scrap_ratio()).map_or(String::new(), |scrap| {
                    format!("of the parts on which stations worked; scrap {}", percent(scrap))
                })))
            }
            (tile("Violations", &count(violations), &if page.traces.len() > 1 {
                format!("{of_contracts}, in {} runs", page.traces.len())
            } else {
                of_contracts.to_owned()
            }))
            div.tile.wide { dt { "Bottleneck" } dd.text {
                (limits(page))
            } }
        }
        (warnings(page))
    }
}

/// What limits the line: in several runs, how often it is what.
fn limits(page: &Page<'_>) -> String {
    let [trace] = page.traces else {
        let mut rest: Vec<String> = page
            .traces
            .iter()
            .filter_map(|trace| limit(&trace.bottleneck))
            .collect();
        if page.traces.iter().all(|trace| trace.products == 0) {
            return NO_PRODUCT.to_owned();
        }
        let runs = page.traces.len();
        let mut all: Vec<String> = Vec::new();
        while let Some((most, number)) = most_frequent(rest.iter().cloned()) {
            rest.retain(|other| *other != most);
            all.push(format!(
                "{} in {number} of {runs} runs",
                most.trim_end_matches(',')
            ));
        }
        return all.join("; ");
    };
    limit_of_run(trace)
}

/// What is said instead of a bottleneck if the line made nothing.
const NO_PRODUCT: &str = "none: no product was made";

/// What limits the line in a run.
pub(super) fn limit_of_run(trace: &Trace) -> String {
    if trace.products == 0 {
        return NO_PRODUCT.to_owned();
    }
    bottleneck(&trace.bottleneck)
}

/// The OEE of the busiest station with its name, if it is one station: its factors are means over
/// the runs.
fn busiest_oee<'a>(page: &Page<'a>) -> Option<(&'a str, Oee)> {
    let traces = page.traces;
    let busiest = traces.iter().filter_map(|trace| trace.bottleneck.busiest());
    let (busiest, _) = most_frequent(busiest.map(|station| station.name.clone()))?;
    let mut stations = traces.iter().flat_map(|trace| &trace.stations);
    let name = &stations.find(|s| declared_name(&s.name) == busiest)?.name;
    let mean = |factor: fn(&Oee) -> f64| {
        mean_of_runs(page, |trace| {
            let station = trace
                .stations
                .iter()
                .find(|station| station.name == *name)?;
            station.oee.as_ref().map(factor)
        })
    };
    let oee = Oee {
        availability: mean(|oee| oee.availability)?,
        effectiveness: mean(|oee| oee.effectiveness)?,
        quality: mean(|oee| oee.quality)?,
    };
    Some((name, oee))
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

/// Products of each type, if there are several, and rejected parts of each type: means over the
/// runs.
fn made_and_rejected(page: &Page<'_>) -> String {
    let line = page.line;
    let mean =
        |number: &dyn Fn(&Trace) -> u64| mean_of_runs(page, |trace| Some(number(trace) as f64));
    let kinds = 0..line.parts.len();
    let products = kinds.clone().map(|kind| {
        let of_kind = |trace: &Trace| {
            let mut products = made(line, trace).into_iter();
            products
                .find(|(part, _)| *part == kind)
                .map_or(0, |(_, number)| number)
        };
        (kind, mean(&of_kind).unwrap_or(0.0))
    });
    let rejects = kinds.map(|kind| {
        let of_kind = |trace: &Trace| {
            let mut rejects = trace.rejects.iter();
            rejects
                .find(|reject| reject.part == kind)
                .map_or(0, |reject| reject.count)
        };
        (kind, mean(&of_kind).unwrap_or(0.0))
    });
    let text = |numbers: Vec<(usize, f64)>| {
        let numbers = numbers.into_iter().filter(|(_, number)| *number > 0.0);
        let texts: Vec<String> = numbers
            .map(|(kind, number)| format!("{} {}", figure(number), line.parts[kind].name))
            .collect();
        texts.join(", ")
    };
    let rejects = text(rejects.collect());
    let rejects = if rejects.is_empty() {
        "none rejected".to_owned()
    } else {
        format!("{rejects} rejected")
    };
    match line.only_product() {
        Some(product) => format!("of type {}; {rejects}", line.parts[product].name),
        None => format!("{}; {rejects}", text(products.collect())),
    }
}

/// Verdict and measured value of each requirement.
pub(super) fn judged(page: &Page<'_>) -> Vec<(Verdict, String)> {
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
    let rows = html! {
        @for (index, requirement) in line.requirements.iter().enumerate() {
            @let result = judged.get(index);
            tr {
                th scope="row" { (requirement.name) }
                @match result {
                    Some((verdict, _)) => td.verdict.(verdict_class(*verdict)) { (verdict.word()) },
                    None => td { "-" },
                }
                td { (required_with(line, index, exact)) }
                td.number { (result.map_or("-", |(_, value)| value.as_str())) }
            }
        }
    };
    section(
        "requirements",
        "Requirements",
        &table_of(
            "Requirements",
            &["Requirement", "Verdict", "Required", "Measured"],
            &rows,
        ),
    )
}

/// The class of the style sheet by which a verdict is marked.
fn verdict_class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "good",
        Verdict::Fails => "bad",
        Verdict::Undecided { .. } => "open",
    }
}
