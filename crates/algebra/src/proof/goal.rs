//! The goal that the parts have to keep together, once all assumptions are met.

use super::super::system::FormulaRef;
use super::prover::{ALL, ObligationResult, Prover, is_goal};
use super::{DischargeRule, Open, Reach, Refutation};
use linewright_core::gr1::{Expr, Time};
use linewright_solver::game::{Lasso, Limit, Rule, RuleKind};
use std::collections::{BTreeSet, VecDeque};

/// Numbers of rings tried for near rules, in this order.
const NEAR: [usize; 3] = [1, 2, 3];

impl<'a> Prover<'a> {
    /// Proves the goal. Justice of the goal that was already shown may be used for other justice:
    /// it holds on all runs, and so a proof may go place by place where proving all at once would
    /// be too expensive.
    pub(super) fn goal(&mut self, reliable: &BTreeSet<usize>) -> Result<(), Limit> {
        // After all assumptions.
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
        let goals = self.book.numbers(|at| is_goal(*at));
        let (justice, safety): (Vec<usize>, Vec<usize>) =
            goals.into_iter().partition(|i| self.book.is_justice(*i));
        let (mut lemmas, mut goals): (Vec<usize>, Vec<usize>) =
            safety.into_iter().partition(|i| self.is_lemma(*i));
        // Formulas with few variables first: lemmas rest on them, and those with many on lemmas.
        goals.sort_by_key(|i| self.book.entries[*i].mentions.len());
        for (place, rule) in goals.iter().copied().enumerate() {
            self.ready_lemmas(&mut lemmas, &goals[place..], turns)?;
            if self.claim.known.contains(&self.at(rule)) {
                self.shown.push(rule);
                self.kept.insert(rule);
                continue;
            }
            let found = match self.step_minimal(rule, None, ALL)? {
                Some(by) => {
                    self.kept.insert(rule);
                    ObligationResult::Follows(by)
                }
                None if self.stepwise => self.step_of_goal(rule)?,
                None => self.fairly(rule, reliable)?,
            };
            match found {
                ObligationResult::Follows(by) => self.show(rule, &by, turns),
                ObligationResult::Fails(why) => self.open(rule, why),
            }
        }
        self.ready_lemmas(&mut lemmas, &[], turns)?;
        self.again_and_again(justice, reliable, turns)?;
        self.leave_out_idle_lemmas();
        Ok(())
    }

    /// Proves safety lemmas as soon as all their sources were tried. `left` are the goals not tried
    /// yet.
    fn ready_lemmas(
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
            if let Some(by) = self.step_minimal(rule, None, ALL)? {
                self.kept.insert(rule);
                self.show(rule, &by, turns);
            }
        }
        Ok(())
    }

    /// Proves justice of the goal: first everything that follows from near rules; then, while some
    /// are left, one of the others from all rules, which may make more provable nearby. Lemmas are
    /// only tried with near rules.
    fn again_and_again(
        &mut self,
        mut left: Vec<usize>,
        reliable: &BTreeSet<usize>,
        turn: usize,
    ) -> Result<(), Limit> {
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
                        self.again_minimal(rule, reliable, rings)?
                    };
                    match found {
                        Some(by) => {
                            self.show(rule, &by, turn);
                            // With it, others may follow from fewer rules.
                            if far > 0 {
                                left = waiting.into();
                                continue 'again;
                            }
                        }
                        // Tried last next time.
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
            match self.again_minimal(rule, reliable, ALL)? {
                Some(by) => self.show(rule, &by, turn),
                None => match self.never_again(rule, reliable)? {
                    Some(lasso) => self.open(rule, Refutation::Lasso(lasso)),
                    None => unreachable!("what follows was found; please report this"),
                },
            }
        }
    }

    /// Returns the number of rules near a goal; a goal with many is the most decisive.
    fn neighbours(&self, rule: usize) -> usize {
        let rings = self.book.rings(&[rule], &self.hypotheses());
        rings.iter().take(2).map(Vec::len).sum()
    }

    pub(super) fn is_lemma(&self, rule: usize) -> bool {
        let at = self.book.entries[rule].at;
        at.is_some_and(|at| self.claim.lemmas.contains_key(&at))
    }

    /// Returns whether the rule is a lemma that all may rest on.
    pub(super) fn is_common_lemma(&self, rule: usize) -> bool {
        let at = self.book.entries[rule].at;
        at.is_some_and(|at| self.claim.lemmas.get(&at) == Some(&Reach::Near))
    }

    /// Returns the formulas from which a formula is tried to be shown first.
    fn from(&self, rule: usize) -> Option<&'a BTreeSet<FormulaRef>> {
        self.claim.from.get(&self.book.entries[rule].at?)
    }

    /// Returns the rules from which a formula is tried to be shown first, if specified. `others`
    /// are rules outside the goal that may be relied on.
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

    /// Removes lemmas that nothing else rests on from the result.
    fn leave_out_idle_lemmas(&mut self) {
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

    /// Records that a formula of the goal was shown: not before turn `first`, and after all
    /// formulas of the goal that it rests on.
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
        self.record_again(rule, by, turn);
        self.shown.push(rule);
    }

    fn open(&mut self, rule: usize, why: Refutation) {
        let what = self.at(rule);
        self.proof.open.push(Open { what, why });
    }

    /// Tries safety of the goal with everything kept so far.
    fn step_of_goal(&mut self, rule: usize) -> Result<ObligationResult, Limit> {
        let mut all = self.with_assumptions(self.hypotheses());
        if self.book.rule(rule).kind == RuleKind::Initial {
            let first = [RuleKind::Initial, RuleKind::Invariant];
            all.retain(|i| first.contains(&self.book.rule(*i).kind));
        }
        if let Some(trace) = self.step(&all, rule, None)? {
            return Ok(ObligationResult::Fails(Refutation::Trace(trace)));
        }
        let mut holds = |p: &mut Self, kept: &[usize]| p.step_holds(kept, rule, None);
        Ok(ObligationResult::Follows(self.fewest(&all, &mut holds)?))
    }

    /// Tries safety of the goal again, on infinite runs only: a step to a state where no run
    /// continues breaks nothing.
    fn fairly(
        &mut self,
        rule: usize,
        reliable: &BTreeSet<usize>,
    ) -> Result<ObligationResult, Limit> {
        let slipped = self.book.slipped;
        let Rule { kind, expr } = self.book.rule(rule).clone();
        let first = match kind {
            RuleKind::Safety | RuleKind::Justice => Expr::FALSE,
            RuleKind::Initial | RuleKind::Invariant => expr.clone().not(),
        };
        let later = match kind {
            RuleKind::Initial | RuleKind::Justice => Expr::FALSE,
            RuleKind::Invariant => {
                let next = expr.substitute(&mut |v, _| Expr::Var(v, Time::Next));
                next.not()
            }
            RuleKind::Safety => expr.clone().not(),
        };
        let start = self.book.add(Rule {
            kind: RuleKind::Initial,
            expr: Expr::now(slipped).equals(first),
        });
        let on = self.book.add(Rule {
            kind: RuleKind::Safety,
            expr: Expr::next(slipped).equals(Expr::now(slipped).or(later)),
        });
        let seen = self.book.add(Rule {
            kind: RuleKind::Justice,
            expr: Expr::now(slipped),
        });
        let candidates = self.with_assumptions(self.reasons(reliable));
        let slips = |p: &mut Self, kept: &[usize]| -> Result<Option<Lasso>, Limit> {
            let mut wanted = p.wanted(kept, &[rule]);
            wanted.keep.extend([start, on]);
            wanted.again.push(seen);
            p.book.runs.lasso(&wanted)
        };
        match slips(self, &candidates)? {
            None => {
                let mut holds = |p: &mut Self, kept: &[usize]| Ok(slips(p, kept)?.is_none());
                Ok(ObligationResult::Follows(
                    self.fewest(&candidates, &mut holds)?,
                ))
            }
            Some(lasso) => {
                let mut steps = [lasso.prefix, lasso.cycle].concat();
                let first = steps.iter().position(|s| s[slipped.index()] != 0);
                steps.truncate(first.map_or(steps.len(), |i| i + 1));
                Ok(ObligationResult::Fails(Refutation::Trace(steps)))
            }
        }
    }
}
