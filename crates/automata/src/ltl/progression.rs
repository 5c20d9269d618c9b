//! Progression: what remains of a formula after a step.

use super::formula::{Formula, Formulas, Node};
use crate::antichain::Antichain;
use crate::bound::BoundExceeded;
use std::collections::BTreeMap;

/// Obligation from the next step on.
pub(super) type Condition = Antichain<Node>;

/// Reading of a condition's sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// All elements of at least one set.
    Terms,
    /// At least one element of every set.
    Clauses,
}

pub(super) struct Progression<'f> {
    formulas: &'f Formulas,
    reading: Reading,
    /// Maximum number of sets in a condition.
    most: usize,
    known: BTreeMap<(Node, u32), Condition>,
}

impl<'f> Progression<'f> {
    pub fn new(formulas: &'f Formulas, reading: Reading, most: usize) -> Self {
        Self {
            formulas,
            reading,
            most,
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
        if condition.len() > self.most {
            return Err(BoundExceeded::Count {
                what: "alternatives in a state",
                limit: self.most,
            });
        }
        Ok(condition)
    }

    fn joined(&self, and: bool, a: &Condition, b: &Condition) -> Result<Condition, BoundExceeded> {
        self.bounded(if and == (self.reading == Reading::Terms) {
            a.product(b)
        } else {
            a.union(b)
        })
    }

    /// Reads a list as a conjunction or a disjunction.
    fn all(
        &mut self,
        and: bool,
        list: &[Node],
        of: impl Fn(&mut Self, Node) -> Result<Condition, BoundExceeded>,
    ) -> Result<Condition, BoundExceeded> {
        let mut found = self.constant(and);
        for node in list {
            let part = of(self, *node)?;
            found = self.joined(and, &found, &part)?;
        }
        Ok(found)
    }

    /// Returns a formula as a condition on the steps to come.
    pub fn ahead(&mut self, node: Node) -> Result<Condition, BoundExceeded> {
        let formulas = self.formulas;
        match formulas.formula(node) {
            Formula::Constant(value) => Ok(self.constant(*value)),
            Formula::And(list) => self.all(true, list, Self::ahead),
            Formula::Or(list) => self.all(false, list, Self::ahead),
            _ => Ok(Condition::of(node)),
        }
    }

    /// Returns what remains of a formula after a step in which these atoms hold, as bits.
    fn after(&mut self, node: Node, letter: u32) -> Result<Condition, BoundExceeded> {
        if let Some(known) = self.known.get(&(node, letter)) {
            return Ok(known.clone());
        }
        let itself = Condition::of(node);
        let formulas = self.formulas;
        let found = match formulas.formula(node) {
            Formula::Constant(value) => self.constant(*value),
            Formula::Atom(atom, value) => self.constant((letter >> atom & 1 == 1) == *value),
            Formula::And(list) => self.all(true, list, |s, a| s.after(a, letter))?,
            Formula::Or(list) => self.all(false, list, |s, a| s.after(a, letter))?,
            Formula::Next(a) => self.ahead(*a)?,
            Formula::Until(a, b) | Formula::Weak(a, b) => {
                let on = self.after(*a, letter)?;
                let on = self.joined(true, &on, &itself)?;
                let end = self.after(*b, letter)?;
                self.joined(false, &end, &on)?
            }
            Formula::Release(a, b) => {
                let on = self.after(*a, letter)?;
                let on = self.joined(false, &on, &itself)?;
                let kept = self.after(*b, letter)?;
                self.joined(true, &kept, &on)?
            }
        };
        self.known.insert((node, letter), found.clone());
        Ok(found)
    }

    /// Returns what remains of a condition after such a step.
    pub fn all_after(
        &mut self,
        condition: &Condition,
        letter: u32,
    ) -> Result<Condition, BoundExceeded> {
        // "And" and "or" swap with the reading, and so do these two.
        let mut found = Condition::none();
        for set in condition.sets() {
            let mut left = Condition::unit();
            for node in set {
                let part = self.after(*node, letter)?;
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
