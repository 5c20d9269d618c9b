//! Lowering of specification patterns in a contract to monitors and formulas.
//!
//! [`gr1::monitors`](linewright_core::gr1::monitors) defines the meaning of a pattern. This module
//! resolves the operands of patterns. It also lowers LTL formulas that are equivalent to patterns,
//! such as `always (p -> eventually s)`.

use super::elaborate::Elaborator;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::monitors::{Obligation, Origin, Pattern, Scope};
use linewright_syntax::ast::{self, PatternKind};

/// Creates the monitors of a pattern, and returns its formulas. Returns `None` if an error was
/// reported.
pub(super) fn lower<'a>(
    e: &mut Elaborator<'a>,
    pattern: &'a ast::Pattern,
    origin: &Origin,
) -> Option<Vec<Obligation>> {
    let steps = match &pattern.bound {
        Some(bound) => e.steps(bound).map(Some),
        None => Some(None),
    };
    if let (PatternKind::Absence(_) | PatternKind::Universality(_), Some(bound)) =
        (&pattern.kind, &pattern.bound)
    {
        e.findings.error_with(
            codes::PAST,
            bound.span,
            "`never` and `always` take no bound",
            "limit the time with a scope, such as `never P after Q until R`, where R states that a counter has reached its end",
        );
        return None;
    }
    let kind = match &pattern.kind {
        PatternKind::Absence(p) => e.state(p, "never").map(Pattern::Absence),
        PatternKind::Universality(p) => e.state(p, "always").map(Pattern::Universality),
        PatternKind::Existence(p) => {
            let p = e.state(p, "eventually");
            p.zip(steps).map(|(p, steps)| Pattern::Existence(p, steps))
        }
        PatternKind::Precedence(s, p) => {
            let (first, then) = (e.state(s, "precedes"), e.state(p, "precedes"));
            if let Some(bound) = &pattern.bound {
                e.findings.error_with(
                    codes::PAST,
                    bound.span,
                    "`precedes` takes no bound",
                    "write `always (P -> once S within n steps)`",
                );
                return None;
            }
            first
                .zip(then)
                .map(|(first, then)| Pattern::Precedence { first, then })
        }
        PatternKind::Response(s, p) => {
            let (answer, trigger) = (e.state(s, "responds to"), e.state(p, "responds to"));
            answer
                .zip(trigger)
                .zip(steps)
                .map(|((answer, trigger), within)| Pattern::Response {
                    trigger,
                    answer,
                    within,
                })
        }
    };
    let scope = scope(e, &pattern.scope);
    add_pattern(e, &kind?, &scope?, origin)
}

fn scope<'a>(e: &mut Elaborator<'a>, scope: &'a ast::Scope) -> Option<Scope> {
    Some(match scope {
        ast::Scope::Globally => Scope::Globally,
        ast::Scope::Before(r) => Scope::Before(e.state(r, "before")?),
        ast::Scope::After(q) => Scope::After(e.state(q, "after")?),
        ast::Scope::Between(q, r) => {
            let (q, r) = (e.state(q, "between"), e.state(r, "between"));
            Scope::Between(q?, r?)
        }
        ast::Scope::AfterUntil(q, r) => {
            let (q, r) = (e.state(q, "after"), e.state(r, "until"));
            Scope::AfterUntil(q?, r?)
        }
    })
}

/// Lowers `always (p -> eventually s)`, or `eventually s` if there is no `p`.
pub(super) fn response<'a>(
    e: &mut Elaborator<'a>,
    p: Option<&'a ast::Expr>,
    s: &'a ast::Expr,
    origin: &Origin,
) -> Option<Vec<Obligation>> {
    let answer = e.state(s, "eventually");
    let pattern = match p {
        None => Pattern::Existence(answer?, None),
        Some(p) => {
            let trigger = e.state(p, "eventually");
            Pattern::Response {
                trigger: trigger?,
                answer: answer?,
                within: None,
            }
        }
    };
    add_pattern(e, &pattern, &Scope::Globally, origin)
}

fn add_pattern(
    e: &mut Elaborator<'_>,
    pattern: &Pattern,
    scope: &Scope,
    origin: &Origin,
) -> Option<Vec<Obligation>> {
    let monitors = e.memory.monitors.as_mut()?;
    let obligations = monitors.pattern(pattern, scope, origin);
    e.variables.add_monitors(monitors);
    Some(obligations)
}
