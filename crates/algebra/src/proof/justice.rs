//! Proof of the justice assumptions of components, in turns, to avoid circular reasoning.

use super::super::system::FormulaRef;
use super::loops::cycle_through;
use super::prover::{ALL, Prover, is_assumption, is_completion, is_given, is_guarantee};
use super::{Cycle, DischargeRule, Open, Refutation};
use linewright_core::gr1::FormulaKind;
use linewright_solver::game::{Lasso, Limit, RunQuery};
use std::collections::BTreeSet;

impl Prover<'_> {
    /// Proves the justice assumptions of components, in turns. Returns the components whose justice
    /// guarantees can be relied on afterwards.
    pub(super) fn prove_justice(&mut self) -> Result<BTreeSet<usize>, Limit> {
        let assumed = self.book.rules_where(|at| is_assumption(*at));
        let mut left: Vec<usize> = assumed;
        left.retain(|i| self.book.is_justice(*i));
        let mut turn = 0;
        let mut exported = false;
        loop {
            let reliable = self.reliable(&left);
            if left.is_empty() {
                return Ok(reliable);
            }
            let before = left.len();
            left = self.discharge_by_environment(&left)?;
            if left.len() == before {
                self.derive_completions(&reliable)?;
                left = self.discharge_by_justice(&left, &reliable, turn)?;
                turn += usize::from(left.len() < before);
            }
            if left.len() < before {
                continue;
            }
            if !exported {
                exported = true;
                let mut open = Vec::new();
                for rule in std::mem::take(&mut left) {
                    match self.export(rule)? {
                        Ok(by) => self.record_export(rule, &by),
                        Err(_) => open.push(rule),
                    }
                }
                left = open;
                continue;
            }
            for rule in &left {
                if let Some(lasso) = self.starving_run(*rule, &reliable)? {
                    let what = self.at(*rule);
                    let why = Refutation::Lasso(lasso);
                    self.proof.open.push(Open { what, why });
                }
            }
            self.proof.cycles = self.cycles(&left);
            return Ok(reliable);
        }
    }

    /// Discharges the justice assumptions that follow from formulas that the environment keeps;
    /// returns the others.
    fn discharge_by_environment(&mut self, left: &[usize]) -> Result<Vec<usize>, Limit> {
        let environments: Vec<usize> = self
            .reasons(&BTreeSet::new())
            .into_iter()
            .filter(|i| self.is_from_environment(*i))
            .collect();
        let mut waiting = Vec::new();
        for rule in left {
            let found = self.minimal(*rule, &environments, ALL, &mut |p, kept| {
                Ok(!p.is_starved(kept, *rule)?)
            })?;
            match found {
                Some(by) => {
                    self.record_with_justice(*rule, &by, 0);
                    self.met.push(*rule);
                }
                None => waiting.push(*rule),
            }
        }
        Ok(waiting)
    }

    /// Derives the completions of components in `reliable`, each from its own component's contract
    /// alone: a contract that fixes every step need not state that requests are completed, and
    /// others can rest on it all the same.
    pub(super) fn derive_completions(&mut self, reliable: &BTreeSet<usize>) -> Result<(), Limit> {
        for rule in self.book.rules_where(|at| is_completion(*at)) {
            let component = self.component_of(rule);
            if !reliable.contains(&component) || !self.examined.insert(rule) {
                continue;
            }
            let is_own = |at: &FormulaRef| at.component == Some(component) && !is_completion(*at);
            let own = self.book.rules_where(is_own);
            if !self.is_starved(&own, rule)? {
                self.derived.push(rule);
            }
        }
        Ok(())
    }

    /// Discharges one justice assumption with the guarantees of the components in `reliable`,
    /// preferably an assumption that mentions few components. Returns the assumptions that are
    /// left.
    fn discharge_by_justice(
        &mut self,
        left: &[usize],
        reliable: &BTreeSet<usize>,
        turn: usize,
    ) -> Result<Vec<usize>, Limit> {
        let components = |rule: &usize| {
            let drivers = self.book.entries[*rule]
                .mentions
                .iter()
                .filter_map(|v| self.book.system.driver(*v));
            drivers.collect::<BTreeSet<usize>>().len()
        };
        let mut order = left.to_vec();
        order.sort_by_key(components);
        for rule in order {
            for rings in self.attempts() {
                if let Some(by) = self.minimal_for_justice(rule, reliable, *rings)? {
                    self.record_with_justice(rule, &by, turn);
                    self.met.push(rule);
                    return Ok(left.iter().copied().filter(|i| *i != rule).collect());
                }
            }
        }
        Ok(left.to_vec())
    }

    /// Returns the numbers of rings of rules in the attempts to discharge an assumption. A quick
    /// proof tries near rules first: whether they suffice is found far sooner than whether all
    /// rules do, and they mostly suffice. Otherwise, [`Self::minimal`] goes from ring to ring
    /// anyway.
    fn attempts(&self) -> &'static [usize] {
        if self.minimal { &[ALL] } else { &[1, 2, ALL] }
    }

    /// Records a discharge whose formulas can include justice.
    pub(super) fn record_with_justice(&mut self, rule: usize, by: &[usize], turn: usize) {
        let environments = by.iter().all(|i| self.is_from_environment(*i));
        let kind = match (environments, by.iter().any(|i| self.book.is_justice(*i))) {
            (true, _) => DischargeRule::Environment,
            (false, false) => DischargeRule::Induction,
            (false, true) => DischargeRule::Justice { turn },
        };
        self.record(rule, kind, by);
    }

    /// Returns the components that have no justice assumption in `left`.
    fn reliable(&self, left: &[usize]) -> BTreeSet<usize> {
        let waiting: BTreeSet<usize> = left.iter().map(|i| self.component_of(*i)).collect();
        (0..self.book.system.components.len())
            .filter(|p| !waiting.contains(p))
            .collect()
    }

    /// Returns the rules that justice can rest on: the hypotheses, justice of the environment and
    /// of the components in `reliable`, discharged justice assumptions, and proved justice of the
    /// goal.
    pub(super) fn reasons(&self, reliable: &BTreeSet<usize>) -> Vec<usize> {
        let mut found = self.hypotheses();
        found.extend(self.book.rules_where(|at| {
            at.kind == FormulaKind::Justice
                && (is_given(*at)
                    || (is_guarantee(*at) && at.component.is_some_and(|p| reliable.contains(&p))))
        }));
        found.extend(self.exported.iter().filter(|i| self.book.is_justice(**i)));
        found.extend(&self.met);
        let is_reliable = |i: &&usize| reliable.contains(&self.component_of(**i));
        found.extend(self.derived.iter().filter(is_reliable));
        found.sort_unstable();
        found.dedup();
        let is_there = |i: &&usize| !self.is_lemma(**i) || self.is_common_lemma(**i);
        let shown = self.shown.iter().filter(is_there);
        found.extend(shown.filter(|i| self.book.is_justice(**i)));
        found
    }

    pub(super) fn minimal_for_justice(
        &mut self,
        rule: usize,
        reliable: &BTreeSet<usize>,
        rings: usize,
    ) -> Result<Option<Vec<usize>>, Limit> {
        let mut holds = |p: &mut Self, kept: &[usize]| Ok(!p.is_starved(kept, rule)?);
        let candidates = self.reasons(reliable);
        if let Some(sources) = self.sources(rule, &candidates) {
            let found = self.minimal(rule, &sources, ALL, &mut holds)?;
            if found.is_some() || self.is_lemma(rule) {
                return Ok(found);
            }
        }
        if let Some(by) = self.minimal(rule, &candidates, rings, &mut holds)? {
            return Ok(Some(by));
        }
        if rings != ALL {
            return Ok(None);
        }
        let all = self.with_assumptions(candidates);
        if holds(self, &all)? {
            return self.minimize(&all, &mut holds).map(Some);
        }
        Ok(None)
    }

    /// Returns a run that keeps all rules that can be relied on, and on which a justice rule never
    /// holds from some step on.
    pub(super) fn starving_run(
        &mut self,
        rule: usize,
        reliable: &BTreeSet<usize>,
    ) -> Result<Option<Lasso>, Limit> {
        let all = self.with_assumptions(self.reasons(reliable));
        self.starved(&all, rule)
    }

    fn starved(&mut self, kept: &[usize], rule: usize) -> Result<Option<Lasso>, Limit> {
        let wanted = self.run_query(kept, &[rule]);
        self.book.runs.find_lasso(&RunQuery {
            finitely_often: vec![rule],
            ..wanted
        })
    }

    fn is_starved(&mut self, kept: &[usize], rule: usize) -> Result<bool, Limit> {
        let wanted = self.run_query(kept, &[rule]);
        self.book.runs.has_lasso(&RunQuery {
            finitely_often: vec![rule],
            ..wanted
        })
    }

    /// Returns the query for runs that keep the rules `kept`, including the definitions of the
    /// monitors that `kept` and `others` mention.
    pub(super) fn run_query(&self, kept: &[usize], others: &[usize]) -> RunQuery {
        let all = kept.iter().chain(others).copied();
        let mut keep = self.book.definitions(all);
        let (again, safe): (Vec<usize>, Vec<usize>) =
            kept.iter().copied().partition(|i| self.book.is_justice(*i));
        keep.extend(safe);
        RunQuery {
            keep,
            infinitely_often: again,
            finitely_often: Vec::new(),
        }
    }

    /// Returns cycles among the open justice assumptions. An assumption waits for the assumptions
    /// of the components that set its variables.
    fn cycles(&self, left: &[usize]) -> Vec<Cycle> {
        let waits_for = |a: usize| -> BTreeSet<usize> {
            let own = self.component_of(a);
            let drivers = self.book.entries[a].mentions.iter();
            let drivers: BTreeSet<usize> = drivers
                .filter_map(|v| self.book.system.driver(*v))
                .filter(|p| *p != own)
                .collect();
            (0..left.len())
                .filter(|i| drivers.contains(&self.component_of(left[*i])))
                .collect()
        };
        let edges: Vec<BTreeSet<usize>> = left.iter().map(|a| waits_for(*a)).collect();
        let mut shown: BTreeSet<usize> = BTreeSet::new();
        let mut cycles = Vec::new();
        for start in 0..left.len() {
            if shown.contains(&start) {
                continue;
            }
            if let Some(way) = cycle_through(|i: usize| edges[i].iter().copied().collect(), start) {
                shown.extend(&way);
                cycles.push(Cycle {
                    assumptions: way.into_iter().map(|i| self.at(left[i])).collect(),
                });
            }
        }
        cycles
    }
}
