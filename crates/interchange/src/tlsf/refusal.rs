//! Finds the smallest refused part of a formula, and explains which equivalence is missing.

use super::classify::{Classifier, Refusal};
use super::ltl::{FormulaId, Formulas, Op};

impl Classifier<'_> {
    /// The refusal of the smallest temporal subformula without an equivalent. `within` describes
    /// the formula around `f`.
    pub fn nested(&self, f: FormulaId, within: &str) -> Refusal {
        let (mut at, mut within) = (f, within);
        loop {
            let next = match self.formulas.op(at) {
                Op::Next(a) => Some(*a),
                Op::And(list) | Op::Or(list) => {
                    let find = |wanted: &dyn Fn(FormulaId) -> bool| {
                        list.iter().copied().find(|g| wanted(*g))
                    };
                    find(&|g| !self.formulas.is_safety(g))
                        .or_else(|| find(&|g| self.formulas.ahead(g).is_none()))
                }
                Op::Finally(a) if self.formulas.ahead(*a).is_none() => {
                    let persistent = matches!(self.formulas.op(*a), Op::Globally(_));
                    (!persistent).then(|| {
                        within = "`F`";
                        *a
                    })
                }
                // The cause is an operand that is not a safety formula, if there is one.
                Op::Weak(a, b) | Op::Until(a, b) | Op::Release(a, b) => {
                    let found = [*a, *b].into_iter().find(|g| !self.formulas.is_safety(*g));
                    if found.is_some() {
                        within = "`U`, `W` or `R`";
                    }
                    found
                }
                _ => None,
            };
            match next {
                Some(next) => at = next,
                None => break,
            }
        }
        let (word, help) = match self.formulas.op(at) {
            Op::Until(..) | Op::Weak(..) | Op::Release(..) => (
                "this `U`, `W` or `R`",
                "replace it with an output `q`: in a guarantee, add `G (q -> (a U b))`, which can be stronger; in a condition, add `G ((a U b) -> q)`",
            ),
            Op::Finally(g) if matches!(self.formulas.op(*g), Op::Globally(_)) => (
                "`F G`",
                "add an output `settled` that signals when it begins: `G (settled -> X settled)`, \
                 `G (settled -> a)` and `G F settled`",
            ),
            Op::Globally(g) if matches!(self.formulas.op(*g), Op::Finally(_)) => (
                "`G F`",
                "write `G F a` alone, as an operand of `||`, or after `->`",
            ),
            Op::Finally(_) => (
                "this `F`",
                "replace it with an output `q`, and add `G (q -> F a)`, which can be stronger",
            ),
            _ => (
                "this `G`",
                "replace it with an output `q`, and add `G (q -> G a)`, which can be stronger",
            ),
        };
        Refusal {
            at,
            why: format!("{word} within {within} has no equivalent in GR(1) here"),
            help: help.to_owned(),
        }
    }

    /// The refusal of a `U` in a positive position within another such `U`, as the file's formula
    /// is written; `None` if there is no such `U`.
    pub fn nested_until(&self, f: FormulaId) -> Option<Refusal> {
        let at = self.inner_until(f, false, false)?;
        Some(Refusal {
            at,
            why: "this `U` is nested in another `U`, which has no equivalent in GR(1) here".to_owned(),
            help: "replace the inner one with an output `q`, which can be stronger: `a U q` and `G (q -> (b U c))` for `a U (b U c)`".to_owned(),
        })
    }

    fn inner_until(&self, f: FormulaId, negated: bool, within: bool) -> Option<FormulaId> {
        let op = self.formulas.op(f);
        let until = matches!(op, Op::Until(..)) && !negated;
        if until && within {
            return Some(f);
        }
        let within = within || until;
        match op {
            Op::Not(a) => self.inner_until(*a, !negated, within),
            Op::Implies(a, b) => (self.inner_until(*a, !negated, within))
                .or_else(|| self.inner_until(*b, negated, within)),
            op => Formulas::children(op)
                .into_iter()
                .find_map(|g| self.inner_until(g, negated, within)),
        }
    }
}
