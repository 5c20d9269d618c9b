//! What the commands of the algebra print as JSON.

use crate::algebra::proof::{Discharge, DischargeRule, Open, Proof, Refutation};
use crate::algebra::system::{FormulaRef, System, formulas};
use crate::diagnostics::json;
use crate::engine::words::{DischargeRuleName, ProofPrinter};
use crate::game::Lasso;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// Points at a formula.
#[derive(Debug, JsonSchema, Serialize)]
pub struct FormulaReference {
    /// The contract or component it belongs to.
    pub of: String,
    /// Its name there.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// How an obligation is met.
#[derive(Debug, JsonSchema, Serialize)]
pub struct DischargeEntry {
    /// What.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// By which rule.
    pub rule: DischargeRuleName,
    /// Of justice: the turn, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub turn: Option<usize>,
    /// On what it rests.
    pub by: Vec<FormulaReference>,
}

/// An obligation that is not met.
#[derive(Debug, JsonSchema, Serialize)]
pub struct OpenEntry {
    /// What.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// Why.
    pub reason: String,
    /// How it is broken.
    pub counterexample: Counterexample,
}

/// A counterexample, with a value for every variable by its name.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Counterexample {
    /// `trace`, whose last step breaks something, or `lasso`.
    #[schemars(extend("enum" = ["trace", "lasso"]))]
    pub kind: &'static str,
    /// The steps.
    pub steps: Vec<BTreeMap<String, String>>,
    /// Of a lasso: the step with which it goes on after the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<usize>,
}

/// A proof.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProofEntry {
    /// What is met.
    pub discharges: Vec<DischargeEntry>,
    /// What is not.
    pub open: Vec<OpenEntry>,
    /// Justice assumptions that wait for one another.
    pub circles: Vec<Vec<FormulaReference>>,
    /// Variables that wait for one another within a step.
    pub loops: Vec<Vec<String>>,
}

/// One contract among those that a result is made of.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Pair {
    /// What it is called.
    pub name: String,
    /// What it assumes.
    pub assumptions: Vec<Text>,
    /// What it guarantees.
    pub guarantees: Vec<Text>,
}

/// A formula as it was written.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Text {
    /// Its name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// The answer of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every assumption of a part is met.
    Composed,
    /// Some are not.
    Open,
    /// Some environment keeps all assumptions.
    Compatible,
    /// None does.
    Incompatible,
    /// What was promised is still kept.
    Refined,
    /// It is not.
    Broken,
    /// A law of the algebra was proved for these operands.
    Proved,
    /// A run refutes it.
    Refuted,
}

/// What two contracts are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Semantics {
    /// Safety first, step by step.
    Strict,
    /// Inclusion of infinite runs.
    Runs,
}

/// What became of a contract from one library to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LibraryChange {
    /// It says the same.
    Same,
    /// It promises at least as much, and assumes no more.
    Refined,
    /// It does not.
    Broken,
    /// It is new.
    Added,
    /// It is gone.
    Removed,
    /// A limit was reached.
    GaveUp,
}

impl fmt::Display for LibraryChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// The document of a command.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Document {
    /// Which command's.
    pub schema: String,
    /// What came out.
    pub verdict: Verdict,
    /// Which semantics it was decided in.
    pub semantics: Semantics,
    /// The contracts it is about.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<Pair>,
    /// Proofs, by what they show.
    #[serde(flatten)]
    #[schemars(with = "Proofs")]
    pub proofs: BTreeMap<&'static str, ProofEntry>,
    /// A run or play that shows why not, where it belongs to no single formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<Counterexample>,
    /// Contract by contract, of two libraries.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contracts: Vec<ContractComparison>,
    /// All findings.
    pub findings: Vec<json::Finding>,
}

/// The proofs that there can be, for the schema.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "it only describes what `proofs` can hold")]
struct Proofs {
    /// Of `compose`, and of `refine` with several contracts.
    #[schemars(skip_serializing_if = "Option::is_none")]
    proof: Option<ProofEntry>,
    /// Of `refine`: the assumptions of the old contract imply those of the new one.
    #[schemars(skip_serializing_if = "Option::is_none")]
    assumptions: Option<ProofEntry>,
    /// Of `refine`: the guarantees of the new contract imply those of the old one.
    #[schemars(skip_serializing_if = "Option::is_none")]
    guarantees: Option<ProofEntry>,
}

/// What became of a contract from one library to the other.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ContractComparison {
    /// Its name.
    pub name: String,
    /// What became of it.
    pub verdict: LibraryChange,
    /// What is not kept any more.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<OpenEntry>,
}

/// A formula by name.
pub fn named(printer: ProofPrinter<'_>, at: FormulaRef) -> FormulaReference {
    let formula = printer.formula(at);
    FormulaReference {
        of: printer.owner(at).to_owned(),
        name: formula.name.clone(),
        text: formula.text.clone(),
    }
}

/// A proof for other programs.
pub fn proof(printer: ProofPrinter<'_>, proof: &Proof) -> ProofEntry {
    ProofEntry {
        discharges: proof
            .discharges
            .iter()
            .map(|d| discharge(printer, d))
            .collect(),
        open: proof.open.iter().map(|o| open(printer, o)).collect(),
        circles: proof
            .circles
            .iter()
            .map(|c| c.assumptions.iter().map(|at| named(printer, *at)).collect())
            .collect(),
        loops: proof
            .loops
            .iter()
            .map(|l| {
                let names = l.variables.iter();
                names
                    .map(|v| printer.system.variables[v.index()].name.clone())
                    .collect()
            })
            .collect(),
    }
}

fn discharge(printer: ProofPrinter<'_>, discharge: &Discharge) -> DischargeEntry {
    DischargeEntry {
        what: named(printer, discharge.what),
        rule: discharge.rule.into(),
        turn: match discharge.rule {
            DischargeRule::Justice { turn } => Some(turn + 1),
            _ => None,
        },
        by: discharge.by.iter().map(|at| named(printer, *at)).collect(),
    }
}

/// An open obligation for other programs.
pub fn open(printer: ProofPrinter<'_>, open: &Open) -> OpenEntry {
    OpenEntry {
        what: named(printer, open.what),
        reason: printer.reason(open),
        counterexample: match &open.why {
            Refutation::Trace(steps) => trace(printer.system, steps),
            Refutation::Lasso(run) => lasso(printer.system, run),
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
