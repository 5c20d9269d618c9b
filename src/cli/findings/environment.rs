//! What is odd about the plant's side of a contract that is realizable: LW205 and LW206.

use super::situation;
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
    let mut findings = Vec::new();
    findings.extend(empty(specification, span, found));
    findings.extend(forced(specification, span, found));
    findings
}

/// LW206
fn empty(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Option<Diagnostic> {
    let name = &specification.name;
    let warning = |text: String, help: String| {
        Some(Diagnostic::warning(codes::ENVIRONMENT_EMPTY, span, text).with_help(help))
    };
    if found.cannot_start {
        return warning(
            format!(
                "the assumptions of `{name}` contradict each other at the start, so every machine keeps it"
            ),
            "no plant can begin like this; weaken an initial or `always` assumption".to_owned(),
        );
    }
    if found.unsatisfiable {
        return warning(
            format!(
                "no plant can keep all assumptions of `{name}`, so every machine keeps it in the end"
            ),
            "some assumptions contradict each other in the long run; weaken one of them".to_owned(),
        );
    }
    let values = found.stuck_at_start.as_ref().or(found.dead_end.as_ref())?;
    warning(
        format!("the assumptions of `{name}` leave the plant no next step in some situations"),
        format!(
            "one of them is {}; weaken an assumption there, or keep the machine from bringing the plant there",
            situation(specification, values)
        ),
    )
}

/// LW205
fn forced(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Option<Diagnostic> {
    let name = &specification.name;
    let (values, [from, all]) = match (&found.forced, &found.forced_recklessly) {
        (Some(values), _) => (values, found.forced_states),
        (None, Some(values)) => (values, found.forced_recklessly_states),
        (None, None) => return None,
    };
    let share = if from >= all {
        "every situation that can occur".to_owned()
    } else {
        format!("{from} of the {all} situations that can occur")
    };
    let mut finding = if found.forced.is_some() {
        Diagnostic::warning(
            codes::NOT_WELL_SEPARATED,
            span,
            format!(
                "a controller of `{name}` may keep its contract by making the plant break an assumption"
            ),
        )
        .with_note(format!("it can force that from {share}"))
    } else {
        Diagnostic::note(
            codes::NOT_WELL_SEPARATED,
            span,
            format!(
                "only the guarantees of `{name}` keep its controller from making the plant break an assumption"
            ),
        )
        .with_note(format!(
            "a machine that breaks its guarantees can force that from {share}"
        ))
    };
    for assumption in &found.broken {
        let formula = assumption.formula(&specification.assumptions);
        finding = finding.with_label(formula.span, "the plant can be made to break this");
    }
    Some(finding.with_help(format!(
        "one such situation is {}; let assumptions speak of what the plant decides, not of what the machine does to it",
        situation(specification, values)
    )))
}
