//! Progression: the obligation that remains of a formula after a step.

use super::formula::{Formula, Formulas, Node};
use crate::antichain::Antichain;
use crate::bound::BoundExceeded;
use std::collections::BTreeMap;

/// Obligation on the following steps.
pub(super) type Condition = Antichain<Node>;

/// Meaning of a condition's sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// All elements of at least one set have to hold.
    Terms,
    /// At least one element of every set has to hold.
    Clauses,
}

pub(super) struct Progression<'f> {
    formulas: &'f Formulas,
    reading: Reading,
    /// Maximum number of sets in a condition.
    max_sets: usize,
    known: BTreeMap<(Node, u32), Condition>,
}

impl<'f> Progression<'f> {
    pub fn new(formulas: &'f Formulas, reading: Reading, max_sets: usize) -> Self {
        Self {
            formulas,
            reading,
            max_sets,
            known: BTreeMap::new(),
        }
    }

    pub fn constant(&self, value: bool) -> Condition {
        if value == (self.reading == Reading::Terms) {
            Condition::unit()
        } else {
            Condition::none()
        }
    }

    fn bounded(&self, condition: Condition) -> Result<Condition, BoundExceeded> {
        if condition.len() > self.max_sets {
            return Err(BoundExceeded::Count {
                what: "alternatives in a state",
                limit: self.max_sets,
            });
        }
        Ok(condition)
    }

    fn combine(&self, and: bool, a: &Condition, b: &Condition) -> Result<Condition, BoundExceeded> {
        self.bounded(if and == (self.reading == Reading::Terms) {
            a.product(b)
        } else {
            a.union(b)
        })
    }

    /// Returns the conjunction (if `and`) or disjunction of the conditions that `of` returns for
    /// the formulas in `list`.
    fn combine_list(
        &mut self,
        and: bool,
        list: &[Node],
        of: impl Fn(&mut Self, Node) -> Result<Condition, BoundExceeded>,
    ) -> Result<Condition, BoundExceeded> {
        let mut found = self.constant(and);
        for node in list {
            let part = of(self, *node)?;
            found = self.combine(and, &found, &part)?;
        }
        Ok(found)
    }

    /// Returns a formula as a condition on the following steps.
    pub fn as_condition(&mut self, node: Node) -> Result<Condition, BoundExceeded> {
        let formulas = self.formulas;
        match formulas.formula(node) {
            Formula::Constant(value) => Ok(self.constant(*value)),
            Formula::And(list) => self.combine_list(true, list, Self::as_condition),
            Formula::Or(list) => self.combine_list(false, list, Self::as_condition),
            _ => Ok(Condition::of(node)),
        }
    }

    /// Returns the obligation that remains of a formula after a step. The bits of `letter` are the
    /// atoms that hold in the step.
    fn progress(&mut self, node: Node, letter: u32) -> Result<Condition, BoundExceeded> {
        if let Some(known) = self.known.get(&(node, letter)) {
            return Ok(known.clone());
        }
        let itself = Condition::of(node);
        let formulas = self.formulas;
        let found = match formulas.formula(node) {
            Formula::Constant(value) => self.constant(*value),
            Formula::Atom(atom, value) => self.constant((letter >> atom & 1 == 1) == *value),
            Formula::And(list) => self.combine_list(true, list, |s, a| s.progress(a, letter))?,
            Formula::Or(list) => self.combine_list(false, list, |s, a| s.progress(a, letter))?,
            Formula::Next(a) => self.as_condition(*a)?,
            Formula::Until(a, b) | Formula::Weak(a, b) => {
                let on = self.progress(*a, letter)?;
                let on = self.combine(true, &on, &itself)?;
                let end = self.progress(*b, letter)?;
                self.combine(false, &end, &on)?
            }
            Formula::Release(a, b) => {
                let on = self.progress(*a, letter)?;
                let on = self.combine(false, &on, &itself)?;
                let kept = self.progress(*b, letter)?;
                self.combine(true, &kept, &on)?
            }
        };
        self.known.insert((node, letter), found.clone());
        Ok(found)
    }

    /// Returns the obligation that remains of a condition after a step, with `letter` as in
    /// [`progress`](Self::progress).
    pub fn progress_condition(
        &mut self,
        condition: &Condition,
        letter: u32,
    ) -> Result<Condition, BoundExceeded> {
        // For terms, `product` is "and" and `union` is "or". For clauses it is the reverse, which
        // is also right, since the sets are then a conjunction of disjunctions.
        let mut found = Condition::none();
        for set in condition.sets() {
            let mut left = Condition::unit();
            for node in set {
                let part = self.progress(*node, letter)?;
                left = self.bounded(left.product(&part))?;
                if left.is_empty() {
                    break;
                }
            }
            found = self.bounded(found.union(&left))?;
        }
        Ok(found)
    }
}
