//! The game in which Moore machines answer before the environment, and Mealy machines after it.
//!
//! A GR(1) game has two moves per step, and this game has three: the early answers (of the Moore
//! machines), the inputs, and the late answers (of the Mealy machines). The late answers of a step
//! and the early answers of the next step are both made by components, so they are merged into one
//! move. The values of a step are therefore complete only one step later. Conditions on the step
//! are checked then, with copies of its early values and inputs.
//!
//! Whoever leaves itself no allowed move has lost. The Moore machines lose before the environment
//! moves if their early answer breaks their own guarantees, whatever the others do. The Mealy
//! machines lose only after the environment's move, which therefore has to keep the assumptions.

use super::{Game, auxiliary, of_last_step};
use crate::proof::last_step;
use crate::system::System;
use linewright_core::gr1::{
    Domain, Expr, Formula, FormulaKind, Owner, Side, Specification, Timing, VarId,
};
use std::collections::{BTreeMap, BTreeSet};

/// Translates conditions on a step to conditions on the step after it.
struct Delay<'s> {
    late: &'s dyn Fn(&VarId) -> bool,
    /// Variable that is true in the first step only.
    first: VarId,
    /// Copies that store the values of the previous step, for variables that are not late.
    past: BTreeMap<VarId, VarId>,
}

impl Delay<'_> {
    /// Translates a formula. Values of the last step that it constrains are taken from `copies` if
    /// there is a copy; otherwise late values are those of the next state, where they are known.
    fn of(&self, kind: FormulaKind, expr: &Expr, copies: &BTreeMap<VarId, VarId>) -> Expr {
        let expr = expr.substitute(&mut |v, time| {
            if kind == FormulaKind::Justice || time != last_step(kind) {
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
            FormulaKind::Initial => Expr::now(self.first).implies(expr),
            FormulaKind::Safety => Expr::now(self.first).or(expr),
            FormulaKind::Invariant | FormulaKind::Justice => expr,
        }
    }

    /// Returns the translated conjunction of all formulas of some sides, without justice.
    fn all<'f>(
        &self,
        sides: impl Iterator<Item = &'f Side>,
        copies: &BTreeMap<VarId, VarId>,
    ) -> Expr {
        let asked = sides.flat_map(Side::formulas);
        let asked = asked.filter(|(kind, ..)| *kind != FormulaKind::Justice);
        asked.fold(Expr::Const(1), |all, (kind, _, f)| {
            all.and(self.of(kind, &f.expr, copies))
        })
    }
}

/// Builds the game; `late` is true for the variables that are set after the outside variables.
pub(super) fn game(system: &System, late: &dyn Fn(&VarId) -> bool) -> Specification {
    let driven = |v: &VarId| system.driver(*v).is_some();
    let mut game = Game::new(system, Timing::Mealy, |v| !driven(v));
    let guaranteed = || system.components.iter().map(|p| &p.guarantees);
    let moore = || {
        let early = system.components.iter();
        let early = early.filter(|p| p.timing == Timing::Moore);
        early.map(|p| &p.guarantees)
    };
    let assumed = || system.components.iter().map(|p| &p.assumptions);
    let defining = || system.components.iter().map(|p| &p.definitions);

    let all = guaranteed().chain(assumed()).chain(defining());
    let earlier: BTreeSet<VarId> = all
        .flat_map(of_the_step_before)
        .filter(|v| !late(v))
        .collect();
    let first = game.add(Owner::Environment, Domain::Bool);
    let past = game.copies(earlier, Owner::Environment);
    let delay = Delay { late, first, past };

    let named = moore().chain(defining()).flat_map(of_last_step);
    let named = named.filter(|v| late(v) || !driven(v)).collect();
    let allowed = game.copies(named, Owner::Environment);
    let answers = assumed().chain(defining()).flat_map(of_last_step);
    let answers = game.copies(answers.filter(late).collect(), Owner::System);
    let violated = game.add(Owner::Environment, Domain::Bool);

    let none = BTreeMap::new();
    let kept = delay.all(guaranteed(), &none);
    // The Moore machines lose before the environment moves if they cannot name values with which
    // their answer keeps their own guarantees. What the Mealy machines guarantee is no excuse for
    // the environment: they answer after it. The conditions on the step before are checked first.
    let has_allowed_answer = delay.all(moore().chain(defining()), &allowed);
    let kept = has_allowed_answer.clone().and(kept);
    let mut rules = Side {
        initial: vec![
            auxiliary(Expr::now(first)),
            auxiliary(Expr::now(violated).not()),
        ],
        invariants: Vec::new(),
        safety: vec![
            auxiliary(Expr::next(first).not()),
            auxiliary(Expr::next(violated).equals(Expr::now(violated).or(kept.not()))),
            auxiliary(delay.all(defining(), &none)),
        ],
        justice: Vec::new(),
    };
    for (v, copy) in &delay.past {
        rules
            .safety
            .push(auxiliary(Expr::next(*copy).equals(Expr::now(*v))));
    }
    for f in guaranteed().flat_map(|side| &side.justice) {
        let expr = delay.of(FormulaKind::Justice, &f.expr, &none);
        rules.justice.push(Formula { expr, ..f.clone() });
    }
    let answered = delay.all(defining(), &answers);
    let spared = Expr::now(violated).or(has_allowed_answer.not());
    let mut guarantees = Side::default();
    for (kind, _, f) in assumed().flat_map(Side::formulas) {
        let asked = delay.of(kind, &f.expr, &none);
        if kind == FormulaKind::Justice {
            let expr = asked.or(Expr::now(violated));
            guarantees.justice.push(Formula { expr, ..f.clone() });
            continue;
        }
        let with_answer = delay.of(kind, &f.expr, &answers).and(answered.clone());
        let expr = Expr::next(violated)
            .or(asked)
            .and(spared.clone().or(with_answer));
        guarantees.safety.push(Formula { expr, ..f.clone() });
    }
    game.specification.assumptions = rules;
    game.specification.guarantees = guarantees;
    game.specification
}

/// Returns the variables whose values of an earlier step are needed to check a side's formulas one
/// step late.
fn of_the_step_before(side: &Side) -> BTreeSet<VarId> {
    let mut found = BTreeSet::new();
    for (kind, _, f) in side.formulas() {
        f.expr.for_each_var(&mut |v, time| {
            if kind == FormulaKind::Justice || time != last_step(kind) {
                found.insert(v);
            }
        });
    }
    found
}

/// Undoes the delay of a play: takes the late values of each step from the step after it. The last
/// step is dropped unless `next` is given as the step after it.
pub(super) fn undo_delay(
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
