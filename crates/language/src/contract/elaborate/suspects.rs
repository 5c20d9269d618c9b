//! Findings for valid comparisons that are probably mistakes: those whose result follows from the
//! domains (LW114), and equations with next values on both sides (LW211).

use super::Elaborator;
use super::names::Names;
use crate::contract::shape::Entry;
use crate::contract::units::Unit;
use crate::contract::value::{Term, Value};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::interval::Interval;
use linewright_core::gr1::{BinaryOp, Time, VarId, describe_domain};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, Expr, ExprKind};
use linewright_syntax::format;

impl Elaborator<'_> {
    /// Reports a comparison of numbers whose result is always the same. `term` is the comparison of
    /// `a` and `b` in a common unit.
    ///
    /// Checks only comparisons of a variable with a literal number, a constant or another variable.
    /// An expression with parameters or quantified names is written for many cases, and its value
    /// can rightly be constant in one of them.
    pub(super) fn compared(&mut self, span: Span, sign: &str, term: &Term, a: &Expr, b: &Expr) {
        let Term::Binary(op, x, y) = term else { return };
        if self.dialect.real {
            return;
        }
        // An inequality with a named constant is not checked, because `place <= LAST` can
        // deliberately state the range of `place`. An equation such as `place = LAST` is checked.
        let equation = matches!(op, BinaryOp::Eq | BinaryOp::Ne);
        let both = self.names.declared(a) && self.names.declared(b) && equation;
        let of_number = |v: &Expr, n: &Expr| {
            let named = |n: &Expr| matches!(n.kind, ExprKind::Path(_));
            self.names.declared(v) && self.names.is_literal(n) && (equation || !named(n))
        };
        if !both && !of_number(a, b) && !of_number(b, a) {
            return;
        }
        let (Some(x), Some(y)) = (self.variables.range(x), self.variables.range(y)) else {
            return;
        };
        let Some(holds) = decided(*op, x, y) else {
            return;
        };
        let sides: Vec<String> = [(a, x), (b, y)]
            .into_iter()
            .filter(|(e, _)| self.names.declared(e))
            .map(|(e, range)| {
                format!(
                    "`{}` is {}",
                    format::format_expression(e),
                    self.domain_of(e, range)
                )
            })
            .collect();
        let text = format!(
            "{} {sign} {}",
            format::format_expression(a),
            format::format_expression(b)
        );
        let verdict = if holds { "always" } else { "never" };
        let help = if holds {
            "remove the comparison, or compare with a value inside the domain"
        } else {
            "compare with a value of the domain, or extend the domain"
        };
        let message = format!("`{text}` {verdict} holds: {}", sides.join(", and "));
        // `x >= 0` is a common and harmless habit, so it is only a note.
        let finding = if holds && !equation {
            Diagnostic::note(codes::COMPARISON_DECIDED, span, message)
        } else {
            Diagnostic::warning(codes::COMPARISON_DECIDED, span, message)
        };
        self.findings.push(finding.with_help(help));
    }

    /// Formats the declared domain of a scalar variable, or the range of any other expression.
    fn domain_of(&self, e: &Expr, range: Interval) -> String {
        let mut base = e;
        while let ExprKind::Next(inner) = &base.kind {
            base = inner;
        }
        if let ExprKind::Path(names) = &base.kind
            && let [name] = names.as_slice()
            && let Some(Entry::One(id)) = self.names.variables.get(&name.text)
            && let Some(Some(domain)) = self.variables.domains.get(id.index())
        {
            return describe_domain(
                domain,
                self.variables
                    .measures
                    .get(id)
                    .copied()
                    .map_or("", Unit::name),
            );
        }
        format!("{}..{}", range.low, range.high)
    }

    /// Reports an equation such as `next x = next (x + 1)`. It contains the next value of `x` on
    /// both sides, and so does not relate it to the current value of `x`.
    pub(super) fn equated(
        &mut self,
        span: Span,
        sign: &str,
        (a, x): (&Expr, &Term),
        (b, y): (&Expr, &Term),
        time: Time,
    ) {
        let sets = |x: &Term, y: &Term| match x {
            Term::Var(v, Time::Next) => x != y && contains_next(y, *v),
            _ => false,
        };
        let (bare, other) = match (sets(x, y), sets(y, x)) {
            (true, _) => (a, b),
            (_, true) => (b, a),
            _ => return,
        };
        let now = |e: &Expr| match time {
            Time::Next => format::format_expression(&self.names.primed(e)),
            Time::Now => format::format_expression(e),
        };
        let message = format!(
            "both sides of this equation refer to the next step: it means `{} {sign} {}`",
            now(bare),
            now(other)
        );
        let next = Expr {
            kind: ExprKind::Next(Box::new(stripped(bare))),
            span: bare.span,
        };
        let help = format!(
            "to compute the next value from the current one, write `{} {sign} {}`",
            format::format_expression(&next),
            format::format_expression(&stripped(other))
        );
        let finding = Diagnostic::warning(codes::NEXT_BOTH_SIDES, span, message);
        self.findings.push(finding.with_help(help));
    }
}

impl Names<'_> {
    /// Returns whether the expression is a declared variable or a part of one, with or without
    /// `next`.
    fn declared(&self, e: &Expr) -> bool {
        match &e.kind {
            ExprKind::Path(names) => names.first().is_some_and(|n| {
                self.variables.contains_key(&n.text) && !self.constants.contains_key(&n.text)
            }),
            ExprKind::Index(base, _) | ExprKind::Field(base, _) | ExprKind::Next(base) => {
                self.declared(base)
            }
            _ => false,
        }
    }

    /// Returns whether the expression is a literal number or a top-level constant.
    fn is_literal(&self, e: &Expr) -> bool {
        match &e.kind {
            ExprKind::Int(_) | ExprKind::Quantity(..) => true,
            ExprKind::Neg(inner) => self.is_literal(inner),
            ExprKind::Path(names) => match names.as_slice() {
                [name] => {
                    let constant = self.of_file.constants.get(&name.text);
                    matches!(
                        constant,
                        Some(Value::Scalar(Term::Int(_) | Term::Real(_), _))
                    ) && self.constants.get(&name.text) == constant
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Returns the expression with `next` before each variable.
    fn primed(&self, e: &Expr) -> Expr {
        if self.declared(e) {
            return Expr {
                kind: ExprKind::Next(Box::new(e.clone())),
                span: e.span,
            };
        }
        changed(e, &|e| self.primed(e))
    }
}

/// Returns the expression without `next`.
fn stripped(e: &Expr) -> Expr {
    match &e.kind {
        ExprKind::Next(inner) => stripped(inner),
        _ => changed(e, &stripped),
    }
}

/// Returns the expression with `change` applied to each operand.
fn changed(e: &Expr, change: &dyn Fn(&Expr) -> Expr) -> Expr {
    let sub = |e: &Expr| Box::new(change(e));
    let kind = match &e.kind {
        ExprKind::Binary(op, a, b) => ExprKind::Binary(*op, sub(a), sub(b)),
        ExprKind::Not(a) => ExprKind::Not(sub(a)),
        ExprKind::Neg(a) => ExprKind::Neg(sub(a)),
        ExprKind::If(c, a, b) => ExprKind::If(sub(c), sub(a), sub(b)),
        ExprKind::Call(name, list) => {
            ExprKind::Call(name.clone(), list.iter().map(change).collect())
        }
        other => other.clone(),
    };
    ast::Expr { kind, span: e.span }
}

/// Returns whether the term contains the next value of `v`.
fn contains_next(term: &Term, v: VarId) -> bool {
    match term {
        Term::Int(_) | Term::Real(_) => false,
        Term::Var(w, time) => *w == v && *time == Time::Next,
        Term::Unary(_, a) | Term::Rounded(_, a) => contains_next(a, v),
        Term::Binary(_, a, b) => contains_next(a, v) || contains_next(b, v),
        Term::If(c, a, b) => contains_next(c, v) || contains_next(a, v) || contains_next(b, v),
    }
}

/// Returns the result of comparing a value of `a` with a value of `b`; `None` if different values
/// give different results.
fn decided(op: BinaryOp, a: Interval, b: Interval) -> Option<bool> {
    let below = a.high < b.low;
    let above = b.high < a.low;
    let one = a.low == a.high && a == b;
    match op {
        BinaryOp::Eq if below || above => Some(false),
        BinaryOp::Ne if below || above => Some(true),
        BinaryOp::Eq if one => Some(true),
        BinaryOp::Ne if one => Some(false),
        BinaryOp::Lt if below => Some(true),
        BinaryOp::Lt if a.low >= b.high => Some(false),
        BinaryOp::Le if a.high <= b.low => Some(true),
        BinaryOp::Le if above => Some(false),
        BinaryOp::Gt if above => Some(true),
        BinaryOp::Gt if a.high <= b.low => Some(false),
        BinaryOp::Ge if a.low >= b.high => Some(true),
        BinaryOp::Ge if below => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::gr1::eval;

    #[test]
    fn comparisons_are_decided_by_trying_all_values() {
        use BinaryOp::{Eq, Ge, Gt, Le, Lt, Ne};
        let range = |low, high| Interval { low, high };
        let all = || (0..4).flat_map(|l| (l..4).map(move |h| (l, h)));
        for op in [Eq, Ne, Lt, Le, Gt, Ge] {
            for (al, ah) in all() {
                for (bl, bh) in all() {
                    let values = (al..=ah).flat_map(|a| (bl..=bh).map(move |b| (a, b)));
                    let answers: Vec<bool> =
                        values.map(|(a, b)| eval::binary(op, a, b) != 0).collect();
                    let same = answers.iter().all(|x| *x == answers[0]);
                    let wanted = same.then_some(answers[0]);
                    assert_eq!(
                        decided(op, range(al, ah), range(bl, bh)),
                        wanted,
                        "{op:?} {al}..{ah} {bl}..{bh}"
                    );
                }
            }
        }
    }
}
