//! Refinement of a contract by another one, by a composition, or by any other expression.

use super::document::{self, Document, Semantics, Verdict};
use super::operand::{Operand, Operation};
use super::{Joined, Outcome, RefineArguments, bring_together, gave_up, tell};
use crate::algebra::contract::Contract as Sets;
use crate::algebra::decide::Decider;
use crate::algebra::join::Sharing;
use crate::algebra::proof::{Claim, Exports, prove};
use crate::algebra::refine::{Question, Refinement, refine};
use crate::algebra::system::{ContractSide, Part, System};
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
    let joined = match bring_together(
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
        (Operand::Contract { .. }, Operand::Contract { .. }) => single(&joined, options),
        (Operand::Contract { .. }, Operand::Result(Operation::Compose, inner))
            if inner.iter().all(|o| matches!(o, Operand::Contract { .. })) =>
        {
            composed(&joined, options)
        }
        _ => sets(&joined, options),
    };
    match outcome {
        Ok(outcome) => tell(outcome, &joined.loaded, options),
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
        pairs: document::pairs(&joined.system),
        proofs: BTreeMap::new(),
        counterexample: None,
        contracts: Vec::new(),
        findings: Vec::new(),
    }
}

/// One contract against another, formula by formula.
fn single(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let (old, new) = (0, 1);
    let refinement = refine(&joined.system, new, old, &options.limits())?;
    let names = [
        &joined.system.parts[old].name,
        &joined.system.parts[new].name,
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
        let printer = of_question(question, whole);
        let entry = document::proof(printer, &question.proof);
        outcome.document.proofs.insert(what, entry);
    }
    Ok(outcome)
}

/// Builds a question, with the owner of its goal's formulas.
pub fn of_question<'a>(question: &'a Question, whole: &'a str) -> ProofPrinter<'a> {
    ProofPrinter {
        system: &question.system,
        claim: &question.claim,
        whole,
    }
}

/// A refinement in words.
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
        let printer = of_question(question, whole);
        for open in &question.proof.open {
            let formula = printer.formula(open.what);
            let message = match what {
                "assumes more" => format!(
                    "`{new}` assumes `{}`, and `{old}` does not: an environment of `{old}` may break it",
                    formula.name
                ),
                _ => format!("`{new}` does not keep `{}` of `{old}`", formula.name),
            };
            let help = match what {
                "assumes more" => "drop the assumption, or weaken it to what was assumed before",
                _ => "guarantee it, too, or publish the change as one that is not compatible",
            };
            findings.push(
                Diagnostic::error(codes::PROMISE_BROKEN, at(Some(0)), message)
                    .with_label(
                        formula.span,
                        if what == "assumes more" {
                            "this is assumed"
                        } else {
                            "this was guaranteed"
                        },
                    )
                    .with_note(printer.shown(open))
                    .with_help(help),
            );
        }
    }
    if refinement.is_vacuous {
        let message = format!(
            "no environment keeps the assumptions of `{old}`, so every contract refines it"
        );
        findings.push(
            Diagnostic::warning(codes::ENVIRONMENT_EMPTY, at(None), message)
                .with_help("`check` names the assumptions; weaken them, and compare again"),
        );
    }
    let mut text = String::new();
    for (question, whole, what) in [
        (&refinement.assumptions, new, "assumes"),
        (&refinement.guarantees, old, "guarantees"),
    ] {
        if !question.proof.discharges.is_empty() {
            let _ = writeln!(text, "What `{whole}` {what} follows from:");
            text.push_str(&of_question(question, whole).rests(&question.proof.discharges, old));
        }
    }
    let _ = writeln!(
        text,
        "{}",
        if refinement.holds() {
            format!("`{new}` refines `{old}`: it can be used wherever that was used.")
        } else {
            format!("`{new}` does not refine `{old}`.")
        }
    );
    text.push_str("Semantics: inclusion of infinite runs.\n");
    (findings, text)
}

/// A contract against a composition: whether under its assumptions the parts discharge one
/// another's assumptions and keep its guarantees.
fn composed(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let (whole, parts) = joined.system.parts.split_first().expect("two operands");
    let mut system = System {
        variables: joined.system.variables.clone(),
        parts: parts.to_vec(),
    };
    // The definitions of the whole's monitors hold, whoever keeps them.
    if whole.definitions != Side::default() {
        system.parts.push(Part {
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
    let proof = prove(&system, &claim, &options.limits())?;
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
            "{}{} {verdict} `{}`.\n",
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
fn sets(joined: &Joined, options: &GlobalOptions) -> Result<Outcome, Limit> {
    let mut decider = Decider::new(&joined.system, &options.limits())?;
    let refutation = decider.refutation(&joined.sets[1], &joined.sets[0])?;
    let mut outcome = Outcome {
        document: document(joined, refutation.is_none(), Semantics::Runs),
        text: "Refined: whatever keeps the second keeps the first, in every environment of the first.\n".to_owned(),
        findings: Vec::new(),
    };
    if let Some((half, run)) = refutation {
        outcome.text = String::new();
        outcome.document.counterexample = Some(document::lasso(&joined.system, &run));
        outcome
            .findings
            .push(refuted(joined, half, &lasso_table(&joined.system, &run)));
    }
    Ok(outcome)
}

fn refuted(joined: &Joined, half: ContractSide, shown: &str) -> Diagnostic {
    let message = match half {
        ContractSide::Assumptions => {
            "it is not refined: an environment of the first may do this, and the second does not allow for it"
        }
        ContractSide::Guarantees => {
            "it is not refined: an implementation of the second may do this, and the first forbids it"
        }
    };
    Diagnostic::error(codes::PROMISE_BROKEN, joined.spans[0], message)
        .with_note(shown.to_owned())
        .with_help("add a guarantee that rules this run out, or promise less")
}

/// Whether one expression refines another, for claims that other commands prove along the way.
pub fn refutes(
    joined: &Joined,
    small: &Sets,
    large: &Sets,
    options: &GlobalOptions,
) -> Result<Option<crate::game::Lasso>, Limit> {
    let mut decider = Decider::new(&joined.system, &options.limits())?;
    Ok(decider.refutation(small, large)?.map(|(_, run)| run))
}
