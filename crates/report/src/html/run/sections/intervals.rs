//! Confidence intervals of replications and batches, and the comparison with a variant.

use super::super::charts::{Range, signed};
use super::super::{Compared, Page, charts};
use super::operation::{OF_SHARES, shares};
use super::{first, legend};
use crate::html::numbers::{figure, rounded};
use crate::html::parts::{behind, section, table};
use crate::intervals::{shown_in, without_value};
use crate::{Intervals, Variant};
use linewright_language::contract::metric::Measure;
use linewright_line::comparison::{COMPARED, Comparison};
use linewright_line::metric;
use linewright_line::trace::{End, duration_in_units};
use linewright_line::{Estimate, Trace};
use maud::{Markup, html};

/// The estimate of a measure over replications or batches.
pub(super) fn estimate(page: &Page<'_>, measure: Measure) -> Option<Estimate> {
    match page.intervals? {
        Intervals::Replications(_) => Estimate::over_runs(measure, of_runs(measure, page.traces)),
        Intervals::Batches(batches) => {
            let mut estimates = batches.estimates.iter();
            estimates.find(|e| e.measure == measure)?.value
        }
    }
}

/// Mean of a figure over all runs that have one.
pub(super) fn mean_of_runs(page: &Page<'_>, figure: impl Fn(&Trace) -> Option<f64>) -> Option<f64> {
    let values: Vec<f64> = page.traces.iter().filter_map(figure).collect();
    Estimate::of(&values).map(|estimate| estimate.mean)
}

/// A mean with its interval, as text.
pub(super) fn interval(estimate: Option<Estimate>) -> String {
    interval_with(estimate, rounded)
}

/// A mean with its interval, with its numbers in a format that depends on the half-width.
fn interval_with(estimate: Option<Estimate>, show: impl Fn(f64, f64) -> String) -> String {
    let Some(estimate) = estimate else {
        return "-".to_owned();
    };
    let half = estimate.half_width.unwrap_or(0.0);
    let mean = show(estimate.mean, half);
    let mut text = match estimate.interval() {
        Some((low, high)) => format!("{mean} ({} to {})", show(low, half), show(high, half)),
        None => mean,
    };
    if let Some(missing) = without_value(&estimate) {
        text.push_str(", ");
        text.push_str(&missing);
    }
    text
}

/// The name of a measure; that of a time in seconds without its unit, which its values have.
fn name_of(measure: Measure) -> &'static str {
    if measure == Measure::Makespan {
        return "makespan: time of the last product";
    }
    let label = measure.info().label;
    label.strip_suffix(SECONDS).unwrap_or(label)
}

/// A value of a measure, or a difference of two, with the digits that fit the half-width of an
/// interval, which is 0 if there is none: times with their units, from a minute on in whole
/// seconds.
pub(super) fn value_of(measure: Measure, value: f64, half_width: f64) -> String {
    if !measure.info().label.ends_with(SECONDS) {
        return rounded(value, half_width);
    }
    if half_width > 0.0 && value.abs() < 59.5 {
        return format!("{} s", rounded(value, half_width));
    }
    let sign = if value < 0.0 { "-" } else { "" };
    format!("{sign}{}", duration_in_units(value.abs()))
}

/// The unit in the names of times.
const SECONDS: &str = " in s";

/// Whether a measure says something about the line: the length of a run that time ends does not.
fn is_result(page: &Page<'_>, measure: Measure) -> bool {
    measure != Measure::Makespan || first(page).end != End::Time
}

/// The heading of the section on intervals.
pub(super) fn heading_of(intervals: Intervals<'_>) -> &'static str {
    match intervals {
        Intervals::Replications(_) => "Replications",
        Intervals::Batches(_) => "Batch means",
    }
}

pub(super) fn replications(page: &Page<'_>) -> Markup {
    const SHOWN: [Measure; 6] = [
        Measure::Throughput,
        Measure::LeadTime,
        Measure::LeadTimePercentile,
        Measure::Wip,
        Measure::Makespan,
        Measure::Energy,
    ];
    let Some(intervals) = page.intervals else {
        return html! {};
    };
    let heading = heading_of(intervals);
    let about = match intervals {
        Intervals::Replications(runs) => format!(
            "Means of {} runs with 95 % confidence intervals, in percent of each mean. The thin upright lines are the ends of an interval. Each small dot is a run; its height has no meaning.",
            runs.seeds.len()
        ),
        Intervals::Batches(batches) => format!(
            "Means of {} batches of the run with 95 % confidence intervals, in percent of each mean. The thin upright lines are the ends of an interval.",
            batches.count
        ),
    };
    let is_single = matches!(page.intervals, Some(Intervals::Batches(_)));
    let shown = SHOWN.iter().filter(|measure| is_result(page, **measure));
    let ranges: Vec<Range> = shown
        .clone()
        .filter_map(|measure| {
            let estimate = estimate(page, *measure)?;
            let mean = estimate.mean;
            let (low, high) = estimate.interval().unwrap_or((mean, mean));
            let of_mean = |value: f64| value / mean - 1.0;
            (mean != 0.0).then(|| Range {
                name: name_of(*measure).to_owned(),
                low: of_mean(low),
                mean: 0.0,
                high: of_mean(high),
                values: if is_single {
                    Vec::new()
                } else {
                    let values = of_runs(*measure, page.traces);
                    values.flatten().map(of_mean).collect()
                },
                text: interval_with(Some(estimate), |value, half| {
                    value_of(*measure, value, half)
                }),
            })
        })
        .collect();
    let rows: Vec<Vec<String>> = page
        .traces
        .iter()
        .map(|trace| {
            let cells = shown.clone().map(|measure| {
                let value = metric::measure(&(*measure).into(), trace);
                value.map_or("-".to_owned(), |value| value_of(*measure, value, 0.0))
            });
            std::iter::once(trace.seed.to_string())
                .chain(cells)
                .collect()
        })
        .collect();
    let headings: Vec<&str> = std::iter::once("Seed")
        .chain(shown.map(|of| name_of(*of)))
        .collect();
    let inside = html! {
        p { (about) }
        (charts::ranges(heading, &ranges))
        @if !is_single { (behind(&headings, &rows)) }
        (all_measures(page, intervals))
    };
    section("replications", heading, &inside)
}

/// The intervals of all measures that are not 0 throughout.
fn all_measures(page: &Page<'_>, intervals: Intervals<'_>) -> Markup {
    let measures = match intervals {
        Intervals::Replications(runs) => &runs.measures,
        Intervals::Batches(batches) => &batches.measures,
    };
    let rows: Vec<Vec<String>> = measures
        .iter()
        .filter_map(|of| {
            let estimate = of.value?;
            let mean = estimate.mean;
            let half = estimate.half_width.unwrap_or(0.0);
            let (low, high) = estimate.interval().unzip();
            if mean == 0.0 && half == 0.0 {
                return None;
            }
            let measure = of.subject.measure();
            let (label, scale) = shown_in(measure, of.subject.label(page.line), mean);
            let value = |value: f64| rounded(value * scale, half * scale);
            Some(vec![
                label,
                value(mean),
                low.map_or("-".to_owned(), value),
                high.map_or("-".to_owned(), value),
            ])
        })
        .collect();
    if rows.is_empty() {
        return html! {};
    }
    html! {
        details {
            summary { "All measures with their intervals" }
            (table(&["Measure", "Mean", "From", "To"], &rows))
        }
    }
}

/// Values of a measure in runs that have one.
fn of_runs(measure: Measure, traces: &[Trace]) -> impl Iterator<Item = Option<f64>> {
    let metric = measure.into();
    traces
        .iter()
        .map(move |trace| metric::measure(&metric, trace))
}

pub(super) fn comparison(page: &Page<'_>) -> Markup {
    let variants = page.comparisons;
    if variants.is_empty() {
        return html! {};
    }
    let labels: Vec<&str> = variants.iter().map(|of| of.variant.label()).collect();
    let shown = || COMPARED.into_iter().filter(|of| is_result(page, *of));
    let ranges: Vec<Range> = shown()
        .flat_map(|measure| of_measure(variants, measure))
        .filter(|(_, compared)| compared.as_it_is != 0.0)
        .map(|(variant, compared)| range(compared, labels[variant], variants.len() > 1))
        .collect();
    let rows: Vec<Vec<String>> = shown()
        .flat_map(|measure| measure_rows(variants, &labels, measure))
        .collect();
    let of_first_run = if page.traces.len() > 1 {
        ", in the first run"
    } else {
        ""
    };
    let inside = html! {
        @for compared in variants { p {
            @if variants.len() > 1 { strong { (compared.variant.label()) } ": what" } @else { "What" }
            " if " (changes(compared.variant)) "?"
        } }
        p { "All lines were run with the same random seeds. The chart shows the differences in percent of the line as it is, with their paired 95 % confidence intervals. The thin upright lines are the ends of an interval." }
        (charts::ranges("Differences", &ranges))
        (table(&["Measure", "Line", "Mean", "Difference from the line as it is", "More than noise"], &rows))
        h3 { "Where the time goes, as it is" (of_first_run) }
        p { (OF_SHARES) }
        (shares(&first(page).stations))
        (legend())
        @for compared in variants { @if let Some(other) = compared.traces.first() {
            h3 { "Where the time goes, " (compared.variant.label()) (of_first_run) }
            (shares(&other.stations))
            (legend())
        } }
    };
    section("comparison", "Comparison", &inside)
}

/// The comparisons of a measure, with the number of the variant of each. Measures that are 0
/// everywhere are left out.
fn of_measure<'a>(variants: &'a [Compared<'a>], measure: Measure) -> Vec<(usize, &'a Comparison)> {
    let variants = variants.iter().enumerate();
    let all: Vec<(usize, &Comparison)> = variants
        .flat_map(|(variant, of)| of.comparisons.iter().map(move |c| (variant, c)))
        .filter(|(_, compared)| compared.measure == measure)
        .collect();
    if all
        .iter()
        .all(|(_, c)| c.as_it_is == 0.0 && c.what_if == 0.0)
    {
        return Vec::new();
    }
    all
}

fn range(compared: &Comparison, label: &str, are_several: bool) -> Range {
    let base = compared.as_it_is.abs();
    let difference = compared.difference.scaled(1.0 / base);
    let mean = difference.mean;
    let (low, high) = difference.interval().unwrap_or((mean, mean));
    let measure = name_of(compared.measure);
    Range {
        name: if are_several {
            format!("{measure}, {label}")
        } else {
            measure.to_owned()
        },
        low,
        mean,
        high,
        values: Vec::new(),
        text: interval_with(Some(difference), signed),
    }
}

/// The rows of a measure: the line as it is, then each variant.
fn measure_rows(variants: &[Compared<'_>], labels: &[&str], measure: Measure) -> Vec<Vec<String>> {
    let all = of_measure(variants, measure);
    let Some((_, one)) = all.first() else {
        return Vec::new();
    };
    // All numbers of a measure have the digits that its least half-width asks for.
    let halves = all.iter().filter_map(|(_, c)| c.difference.half_width);
    let least = halves.filter(|half| *half > 0.0).reduce(f64::min);
    let show = |value: f64| value_of(measure, value, least.unwrap_or(0.0));
    let row = |line: &str, mean: f64, difference: String, is_significant: &str| {
        vec![
            name_of(measure).to_owned(),
            line.to_owned(),
            show(mean),
            difference,
            is_significant.to_owned(),
        ]
    };
    let mut rows = vec![row("as it is", one.as_it_is, String::new(), "")];
    for (variant, compared) in all {
        let is_significant = match compared.is_significant() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "-",
        };
        rows.push(row(
            labels[variant],
            compared.what_if,
            interval_with(Some(compared.difference), |value, _| show(value)),
            is_significant,
        ));
    }
    rows
}

/// What differs in a variant, as the condition of a sentence.
pub(super) fn changes(variant: &Variant) -> String {
    let set = variant
        .set
        .iter()
        .map(|(name, value)| match variant.as_it_is.get(name) {
            Some(now) => format!("{name} = {value} instead of {now}"),
            None => format!("{name} = {value}"),
        });
    let speeds = variant.speeds.iter().map(|(name, speed)| {
        let word = if *speed < 1.0 { "slower" } else { "faster" };
        format!(
            "{name} works {} % {word}",
            figure((speed - 1.0).abs() * 100.0)
        )
    });
    set.chain(speeds).collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_has_the_old_value() {
        let of = |pairs: &[(&str, &str)]| {
            let pairs = pairs.iter();
            pairs
                .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()))
                .collect()
        };
        let variant = Variant {
            set: of(&[("belt.speed", "0.1 m/s"), ("printer.time", "35 s")]),
            as_it_is: of(&[("printer.time", "50 s per step")]),
            ..Variant::default()
        };
        assert_eq!(
            changes(&variant),
            "belt.speed = 0.1 m/s and printer.time = 35 s instead of 50 s per step"
        );
    }
}
