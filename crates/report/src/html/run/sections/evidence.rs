//! Violations, and what is needed to make the run again.

use super::super::Page;
use super::super::moments::Moments;
use super::{first, section_of_first};
use crate::html::numbers::count;
use crate::html::parts::{formula, origin, table, table_of};
use linewright_core::gr1::Formula;
use linewright_line::Trace;
use linewright_line::trace::Violation;
use maud::{Markup, html};

/// Number of violations that the table shows.
const SHOWN_VIOLATIONS: usize = 200;

pub(super) fn violations(page: &Page<'_>) -> Markup {
    let trace = first(page);
    if trace.violation_count == 0 {
        return html! {};
    }
    let mut kinds: Vec<(&Violation, u64, f64)> = Vec::new();
    for violation in &trace.violations {
        let same = |first: &Violation| first.node == violation.node && first.rule == violation.rule;
        match kinds.iter_mut().find(|(first, ..)| same(first)) {
            Some((_, number, last)) => {
                *number += 1;
                *last = violation.time;
            }
            None => kinds.push((violation, 1, violation.time)),
        }
    }
    let moments = Moments::of(page.line);
    let is_cut = (trace.violations.len() as u64) < trace.violation_count;
    let shown = trace.violations.len().min(SHOWN_VIOLATIONS);
    let inside = html! {
        p {
            "A contract has the rules that a machine's controller keeps, and those that it assumes of the plant, which is everything outside the controller. There were "
            (count(trace.violation_count)) " violations of contracts. The first table groups them by place and rule."
            @if is_cut { " The tables have the first " (count(trace.violations.len() as u64)) "." }
        }
        p.hint { "Parts are numbered in the order in which they were made, over all types. A name with a colon before a rule is that of the component of the machine whose contract has the rule." }
        (table_of("Table of violations", &["First", "Last", "Number", "Place", "Rule", "What happened first"], &html! {
            @for (first, number, last) in &kinds { tr {
                th scope="row" { (jump(moments, first.time)) }
                td { (jump(moments, *last)) }
                td.number { (count(*number)) }
                td { (page.line.nodes[first.node].name) }
                td { (rule(page, first)) }
                td { (part(page, first)) ": " (first.message) }
            } }
        }))
        details {
            summary { "Show the first " (count(shown as u64)) }
            (table_of("Table of violations", &["Time", "Place", "Part", "What happened"], &html! {
                @for violation in &trace.violations[..shown] { tr {
                    th scope="row" { (jump(moments, violation.time)) }
                    td { (page.line.nodes[violation.node].name) }
                    td { (part(page, violation)) }
                    td { (violation.message) }
                } }
            }))
        }
    };
    section_of_first(page, "violations", "Violations", &inside)
}

/// A button that goes to a moment of the run.
fn jump(moments: Moments, seconds: f64) -> Markup {
    html! { button.jump type="button" data-time=(seconds) { (moments.instant(seconds)) } }
}

fn part(page: &Page<'_>, violation: &Violation) -> String {
    violation
        .part
        .map_or("no part".to_owned(), |(number, kind)| {
            format!("{} {number}", page.line.parts[kind].name)
        })
}

/// The rule that was violated, with its text and place.
fn rule(page: &Page<'_>, violation: &Violation) -> Markup {
    html! {
        (violation.rule.as_deref().unwrap_or("-"))
        @if let Some((place, text)) = rule_line(page, violation) { br; (formula(&text)) br; small { (place) } }
    }
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
    let file = &page.origin.sources.file(formula.span.file).name;
    let line = page.origin.sources.start(formula.span).line;
    Some((format!("{file}:{line}"), formula.text.clone()))
}

pub(super) fn model(page: &Page<'_>) -> Markup {
    let set = page.set.iter();
    let set: Vec<_> = set
        .map(|(name, value)| vec![(*name).to_owned(), (*value).to_owned()])
        .collect();
    let inside = html! {
        @if !set.is_empty() {
            h3 { "Numbers that were set" }
            (table(&["Name", "Value"], &set))
        }
    };
    origin(
        "The model",
        &page.origin,
        &[("Random seeds", seeds(page.traces))],
        &inside,
    )
}

fn seeds(traces: &[Trace]) -> String {
    match traces {
        [first, .., last] => format!("{} to {}", first.seed, last.seed),
        [only] => only.seed.to_string(),
        [] => String::new(),
    }
}
