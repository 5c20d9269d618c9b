//! What is odd about the plant's side of a contract that is realizable: LW205 and LW206.

use crate::diagnostics::{Diagnostic, codes};
use crate::game::EnvironmentFindings;
use crate::gr1::Specification;
use crate::source::Span;

/// What makes a realizable contract mean less than it seems to: LW205 and LW206.
pub fn findings(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Vec<Diagnostic> {
    let name = &specification.name;
    let mut findings = Vec::new();
    if found.cannot_start {
        findings.push(
            Diagnostic::warning(
                codes::ENVIRONMENT_EMPTY,
                span,
                format!("the assumptions of `{name}` contradict each other at the start, so every machine keeps it"),
            )
            .with_help("no plant can begin like this; weaken an initial or `always` assumption"),
        );
    } else if let Some(values) = found.stuck_at_start.as_ref().or(found.dead_end.as_ref()) {
        findings.push(
            Diagnostic::warning(
                codes::ENVIRONMENT_EMPTY,
                span,
                format!(
                    "the assumptions of `{name}` leave the plant no next step in some situations"
                ),
            )
            .with_help(format!(
                "one of them is {}",
                situation(specification, values)
            )),
        );
    }
    if let Some(values) = &found.forced {
        findings.push(
            Diagnostic::warning(
                codes::NOT_WELL_SEPARATED,
                span,
                format!("a controller of `{name}` may keep its contract by making the plant break an assumption"),
            )
            .with_help(format!(
                "it can force that from {}; let assumptions speak of what the plant decides, not of what the machine does to it",
                situation(specification, values)
            )),
        );
    }
    findings
}

/// A valuation in words.
fn situation(specification: &Specification, values: &[i64]) -> String {
    let shown: Vec<String> = specification
        .variables
        .iter()
        .zip(values)
        .map(|(v, x)| format!("{} = {}", v.name, v.show(*x)))
        .collect();
    shown.join(", ")
}
