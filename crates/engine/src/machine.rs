//! Proofs about a machine as a whole: its components discharge each other's assumptions, it keeps
//! its own guarantees, and it refines the contracts named in its declaration.

use super::layers;
use crate::closed::{self, undecided};
use crate::controlled::{self, ControlledMachine};
use crate::found;
use crate::internal::within;
use crate::prover::Prover;
use crate::words::{
    DischargeEntry, DischargeRuleName, KEPT_BY_LINE, ProofPrinter, discharge_entry,
};
use linewright_algebra::closed::{ClosedComposition, DischargeMethod, Form, Verdict};
use linewright_algebra::machine::{COMPLETES, of_machine, of_refined_contract};
use linewright_algebra::proof::{Claim, Cycle, Proof};
use linewright_algebra::system::{FormulaRef, System};
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_core::gr1::FormulaKind;
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, RefinedContract};
use linewright_solver::game::{Budget, Limit};
use linewright_station::composition::{Composition, Discharger};
use schemars::JsonSchema;
use serde::Serialize;

/// Context in which a machine works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineContext {
    /// On its own in a plant, in which its signals have the values declared in its file.
    Alone,
    /// Only within other machines, which bind its signals; the proofs of those machines include it.
    Within,
}

/// Whether to count the reachable states of the closed composition of a machine's controllers,
/// which takes longer than its proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StateCount {
    /// Counted.
    Wanted,
    /// Not counted.
    Omitted,
}

/// Result of the proofs of a machine.
#[derive(Debug, Default)]
pub struct MachineProof {
    /// How each assumption of a component and each guarantee of the machine is met.
    pub discharges: Vec<DischargeEntry>,
    /// Verdict on the closed composition of its controllers; `None` before it was tried.
    pub closed: Option<ClosedEntry>,
    /// Verdicts on the contracts that the machine is declared to refine.
    pub refines: Vec<RefinesEntry>,
    /// Problems found.
    pub findings: Vec<Diagnostic>,
}

/// Verdict on the closed composition of a machine's controllers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClosedVerdict {
    /// The controllers meet all obligations.
    Holds,
    /// A run violates an obligation.
    Broken,
    /// Some obligation is undecided, because a controller is represented by its contract.
    Open,
    /// A limit was reached.
    GaveUp,
}

/// Whether a machine keeps a contract that it is declared to refine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RefinementVerdict {
    /// The machine keeps the contract.
    Refined,
    /// A run violates the contract.
    Broken,
    /// A limit was reached.
    GaveUp,
}

/// The closed composition, in which controllers represent the components.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ClosedEntry {
    /// Verdict on the composition.
    pub verdict: ClosedVerdict,
    /// Number of reachable states: combinations of the values of all wires, the states of the
    /// tables, and the progress of operations. Absent if it was not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub states: Option<u64>,
    /// How each component is represented.
    pub components: Vec<TakenEntry>,
}

/// How a component is represented in the closed composition.
#[derive(Debug, JsonSchema, Serialize)]
pub struct TakenEntry {
    /// Name of the component.
    pub name: String,
    /// Form in which it is represented.
    #[serde(rename = "as")]
    pub form: Form,
}

/// A contract that a machine is declared to refine.
#[derive(Debug, JsonSchema, Serialize)]
pub struct RefinesEntry {
    /// Name of the contract.
    pub contract: String,
    /// Whether the machine keeps the contract.
    pub verdict: RefinementVerdict,
    /// Verdict of the closed composition, if the components' contracts do not prove the refinement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closed: Option<ClosedVerdict>,
    /// How each assumption of a component and each guarantee of the contract is met.
    pub discharges: Vec<DischargeEntry>,
}

/// Proves the obligations of a machine, both for all controllers that keep the contracts and for
/// the actual controllers. The latter can meet obligations that no contract implies.
pub fn prove_machine(
    controlled: &ControlledMachine<'_>,
    context: MachineContext,
    prover: Prover<'_>,
    state_count: StateCount,
) -> MachineProof {
    let prover = prover.with_budget(Budget::MACHINE);
    let mut result = MachineProof::default();
    // An inner machine is represented by the contracts that it refines. First, it is proved that
    // the machine keeps them.
    within("proving its inner machines", || {
        layers::prove_refinements(controlled.machine, prover, &mut result.findings);
    });
    let unspecified = layers::note_on_unspecified(controlled.machine);
    let machine = controlled.machine.abstraction();
    let (system, claim) = of_machine(machine);
    let closed = ClosedComposition::of_machine(controlled.machine, &controlled.controllers);
    let flat = &controlled.machine.refines;
    let refined: Vec<(&RefinedContract, (System, Claim))> = machine
        .refines
        .iter()
        .map(|contract| (contract, of_refined_contract(machine, contract)))
        .collect();
    let proof = within("proving it from its contracts", || {
        prover.prove_stepwise(&system, &claim)
    });
    let closed = knowing(closed, controlled, &proof);
    let (decided, refinements) = rayon::join(
        || {
            within("putting its controllers together", || {
                prover.decide_closed(&closed)
            })
        },
        || {
            within("proving it from its contracts", || {
                let claims = refined.iter();
                let refinements =
                    claims.map(|(_, (system, claim))| prover.prove_stepwise(system, claim));
                refinements.collect::<Vec<_>>()
            })
        },
    );
    let states = if state_count == StateCount::Wanted && decided.is_ok() {
        prover.count_states(&closed).ok()
    } else {
        None
    };
    result.closed = Some(closed_entry(&closed, &decided, states));
    // If the composition is too large, only the coordinator's states are explored; all other
    // components can do anything.
    let walked = match &decided {
        Err(_) if !is_layered(controlled) => controlled::compose(controlled),
        _ => Composition::default(),
    };
    let both = CombinedProof {
        printer: ProofPrinter {
            system: &system,
            claim: &claim,
            whole: &machine.name,
        },
        span: machine.span,
        machine,
        closed: &closed,
        verdict: decided.as_ref().ok().filter(|_| !is_layered(controlled)),
        walked: &walked,
    };
    match proof {
        Ok(proof) => result.discharges = both.merged(proof, &mut result.findings),
        Err(limit) => {
            // This finding also covers whatever the controllers leave undecided.
            let limited = undecided(machine.span, &machine.name, limit);
            if let Some(verdict) = both.verdict {
                let met = verdict.met.iter().map(|(at, met)| both.shown(*at, *met));
                result.discharges = met.collect();
                both.report_open(verdict, &[], &mut result.findings);
                if !verdict.undecided.is_empty() {
                    result.findings.push(limited);
                }
            } else {
                result.findings.push(limited);
                let open = walked
                    .findings
                    .iter()
                    .filter(|f| f.code == codes::ASSUMPTION_UNDISCHARGED);
                result.findings.extend(open.cloned());
            }
        }
    }
    if let Ok(verdict) = &decided {
        // The proof represents inner machines by their contracts; the closed composition has the
        // controllers of all layers. The two can come to the same finding.
        if is_layered(controlled) {
            let mut open = Vec::new();
            both.report_open(verdict, &[], &mut open);
            open.retain(|finding| !result.findings.contains(finding));
            result.findings.append(&mut open);
        }
        let operations = closed::operations(&closed, verdict, context);
        result.findings.extend(operations);
    } else {
        let walked = walked.findings.into_iter();
        let others = walked.filter(|f| f.code != codes::ASSUMPTION_UNDISCHARGED);
        result.findings.extend(others);
    }
    cut_short(machine.span, machine, &decided, &mut result.findings);
    for (((contract, (system, claim)), proof), flat) in refined.iter().zip(refinements).zip(flat) {
        let refinement = Refinement {
            contract,
            flat,
            system,
            claim,
        };
        let entry = refines(controlled, &refinement, proof, prover, &mut result.findings);
        result.refines.push(entry);
    }
    for finding in &mut result.findings {
        if [codes::ASSUMPTION_UNDISCHARGED, codes::GUARANTEE_UNPROVED].contains(&finding.code) {
            finding.notes.extend(unspecified.clone());
        }
    }
    result
}

/// Reports that the controllers were not composed because the command reached a limit, unless that
/// was already reported.
fn cut_short(
    span: Span,
    machine: &Machine,
    decided: &Result<Verdict, Limit>,
    findings: &mut Vec<Diagnostic>,
) {
    if let Err(limit) = decided
        && limit.is_external()
        && !findings.iter().any(|f| f.gave_up)
    {
        findings.push(undecided(span, &machine.name, *limit));
    }
}

/// The closed composition with the justice that was proved from the contracts. A machine that has
/// inner machines is proved over other wires than those of its composition.
fn knowing<'a>(
    closed: ClosedComposition<'a>,
    controlled: &ControlledMachine<'_>,
    proof: &Result<Proof, Limit>,
) -> ClosedComposition<'a> {
    match proof {
        Ok(proof) if !is_layered(controlled) => closed.knowing(proof),
        _ => closed,
    }
}

/// Whether the machine has inner machines, which its proof represents by their contracts.
fn is_layered(controlled: &ControlledMachine<'_>) -> bool {
    controlled.machine.layers.abstraction.is_some()
}

/// Combines the proof from the contracts with what the composition of the controllers shows.
struct CombinedProof<'a> {
    printer: ProofPrinter<'a>,
    span: Span,
    /// The machine as seen by the proof.
    machine: &'a Machine,
    closed: &'a ClosedComposition<'a>,
    /// Verdict on the composition of the controllers, for the formulas of the proof; `None` if a
    /// limit was reached, or if the machine has inner machines.
    verdict: Option<&'a Verdict>,
    /// If there is no verdict: result of exploring the coordinator's states.
    walked: &'a Composition,
}

impl CombinedProof<'_> {
    /// Returns the table of met obligations, and adds findings for the others.
    fn merged(&self, mut proof: Proof, findings: &mut Vec<Diagnostic>) -> Vec<DischargeEntry> {
        let mut entries: Vec<(FormulaRef, DischargeEntry)> = Vec::new();
        entries.extend(
            proof
                .discharges
                .iter()
                .map(|d| (d.what, discharge_entry(self.printer, d))),
        );
        if let Some(verdict) = self.verdict.filter(|_| proof.loops.is_empty()) {
            // For a stuck component, only the cause is reported.
            let is_stuck = |part: Option<usize>| {
                let mut stuck = verdict.stuck.iter();
                stuck.any(|s| Some(s.component) == part)
            };
            proof.open.retain(|o| !is_stuck(o.what.component));
            for open in &proof.open {
                if let Some(met) = verdict.is_met(open.what) {
                    entries.push((open.what, self.shown(open.what, met)));
                }
            }
            let is_met = |at: &FormulaRef| verdict.is_met(*at).is_some();
            let (resolved, cycles) = proof
                .cycles
                .into_iter()
                .partition(|c: &Cycle| c.assumptions.iter().any(is_met));
            proof.cycles = cycles;
            self.report_resolved(resolved, findings);
            self.report_open(verdict, &members(&proof), findings);
            let settled =
                |at: FormulaRef| verdict.is_met(at).is_some() || verdict.is_open(at).is_some();
            proof.open.retain(|o| !settled(o.what));
        } else {
            let shown = self.by_the_walk(&proof);
            let is_met = |at: &FormulaRef| shown.iter().any(|(known, _)| known == at);
            proof.open.retain(|o| !is_met(&o.what));
            proof.cycles.retain(|c| !c.assumptions.iter().any(is_met));
            entries.extend(shown);
        }
        entries.sort_by_key(|(at, _)| (at.component.unwrap_or(usize::MAX), at.kind, at.index));
        self.report_unsettled(&mut proof, findings);
        entries.into_iter().map(|(_, e)| e).collect()
    }

    /// Obligations that are met in all states of the coordinator although the contracts do not
    /// imply them. Assumptions are included if no assumption is found to be violated; the
    /// completion of requests is included if there are no findings at all.
    fn by_the_walk(&self, proof: &Proof) -> Vec<(FormulaRef, DischargeEntry)> {
        let sound = self
            .walked
            .findings
            .iter()
            .all(|f| f.code != codes::ASSUMPTION_UNDISCHARGED);
        let complete = self.walked.findings.is_empty() && !self.walked.discharges.is_empty();
        let shows = |at: FormulaRef| {
            let name = &self.printer.formula(at).name;
            let owner = self.printer.owner(at);
            let mut walked = self.walked.discharges.iter();
            let known = walked
                .any(|d| d.component == owner && d.assumption == *name && d.by != Discharger::Line);
            (sound && known) || (complete && at.component.is_none() && name == COMPLETES)
        };
        let open = proof.open.iter().filter(|o| shows(o.what));
        open.map(|o| {
            let mut shown = self.shown(o.what, DischargeMethod::Held);
            "the coordinator's reachable states".clone_into(&mut shown.by);
            (o.what, shown)
        })
        .collect()
    }

    /// Reports the obligations that the controllers violate, except those in `skipped`, and stuck
    /// components.
    fn report_open(
        &self,
        verdict: &Verdict,
        skipped: &[FormulaRef],
        findings: &mut Vec<Diagnostic>,
    ) {
        // Completion is left out because it is reported per operation, and members of a cycle
        // because the whole cycle is one finding.
        let open = verdict.open.iter();
        let open =
            open.filter(|o| !closed::is_completion(self.closed, o) && !skipped.contains(&o.what));
        findings.extend(open.map(|o| closed::open(self.closed, self.printer.whole, o, self.span)));
        findings.extend(verdict.stuck.iter().map(|s| closed::stuck(self.closed, s)));
    }

    /// Reports the obligations that the contracts do not discharge and that the controllers neither
    /// meet nor violate.
    fn report_unsettled(&self, proof: &mut Proof, findings: &mut Vec<Diagnostic>) {
        let circular = members(proof);
        // A cycle is one finding, without extra findings for its members.
        proof.open.retain(|o| !circular.contains(&o.what));
        for mut finding in found::of_proof(self.printer, proof, &|part| Some(self.at(part))) {
            let of_justice = proof.open.iter().any(|o| {
                let formula = self.printer.formula(o.what);
                o.what.kind == FormulaKind::Justice
                    && o.what.component.is_some()
                    && finding.labels.iter().any(|l| l.0 == formula.span)
            });
            // The assumption can still hold for a reason that no contract states.
            if of_justice && finding.code == codes::ASSUMPTION_UNDISCHARGED {
                finding.severity = Severity::Warning;
            }
            findings.push(finding);
        }
    }

    /// Reports cycles of contracts in which the actual controllers do not wait for ever.
    fn report_resolved(&self, cycles: Vec<Cycle>, findings: &mut Vec<Diagnostic>) {
        let proof = Proof {
            cycles,
            ..Proof::default()
        };
        for mut finding in found::of_proof(self.printer, &proof, &|part| Some(self.at(part))) {
            finding.severity = Severity::Warning;
            findings.push(finding.with_note(
                "the synthesized controllers do not wait for ever, but other controllers that keep these contracts can",
            ));
        }
    }

    /// Place of a part in the text.
    fn at(&self, part: Option<usize>) -> Span {
        let component = part.and_then(|p| self.machine.components.get(p));
        component.map_or(self.span, |c| c.span)
    }

    /// Entry for an obligation that the controllers meet although the contracts do not imply it.
    fn shown(&self, at: FormulaRef, met: DischargeMethod) -> DischargeEntry {
        DischargeEntry {
            component: self.printer.owner(at).to_owned(),
            assumption: self.printer.formula(at).name.clone(),
            rule: match met {
                DischargeMethod::Held => DischargeRuleName::Controllers,
                DischargeMethod::Exported => DischargeRuleName::Exported,
            },
            turn: None,
            by: match met {
                DischargeMethod::Held => "all reachable states of the controllers".to_owned(),
                DischargeMethod::Exported => KEPT_BY_LINE.to_owned(),
            },
            formulas: vec![self.printer.named(at)],
        }
    }
}

/// Assumptions that are members of cycles.
fn members(proof: &Proof) -> Vec<FormulaRef> {
    let cycles = proof.cycles.iter();
    cycles.flat_map(|c| c.assumptions.iter().copied()).collect()
}

/// The closed composition as an entry of the JSON document, with the number of its states if they
/// were counted.
fn closed_entry(
    closed: &ClosedComposition<'_>,
    decided: &Result<Verdict, Limit>,
    states: Option<f64>,
) -> ClosedEntry {
    let components = closed.machine.components.iter().zip(&closed.participants);
    ClosedEntry {
        verdict: closed_verdict(decided),
        states: states.map(count),
        components: components
            .map(|(component, taking)| TakenEntry {
                name: component.name.clone(),
                form: taking.form,
            })
            .collect(),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count is not negative, and is computed from powers of two"
)]
fn count(states: f64) -> u64 {
    states.round() as u64
}

fn closed_verdict(decided: &Result<Verdict, Limit>) -> ClosedVerdict {
    match decided {
        Err(_) => ClosedVerdict::GaveUp,
        Ok(verdict) if verdict.is_broken() => ClosedVerdict::Broken,
        Ok(verdict) if !verdict.holds() => ClosedVerdict::Open,
        Ok(_) => ClosedVerdict::Holds,
    }
}

/// The claim that a machine keeps a contract that it is declared to refine.
struct Refinement<'a> {
    /// The contract, over the wires of the proof.
    contract: &'a RefinedContract,
    /// The contract, over the wires of all layers.
    flat: &'a RefinedContract,
    system: &'a System,
    claim: &'a Claim,
}

/// Reports on a contract that the machine is declared to refine. If the components' contracts do
/// not prove the refinement, the controllers are tried.
fn refines(
    controlled: &ControlledMachine<'_>,
    refinement: &Refinement<'_>,
    proof: Result<Proof, Limit>,
    prover: Prover<'_>,
    findings: &mut Vec<Diagnostic>,
) -> RefinesEntry {
    let machine = controlled.machine.abstraction();
    let refined_contract = refinement.contract;
    let printer = ProofPrinter {
        system: refinement.system,
        claim: refinement.claim,
        whole: &refined_contract.contract,
    };
    let mut refined = RefinesEntry {
        contract: refined_contract.contract.clone(),
        verdict: RefinementVerdict::Refined,
        closed: None,
        discharges: Vec::new(),
    };
    match proof {
        Ok(proof) if proof.holds() => {
            let entries = proof.discharges.iter();
            refined.discharges = entries.map(|d| discharge_entry(printer, d)).collect();
        }
        Ok(proof) => {
            let closed = ClosedComposition::of_refined_contract(
                controlled.machine,
                &controlled.controllers,
                refinement.flat,
            );
            let decided = prover.decide_closed(&closed);
            refined.closed = Some(closed_verdict(&decided));
            let both = CombinedProof {
                printer,
                span: refined_contract.span,
                machine,
                closed: &closed,
                verdict: decided.as_ref().ok().filter(|_| !is_layered(controlled)),
                walked: &Composition::default(),
            };
            cut_short(refined_contract.span, machine, &decided, findings);
            let mut found = Vec::new();
            refined.discharges = both.merged(proof, &mut found);
            if !found.is_empty() {
                refined.verdict = RefinementVerdict::Broken;
            }
            let label = "needed to refine this contract";
            let found = found.into_iter();
            findings.extend(found.map(|f| f.with_label(refined_contract.span, label)));
        }
        Err(limit) => {
            refined.verdict = RefinementVerdict::GaveUp;
            findings.push(undecided(refined_contract.span, &machine.name, limit));
        }
    }
    refined
}
