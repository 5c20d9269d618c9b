//! Violations, and what is needed to make the run again.

use super::super::Page;
use super::super::numbers::count;
use super::{first, section, table};
use anstream::adapter::strip_str;
use linewright_core::diagnostics::render;
use linewright_core::gr1::Formula;
use linewright_core::source::SourceMap;
use linewright_line::Trace;
use linewright_line::trace::{Violation, duration};
use maud::{Markup, html};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

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
    let is_cut = (trace.violations.len() as u64) < trace.violation_count;
    let shown = trace.violations.len().min(SHOWN_VIOLATIONS);
    let inside = html! {
        p {
            (count(trace.violation_count)) " violations of contracts, by place and rule."
            @if is_cut { " The tables have the first " (count(trace.violations.len() as u64)) "." }
        }
        (violation_table(&["First", "Last", "Number", "Place", "Rule", "What happened first"], &html! {
            @for (first, number, last) in &kinds { tr {
                th scope="row" { (jump(first.time)) }
                td { (jump(*last)) }
                td.number { (count(*number)) }
                td { (page.line.nodes[first.node].name) }
                td { (rule(page, first)) }
                td { (part(page, first)) ": " (first.message) }
            } }
        }))
        details {
            summary { "Show the first " (shown) }
            (violation_table(&["Time", "Place", "Part", "What happened"], &html! {
                @for violation in &trace.violations[..shown] { tr {
                    th scope="row" { (jump(violation.time)) }
                    td { (page.line.nodes[violation.node].name) }
                    td { (part(page, violation)) }
                    td { (violation.message) }
                } }
            }))
        }
    };
    section("violations", "Violations", &inside)
}

fn violation_table(headings: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll tabindex="0" role="group" aria-label="Table of violations" {
            table {
                thead { tr { @for heading in headings { th scope="col" { (heading) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A button that goes to a moment of the run.
fn jump(seconds: f64) -> Markup {
    html! { button.jump type="button" data-time=(seconds) { (duration(seconds)) } }
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
        @if let Some((place, text)) = rule_line(page, violation) { br; code { (text) } br; small { (place) } }
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
    let file = &page.sources.file(formula.span.file).name;
    let line = page.sources.start(formula.span).line;
    Some((format!("{file}:{line}"), formula.text.clone()))
}

pub(super) fn model(page: &Page<'_>) -> Markup {
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
    let digest = hash.finalize();
    digest.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn seeds(traces: &[Trace]) -> String {
    match traces {
        [first, .., last] => format!("{} to {}", first.seed, last.seed),
        [only] => only.seed.to_string(),
        [] => String::new(),
    }
}
