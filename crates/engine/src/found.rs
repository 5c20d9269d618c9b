//! Findings about proofs, and about contracts that cannot be combined.

use super::words::ProofPrinter;
use crate::findings::list;
use linewright_algebra::join::Mismatch;
use linewright_algebra::proof::{Open, Proof};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_language::order::lower::rule_name;

/// Converts a proof's failures to findings. `at` maps the index of a part to its place in the text.
/// It receives `None` for the claim's own formulas, which belong to no part.
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
        let (message, help) = printer.describe_loop(found);
        findings.push(Diagnostic::error(codes::SAME_STEP_LOOP, at(part), message).with_help(help));
    }
    for cycle in &proof.cycles {
        let part = cycle.assumptions.first().and_then(|a| a.component);
        let (message, help) = printer.describe_cycle(cycle);
        let mut finding = Diagnostic::error(codes::JUSTICE_CYCLE, at(part), message);
        for assumption in &cycle.assumptions {
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
    let (code, message, label) = match open.what.component {
        Some(part) => (
            codes::ASSUMPTION_UNDISCHARGED,
            format!(
                "the assumption `{}` of `{}` is not discharged: {reason}",
                formula.name, printer.system.components[part].name
            ),
            "this is assumed",
        ),
        None => (
            codes::GUARANTEE_UNPROVED,
            format!("`{}` of `{}` is not kept", formula.name, printer.whole),
            "this guarantee is not kept",
        ),
    };
    let help = match open.what.component {
        Some(_) if rule_name(&formula.name).is_some() => {
            "let the component that calls these skills keep the order. To leave the order to the caller of the machine, bind its skills to `operation` alone, and not also to what happens while the operation runs"
        }
        Some(_) => "let another contract guarantee it, or weaken the assumption",
        None => "add a guarantee that implies it, or weaken it",
    };
    Diagnostic::error(code, at(open.what.component), message)
        .with_label(formula.span, label)
        .with_note(printer.counterexample(open))
        .with_help(help)
}

/// Finding for contracts that cannot be combined.
pub fn of_mismatch(mismatch: &Mismatch) -> Diagnostic {
    match mismatch {
        Mismatch::DifferentDomains {
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
            "give both the same type, or rename one of them: --rename {}.{name}=...",
            second.0
        )),
        Mismatch::SeveralDrivers {
            name,
            first,
            second,
        } => Diagnostic::error(
            codes::PORTS,
            second.1,
            format!("`{name}` is set by `{}` and by `{}`", first.0, second.0),
        )
        .with_label(first.1, "first declared here")
        .with_help(format!(
            "make it an input of one of them; if these are different variables, rename one: --rename {}.{name}=...",
            second.0
        )),
        Mismatch::UnknownPort {
            contract,
            port,
            ports,
        } => Diagnostic::error(
            codes::PORTS,
            None,
            format!("`{contract}` has no variable `{port}` to rename"),
        )
        .with_help(format!("its variables are {}", list(ports))),
        Mismatch::DuplicatePortName { contract, name } => Diagnostic::error(
            codes::PORTS,
            None,
            format!("two variables of `{contract}` would be called `{name}`"),
        )
        .with_help("give each variable its own name"),
    }
}
