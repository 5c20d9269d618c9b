//! What `check` says of a machine as a whole: how its components discharge one another's assumptions, whether it keeps its own guarantees, and
//! whether it refines the contracts that it is said to refine.

use super::document::RefinesEntry;
use super::layers;
use crate::algebra::machine::{COMPLETES, of_machine, of_promise};
use crate::algebra::proof::{Claim, Open, Proof, prove};
use crate::algebra::system::System;
use crate::cli::algebra::found;
use crate::cli::algebra::words::{DischargeEntry, Told, entry};
use crate::contract::machine::{Machine, Promised};
use crate::diagnostics::{Diagnostic, Severity, codes};
use crate::game::{Limit, Limits, RuleKind};
use crate::source::Span;
use crate::station::composition::{By, Composition};

/// What is known of a machine.
#[derive(Debug, Default)]
pub(super) struct Proved {
    /// How each assumption of a component is met, and each guarantee of the machine.
    pub(super) discharges: Vec<DischargeEntry>,
    /// The contracts that it is said to refine.
    pub(super) refines: Vec<RefinesEntry>,
    /// What is wrong.
    pub(super) findings: Vec<Diagnostic>,
}

/// Proves what is to be shown of a machine. `walked` is what its synthesized coordinator shows beside: what no contract implies may still
/// hold of the controllers that there are.
pub(super) fn proved(machine: &Machine, walked: Composition, limits: &Limits) -> Proved {
    let mut result = Proved::default();
    // An inner machine is known by what it promises; that it keeps the promise is shown first.
    layers::promises(machine, limits, &mut result.findings);
    let beyond = layers::beyond(machine);
    let machine = machine.abstracted();
    let (system, claim) = of_machine(machine);
    match prove(&system, &claim, limits) {
        Ok(proof) => {
            let told = Told {
                system: &system,
                claim: &claim,
                whole: &machine.name,
            };
            // What the walk shows of one assumption relies on all others.
            let (open, others): (Vec<_>, Vec<_>) =
                { walked.findings.into_iter() }.partition(|f| f.code == codes::ASSUMPTION_OPEN);
            let unfinished = !others.is_empty();
            result.findings.extend(others);
            let walked = if open.is_empty() {
                walked.discharges
            } else {
                Vec::new()
            };
            components(machine, told, proof, &walked, unfinished, &mut result);
        }
        Err(limit) => {
            // What the coordinator's states show is then all that there is.
            result
                .findings
                .push(undecided(machine.span, &machine.name, limit));
            result.findings.extend(walked.findings);
            result.discharges = walked.discharges.iter().map(by_controllers).collect();
        }
    }
    for promised in &machine.refines {
        result
            .refines
            .push(refines(machine, promised, limits, &mut result.findings));
    }
    for finding in &mut result.findings {
        if [codes::ASSUMPTION_OPEN, codes::PROMISE_BROKEN].contains(&finding.code) {
            finding.notes.extend(beyond.clone());
        }
    }
    result
}

/// The table of the components, and what is open.
fn components(
    machine: &Machine,
    told: Told<'_>,
    mut proof: Proof,
    walked: &[crate::station::composition::Discharge],
    unfinished: bool,
    result: &mut Proved,
) {
    let shown = |open: &Open| {
        let name = &told.formula(open.what).name;
        let owner = told.owner(open.what);
        let is = |d: &&crate::station::composition::Discharge| {
            d.component == owner && d.assumption == *name && d.by != By::Line
        };
        walked.iter().find(is)
    };
    let mut entries: Vec<(crate::algebra::system::FormulaRef, DischargeEntry)> = Vec::new();
    entries.extend(proof.discharges.iter().map(|d| (d.what, entry(told, d))));
    let mut settled = Vec::new();
    for open in &proof.open {
        if let Some(known) = shown(open) {
            entries.push((open.what, by_controllers(known)));
            settled.push(open.what);
        }
    }
    // That requests complete is shown of the controllers as well, operation by operation; where they do not, that is told there.
    let completes = |o: &Open| o.what.part.is_none() && told.formula(o.what).name == COMPLETES;
    if let Some(open) = proof.open.iter().find(|o| completes(o)) {
        settled.push(open.what);
        if !unfinished {
            let walked = DischargeEntry {
                component: machine.name.clone(),
                assumption: COMPLETES.to_owned(),
                rule: "controllers",
                turn: None,
                by: "the coordinator's reachable states".to_owned(),
            };
            entries.push((open.what, walked));
        }
    }
    proof.open.retain(|o| !settled.contains(&o.what));
    proof
        .circles
        .retain(|c| !c.assumptions.iter().any(|a| settled.contains(a)));
    entries.sort_by_key(|(at, _)| (at.part.unwrap_or(usize::MAX), at.kind, at.index));
    result.discharges = entries.into_iter().map(|(_, e)| e).collect();
    let circular: Vec<_> = { proof.circles.iter() }
        .flat_map(|c| c.assumptions.iter().copied())
        .collect();
    // A circle is one finding, and not one for each of its members as well.
    proof.open.retain(|o| !circular.contains(&o.what));
    let at = |part: Option<usize>| -> Option<Span> {
        let component = part.and_then(|p| machine.components.get(p));
        Some(component.map_or(machine.span, |c| c.span))
    };
    for mut finding in found::of_proof(told, &proof, &at) {
        let of_justice = proof.open.iter().any(|o| {
            let formula = told.formula(o.what);
            o.what.kind == RuleKind::Justice
                && o.what.part.is_some()
                && finding.labels.iter().any(|l| l.0 == formula.span)
        });
        // It may come true for a reason that nobody has written down.
        if of_justice && finding.code == codes::ASSUMPTION_OPEN {
            finding.severity = Severity::Warning;
        }
        result.findings.push(finding);
    }
}

/// A contract that the machine is said to refine.
fn refines(
    machine: &Machine,
    promised: &Promised,
    limits: &Limits,
    findings: &mut Vec<Diagnostic>,
) -> RefinesEntry {
    let (system, claim): (System, Claim) = of_promise(machine, promised);
    let told = Told {
        system: &system,
        claim: &claim,
        whole: &promised.contract,
    };
    let mut refined = RefinesEntry {
        contract: promised.contract.clone(),
        verdict: "refined",
        discharges: Vec::new(),
    };
    match prove(&system, &claim, limits) {
        Ok(proof) => {
            refined.discharges = proof.discharges.iter().map(|d| entry(told, d)).collect();
            if !proof.holds() {
                refined.verdict = "broken";
                let at = |part: Option<usize>| -> Option<Span> {
                    let component = part.and_then(|p| machine.components.get(p));
                    Some(component.map_or(promised.span, |c| c.span))
                };
                findings.extend(
                    found::of_proof(told, &proof, &at).into_iter().map(|f| {
                        f.with_label(promised.span, "on the way to refining this contract")
                    }),
                );
            }
        }
        Err(limit) => {
            refined.verdict = "gave_up";
            findings.push(undecided(promised.span, &machine.name, limit));
        }
    }
    refined
}

pub(super) fn undecided(span: Span, name: &str, limit: Limit) -> Diagnostic {
    Diagnostic::warning(
        codes::GAVE_UP,
        span,
        format!("whether the parts of `{name}` fit together was not decided: {limit}"),
    )
    .with_help("give it more with --timeout SECONDS and --memory MIB, or make the domains smaller")
}

/// What only the controllers that were synthesized show.
fn by_controllers(discharge: &crate::station::composition::Discharge) -> DischargeEntry {
    DischargeEntry {
        component: discharge.component.clone(),
        assumption: discharge.assumption.clone(),
        rule: "controllers",
        turn: None,
        by: match &discharge.by {
            By::Guarantee(name) => name.clone(),
            By::Coordinator => "the coordinator's reachable states".to_owned(),
            By::Plant => "what the machine's file fixes".to_owned(),
            By::Line => "the line, checked at every call".to_owned(),
        },
    }
}
