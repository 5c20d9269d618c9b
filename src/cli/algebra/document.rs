//! JSON documents of the algebra commands.

use crate::algebra::proof::{Discharge, DischargeRule, Open, Proof, Refutation};
use crate::algebra::system::{FormulaRef, System};
use crate::diagnostics::json;
use crate::engine::words::{DischargeRuleName, ProofPrinter};
use crate::game::Lasso;
use crate::gr1::Side;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// A reference to a formula.
#[derive(Debug, JsonSchema, Serialize)]
pub struct FormulaReference {
    /// Contract or component that the formula belongs to.
    pub of: String,
    /// Name of the formula.
    pub name: String,
    /// Text of the formula.
    pub text: String,
}

/// An obligation that is discharged.
#[derive(Debug, JsonSchema, Serialize)]
pub struct DischargeEntry {
    /// The obligation.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// The rule by which the obligation is discharged.
    pub rule: DischargeRuleName,
    /// For justice: the turn, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub turn: Option<usize>,
    /// The formulas from which the obligation follows.
    pub by: Vec<FormulaReference>,
}

/// An obligation that is not discharged.
#[derive(Debug, JsonSchema, Serialize)]
pub struct OpenEntry {
    /// The obligation.
    #[serde(flatten)]
    pub what: FormulaReference,
    /// Why the obligation is not discharged.
    pub reason: String,
    /// A run that violates the obligation.
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
    /// For a lasso: index of the step to which the run returns after the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<usize>,
}

/// A proof, complete or with open obligations.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ProofEntry {
    /// Obligations that are discharged.
    pub discharges: Vec<DischargeEntry>,
    /// Obligations that are not discharged.
    pub open: Vec<OpenEntry>,
    /// Cycles of justice assumptions that depend on each other.
    pub circles: Vec<Vec<FormulaReference>>,
    /// Loops of variables that depend on each other within a step.
    pub loops: Vec<Vec<String>>,
}

/// One of the contracts that make up a result, with its assumptions and guarantees.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Pair {
    /// Name of the contract.
    pub name: String,
    /// Assumptions of the contract.
    pub assumptions: Vec<Text>,
    /// Guarantees of the contract.
    pub guarantees: Vec<Text>,
}

/// A formula as written.
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
    /// Every assumption of a part is discharged.
    Composed,
    /// Some assumptions are not discharged.
    Open,
    /// Some environment keeps all assumptions.
    Compatible,
    /// No environment keeps all assumptions.
    Incompatible,
    /// The new contract refines the old one.
    Refined,
    /// The new contract does not refine the old one.
    Broken,
    /// A law of the algebra was proved for these operands.
    Proved,
    /// A run refutes a law of the algebra: a fault of this program.
    Refuted,
}

/// Semantics of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Semantics {
    /// Step by step: a component keeps its guarantees as long as its assumptions have been kept.
    Strict,
    /// Inclusion of infinite runs.
    Runs,
}

/// Change of a contract between two versions of a library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LibraryChange {
    /// Unchanged.
    Same,
    /// The new contract refines the old one.
    Refined,
    /// The new contract guarantees less, or assumes more.
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

/// The JSON document that an algebra command prints.
#[derive(Debug, JsonSchema, Serialize)]
pub struct Document {
    /// Name of the schema; it contains the command's name.
    pub schema: String,
    /// Answer of the command.
    pub verdict: Verdict,
    /// Semantics of the decision.
    pub semantics: Semantics,
    /// The contracts that make up the result.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pairs: Vec<Pair>,
    /// The proofs, by name.
    #[serde(flatten)]
    #[schemars(with = "Proofs")]
    pub proofs: BTreeMap<&'static str, ProofEntry>,
    /// A run or play that refutes the claim as a whole, not a single formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<Counterexample>,
    /// Comparison of two libraries, contract by contract.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contracts: Vec<ContractComparison>,
    /// All findings.
    pub findings: Vec<json::Finding>,
}

/// All possible proofs, for the schema.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "it only describes what `proofs` can hold")]
struct Proofs {
    /// Proof of `compose`, or of `refine` with several contracts.
    #[schemars(skip_serializing_if = "Option::is_none")]
    proof: Option<ProofEntry>,
    /// Proof of `refine` that the assumptions of the old contract imply those of the new one.
    #[schemars(skip_serializing_if = "Option::is_none")]
    assumptions: Option<ProofEntry>,
    /// Proof of `refine` that the guarantees of the new contract imply those of the old one.
    #[schemars(skip_serializing_if = "Option::is_none")]
    guarantees: Option<ProofEntry>,
}

/// Comparison of two versions of a contract.
#[derive(Debug, JsonSchema, Serialize)]
pub struct ContractComparison {
    /// Name of the contract.
    pub name: String,
    /// Change of the contract.
    pub verdict: LibraryChange,
    /// Obligations that are no longer met.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<OpenEntry>,
}

/// Creates a reference to a formula.
pub fn reference(printer: ProofPrinter<'_>, at: FormulaRef) -> FormulaReference {
    let formula = printer.formula(at);
    FormulaReference {
        of: printer.owner(at).to_owned(),
        name: formula.name.clone(),
        text: formula.text.clone(),
    }
}

/// Converts a proof.
pub fn proof(printer: ProofPrinter<'_>, proof: &Proof) -> ProofEntry {
    ProofEntry {
        discharges: proof
            .discharges
            .iter()
            .map(|d| discharge(printer, d))
            .collect(),
        open: proof.open.iter().map(|o| open(printer, o)).collect(),
        circles: proof
            .cycles
            .iter()
            .map(|c| {
                c.assumptions
                    .iter()
                    .map(|at| reference(printer, *at))
                    .collect()
            })
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
        what: reference(printer, discharge.what),
        rule: discharge.rule.into(),
        turn: match discharge.rule {
            DischargeRule::Justice { turn } => Some(turn + 1),
            _ => None,
        },
        by: discharge
            .by
            .iter()
            .map(|at| reference(printer, *at))
            .collect(),
    }
}

/// Converts an open obligation.
pub fn open(printer: ProofPrinter<'_>, open: &Open) -> OpenEntry {
    OpenEntry {
        what: reference(printer, open.what),
        reason: printer.reason(open),
        counterexample: match &open.why {
            Refutation::Trace(steps) => trace(printer.system, steps),
            Refutation::Lasso(run) => lasso(printer.system, run),
        },
    }
}

/// Converts a finite run.
pub fn trace(system: &System, steps: &[Vec<i64>]) -> Counterexample {
    Counterexample {
        kind: "trace",
        steps: steps.iter().map(|s| values(system, s)).collect(),
        from: None,
    }
}

/// Converts an infinite run.
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

/// The contracts of a system as written, without repeated formulas.
pub fn contract_texts(system: &System) -> Vec<Pair> {
    let texts = |side: &Side| {
        let mut texts: Vec<Text> = Vec::new();
        for (_, _, formula) in side.formulas() {
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
    let parts = system.components.iter();
    parts
        .map(|part| Pair {
            name: part.name.clone(),
            assumptions: texts(&part.assumptions),
            guarantees: texts(&part.guarantees),
        })
        .collect()
}
