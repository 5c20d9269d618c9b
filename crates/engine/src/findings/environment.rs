//! Findings about the environment of a realizable contract: LW205 and LW206.

use super::lost::percent;
use super::shown;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Specification;
use linewright_core::source::Span;
use linewright_solver::game::EnvironmentFindings;

/// Returns the findings. `span` is the place of the contract's name.
pub fn findings(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    findings.extend(empty(specification, span, found));
    // If no plant can keep the assumptions, it is irrelevant whether the machine can break them.
    if !found.cannot_start && !found.unsatisfiable {
        findings.extend(forced(specification, span, found));
    }
    findings
}

/// LW206: no plant can keep the assumptions, or in some situations they leave the plant no next
/// step.
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
                "the assumptions of `{name}` contradict each other at the start, so every machine keeps the contract"
            ),
            "weaken an initial or `always` assumption, so that a plant can begin".to_owned(),
        );
    }
    if found.unsatisfiable {
        return warning(
            format!("no plant can keep all assumptions of `{name}`, so the verdict is meaningless"),
            "some assumptions cannot be kept together for ever; weaken one of them".to_owned(),
        );
    }
    let values = found.stuck_at_start.as_ref().or(found.dead_end.as_ref())?;
    warning(
        format!("the assumptions of `{name}` leave the plant no next step in some situations"),
        match shown(specification, values) {
            Some(values) => format!(
                "one of them is {values}; weaken an assumption there, or prevent the machine from leading the plant there"
            ),
            None => "this is the case in every situation that can occur; weaken an assumption"
                .to_owned(),
        },
    )
}

/// LW205: the machine can make the plant break an assumption.
fn forced(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Option<Diagnostic> {
    let name = &specification.name;
    let values = found.forced.as_ref()?;
    let share = |[from, all]: [f64; 2]| {
        if from >= all {
            "every situation that can occur".to_owned()
        } else {
            format!("{} of the situations that can occur", percent(from / all))
        }
    };
    let careful = share(found.forced_states);
    let reckless = share(found.forced_recklessly_states);
    let mut note = format!("it can do so from {careful}");
    if found.forced_recklessly.is_some() && reckless != careful {
        note.push_str("; if it does not keep its guarantees either, from ");
        note.push_str(&reckless);
    }
    let message = format!(
        "a controller of `{name}` can keep its contract by making the plant break an assumption"
    );
    let mut finding = Diagnostic::warning(codes::NOT_WELL_SEPARATED, span, message).with_note(note);
    for assumption in &found.broken {
        let formula = assumption.formula(&specification.assumptions);
        finding = finding.with_label(formula.span, "the plant can be made to break this");
    }
    let from = match shown(specification, values) {
        Some(values) => format!("one such situation is {values}: from there"),
        None => "from every situation that can occur,".to_owned(),
    };
    Some(finding.with_help(format!(
        "{from} the machine can prevent the plant from keeping {}; assume it only while the machine lets the plant keep it",
        if found.broken.is_empty() { "all assumptions" } else { "the marked assumption" }
    )))
}
