//! Proves that inner machines keep the contracts on which the proof of a machine relies.
//!
//! In the proof of a cell, an inner machine that refines a contract is represented by that
//! contract. This is sound if the inner machine, with the arguments given in the cell, keeps the
//! contract step by step in any environment. This module proves that, layer by layer from the
//! bottom. If an inner machine refines no contract, its own components take part in the proof of
//! the cell, and those of its own inner machines that refine a contract are represented likewise.

use crate::closed::undecided;
use crate::prover::Prover;
use crate::words::ProofPrinter;
use linewright_algebra::machine::of_refined_contract;
use linewright_algebra::proof::Claim;
use linewright_algebra::system::System;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::machine::{InnerMachine, Machine, RefinedContract};

/// Systems and claims that were proved before: two machines of the same kind are proved once.
type ProvedSystems = Vec<(System, Claim)>;

/// Proves the refinements on which the proof of a machine relies; a contract that is not kept is
/// reported at the inner machine.
pub(super) fn prove_refinements(
    machine: &Machine,
    prover: Prover<'_>,
    findings: &mut Vec<Diagnostic>,
) {
    let mut known = ProvedSystems::new();
    for inner in &machine.layers.inner {
        prove_inner(machine, inner, prover, &mut known, findings);
    }
}

/// Proves an inner machine and all machines in it, bottom-up.
fn prove_inner(
    machine: &Machine,
    inner: &InnerMachine,
    prover: Prover<'_>,
    known: &mut ProvedSystems,
    findings: &mut Vec<Diagnostic>,
) {
    for deeper in &inner.machine.layers.inner {
        // Findings about deeper layers are shown where the outer machine declares its inner one.
        let mut found = Vec::new();
        prove_inner(machine, deeper, prover, known, &mut found);
        findings.extend(found.into_iter().map(|mut f| {
            f.span = Some(inner.span);
            f
        }));
    }
    let Some(refined) = inner.machine.refines.first() else {
        return;
    };
    let (system, claim) = of_refined_contract(inner.machine.abstraction(), refined);
    if known.iter().any(|(s, c)| *s == system && *c == claim) {
        return;
    }
    match prover.prove_stepwise(&system, &claim) {
        Ok(proof) if proof.holds() => {}
        Ok(proof) => {
            let printer = ProofPrinter {
                system: &system,
                claim: &claim,
                whole: &refined.contract,
            };
            findings.push(broken(machine, inner, refined, printer, &proof));
        }
        Err(limit) => findings.push(undecided(inner.span, &inner.machine.name, limit)),
    }
    known.push((system, claim));
}

/// Finding for a contract that an inner machine does not keep, with the first reason.
fn broken(
    machine: &Machine,
    inner: &InnerMachine,
    refined: &RefinedContract,
    printer: ProofPrinter<'_>,
    proof: &linewright_algebra::proof::Proof,
) -> Diagnostic {
    let contract = &refined.contract;
    let finding = Diagnostic::error(
        codes::GUARANTEE_UNPROVED,
        inner.span,
        format!(
            "`{}` does not keep `{contract}`, on which the proof of `{}` relies",
            inner.name, machine.name
        ),
    )
    .with_label(refined.span, "declared to refine this contract");
    let finding = match proof.open.first() {
        Some(open) => {
            let formula = printer.formula(open.what);
            finding
                .with_label(
                    formula.span,
                    match open.what.component {
                        Some(_) => "this assumption of a component is not discharged",
                        None => "this guarantee is not kept",
                    },
                )
                .with_note(printer.counterexample(open))
        }
        None => finding,
    };
    finding.with_help(format!(
        "repair `{}`, or let it refine a weaker contract",
        inner.machine.name
    ))
}

/// Returns a note about values of inner machines that a machine reads although their contracts do
/// not mention them: proofs assume nothing about these values.
pub(super) fn note_on_unspecified(machine: &Machine) -> Option<String> {
    let mut unspecified = Vec::new();
    for component in &machine.abstraction().components {
        let inner = machine
            .layers
            .inner
            .iter()
            .find(|i| i.name == component.name);
        let Some(refined) = inner.and_then(|i| i.machine.refines.first()) else {
            continue;
        };
        let count = refined.specification.variables.len();
        for variable in &component.specification.variables[count..] {
            unspecified.push(format!(
                "`{}.{}`, which `{}` does not mention",
                component.name, variable.name, refined.contract
            ));
        }
    }
    if unspecified.is_empty() {
        return None;
    }
    Some(format!(
        "this machine reads {}; its proof assumes nothing about such a value: make it an output of the contract",
        unspecified.join(", ")
    ))
}
