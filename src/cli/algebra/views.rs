//! Conjunction, quotient and merging: results that generally leave GR(1), and are kept as
//! expressions.

use super::document::{self, Document, Semantics, Verdict};
use super::operand::{Operand, Operation};
use super::{Common, Joined, Outcome, bring_together, gave_up, refine, tell};
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

/// Runs one of the three.
pub fn run(
    operation: Operation,
    operands: &[&Operand],
    common: &Common,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let word = operation.word();
    let joined = match bring_together(word, operands, common, Sharing::SeveralViews, options)? {
        Ok(joined) => joined,
        Err(code) => return Ok(code),
    };
    match outcome(operation, &joined, options) {
        Ok(outcome) => tell(outcome, &joined.loaded, options),
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
        .expect("at least two operands were parsed; please report this");
    let mut outcome = Outcome {
        document: Document {
            schema: schema(operation.word()),
            verdict: Verdict::Proved,
            semantics: Semantics::Runs,
            pairs: document::pairs(&joined.system),
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
        match refine::refutes(joined, &small, &large, options)? {
            None => {
                let _ = writeln!(outcome.text, "Proved: {sentence}.");
            }
            Some(run) => {
                outcome.document.verdict = Verdict::Refuted;
                outcome.document.counterexample = Some(document::lasso(&joined.system, &run));
                let message = format!("it is not so that {sentence}");
                outcome.findings.push(
                    Diagnostic::error(codes::PROMISE_BROKEN, joined.spans[0], message)
                        .with_note(lasso_table(&joined.system, &run))
                        .with_help("this is a law of the algebra: please report it"),
                );
            }
        }
    }
    Ok(outcome)
}

/// Proves the laws that define a result: a sentence, and which contract refines which.
fn claims(operation: Operation, joined: &Joined, result: &Sets) -> Vec<(String, Sets, Sets)> {
    let names: Vec<&str> = joined
        .system
        .parts
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

/// The result as a list of pairs with the operation that combines them.
fn text(operation: Operation, joined: &Joined) -> String {
    let mut text = String::new();
    for pair in document::pairs(&joined.system) {
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
            "The conjunction: an environment of any of them will do, and each guarantee holds where its own assumptions do."
        }
        Operation::Merge => {
            "The merging: an environment keeps all assumptions, and then all guarantees hold."
        }
        Operation::Quotient => {
            "The quotient: what is missing may rely on what the whole assumes and what is there guarantees; it has to keep what the whole guarantees, and what is there assumes."
        }
        Operation::Compose => "",
    };
    let _ = writeln!(text, "{sentence}");
    text
}
