//! Evaluates guards of definitions: conditions, and patterns to match formulas with.

use super::super::ast::{Binary, Kind, Tree, Unary};
use super::super::ltl::{FormulaId, Op};
use super::super::value::Value;
use super::{Expander, Result, Scope};
use linewright_core::diagnostics::codes;

impl<'f> Expander<'f, '_> {
    pub(super) fn guard(
        &mut self,
        guard: &'f Tree,
        scope: Scope<'_>,
        site: u32,
        bound: &mut Vec<(&'f str, Value)>,
    ) -> Result<bool> {
        if let Kind::Binary(Binary::Pattern, formula, pattern) = &guard.kind {
            let formula = self.condition(formula, scope, site)?;
            return Ok(self.matches(formula, pattern, bound));
        }
        let f = self.condition(guard, scope, site)?;
        match self.formulas.truth(f) {
            Some(truth) => Ok(truth),
            None => self.fail(
                codes::NOT_CONSTANT,
                &guard.range,
                site,
                "this condition is a formula, whose value is not known when the file is read",
                "compare numbers or sets in a guard, or match a formula with a pattern: `f ~ a U b`",
            ),
        }
    }

    /// Whether a formula matches a pattern. Adds what the names in the pattern stand for to
    /// `bound`. The recursion is as deep as the pattern.
    pub(super) fn matches(
        &mut self,
        f: FormulaId,
        pattern: &'f Tree,
        bound: &mut Vec<(&'f str, Value)>,
    ) -> bool {
        let op = self.formulas.op(f).clone();
        let two =
            |s: &mut Self,
             (a, b): (FormulaId, FormulaId),
             (p, q): (&'f Tree, &'f Tree),
             bound: &mut Vec<_>| { s.matches(a, p, bound) && s.matches(b, q, bound) };
        match (&pattern.kind, op) {
            (Kind::Wild, _) => true,
            (Kind::Name(name), _) => {
                bound.push((name, Value::Formula(f)));
                true
            }
            (Kind::Truth(t), op) => op == if *t { Op::True } else { Op::False },
            (Kind::Unary(Unary::Not, p), Op::Not(a))
            | (Kind::Unary(Unary::Next, p), Op::Next(a))
            | (Kind::Unary(Unary::Globally, p), Op::Globally(a))
            | (Kind::Unary(Unary::Finally, p), Op::Finally(a)) => self.matches(a, p, bound),
            (Kind::And(patterns), Op::And(parts)) | (Kind::Or(patterns), Op::Or(parts)) => {
                let and = matches!(pattern.kind, Kind::And(_));
                let Some(more) = parts.len().checked_sub(patterns.len()) else {
                    return false;
                };
                // The operators are left-associative, so the first pattern matches all parts that
                // the other patterns leave over.
                let (head, rest) = parts.split_at(more + 1);
                let place = self.formulas.place(f);
                let head = if and {
                    self.formulas.and(head.to_vec(), place)
                } else {
                    self.formulas.or(head.to_vec(), place)
                };
                let parts = std::iter::once(head).chain(rest.iter().copied());
                parts
                    .zip(patterns)
                    .all(|(part, p)| self.matches(part, p, bound))
            }
            (Kind::Binary(Binary::Implies, p, q), Op::Implies(a, b))
            | (Kind::Binary(Binary::Equivalent, p, q), Op::Iff(a, b))
            | (Kind::Binary(Binary::Until, p, q), Op::Until(a, b))
            | (Kind::Binary(Binary::Weak, p, q), Op::Weak(a, b))
            | (Kind::Binary(Binary::Release, p, q), Op::Release(a, b)) => {
                two(self, (a, b), (p, q), bound)
            }
            _ => false,
        }
    }
}
