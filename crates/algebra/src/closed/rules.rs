//! The givens and proof obligations of a closed composition as numbered rules.

use super::table::{StepCondition, Table, conjunction};
use super::{ClosedComposition, Form};
use crate::proof::{Exports, latest};
use crate::system::{FormulaRef, rule};
use linewright_core::gr1::{Expr, Formula, FormulaKind, Side, Time, Timing, VarId};
use linewright_solver::game::Rule;
use std::collections::BTreeSet;

/// An obligation of a component in a step, which has to be met before the component answers or
/// advances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepObligation {
    /// A component that answers first has outputs.
    HasOutputs,
    /// This assumption of the component is kept.
    Assumption(FormulaRef),
    /// The component's table has a row for its inputs.
    HasRow,
}

/// An obligation, in the order in which the obligations of a step are examined.
#[derive(Debug, Clone)]
pub(super) struct ScheduledObligation {
    /// Index of the component.
    pub component: usize,
    /// Kind of obligation.
    pub kind: StepObligation,
    /// Condition under which the obligation is met.
    pub condition: StepCondition,
    /// The same condition as rules.
    pub rules: [usize; 2],
}

/// Justice rules of a component.
#[derive(Debug, Clone, Default)]
pub(super) struct ComponentJustice {
    /// Justice assumptions that are not exported.
    pub assumed: Vec<(FormulaRef, usize)>,
    /// Justice guarantees of its contract, if it is represented by its contract.
    pub guaranteed: Vec<usize>,
}

/// All rules of a closed composition, and their numbers grouped by use.
#[derive(Debug, Default)]
pub(super) struct RuleSet {
    /// The rules.
    pub rules: Vec<Rule>,
    /// Rules that hold in every step without errors.
    pub keep: Vec<usize>,
    /// Those of `keep` that are assumptions of components.
    pub kept: Vec<(FormulaRef, usize)>,
    /// For each component represented by its table: the rules of the table (which are in `keep`),
    /// and rules that require the same only for inputs for which the table has a row.
    pub tables: Vec<Option<[[usize; 2]; 2]>>,
    /// Rules that hold even in a step with errors.
    pub last: Vec<usize>,
    /// For each component: those of `last` that say how it answers.
    answers: Vec<Vec<usize>>,
    /// For each component: those of `keep` that say how it answers and what it assumes.
    own: Vec<Vec<usize>>,
    /// Justice rules of the environment.
    pub environment_justice: Vec<usize>,
    /// Obligations of the components, in the order in which they are examined in a step.
    pub obligations: Vec<ScheduledObligation>,
    /// Justice rules of each component.
    pub justice: Vec<ComponentJustice>,
    /// Assumptions that are exported to the environment.
    pub exported: Vec<FormulaRef>,
    /// Formulas of the goal.
    pub goals: Vec<(FormulaRef, usize)>,
}

impl RuleSet {
    /// Builds all rules.
    pub fn new(closed: &ClosedComposition<'_>) -> Self {
        let mut book = Self {
            tables: vec![None; closed.participants.len()],
            answers: vec![Vec::new(); closed.participants.len()],
            own: vec![Vec::new(); closed.participants.len()],
            ..Self::default()
        };
        book.add_environment(closed);
        book.add_exported(closed);
        for component in 0..closed.participants.len() {
            match closed.participants[component].form {
                Form::Table => book.add_table(closed, component),
                Form::Contract => book.add_contract(closed, component),
            }
            for (at, formula) in closed.assumed(component) {
                if at.kind != FormulaKind::Justice {
                    let kept = book.add(rule(at.kind, &formula.expr));
                    book.keep.push(kept);
                    book.own[component].push(kept);
                    book.kept.push((at, kept));
                }
            }
        }
        book.add_obligations(closed);
        for (at, formula) in closed.claim.goals() {
            let rule = book.add(rule(at.kind, &formula.expr));
            book.goals.push((at, rule));
        }
        book
    }

    /// Adds a rule.
    pub fn add(&mut self, rule: Rule) -> usize {
        self.rules.push(rule);
        self.rules.len() - 1
    }

    fn add_condition(&mut self, condition: StepCondition) -> [usize; 2] {
        condition.rules().map(|rule| self.add(rule))
    }

    /// Adds a rule that holds in every step, with or without errors.
    fn add_always(&mut self, rule: Rule) -> usize {
        let number = self.add(rule);
        self.keep.push(number);
        self.last.push(number);
        number
    }

    /// Adds the givens, the definitions of monitors, and the watch on operations.
    fn add_environment(&mut self, closed: &ClosedComposition<'_>) {
        let given = &closed.claim.given;
        self.add_side(given);
        for formula in &given.justice {
            let rule = self.add(rule(FormulaKind::Justice, &formula.expr));
            self.environment_justice.push(rule);
        }
        for (index, component) in closed.system.components.iter().enumerate() {
            let participant = closed.participants.get(index);
            if participant.is_none_or(|t| t.form == Form::Contract) {
                self.add_side(&component.definitions);
            }
        }
        if let Some(watch) = &closed.watch {
            for rule in watch.rules(closed.machine) {
                self.add_always(rule);
            }
        }
    }

    fn add_side(&mut self, side: &Side) {
        for kind in FormulaKind::ALL
            .into_iter()
            .filter(|k| *k != FormulaKind::Justice)
        {
            for formula in side.list(kind) {
                self.add_always(rule(kind, &formula.expr));
            }
        }
    }

    /// Adds the exported assumptions, which the environment keeps.
    fn add_exported(&mut self, closed: &ClosedComposition<'_>) {
        for component in 0..closed.participants.len() {
            for (at, formula) in closed.assumed(component) {
                if !closed.is_exported(at.kind, formula) {
                    continue;
                }
                self.exported.push(at);
                if at.kind == FormulaKind::Justice {
                    let rule = self.add(rule(FormulaKind::Justice, &formula.expr));
                    self.environment_justice.push(rule);
                    continue;
                }
                let mut condition = in_step(at.kind, formula);
                if let Some(done) = closed.done() {
                    condition.later = done.clone().implies(condition.later);
                }
                let rules = self.add_condition(condition);
                self.last.extend(rules);
            }
        }
    }

    /// Adds a table. A row that matches the inputs is taken. If no row matches, which is possible
    /// only in a step with errors, anything can happen.
    fn add_table(&mut self, closed: &ClosedComposition<'_>, component: usize) {
        let Some(table) = closed.table(component) else {
            return;
        };
        if let Some(fixed_outputs) = table.fixed_outputs() {
            for rule in fixed_outputs.rules() {
                let rule = self.add_always(rule);
                self.own[component].push(rule);
            }
        }
        let transitions = table.transitions_taken();
        let strict = self.add_condition(transitions.clone());
        self.keep.extend(strict);
        self.own[component].extend(strict);
        let loose = self.add_condition(transitions.or(table.has_row().not()));
        self.last.extend(loose);
        self.answers[component].extend(loose);
        self.tables[component] = Some([strict, loose]);
        self.justice.push(ComponentJustice::default());
    }

    /// Adds a contract: its guarantees hold in every step without errors, and in a step with errors
    /// if its assumptions hold.
    fn add_contract(&mut self, closed: &ClosedComposition<'_>, component: usize) {
        let assumed = closed
            .assumed(component)
            .filter(|(at, _)| at.kind != FormulaKind::Justice);
        let (first, later) = assumed
            .map(|(at, formula)| in_step(at.kind, formula))
            .map(|condition| (condition.first, condition.later))
            .unzip();
        let (first, later) = (conjunction(first), conjunction(later));
        let guarantees = &closed.component(component).guarantees;
        for kind in FormulaKind::ALL
            .into_iter()
            .filter(|k| *k != FormulaKind::Justice)
        {
            for formula in guarantees.list(kind) {
                let kept = self.add(rule(kind, &formula.expr));
                self.keep.push(kept);
                self.own[component].push(kept);
                let condition = in_step(kind, formula);
                let loose = self.add_condition(StepCondition {
                    first: first.clone().implies(condition.first).simplify(),
                    later: later.clone().implies(condition.later).simplify(),
                });
                self.last.extend(loose);
                self.answers[component].extend(loose);
            }
        }
        let guaranteed = guarantees
            .justice
            .iter()
            .map(|f| self.add(rule(FormulaKind::Justice, &f.expr)));
        let guaranteed = guaranteed.collect();
        self.justice.push(ComponentJustice {
            guaranteed,
            assumed: Vec::new(),
        });
    }

    /// Adds the obligations of the components.
    fn add_obligations(&mut self, closed: &ClosedComposition<'_>) {
        let order = closed.order();
        for component in &order {
            if let Some(table) = closed.table(*component) {
                self.add_obligation(*component, StepObligation::HasOutputs, &table.has_outputs());
            }
        }
        for component in order {
            for (at, formula) in closed.assumed(component) {
                let exported = self.exported.contains(&at);
                if at.kind == FormulaKind::Justice {
                    if !exported {
                        let rule = self.add(rule(FormulaKind::Justice, &formula.expr));
                        self.justice[component].assumed.push((at, rule));
                    }
                    continue;
                }
                let mut condition = in_step(at.kind, formula);
                if exported {
                    condition.first = Expr::TRUE;
                    condition.later = match (&closed.claim.exports, closed.done()) {
                        (Exports::After(_), Some(done)) => done.clone().or(condition.later),
                        _ => Expr::TRUE,
                    };
                }
                self.add_obligation(component, StepObligation::Assumption(at), &condition);
            }
            if let Some(table) = closed.table(component) {
                self.add_obligation(component, StepObligation::HasRow, &table.has_row());
            }
        }
    }

    fn add_obligation(
        &mut self,
        component: usize,
        kind: StepObligation,
        condition: &StepCondition,
    ) {
        let condition = StepCondition {
            first: condition.first.simplify(),
            later: condition.later.simplify(),
        };
        let rules = self.add_condition(condition.clone());
        self.obligations.push(ScheduledObligation {
            component,
            kind,
            condition,
            rules,
        });
    }

    /// Adds rules that hold as long as all obligations are met, and returns their numbers.
    pub fn no_error(&mut self) -> [usize; 2] {
        self.all_met(|_| true)
    }

    /// Adds rules that hold as long as a component's obligations are met. Returns their numbers,
    /// and the rules of `last` without the answers of components that it does not wait for in a
    /// step.
    pub fn no_error_of(
        &mut self,
        closed: &ClosedComposition<'_>,
        component: usize,
    ) -> ([usize; 2], Vec<usize>) {
        let rules = self.all_met(|of| of == component);
        let mut waits_for = BTreeSet::new();
        let mut open = rules.to_vec();
        while let Some(rule) = open.pop() {
            for driver in self.drivers(closed, rule) {
                if driver != component && waits_for.insert(driver) {
                    open.extend(&self.answers[driver]);
                }
            }
        }
        (rules, only_of(&waits_for, &self.answers, &self.last))
    }

    /// Returns the rules of `keep` without those of components other than `near`. Every run that
    /// keeps `keep` keeps these rules, too.
    pub fn keep_of(&self, near: &BTreeSet<usize>) -> Vec<usize> {
        only_of(near, &self.own, &self.keep)
    }

    /// Returns the components that drive a variable which a component's own rules mention, and the
    /// component itself.
    pub fn neighbours(&self, closed: &ClosedComposition<'_>, component: usize) -> BTreeSet<usize> {
        let rules = self.own[component]
            .iter()
            .map(|rule| &self.rules[*rule].expr);
        let mut near = self.drivers_of(closed, rules);
        near.insert(component);
        near
    }

    /// Returns the components that drive a variable which one of these expressions mentions.
    pub fn drivers_of<'e>(
        &self,
        closed: &ClosedComposition<'_>,
        expressions: impl Iterator<Item = &'e Expr>,
    ) -> BTreeSet<usize> {
        let mut found = BTreeSet::new();
        for expr in expressions {
            expr.for_each_var(&mut |v, _| found.extend(closed.system.driver(v)));
        }
        // The system can have components without a controller, which only define monitors.
        found.retain(|driver| *driver < self.own.len());
        found
    }

    fn all_met(&mut self, of: impl Fn(usize) -> bool) -> [usize; 2] {
        let obligations = self.obligations.iter().filter(|o| of(o.component));
        let (first, later) = obligations
            .map(|o| (o.condition.first.clone(), o.condition.later.clone()))
            .unzip();
        self.add_condition(StepCondition {
            first: conjunction(first),
            later: conjunction(later),
        })
    }

    /// Returns the components that have to answer before the rule can be checked in a step. A table
    /// that answers first does not count: its outputs are those of its state.
    fn drivers(&self, closed: &ClosedComposition<'_>, rule: usize) -> BTreeSet<usize> {
        let Rule { kind, expr } = &self.rules[rule];
        let answers_late = |driver: &usize| {
            let table = closed.table(*driver);
            table.is_none_or(|table| table.machine.timing == Timing::Mealy)
        };
        let read = latest(expr, *kind).into_iter();
        read.filter_map(|v| closed.system.driver(v))
            // The system can have components without a controller, which only define monitors.
            .filter(|driver| *driver < self.answers.len() && answers_late(driver))
            .collect()
    }
}

impl ClosedComposition<'_> {
    /// Returns the table of a component, if it is represented by its table.
    pub(super) fn table(&self, component: usize) -> Option<Table<'_>> {
        let participant = &self.participants[component];
        Some(Table {
            machine: self.controllers[component].machine()?,
            bindings: &self.machine.components[component].bindings,
            first: participant.first,
            state: participant.state?,
            states: participant.states.as_ref()?,
        })
    }
}

/// Returns `rules` without those that belong to components other than these. `own` has the rules of
/// each component.
fn only_of(components: &BTreeSet<usize>, own: &[Vec<usize>], rules: &[usize]) -> Vec<usize> {
    let others: BTreeSet<usize> = own
        .iter()
        .enumerate()
        .filter(|(component, _)| !components.contains(component))
        .flat_map(|(_, rules)| rules.iter().copied())
        .collect();
    let left = rules.iter().filter(|rule| !others.contains(rule));
    left.copied().collect()
}

/// Returns the condition that a formula puts on step 0 and on later steps; always true for justice.
fn in_step(kind: FormulaKind, formula: &Formula) -> StepCondition {
    let expr = &formula.expr;
    match kind {
        FormulaKind::Initial => StepCondition {
            first: expr.clone(),
            later: Expr::TRUE,
        },
        FormulaKind::Invariant => StepCondition {
            first: expr.clone(),
            later: expr.substitute(&mut |v: VarId, _| Expr::Var(v, Time::Next)),
        },
        FormulaKind::Safety => StepCondition {
            first: Expr::TRUE,
            later: expr.clone(),
        },
        FormulaKind::Justice => StepCondition {
            first: Expr::TRUE,
            later: Expr::TRUE,
        },
    }
}
