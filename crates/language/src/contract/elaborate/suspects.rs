//! Well-formed comparisons that are probably not intended: decided by domains alone (LW114), or
//! about the next step on both sides (LW211).

use super::Elaborator;
use super::names::Names;
use crate::contract::shape::Entry;
use crate::contract::units::Unit;
use crate::contract::value::{Term, Value};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::interval::Interval;
use linewright_core::gr1::{BinaryOp, Time, VarId, described};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, Expr, ExprKind};
use linewright_syntax::format;

impl Elaborator<'_> {
    /// Checks a comparison of numbers: `term` is the result for `a` and `b`, in one unit.
    ///
    /// Only compares a variable with a number written in the source or with another variable.
    /// Expressions with parameters or quantified names are deliberately general, and may well be
    /// decided in one case of many.
    pub(super) fn compared(&mut self, span: Span, sign: &str, term: &Term, a: &Expr, b: &Expr) {
        let Term::Binary(op, x, y) = term else { return };
        if self.dialect.real {
            return;
        }
        // `place <= LAST` describes the range of a place and needs no check; `place = LAST` must be
        // possible.
        let equation = matches!(op, BinaryOp::Eq | BinaryOp::Ne);
        let both = self.names.declared(a) && self.names.declared(b) && equation;
        let of_number = |v: &Expr, n: &Expr| {
            let named = |n: &Expr| matches!(n.kind, ExprKind::Path(_));
            self.names.declared(v) && self.names.written_out(n) && (equation || !named(n))
        };
        if !both && !of_number(a, b) && !of_number(b, a) {
            return;
        }
        let (Some(x), Some(y)) = (self.variables.reach(x), self.variables.reach(y)) else {
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
                    format::expression(e),
                    self.domain_of(e, range)
                )
            })
            .collect();
        let text = format!("{} {sign} {}", format::expression(a), format::expression(b));
        let verdict = if holds { "always" } else { "never" };
        let help = if holds {
            "leave it out, or compare with a value in the middle of the domain"
        } else {
            "compare with a value of the domain, or make the domain larger"
        };
        let message = format!("`{text}` {verdict} holds: {}", sides.join(", and "));
        // `x >= 0` is a common, harmless habit.
        let finding = if holds && !equation {
            Diagnostic::note(codes::COMPARISON_DECIDED, span, message)
        } else {
            Diagnostic::warning(codes::COMPARISON_DECIDED, span, message)
        };
        self.findings.push(finding.with_help(help));
    }

    /// Describes a variable's declared domain, or the range of an expression that is not a scalar
    /// variable.
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
            return described(
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

    /// Checks an equation: `x = f(x)` with both values of the next step assigns nothing.
    pub(super) fn equated(
        &mut self,
        span: Span,
        sign: &str,
        (a, x): (&Expr, &Term),
        (b, y): (&Expr, &Term),
        time: Time,
    ) {
        let sets = |x: &Term, y: &Term| match x {
            Term::Var(v, Time::Next) => x != y && holds_next(y, *v),
            _ => false,
        };
        let (bare, other) = match (sets(x, y), sets(y, x)) {
            (true, _) => (a, b),
            (_, true) => (b, a),
            _ => return,
        };
        let now = |e: &Expr| match time {
            Time::Next => format::expression(&self.names.primed(e)),
            Time::Now => format::expression(e),
        };
        let message = format!(
            "both sides of this equation are about the next step: it says `{} {sign} {}`",
            now(bare),
            now(other)
        );
        let next = Expr {
            kind: ExprKind::Next(Box::new(stripped(bare))),
            span: bare.span,
        };
        let help = format!(
            "to set the next value from the present one, write `{} {sign} {}`",
            format::expression(&next),
            format::expression(&stripped(other))
        );
        let finding = Diagnostic::warning(codes::NEXT_BOTH_SIDES, span, message);
        self.findings.push(finding.with_help(help));
    }
}

impl Names<'_> {
    /// Returns whether the expression is a declared variable or a part of one.
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

    /// Returns whether the expression is a number written in the source or a constant of the file.
    fn written_out(&self, e: &Expr) -> bool {
        match &e.kind {
            ExprKind::Int(_) | ExprKind::Quantity(..) => true,
            ExprKind::Neg(inner) => self.written_out(inner),
            ExprKind::Path(names) => match names.as_slice() {
                [name] => {
                    let outside = self.outside.constants.get(&name.text);
                    matches!(
                        outside,
                        Some(Value::Scalar(Term::Int(_) | Term::Real(_), _))
                    ) && self.constants.get(&name.text) == outside
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Adds `next` before each variable.
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

/// Removes every `next`.
fn stripped(e: &Expr) -> Expr {
    match &e.kind {
        ExprKind::Next(inner) => stripped(inner),
        _ => changed(e, &stripped),
    }
}

/// Returns an expression with changed operands.
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

fn holds_next(term: &Term, v: VarId) -> bool {
    match term {
        Term::Int(_) | Term::Real(_) => false,
        Term::Var(w, time) => *w == v && *time == Time::Next,
        Term::Unary(_, a) | Term::Rounded(_, a) => holds_next(a, v),
        Term::Binary(_, a, b) => holds_next(a, v) || holds_next(b, v),
        Term::If(c, a, b) => holds_next(c, v) || holds_next(a, v) || holds_next(b, v),
    }
}

/// Returns the result of comparing any values of two intervals, if it is always the same.
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
