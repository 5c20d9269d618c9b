//! Proof of the goal that the components together have to keep, after the proof of their
//! assumptions.

use super::super::system::FormulaRef;
use super::prover::{ALL, ObligationResult, Prover, is_goal};
use super::{DischargeRule, Open, Reach, Refutation};
use linewright_core::gr1::{Expr, FormulaKind, Time};
use linewright_solver::game::{Lasso, Limit, Rule};
use std::collections::{BTreeSet, VecDeque};

/// Maximum numbers of rings in the attempts to prove justice from near rules, in this order.
const NEAR: [usize; 3] = [1, 2, 3];

impl<'a> Prover<'a> {
    /// Proves the goal. Justice of the goal can rest on other justice of the goal that is already
    /// proved, because the latter holds on all runs. So a proof can proceed in small steps where a
    /// single step would be too expensive.
    pub(super) fn prove_goal(&mut self, reliable: &BTreeSet<usize>) -> Result<(), Limit> {
        // The goal is proved in the turns after all assumptions.
        let turns = self
            .proof
            .discharges
            .iter()
            .map(|d| match d.rule {
                DischargeRule::Justice { turn } => turn + 1,
                _ => 0,
            })
            .max();
        let turns = turns.unwrap_or(0);
        let goals = self.book.rules_where(|at| is_goal(*at));
        let (justice, safety): (Vec<usize>, Vec<usize>) =
            goals.into_iter().partition(|i| self.book.is_justice(*i));
        let (mut lemmas, mut goals): (Vec<usize>, Vec<usize>) =
            safety.into_iter().partition(|i| self.is_lemma(*i));
        // Formulas with few variables come first: lemmas rest on them, and formulas with many
        // variables rest on lemmas.
        goals.sort_by_key(|i| self.book.entries[*i].mentions.len());
        for (place, rule) in goals.iter().copied().enumerate() {
            self.prove_ready_lemmas(&mut lemmas, &goals[place..], turns)?;
            if self.claim.known.contains(&self.at(rule)) {
                self.shown.push(rule);
                self.kept.insert(rule);
                continue;
            }
            let found = match self.minimal_for_step(rule, None, ALL)? {
                Some(by) => {
                    self.kept.insert(rule);
                    ObligationResult::Follows(by)
                }
                None if self.stepwise => self.step_of_goal(rule)?,
                None => self.step_of_infinite_runs(rule, reliable)?,
            };
            match found {
                ObligationResult::Follows(by) => self.show(rule, &by, turns),
                ObligationResult::Fails(why) => self.record_open(rule, why),
            }
        }
        self.prove_ready_lemmas(&mut lemmas, &[], turns)?;
        self.prove_justice_goals(justice, reliable, turns)?;
        self.remove_unused_lemmas();
        Ok(())
    }

    /// Proves the safety lemmas whose sources were all tried. `left` are the goals that were not
    /// tried yet.
    fn prove_ready_lemmas(
        &mut self,
        lemmas: &mut Vec<usize>,
        left: &[usize],
        turns: usize,
    ) -> Result<(), Limit> {
        let is_ready = |p: &Self, lemmas: &[usize], rule: usize| {
            let from = p.from(rule);
            let mut waiting = left.iter().chain(lemmas);
            !waiting.any(|i| from.is_some_and(|from| from.contains(&p.at(*i))))
        };
        while let Some(place) = (0..lemmas.len()).find(|i| is_ready(self, lemmas, lemmas[*i])) {
            let rule = lemmas.remove(place);
            if let Some(by) = self.minimal_for_step(rule, None, ALL)? {
                self.kept.insert(rule);
                self.show(rule, &by, turns);
            }
        }
        Ok(())
    }

    /// Proves justice of the goal. First, all formulas that follow from near rules are proved. If
    /// formulas are left, one of them is proved from all rules; then others might follow from near
    /// rules, so the search starts again. Lemmas are only tried with near rules.
    fn prove_justice_goals(
        &mut self,
        mut left: Vec<usize>,
        reliable: &BTreeSet<usize>,
        turn: usize,
    ) -> Result<(), Limit> {
        if !left.is_empty() {
            self.derive_completions(reliable)?;
        }
        'again: loop {
            for (far, rings) in NEAR.into_iter().enumerate() {
                let mut waiting = VecDeque::from(std::mem::take(&mut left));
                let mut tried = waiting.len();
                while tried > 0 {
                    tried -= 1;
                    let Some(rule) = waiting.pop_front() else {
                        break;
                    };
                    // A lemma with fixed sources has the same candidates for all rings.
                    let asked = far > 0 && self.is_lemma(rule) && self.from(rule).is_some();
                    let found = if asked {
                        None
                    } else {
                        self.minimal_for_justice(rule, reliable, rings)?
                    };
                    match found {
                        Some(by) => {
                            self.show(rule, &by, turn);
                            // With this formula proved, others might follow from nearer rules.
                            if far > 0 {
                                left = waiting.into();
                                continue 'again;
                            }
                        }
                        // The formula is tried last in the next round.
                        None => waiting.push_back(rule),
                    }
                }
                left = waiting.into();
            }
            let goals = left.iter().rev().filter(|i| !self.is_lemma(**i));
            let Some(&rule) = goals.max_by_key(|i| self.neighbours(**i)) else {
                return Ok(());
            };
            left.retain(|other| *other != rule);
            match self.minimal_for_justice(rule, reliable, ALL)? {
                Some(by) => self.show(rule, &by, turn),
                None => match self.starving_run(rule, reliable)? {
                    Some(lasso) => self.record_open(rule, Refutation::Lasso(lasso)),
                    None => unreachable!(
                        "neither a proof nor a counterexample was found; please report this"
                    ),
                },
            }
        }
    }

    /// Returns the number of rules near a goal. A goal with many of them is proved first, because
    /// its proof is likely to help most.
    fn neighbours(&self, rule: usize) -> usize {
        let rings = self.book.rings(&[rule], &self.hypotheses());
        rings.iter().take(2).map(Vec::len).sum()
    }

    pub(super) fn is_lemma(&self, rule: usize) -> bool {
        let at = self.book.entries[rule].at;
        at.is_some_and(|at| self.claim.lemmas.contains_key(&at))
    }

    /// Returns whether the rule is a lemma that every formula can rest on.
    pub(super) fn is_common_lemma(&self, rule: usize) -> bool {
        let at = self.book.entries[rule].at;
        at.is_some_and(|at| self.claim.lemmas.get(&at) == Some(&Reach::Near))
    }

    /// Returns the formulas that the claim prescribes as sources of a formula.
    fn from(&self, rule: usize) -> Option<&'a BTreeSet<FormulaRef>> {
        self.claim.from.get(&self.book.entries[rule].at?)
    }

    /// Returns the rules from which the prover first tries to derive a formula, if the claim
    /// prescribes them. `others` are the rules outside the goal that can be relied on.
    pub(super) fn sources(&self, rule: usize, others: &[usize]) -> Option<Vec<usize>> {
        let from = self.from(rule)?;
        let again = self.book.is_justice(rule);
        let is_there = |i: &usize| match self.book.entries[*i].at {
            Some(at) if !from.contains(&at) => false,
            Some(at) if is_goal(at) && again => self.shown.contains(i),
            Some(at) if is_goal(at) => self.kept.contains(i),
            Some(_) => others.contains(i),
            None => false,
        };
        Some((0..self.book.entries.len()).filter(is_there).collect())
    }

    /// Removes from the result the lemmas on which nothing else rests.
    fn remove_unused_lemmas(&mut self) {
        loop {
            let discharges = &self.proof.discharges;
            let idle = discharges.iter().position(|d| {
                self.claim.lemmas.contains_key(&d.what)
                    && !discharges.iter().any(|other| other.by.contains(&d.what))
            });
            match idle {
                Some(place) => self.proof.discharges.remove(place),
                None => return,
            };
        }
    }

    /// Records that a formula of the goal was proved: in turn `first`, or in a later one so that it
    /// comes after all formulas of the goal that it rests on.
    fn show(&mut self, rule: usize, by: &[usize], first: usize) {
        let after: Vec<FormulaRef> = by
            .iter()
            .filter(|i| self.shown.contains(i))
            .map(|i| self.at(*i))
            .collect();
        let turns = self
            .proof
            .discharges
            .iter()
            .filter(|d| after.contains(&d.what))
            .filter_map(|d| match d.rule {
                DischargeRule::Justice { turn } => Some(turn + 1),
                _ => None,
            });
        let turn = turns.fold(first, usize::max);
        self.record_with_justice(rule, by, turn);
        self.shown.push(rule);
    }

    fn record_open(&mut self, rule: usize, why: Refutation) {
        let what = self.at(rule);
        self.proof.open.push(Open { what, why });
    }

    /// Tries to prove safety of the goal from all hypotheses and all safety assumptions.
    fn step_of_goal(&mut self, rule: usize) -> Result<ObligationResult, Limit> {
        let mut all = self.with_assumptions(self.hypotheses());
        if self.book.rule(rule).kind == FormulaKind::Initial {
            let first = [FormulaKind::Initial, FormulaKind::Invariant];
            all.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        if let Some(trace) = self.step(&all, rule, None)? {
            return Ok(ObligationResult::Fails(Refutation::Trace(trace)));
        }
        let mut holds = |p: &mut Self, kept: &[usize]| p.step_holds(kept, rule, None);
        Ok(ObligationResult::Follows(self.minimize(&all, &mut holds)?))
    }

    /// Tries to prove safety of the goal on infinite runs only: a violation does not count if it
    /// leads to a state from which no run continues.
    fn step_of_infinite_runs(
        &mut self,
        rule: usize,
        reliable: &BTreeSet<usize>,
    ) -> Result<ObligationResult, Limit> {
        let violated = self.book.violated;
        let Rule { kind, expr } = self.book.rule(rule).clone();
        let first = match kind {
            FormulaKind::Safety | FormulaKind::Justice => Expr::FALSE,
            FormulaKind::Initial | FormulaKind::Invariant => expr.clone().not(),
        };
        let later = match kind {
            FormulaKind::Initial | FormulaKind::Justice => Expr::FALSE,
            FormulaKind::Invariant => {
                let next = expr.substitute(&mut |v, _| Expr::Var(v, Time::Next));
                next.not()
            }
            FormulaKind::Safety => expr.clone().not(),
        };
        let start = self.book.add(Rule {
            kind: FormulaKind::Initial,
            expr: Expr::now(violated).equals(first),
        });
        let on = self.book.add(Rule {
            kind: FormulaKind::Safety,
            expr: Expr::next(violated).equals(Expr::now(violated).or(later)),
        });
        let seen = self.book.add(Rule {
            kind: FormulaKind::Justice,
            expr: Expr::now(violated),
        });
        let candidates = self.with_assumptions(self.reasons(reliable));
        let violation = |p: &mut Self, kept: &[usize]| -> Result<Option<Lasso>, Limit> {
            let mut wanted = p.run_query(kept, &[rule]);
            wanted.keep.extend([start, on]);
            wanted.infinitely_often.push(seen);
            p.book.runs.find_lasso(&wanted)
        };
        match violation(self, &candidates)? {
            None => {
                let mut holds = |p: &mut Self, kept: &[usize]| Ok(violation(p, kept)?.is_none());
                Ok(ObligationResult::Follows(
                    self.minimize(&candidates, &mut holds)?,
                ))
            }
            Some(lasso) => {
                let mut steps = [lasso.prefix, lasso.cycle].concat();
                let first = steps.iter().position(|s| s[violated.index()] != 0);
                steps.truncate(first.map_or(steps.len(), |i| i + 1));
                Ok(ObligationResult::Fails(Refutation::Trace(steps)))
            }
        }
    }
}
