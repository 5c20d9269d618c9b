//! `documentation/index.html`: what a person who imports a unit has to know.

use super::Unit;
use super::description::{TOOL, printable, variables};
use super::variables::{Causality, Kind, Variable};
use quick_xml::escape::escape;
use std::fmt::Write;

/// The page.
pub(super) fn documentation(unit: &Unit) -> String {
    let text = |t: &str| escape(printable(t)).into_owned();
    let name = text(&unit.name);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{name}</title></head>\n<body>\n<h1>{name}</h1>\n"
    );
    let doc = unit.doc.trim();
    if !doc.is_empty() {
        let _ = writeln!(out, "<p>{}</p>", text(doc));
    }
    let step = unit.step_seconds;
    let _ = write!(
        out,
        "<p>A machine of a production line with its verified controllers, made by {TOOL}.</p>\n\
         <h2>How to step it</h2>\n<ul>\n\
         <li>A communication step is a whole multiple of {step} s, the machine's own step. Another size is refused.</li>\n\
         <li>Inputs are read at the beginning of a communication step. Outputs change in steps only: no output depends on an input of \
         the same instant.</li>\n"
    );
    if unit.interface.find("operation").is_some() {
        out.push_str(
            "<li>An operation begins in the first step, and in the step after each one that ended an operation: with <code>operation</code>, \
             the part's properties and the parameters as they are then. Signals of the plant are read at every step. Set \
             <code>enabled</code> to false to let the machine wait.</li>\n\
             <li><code>done</code> is true after the step that ended an operation; <code>completed</code> counts them, for communication \
             steps of several of the machine's. <code>result.…</code> is what it has left in the part.</li>\n\
             <li>One of the machine's steps is one step of its controllers. What it takes by the machine's own times is another number: \
             <code>last.seconds</code> is how long the operation keeps the machine busy in the plant, <code>total.seconds</code> the sum.</li>\n",
        );
    } else {
        out.push_str(
            "<li>The machine has no operations: its controllers make a step whenever it is stepped. Set <code>enabled</code> to false to \
             let it stand still.</li>\n",
        );
    }
    out.push_str(
        "<li>Where the plant breaks an assumption of a contract, the step is answered with Error and nothing changes but \
         <code>verdict</code>; the logged text names the rule. Set other inputs, and step again.</li>\n\
         <li>At the step limit of an operation the machine is set back to before its first step.</li>\n</ul>\n",
    );
    let groups = [
        (Causality::Input, "Inputs"),
        (Causality::Parameter, "Parameters"),
        (Causality::Output, "Outputs"),
        (Causality::Local, "Inside"),
    ];
    for (causality, title) in groups {
        let rows: Vec<&Variable> = variables(unit)
            .filter(|v| v.causality == causality)
            .collect();
        if rows.is_empty() {
            continue;
        }
        let _ = writeln!(
            out,
            "<h2>{title}</h2>\n<table>\n<tr><th>name</th><th>type</th><th>unit</th><th>what it is</th></tr>"
        );
        for row in rows {
            let kind = match row.kind {
                Kind::Real => "real".to_owned(),
                Kind::Integer | Kind::Long => "integer".to_owned(),
                Kind::Boolean => "boolean".to_owned(),
                Kind::Enumeration(index) => unit.interface.enumerations[index].name.clone(),
            };
            let _ = writeln!(
                out,
                "<tr><td><code>{}</code></td><td>{kind}</td><td>{}</td><td>{}</td></tr>",
                row.name,
                text(&row.unit),
                text(&row.description)
            );
        }
        out.push_str("</table>\n");
    }
    if !unit.interface.enumerations.is_empty() {
        out.push_str("<h2>Labels</h2>\n<table>\n<tr><th>type</th><th>labels, from 1</th></tr>\n");
        for enumeration in &unit.interface.enumerations {
            let _ = writeln!(
                out,
                "<tr><td>{}</td><td>{}</td></tr>",
                enumeration.name,
                enumeration.labels.join(", ")
            );
        }
        out.push_str("</table>\n");
    }
    out.push_str("</body>\n</html>\n");
    out
}
