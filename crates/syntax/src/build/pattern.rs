//! Builds past operators and specification patterns.

use super::super::ast::{BinaryOp, Expr, ExprKind, PastOp, PatternKind, Scope, UntilOp};
use super::super::parser::Rule;
use super::expression::make;
use super::{Builder, Children};
use linewright_core::source::Span;
use pest::iterators::Pair;

impl Builder {
    /// Builds an expression that can continue with `precedes ...`, `responds to ...` or
    /// `until ...`.
    pub(super) fn patterned(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let first = c.next();
        let place = self.span(&first);
        let first = self.expr(first);
        if let Some(op) = c.take(Rule::until_word) {
            let op = until_op(op.as_str());
            let second = self.expr(c.next());
            return until((first, place), op, second, span);
        }
        let Some(op) = c.take(Rule::pattern_op) else {
            return first;
        };
        let second = self.expr(c.next());
        let (first, second) = (Box::new(first), Box::new(second));
        let kind = if op.as_str().starts_with("precedes") {
            PatternKind::Precedence(first, second)
        } else {
            PatternKind::Response(first, second)
        };
        let bound = self.bound(&mut c);
        let scope = self.scope(&mut c);
        make(ExprKind::Pattern(kind.in_scope(bound, scope)), span)
    }

    /// Builds `always`, `eventually` and `never`, which extend as far to the right as possible.
    /// `never` is always a pattern; the other two are patterns if they have a bound or a scope.
    pub(super) fn wide(&mut self, rule: Rule, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        c.next();
        let body = self.boxed(&mut c);
        let bound = self.bound(&mut c);
        let scope = self.scope(&mut c);
        let plain = bound.is_none() && scope == Scope::Globally;
        let kind = match rule {
            Rule::wide_always if plain => ExprKind::Always(body),
            Rule::wide_eventually if plain => ExprKind::Eventually(body),
            Rule::wide_always => {
                ExprKind::Pattern(PatternKind::Universality(body).in_scope(bound, scope))
            }
            Rule::wide_eventually => {
                ExprKind::Pattern(PatternKind::Existence(body).in_scope(bound, scope))
            }
            _ => ExprKind::Pattern(PatternKind::Absence(body).in_scope(bound, scope)),
        };
        make(kind, span)
    }

    fn bound(&mut self, c: &mut Children<'_>) -> Option<Box<Expr>> {
        let bound = c.take(Rule::bound)?;
        Some(self.boxed(&mut Children::of(bound)))
    }

    fn scope(&mut self, c: &mut Children<'_>) -> Scope {
        let Some(scope) = c.take(Rule::scope) else {
            return Scope::Globally;
        };
        let inner = Children::of(scope).next();
        let rule = inner.as_rule();
        let mut c = Children::of(inner);
        let first = self.boxed(&mut c);
        match rule {
            Rule::before => Scope::Before(first),
            Rule::between => {
                c.next();
                Scope::Between(first, self.boxed(&mut c))
            }
            _ => match c.take(Rule::until) {
                Some(until) => Scope::AfterUntil(first, self.boxed(&mut Children::of(until))),
                None => Scope::After(first),
            },
        }
    }

    pub(super) fn past(&mut self, pair: Pair<'_, Rule>) -> Expr {
        let span = self.span(&pair);
        let mut c = Children::of(pair);
        let op = match c.next().as_str().trim() {
            "previous" => PastOp::Previous,
            "once" => PastOp::Once,
            _ => PastOp::Historically,
        };
        let body = self.boxed(&mut c);
        let bound = self.bound(&mut c);
        make(ExprKind::Past(op, body, bound), span)
    }
}

pub(super) fn until_op(word: &str) -> UntilOp {
    match word.trim() {
        "W" | "unless" => UntilOp::Weak,
        "R" | "release" => UntilOp::Release,
        _ => UntilOp::Strong,
    }
}

/// Builds `until` so that `p -> a until b` means `p -> (a until b)`, as is usual. The grammar
/// parses `until` as the loosest operator, so the left side has to be split. `place` is the place
/// of the left side including its brackets, because a bracketed expression must not be split.
fn until((left, place): (Expr, Span), op: UntilOp, right: Expr, whole: Span) -> Expr {
    match left.kind {
        ExprKind::Binary(BinaryOp::Implies, a, b) if left.span == place => {
            let place = Span {
                start: b.span.start,
                ..place
            };
            let whole_b = Span {
                end: whole.end,
                ..place
            };
            let inner = until((*b, place), op, right, whole_b);
            make(
                ExprKind::Binary(BinaryOp::Implies, a, Box::new(inner)),
                whole,
            )
        }
        kind => {
            let left = make(kind, left.span);
            make(ExprKind::Until(op, Box::new(left), Box::new(right)), whole)
        }
    }
}
