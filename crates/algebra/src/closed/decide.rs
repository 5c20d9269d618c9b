//! The questions about a closed composition.
//!
//! Safety is asked in one query: is there a step, after steps without errors, in which any error
//! occurs? Only then is each duty asked separately, in the order of a step. Justice is asked about
//! the runs without errors.

use super::rules::{RuleSet, ScheduledObligation, StepObligation};
use super::{
    Closed, DischargeMethod, FailureKind, Form, OperationFailure, StuckComponent, Verdict, replay,
};
use crate::machine::COMPLETES;
use crate::proof::{Exports, Open, Refutation};
use crate::replay::formula;
use crate::system::FormulaRef;
use linewright_core::gr1::{Expr, Time, VarId};
use linewright_core::source::Span;
use linewright_solver::game::{
    Lasso, Limit, Limits, Rule, RuleKind, RunQuery, Runs, SafetyViolationQuery,
};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum size of a composition in bits. The cost of larger ones grows too fast; a proof from
/// contracts does not need them.
const MOST_BITS: u32 = 90;

/// Returns the number of bits needed for this many values.
fn bits(values: u64) -> u32 {
    u64::BITS - values.saturating_sub(1).leading_zeros()
}

/// Decides the whole claim.
pub(super) fn decide(closed: &Closed<'_>, limits: &Limits) -> Result<Verdict, Limit> {
    let mut book = RuleSet::new(closed);
    let all_owed = book.all_owed();
    let bits = closed
        .system
        .variables
        .iter()
        .map(|v| bits(v.domain.size()));
    if bits.sum::<u32>() > MOST_BITS {
        return Err(Limit::Size);
    }
    let runs = Runs::new(&closed.system.variables, book.rules.clone(), limits)?;
    let mut asked = Asked {
        closed,
        book,
        runs,
        reliable: BTreeSet::new(),
        verdict: Verdict::default(),
    };
    asked.safety(all_owed)?;
    asked.justice()?;
    asked.goals()?;
    asked.operations()?;
    asked.verdict.states = asked.runs.count(&asked.book.keep)?;
    Ok(asked.verdict)
}

struct Asked<'a> {
    closed: &'a Closed<'a>,
    book: RuleSet,
    runs: Runs,
    /// Components used as contracts whose justice can be relied on.
    reliable: BTreeSet<usize>,
    verdict: Verdict,
}

impl Asked<'_> {
    fn add(&mut self, kind: RuleKind, expr: Expr) -> usize {
        self.runs.add(Rule { kind, expr })
    }

    // ---- errors in a step -----------------------------------------------------------------------

    fn safety(&mut self, all: [usize; 2]) -> Result<(), Limit> {
        let mut sound = true;
        for broken in all {
            let last = self.book.last.clone();
            sound &= self.slip(last, broken)?.is_none();
        }
        let owed = std::mem::take(&mut self.book.owed);
        for (place, duty) in owed.iter().enumerate() {
            let broken = if sound {
                None
            } else {
                self.broken(&owed, place)?
            };
            self.conclude(duty, broken);
        }
        self.book.owed = owed;
        Ok(())
    }

    /// Returns a run up to a step in which this duty is the first not to be met.
    fn broken(
        &mut self,
        owed: &[ScheduledObligation],
        place: usize,
    ) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        let duty = &owed[place];
        if duty.both.is_true() {
            return Ok(None);
        }
        let mut last = self.book.last.clone();
        for earlier in &owed[..place] {
            let before =
                earlier.component != duty.component || earlier.duty == StepObligation::Speaks;
            if before || duty.duty == StepObligation::Covered {
                last.extend(earlier.rules);
            }
        }
        for rule in duty.rules {
            if let Some(trace) = self.slip(last.clone(), rule)? {
                return Ok(Some(trace));
            }
        }
        Ok(None)
    }

    fn slip(&mut self, last: Vec<usize>, broken: usize) -> Result<Option<Vec<Vec<i64>>>, Limit> {
        self.runs.step(&SafetyViolationQuery {
            before: self.book.keep.clone(),
            last,
            broken,
        })
    }

    fn conclude(&mut self, owed: &ScheduledObligation, broken: Option<Vec<Vec<i64>>>) {
        match (owed.duty, broken) {
            // The assumptions of a component without outputs are not met in the step in which it
            // has none.
            (StepObligation::Assumed(_), None) if self.is_silent(owed.component) => {}
            (StepObligation::Assumed(at), None) => self.met(at),
            (StepObligation::Assumed(at), Some(trace)) => self.open(at, Refutation::Trace(trace)),
            (StepObligation::Speaks | StepObligation::Covered, None) => {}
            (StepObligation::Speaks | StepObligation::Covered, Some(trace)) => {
                let stuck = StuckComponent {
                    component: owed.component,
                    silent: owed.duty == StepObligation::Speaks,
                    trace,
                };
                if self.is_real(replay::stuck(self.closed, &stuck)) {
                    self.verdict.stuck.push(stuck);
                }
            }
        }
    }

    fn is_silent(&self, component: usize) -> bool {
        let mut stuck = self.verdict.stuck.iter();
        stuck.any(|s| s.silent && s.component == component)
    }

    fn met(&mut self, at: FormulaRef) {
        let met = if self.book.exported.contains(&at) {
            DischargeMethod::Exported
        } else {
            DischargeMethod::Held
        };
        self.verdict.met.push((at, met));
    }

    /// Records that something is not met, as a run shows.
    fn open(&mut self, what: FormulaRef, why: Refutation) {
        let open = Open { what, why };
        if self.is_real(replay::open(self.closed, &open)) {
            self.verdict.open.push(open);
        } else {
            self.verdict.undecided.push(what);
        }
    }

    /// Returns whether the controllers can make the run that was found. They may not if one of them
    /// was used as its contract.
    fn is_real(&self, played: Result<(), String>) -> bool {
        let exact = self.closed.taking.iter().all(|t| t.form == Form::Table);
        match played {
            Ok(()) => true,
            Err(_) if !exact => false,
            Err(why) => panic!("a run that the tables do not make: {why}; please report this"),
        }
    }

    // ---- justice --------------------------------------------------------------------------------

    /// Decides the justice that components assume, turn by turn: a contract's own justice is relied
    /// on once its assumed justice is met.
    fn justice(&mut self) -> Result<(), Limit> {
        for at in self.book.exported.clone() {
            if at.kind == RuleKind::Justice {
                self.met(at);
            }
        }
        let mut left: Vec<(FormulaRef, usize)> = Vec::new();
        for (component, again) in self.book.justice.iter().enumerate() {
            left.extend(&again.assumed);
            if again.assumed.is_empty() {
                self.reliable.insert(component);
            }
        }
        loop {
            let mut waiting = Vec::new();
            let before = left.len();
            for (at, rule) in left {
                match self.starved(rule)? {
                    None => self.met(at),
                    Some(lasso) => waiting.push((at, rule, lasso)),
                }
            }
            let waits = |c: &usize| waiting.iter().any(|(at, ..)| at.part == Some(*c));
            let components = 0..self.book.justice.len();
            let reliable: BTreeSet<usize> = components.filter(|c| !waits(c)).collect();
            let helps = reliable
                .difference(&self.reliable)
                .any(|c| !self.book.justice[*c].guaranteed.is_empty());
            self.reliable = reliable;
            if waiting.is_empty() || waiting.len() == before || !helps {
                for (at, _, lasso) in waiting {
                    self.open(at, Refutation::Lasso(lasso));
                }
                return Ok(());
            }
            left = waiting
                .into_iter()
                .map(|(at, rule, _)| (at, rule))
                .collect();
        }
    }

    /// Returns a run without errors on which, from some step on, a justice is never met.
    fn starved(&mut self, rule: usize) -> Result<Option<Lasso>, Limit> {
        let wanted = RunQuery {
            keep: self.book.keep.clone(),
            again: self.again(),
            never_again: vec![rule],
        };
        self.runs.lasso(&wanted)
    }

    /// Returns the justice that can be relied on.
    fn again(&self) -> Vec<usize> {
        let owed = self
            .reliable
            .iter()
            .flat_map(|c| &self.book.justice[*c].guaranteed);
        self.book.again.iter().chain(owed).copied().collect()
    }

    // ---- goals ----------------------------------------------------------------------------------

    fn goals(&mut self) -> Result<(), Limit> {
        for (at, rule) in self.book.goals.clone() {
            if at.kind == RuleKind::Justice {
                match self.starved(rule)? {
                    None => self.met(at),
                    Some(lasso) => self.open(at, Refutation::Lasso(lasso)),
                }
                continue;
            }
            match self.slip(self.book.keep.clone(), rule)? {
                Some(trace) if self.goes_on(rule)? => self.open(at, Refutation::Trace(trace)),
                _ => self.met(at),
            }
        }
        Ok(())
    }

    /// Returns whether a broken rule counts. For a refined contract only infinite runs count, so a
    /// step does not count if it leads to a state in which the assumed environment cannot go on.
    fn goes_on(&mut self, rule: usize) -> Result<bool, Limit> {
        let Some(slipped) = self
            .closed
            .slipped
            .filter(|_| self.closed.claim.exports == Exports::Never)
        else {
            return Ok(true);
        };
        let Rule { kind, expr } = self.runs.rules()[rule].clone();
        let (first, later) = match kind {
            RuleKind::Initial => (expr.not(), Expr::FALSE),
            RuleKind::Safety | RuleKind::Justice => (Expr::FALSE, expr.not()),
            RuleKind::Invariant => {
                let next = expr.substitute(&mut |v, _| Expr::Var(v, Time::Next));
                (expr.not(), next.not())
            }
        };
        let start = self.add(RuleKind::Initial, Expr::now(slipped).equals(first));
        let on = Expr::next(slipped).equals(Expr::now(slipped).or(later));
        let on = self.add(RuleKind::Safety, on);
        let seen = self.add(RuleKind::Justice, Expr::now(slipped));
        let mut wanted = RunQuery {
            keep: self.book.keep.clone(),
            again: self.again(),
            never_again: Vec::new(),
        };
        wanted.keep.extend([start, on]);
        wanted.again.push(seen);
        Ok(self.runs.lasso(&wanted)?.is_some())
    }

    // ---- operations -----------------------------------------------------------------------------

    fn operations(&mut self) -> Result<(), Limit> {
        for operation in 0..self.closed.machine.operations.len() {
            if let Some(why) = self.operation(operation)? {
                let misrun = OperationFailure { operation, why };
                if self.is_real(replay::misrun(self.closed, &misrun)) {
                    self.verdict.misruns.push(misrun);
                } else {
                    self.verdict.unclear.push(operation);
                }
            }
        }
        Ok(())
    }

    fn operation(&mut self, operation: usize) -> Result<Option<FailureKind>, Limit> {
        let (machine, Some(watch)) = (self.closed.machine, &self.closed.watch) else {
            return Ok(None);
        };
        let keep = self.book.keep.clone();
        let never = watch
            .never_begins(machine, operation)
            .map(|rule| self.runs.add(rule));
        if !self.begins(&keep, never)? {
            let by = self.forbidding(watch.operation, never)?;
            return Ok(Some(FailureKind::NeverBegins(by)));
        }
        let in_order = watch.in_order(machine, operation);
        let in_order = self.add(RuleKind::Invariant, in_order);
        if let Some(trace) = self.slip(keep, in_order)? {
            return Ok(Some(FailureKind::Order(trace)));
        }
        // If all requests complete, so does each operation.
        let mut goals = self.closed.claim.goals();
        let completes = goals.find(|(_, f)| f.name == COMPLETES);
        if completes.is_some_and(|(at, _)| self.verdict.is_met(at).is_some()) {
            return Ok(None);
        }
        let done = machine.done.clone().unwrap_or(Expr::FALSE);
        let runs = watch.runs(machine, operation);
        let ends = self.add(RuleKind::Justice, done.or(runs.not()).simplify());
        Ok(self.starved(ends)?.map(FailureKind::Endless))
    }

    /// Returns whether some call that keeps these rules breaks one of the two rules of
    /// [`never_begins`](super::watch::Watch::never_begins).
    fn begins(&mut self, keep: &[usize], never: [usize; 2]) -> Result<bool, Limit> {
        for broken in never {
            let slip = SafetyViolationQuery {
                before: keep.to_vec(),
                last: keep.to_vec(),
                broken,
            };
            if self.runs.step(&slip)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns what keeps an operation from ever beginning: the assumptions without one of which it
    /// could begin or, if no single one suffices, all that mention the requested operation. Of
    /// formulas made from the same source, only the first is returned.
    fn forbidding(
        &mut self,
        asked: Option<VarId>,
        never: [usize; 2],
    ) -> Result<Vec<FormulaRef>, Limit> {
        let mut groups: BTreeMap<(usize, Span), Vec<(FormulaRef, usize)>> = BTreeMap::new();
        for (at, rule) in &self.book.kept {
            let component = at.part.unwrap_or_default();
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
                // A table has no row for inputs that its assumptions exclude.
                left_out.extend(strict);
                keep.extend(loose);
            }
            keep.retain(|rule| !left_out.contains(rule));
            if self.begins(&keep, never)? {
                single.push(first);
            }
            let mut speaks = false;
            for (_, rule) in group {
                let expr = self.runs.rules()[*rule].expr.clone().simplify();
                expr.for_each_var(&mut |v, _| speaks |= Some(v) == asked);
            }
            if speaks {
                speaking.push(first);
            }
        }
        Ok(if single.is_empty() { speaking } else { single })
    }
}
