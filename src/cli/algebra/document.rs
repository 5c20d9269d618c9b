//! What the commands of the algebra print as JSON.

use crate::algebra::proof::{Broken, Discharge, Discharged, Open, Proof};
use crate::algebra::system::{FormulaRef, System, formulas};
use crate::diagnostics::json;
use crate::engine::words::{self, Told};
use crate::game::Lasso;
use serde::Serialize;
use std::collections::BTreeMap;

/// Points at a formula.
#[derive(Debug, Serialize)]
pub struct Named {
    /// The contract or component it belongs to.
    pub of: String,
    /// Its name there.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// How an obligation is met.
#[derive(Debug, Serialize)]
pub struct DischargeEntry {
    /// What.
    #[serde(flatten)]
    pub what: Named,
    /// `environment`, `exported`, `induction` or `justice`.
    pub rule: &'static str,
    /// Of justice: the turn, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn: Option<usize>,
    /// On what it rests.
    pub by: Vec<Named>,
}

/// An obligation that is not met.
#[derive(Debug, Serialize)]
pub struct OpenEntry {
    /// What.
    #[serde(flatten)]
    pub what: Named,
    /// Why.
    pub reason: String,
    /// How it is broken.
    pub counterexample: Counterexample,
}

/// A counterexample, with a value for every variable by its name.
#[derive(Debug, Serialize)]
pub struct Counterexample {
    /// `trace`, whose last step breaks something, or `lasso`.
    pub kind: &'static str,
    /// The steps.
    pub steps: Vec<BTreeMap<String, String>>,
    /// Of a lasso: the step with which it goes on after the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<usize>,
}

/// A proof.
#[derive(Debug, Serialize)]
pub struct ProofEntry {
    /// What is met.
    pub discharges: Vec<DischargeEntry>,
    /// What is not.
    pub open: Vec<OpenEntry>,
    /// Justice assumptions that wait for one another.
    pub circles: Vec<Vec<Named>>,
    /// Variables that wait for one another within a step.
    pub loops: Vec<Vec<String>>,
}

/// One contract among those that a result is made of.
#[derive(Debug, Serialize)]
pub struct Pair {
    /// What it is called.
    pub name: String,
    /// What it assumes.
    pub assumptions: Vec<Text>,
    /// What it guarantees.
    pub guarantees: Vec<Text>,
}

/// A formula as it was written.
#[derive(Debug, Serialize)]
pub struct Text {
    /// Its name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// The document of a command.
#[derive(Debug, Serialize)]
pub struct Document {
    /// Which command's.
    pub schema: String,
    /// What came out, in a word.
    pub verdict: &'static str,
    /// Which semantics it was decided in: `strict` (safety first, step by step) or `runs` (inclusion of infinite runs).
    pub semantics: &'static str,
    /// The contracts it is about.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<Pair>,
    /// Proofs, by what they show.
    #[serde(flatten)]
    pub proofs: BTreeMap<&'static str, ProofEntry>,
    /// A run or play that shows why not, where it belongs to no single formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<Counterexample>,
    /// Contract by contract, of two libraries.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contracts: Vec<Compared>,
    /// All findings.
    pub findings: Vec<json::Finding>,
}

/// What became of a contract from one library to the other.
#[derive(Debug, Serialize)]
pub struct Compared {
    /// Its name.
    pub name: String,
    /// `same`, `refined`, `broken`, `added`, `removed` or `gave_up`.
    pub verdict: &'static str,
    /// What is not kept any more.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<OpenEntry>,
}

/// A formula by name.
pub fn named(told: Told<'_>, at: FormulaRef) -> Named {
    let formula = told.formula(at);
    Named {
        of: told.owner(at).to_owned(),
        name: formula.name.clone(),
        text: formula.text.clone(),
    }
}

/// A proof for other programs.
pub fn proof(told: Told<'_>, proof: &Proof) -> ProofEntry {
    ProofEntry {
        discharges: proof
            .discharges
            .iter()
            .map(|d| discharge(told, d))
            .collect(),
        open: proof.open.iter().map(|o| open(told, o)).collect(),
        circles: proof
            .circles
            .iter()
            .map(|c| c.assumptions.iter().map(|at| named(told, *at)).collect())
            .collect(),
        loops: proof
            .loops
            .iter()
            .map(|l| {
                let names = l.variables.iter();
                names
                    .map(|v| told.system.variables[v.index()].name.clone())
                    .collect()
            })
            .collect(),
    }
}

fn discharge(told: Told<'_>, discharge: &Discharge) -> DischargeEntry {
    DischargeEntry {
        what: named(told, discharge.what),
        rule: words::rule(discharge.rule),
        turn: match discharge.rule {
            Discharged::Justice { turn } => Some(turn + 1),
            _ => None,
        },
        by: discharge.by.iter().map(|at| named(told, *at)).collect(),
    }
}

/// An open obligation for other programs.
pub fn open(told: Told<'_>, open: &Open) -> OpenEntry {
    OpenEntry {
        what: named(told, open.what),
        reason: told.reason(open),
        counterexample: match &open.why {
            Broken::Trace(steps) => trace(told.system, steps),
            Broken::Lasso(run) => lasso(told.system, run),
        },
    }
}

/// A finite run.
pub fn trace(system: &System, steps: &[Vec<i64>]) -> Counterexample {
    Counterexample {
        kind: "trace",
        steps: steps.iter().map(|s| values(system, s)).collect(),
        from: None,
    }
}

/// An infinite run.
pub fn lasso(system: &System, run: &Lasso) -> Counterexample {
    let steps = run.prefix.iter().chain(&run.cycle);
    Counterexample {
        kind: "lasso",
        steps: steps.map(|s| values(system, s)).collect(),
        from: Some(run.prefix.len()),
    }
}

fn values(system: &System, step: &[i64]) -> BTreeMap<String, String> {
    let variables = system.variables.iter().zip(step);
    variables
        .filter(|(v, _)| !v.internal)
        .map(|(v, value)| (v.name.clone(), v.domain.show(*value)))
        .collect()
}

/// The contracts of a system, as they were written.
pub fn pairs(system: &System) -> Vec<Pair> {
    let texts = |side| {
        let mut texts: Vec<Text> = Vec::new();
        for (_, _, formula) in formulas(side) {
            let known = texts
                .iter()
                .any(|t| t.name == formula.name && t.text == formula.text);
            if !known {
                texts.push(Text {
                    name: formula.name.clone(),
                    text: formula.text.clone(),
                });
            }
        }
        texts
    };
    let parts = system.parts.iter();
    parts
        .map(|part| Pair {
            name: part.name.clone(),
            assumptions: texts(&part.assumptions),
            guarantees: texts(&part.guarantees),
        })
        .collect()
}
