//! Layouts, recipes and what is to be made, on the page of a check.

use super::document::Document;
use super::report::{Row, declaration, id};
use super::table::in_words;
use crate::report::html::parts::{count, findings};
use crate::source::SourceMap;
use maud::{Markup, html};

/// Id of the section.
pub(super) const ID: &str = "recipes";
/// Heading of the section.
pub(super) const TITLE: &str = "Layouts and recipes";

/// Whether the page has the section.
pub(super) fn is_shown(document: &Document) -> bool {
    let has_models = !document.layouts.is_empty() || !document.recipes.is_empty();
    has_models || !document.realizations.is_empty()
}

/// Rows of the table of results.
pub(super) fn rows(document: &Document) -> Vec<Row<'_>> {
    let realizations = document.realizations.iter().enumerate();
    let realizations = realizations.map(|(number, entry)| Row {
        id: id("realize", number),
        name: &entry.name,
        kind: "realize",
        mark: entry.verdict.into(),
        verdict: in_words(entry.verdict),
        details: match (entry.worst_case, entry.lower_bound) {
            (Some(steps), None) => {
                format!("{} in the worst case", count(steps as usize, "step"))
            }
            (Some(steps), Some(bound)) => format!(
                "{} in the worst case, by the first plan that was found; at least {bound}",
                count(steps as usize, "step")
            ),
            (None, _) => String::new(),
        },
        file: &entry.file,
        findings: &entry.findings,
    });
    let layouts = document.layouts.iter().enumerate();
    let layouts = layouts.map(|(number, entry)| Row {
        id: id("layout", number),
        name: &entry.name,
        kind: "layout",
        mark: entry.verdict.into(),
        verdict: in_words(entry.verdict),
        details: count(entry.resources, "resource"),
        file: &entry.file,
        findings: &entry.findings,
    });
    let recipes = document.recipes.iter().enumerate();
    let recipes = recipes.map(|(number, entry)| Row {
        id: id("recipe", number),
        name: &entry.name,
        kind: "recipe",
        mark: entry.verdict.into(),
        verdict: in_words(entry.verdict),
        details: count(entry.transitions, "transition"),
        file: &entry.file,
        findings: &entry.findings,
    });
    realizations.chain(layouts).chain(recipes).collect()
}

/// The inside of the section: each layout and each recipe, with its findings.
pub(super) fn section(document: &Document, sources: &SourceMap) -> Markup {
    html! {
        @for row in rows(document) {
            (declaration(
                &row.id,
                (row.name, row.file),
                row.mark,
                &row.verdict,
                row.findings,
                &html! {
                    @if !row.details.is_empty() { p { (row.details) "." } }
                    (findings(sources, row.findings))
                },
            ))
        }
    }
}
