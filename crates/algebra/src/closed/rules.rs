//! All givens and all proof obligations of a closed composition, as numbered rules.

use super::table::{Both, Table, any, conjunction};
use super::{Closed, Form};
use crate::proof::Exports;
use crate::system::{FormulaRef, KINDS, list, rule};
use linewright_core::gr1::{Expr, Formula, Side, Time, VarId};
use linewright_solver::game::{Rule, RuleKind};

/// An obligation of a component before it answers or advances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepObligation {
    /// It answers first, and has an answer.
    Speaks,
    /// One of its assumptions is kept.
    Assumed(FormulaRef),
    /// It has an answer to its inputs.
    Covered,
}

/// A duty at its position in the order of a step.
#[derive(Debug, Clone)]
pub(super) struct ScheduledObligation {
    /// Index of the component.
    pub component: usize,
    /// Kind of duty.
    pub duty: StepObligation,
    /// Condition under which it is met.
    pub both: Both,
    /// The same condition as rules.
    pub rules: [usize; 2],
}

/// Justice of a component.
#[derive(Debug, Clone, Default)]
pub(super) struct ComponentJustice {
    /// Assumed justice, without exported assumptions.
    pub assumed: Vec<(FormulaRef, usize)>,
    /// Guaranteed justice of its contract, if it is used as its contract.
    pub guaranteed: Vec<usize>,
}

/// All rules, grouped by use.
#[derive(Debug, Default)]
pub(super) struct RuleSet {
    /// The rules.
    pub rules: Vec<Rule>,
    /// Rules kept in every step without errors.
    pub keep: Vec<usize>,
    /// Those of `keep` that are assumptions of components.
    pub kept: Vec<(FormulaRef, usize)>,
    /// By component: the rules of its table (in `keep`), and the same where the table has a row for
    /// its inputs. `None` for one used as its contract.
    pub tables: Vec<Option<[[usize; 2]; 2]>>,
    /// Rules kept in a step even if there are errors in it.
    pub last: Vec<usize>,
    /// Justice of the environment.
    pub again: Vec<usize>,
    /// Duties of components, in the order of a step.
    pub owed: Vec<ScheduledObligation>,
    /// Justice by component.
    pub justice: Vec<ComponentJustice>,
    /// Assumptions that are handed on.
    pub exported: Vec<FormulaRef>,
    /// Formulas that the components must keep together.
    pub goals: Vec<(FormulaRef, usize)>,
}

impl RuleSet {
    /// Builds all rules.
    pub fn new(closed: &Closed<'_>) -> Self {
        let mut book = Self {
            tables: vec![None; closed.taking.len()],
            ..Self::default()
        };
        book.surroundings(closed);
        book.handed_on(closed);
        for component in 0..closed.taking.len() {
            match closed.taking[component].form {
                Form::Table => book.table(closed, component),
                Form::Contract => book.contract(closed, component),
            }
            for (at, formula) in closed.assumed(component) {
                if at.kind != RuleKind::Justice {
                    let kept = book.add(rule(at.kind, &formula.expr));
                    book.keep.push(kept);
                    book.kept.push((at, kept));
                }
            }
        }
        book.duties(closed);
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

    fn add_both(&mut self, both: Both) -> [usize; 2] {
        both.rules().map(|rule| self.add(rule))
    }

    /// Adds a rule for every step, with or without errors.
    fn always(&mut self, rule: Rule) {
        let number = self.add(rule);
        self.keep.push(number);
        self.last.push(number);
    }

    /// Adds the givens, the definitions of monitors, and the watch on operations.
    fn surroundings(&mut self, closed: &Closed<'_>) {
        let given = &closed.claim.given;
        self.side(given);
        for formula in &given.justice {
            let rule = self.add(rule(RuleKind::Justice, &formula.expr));
            self.again.push(rule);
        }
        for (index, part) in closed.system.parts.iter().enumerate() {
            let taking = closed.taking.get(index);
            if taking.is_none_or(|t| t.form == Form::Contract) {
                self.side(&part.definitions);
            }
        }
        if let Some(watch) = &closed.watch {
            for rule in watch.rules(closed.machine) {
                self.always(rule);
            }
        }
    }

    fn side(&mut self, side: &Side) {
        for kind in KINDS.into_iter().filter(|k| *k != RuleKind::Justice) {
            for formula in list(side, kind) {
                self.always(rule(kind, &formula.expr));
            }
        }
    }

    /// Adds the environment's share of the components' assumptions.
    fn handed_on(&mut self, closed: &Closed<'_>) {
        for component in 0..closed.taking.len() {
            for (at, formula) in closed.assumed(component) {
                if !closed.is_exported(at.kind, formula) {
                    continue;
                }
                self.exported.push(at);
                if at.kind == RuleKind::Justice {
                    let rule = self.add(rule(RuleKind::Justice, &formula.expr));
                    self.again.push(rule);
                    continue;
                }
                let mut both = in_step(at.kind, formula);
                if let Some(done) = closed.done() {
                    both.later = done.clone().implies(both.later);
                }
                let rules = self.add_both(both);
                self.last.extend(rules);
            }
        }
    }

    /// Adds a table: it follows its rows; if no row matches the inputs, anything may follow.
    fn table(&mut self, closed: &Closed<'_>, component: usize) {
        let Some(table) = closed.table(component) else {
            return;
        };
        if let Some(spoken) = table.spoken() {
            for rule in spoken.rules() {
                self.always(rule);
            }
        }
        let moves = table.moves();
        let strict = self.add_both(moves.clone());
        self.keep.extend(strict);
        let loose = self.add_both(moves.or(table.covers().not()));
        self.last.extend(loose);
        self.tables[component] = Some([strict, loose]);
        self.justice.push(ComponentJustice::default());
    }

    /// Adds a contract: it keeps its guarantees in a step in which its assumptions are kept.
    fn contract(&mut self, closed: &Closed<'_>, component: usize) {
        let assumed = closed
            .assumed(component)
            .filter(|(at, _)| at.kind != RuleKind::Justice);
        let (first, later) = assumed
            .map(|(at, formula)| in_step(at.kind, formula))
            .map(|both| (both.first, both.later))
            .unzip();
        let (first, later) = (conjunction(first), conjunction(later));
        let guarantees = &closed.part(component).guarantees;
        for kind in KINDS.into_iter().filter(|k| *k != RuleKind::Justice) {
            for formula in list(guarantees, kind) {
                let kept = self.add(rule(kind, &formula.expr));
                self.keep.push(kept);
                let both = in_step(kind, formula);
                let loose = self.add_both(Both {
                    first: first.clone().implies(both.first).simplify(),
                    later: later.clone().implies(both.later).simplify(),
                });
                self.last.extend(loose);
            }
        }
        let guaranteed = guarantees
            .justice
            .iter()
            .map(|f| self.add(rule(RuleKind::Justice, &f.expr)));
        let guaranteed = guaranteed.collect();
        self.justice.push(ComponentJustice {
            guaranteed,
            assumed: Vec::new(),
        });
    }

    /// Adds the duties of components.
    fn duties(&mut self, closed: &Closed<'_>) {
        let order = closed.order();
        for component in &order {
            if let Some(table) = closed.table(*component) {
                self.owe(*component, StepObligation::Speaks, &table.speaks());
            }
        }
        for component in order {
            for (at, formula) in closed.assumed(component) {
                let exported = self.exported.contains(&at);
                if at.kind == RuleKind::Justice {
                    if !exported {
                        let rule = self.add(rule(RuleKind::Justice, &formula.expr));
                        self.justice[component].assumed.push((at, rule));
                    }
                    continue;
                }
                let mut both = in_step(at.kind, formula);
                if exported {
                    both.first = Expr::TRUE;
                    both.later = match (&closed.claim.exports, closed.done()) {
                        (Exports::After(_), Some(done)) => done.clone().or(both.later),
                        _ => Expr::TRUE,
                    };
                }
                self.owe(component, StepObligation::Assumed(at), &both);
            }
            if let Some(table) = closed.table(component) {
                self.owe(component, StepObligation::Covered, &table.covers());
            }
        }
    }

    fn owe(&mut self, component: usize, duty: StepObligation, both: &Both) {
        let both = Both {
            first: both.first.simplify(),
            later: both.later.simplify(),
        };
        let rules = self.add_both(both.clone());
        self.owed.push(ScheduledObligation {
            component,
            duty,
            both,
            rules,
        });
    }

    /// Returns rules that hold as long as no duty is broken.
    pub fn all_owed(&mut self) -> [usize; 2] {
        let broken = self.owed.iter().filter(|o| !o.both.is_true());
        let (first, later) = broken
            .map(|o| o.both.clone().not())
            .map(|both| (both.first, both.later))
            .unzip();
        let all = Both {
            first: any(first),
            later: any(later),
        };
        self.add_both(all.not())
    }
}

impl Closed<'_> {
    /// Returns the table of a component, if it is used as its table.
    pub(super) fn table(&self, component: usize) -> Option<Table<'_>> {
        let taking = &self.taking[component];
        Some(Table {
            machine: self.controllers[component].machine()?,
            bindings: &self.machine.components[component].bindings,
            first: taking.first,
            state: taking.state?,
            states: taking.states.as_ref()?,
        })
    }
}

/// Returns what a formula requires of step 0, and of a step after another.
fn in_step(kind: RuleKind, formula: &Formula) -> Both {
    let expr = &formula.expr;
    match kind {
        RuleKind::Initial => Both {
            first: expr.clone(),
            later: Expr::TRUE,
        },
        RuleKind::Invariant => Both {
            first: expr.clone(),
            later: expr.substitute(&mut |v: VarId, _| Expr::Var(v, Time::Next)),
        },
        RuleKind::Safety => Both {
            first: Expr::TRUE,
            later: expr.clone(),
        },
        RuleKind::Justice => Both {
            first: Expr::TRUE,
            later: Expr::TRUE,
        },
    }
}
