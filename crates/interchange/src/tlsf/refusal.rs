//! What is refused, at its smallest part, and the equivalence that is missing.

use super::classify::{Classifier, Refusal};
use super::ltl::{FormulaId, Formulas, Op};

impl Classifier<'_> {
    /// The smallest temporal formula in one that appears where none can.
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
                // What it waits for, or what holds until then, is itself something to wait for.
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
                "let an output stand for it, and `q` in its place: promised, `G (q -> (a U b))`, which may ask for more; as a condition, `G ((a U b) -> q)`",
            ),
            Op::Finally(g) if matches!(self.formulas.op(*g), Op::Globally(_)) => (
                "`F G`",
                "\"some day and from then on\" has no equivalent: let an output say when it begins, `G (settled -> X settled)`, \
                 `G (settled -> a)` and `G F settled`",
            ),
            Op::Globally(g) if matches!(self.formulas.op(*g), Op::Finally(_)) => (
                "`G F`",
                "`G F a` has to stand alone, beside `||`, or behind `->`",
            ),
            Op::Finally(_) => (
                "this `F`",
                "let an output stand for it, which may ask for more: `G (q -> F a)`, and `q` in its place",
            ),
            _ => (
                "this `G`",
                "let an output stand for it, which may ask for more: `G (q -> G a)`, and `q` in its place",
            ),
        };
        Refusal {
            at,
            why: format!("{word} appears within {within} so that it has no form in GR(1) here"),
            help: help.to_owned(),
        }
    }

    /// An `U` within an `U`, as they were written, where both are promised: the inner one.
    pub fn nested_until(&self, f: FormulaId) -> Option<Refusal> {
        let at = self.inner_until(f, false, false)?;
        Some(Refusal {
            at,
            why: "this `U` appears within another `U`: nested untils are outside what is turned into GR(1)".to_owned(),
            help: "let an output stand for the inner one, which may ask for more: `a U q` and `G (q -> (b U c))` for `a U (b U c)`".to_owned(),
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
