//! Proves what the proof of a machine relies on in its inner machines.
//!
//! In the proof of a cell, an inner machine that refines a contract is represented by that
//! contract. This is sound if the machine, with its arguments there, keeps the contract step by
//! step in any environment. That is proved here, layer by layer from the bottom. If it refines no
//! contract, its own components take part in the proof, and those of its machines that refine one
//! are represented likewise.

use crate::closed::undecided;
use crate::words::ProofPrinter;
use linewright_algebra::machine::of_promise;
use linewright_algebra::proof::{Claim, prove_stepwise};
use linewright_algebra::system::System;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::machine::{Inner, Machine, RefinedContract};
use linewright_solver::game::Limits;

/// Results of earlier proofs: two machines of the same kind are proved once.
type ProvedSystems = Vec<(System, Claim)>;

/// Proves the promises that the proof of a machine relies on; a broken promise is a finding at the
/// inner machine.
pub(super) fn promises(machine: &Machine, limits: &Limits, findings: &mut Vec<Diagnostic>) {
    let mut known = ProvedSystems::new();
    for inner in &machine.layers.inner {
        below(machine, inner, limits, &mut known, findings);
    }
}

fn below(
    machine: &Machine,
    inner: &Inner,
    limits: &Limits,
    known: &mut ProvedSystems,
    findings: &mut Vec<Diagnostic>,
) {
    for deeper in &inner.machine.layers.inner {
        // Faults of deeper layers are shown where this machine names its own inner machine.
        let mut found = Vec::new();
        below(machine, deeper, limits, known, &mut found);
        findings.extend(found.into_iter().map(|mut f| {
            f.span = Some(inner.span);
            f
        }));
    }
    let Some(promised) = inner.machine.refines.first() else {
        return;
    };
    let (system, claim) = of_promise(inner.machine.abstracted(), promised);
    if known.iter().any(|(s, c)| *s == system && *c == claim) {
        return;
    }
    match prove_stepwise(&system, &claim, limits) {
        Ok(proof) if proof.holds() => {}
        Ok(proof) => {
            let printer = ProofPrinter {
                system: &system,
                claim: &claim,
                whole: &promised.contract,
            };
            findings.push(broken(machine, inner, promised, printer, &proof));
        }
        Err(limit) => findings.push(undecided(inner.span, &inner.machine.name, limit)),
    }
    known.push((system, claim));
}

/// Finding for a broken promise, with the first reason.
fn broken(
    machine: &Machine,
    inner: &Inner,
    promised: &RefinedContract,
    printer: ProofPrinter<'_>,
    proof: &linewright_algebra::proof::Proof,
) -> Diagnostic {
    let contract = &promised.contract;
    let finding = Diagnostic::error(
        codes::PROMISE_BROKEN,
        inner.span,
        format!(
            "`{}` does not keep `{contract}`, by which the proof of `{}` knows it",
            inner.name, machine.name
        ),
    )
    .with_label(promised.span, "it is said to refine this");
    let finding = match proof.open.first() {
        Some(open) => {
            let formula = printer.formula(open.what);
            finding
                .with_label(
                    formula.span,
                    match open.what.part {
                        Some(_) => "this is assumed within it, and not met",
                        None => "this is not kept",
                    },
                )
                .with_note(printer.shown(open))
        }
        None => finding,
    };
    finding.with_help(format!(
        "repair `{}`, or let it refine a contract that promises less",
        inner.machine.name
    ))
}

/// Values of inner machines that a machine reads although their contracts do not mention them;
/// proofs know nothing about those.
pub(super) fn beyond(machine: &Machine) -> Option<String> {
    let mut unspecified = Vec::new();
    for component in &machine.abstracted().components {
        let inner = machine
            .layers
            .inner
            .iter()
            .find(|i| i.name == component.name);
        let Some(promised) = inner.and_then(|i| i.machine.refines.first()) else {
            continue;
        };
        let count = promised.specification.variables.len();
        for variable in &component.specification.variables[count..] {
            unspecified.push(format!(
                "`{}.{}`, of which `{}` says nothing",
                component.name, variable.name, promised.contract
            ));
        }
    }
    if unspecified.is_empty() {
        return None;
    }
    Some(format!(
        "this machine reads {}; in its proof that can be anything: make it an output of the contract",
        unspecified.join(", ")
    ))
}
