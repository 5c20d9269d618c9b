//! JSON documents of the algebra commands.

use crate::algebra::proof::{Discharge, DischargeRule, Open, Proof, Refutation};
use crate::algebra::system::{FormulaRef, System, formulas};
use crate::diagnostics::json;
use crate::engine::words::{DischargeRuleName, ProofPrinter};
use crate::game::Lasso;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// A reference to a formula.
#[derive(Debug, JsonSchema, Serialize)]
pub struct FormulaReference {
    /// Contract or component that it belongs to.
    pub of: String,
    /// Name of the formula.
    pub name: String,
    /// Text of the formula.
    pub text: String,
}

/// How an obligation is met.
#[derive(Debug, JsonSchema, Serialize)]
pub struct DischargeEntry {
    /// The obligation.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// The rule that meets it.
    pub rule: DischargeRuleName,
    /// For justice: the turn, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub turn: Option<usize>,
    /// Formulas on which it rests.
    pub by: Vec<FormulaReference>,
}

/// An obligation that is not met.
#[derive(Debug, JsonSchema, Serialize)]
pub struct OpenEntry {
    /// The obligation.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// Why it is not met.
    pub reason: String,
    /// A run that violates it.
    pub counterexample: Counterexample,
}

/// A counterexample with the values of all variables by name.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Counterexample {
    /// `trace`, whose last step is a violation, or `lasso`.
    #[schemars(extend("enum" = ["trace", "lasso"]))]
    pub kind: &'static str,
    /// Steps in order.
    pub steps: Vec<BTreeMap<String, String>>,
    /// For a lasso: index of the step that follows the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<usize>,
}

/// A proof.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProofEntry {
    /// Obligations that are met.
    pub discharges: Vec<DischargeEntry>,
    /// Obligations that are not met.
    pub open: Vec<OpenEntry>,
    /// Justice assumptions that wait for one another.
    pub circles: Vec<Vec<FormulaReference>>,
    /// Variables that wait for one another within a step.
    pub loops: Vec<Vec<String>>,
}

/// One of the contracts that a result is made of.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Pair {
    /// Name of the contract.
    pub name: String,
    /// Its assumptions.
    pub assumptions: Vec<Text>,
    /// Its guarantees.
    pub guarantees: Vec<Text>,
}

/// A formula as it was written.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Text {
    /// Name of the formula.
    pub name: String,
    /// Text of the formula.
    pub text: String,
}

/// The answer of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every assumption of a part is met.
    Composed,
    /// Some assumptions are not met.
    Open,
    /// Some environment keeps all assumptions.
    Compatible,
    /// No environment does.
    Incompatible,
    /// What was promised is still kept.
    Refined,
    /// A promise is broken.
    Broken,
    /// A law of the algebra was proved for these operands.
    Proved,
    /// A run refutes it.
    Refuted,
}

/// Semantics of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Semantics {
    /// Safety first, step by step.
    Strict,
    /// Inclusion of infinite runs.
    Runs,
}

/// Fate of a contract from one library to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LibraryChange {
    /// Unchanged.
    Same,
    /// It promises at least as much, and assumes no more.
    Refined,
    /// It promises less, or assumes more.
    Broken,
    /// Only in the new library.
    Added,
    /// Only in the old library.
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
    /// Schema with the command's name.
    pub schema: String,
    /// Answer of the command.
    pub verdict: Verdict,
    /// Semantics of the decision.
    pub semantics: Semantics,
    /// Contracts concerned.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<Pair>,
    /// Proofs by what they show.
    #[serde(flatten)]
    #[schemars(with = "Proofs")]
    pub proofs: BTreeMap<&'static str, ProofEntry>,
    /// A run or play that shows why not, if it belongs to no single formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<Counterexample>,
    /// Comparison of two libraries, contract by contract.
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
    /// Name of the contract.
    pub name: String,
    /// What became of it.
    pub verdict: LibraryChange,
    /// What is not kept any more.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<OpenEntry>,
}

/// A formula with its name.
pub fn named(printer: ProofPrinter<'_>, at: FormulaRef) -> FormulaReference {
    let formula = printer.formula(at);
    FormulaReference {
        of: printer.owner(at).to_owned(),
        name: formula.name.clone(),
        text: formula.text.clone(),
    }
}

/// A proof as JSON.
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

/// An open obligation as JSON.
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

/// The contracts of a system as written.
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
