//! The decision procedure for a closed composition.
//!
//! Safety is first decided for each component: can one of its obligations be broken in a step after
//! steps without errors, if the components that it does not wait for can do anything? If so, it is
//! decided as a whole: can any error occur? Only if one can, each obligation is examined
//! separately, in the order of a step. Justice is decided on the runs without errors.

use super::rules::{RuleSet, ScheduledObligation, StepObligation};
use super::table::conjunction;
use super::{
    ClosedComposition, DischargeMethod, FailureKind, Form, OperationFailure, StuckComponent,
    Verdict, replay,
};
use crate::machine::COMPLETES;
use crate::proof::{Open, Refutation};
use crate::replay::formula;
use crate::system::FormulaRef;
use linewright_core::gr1::{Expr, FormulaKind, VarId};
use linewright_core::source::Span;
use linewright_solver::game::{Lasso, Limit, Limits, Rule, RunQuery, Runs, SafetyViolationQuery};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum size of a composition in bits of state. Larger compositions would take too long; a proof
/// from contracts is possible without this decision.
const MAX_BITS: u32 = 90;

/// Returns the number of bits needed for this many values.
fn bits(values: u64) -> u32 {
    u64::BITS - values.saturating_sub(1).leading_zeros()
}

/// Decides all obligations of a closed composition.
pub(super) fn decide(closed: &ClosedComposition<'_>, limits: &Limits) -> Result<Verdict, Limit> {
    let mut book = RuleSet::new(closed);
    let no_error = book.no_error();
    let runs = runs(closed, &book, limits)?;
    let mut decider = ClosedDecider {
        closed,
        book,
        runs,
        reliable: BTreeSet::new(),
        first_call: None,
        verdict: Verdict::default(),
    };
    decider.safety(no_error)?;
    decider.justice()?;
    decider.goals()?;
    decider.operations()?;
    Ok(decider.verdict)
}

/// Counts the reachable states of a closed composition.
pub(super) fn count_states(closed: &ClosedComposition<'_>, limits: &Limits) -> Result<f64, Limit> {
    let book = RuleSet::new(closed);
    runs(closed, &book, limits)?.count_states(&book.keep)
}

fn runs(closed: &ClosedComposition<'_>, book: &RuleSet, limits: &Limits) -> Result<Runs, Limit> {
    let variables = &closed.system.variables;
    let bits = variables.iter().map(|v| bits(v.domain.size()));
    if bits.sum::<u32>() > MAX_BITS {
        return Err(Limit::Size);
    }
    Runs::new(variables, book.rules.clone(), limits)
}

struct ClosedDecider<'a> {
    closed: &'a ClosedComposition<'a>,
    book: RuleSet,
    runs: Runs,
    /// Components whose justice guarantees can be relied on.
    reliable: BTreeSet<usize>,
    /// Initial rule that gives the operation of the first call, one that can be the first.
    first_call: Option<usize>,
    verdict: Verdict,
}

impl ClosedDecider<'_> {
    fn add(&mut self, kind: FormulaKind, expr: Expr) -> usize {
        self.runs.add(Rule { kind, expr })
    }

    // ---- errors in a step -----------------------------------------------------------------------

    fn safety(&mut self, all: [usize; 2]) -> Result<(), Limit> {
        let (keep, last) = (self.book.keep.clone(), self.book.last.clone());
        let sound = self.is_sound_by_proof()
            || self.is_sound_by_component(&keep)?
            || !self.can_break(&keep, &last, &all)?;
        let obligations = std::mem::take(&mut self.book.obligations);
        for (place, obligation) in obligations.iter().enumerate() {
            let broken = if sound {
                None
            } else {
                self.broken(&obligations, place)?
            };
            self.conclude(obligation, broken);
        }
        self.book.obligations = obligations;
        Ok(())
    }

    /// Whether a step that keeps the rules `last`, after steps that keep the rules `before`, can
    /// break one of some rules.
    fn can_break(
        &mut self,
        before: &[usize],
        last: &[usize],
        rules: &[usize],
    ) -> Result<bool, Limit> {
        for &broken in rules {
            let query = SafetyViolationQuery {
                before: before.to_vec(),
                last: last.to_vec(),
                broken,
            };
            if self.runs.has_violation(&query)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether it is known that no error can occur: safety was proved from the contracts, and every
    /// component that answers first has outputs in all its states.
    fn is_sound_by_proof(&self) -> bool {
        let mut obligations = self.book.obligations.iter();
        self.closed.known.safety
            && obligations.all(|o| o.kind != StepObligation::HasOutputs || o.condition.is_true())
    }

    /// Whether each component's obligations are met even if the components that it does not wait
    /// for in a step can do anything. If so, no error can occur; if not, one might. This is far
    /// cheaper than all obligations at once, because each question involves few tables.
    fn is_sound_by_component(&mut self, keep: &[usize]) -> Result<bool, Limit> {
        for component in self.closed.order() {
            let (all, last) = self.book.no_error_of(self.closed, component);
            // A rule has the same number in both.
            for rule in &self.book.rules[self.runs.rules().len()..] {
                self.runs.add(rule.clone());
            }
            let neighbours = self.book.neighbours(self.closed, component);
            let mut attempts = vec![
                self.book.keep_of(&BTreeSet::from([component])),
                self.book.keep_of(&neighbours),
                keep.to_vec(),
            ];
            attempts.dedup();
            let mut can_break = true;
            for before in attempts {
                can_break = can_break && self.can_break(&before, &last, &all)?;
            }
            if can_break {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns a run whose last step violates the obligation at `place` and no earlier obligation.
    fn broken(
        &mut self,
        obligations: &[ScheduledObligation],
        place: usize,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let obligation = &obligations[place];
        if obligation.condition.is_true() {
            return Ok(None);
        }
        let mut last = self.book.last.clone();
        for earlier in &obligations[..place] {
            let before = earlier.component != obligation.component
                || earlier.kind == StepObligation::HasOutputs;
            if before || obligation.kind == StepObligation::HasRow {
                last.extend(earlier.rules);
            }
        }
        for rule in obligation.rules {
            if let Some(trace) = self.violation(last.clone(), rule)? {
                return Ok(Some(trace));
            }
        }
        Ok(None)
    }

    fn violation(
        &mut self,
        last: Vec<usize>,
        broken: usize,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.runs.find_violation(&SafetyViolationQuery {
            before: self.book.keep.clone(),
            last,
            broken,
        })
    }

    fn conclude(&mut self, obligation: &ScheduledObligation, broken: Option<Vec<Vec<i64>>>) {
        match (obligation.kind, broken) {
            // If a component has no outputs, no inputs keep its assumptions, so the assumptions are
            // not recorded as met.
            (StepObligation::Assumption(_), None) if self.is_silent(obligation.component) => {}
            (StepObligation::Assumption(at), None) => self.record_met(at),
            (StepObligation::Assumption(at), Some(trace)) => {
                self.record_open(at, Refutation::Trace(trace));
            }
            (StepObligation::HasOutputs | StepObligation::HasRow, None) => {}
            (StepObligation::HasOutputs | StepObligation::HasRow, Some(trace)) => {
                let stuck = StuckComponent {
                    component: obligation.component,
                    silent: obligation.kind == StepObligation::HasOutputs,
                    trace,
                };
                if self.is_real(replay::check_stuck(self.closed, &stuck)) {
                    self.verdict.stuck.push(stuck);
                }
            }
        }
    }

    fn is_silent(&self, component: usize) -> bool {
        let mut stuck = self.verdict.stuck.iter();
        stuck.any(|s| s.silent && s.component == component)
    }

    fn record_met(&mut self, at: FormulaRef) {
        let met = if self.book.exported.contains(&at) {
            DischargeMethod::Exported
        } else {
            DischargeMethod::Held
        };
        self.verdict.met.push((at, met));
    }

    /// Records that an obligation is not met, with a run as the counterexample. If the controllers
    /// cannot make the run, the obligation is recorded as undecided.
    fn record_open(&mut self, what: FormulaRef, why: Refutation) {
        let open = Open { what, why };
        if self.is_real(replay::check_open(self.closed, &open)) {
            self.verdict.open.push(open);
        } else {
            self.verdict.undecided.push(what);
        }
    }

    /// Returns whether the controllers can make the run that was found, given the result of its
    /// replay. The replay can only fail if a controller was represented by its contract.
    fn is_real(&self, played: Result<(), String>) -> bool {
        let exact = self
            .closed
            .participants
            .iter()
            .all(|t| t.form == Form::Table);
        match played {
            Ok(()) => true,
            Err(_) if !exact => false,
            Err(why) => {
                panic!(
                    "the counterexample that was found fails its replay: {why}; please report this"
                )
            }
        }
    }

    // ---- justice --------------------------------------------------------------------------------

    /// Decides the justice assumptions of components, in rounds: the justice guarantees of a
    /// contract are relied on once its justice assumptions are met.
    fn justice(&mut self) -> Result<(), Limit> {
        for at in self.book.exported.clone() {
            if at.kind == FormulaKind::Justice {
                self.record_met(at);
            }
        }
        let mut left: Vec<(FormulaRef, usize)> = Vec::new();
        let mut met: Vec<FormulaRef> = Vec::new();
        for (component, justice) in self.book.justice.iter().enumerate() {
            let (known, unknown): (Vec<_>, Vec<_>) = justice
                .assumed
                .iter()
                .partition(|(at, _)| self.closed.known.justice.contains(at));
            if unknown.is_empty() {
                self.reliable.insert(component);
            }
            left.extend(unknown);
            met.extend(known.into_iter().map(|(at, _)| at));
        }
        for at in met {
            self.record_met(at);
        }
        loop {
            let mut waiting = Vec::new();
            let before = left.len();
            for (at, rule) in left {
                match self.starved(rule)? {
                    None => self.record_met(at),
                    Some(lasso) => waiting.push((at, rule, lasso)),
                }
            }
            let waits = |c: &usize| waiting.iter().any(|(at, ..)| at.component == Some(*c));
            let components = 0..self.book.justice.len();
            let reliable: BTreeSet<usize> = components.filter(|c| !waits(c)).collect();
            let helps = reliable
                .difference(&self.reliable)
                .any(|c| !self.book.justice[*c].guaranteed.is_empty());
            self.reliable = reliable;
            if waiting.is_empty() || waiting.len() == before || !helps {
                for (at, _, lasso) in waiting {
                    self.record_open(at, Refutation::Lasso(lasso));
                }
                return Ok(());
            }
            left = waiting
                .into_iter()
                .map(|(at, rule, _)| (at, rule))
                .collect();
        }
    }

    /// Returns a run without errors on which a justice rule never holds from some step on.
    fn starved(&mut self, rule: usize) -> Result<Option<Lasso>, Limit> {
        let query = RunQuery {
            keep: self.book.keep.clone(),
            infinitely_often: self.reliable_justice(),
            finitely_often: vec![rule],
        };
        self.runs.find_lasso(&query)
    }

    /// Returns the justice rules that can be relied on.
    fn reliable_justice(&self) -> Vec<usize> {
        let guaranteed = self
            .reliable
            .iter()
            .flat_map(|c| &self.book.justice[*c].guaranteed);
        self.book
            .environment_justice
            .iter()
            .chain(guaranteed)
            .copied()
            .collect()
    }

    // ---- goals ----------------------------------------------------------------------------------

    fn goals(&mut self) -> Result<(), Limit> {
        let is_safe = self.is_sound_by_proof();
        for (at, rule) in self.book.goals.clone() {
            let is_justice = at.kind == FormulaKind::Justice;
            let is_known = if is_justice {
                self.closed.known.justice.contains(&at)
            } else {
                is_safe
            };
            let why = if is_known {
                None
            } else if is_justice {
                self.starved(rule)?.map(Refutation::Lasso)
            } else {
                let keep = self.book.keep.clone();
                self.violation(keep, rule)?.map(Refutation::Trace)
            };
            match why {
                None => self.record_met(at),
                Some(why) => self.record_open(at, why),
            }
        }
        Ok(())
    }

    // ---- operations -----------------------------------------------------------------------------

    fn operations(&mut self) -> Result<(), Limit> {
        let in_order = self.are_in_order()?;
        for operation in 0..self.closed.machine.operations.len() {
            if let Some(why) = self.operation(operation, in_order)? {
                let failure = OperationFailure { operation, why };
                if self.is_real(replay::check_operation_failure(self.closed, &failure)) {
                    self.verdict.operation_failures.push(failure);
                } else {
                    self.verdict.undecided_operations.push(operation);
                }
            }
        }
        Ok(())
    }

    /// Whether all operations run their actions in order: one question for all of them. Only if
    /// they do not, each is examined separately.
    fn are_in_order(&mut self) -> Result<bool, Limit> {
        let (machine, Some(watch)) = (self.closed.machine, &self.closed.watch) else {
            return Ok(true);
        };
        let operations = 0..machine.operations.len();
        let all = operations.map(|operation| watch.in_order(machine, operation));
        let all = conjunction(all.collect());
        if all == Expr::TRUE {
            return Ok(true);
        }
        // The components that begin the actions mostly see to their order on their own.
        let watched = watch.rules(machine).map(|rule| rule.expr);
        let beginning = watched.iter().chain([&all]);
        let beginning = self.book.drivers_of(self.closed, beginning);
        let near = self.book.keep_of(&beginning);
        let broken = self.add(FormulaKind::Invariant, all);
        for keep in [near, self.book.keep.clone()] {
            let query = SafetyViolationQuery {
                before: keep.clone(),
                last: keep,
                broken,
            };
            if !self.runs.has_violation(&query)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns how an operation fails. `in_order` states that all operations run their actions in
    /// order.
    fn operation(
        &mut self,
        operation: usize,
        in_order: bool,
    ) -> Result<Option<FailureKind>, Limit> {
        let (machine, Some(watch)) = (self.closed.machine, &self.closed.watch) else {
            return Ok(None);
        };
        let keep = self.book.keep.clone();
        let never = watch
            .never_begins(machine, operation)
            .map(|rule| self.runs.add(rule));
        if !self.can_begin(never)? {
            let by = self.forbidding(watch.operation, never)?;
            return Ok(Some(FailureKind::NeverBegins(by)));
        }
        if !in_order {
            let in_order = watch.in_order(machine, operation);
            let in_order = self.add(FormulaKind::Invariant, in_order);
            if let Some(trace) = self.violation(keep, in_order)? {
                return Ok(Some(FailureKind::Order(trace)));
            }
        }
        // If every request completes, each operation ends.
        let mut goals = self.closed.claim.goals();
        let completes = goals.find(|(_, f)| f.name == COMPLETES);
        if completes.is_some_and(|(at, _)| self.verdict.is_met(at).is_some()) {
            return Ok(None);
        }
        let done = machine.done.clone().unwrap_or(Expr::FALSE);
        let runs = watch.runs(machine, operation);
        let ends = self.add(FormulaKind::Justice, done.or(runs.not()).simplify());
        Ok(self.starved(ends)?.map(FailureKind::Endless))
    }

    /// Whether an operation can begin, so that one of the two rules of `never_begins` can be
    /// broken.
    fn can_begin(&mut self, [first, later]: [usize; 2]) -> Result<bool, Limit> {
        let keep = self.book.keep.clone();
        if self.can_break(&keep, &keep, &[first])? {
            if self.first_call.is_none() {
                let Rule { kind, expr } = self.runs.rules()[first].clone();
                self.first_call = Some(self.add(kind, expr.not().simplify()));
            }
            return Ok(true);
        }
        // Mostly, an operation can follow that of the first call, and if this is given, far fewer
        // states have to be explored.
        if let Some(given) = self.first_call {
            let keep = [&keep[..], &[given]].concat();
            if self.can_break(&keep, &keep, &[later])? {
                return Ok(true);
            }
        }
        self.can_break(&keep, &keep, &[later])
    }

    /// Returns the assumptions that prevent an operation from beginning: each assumption without
    /// which it could begin or, if there is no such assumption, all assumptions that mention the
    /// requested operation. Of formulas generated from the same source formula, only the first is
    /// returned.
    fn forbidding(
        &mut self,
        operation: Option<VarId>,
        never: [usize; 2],
    ) -> Result<Vec<FormulaRef>, Limit> {
        let mut groups: BTreeMap<(usize, Span), Vec<(FormulaRef, usize)>> = BTreeMap::new();
        for (at, rule) in &self.book.kept {
            let component = at.component.unwrap_or_default();
            let formula = formula(&self.closed.system, &self.closed.claim, *at);
            let group = groups.entry((component, formula.span));
            group.or_default().push((*at, *rule));
        }
        let (mut single, mut speaking) = (Vec::new(), Vec::new());
        for ((component, _), group) in &groups {
            let first = group[0].0;
            let mut left_out: Vec<usize> = group.iter().map(|(_, rule)| *rule).collect();
            let mut keep = self.book.keep.clone();
            if let Some([strict, loose]) = self.book.tables[*component] {
                // Without its assumptions, a table needs rules that allow inputs for which it has
                // no row.
                left_out.extend(strict);
                keep.extend(loose);
            }
            keep.retain(|rule| !left_out.contains(rule));
            if self.can_break(&keep, &keep, &never)? {
                single.push(first);
            }
            let mut speaks = false;
            for (_, rule) in group {
                let expr = self.runs.rules()[*rule].expr.clone().simplify();
                expr.for_each_var(&mut |v, _| speaks |= Some(v) == operation);
            }
            if speaks {
                speaking.push(first);
            }
        }
        Ok(if single.is_empty() { speaking } else { single })
    }
}
