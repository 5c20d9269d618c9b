//! All formulas of a system and a claim as numbered rules, with the variables each one mentions and
//! defines.

use super::super::system::{ContractSide, FormulaRef, System, formulas, rule};
use super::Claim;
use linewright_core::gr1::{Domain, Expr, Owner, Side, Time, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_solver::game::{Limit, Limits, Rule, RuleKind, Runs};
use std::collections::BTreeSet;

/// Origin of a rule, and whether others may rely on it.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Formula; `None` for the definition of a monitor.
    pub at: Option<FormulaRef>,
    /// Part that the formula belongs to.
    pub part: Option<usize>,
    /// Variables that it mentions.
    pub mentions: BTreeSet<VarId>,
    /// Those of `mentions` that its part sets (for givens: that come from outside); all of them if
    /// there are none.
    pub defines: BTreeSet<VarId>,
    /// Whether it holds in a step whatever the others do in that step: givens, and the guarantees
    /// of a part that answers first about its own answer.
    pub unconditional: bool,
}

/// All rules of a proof.
#[derive(Debug)]
pub struct ProofRules<'a> {
    /// System that the rules are about.
    pub system: &'a System,
    /// Decision procedure for questions about the rules.
    pub runs: Runs,
    /// One entry per rule.
    pub entries: Vec<Entry>,
    /// Boolean that stays true once the rule under examination was broken.
    pub slipped: VarId,
}

impl<'a> ProofRules<'a> {
    /// Builds the rules of a system and a claim.
    pub fn new(system: &'a System, claim: &Claim, limits: &Limits) -> Result<Self, Limit> {
        let mut variables = system.variables.clone();
        let slipped = VarId(variables.len() as u32);
        variables.push(Variable {
            name: system.fresh_name("slipped"),
            owner: Owner::System,
            internal: true,
            domain: Domain::Bool,
            unit: String::new(),
            span: Span::default(),
        });
        let mut rules = Vec::new();
        let mut entries = Vec::new();
        let mut add = |side: &Side, part: Option<usize>, half: Option<ContractSide>| {
            for (kind, index, formula) in formulas(side) {
                entries.push(entry(system, &formula.expr, kind, index, part, half));
                rules.push(rule(kind, &formula.expr));
            }
        };
        add(&claim.given, None, Some(ContractSide::Assumptions));
        for (i, part) in system.parts.iter().enumerate() {
            add(&part.definitions, Some(i), None);
            add(&part.guarantees, Some(i), Some(ContractSide::Guarantees));
        }
        for (i, part) in system.parts.iter().enumerate() {
            add(&part.assumptions, Some(i), Some(ContractSide::Assumptions));
        }
        add(&claim.goal, None, Some(ContractSide::Guarantees));
        Ok(Self {
            system,
            runs: Runs::new(&variables, rules, limits)?,
            entries,
            slipped,
        })
    }

    /// Returns the rule with a number.
    pub fn rule(&self, index: usize) -> &Rule {
        &self.runs.rules()[index]
    }

    /// Returns whether a rule is justice.
    pub fn is_justice(&self, index: usize) -> bool {
        self.rule(index).kind == RuleKind::Justice
    }

    /// Returns the rules whose formulas satisfy a condition.
    pub fn numbers(&self, wanted: impl Fn(&FormulaRef) -> bool) -> Vec<usize> {
        let entries = self.entries.iter().enumerate();
        entries
            .filter(|(_, e)| e.at.as_ref().is_some_and(&wanted))
            .map(|(i, _)| i)
            .collect()
    }

    /// Adds a rule that is not relied on unless requested.
    pub fn add(&mut self, rule: Rule) -> usize {
        let mentions = mentions(&rule.expr);
        self.entries.push(Entry {
            at: None,
            part: None,
            defines: BTreeSet::new(),
            mentions,
            unconditional: false,
        });
        self.runs.add(rule)
    }

    /// Returns the definitions of all monitors that these rules mention, directly or through other
    /// monitors.
    pub fn definitions(&self, rules: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut needed: BTreeSet<VarId> = BTreeSet::new();
        for index in rules {
            needed.extend(&self.entries[index].mentions);
        }
        let mut found = BTreeSet::new();
        loop {
            let more: Vec<usize> = (0..self.entries.len())
                .filter(|i| self.is_definition(*i) && !found.contains(i))
                .filter(|i| !self.entries[*i].defines.is_disjoint(&needed))
                .collect();
            if more.is_empty() {
                return found.into_iter().collect();
            }
            for index in more {
                needed.extend(&self.entries[index].mentions);
                found.insert(index);
            }
        }
    }

    /// Returns whether a rule defines a monitor.
    fn is_definition(&self, index: usize) -> bool {
        let entry = &self.entries[index];
        entry.at.is_none() && entry.part.is_some()
    }

    /// Returns the candidates reachable from a goal through the variables that rules mention and
    /// define, in rings, nearest first. Unreachable candidates are omitted.
    pub fn rings(&self, goals: &[usize], candidates: &[usize]) -> Vec<Vec<usize>> {
        let mut needed: BTreeSet<VarId> = BTreeSet::new();
        for goal in goals {
            needed.extend(&self.entries[*goal].mentions);
        }
        let mut left: Vec<usize> = candidates.to_vec();
        let mut rings = Vec::new();
        loop {
            for index in self.definitions(goals.iter().copied()) {
                needed.extend(&self.entries[index].mentions);
            }
            let (near, far): (Vec<usize>, Vec<usize>) = left
                .into_iter()
                .partition(|i| !self.entries[*i].defines.is_disjoint(&needed));
            left = far;
            if near.is_empty() {
                return rings;
            }
            for index in &near {
                needed.extend(&self.entries[*index].mentions);
            }
            for index in self.definitions(near.iter().copied()) {
                needed.extend(&self.entries[index].mentions);
            }
            rings.push(near);
        }
    }
}

/// Returns the variables of an expression.
pub fn mentions(expr: &Expr) -> BTreeSet<VarId> {
    let mut found = BTreeSet::new();
    expr.for_each_var(&mut |v, _| {
        found.insert(v);
    });
    found
}

/// Returns the time of the last step that a formula of this kind is about.
pub fn last_step(kind: RuleKind) -> Time {
    match kind {
        RuleKind::Safety => Time::Next,
        _ => Time::Now,
    }
}

/// Returns the variables of a formula whose values belong to the last step that it is about.
pub fn latest(expr: &Expr, kind: RuleKind) -> BTreeSet<VarId> {
    let time = last_step(kind);
    let mut found = BTreeSet::new();
    expr.for_each_var(&mut |v, t| {
        if t == time {
            found.insert(v);
        }
    });
    found
}

fn entry(
    system: &System,
    expr: &Expr,
    kind: RuleKind,
    index: usize,
    part: Option<usize>,
    half: Option<ContractSide>,
) -> Entry {
    let mentions = mentions(expr);
    let own = |v: &VarId| match part {
        Some(part) => system.parts[part].drives.contains(v),
        None => system.driver(*v).is_none(),
    };
    let mut defines: BTreeSet<VarId> = mentions.iter().copied().filter(own).collect();
    // The goal defines everything that it mentions.
    if defines.is_empty() || (part.is_none() && half == Some(ContractSide::Guarantees)) {
        defines.clone_from(&mentions);
    }
    let guarantee = part.filter(|_| half != Some(ContractSide::Assumptions));
    let answers_first = guarantee.is_some_and(|p| {
        let part = &system.parts[p];
        part.timing == Timing::Moore && latest(expr, kind).iter().all(|v| part.drives.contains(v))
    });
    Entry {
        at: half.map(|half| FormulaRef {
            part,
            half,
            kind,
            index,
        }),
        part,
        mentions,
        defines,
        unconditional: part.is_none() || half.is_none() || answers_first,
    }
}
