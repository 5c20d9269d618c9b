//! Builds a claim by adding lemmas one at a time.

use super::parts::formula;
use super::vocabulary::Model;
use linewright_algebra::proof::{Claim, Reach};
use linewright_algebra::system::{ContractSide, FormulaRef, System};
use linewright_core::gr1::{Expr, FormulaKind};
use linewright_language::contract::line::Line;
use std::collections::BTreeSet;

/// A claim under construction.
pub(super) struct ClaimBuilder<'a> {
    pub(super) model: Model<'a>,
    pub(super) line: &'a Line,
    pub(super) system: &'a System,
    pub(super) claim: &'a mut Claim,
}

impl ClaimBuilder<'_> {
    /// Adds a lemma and returns its reference. The lemma is proved from the formulas in `from` or,
    /// if there are none, from the formulas close to it.
    pub(super) fn lemma(
        &mut self,
        place: usize,
        kind: FormulaKind,
        (name, text): (&str, &str),
        expr: &Expr,
        from: BTreeSet<FormulaRef>,
        reach: Reach,
    ) -> FormulaRef {
        let list = self.claim.goal.list_mut(kind);
        let at = FormulaRef {
            component: None,
            half: ContractSide::Guarantees,
            kind,
            index: list.len(),
        };
        let span = self.line.nodes[self.model.shape.places[place].node].span;
        list.push(formula(span, name, text, expr));
        self.claim.lemmas.insert(at, reach);
        if !from.is_empty() {
            self.claim.from.insert(at, from);
        }
        at
    }

    /// Adds formulas to try first in the proof of the goal called `name`.
    pub(super) fn rests_on(&mut self, name: &str, from: BTreeSet<FormulaRef>) {
        let found = self.claim.goals().find(|(_, f)| f.name == name);
        if let Some((at, _)) = found {
            self.claim.from.entry(at).or_default().extend(from);
        }
    }

    /// The goal `what` for a place, if there is one.
    pub(super) fn goal(&self, what: &str, place: usize) -> Option<FormulaRef> {
        let name = format!("{what}_at_{}", self.model.shape.places[place].name);
        let mut goals = self.claim.goals();
        goals.find(|(_, f)| f.name == name).map(|(at, _)| at)
    }

    /// Guarantees of a place.
    pub(super) fn guarantees(&self, place: usize) -> impl Iterator<Item = FormulaRef> {
        self.system.components[place]
            .guarantees
            .formulas()
            .map(move |(kind, index, _)| FormulaRef {
                component: Some(place),
                half: ContractSide::Guarantees,
                kind,
                index,
            })
    }

    /// The given formulas about a place: those that mention only its own variables and the
    /// environment variables in its contract.
    pub(super) fn given(&self, place: usize) -> Vec<FormulaRef> {
        let part = &self.system.components[place];
        let mut known: BTreeSet<_> = part.drives.iter().copied().collect();
        for (_, _, f) in part.guarantees.formulas() {
            f.expr.for_each_var(&mut |v, _| {
                if self.system.driver(v).is_none() {
                    known.insert(v);
                }
            });
        }
        let is_known = |expr: &Expr| {
            let mut all = true;
            expr.for_each_var(&mut |v, _| all &= known.contains(&v));
            all
        };
        self.claim
            .given
            .formulas()
            .filter(|(_, _, f)| is_known(&f.expr))
            .map(|(kind, index, _)| FormulaRef {
                component: None,
                half: ContractSide::Assumptions,
                kind,
                index,
            })
            .collect()
    }
}
