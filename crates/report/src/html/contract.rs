//! Parts of pages that show a contract: its interface, its rules, and plays as timing diagrams.

use super::parts::{behind, drawing, formula, table, table_of, with_code};
use linewright_core::drawing::timing::{self, Level};
use linewright_core::gr1::{FormulaKind, Owner, Specification, VarId, Variable, diagram};
use linewright_core::source::{SourceMap, Span};
use linewright_core::taxonomy::{self, Standard};
use linewright_language::contract::{Contract, Definition};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Maximum number of steps in a timing diagram.
const MAX_STEPS: usize = 400;

/// The contract's comment, and the terms of its codes in the taxonomies.
pub fn description(contract: &Contract) -> Markup {
    html! {
        @if !contract.doc.is_empty() { p.doc { (with_code(&contract.doc)) } }
        @if !contract.codes.is_empty() {
            p { @for (index, code) in contract.codes.iter().enumerate() {
                @if index > 0 { "; " }
                code { (code.text) }
                @if let Some(entry) = taxonomy::find(&code.text) { " " (entry.english) " (" (entry.standard.title()) ")" }
            } }
        }
    }
}

/// The standards from which codes such as `vdi:Drehen` are, as a sentence; `None` without codes.
pub fn standards<'a>(codes: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let found = codes.into_iter().filter_map(taxonomy::find);
    let standards: BTreeSet<Standard> = found.map(|entry| entry.standard).collect();
    let each = standards.iter().map(|standard| {
        let what = match standard {
            Standard::Din8580 => "manufacturing processes",
            Standard::Vdi2860 => "handling functions",
        };
        format!("{}: {} ({what})", standard.prefix(), standard.title())
    });
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("Codes are from these standards: {}.", each.join("; ")))
}

/// The parameters of a contract with the values for which it is shown.
pub fn parameters(contract: &Contract) -> Markup {
    let values = contract.arguments.iter();
    let values = values.map(|(name, value)| format!("{name} = {value}"));
    let values: Vec<String> = values.collect();
    html! {
        @if !values.is_empty() { p { "Parameters, with the values that they have here: " code { (values.join(", ")) } "." } }
    }
}

/// Rank of the headings above the tables of a contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// Below the heading of a section.
    Section,
    /// Below the heading of one of several declarations in a section.
    Declaration,
}

fn heading(rank: Rank, text: &str) -> Markup {
    html! {
        @match rank {
            Rank::Section => h3 { (text) },
            Rank::Declaration => h4 { (text) },
        }
    }
}

/// The signals of a contract with their values.
pub fn interface(specification: &Specification, rank: Rank) -> Markup {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (index, variable) in specification.variables.iter().enumerate() {
        if !specification.is_auxiliary(VarId(index as u32)) {
            rows.push(vec![
                variable.name.clone(),
                side(variable).to_owned(),
                variable.describe(),
            ]);
        }
    }
    html! {
        (heading(rank, "Interface"))
        (table(&["Signal", "Kind", "Values"], &rows))
    }
}

fn side(variable: &Variable) -> &'static str {
    match variable.owner {
        Owner::Environment => "input",
        Owner::System if variable.internal => "internal",
        Owner::System => "output",
    }
}

/// The assumptions and guarantees of a contract with their places in the files, and the definitions
/// that they use.
pub fn rules(
    specification: &Specification,
    definitions: &[Definition],
    sources: &SourceMap,
    rank: Rank,
) -> Markup {
    let place = |span: Span| {
        let file = &sources.file(span.file).name;
        format!("{file}:{}", sources.start(span).line)
    };
    let sides = [
        ("assumption", &specification.assumptions),
        ("guarantee", &specification.guarantees),
    ];
    html! {
        (heading(rank, "Rules"))
        (table_of("Rules", &["Rule", "Kind", "When", "Formula", "Place"], &html! {
            @for (kind, side) in sides { @for (when, _, formula) in side.formulas() { tr {
                th scope="row" { (formula.name) @if let Some(id) = &formula.requirement { br; small { (id) } } }
                td { (kind) }
                td { (time(when)) }
                td { (self::formula(&formula.text)) }
                td { (place(formula.span)) }
            } } }
        }))
        @if !definitions.is_empty() {
            p { "Definitions in these rules:" }
            (table_of("Definitions", &["Name", "Stands for", "Place"], &html! {
                @for definition in definitions { tr {
                    th scope="row" { code { (definition.name) } }
                    td { (formula(&definition.text)) }
                    td { (place(definition.span)) }
                } }
            }))
        }
    }
}

/// When a formula has to hold, in words.
pub fn time(kind: FormulaKind) -> &'static str {
    match kind {
        FormulaKind::Initial => "in step 0",
        FormulaKind::Invariant => "in every step",
        FormulaKind::Safety => "from every step to the next",
        FormulaKind::Justice => "again and again",
    }
}

/// Steps of a play as a timing diagram, with a table behind it. A step has a value for each
/// variable, unless it is not known.
pub fn play(
    title: &str,
    specification: &Specification,
    steps: &[Vec<Option<i64>>],
    repeats_from: Option<usize>,
) -> Markup {
    let shown = steps.len().min(MAX_STEPS);
    let diagram = diagram::of_steps(specification, &steps[..shown], repeats_from);
    let mut headings = vec!["Signal".to_owned()];
    headings.extend((0..shown).map(|step| format!("Step {step}")));
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    let signals = diagram.groups.iter().flat_map(|(_, signals)| signals);
    let rows = signals.map(|signal| {
        let values = signal.values.iter().map(|level| match level {
            Level::Bit(is_high) => is_high.to_string(),
            Level::Word(word) => word.clone(),
            Level::Unknown => "?".to_owned(),
        });
        std::iter::once(signal.name.clone()).chain(values).collect()
    });
    let rows: Vec<Vec<String>> = rows.collect();
    html! {
        (drawing(&timing::render(title, &diagram), &format!("Timing diagram: {title}. Its values are in the table below.")))
        p.hint { "A line at the top of a filled area is true, one at the bottom is false; other values are in boxes. A dashed box with ? has no value: the play ends there." }
        @if shown < steps.len() { p.hint { "The first " (shown) " of " (steps.len()) " steps." } }
        (behind(&headings, &rows))
    }
}
