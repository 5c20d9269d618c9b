//! Normalization of LTL formulas, which prepares the search for a GR(1) form.
//!
//! Negations are pushed inwards and conjunctions outwards. Equivalences simplify nested operators:
//! `always (p -> always q)` becomes `always (once p -> q)`; `always eventually` has the same value
//! at every step of a run, so it can be pulled out of any disjunction. The result is a conjunction
//! of clauses. `forms.rs` looks for a GR(1) form of each clause.
//!
//! All steps are equivalences. For a formula that cannot be normalized, the result is `None`,
//! although a GR(1) form might exist.

use linewright_core::source::Span;
use linewright_syntax::ast::{BinaryOp, Expr, ExprKind, Name, PastOp, PatternKind, Scope, UntilOp};

/// A formula without negations of temporal operators.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Ltl {
    /// A condition on one step, or on one step and the next.
    State(Expr),
    And(Vec<Ltl>),
    Or(Vec<Ltl>),
    Next(Box<Ltl>),
    Always(Box<Ltl>),
    Eventually(Box<Ltl>),
    /// The first condition holds until the second one does, or for ever.
    Unless(Expr, Expr),
}

use Ltl::{Always, And, Eventually, Next, Or, State, Unless};

/// Maximum number of clauses; each `<->` doubles the number.
const MAX_CLAUSES: usize = 16;

/// Normalizes the formula `e` if `holds` is true, otherwise its negation. Returns `None` if it
/// cannot be normalized.
pub(super) fn read(e: &Expr, holds: bool) -> Option<Ltl> {
    if !super::temporal(e) {
        return Some(State(if holds { e.clone() } else { not(e) }));
    }
    match (&e.kind, holds) {
        (ExprKind::Not(a), _) => read(a, !holds),
        (ExprKind::Binary(BinaryOp::And, a, b), true)
        | (ExprKind::Binary(BinaryOp::Or, a, b), false) => and([read(a, holds)?, read(b, holds)?]),
        (ExprKind::Binary(BinaryOp::Or, a, b), true)
        | (ExprKind::Binary(BinaryOp::And, a, b), false) => {
            or(vec![read(a, holds)?, read(b, holds)?])
        }
        (ExprKind::Binary(BinaryOp::Implies, a, b), true) => {
            or(vec![read(a, false)?, read(b, true)?])
        }
        (ExprKind::Binary(BinaryOp::Implies, a, b), false) => {
            and([read(a, true)?, read(b, false)?])
        }
        (
            ExprKind::Binary(
                op @ (BinaryOp::Iff | BinaryOp::Eq | BinaryOp::Xor | BinaryOp::Ne),
                a,
                b,
            ),
            _,
        ) => {
            let equal = matches!(op, BinaryOp::Iff | BinaryOp::Eq) == holds;
            and([
                or(vec![read(a, false)?, read(b, equal)?])?,
                or(vec![read(a, true)?, read(b, !equal)?])?,
            ])
        }
        (ExprKind::If(c, a, b), _) => and([
            or(vec![read(c, false)?, read(a, holds)?])?,
            or(vec![read(c, true)?, read(b, holds)?])?,
        ]),
        (ExprKind::Next(a), _) => next(read(a, holds)?),
        (ExprKind::Always(a), true) | (ExprKind::Eventually(a), false) => always(read(a, holds)?),
        (ExprKind::Eventually(a), true) | (ExprKind::Always(a), false) => {
            eventually(read(a, holds)?)
        }
        (ExprKind::Until(op, a, b), _) => until(*op, a, b, holds),
        (ExprKind::Pattern(p), _) if p.bound.is_none() && p.scope == Scope::Globally => {
            match &p.kind {
                PatternKind::Absence(a) if holds => always(read(a, false)?),
                PatternKind::Absence(a) => eventually(read(a, true)?),
                PatternKind::Universality(a) if holds => always(read(a, true)?),
                PatternKind::Universality(a) => eventually(read(a, false)?),
                PatternKind::Existence(a) if holds => eventually(read(a, true)?),
                PatternKind::Existence(a) => always(read(a, false)?),
                PatternKind::Response(s, p) if holds => {
                    always(or(vec![read(p, false)?, eventually(read(s, true)?)?])?)
                }
                PatternKind::Precedence(s, p) => {
                    let kept = implies(p.as_ref().clone(), once(s)?);
                    if holds {
                        always(State(kept))
                    } else {
                        eventually(State(not(&kept)))
                    }
                }
                PatternKind::Response(..) => None,
            }
        }
        _ => None,
    }
}

fn until(op: UntilOp, a: &Expr, b: &Expr, holds: bool) -> Option<Ltl> {
    if super::temporal(a) || super::temporal(b) {
        return None;
    }
    // The operands of `p until q`, and whether `q` has to occur.
    let (p, q, q_occurs) = match (op, holds) {
        (UntilOp::Strong, true) => (a.clone(), b.clone(), true),
        (UntilOp::Weak, true) => (a.clone(), b.clone(), false),
        (UntilOp::Release, true) => (b.clone(), conj(a.clone(), b.clone()), false),
        (UntilOp::Strong, false) => (not(b), conj(not(a), not(b)), false),
        (UntilOp::Weak, false) => (not(b), conj(not(a), not(b)), true),
        (UntilOp::Release, false) => (not(a), not(b), true),
    };
    let unless = Unless(p, q.clone());
    if q_occurs {
        and([unless, eventually(State(q))?])
    } else {
        Some(unless)
    }
}

fn and(parts: impl IntoIterator<Item = Ltl>) -> Option<Ltl> {
    let mut all = Vec::new();
    for part in parts {
        match part {
            And(inner) => all.extend(inner),
            other => all.push(other),
        }
    }
    match all.len() {
        1 => all.pop(),
        n if n > MAX_CLAUSES => None,
        _ => Some(And(all)),
    }
}

/// Builds a disjunction: flattens it, pulls conjunctions out, and merges alternatives of the same
/// kind.
fn or(parts: Vec<Ltl>) -> Option<Ltl> {
    if let Some(at) = parts.iter().position(|p| matches!(p, And(_))) {
        let And(inner) = &parts[at] else { return None };
        let clauses = inner.iter().map(|one| {
            let mut clause = parts.clone();
            clause[at] = one.clone();
            or(clause)
        });
        return and(clauses.collect::<Option<Vec<_>>>()?);
    }
    let mut all: Vec<Ltl> = Vec::new();
    let mut open: Vec<Ltl> = parts.into_iter().rev().collect();
    while let Some(part) = open.pop() {
        if let Or(inner) = part {
            open.extend(inner.into_iter().rev());
            continue;
        }
        let joined = all.iter_mut().any(|other| match (other, &part) {
            (State(a), State(b)) => {
                *a = disj(a.clone(), b.clone());
                true
            }
            (Eventually(a), Eventually(b)) => merge(a, b),
            (Always(a), Always(b)) => match (&mut **a, &**b) {
                (Eventually(a), Eventually(b)) => merge(a, b),
                _ => false,
            },
            _ => false,
        });
        if !joined && !all.contains(&part) {
            all.push(part);
        }
    }
    if all.len() == 1 {
        all.pop()
    } else {
        Some(Or(all))
    }
}

/// If both are conditions, replaces `a` by `a or b`. Returns whether it did.
fn merge(a: &mut Ltl, b: &Ltl) -> bool {
    match (a, b) {
        (State(a), State(b)) => {
            *a = disj(a.clone(), b.clone());
            true
        }
        _ => false,
    }
}

fn next(x: Ltl) -> Option<Ltl> {
    match x {
        State(s) if super::mentions_next(&s) => None,
        State(s) => Some(State(make(ExprKind::Next(Box::new(s))))),
        And(parts) => and(parts.into_iter().map(next).collect::<Option<Vec<_>>>()?),
        Or(parts) => or(parts.into_iter().map(next).collect::<Option<_>>()?),
        x if endless(&x) => Some(x),
        x => Some(Next(Box::new(x))),
    }
}

/// Returns whether a formula is `always eventually` or `eventually always` of a condition. Such a
/// formula has the same value at every step of a run.
fn endless(x: &Ltl) -> bool {
    match x {
        Always(x) => matches!(&**x, Eventually(x) if matches!(**x, State(_))),
        Eventually(x) => matches!(&**x, Always(x) if matches!(**x, State(_))),
        _ => false,
    }
}

fn always(x: Ltl) -> Option<Ltl> {
    match x {
        State(_) => Some(Always(Box::new(x))),
        And(parts) => and(parts.into_iter().map(always).collect::<Option<Vec<_>>>()?),
        Always(_) => Some(x),
        Eventually(y) => match *y {
            State(_) => Some(Always(Box::new(Eventually(y)))),
            Always(_) => Some(Eventually(y)),
            And(parts) => {
                let each = parts.into_iter().map(|p| always(eventually(p)?));
                // `q and eventually r` holds infinitely often exactly if `q` and `r` each hold
                // infinitely often.
                and(each.collect::<Option<Vec<_>>>()?)
            }
            _ => None,
        },
        Unless(p, q) => Some(Always(Box::new(State(disj(p, q))))),
        // `always next eventually p` is equivalent to `always eventually p`.
        Next(y) if matches!(*y, Eventually(_)) => always(*y),
        Next(y) => always(or(vec![State(not(&previous(&truth())?)), *y])?),
        Or(parts) => always_one_of(parts),
    }
}

fn always_one_of(parts: Vec<Ltl>) -> Option<Ltl> {
    let (mut endless, rest): (Vec<Ltl>, Vec<Ltl>) = parts.into_iter().partition(endless);
    if !endless.is_empty() {
        if !rest.is_empty() {
            endless.push(always(or(rest)?)?);
        }
        return or(endless);
    }
    let (states, rest): (Vec<Ltl>, Vec<Ltl>) =
        rest.into_iter().partition(|p| matches!(p, State(_)));
    let state = states.into_iter().find_map(|s| match s {
        State(s) => Some(s),
        _ => None,
    });
    let whole = |state: Option<Expr>, rest: Vec<Ltl>| {
        let parts: Vec<Ltl> = state.map(State).into_iter().chain(rest).collect();
        Always(Box::new(Or(parts)))
    };
    let all_always = rest.iter().all(|p| matches!(p, Always(_)));
    match (rest.as_slice(), state) {
        ([], Some(state)) => Some(Always(Box::new(State(state)))),
        ([Always(y)], Some(state)) => {
            let earlier = not(&once(&not(&state))?);
            always(or(vec![State(earlier), (**y).clone()])?)
        }
        ([Next(y)], state) => {
            let before = match state {
                Some(state) => previous(&not(&state))?,
                None => previous(&truth())?,
            };
            always(or(vec![State(not(&before)), (**y).clone()])?)
        }
        ([Eventually(_) | Unless(..)], Some(state)) => Some(whole(Some(state), rest)),
        (_, None) if all_always => Some(Or(rest)),
        (_, Some(state)) if all_always => {
            // One of the other parts holds for ever from the first step in which the condition
            // fails.
            let begun = once(&not(&state))?;
            let mut kept = rest.into_iter().map(|p| match p {
                Always(y) => match *y {
                    State(y) => historically(&implies(begun.clone(), y)),
                    _ => None,
                },
                _ => None,
            });
            let first = kept.next()??;
            let one = kept.try_fold(first, |a, b| Some(disj(a, b?)))?;
            Some(Always(Box::new(State(one))))
        }
        _ => None,
    }
}

fn eventually(x: Ltl) -> Option<Ltl> {
    match x {
        State(_) => Some(Eventually(Box::new(x))),
        Or(parts) => or(parts.into_iter().map(eventually).collect::<Option<_>>()?),
        Eventually(_) => Some(x),
        Always(y) => match *y {
            State(_) => Some(Eventually(Box::new(Always(y)))),
            Eventually(_) => Some(Always(y)),
            _ => None,
        },
        Next(y) => next(eventually(*y)?),
        And(parts) => {
            let (mut endless, rest): (Vec<Ltl>, Vec<Ltl>) = parts.into_iter().partition(endless);
            let mut condition: Option<Expr> = None;
            let mut later: Option<Expr> = None;
            for part in rest {
                match part {
                    State(s) => {
                        condition = Some(match condition {
                            Some(c) => conj(c, s),
                            None => s,
                        });
                    }
                    Eventually(y) => match *y {
                        State(r) if later.is_none() => later = Some(r),
                        _ => return None,
                    },
                    _ => return None,
                }
            }
            endless.extend(match (condition, later) {
                (Some(q), Some(r)) => {
                    let r = Eventually(Box::new(State(r)));
                    Some(Eventually(Box::new(And(vec![State(q), r]))))
                }
                (Some(s), None) | (None, Some(s)) => Some(Eventually(Box::new(State(s)))),
                (None, None) => None,
            });
            and(endless)
        }
        Unless(..) => None,
    }
}

// ---- conditions ---------------------------------------------------------------------------------

pub(super) fn make(kind: ExprKind) -> Expr {
    Expr {
        kind,
        span: Span::default(),
    }
}

pub(super) fn truth() -> Expr {
    make(ExprKind::Bool(true))
}

pub(super) fn name(text: &str) -> Expr {
    make(ExprKind::Path(vec![Name {
        text: text.to_owned(),
        span: Span::default(),
    }]))
}

fn binary(op: BinaryOp, a: Expr, b: Expr) -> Expr {
    make(ExprKind::Binary(op, Box::new(a), Box::new(b)))
}

pub(super) fn not(e: &Expr) -> Expr {
    match &e.kind {
        ExprKind::Not(a) => (**a).clone(),
        ExprKind::Bool(value) => make(ExprKind::Bool(!value)),
        ExprKind::Binary(BinaryOp::Implies, a, b) => conj((**a).clone(), not(b)),
        _ => make(ExprKind::Not(Box::new(e.clone()))),
    }
}

pub(super) fn conj(a: Expr, b: Expr) -> Expr {
    match (&a.kind, &b.kind) {
        (ExprKind::Bool(true), _) => b,
        (_, ExprKind::Bool(true)) => a,
        _ => binary(BinaryOp::And, a, b),
    }
}

/// Builds `a or b`; `not a or b` becomes `a -> b`, which is easier to read.
pub(super) fn disj(a: Expr, b: Expr) -> Expr {
    match (a.kind, b.kind) {
        (ExprKind::Not(a), b) => binary(BinaryOp::Implies, *a, make(b)),
        (a, ExprKind::Not(b)) => binary(BinaryOp::Implies, *b, make(a)),
        (a, b) => binary(BinaryOp::Or, make(a), make(b)),
    }
}

pub(super) fn implies(a: Expr, b: Expr) -> Expr {
    let span = a.span;
    match a.kind {
        ExprKind::Bool(true) => b,
        ExprKind::Not(inner) => binary(BinaryOp::Or, *inner, b),
        kind => binary(BinaryOp::Implies, Expr { kind, span }, b),
    }
}

/// Builds `a -> b` for any `a`: the shape of a response.
pub(super) fn arrow(a: Expr, b: Expr) -> Expr {
    binary(BinaryOp::Implies, a, b)
}

/// Builds a past operator; `None` if the operand contains `next`, which is not allowed.
fn past(op: PastOp, e: &Expr) -> Option<Expr> {
    let body = Box::new(e.clone());
    (!super::mentions_next(e)).then(|| make(ExprKind::Past(op, body, None)))
}

pub(super) fn once(e: &Expr) -> Option<Expr> {
    past(PastOp::Once, e)
}

pub(super) fn historically(e: &Expr) -> Option<Expr> {
    past(PastOp::Historically, e)
}

/// Builds the condition that `e` holds in some step up to now, without a negated operand if
/// possible.
pub(super) fn ever(e: &Expr) -> Option<Expr> {
    match &e.kind {
        ExprKind::Not(a) => Some(not(&historically(a)?)),
        _ => once(e),
    }
}

/// Builds the condition that `e` holds in all steps up to now, without a negated operand if
/// possible.
pub(super) fn so_far(e: &Expr) -> Option<Expr> {
    match &e.kind {
        ExprKind::Not(a) => Some(not(&once(a)?)),
        _ => historically(e),
    }
}

pub(super) fn previous(e: &Expr) -> Option<Expr> {
    past(PastOp::Previous, e)
}

/// Builds the condition that this is the first step and `e` holds in it; `None` if `e` contains
/// `next`.
pub(super) fn at_first(e: &Expr) -> Option<Expr> {
    let first = not(&previous(&truth())?);
    (!super::mentions_next(e)).then(|| conj(e.clone(), first))
}
