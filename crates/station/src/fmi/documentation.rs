//! Renders `documentation/index.html`, the page for users who import a unit.

use super::Unit;
use super::description::{TOOL, printable, variables};
use super::variables::{Causality, Kind};
use crate::template::render;
use quick_xml::escape::escape;
use serde::Serialize;

/// The fields of `documentation.html`, all of them escaped.
#[derive(Serialize)]
struct Page<'a> {
    name: String,
    doc: String,
    tool: &'static str,
    step_seconds: String,
    has_operations: bool,
    groups: Vec<Group<'a>>,
    enumerations: Vec<Enumeration<'a>>,
}

/// The variables of one causality.
#[derive(Serialize)]
struct Group<'a> {
    title: &'static str,
    rows: Vec<Row<'a>>,
}

/// A variable.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    kind: &'a str,
    unit: String,
    about: String,
}

#[derive(Serialize)]
struct Enumeration<'a> {
    name: &'a str,
    labels: String,
}

/// Renders the page.
pub(super) fn documentation(unit: &Unit) -> String {
    let text = |t: &str| escape(printable(t)).into_owned();
    let kind = |kind: &Kind| match kind {
        Kind::Real => "real",
        Kind::Integer | Kind::Long => "integer",
        Kind::Boolean => "boolean",
        Kind::Enumeration(index) => unit.interface.enumerations[*index].name.as_str(),
    };
    let groups = [
        (Causality::Input, "Inputs"),
        (Causality::Parameter, "Parameters"),
        (Causality::Output, "Outputs"),
        (Causality::Local, "Internal variables"),
    ];
    let groups = groups.into_iter().map(|(causality, title)| {
        let rows = variables(unit).filter(|v| v.causality == causality);
        let rows = rows.map(|v| Row {
            name: &v.name,
            kind: kind(&v.kind),
            unit: text(&v.unit),
            about: text(&v.description),
        });
        Group {
            title,
            rows: rows.collect(),
        }
    });
    let enumerations = unit
        .interface
        .enumerations
        .iter()
        .map(|enumeration| Enumeration {
            name: &enumeration.name,
            labels: enumeration.labels.join(", "),
        });
    render(
        "fmi/documentation.html",
        Page {
            name: text(&unit.name),
            doc: text(unit.doc.trim()),
            tool: TOOL,
            step_seconds: unit.step_seconds.to_string(),
            has_operations: unit.interface.find("operation").is_some(),
            groups: groups.filter(|g| !g.rows.is_empty()).collect(),
            enumerations: enumerations.collect(),
        },
    )
}
