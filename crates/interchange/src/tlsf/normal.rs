//! Normalizes formulas: pushes negations inwards and pulls conjunctions outwards.
//!
//! Formulas about finitely many steps (`X` is their only temporal operator) stay unchanged. For the
//! others, these equivalences apply:
//!
//! ```text
//! G (a & b) = G a & G b        X (a & b) = X a & X b        p | (a & b) = (p | a) & (p | b)
//! (a & b) W c = (a W c) & (b W c)     c R (a & b) = (c R a) & (c R b)
//! a U b = (a W b) & F b
//! ```
//!
//! and those of [`long_run`](super::long_run).

use super::ltl::{FormulaId, Formulas, Op};

/// Maximum number of parts when conjunctions are pulled out of a disjunction.
const MAX_PARTS: usize = 1024;

impl Formulas {
    /// The formula, or its negation if `negated`, with negations only before formulas about
    /// finitely many steps. The recursion is as deep as the formula.
    pub fn positive(&mut self, f: FormulaId, negated: bool) -> FormulaId {
        if self.ahead(f).is_some() {
            return if negated { self.not(f) } else { f };
        }
        // Look up known results, because `a <-> b` needs each operand and its negation twice.
        if let Some(known) = self.positives.get(&(f, negated)) {
            return *known;
        }
        let found = self.positive_of(f, negated);
        self.positives.insert((f, negated), found);
        found
    }

    fn positive_of(&mut self, f: FormulaId, negated: bool) -> FormulaId {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::True | Op::False | Op::Atom(_) => f,
            Op::Not(a) => self.positive(a, !negated),
            Op::And(list) | Op::Or(list) => {
                let and = matches!(self.op(f), Op::And(_)) != negated;
                let list = list
                    .into_iter()
                    .map(|a| self.positive(a, negated))
                    .collect();
                if and {
                    self.and(list, place)
                } else {
                    self.or(list, place)
                }
            }
            Op::Implies(a, b) => {
                let (a, b) = (self.positive(a, !negated), self.positive(b, negated));
                if negated {
                    self.and(vec![a, b], place)
                } else {
                    self.or(vec![a, b], place)
                }
            }
            Op::Iff(a, b) => {
                let (p, q) = (self.positive(a, false), self.positive(b, false));
                let (r, s) = (self.positive(a, true), self.positive(b, true));
                let (one, two) = if negated {
                    (vec![p, q], vec![r, s])
                } else {
                    (vec![r, q], vec![p, s])
                };
                let (one, two) = (self.or(one, place), self.or(two, place));
                self.and(vec![one, two], place)
            }
            Op::Next(a) => {
                let a = self.positive(a, negated);
                self.next(a, place)
            }
            Op::Globally(a) => {
                let a = self.positive(a, negated);
                if negated {
                    self.finally(a, place)
                } else {
                    self.globally(a, place)
                }
            }
            Op::Finally(a) => {
                let a = self.positive(a, negated);
                if negated {
                    self.globally(a, place)
                } else {
                    self.finally(a, place)
                }
            }
            // !(a U b) = !a R !b, and a W b = b R (a | b).
            Op::Until(a, b) => {
                let (a, b) = (self.positive(a, negated), self.positive(b, negated));
                if negated {
                    self.release(a, b, place)
                } else {
                    self.until(a, b, place)
                }
            }
            Op::Release(a, b) => {
                let (a, b) = (self.positive(a, negated), self.positive(b, negated));
                if negated {
                    self.until(a, b, place)
                } else {
                    self.release(a, b, place)
                }
            }
            Op::Weak(a, b) => {
                if negated {
                    // !(a W b) = !b U (!a & !b)
                    let (a, b) = (self.positive(a, true), self.positive(b, true));
                    let both = self.and(vec![a, b], place);
                    self.until(b, both, place)
                } else {
                    let (a, b) = (self.positive(a, false), self.positive(b, false));
                    self.weak(a, b, place)
                }
            }
        }
    }

    /// The conjuncts of a formula that is in [`positive`](Self::positive) form.
    pub fn parts(&mut self, f: FormulaId) -> Vec<FormulaId> {
        let place = self.place(f);
        match self.op(f).clone() {
            Op::And(list) => list.into_iter().flat_map(|a| self.parts(a)).collect(),
            Op::Globally(a) => {
                let parts = self.parts(a);
                // The result has the location of `G`, unless there are several conjuncts,
                // which need different locations.
                if let [part] = parts.as_slice() {
                    return vec![self.globally(*part, place)];
                }
                parts
                    .into_iter()
                    .map(|a| {
                        let own = self.place(a);
                        self.globally(a, own)
                    })
                    .collect()
            }
            Op::Next(a) => {
                let parts = self.parts(a);
                parts.into_iter().map(|a| self.next(a, place)).collect()
            }
            Op::Until(a, b) => {
                let weak = self.weak(a, b, place);
                let some_day = self.finally(b, place);
                let mut found = self.parts(weak);
                found.extend(self.parts(some_day));
                found
            }
            Op::Weak(a, b) => {
                let parts = self.parts(a);
                parts.into_iter().map(|a| self.weak(a, b, place)).collect()
            }
            Op::Release(a, b) => {
                let parts = self.parts(b);
                parts
                    .into_iter()
                    .map(|b| self.release(a, b, place))
                    .collect()
            }
            Op::Or(list) if self.ahead(f).is_none() => {
                let mut product: Vec<Vec<FormulaId>> = vec![Vec::new()];
                for a in list {
                    let parts = if self.ahead(a).is_some() {
                        vec![a]
                    } else {
                        self.parts(a)
                    };
                    if product.len() * parts.len() > MAX_PARTS {
                        return vec![f];
                    }
                    product = product
                        .iter()
                        .flat_map(|done| {
                            parts
                                .iter()
                                .map(|p| done.iter().copied().chain([*p]).collect())
                        })
                        .collect();
                }
                product
                    .into_iter()
                    .map(|list| self.or(list, place))
                    .collect()
            }
            _ => vec![f],
        }
    }

    /// Whether the operators of `f`, in positive form, show that it is a safety formula.
    pub fn is_safety(&self, f: FormulaId) -> bool {
        match self.op(f) {
            _ if self.ahead(f).is_some() => true,
            Op::Until(..) | Op::Finally(_) => false,
            op => Self::children(op).iter().all(|g| self.is_safety(*g)),
        }
    }
}
