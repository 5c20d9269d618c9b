//! Proofs as text: how and by what an obligation is met, why it is not met, and the counterexample
//! as a table.

use crate::findings::list;
use crate::findings::play::{Row, grid};
use linewright_algebra::proof::{
    Claim, Cycle, Discharge, DischargeRule, Open, Proof, Refutation, SameStepLoop,
};
use linewright_algebra::replay;
use linewright_algebra::system::{FormulaRef, System};
use linewright_core::gr1::{BinaryOp, Expr, Formula, FormulaKind, Timing, VarId};
use linewright_solver::game::Lasso;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

/// What discharges an obligation that is true of all values.
pub const ALWAYS_HOLDS: &str = "it always holds";

/// Formats a proof about a system.
#[derive(Debug, Clone, Copy)]
pub struct ProofPrinter<'a> {
    /// The components of the proof.
    pub system: &'a System,
    /// The claim about the system.
    pub claim: &'a Claim,
    /// Owner of the claim's own formulas: the name of the refined contract, or of the machine.
    pub whole: &'a str,
}

impl<'a> ProofPrinter<'a> {
    /// Returns the formula that a reference denotes.
    pub fn formula(&self, at: FormulaRef) -> &'a Formula {
        replay::formula(self.system, self.claim, at)
    }

    /// Name of the formula's owner.
    pub fn owner(&self, at: FormulaRef) -> &'a str {
        at.component
            .map_or(self.whole, |p| &self.system.components[p].name)
    }

    /// Qualified name: `cell: pick_open`.
    pub fn name(&self, at: FormulaRef) -> String {
        let formula = &self.formula(at).name;
        match self.owner(at) {
            "" => formula.clone(),
            owner => format!("{owner}: {formula}"),
        }
    }

    /// The formula with its name.
    pub fn named(&self, at: FormulaRef) -> NamedFormula {
        let formula = self.formula(at);
        NamedFormula {
            owner: self.owner(at).to_owned(),
            name: formula.name.clone(),
            text: formula.text.clone(),
        }
    }

    /// Names of the formulas by which an obligation is discharged, on one line.
    pub fn discharged_by(&self, discharge: &Discharge) -> String {
        let mut names: Vec<String> = Vec::new();
        for at in &discharge.by {
            let name = self.name(*at);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let names = names.join(", ");
        match (discharge.rule, names.is_empty()) {
            (DischargeRule::Exported, _) => "passed on: the caller has to keep it".to_owned(),
            (_, true) => ALWAYS_HOLDS.to_owned(),
            _ => names,
        }
    }

    /// A table of discharges: the obligation, the rule, and the formulas that discharge it.
    pub fn table(&self, discharges: &[Discharge]) -> String {
        let names: Vec<String> = discharges.iter().map(|d| self.name(d.what)).collect();
        let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        let rules: Vec<String> = discharges.iter().map(|d| rule_name(d.rule)).collect();
        let middle = rules.iter().map(|r| r.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for ((discharge, name), rule) in discharges.iter().zip(&names).zip(&rules) {
            let by = self.discharged_by(discharge);
            let _ = writeln!(text, "  {name:<width$}  {rule:<middle$}  {by}");
        }
        text
    }

    /// Table of discharges of a refinement, without the rules. `given` names the contract whose
    /// formulas are given.
    pub fn refinement_table(&self, discharges: &[Discharge], given: &str) -> String {
        let names = discharges
            .iter()
            .map(|d| self.formula(d.what).name.as_str());
        let names: Vec<&str> = names.collect();
        let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for (discharge, name) in discharges.iter().zip(&names) {
            let mut by: Vec<String> = Vec::new();
            for at in &discharge.by {
                let owner = at
                    .component
                    .map_or(given, |p| &self.system.components[p].name);
                let name = format!("{owner}: {}", self.formula(*at).name);
                if !by.contains(&name) {
                    by.push(name);
                }
            }
            let by = match by.as_slice() {
                [] => format!("nothing: {ALWAYS_HOLDS}"),
                by => by.join(", "),
            };
            let _ = writeln!(text, "  {name:<width$}  {by}");
        }
        text
    }

    /// Why an obligation is not met, as far as the owners of its variables show it.
    pub fn reason(&self, open: &Open) -> String {
        let formula = self.formula(open.what);
        let Some(part) = open.what.component else {
            return "the parts together do not guarantee it".to_owned();
        };
        let mut own = true;
        let mut others: BTreeSet<usize> = BTreeSet::new();
        formula
            .expr
            .for_each_var(&mut |v, _| match self.system.driver(v) {
                Some(driver) if driver == part => {}
                driver => {
                    own = false;
                    others.extend(driver);
                }
            });
        if own {
            return format!(
                "it mentions only variables that {} sets itself, so no other part can guarantee it",
                self.system.components[part].name
            );
        }
        if let Some(converse) = self.converse(open.what, formula) {
            return format!("`{converse}` is only its converse");
        }
        let names: Vec<String> = others
            .iter()
            .map(|p| self.system.components[*p].name.clone())
            .collect();
        let has_justice = others
            .iter()
            .any(|p| !self.system.components[*p].guarantees.justice.is_empty());
        match (open.what.kind, names.is_empty()) {
            (_, true) => "what is assumed about its inputs does not imply it".to_owned(),
            (FormulaKind::Justice, _) if !has_justice => {
                format!(
                    "{} has no guarantee of the form `always eventually`",
                    list(&names)
                )
            }
            _ => format!("the guarantees of {} do not imply it", list(&names)),
        }
    }

    /// Finds a guarantee of the form `a -> b` where the assumption needs `b -> a`.
    fn converse(&self, at: FormulaRef, assumed: &Formula) -> Option<String> {
        let (p, q) = implication(&assumed.expr)?;
        let parts = self.system.components.iter().enumerate();
        for (i, part) in parts.filter(|(i, _)| Some(*i) != at.component) {
            for (kind, _, guarantee) in part.guarantees.formulas() {
                if kind != at.kind {
                    continue;
                }
                let Some((a, b)) = implication(&guarantee.expr) else {
                    continue;
                };
                // The assumption is `b -> q`, and `q` is one of the conjuncts of `a`.
                if *b == *p && a.conjuncts().iter().any(|c| same_truth(c, q)) {
                    return Some(format!(
                        "{}: {}",
                        self.system.components[i].name, guarantee.name
                    ));
                }
            }
        }
        None
    }

    /// The counterexample as a table of the relevant variables, with its ending.
    pub fn counterexample(&self, open: &Open) -> String {
        let shown = self.relevant_variables(open.what);
        let (steps, round) = match &open.why {
            Refutation::Trace(steps) => (steps.clone(), None),
            Refutation::Lasso(run) => (
                [run.prefix.clone(), run.cycle.clone()].concat(),
                Some(run.prefix.len()),
            ),
        };
        let last = steps.len() - 1;
        let name = &self.formula(open.what).name;
        let end = match round {
            None => format!("step {last} breaks `{name}`"),
            Some(from) if from == last => {
                format!("step {last} repeats for ever, without meeting `{name}`")
            }
            Some(from) => format!(
                "after step {last} the run repeats from step {from} for ever, without meeting `{name}`"
            ),
        };
        steps_table(self.system, &shown, &steps) + &end
    }

    /// Variables of a formula, and of each guarantee by which a part constrains one of these
    /// variables that the part sets. Internal variables are left out.
    fn relevant_variables(&self, at: FormulaRef) -> Vec<VarId> {
        let mut found: BTreeSet<VarId> = BTreeSet::new();
        let mut add = |expr: &Expr| {
            expr.for_each_var(&mut |v, _| {
                found.insert(v);
            });
        };
        add(&self.formula(at).expr);
        let own: BTreeSet<VarId> = found.clone();
        for part in &self.system.components {
            for (_, _, formula) in part.guarantees.formulas() {
                let mut sets = false;
                formula.expr.for_each_var(&mut |v, _| {
                    sets |= own.contains(&v) && part.drives.contains(&v);
                });
                if sets {
                    formula.expr.for_each_var(&mut |v, _| {
                        found.insert(v);
                    });
                }
            }
        }
        let hidden = |v: &VarId| self.system.variables[v.index()].internal;
        found.into_iter().filter(|v| !hidden(v)).collect()
    }

    /// Returns a message about a cycle of justice assumptions, and a help text with a pattern that
    /// avoids it.
    pub fn describe_cycle(&self, cycle: &Cycle) -> (String, String) {
        let members: Vec<String> = cycle
            .assumptions
            .iter()
            .map(|at| format!("`{}`", self.name(*at)))
            .collect();
        let texts: Vec<&str> = cycle
            .assumptions
            .iter()
            .map(|at| self.formula(*at).text.as_str())
            .collect();
        let message = format!(
            "{} depend on one another: each holds infinitely often only if the others do",
            list(&members)
        );
        let help = format!(
            "instead of `{}`, let the component that acts guarantee `always eventually (not requested or done)`; \
             let the component that asks assume the same, and guarantee \
             `always (requested and not done -> next requested)`; then each request is held until it is done",
            texts.join("` and `")
        );
        (message, help)
    }

    /// Returns a message and a help text about variables that depend on each other within a step.
    pub fn describe_loop(&self, found: &SameStepLoop) -> (String, String) {
        let names: Vec<String> = found
            .variables
            .iter()
            .map(|v| {
                let variable = &self.system.variables[v.index()].name;
                match self.system.driver(*v) {
                    Some(part) => format!("`{variable}` of {}", self.system.components[part].name),
                    None => format!("`{variable}`"),
                }
            })
            .collect();
        let drivers = found.variables.iter().map(|v| self.system.driver(*v));
        let can_be_moore = drivers
            .flatten()
            .any(|part| self.system.components[part].timing == Timing::Mealy);
        let help = if can_be_moore {
            "make one of the contracts `moore`, so that its outputs do not depend on the others in the same step, or let it refer to the previous step"
        } else {
            "let what one of the contracts assumes or guarantees refer to the previous step, not to values that the other sets in the same step"
        };
        (
            format!("within one step, {} wait for each other", list(&names)),
            help.to_owned(),
        )
    }

    /// Assumptions that the proof passes on to the caller.
    pub fn exported(&self, proof: &Proof) -> Vec<FormulaRef> {
        let exported = proof.discharges.iter();
        exported
            .filter(|d| d.rule == DischargeRule::Exported)
            .map(|d| d.what)
            .collect()
    }
}

/// Name of a rule, as shown in tables.
pub fn rule_name(rule: DischargeRule) -> String {
    match rule {
        DischargeRule::Environment | DischargeRule::Exported => "environment".to_owned(),
        DischargeRule::Induction => "step by step".to_owned(),
        DischargeRule::Justice { turn } => format!("justice, turn {}", turn + 1),
    }
}

/// The rule by which an obligation is discharged, for JSON documents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DischargeRuleName {
    /// Assumed about the environment of the whole.
    Environment,
    /// Passed on to the caller of the whole.
    Exported,
    /// Induction over time.
    Induction,
    /// A turn of the proof of justice.
    Justice,
    /// Holds for the synthesized controllers, though not for all that keep the contracts.
    Controllers,
}

/// The name used in JSON documents.
impl fmt::Display for DischargeRuleName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl From<DischargeRule> for DischargeRuleName {
    fn from(rule: DischargeRule) -> Self {
        match rule {
            DischargeRule::Environment => Self::Environment,
            DischargeRule::Exported => Self::Exported,
            DischargeRule::Induction => Self::Induction,
            DischargeRule::Justice { .. } => Self::Justice,
        }
    }
}

/// Steps as a table with a row for each variable in `shown`.
pub fn steps_table(system: &System, shown: &[VarId], steps: &[Vec<i64>]) -> String {
    let rows = shown.iter().map(|v| {
        let variable = &system.variables[v.index()];
        let driver = system.driver(*v);
        Row {
            side: driver.map_or("outside".to_owned(), |p| system.components[p].name.clone()),
            name: variable.name.clone(),
            cells: steps
                .iter()
                .map(|s| variable.domain.show(s[v.index()]))
                .collect(),
        }
    });
    let mut rows: Vec<Row> = rows.collect();
    // Values from the environment come first.
    rows.sort_by_key(|r| r.side != "outside");
    grid(&rows, steps.len() - 1)
}

/// A lasso as a table, with the step to which it returns.
pub fn lasso_table(system: &System, run: &Lasso) -> String {
    let steps = [run.prefix.clone(), run.cycle.clone()].concat();
    let all: Vec<VarId> = (0..system.variables.len() as u32)
        .map(VarId)
        .filter(|v| !system.variables[v.index()].internal)
        .collect();
    steps_table(system, &all, &steps) + &lasso_end(run)
}

/// The step to which a lasso returns.
pub fn lasso_end(run: &Lasso) -> String {
    let last = run.prefix.len() + run.cycle.len() - 1;
    if run.prefix.len() == last {
        format!("step {last} repeats for ever")
    } else {
        format!(
            "after step {last} the run repeats from step {} for ever",
            run.prefix.len()
        )
    }
}

fn implication(expr: &Expr) -> Option<(&Expr, &Expr)> {
    match expr {
        Expr::Binary(BinaryOp::Implies, a, b) => Some((a, b)),
        _ => None,
    }
}

/// Whether two expressions are equal if `grip = true` is read as `grip`.
fn same_truth(a: &Expr, b: &Expr) -> bool {
    fn plain(expr: &Expr) -> &Expr {
        match expr {
            Expr::Binary(BinaryOp::Eq, a, b) if **b == Expr::TRUE => a,
            other => other,
        }
    }
    plain(a) == plain(b)
}

/// How an obligation is met, for the JSON documents of `check`.
#[derive(Debug, JsonSchema, Serialize)]
pub struct DischargeEntry {
    /// The component whose assumption is discharged, or the machine or contract whose guarantee is
    /// discharged.
    pub component: String,
    /// Name of the assumption or guarantee.
    pub assumption: String,
    /// The rule by which it is discharged.
    pub rule: DischargeRuleName,
    /// For justice: the turn, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub turn: Option<usize>,
    /// What discharges it: names of formulas, or a phrase.
    pub by: String,
    /// The obligation, and the formulas that discharge it, for pages.
    #[serde(skip)]
    pub formulas: Vec<NamedFormula>,
}

/// A formula of a proof, with its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFormula {
    /// The component, machine or contract that has it.
    pub owner: String,
    /// Its name.
    pub name: String,
    /// What it says.
    pub text: String,
}

/// What discharges assumptions that a machine passes on to its caller.
pub const KEPT_BY_LINE: &str = "the line, checked at every call";

/// A discharge as an entry of the JSON documents of `check`.
pub fn discharge_entry(printer: ProofPrinter<'_>, discharge: &Discharge) -> DischargeEntry {
    DischargeEntry {
        component: printer.owner(discharge.what).to_owned(),
        assumption: printer.formula(discharge.what).name.clone(),
        rule: discharge.rule.into(),
        turn: match discharge.rule {
            DischargeRule::Justice { turn } => Some(turn + 1),
            _ => None,
        },
        by: match discharge.rule {
            DischargeRule::Exported => KEPT_BY_LINE.to_owned(),
            _ => printer.discharged_by(discharge),
        },
        formulas: {
            // The phrase for what is passed on to the caller names no formula.
            let by: &[FormulaRef] = match discharge.rule {
                DischargeRule::Exported => &[],
                _ => &discharge.by,
            };
            let all = std::iter::once(&discharge.what).chain(by);
            all.map(|at| printer.named(*at)).collect()
        },
    }
}
