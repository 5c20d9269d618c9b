//! The formulas of a system and a claim as numbered rules, with the variables that each rule
//! mentions and defines.

use super::super::system::{ContractSide, FormulaRef, System, rule};
use super::Claim;
use linewright_core::gr1::{Domain, Expr, FormulaKind, Owner, Side, Time, Timing, VarId, Variable};
use linewright_core::source::Span;
use linewright_solver::game::{Limit, Limits, Rule, Runs};
use std::collections::BTreeSet;

/// Origin of a rule, and whether other proofs can rely on it within a step.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Formula of the rule; `None` for the definition of a monitor.
    pub at: Option<FormulaRef>,
    /// Component that the formula belongs to; `None` for a formula of the claim.
    pub component: Option<usize>,
    /// Variables that the rule mentions.
    pub mentions: BTreeSet<VarId>,
    /// Variables that the rule is considered to define: the mentioned variables that the component
    /// sets (for givens: those that come from outside). If there are none, and for formulas of the
    /// goal: all mentioned variables.
    pub defines: BTreeSet<VarId>,
    /// Whether the rule holds in a step regardless of other components' answers in that step. This
    /// is true for formulas of the claim, definitions of monitors, and guarantees of a component
    /// that answers first about its own answer.
    pub unconditional: bool,
}

/// All rules of a proof.
#[derive(Debug)]
pub struct ProofRules<'a> {
    /// System of the rules.
    pub system: &'a System,
    /// Decision procedure for questions about the rules.
    pub runs: Runs,
    /// One entry per rule.
    pub entries: Vec<Entry>,
    /// Boolean that stays true once the examined rule is broken.
    pub violated: VarId,
}

impl<'a> ProofRules<'a> {
    /// Builds the rules of a system and a claim.
    pub fn new(system: &'a System, claim: &Claim, limits: &Limits) -> Result<Self, Limit> {
        let mut variables = system.variables.clone();
        let violated = VarId(variables.len() as u32);
        variables.push(Variable {
            name: system.fresh_name("violated"),
            owner: Owner::System,
            internal: true,
            domain: Domain::Bool,
            unit: String::new(),
            span: Span::default(),
        });
        let mut rules = Vec::new();
        let mut entries = Vec::new();
        let mut add = |side: &Side, component: Option<usize>, half: Option<ContractSide>| {
            for (kind, index, formula) in side.formulas() {
                entries.push(entry(system, &formula.expr, kind, index, component, half));
                rules.push(rule(kind, &formula.expr));
            }
        };
        add(&claim.given, None, Some(ContractSide::Assumptions));
        for (i, component) in system.components.iter().enumerate() {
            add(&component.definitions, Some(i), None);
            add(
                &component.guarantees,
                Some(i),
                Some(ContractSide::Guarantees),
            );
            add(
                &component.completions,
                Some(i),
                Some(ContractSide::Completions),
            );
        }
        for (i, component) in system.components.iter().enumerate() {
            add(
                &component.assumptions,
                Some(i),
                Some(ContractSide::Assumptions),
            );
        }
        add(&claim.goal, None, Some(ContractSide::Guarantees));
        Ok(Self {
            system,
            runs: Runs::new(&variables, rules, limits)?,
            entries,
            violated,
        })
    }

    /// Returns the rule with this number.
    pub fn rule(&self, index: usize) -> &Rule {
        &self.runs.rules()[index]
    }

    /// Returns whether a rule is a justice rule.
    pub fn is_justice(&self, index: usize) -> bool {
        self.rule(index).kind == FormulaKind::Justice
    }

    /// Returns the numbers of the rules whose formulas satisfy a condition; definitions of monitors
    /// are omitted.
    pub fn rules_where(&self, wanted: impl Fn(&FormulaRef) -> bool) -> Vec<usize> {
        let entries = self.entries.iter().enumerate();
        entries
            .filter(|(_, e)| e.at.as_ref().is_some_and(&wanted))
            .map(|(i, _)| i)
            .collect()
    }

    /// Adds a rule that is only used in queries that name it, and returns its number.
    pub fn add(&mut self, rule: Rule) -> usize {
        let mentions = mentions(&rule.expr);
        self.entries.push(Entry {
            at: None,
            component: None,
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
        entry.at.is_none() && entry.component.is_some()
    }

    /// Returns the candidates that are reachable from the goals, in rings, nearest first. A ring
    /// contains the candidates that define a variable mentioned by the goals or by an earlier ring.
    /// Unreachable candidates are omitted.
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

/// Returns the variables that an expression mentions.
pub fn mentions(expr: &Expr) -> BTreeSet<VarId> {
    let mut found = BTreeSet::new();
    expr.for_each_var(&mut |v, _| {
        found.insert(v);
    });
    found
}

/// Returns whether the last step that a formula of this kind constrains is the current or the next
/// one.
pub fn last_step(kind: FormulaKind) -> Time {
    match kind {
        FormulaKind::Safety => Time::Next,
        _ => Time::Now,
    }
}

/// Returns the variables that a formula reads in the last step that it constrains.
pub fn latest(expr: &Expr, kind: FormulaKind) -> BTreeSet<VarId> {
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
    kind: FormulaKind,
    index: usize,
    component: Option<usize>,
    half: Option<ContractSide>,
) -> Entry {
    let mentions = mentions(expr);
    let own = |v: &VarId| match component {
        Some(component) => system.components[component].drives.contains(v),
        None => system.driver(*v).is_none(),
    };
    let mut defines: BTreeSet<VarId> = mentions.iter().copied().filter(own).collect();
    // A formula of the goal counts as defining all variables that it mentions.
    if defines.is_empty() || (component.is_none() && half == Some(ContractSide::Guarantees)) {
        defines.clone_from(&mentions);
    }
    let guarantee = component.filter(|_| half != Some(ContractSide::Assumptions));
    let answers_first = guarantee.is_some_and(|p| {
        let component = &system.components[p];
        component.timing == Timing::Moore
            && latest(expr, kind)
                .iter()
                .all(|v| component.drives.contains(v))
    });
    Entry {
        at: half.map(|half| FormulaRef {
            component,
            half,
            kind,
            index,
        }),
        component,
        mentions,
        defines,
        unconditional: component.is_none() || half.is_none() || answers_first,
    }
}
