//! What came out, in words, and what it is worth: one run, its batches, or several runs.

use super::super::charts::signed;
use super::super::picture::by_type;
use super::super::recorder::Balance;
use super::super::{Compared, Page};
use super::intervals::{changes, estimate, interval, mean_of_runs};
use super::summary::judged;
use super::{counted, first, has_contracts, made};
use crate::Intervals;
use crate::html::numbers::{count, figure, percent};
use linewright_language::contract::line::Line;
use linewright_language::contract::metric::Measure;
use linewright_line::trace::duration_in_units;
use linewright_line::{Bottleneck, Verdict};

/// What came out: products, what limits them, requirements, violations.
pub(super) fn conclusion(page: &Page<'_>) -> String {
    let mut sentences = vec![products(page)];
    sentences.extend(limits(page));
    sentences.extend(requirements(page));
    sentences.push(violations(page));
    sentences.extend(page.comparisons.iter().filter_map(variant));
    sentences.join(" ")
}

/// What a variant does to the throughput.
fn variant(compared: &Compared<'_>) -> Option<String> {
    let mut all = compared.comparisons.iter();
    let of = all.find(|of| of.measure == Measure::Throughput && of.as_it_is > 0.0)?;
    let half_width = of.difference.half_width;
    let share = |difference: f64| {
        signed(
            difference / of.as_it_is,
            half_width.unwrap_or(0.0) / of.as_it_is,
        )
    };
    let (change, mean) = (changes(compared.variant), of.difference.mean);
    Some(match (of.is_significant(), half_width) {
        (Some(true), Some(half)) => format!(
            "If {change}, the throughput changes by {} (95 %: {} to {}).",
            share(mean),
            share(mean - half),
            share(mean + half)
        ),
        (Some(false), Some(half)) => format!(
            "If {change}, the throughput does not change by more than noise (95 %: {} to {}).",
            share(mean - half),
            share(mean + half)
        ),
        _ => format!(
            "If {change}, the throughput changes by {} in this run.",
            share(mean)
        ),
    })
}

fn products(page: &Page<'_>) -> String {
    let trace = first(page);
    let runs = page.traces.len();
    if page.traces.iter().all(|trace| trace.products == 0) {
        let parts = 0..page.line.parts.len();
        let balances: Vec<Balance> = parts.map(|kind| page.recorder.balance(kind)).collect();
        let left = |name: &str, number: fn(&Balance) -> u64| {
            let numbers: Vec<u64> = balances.iter().map(number).collect();
            if runs == 1 && numbers.iter().any(|number| *number > 0) {
                format!("; {name}: {}", by_type(page.line, &numbers))
            } else {
                String::new()
            }
        };
        let finished = left("other parts that left it", |of| of.finished);
        let rejected = left("rejected or taken out", |of| of.rejected + of.scrapped);
        let others = finished + &rejected;
        return format!(
            "The line made no product in {}{others}.",
            counted_runs(runs)
        );
    }
    let median = mean_of_runs(page, |trace| {
        (trace.products > 0).then_some(trace.lead_time.p50)
    });
    let median = duration_in_units(median.unwrap_or(0.0));
    let of_runs = interval(estimate(page, Measure::Throughput));
    let word = product_word(page.line);
    match page.intervals {
        Some(Intervals::Replications(_)) => format!(
            "In {}, the line made {of_runs} {word} an hour; the mean of the runs' median lead times is {median}.",
            counted_runs(runs)
        ),
        Some(Intervals::Batches(batches)) => format!(
            "In {} batches of this one run, the line made {of_runs} {word} an hour; half of them were in it for at most {median}.",
            batches.count
        ),
        None => format!(
            "In this one run, the line made {}, {} an hour{}; half of them were in it for at most {median}.",
            counted(page.line, &made(page.line, trace)),
            figure(trace.throughput_per_hour),
            trace.throughput_on_shift.map_or(String::new(), |rate| {
                format!(" ({} on shift)", figure(rate))
            })
        ),
    }
}

fn counted_runs(runs: usize) -> String {
    match runs {
        1 => "this one run".to_owned(),
        runs => format!("{runs} runs"),
    }
}

/// The name of the only product, or the word for several.
fn product_word(line: &Line) -> &str {
    line.only_product()
        .map_or("products", |product| &line.parts[product].name)
}

/// What limits the line: in one run with the evidence, otherwise in how many runs it is what.
fn limits(page: &Page<'_>) -> Option<String> {
    if page.traces.iter().all(|trace| trace.products == 0) {
        return None;
    }
    if let [trace] = page.traces {
        return limit_with_evidence(&trace.bottleneck);
    }
    let limits = page
        .traces
        .iter()
        .filter_map(|trace| limit(&trace.bottleneck));
    let (most, number) = most_frequent(limits)?;
    let runs = page.traces.len();
    Some(if number == runs {
        format!("In all of them, {most} limits the line.")
    } else {
        format!("In {number} of {runs} runs, {most} limits the line.")
    })
}

/// The text that occurs most often, and how often.
pub(super) fn most_frequent(texts: impl Iterator<Item = String>) -> Option<(String, usize)> {
    let mut numbers: Vec<(String, usize)> = Vec::new();
    for text in texts {
        match numbers.iter_mut().find(|(known, _)| *known == text) {
            Some((_, number)) => *number += 1,
            None => numbers.push((text, 1)),
        }
    }
    // Of equal numbers, the first.
    numbers.into_iter().rev().max_by_key(|(_, number)| *number)
}

/// What limits a run, as the subject of a sentence.
pub(super) fn limit(bottleneck: &Bottleneck) -> Option<String> {
    match bottleneck {
        Bottleneck::Nothing => None,
        Bottleneck::Station(station) => Some(station.name.clone()),
        Bottleneck::Source {
            names,
            busiest: Some(station),
            parts_wait: true,
        } => Some(format!(
            "the supply from {}, for which {} waits,",
            names.join(" and "),
            station.name
        )),
        Bottleneck::Source { names, .. } => {
            Some(format!("the supply from {}", names.join(" and ")))
        }
        Bottleneck::Deadlock(deadlock) => Some(format!("the deadlock of {}", deadlock.listed())),
        Bottleneck::Undecided(stations) => {
            let names: Vec<&str> = stations.iter().map(|s| s.name.as_str()).collect();
            Some(format!(
                "one of {}, which are nearly equal,",
                names.join(", ")
            ))
        }
    }
}

/// What limits a run, and why it does.
fn limit_with_evidence(bottleneck: &Bottleneck) -> Option<String> {
    let sentence = match bottleneck {
        Bottleneck::Source {
            names,
            busiest: Some(station),
            parts_wait: true,
        } => format!(
            "The supply from {} limits the line first: {} waits for parts for {} of its time on shift.",
            names.join(" and "),
            station.name,
            percent(station.starved_on_shift)
        ),
        Bottleneck::Source { names, .. } => format!(
            "The supply from {} limits the line: no part had to wait there.",
            names.join(" and ")
        ),
        Bottleneck::Undecided(stations) => {
            let names: Vec<&str> = stations.iter().map(|s| s.name.as_str()).collect();
            format!(
                "One of {} limits the line; they are nearly equal.",
                names.join(", ")
            )
        }
        Bottleneck::Deadlock(deadlock) => format!(
            "The line has no bottleneck: {} wait for one another for ever, since {}.",
            deadlock.listed(),
            duration_in_units(deadlock.since)
        ),
        _ => format!("The bottleneck is {}.", limit(bottleneck)?),
    };
    Some(sentence)
}

fn requirements(page: &Page<'_>) -> Option<String> {
    let judged = judged(page);
    let requirements = page.line.requirements.iter().zip(&judged);
    let failed = requirements.filter(|(_, (verdict, _))| *verdict == Verdict::Fails);
    let failed: Vec<&str> = failed
        .map(|(requirement, _)| requirement.name.as_str())
        .collect();
    if !failed.is_empty() {
        Some(format!("It does not meet: {}.", failed.join(", ")))
    } else if judged.iter().any(|(verdict, _)| *verdict != Verdict::Holds) {
        Some("No requirement fails, but not all are decided.".to_owned())
    } else {
        (!judged.is_empty()).then(|| "All requirements hold.".to_owned())
    }
}

fn violations(page: &Page<'_>) -> String {
    let traces = page.traces;
    let number: u64 = traces.iter().map(|trace| trace.violation_count).sum();
    let with = traces.iter().filter(|trace| trace.violation_count > 0);
    let in_runs = if traces.len() > 1 {
        format!(", in {} of {} runs", with.count(), traces.len())
    } else {
        String::new()
    };
    match number {
        0 if !has_contracts(page.line) => {
            "No station or conveyor has a contract that could be violated.".to_owned()
        }
        0 => "No contract was violated.".to_owned(),
        1 => format!("A contract was violated once{in_runs}."),
        number => format!("Contracts were violated {} times{in_runs}.", count(number)),
    }
}
