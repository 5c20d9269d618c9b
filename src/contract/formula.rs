//! Which part of a GR(1) specification a formula is.
//!
//! Conjunctions are pulled apart, also under `always` (`G (p & G F q)` is `G p & G F q`), `forall` over temporal formulas is
//! written out, repeated operators are dropped. What is then not an initial condition, `always P` or `always eventually P` is refused,
//! pointing at the smallest formula that cannot be taken.

use super::elaborate::Elaborator;
use super::value::Value;
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::{Expr, Formula, Owner, Side, Time, Variable};
use crate::source::{SourceMap, Span};
use crate::syntax::ast::{self, BinaryOp, ExprKind, Quantifier};

/// What a formula's parts are called in reports.
pub(super) struct Label<'t> {
    pub name: String,
    pub requirement: Option<String>,
    pub guarantee: bool,
    pub sources: &'t SourceMap,
    pub variables: &'t [Variable],
}

/// Where a formula stands with respect to temporal operators.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Top,
    Always,
    Justice,
}

/// Adds the parts of a formula to a side.
pub(super) fn classify<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    label: &Label<'_>,
    side: &mut Side,
) {
    visit(e, formula, Place::Top, "", label, side);
}

fn visit<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    place: Place,
    instance: &str,
    label: &Label<'_>,
    side: &mut Side,
) {
    if !temporal(formula) {
        leaf(e, formula, place, instance, label, side);
        return;
    }
    match (&formula.kind, place) {
        (ExprKind::Binary(BinaryOp::And, a, b), Place::Top | Place::Always) => {
            visit(e, a, place, instance, label, side);
            visit(e, b, place, instance, label, side);
        }
        (ExprKind::Always(inner), Place::Top | Place::Always) => {
            visit(e, inner, Place::Always, instance, label, side);
        }
        (ExprKind::Eventually(inner), Place::Always | Place::Justice) => {
            visit(e, inner, Place::Justice, instance, label, side);
        }
        // `G F G F p` is `G F p`.
        (ExprKind::Always(inner), Place::Justice)
            if matches!(inner.kind, ExprKind::Eventually(_)) =>
        {
            visit(e, inner, Place::Justice, instance, label, side);
        }
        (
            ExprKind::Quantifier(Quantifier::Forall, name, domain, body),
            Place::Top | Place::Always,
        ) => {
            let Some(values) = e.quantified(domain) else {
                return;
            };
            for value in values {
                let shown = match &value {
                    Value::Scalar(super::value::Term::Int(i), _) => i.to_string(),
                    _ => String::new(),
                };
                let instance = format!("{instance} [{} = {shown}]", name.text);
                e.with_bound(&name.text, value, |e| {
                    visit(e, body, place, &instance, label, side);
                });
            }
        }
        _ => e.findings.push(refusal(formula, place)),
    }
}

/// Whether `always`, `eventually` or a pattern occurs.
fn temporal(e: &ast::Expr) -> bool {
    matches!(
        e.kind,
        ExprKind::Always(_) | ExprKind::Eventually(_) | ExprKind::Pattern(_)
    ) || e.children().into_iter().any(temporal)
}

/// Whether `next` is written in it, of whatever.
fn speaks_of_next(e: &ast::Expr) -> bool {
    let mut open = vec![e];
    while let Some(e) = open.pop() {
        if matches!(e.kind, ExprKind::Next(_)) {
            return true;
        }
        open.extend(e.children());
    }
    false
}

/// The smallest formula that is in the way, and what to write instead.
fn refusal(formula: &ast::Expr, place: Place) -> Diagnostic {
    let (span, message, help) = match (&formula.kind, place) {
        (ExprKind::Eventually(inner), Place::Top) if matches!(inner.kind, ExprKind::Always(_)) => (
            formula.span,
            "`eventually always` (persistence) is outside GR(1)",
            "let the machine say when it settles: an output that stays true once set, with `always (settled -> P)` and `always eventually settled`",
        ),
        (ExprKind::Eventually(_), Place::Top) => (
            formula.span,
            "`eventually` without `always` is outside GR(1)",
            "write `always eventually P`; for \"once\", remember in an internal variable that P was seen",
        ),
        (ExprKind::Always(_), Place::Justice) => (
            formula.span,
            "`eventually always` (persistence) is outside GR(1)",
            "let the machine say when it settles: an output that stays true once set, with `always (settled -> P)` and `always eventually settled`",
        ),
        (ExprKind::Binary(BinaryOp::Implies, _, b), _) if temporal(b) => (
            smallest(b),
            "a response (`P -> eventually Q`) is outside GR(1) as it stands",
            "hold the request until it is answered, and write `always eventually (not P or Q)`",
        ),
        (ExprKind::Binary(BinaryOp::Or, ..), _) => (
            smallest(formula),
            "a disjunction of temporal formulas is outside GR(1)",
            "decide the case with an internal variable that is fixed at the start",
        ),
        (ExprKind::Not(inner), _) => (
            smallest(inner),
            "a negated temporal formula is outside GR(1) as it stands",
            "push the negation inwards: `not eventually P` is `always not P`",
        ),
        (ExprKind::Next(inner), _) => (
            smallest(inner),
            "`next` of a temporal formula is outside GR(1)",
            "write `next` in front of variables only",
        ),
        _ => (
            smallest(formula),
            "this temporal operator stands where GR(1) has none",
            "an assumption or guarantee is an initial condition, `always P`, or `always eventually P`",
        ),
    };
    Diagnostic::error(codes::NOT_GR1, span, message).with_help(help)
}

/// The span of the outermost temporal operator within.
fn smallest(e: &ast::Expr) -> Span {
    let within = |children: &[&ast::Expr]| {
        children
            .iter()
            .find(|c| temporal(c))
            .map_or(e.span, |c| smallest(c))
    };
    match &e.kind {
        ExprKind::Index(a, b) | ExprKind::Binary(_, a, b) => within(&[a, b]),
        ExprKind::Next(a)
        | ExprKind::Not(a)
        | ExprKind::Neg(a)
        | ExprKind::Quantifier(_, _, _, a) => within(&[a]),
        ExprKind::If(a, b, c) | ExprKind::Within(a, b, c) => within(&[a, b, c]),
        _ => e.span,
    }
}

fn leaf<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    place: Place,
    instance: &str,
    label: &Label<'_>,
    side: &mut Side,
) {
    let Some(term) = e.boolean(formula, Time::Now) else {
        return;
    };
    let Some(expr) = e.formula(&term, formula.span) else {
        return;
    };
    // `always (next true -> P)` holds in every step that another one follows: a transition, and no invariant.
    let primed = expr.mentions_next() || place == Place::Always && speaks_of_next(formula);
    if place == Place::Top && primed {
        e.error_with(
            codes::NOT_GR1,
            formula.span,
            "`next` without `always` is outside GR(1)",
            "write `always (...)`, or describe step 0 without `next`",
        );
        return;
    }
    if !controls(e, formula.span, place, primed, &expr, label) {
        return;
    }
    let text = label
        .sources
        .text(formula.span)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    let temporal = match place {
        Place::Top => "",
        Place::Always => "always ",
        Place::Justice => "always eventually ",
    };
    let formula = Formula {
        name: label.name.clone(),
        requirement: label.requirement.clone(),
        expr,
        span: formula.span,
        text: format!("{temporal}{text}{instance}"),
    };
    match place {
        Place::Top => side.initial.push(formula),
        Place::Always if primed => side.safety.push(formula),
        Place::Always => side.invariants.push(formula),
        Place::Justice => side.justice.push(formula),
    }
}

/// Whether the formula constrains what its side controls; reports it otherwise.
fn controls(
    e: &mut Elaborator<'_>,
    span: Span,
    place: Place,
    primed: bool,
    expr: &Expr,
    label: &Label<'_>,
) -> bool {
    let (mut outputs_now, mut outputs_next) = (None, None);
    let mut any_output = false;
    expr.for_each_var(&mut |v, time| {
        let variable = &label.variables[v.index()];
        if variable.owner == Owner::System {
            any_output = true;
            if time == Time::Next {
                outputs_next.get_or_insert(variable.name.clone());
            } else {
                outputs_now.get_or_insert(variable.name.clone());
            }
        }
    });
    if label.guarantee {
        if !any_output && place != Place::Justice && !matches!(expr, Expr::Const(_)) {
            e.findings.push(
                Diagnostic::warning(
                    codes::NOT_CONTROLLED,
                    span,
                    "this guarantee speaks of inputs only, which the machine does not control",
                )
                .with_help("if the plant promises it, write `assume`"),
            );
        }
        return true;
    }
    let bad = match place {
        Place::Top => outputs_now.map(|v| {
            (v, "an initial assumption speaks of inputs only; say how the machine starts with `guarantee`".to_owned())
        }),
        Place::Always if primed => outputs_next.map(|v| {
            let help = format!("the plant chooses its next inputs without seeing `next {v}`; speak of `{v}` in the step before");
            (v, help)
        }),
        Place::Always => outputs_now.map(|v| {
            let help = format!("say what the plant does after it has seen `{v}`: `always ({v} ... -> next input ...)`");
            (v, help)
        }),
        Place::Justice => None,
    };
    match bad {
        None => true,
        Some((variable, help)) => {
            e.findings.push(
                Diagnostic::error(
                    codes::NOT_CONTROLLED,
                    span,
                    format!("this assumption constrains `{variable}`, which the machine chooses"),
                )
                .with_help(help),
            );
            false
        }
    }
}
