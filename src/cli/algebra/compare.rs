//! `refine` of two folders: compares the contracts with the same name in two versions of a library.

use super::document::{self, ContractComparison, Document, LibraryChange, Semantics, Verdict};
use super::operand::Operand;
use super::refine::{explain, question_printer};
use super::{Common, Outcome, print_outcome};
use crate::algebra::join::{Member, Sharing, join};
use crate::algebra::refine::refine;
use crate::cli::console::schema;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::contract::Contract;
use crate::diagnostics::{Diagnostic, Severity, codes, has_errors};
use crate::engine::files::{self, LoadedFiles, StandardLibrary};
use crate::game::Limits;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// The path of an operand that is a folder on disk; such an operand stands for all contracts in the
/// folder. `None` for other operands.
pub fn library(operand: &Operand) -> Option<String> {
    match operand {
        Operand::Contract {
            name: None,
            selection,
        } if selection.name.is_none() && Path::new(&selection.path).is_dir() => {
            Some(selection.path.clone())
        }
        _ => None,
    }
}

/// Compares two folders.
pub fn run(
    old: &str,
    new: &str,
    common: &Common,
    options: &GlobalOptions,
) -> anyhow::Result<ExitCode> {
    if !common.rename.is_empty() {
        anyhow::bail!("--rename is for single contracts, and these are two libraries");
    }
    let standard = StandardLibrary::new(options.library.clone());
    let paths = [old.to_owned(), new.to_owned()];
    let loaded = files::load(&paths, &standard);
    if has_errors(&loaded.findings) {
        let sources = &loaded.library.sources;
        options
            .console()
            .failed("refine", sources, &loaded.findings)?;
        return Ok(options
            .exit_code(&loaded.findings)
            .and(ExitCode::of_loading(&loaded)));
    }
    let (before, after) = (contracts_in(&loaded, old), contracts_in(&loaded, new));
    let limits = options.limits();
    let mut outcome = Outcome {
        document: Document {
            schema: schema("refine"),
            verdict: Verdict::Refined,
            semantics: Semantics::Runs,
            pairs: Vec::new(),
            proofs: BTreeMap::new(),
            counterexample: None,
            contracts: Vec::new(),
            findings: Vec::new(),
        },
        text: String::new(),
        findings: Vec::new(),
    };
    let mut names: Vec<&String> = before.keys().chain(after.keys()).collect();
    names.sort();
    names.dedup();
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
    let mut gave_up = false;
    for name in names {
        let compared = match (before.get(name), after.get(name)) {
            (Some(old), Some(new)) => compare(name, old, new, &limits, &mut outcome.findings),
            (Some(old), None) => {
                outcome.findings.push(
                    Diagnostic::error(
                        codes::GUARANTEE_UNPROVED,
                        old.span,
                        format!("the contract `{name}` was removed"),
                    )
                    .with_help("keep it, or publish the change as incompatible"),
                );
                entry(name, LibraryChange::Removed)
            }
            _ => entry(name, LibraryChange::Added),
        };
        gave_up |= compared.verdict == LibraryChange::GaveUp;
        let word = compared.verdict.to_string().replace('_', " ");
        let _ = writeln!(outcome.text, "{name:<width$}  {word}");
        if matches!(
            compared.verdict,
            LibraryChange::Broken | LibraryChange::Removed
        ) {
            outcome.document.verdict = Verdict::Broken;
        }
        outcome.document.contracts.push(compared);
    }
    let code = print_outcome(outcome, &loaded, options)?;
    Ok(if gave_up {
        code.and(ExitCode::GaveUp)
    } else {
        code
    })
}

fn entry(name: &str, verdict: LibraryChange) -> ContractComparison {
    ContractComparison {
        name: name.to_owned(),
        verdict,
        open: Vec::new(),
    }
}

/// The contracts declared in the files of a folder, by name.
fn contracts_in<'a>(loaded: &'a LoadedFiles, folder: &str) -> BTreeMap<String, &'a Contract> {
    let sources = &loaded.library.sources;
    let inside = |c: &&Contract| Path::new(&sources.file(c.span.file).name).starts_with(folder);
    let own = loaded.library.contracts.iter().filter(inside);
    own.map(|c| (c.name.clone(), c)).collect()
}

/// Compares two versions of a contract.
fn compare(
    name: &str,
    old: &Contract,
    new: &Contract,
    limits: &Limits,
    findings: &mut Vec<Diagnostic>,
) -> ContractComparison {
    if is_unchanged(old, new) {
        return entry(name, LibraryChange::Same);
    }
    let (was, is) = (format!("{name} (old)"), format!("{name} (new)"));
    let members = [(old, &was), (new, &is)].map(|(contract, called)| Member {
        specification: &contract.specification,
        name: called.clone(),
        renamings: Vec::new(),
    });
    let system = match join(&members, Sharing::SeveralViews) {
        Ok(system) => system,
        Err(mismatches) => {
            findings.extend(mismatches.iter().map(crate::engine::found::of_mismatch));
            return entry(name, LibraryChange::Broken);
        }
    };
    match refine(&system, 1, 0, limits) {
        Err(limit) => {
            let mut finding = Diagnostic::error(
                codes::GAVE_UP,
                new.span,
                format!("could not decide whether `{name}` is refined: {limit}"),
            )
            .with_help(crate::engine::closed::limit_help(limit))
            .giving_up(limit.is_external());
            finding.severity = Severity::Warning;
            findings.push(finding);
            entry(name, LibraryChange::GaveUp)
        }
        Ok(refinement) => {
            let (found, _) = explain(&refinement, &was, &is, &|_| Some(new.span));
            findings.extend(found);
            let mut compared = entry(
                name,
                if refinement.holds() {
                    LibraryChange::Refined
                } else {
                    LibraryChange::Broken
                },
            );
            for (question, whole) in [
                (&refinement.assumptions, &is),
                (&refinement.guarantees, &was),
            ] {
                let printer = question_printer(question, whole);
                let open = question.proof.open.iter();
                compared
                    .open
                    .extend(open.map(|o| document::open(printer, o)));
            }
            compared
        }
    }
}

/// Whether two contracts have the same variables and formulas.
fn is_unchanged(old: &Contract, new: &Contract) -> bool {
    let (a, b) = (&old.specification, &new.specification);
    let variables = |s: &crate::gr1::Specification| -> Vec<_> {
        let all = s.variables.iter();
        all.map(|v| {
            (
                v.name.clone(),
                v.owner,
                v.internal,
                v.domain.clone(),
                v.unit.clone(),
            )
        })
        .collect()
    };
    let formulas = |side: &crate::gr1::Side| -> Vec<_> {
        side.formulas()
            .map(|(kind, _, f)| (kind, f.expr.clone()))
            .collect()
    };
    a.timing == b.timing
        && variables(a) == variables(b)
        && formulas(&a.assumptions) == formulas(&b.assumptions)
        && formulas(&a.guarantees) == formulas(&b.guarantees)
}
