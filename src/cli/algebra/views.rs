//! `conjoin`, `quotient` and `merge`, whose results are generally outside GR(1), and are
//! represented as expressions.

use super::document::{self, Document, Semantics, Verdict};
use super::operand::{Operand, Operation};
use super::{Common, Joined, Outcome, gave_up, load_joined, print_outcome, refine};
use crate::algebra::contract::Contract as Sets;
use crate::algebra::join::Sharing;
use crate::cli::console::schema;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::words::lasso_table;
use crate::game::Limit;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Runs one of the three commands.
pub fn run(
    operation: Operation,
    operands: &[&Operand],
    common: &Common,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let word = operation.word();
    let joined = match load_joined(word, operands, common, Sharing::SeveralViews, options)? {
        Ok(joined) => joined,
        Err(code) => return Ok(code),
    };
    match outcome(operation, &joined, options) {
        Ok(outcome) => print_outcome(outcome, &joined.loaded, options),
        Err(limit) => gave_up(limit, word, &joined.loaded, options),
    }
}

fn outcome(
    operation: Operation,
    joined: &Joined,
    options: &GlobalOptions,
) -> Result<Outcome, Limit> {
    let result = operation
        .fold(joined.sets.clone())
        .expect("fewer than two operands were parsed; please report this");
    let mut outcome = Outcome {
        document: Document {
            schema: schema(operation.word()),
            verdict: Verdict::Proved,
            semantics: Semantics::Runs,
            pairs: document::contract_texts(&joined.system),
            proofs: BTreeMap::new(),
            counterexample: None,
            contracts: Vec::new(),
            findings: Vec::new(),
        },
        text: text(operation, joined),
        findings: Vec::new(),
    };
    let claims = claims(operation, joined, &result);
    for (sentence, small, large) in claims {
        match refine::refutation(joined, &small, &large, options)? {
            None => {
                let _ = writeln!(outcome.text, "Proved: {sentence}.");
            }
            Some(run) => {
                outcome.document.verdict = Verdict::Refuted;
                outcome.document.counterexample = Some(document::lasso(&joined.system, &run));
                let message = format!("this does not hold: {sentence}");
                outcome.findings.push(
                    Diagnostic::error(codes::GUARANTEE_UNPROVED, joined.spans[0], message)
                        .with_note(lasso_table(&joined.system, &run))
                        .with_help("this is a law of the contract algebra: please report it"),
                );
            }
        }
    }
    outcome.text.push_str(refine::RUNS);
    Ok(outcome)
}

/// The laws that define a result, each as a sentence and two contracts, of which the first refines
/// the second.
fn claims(operation: Operation, joined: &Joined, result: &Sets) -> Vec<(String, Sets, Sets)> {
    let names: Vec<&str> = joined
        .system
        .components
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    let plain = joined.sets.len() == names.len();
    let name = |i: usize| {
        if plain {
            format!("`{}`", names[i])
        } else {
            format!("operand {}", i + 1)
        }
    };
    match operation {
        Operation::Quotient => vec![(
            format!("composed with {} it refines {}", name(1), name(0)),
            joined.sets[1].compose(result),
            joined.sets[0].clone(),
        )],
        Operation::Conjoin => joined
            .sets
            .iter()
            .enumerate()
            .map(|(i, set)| {
                (
                    format!("it refines {}", name(i)),
                    result.clone(),
                    set.clone(),
                )
            })
            .collect(),
        Operation::Compose | Operation::Merge => Vec::new(),
    }
}

/// Formats the result: the contracts, and a sentence about the operation that combines them.
fn text(operation: Operation, joined: &Joined) -> String {
    let mut text = String::new();
    for pair in document::contract_texts(&joined.system) {
        let _ = writeln!(text, "{}", pair.name);
        for (word, list) in [
            ("assume", &pair.assumptions),
            ("guarantee", &pair.guarantees),
        ] {
            for formula in list {
                let _ = writeln!(text, "  {word} {}: {}", formula.name, formula.text);
            }
        }
    }
    let sentence = match operation {
        Operation::Conjoin => {
            "The conjunction: the environment has to keep the assumptions of at least one contract, and each guarantee holds wherever the assumptions of its contract hold."
        }
        Operation::Merge => {
            "The merge: if the environment keeps all assumptions, all guarantees hold."
        }
        Operation::Quotient => {
            "The quotient: the missing component can assume what the whole assumes and what the existing component guarantees; it has to guarantee what the whole guarantees and what the existing component assumes."
        }
        Operation::Compose => "",
    };
    let _ = writeln!(text, "{sentence}");
    text
}
