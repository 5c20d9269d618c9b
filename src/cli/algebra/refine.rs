//! Refinement of a contract by another one, by a composition, or by any other expression.

use super::compose::STRICT;
use super::document::{self, Document, Semantics, Verdict};
use super::operand::{Operand, Operation};
use super::{Joined, Outcome, RefineArguments, gave_up, load_joined, print_outcome};
use crate::algebra::contract::Contract as Sets;
use crate::algebra::decide::Decider;
use crate::algebra::join::Sharing;
use crate::algebra::proof::{Claim, Exports, prove_stepwise};
use crate::algebra::refine::{Question, Refinement, lacks_environment, refine};
use crate::algebra::system::{Component, ContractSide, System};
use crate::cli::console::schema;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::found;
use crate::engine::words::{ProofPrinter, lasso_table};
use crate::game::Limit;
use crate::gr1::Side;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Runs `refine` on two operands.
pub fn run(arguments: &RefineArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let operands = [&arguments.old, &arguments.new];
    let joined = match load_joined(
        "refine",
        &operands,
        &arguments.common,
        Sharing::SeveralViews,
        options,
    )? {
        Ok(joined) => joined,
        Err(code) => return Ok(code),
    };
    let outcome = match (&arguments.old, &arguments.new) {
        (Operand::Contract { .. }, Operand::Contract { .. }) => refine_contract(&joined, options),
        (Operand::Contract { .. }, Operand::Result(Operation::Compose, inner))
            if inner.iter().all(|o| matches!(o, Operand::Contract { .. })) =>
        {
            refine_by_composition(&joined, options)
        }
        _ => refine_expression(&joined, options),
    };
    match outcome {
        Ok(outcome) => print_outcome(outcome, &joined.loaded, options),
        Err(limit) => gave_up(limit, "refine", &joined.loaded, options),
    }
}

fn document(joined: &Joined, holds: bool, semantics: Semantics) -> Document {
    Document {
        schema: schema("refine"),
        verdict: if holds {
            Verdict::Refined
        } else {
            Verdict::Broken
        },
        semantics,
        pairs: document::contract_texts(&joined.system),
        proofs: BTreeMap::new(),
        counterexample: None,
        contracts: Vec::new(),
        findings: Vec::new(),
    }
}

/// Compares two contracts formula by formula.
fn refine_contract(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let (old, new) = (0, 1);
    let refinement = refine(&joined.system, new, old, &options.limits())?;
    let names = [
        &joined.system.components[old].name,
        &joined.system.components[new].name,
    ];
    let mut outcome = Outcome {
        document: document(joined, refinement.holds(), Semantics::Runs),
        text: String::new(),
        findings: Vec::new(),
    };
    let (findings, text) = explain(&refinement, names[0], names[1], &|part| {
        Some(joined.spans[part.map_or(old, |_| new)])
    });
    outcome.findings = findings;
    outcome.text = text;
    let entries = [
        ("assumptions", &refinement.assumptions, names[1]),
        ("guarantees", &refinement.guarantees, names[0]),
    ];
    for (what, question, whole) in entries {
        let printer = question_printer(question, whole);
        let entry = document::proof(printer, &question.proof);
        outcome.document.proofs.insert(what, entry);
    }
    Ok(outcome)
}

/// Creates a printer for the proof of a question; `whole` is the name of the contract whose
/// formulas are the goal.
pub fn question_printer<'a>(question: &'a Question, whole: &'a str) -> ProofPrinter<'a> {
    ProofPrinter {
        system: &question.system,
        claim: &question.claim,
        whole,
    }
}

/// Findings about a refinement, and its text. `at` maps the index of a part to its place in the
/// text.
pub fn explain(
    refinement: &Refinement,
    old: &str,
    new: &str,
    at: &dyn Fn(Option<usize>) -> Option<crate::source::Span>,
) -> (Vec<Diagnostic>, String) {
    let mut findings = Vec::new();
    for (question, whole, what) in [
        (&refinement.assumptions, new, "assumes more"),
        (&refinement.guarantees, old, "guarantees less"),
    ] {
        let printer = question_printer(question, whole);
        for open in &question.proof.open {
            let formula = printer.formula(open.what);
            let message = match what {
                "assumes more" => format!(
                    "`{new}` assumes `{}`, and `{old}` does not: an environment of `{old}` can break it",
                    formula.name
                ),
                _ => format!("`{new}` does not keep `{}` of `{old}`", formula.name),
            };
            let help = match what {
                "assumes more" => {
                    "remove the assumption, or weaken it to what the old contract assumes"
                }
                _ => "guarantee it as well, or publish the change as incompatible",
            };
            findings.push(
                Diagnostic::error(codes::GUARANTEE_UNPROVED, at(Some(0)), message)
                    .with_label(
                        formula.span,
                        if what == "assumes more" {
                            "this is assumed"
                        } else {
                            "guaranteed here"
                        },
                    )
                    .with_note(printer.counterexample(open))
                    .with_help(help),
            );
        }
    }
    if refinement.is_vacuous {
        findings.push(vacuous(&format!("`{old}`"), at(None)));
    }
    let mut text = String::new();
    for (question, whole, what) in [
        (&refinement.assumptions, new, "assumes"),
        (&refinement.guarantees, old, "guarantees"),
    ] {
        if !question.proof.discharges.is_empty() {
            let _ = writeln!(text, "What `{whole}` {what} follows from:");
            text.push_str(
                &question_printer(question, whole)
                    .refinement_table(&question.proof.discharges, old),
            );
        }
    }
    let _ = writeln!(
        text,
        "{}",
        if refinement.holds() {
            format!("`{new}` refines `{old}`: it can be used wherever `{old}` was used.")
        } else {
            format!("`{new}` does not refine `{old}`.")
        }
    );
    text.push_str(RUNS);
    (findings, text)
}

/// Semantics of comparisons of contracts as pairs of sets of runs.
pub const RUNS: &str = "Semantics: inclusion of infinite runs.\n";

/// The finding that a comparison with `old` says nothing.
fn vacuous(old: &str, at: Option<crate::source::Span>) -> Diagnostic {
    Diagnostic::warning(
        codes::ENVIRONMENT_EMPTY,
        at,
        format!("no environment keeps the assumptions of {old}, so every contract refines it"),
    )
    .with_help("`check` names the contradictory assumptions; weaken them, and compare again")
}

/// Compares a contract with a composition: under the assumptions of the contract, the parts have to
/// discharge each other's assumptions, and to keep the contract's guarantees.
fn refine_by_composition(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let (whole, parts) = joined
        .system
        .components
        .split_first()
        .expect("two operands");
    if lacks_environment(&joined.system, 0, &options.limits())? {
        return Ok(Outcome {
            document: document(joined, true, Semantics::Runs),
            text: format!("Every contract refines `{}`.\n{RUNS}", whole.name),
            findings: vec![vacuous(&format!("`{}`", whole.name), Some(joined.spans[0]))],
        });
    }
    let mut system = System {
        variables: joined.system.variables.clone(),
        components: parts.to_vec(),
    };
    // The definitions of the contract's monitors hold in any case.
    if whole.definitions != Side::default() {
        system.components.push(Component {
            assumptions: Side::default(),
            guarantees: Side::default(),
            drives: whole
                .drives
                .iter()
                .copied()
                .filter(|v| !parts.iter().any(|p| p.drives.contains(v)))
                .collect(),
            timing: crate::gr1::Timing::Moore,
            ..whole.clone()
        });
    }
    let claim = Claim {
        given: whole.assumptions.clone(),
        goal: whole.guarantees.clone(),
        exports: Exports::Never,
        ..Claim::default()
    };
    let proof = prove_stepwise(&system, &claim, &options.limits())?;
    let printer = ProofPrinter {
        system: &system,
        claim: &claim,
        whole: &whole.name,
    };
    let names: Vec<&str> = parts.iter().map(|p| p.name.as_str()).collect();
    let findings = found::of_proof(printer, &proof, &|part| {
        Some(joined.spans[part.map_or(0, |p| p + 1)])
    });
    let verdict = if proof.holds() {
        "refines"
    } else {
        "does not refine"
    };
    let mut outcome = Outcome {
        document: document(joined, proof.holds(), Semantics::Strict),
        text: format!(
            "{}{} {verdict} `{}`.\n{STRICT}",
            printer.table(&proof.discharges),
            names.join(" ⊗ "),
            whole.name
        ),
        findings,
    };
    let entry = document::proof(printer, &proof);
    outcome.document.proofs.insert("proof", entry);
    Ok(outcome)
}

/// Compares two arbitrary expressions as sets of runs.
fn refine_expression(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let mut decider = Decider::new(&joined.system, &options.limits())?;
    let refutation = decider.refutation(&joined.sets[1], &joined.sets[0])?;
    let mut outcome = Outcome {
        document: document(joined, refutation.is_none(), Semantics::Runs),
        text: format!(
            "Refined: in every environment of OLD, every component that satisfies NEW also satisfies OLD.\n{RUNS}"
        ),
        findings: Vec::new(),
    };
    if refutation.is_none() && decider.find(&joined.sets[0].assumption)?.is_none() {
        outcome.findings.push(vacuous("OLD", Some(joined.spans[0])));
    }
    if let Some((half, run)) = refutation {
        RUNS.clone_into(&mut outcome.text);
        outcome.document.counterexample = Some(document::lasso(&joined.system, &run));
        outcome
            .findings
            .push(refuted(joined, half, &lasso_table(&joined.system, &run)));
    }
    Ok(outcome)
}

fn refuted(joined: &Joined, half: ContractSide, shown: &str) -> Diagnostic {
    let (message, help) = match half {
        ContractSide::Assumptions => (
            "not refined: an environment of OLD can do this, but NEW assumes that it does not",
            "weaken the assumptions of NEW so that they allow this run, or add an assumption to OLD that excludes it",
        ),
        ContractSide::Guarantees | ContractSide::Completions => (
            "not refined: an implementation of NEW can do this, but OLD forbids it",
            "add a guarantee to NEW that excludes this run, or weaken the guarantees of OLD",
        ),
    };
    Diagnostic::error(codes::GUARANTEE_UNPROVED, joined.spans[0], message)
        .with_note(shown.to_owned())
        .with_help(help)
}

/// Returns a run that shows that `small` does not refine `large`; `None` if it does refine it.
pub fn refutation(
    joined: &Joined,
    small: &Sets,
    large: &Sets,
    options: &GlobalOptions,
) -> Result<Option<crate::game::Lasso>, Limit> {
    let mut decider = Decider::new(&joined.system, &options.limits())?;
    Ok(decider.refutation(small, large)?.map(|(_, run)| run))
}
