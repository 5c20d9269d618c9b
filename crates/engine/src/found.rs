//! Findings about a composition.

use super::words::ProofPrinter;
use crate::findings::list;
use linewright_algebra::join::Mismatch;
use linewright_algebra::proof::{Open, Proof};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_language::order::lower::rule_of;

/// Converts a proof's failures to findings. `at` maps a part to its place in the text; the claim's
/// own formulas have no part.
pub fn of_proof(
    printer: ProofPrinter<'_>,
    proof: &Proof,
    at: &dyn Fn(Option<usize>) -> Option<Span>,
) -> Vec<Diagnostic> {
    let mut findings = Vec::new();
    for found in &proof.loops {
        let part = found
            .variables
            .first()
            .and_then(|v| printer.system.driver(*v));
        let (message, help) = printer.same_step(found);
        findings.push(Diagnostic::error(codes::SAME_STEP_LOOP, at(part), message).with_help(help));
    }
    for circle in &proof.circles {
        let part = circle.assumptions.first().and_then(|a| a.part);
        let (message, help) = printer.circle(circle);
        let mut finding = Diagnostic::error(codes::JUSTICE_CIRCLE, at(part), message);
        for assumption in &circle.assumptions {
            let formula = printer.formula(*assumption);
            finding = finding.with_label(formula.span, "this waits for the other");
        }
        findings.push(finding.with_help(help));
    }
    findings.extend(proof.open.iter().map(|o| open(printer, o, at)));
    findings
}

/// Finding for an obligation that is not met.
fn open(
    printer: ProofPrinter<'_>,
    open: &Open,
    at: &dyn Fn(Option<usize>) -> Option<Span>,
) -> Diagnostic {
    let formula = printer.formula(open.what);
    let reason = printer.reason(open);
    let (code, message, label) = match open.what.part {
        Some(part) => (
            codes::ASSUMPTION_OPEN,
            format!(
                "the assumption `{}` of `{}` is not discharged: {reason}",
                formula.name, printer.system.parts[part].name
            ),
            "this is assumed",
        ),
        None => (
            codes::PROMISE_BROKEN,
            format!("`{}` of `{}` is not kept", formula.name, printer.whole),
            "this is to be kept",
        ),
    };
    let help = match open.what.part {
        Some(_) if rule_of(&formula.name).is_some() => {
            "let what calls its skills keep the order. One that whoever asks for operations is to keep names skills that are bound to `operation` alone, and not also to what happens while it runs"
        }
        Some(_) => "let another contract guarantee it, or weaken the assumption to what it needs",
        None => "add a guarantee from which it follows, or promise less",
    };
    Diagnostic::error(code, at(open.what.part), message)
        .with_label(formula.span, label)
        .with_note(printer.shown(open))
        .with_help(help)
}

/// Finding for contracts that cannot be combined.
pub fn of_mismatch(mismatch: &Mismatch) -> Diagnostic {
    match mismatch {
        Mismatch::Domains {
            name,
            first,
            second,
        } => Diagnostic::error(
            codes::PORTS,
            second.2,
            format!(
                "`{name}` is {} in `{}`, and {} in `{}`",
                second.1, second.0, first.1, first.0
            ),
        )
        .with_label(first.2, "declared here")
        .with_help(format!(
            "give both the same type, or tell them apart: --rename {}.{name}=...",
            second.0
        )),
        Mismatch::Drivers {
            name,
            first,
            second,
        } => Diagnostic::error(
            codes::PORTS,
            second.1,
            format!("`{name}` is set by `{}` and by `{}`", first.0, second.0),
        )
        .with_label(first.1, "the first one")
        .with_help(format!(
            "one of them has to read it as an input, or they are different variables: --rename {}.{name}=...",
            second.0
        )),
        Mismatch::NoPort {
            contract,
            port,
            ports,
        } => Diagnostic::error(
            codes::PORTS,
            None,
            format!("`{contract}` has no variable `{port}` to rename"),
        )
        .with_help(format!("its variables are {}", list(ports))),
        Mismatch::Twice { contract, name } => Diagnostic::error(
            codes::PORTS,
            None,
            format!("two variables of `{contract}` would be called `{name}`"),
        )
        .with_help("give each a name of its own"),
    }
}
