//! Findings about the environment of a realizable contract: LW205 and LW206.

use super::lost::percent;
use super::shown;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Specification;
use linewright_core::source::Span;
use linewright_solver::game::EnvironmentFindings;

/// Returns what makes a realizable contract mean less than it seems to: LW205 and LW206.
pub fn findings(
    specification: &Specification,
    span: Span,
    found: &EnvironmentFindings,
) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    findings.extend(empty(specification, span, found));
    // If no plant can keep the assumptions, whether the machine could break them does not matter.
    if !found.cannot_start && !found.unsatisfiable {
        findings.extend(forced(specification, span, found));
    }
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
            format!("no plant can keep all assumptions of `{name}`, so the verdict means nothing"),
            "some assumptions contradict each other in the long run; weaken one of them".to_owned(),
        );
    }
    let values = found.stuck_at_start.as_ref().or(found.dead_end.as_ref())?;
    warning(
        format!("the assumptions of `{name}` leave the plant no next step in some situations"),
        match shown(specification, values) {
            Some(values) => format!(
                "one of them is {values}; weaken an assumption there, or keep the machine from bringing the plant there"
            ),
            None => "in fact in every situation that can occur: weaken an assumption".to_owned(),
        },
    )
}

/// LW205
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
    let mut note = format!("it can force that from {}", share(found.forced_states));
    if found.forced_recklessly.is_some() {
        note.push_str("; a machine that also broke its guarantees, from ");
        note.push_str(&share(found.forced_recklessly_states));
    }
    let message = format!(
        "a controller of `{name}` may keep its contract by making the plant break an assumption"
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
        "{from} the machine can bring it about that the plant cannot keep {}; ask for that only as long as the machine lets the plant keep it",
        if found.broken.is_empty() { "all assumptions" } else { "the marked assumption" }
    )))
}
