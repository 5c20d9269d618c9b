//! `compose`, with its discharge table and the controller of all parts, and `compat`.

use super::document::{self, Document, Semantics, Verdict};
use super::{
    CompatArguments, ComposeArguments, Joined, Outcome, gave_up, load_joined, print_outcome,
};
use crate::algebra::compat::{Compatibility, compatible};
use crate::algebra::join::Sharing;
use crate::algebra::proof::{Claim, Exports, Proof, Refutation, prove};
use crate::algebra::system::System;
use crate::cli::console::schema;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::findings;
use crate::engine::found;
use crate::engine::pipeline::Jobs;
use crate::engine::words::ProofPrinter;
use crate::gr1::{FormulaKind, Owner, Side, Specification, Time, Timing, VarId, Variable};
use crate::mealy;
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::sync::Arc;

/// Runs `compose`.
pub fn run(arguments: &ComposeArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let operands: Vec<_> = arguments.contracts.iter().collect();
    let common = &arguments.common;
    let joined = match load_joined("compose", &operands, common, Sharing::OneDriver, options)? {
        Ok(joined) => joined,
        Err(code) => return Ok(code),
    };
    let claim = Claim {
        exports: Exports::Always,
        ..Claim::default()
    };
    let proof = match prove(&joined.system, &claim, &options.limits()) {
        Ok(proof) => proof,
        Err(limit) => return gave_up(limit, "compose", &joined.loaded, options),
    };
    let printer = ProofPrinter {
        system: &joined.system,
        claim: &claim,
        whole: "",
    };
    let findings = found::of_proof(printer, &proof, &|part| part.map(|p| joined.spans[p]));
    if arguments.synth && proof.holds() {
        return synth(&joined, printer, &proof, options);
    }
    let outcome = Outcome {
        text: text(printer, &proof, arguments.synth),
        document: Document {
            schema: schema("compose"),
            verdict: if proof.holds() {
                Verdict::Composed
            } else {
                Verdict::Open
            },
            semantics: Semantics::Strict,
            pairs: document::contract_texts(&joined.system),
            proofs: BTreeMap::from([("proof", document::proof(printer, &proof))]),
            counterexample: None,
            contracts: Vec::new(),
            findings: Vec::new(),
        },
        findings,
    };
    print_outcome(outcome, &joined.loaded, options)
}

/// Semantics of proofs that components discharge one another's assumptions.
pub const STRICT: &str = "Semantics: strict, step by step: a component keeps its guarantees as long as its assumptions have been kept.\n";

/// Formats the discharge table, and the verdict as a sentence.
fn text(printer: ProofPrinter<'_>, proof: &Proof, synth: bool) -> String {
    let names: Vec<&str> = printer
        .system
        .components
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    let mut text = format!("{}\n", names.join(" ⊗ "));
    if !proof.discharges.is_empty() {
        text.push_str(&printer.table(&proof.discharges));
    }
    let exported = printer.exported(proof);
    if proof.holds() {
        let what = match exported.len() {
            0 => "there are no assumptions about the environment".to_owned(),
            1 => "one assumption remains, about the environment".to_owned(),
            n => format!("{n} assumptions remain, about the environment"),
        };
        let _ = writeln!(text, "All assumptions are discharged; {what}.");
        text.push_str(STRICT);
    } else {
        let open = proof.open.len();
        let _ = writeln!(
            text,
            "{}{}{}",
            match open {
                0 => "Not composed".to_owned(),
                1 => "1 assumption is not discharged".to_owned(),
                n => format!("{n} assumptions are not discharged"),
            },
            match proof.cycles.len() {
                0 => String::new(),
                1 => "; 1 cycle".to_owned(),
                n => format!("; {n} cycles"),
            },
            if synth {
                ": the composition has no GR(1) contract, so nothing is synthesized."
            } else {
                "."
            }
        );
    }
    text
}

/// The contract of the composition, for a proof without open assumptions. Its assumptions are those
/// that the proof passes on.
fn composition_contract(printer: ProofPrinter<'_>, proof: &Proof) -> Specification {
    let system = printer.system;
    let mut assumptions = Side::default();
    for at in printer.exported(proof) {
        let formula = printer.formula(at).clone();
        let Some(part) = at.component else { continue };
        debug_assert!(
            system.components[part]
                .assumptions
                .list(at.kind)
                .contains(&formula)
        );
        assumptions.list_mut(at.kind).push(formula);
    }
    let mut guarantees = Side::default();
    for side in system
        .components
        .iter()
        .flat_map(|p| [&p.guarantees, &p.definitions])
    {
        guarantees.append(side);
    }
    let variables = system.variables.iter().enumerate().map(|(i, v)| Variable {
        owner: match system.driver(VarId(i as u32)) {
            Some(_) => Owner::System,
            None => Owner::Environment,
        },
        ..v.clone()
    });
    let names: Vec<&str> = system.components.iter().map(|p| p.name.as_str()).collect();
    Specification {
        name: names.join("_"),
        timing: if system.components.iter().all(|p| p.timing == Timing::Moore) {
            Timing::Moore
        } else {
            Timing::Mealy
        },
        variables: variables.collect(),
        assumptions,
        guarantees,
    }
}

/// Findings about assumptions that are passed on although they constrain variables that the
/// environment does not set. The GR(1) contract of the composition cannot have them, since its
/// environment sets the inputs of a step before it sees the outputs (the rule of
/// [`Specification::assumptions`]).
fn uncontrolled_assumptions(printer: ProofPrinter<'_>, proof: &Proof) -> Vec<Diagnostic> {
    let system = printer.system;
    let mut findings = Vec::new();
    for at in printer.exported(proof) {
        let constrained = match at.kind {
            FormulaKind::Initial | FormulaKind::Invariant => Time::Now,
            FormulaKind::Safety => Time::Next,
            FormulaKind::Justice => continue,
        };
        let formula = printer.formula(at);
        let mut chosen: BTreeMap<VarId, usize> = BTreeMap::new();
        formula.expr.for_each_var(&mut |v, time| {
            if time == constrained {
                chosen.extend(system.driver(v).map(|part| (v, part)));
            }
        });
        if chosen.is_empty() {
            continue;
        }
        let variables = chosen.keys().map(|v| &system.variables[v.index()].name);
        let variables = quoted_list(variables.map(String::as_str));
        let parts: BTreeSet<usize> = chosen.into_values().collect();
        let parts = quoted_list(parts.iter().map(|p| system.components[*p].name.as_str()));
        findings.push(
            Diagnostic::error(
                codes::NOT_CONTROLLED,
                formula.span,
                format!(
                    "`{}` of `{}` remains an assumption about the environment, but constrains {variables}, which {parts} sets in the same step: the composition has no GR(1) contract, so nothing is synthesized",
                    formula.name,
                    printer.owner(at),
                ),
            )
            .with_help(format!(
                "let {parts} guarantee what is assumed about {variables}, or let the assumption mention the values of the previous step"
            )),
        );
    }
    findings
}

/// Formats a list of names in backticks.
fn quoted_list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    findings::list(&quoted)
}

/// Synthesizes a controller of the composition, and prints it.
fn synth(
    joined: &Joined,
    printer: ProofPrinter<'_>,
    proof: &Proof,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let uncontrolled = uncontrolled_assumptions(printer, proof);
    if !uncontrolled.is_empty() {
        console.failed("compose", &joined.loaded.library.sources, &uncontrolled)?;
        return Ok(options.exit_code(&uncontrolled));
    }
    let specification = Arc::new(composition_contract(printer, proof));
    let span = joined.spans[0];
    let mut jobs = Jobs::examining();
    let job = jobs.add(&specification, span);
    let checked = jobs.run(&options.settings(), &console.progress(1, "synthesizing"));
    let checked = &checked[job];
    let findings = checked.findings_where_needed();
    let sources = &joined.loaded.library.sources;
    match &checked.controller {
        Some(mealy::Controller::Machine(machine)) => {
            let document = mealy::json::to_json(machine, true);
            console.result(&mealy::json::to_text(&document))?;
        }
        Some(mealy::Controller::Functions(functions)) => {
            console.result(&mealy::json::to_text(&functions.to_json(true)))?;
        }
        None => {
            console.failed("compose", sources, &findings)?;
            return Ok(options.exit_code(&findings));
        }
    }
    console.findings(sources, &findings)?;
    Ok(options.exit_code(&findings))
}

/// Runs `compat`.
pub fn compat(arguments: &CompatArguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let operands: Vec<_> = arguments.contracts.iter().collect();
    let common = &arguments.common;
    let joined = match load_joined("compat", &operands, common, Sharing::OneDriver, options)? {
        Ok(joined) => joined,
        Err(code) => return Ok(code),
    };
    let answer = match compatible(&joined.system, &options.limits()) {
        Ok(answer) => answer,
        Err(limit) => return gave_up(limit, "compat", &joined.loaded, options),
    };
    let names: Vec<String> = joined
        .system
        .components
        .iter()
        .map(|p| p.name.clone())
        .collect();
    let together = findings::list(&names);
    let mut outcome = Outcome {
        document: Document {
            schema: schema("compat"),
            verdict: Verdict::Compatible,
            semantics: Semantics::Strict,
            pairs: document::contract_texts(&joined.system),
            proofs: BTreeMap::new(),
            counterexample: None,
            contracts: Vec::new(),
            findings: Vec::new(),
        },
        text: format!(
            "{together}: some environment can keep {} assumptions, whatever happens within the guarantees.\n",
            if names.len() == 1 { "its" } else { "their" }
        ),
        findings: Vec::new(),
    };
    if let Compatibility::Incompatible { assumptions, play } = answer {
        outcome.document.verdict = Verdict::Incompatible;
        outcome.text = String::new();
        let described = assumptions.iter().map(|a| match &names[..] {
            [_] => format!("`{}`", a.name),
            _ => format!("`{}` of {}", a.name, names[a.component]),
        });
        let mut spans = assumptions.iter().map(|a| a.span);
        let span = spans.find(|span| *span != Span::default());
        let mut finding = Diagnostic::error(
            codes::INCOMPATIBLE,
            span.unwrap_or(joined.spans[0]),
            format!(
                "no environment can keep what {together} assume{}: {} {}, whatever the environment does",
                if names.len() == 1 { "s" } else { "" },
                findings::list(&described.collect::<Vec<_>>()),
                if assumptions.len() == 1 {
                    "can be broken"
                } else {
                    "cannot be kept together"
                },
            ),
        );
        match &play {
            Some(Refutation::Trace(steps)) => {
                outcome.document.counterexample = Some(document::trace(&joined.system, steps));
                let shown = shown(&joined.system, steps);
                let last = steps.len() - 1;
                finding = finding.with_note(format!(
                    "{shown}in step {last} no inputs from the environment keep the assumptions"
                ));
            }
            Some(Refutation::Lasso(run)) => {
                outcome.document.counterexample = Some(document::lasso(&joined.system, run));
                finding = finding.with_note(crate::engine::words::lasso_table(&joined.system, run));
            }
            None => {}
        }
        outcome.findings.push(finding.with_help(
            "weaken the assumption to what the environment controls, or let a contract guarantee the rest",
        ));
    }
    print_outcome(outcome, &joined.loaded, options)
}

fn shown(system: &System, steps: &[Vec<i64>]) -> String {
    let all: Vec<VarId> = (0..system.variables.len() as u32)
        .map(VarId)
        .filter(|v| !system.variables[v.index()].internal)
        .collect();
    crate::engine::words::steps_table(system, &all, steps)
}
