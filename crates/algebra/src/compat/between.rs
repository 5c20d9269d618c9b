//! The game where Moore machines answer before the environment, and Mealy machines after it.
//!
//! A GR(1) game has two moves per step, and this one has three. But the last move of a step and the
//! first one of the next are both the parts': a late answer is revealed one step later, together
//! with the next early one. So conditions on a step are checked one step later, with copies of its
//! early values.

use super::{Game, of_last_step, unnamed};
use crate::proof::last_step;
use crate::system::{System, formulas};
use linewright_core::gr1::{Domain, Expr, Formula, Owner, Side, Specification, Timing, VarId};
use linewright_solver::game::RuleKind;
use std::collections::{BTreeMap, BTreeSet};

/// Translates conditions on a step to the step after it.
struct Delay<'s> {
    late: &'s dyn Fn(&VarId) -> bool,
    /// Whether there was no step before.
    first: VarId,
    /// Values of the step before that one, for variables that are not late.
    past: BTreeMap<VarId, VarId>,
}

impl Delay<'_> {
    /// Returns a formula about the last step. Its late values are known in the next state, or are
    /// in `copies`, as others may be.
    fn of(&self, kind: RuleKind, expr: &Expr, copies: &BTreeMap<VarId, VarId>) -> Expr {
        let expr = expr.substitute(&mut |v, time| {
            if kind == RuleKind::Justice || time != last_step(kind) {
                let known = Some(&v).filter(|v| (self.late)(v));
                return Expr::now(*known.or(self.past.get(&v)).unwrap_or(&v));
            }
            match copies.get(&v) {
                Some(copy) => Expr::now(*copy),
                None if (self.late)(&v) => Expr::next(v),
                None => Expr::now(v),
            }
        });
        match kind {
            RuleKind::Initial => Expr::now(self.first).implies(expr),
            RuleKind::Safety => Expr::now(self.first).or(expr),
            RuleKind::Invariant | RuleKind::Justice => expr,
        }
    }

    /// Returns everything that sides require of the last step, justice excluded.
    fn all<'f>(
        &self,
        sides: impl Iterator<Item = &'f Side>,
        copies: &BTreeMap<VarId, VarId>,
    ) -> Expr {
        let asked = sides.flat_map(formulas);
        let asked = asked.filter(|(kind, ..)| *kind != RuleKind::Justice);
        asked.fold(Expr::Const(1), |all, (kind, _, f)| {
            all.and(self.of(kind, &f.expr, copies))
        })
    }
}

/// Builds the game; `late` selects the variables set after those from outside.
pub(super) fn game(system: &System, late: &dyn Fn(&VarId) -> bool) -> Specification {
    let driven = |v: &VarId| system.driver(*v).is_some();
    let mut game = Game::new(system, Timing::Mealy, |v| !driven(v));
    let promised = || system.parts.iter().map(|p| &p.guarantees);
    let assumed = || system.parts.iter().map(|p| &p.assumptions);
    let defining = || system.parts.iter().map(|p| &p.definitions);

    let all = promised().chain(assumed()).chain(defining());
    let earlier: BTreeSet<VarId> = all
        .flat_map(of_the_step_before)
        .filter(|v| !late(v))
        .collect();
    let first = game.add(Owner::Environment, Domain::Bool);
    let past = game.copies(earlier, Owner::Environment);
    let delay = Delay { late, first, past };

    let named = promised().chain(defining()).flat_map(of_last_step);
    let named = named.filter(|v| late(v) || !driven(v)).collect();
    let allowed = game.copies(named, Owner::Environment);
    let answers = assumed().chain(defining()).flat_map(of_last_step);
    let answers = game.copies(answers.filter(late).collect(), Owner::System);
    let over = game.add(Owner::Environment, Domain::Bool);

    let none = BTreeMap::new();
    let kept = delay.all(promised(), &none);
    // Parts that name no way to make their early answer an allowed one give up, after the
    // conditions on the step before.
    let gone_on = delay.all(promised().chain(defining()), &allowed);
    let kept = gone_on.clone().and(kept);
    let mut rules = Side {
        initial: vec![unnamed(Expr::now(first)), unnamed(Expr::now(over).not())],
        invariants: Vec::new(),
        safety: vec![
            unnamed(Expr::next(first).not()),
            unnamed(Expr::next(over).equals(Expr::now(over).or(kept.not()))),
            unnamed(delay.all(defining(), &none)),
        ],
        justice: Vec::new(),
    };
    for (v, copy) in &delay.past {
        rules
            .safety
            .push(unnamed(Expr::next(*copy).equals(Expr::now(*v))));
    }
    for f in promised().flat_map(|side| &side.justice) {
        let expr = delay.of(RuleKind::Justice, &f.expr, &none);
        rules.justice.push(Formula { expr, ..f.clone() });
    }
    let answered = delay.all(defining(), &answers);
    let spared = Expr::now(over).or(gone_on.not());
    let mut guarantees = Side::default();
    for (kind, _, f) in assumed().flat_map(formulas) {
        let asked = delay.of(kind, &f.expr, &none);
        if kind == RuleKind::Justice {
            let expr = asked.or(Expr::now(over));
            guarantees.justice.push(Formula { expr, ..f.clone() });
            continue;
        }
        let with_answer = delay.of(kind, &f.expr, &answers).and(answered.clone());
        let expr = Expr::next(over)
            .or(asked)
            .and(spared.clone().or(with_answer));
        guarantees.safety.push(Formula { expr, ..f.clone() });
    }
    game.specification.assumptions = rules;
    game.specification.guarantees = guarantees;
    game.specification
}

/// Returns the variables whose values from an earlier step a side's formulas need when they are
/// checked one step late.
fn of_the_step_before(side: &Side) -> BTreeSet<VarId> {
    let mut found = BTreeSet::new();
    for (kind, _, f) in formulas(side) {
        f.expr.for_each_var(&mut |v, time| {
            if kind == RuleKind::Justice || time != last_step(kind) {
                found.insert(v);
            }
        });
    }
    found
}

/// Undoes the delay of a play's steps: late values are in the step after. The last step is dropped,
/// unless `next` follows it.
pub(super) fn undelayed(
    steps: &[Vec<i64>],
    next: Option<&Vec<i64>>,
    late: &dyn Fn(&VarId) -> bool,
) -> Vec<Vec<i64>> {
    let after = steps.iter().skip(1).chain(next);
    let joined = steps.iter().zip(after).map(|(step, after)| {
        let values = (0..).map(VarId).zip(step.iter().zip(after));
        values
            .map(|(v, (own, known))| if late(&v) { *known } else { *own })
            .collect()
    });
    joined.collect()
}
