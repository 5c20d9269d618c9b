//! Proofs in words: what an obligation rests on and how, what prevents it, and the counterexample
//! as a table.

use crate::findings::list;
use crate::findings::play::{Row, grid};
use linewright_algebra::proof::{
    Circle, Claim, Discharge, DischargeRule, Open, Proof, Refutation, SameStepLoop,
};
use linewright_algebra::replay;
use linewright_algebra::system::{FormulaRef, System, formulas};
use linewright_core::gr1::{BinaryOp, Expr, Formula, VarId};
use linewright_solver::game::{Lasso, RuleKind};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

/// A system and a claim about it, with their names.
#[derive(Debug, Clone, Copy)]
pub struct ProofPrinter<'a> {
    /// The system.
    pub system: &'a System,
    /// The claim.
    pub claim: &'a Claim,
    /// Owner of the claim's own formulas: the name of the refined contract, or of the machine.
    pub whole: &'a str,
}

impl<'a> ProofPrinter<'a> {
    /// Returns the formula at a reference.
    pub fn formula(&self, at: FormulaRef) -> &'a Formula {
        replay::formula(self.system, self.claim, at)
    }

    /// Name of the formula's owner.
    pub fn owner(&self, at: FormulaRef) -> &'a str {
        at.part.map_or(self.whole, |p| &self.system.parts[p].name)
    }

    /// Qualified name: `cell: pick_open`.
    pub fn name(&self, at: FormulaRef) -> String {
        let formula = &self.formula(at).name;
        match self.owner(at) {
            "" => formula.clone(),
            owner => format!("{owner}: {formula}"),
        }
    }

    /// What meets an obligation, in one line.
    pub fn by(&self, discharge: &Discharge) -> String {
        let mut names: Vec<String> = Vec::new();
        for at in &discharge.by {
            let name = self.name(*at);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let names = names.join(", ");
        match (discharge.rule, names.is_empty()) {
            (DischargeRule::Exported, _) => "handed on: whoever uses it has to keep it".to_owned(),
            (_, true) => "it cannot be broken".to_owned(),
            _ => names,
        }
    }

    /// A table of discharges: obligation, rule, and what meets it.
    pub fn table(&self, discharges: &[Discharge]) -> String {
        let names: Vec<String> = discharges.iter().map(|d| self.name(d.what)).collect();
        let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        let how: Vec<String> = discharges.iter().map(|d| how(d.rule)).collect();
        let middle = how.iter().map(|h| h.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for ((discharge, name), how) in discharges.iter().zip(&names).zip(&how) {
            let by = self.by(discharge);
            let _ = writeln!(text, "  {name:<width$}  {how:<middle$}  {by}");
        }
        text
    }

    /// Like `table`, for a refinement whose environment is that of the contract `given`.
    pub fn rests(&self, discharges: &[Discharge], given: &str) -> String {
        let names = discharges
            .iter()
            .map(|d| self.formula(d.what).name.as_str());
        let names: Vec<&str> = names.collect();
        let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for (discharge, name) in discharges.iter().zip(&names) {
            let mut by: Vec<String> = Vec::new();
            for at in &discharge.by {
                let owner = at.part.map_or(given, |p| &self.system.parts[p].name);
                let name = format!("{owner}: {}", self.formula(*at).name);
                if !by.contains(&name) {
                    by.push(name);
                }
            }
            let by = match by.as_slice() {
                [] => "nothing: it cannot be broken".to_owned(),
                by => by.join(", "),
            };
            let _ = writeln!(text, "  {name:<width$}  {by}");
        }
        text
    }

    /// Why an assumption is not met, as far as the owners of the variables show it.
    pub fn reason(&self, open: &Open) -> String {
        let formula = self.formula(open.what);
        let Some(part) = open.what.part else {
            return "the parts together do not keep it".to_owned();
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
                "it speaks only of what {} sets itself, so nobody else can see to it",
                self.system.parts[part].name
            );
        }
        if let Some(converse) = self.converse(open.what, formula) {
            return format!("`{converse}` is only its converse");
        }
        let names: Vec<String> = others
            .iter()
            .map(|p| self.system.parts[*p].name.clone())
            .collect();
        let owed = others
            .iter()
            .any(|p| !self.system.parts[*p].guarantees.justice.is_empty());
        match (open.what.kind, names.is_empty()) {
            (_, true) => "nothing that is known of its inputs makes it true".to_owned(),
            (RuleKind::Justice, _) if !owed => format!(
                "{} {} nothing that comes true again and again",
                list(&names),
                if names.len() == 1 {
                    "promises"
                } else {
                    "promise"
                }
            ),
            (RuleKind::Justice, _) => {
                format!(
                    "what {} can be relied on for does not bring it about",
                    list(&names)
                )
            }
            _ => format!("what {} guarantees does not imply it", list(&names)),
        }
    }

    /// Finds a guarantee of the form `a -> b` where the assumption needs `b -> a`.
    fn converse(&self, at: FormulaRef, assumed: &Formula) -> Option<String> {
        let (p, q) = implication(&assumed.expr)?;
        let parts = self.system.parts.iter().enumerate();
        for (i, part) in parts.filter(|(i, _)| Some(*i) != at.part) {
            for (kind, _, guarantee) in formulas(&part.guarantees) {
                if kind != at.kind {
                    continue;
                }
                let Some((a, b)) = implication(&guarantee.expr) else {
                    continue;
                };
                // `b` is assumed to lead to `q`, and `q` is among the conjuncts that lead to `b`.
                if *b == *p && a.conjuncts().iter().any(|c| same_truth(c, q)) {
                    return Some(format!("{}: {}", self.system.parts[i].name, guarantee.name));
                }
            }
        }
        None
    }

    /// The counterexample as a table of the relevant variables, with its ending.
    pub fn shown(&self, open: &Open) -> String {
        let shown = self.mentioned(open.what);
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
                format!("step {last} goes on for ever, and `{name}` is never met again")
            }
            Some(from) => format!(
                "after step {last} it goes on with step {from}, for ever, and `{name}` is never met again"
            ),
        };
        steps_table(self.system, &shown, &steps) + &end
    }

    /// Variables of a formula, and of formulas about the same variables' values that mention few
    /// others.
    fn mentioned(&self, at: FormulaRef) -> Vec<VarId> {
        let mut found: BTreeSet<VarId> = BTreeSet::new();
        let mut add = |expr: &Expr| {
            expr.for_each_var(&mut |v, _| {
                found.insert(v);
            });
        };
        add(&self.formula(at).expr);
        let own: BTreeSet<VarId> = found.clone();
        for part in &self.system.parts {
            for (_, _, formula) in formulas(&part.guarantees) {
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

    /// Describes a circle of justice, and the change of pattern that breaks it.
    pub fn circle(&self, circle: &Circle) -> (String, String) {
        let members: Vec<String> = circle
            .assumptions
            .iter()
            .map(|at| format!("`{}`", self.name(*at)))
            .collect();
        let texts: Vec<&str> = circle
            .assumptions
            .iter()
            .map(|at| self.formula(*at).text.as_str())
            .collect();
        let message = format!(
            "{} depend on one another: each holds infinitely often only if the others do",
            list(&members)
        );
        let help = format!(
            "hold each request until it is done, and ask for no more than that: instead of `{}`, let the one who acts guarantee \
             `always eventually (not requested or done)`, let the one who asks assume the same and guarantee \
             `always (requested and not done -> next requested)`; then nobody has to ask for ever",
            texts.join("` and `")
        );
        (message, help)
    }

    /// Describes a loop within a step.
    pub fn same_step(&self, found: &SameStepLoop) -> (String, String) {
        let names: Vec<String> = found
            .variables
            .iter()
            .map(|v| {
                let variable = &self.system.variables[v.index()].name;
                match self.system.driver(*v) {
                    Some(part) => format!("`{variable}` of {}", self.system.parts[part].name),
                    None => format!("`{variable}`"),
                }
            })
            .collect();
        (
            format!("within one step {} wait for each other", list(&names)),
            "make one of the contracts `moore`, so that it answers before it sees the others' answers, or let it refer to the step before"
                .to_owned(),
        )
    }

    /// Assumptions that are passed on to the caller.
    pub fn exported(&self, proof: &Proof) -> Vec<FormulaRef> {
        let exported = proof.discharges.iter();
        exported
            .filter(|d| d.rule == DischargeRule::Exported)
            .map(|d| d.what)
            .collect()
    }
}

/// The rule that meets an obligation, in a word or two.
pub fn how(rule: DischargeRule) -> String {
    match rule {
        DischargeRule::Environment | DischargeRule::Exported => "environment".to_owned(),
        DischargeRule::Induction => "step by step".to_owned(),
        DischargeRule::Justice { turn } => format!("justice, turn {}", turn + 1),
    }
}

/// The rule that meets an obligation, for JSON documents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DischargeRuleName {
    /// Assumed of the environment of the whole.
    Environment,
    /// Passed on to the caller of the whole.
    Exported,
    /// Induction over time.
    Induction,
    /// A turn of the proof of justice.
    Justice,
    /// Shown only by the synthesized controllers.
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

/// Steps as a table, with a row per variable.
pub fn steps_table(system: &System, shown: &[VarId], steps: &[Vec<i64>]) -> String {
    let rows = shown.iter().map(|v| {
        let variable = &system.variables[v.index()];
        let driver = system.driver(*v);
        Row {
            side: driver.map_or("outside".to_owned(), |p| system.parts[p].name.clone()),
            name: variable.name.clone(),
            cells: steps
                .iter()
                .map(|s| variable.domain.show(s[v.index()]))
                .collect(),
        }
    });
    let mut rows: Vec<Row> = rows.collect();
    // Values from outside come first, then part by part.
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
        format!("step {last} goes on for ever")
    } else {
        format!(
            "after step {last} it goes on with step {}, for ever",
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

/// `grip` and `grip = true` are equivalent.
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
    /// The component, or the machine or contract that guarantees it.
    pub component: String,
    /// The assumption or guarantee.
    pub assumption: String,
    /// The rule that meets it.
    pub rule: DischargeRuleName,
    /// For justice: the turn, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub turn: Option<usize>,
    /// What meets it.
    pub by: String,
}

/// Text naming what meets assumptions that are passed on.
pub const HANDED_ON: &str = "the line, checked at every call";

/// A discharge as an entry of the JSON documents of `check`.
pub fn entry(told: ProofPrinter<'_>, discharge: &Discharge) -> DischargeEntry {
    DischargeEntry {
        component: told.owner(discharge.what).to_owned(),
        assumption: told.formula(discharge.what).name.clone(),
        rule: discharge.rule.into(),
        turn: match discharge.rule {
            DischargeRule::Justice { turn } => Some(turn + 1),
            _ => None,
        },
        by: match discharge.rule {
            DischargeRule::Exported => HANDED_ON.to_owned(),
            _ => told.by(discharge),
        },
    }
}
