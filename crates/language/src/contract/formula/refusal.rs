//! LW201: findings for formulas outside GR(1), with the reason and a suggested replacement.

use super::forms::{self, Form};
use super::ltl::make;
use super::{Label, Place, first_temporal, mentions_next, temporal};
use crate::contract::elaborate::Names;
use crate::contract::shape::Entry;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Owner;
use linewright_core::source::Span;
use linewright_syntax::ast::{BinaryOp, Domain, Expr, ExprKind, Name, Quantifier, UntilOp};
use linewright_syntax::format;

/// An enclosing quantifier of a formula: its name and domain.
pub(super) type EnclosingQuantifier<'a> = (&'a Name, &'a Domain);

/// Returns the finding for a formula that is outside GR(1) at its position.
pub(super) fn refusal(
    known: &Names<'_>,
    formula: &Expr,
    place: Place,
    quantifiers: &[EnclosingQuantifier<'_>],
    label: &Label<'_>,
) -> Diagnostic {
    let (span, why) = culprit(formula, place);
    let help = match form(known, formula, place, quantifiers, label) {
        Some(help) => help,
        None => match place {
            Place::Top => "write it as an initial condition, `always P`, `always eventually P` or a pattern; see `linewright explain LW201`",
            _ => "write each part as a separate formula, or record earlier steps with `once`, `since` or an internal variable",
        }
        .to_owned(),
    };
    // Authors often overlook that the first `always` of `always eventually a -> always eventually
    // b` applies to the whole implication.
    let help = match (&formula.kind, place) {
        (ExprKind::Binary(BinaryOp::Implies, a, b), Place::Justice) if temporal(b) => format!(
            "{help}; `always` applies to everything after it: put parentheses around `always eventually {}` if it should end before the arrow",
            format::format_expression(a)
        ),
        _ => help,
    };
    Diagnostic::error(codes::NOT_GR1, span, why).with_help(help)
}

/// Describes a GR(1) replacement for a formula; `None` if none is known.
fn form(
    known: &Names<'_>,
    formula: &Expr,
    place: Place,
    quantifiers: &[EnclosingQuantifier<'_>],
    label: &Label<'_>,
) -> Option<String> {
    let whole = super::whole(formula, place);
    let input = |e: &Expr| mentions_only_inputs(known, e, label);
    let free = fresh(known);
    let fresh = quantifiers.is_empty().then_some(free.as_str());
    let of = |formula: &Expr| {
        let form = forms::of(formula, label.guarantee, &input, fresh)?;
        Some(under(form, quantifiers))
    };
    let exact = of(&whole)?;
    // A formula without `always` is usually intended for all steps.
    if place == Place::Top && first_step_only(formula) {
        let meant = of(&make(ExprKind::Always(Box::new(formula.clone()))));
        if let Some(meant) = meant.filter(|m| m.strength == forms::Strength::Equivalent) {
            let rules = |f: &Form| {
                let text = f.text();
                text.trim_end_matches(", which is equivalent").to_owned()
            };
            return Some(format!(
                "for every step, write {}; for the first step only, write {}",
                rules(&meant),
                rules(&exact)
            ));
        }
    }
    Some(format!("write {}", exact.text()))
}

/// Returns whether a formula constrains only the first step, so that its author might have
/// forgotten `always`.
fn first_step_only(formula: &Expr) -> bool {
    match &formula.kind {
        ExprKind::Binary(BinaryOp::Implies, a, b) => {
            !temporal(a) && (temporal(b) || mentions_next(b))
        }
        _ => !temporal(formula),
    }
}

/// Puts these quantifiers around each formula of a form.
fn under(mut form: Form, quantifiers: &[EnclosingQuantifier<'_>]) -> Form {
    for (_, rule) in &mut form.rules {
        for (name, domain) in quantifiers.iter().rev() {
            *rule = make(ExprKind::Quantifier(
                Quantifier::Forall,
                (*name).clone(),
                Box::new((*domain).clone()),
                Box::new(rule.clone()),
            ));
        }
    }
    form
}

/// Returns the position of the part outside GR(1), and the reason.
fn culprit(e: &Expr, place: Place) -> (Span, String) {
    let inner = |e: &Expr, why: &str| {
        let at = first_temporal(e);
        (
            at.span,
            format!("{} {why}; this is outside GR(1)", word(at)),
        )
    };
    match (&e.kind, place) {
        (ExprKind::Until(op, ..), _) => (
            e.span,
            format!("`{}` between two conditions is outside GR(1)", op.word()),
        ),
        (ExprKind::Eventually(inner), _) if matches!(inner.kind, ExprKind::Always(_)) => (
            e.span,
            "`eventually always` (persistence) is outside GR(1)".to_owned(),
        ),
        (ExprKind::Eventually(a), _) if temporal(a) => inner(a, "appears within `eventually`"),
        (ExprKind::Always(a), Place::Justice) if temporal(a) => culprit(a, Place::Always),
        (ExprKind::Always(_), Place::Justice) => (
            e.span,
            "`eventually always` (persistence) is outside GR(1)".to_owned(),
        ),
        (ExprKind::Binary(BinaryOp::Implies, a, _), _) if temporal(a) => {
            inner(a, "is a condition on the whole run before `->`")
        }
        (ExprKind::Binary(BinaryOp::Implies, _, b), _) => match &b.kind {
            ExprKind::Until(..) => culprit(b, place),
            ExprKind::Eventually(x) if temporal(x) => culprit(b, place),
            ExprKind::Eventually(_) => inner(b, "follows `->` without an enclosing `always`"),
            _ => inner(b, "follows `->`"),
        },
        (ExprKind::Pattern(_), _) => (
            e.span,
            "this pattern appears within a larger formula; this is outside GR(1)".to_owned(),
        ),
        (ExprKind::Binary(BinaryOp::Or, ..), _) => inner(e, "is an operand of `or`"),
        (ExprKind::Not(a), _) => inner(a, "follows `not`"),
        (ExprKind::Next(a), _) => inner(a, "follows `next`"),
        (ExprKind::If(..), _) => inner(e, "appears within `if`"),
        (ExprKind::Binary(op, ..), _) if *op != BinaryOp::And => {
            inner(e, &format!("is an operand of `{}`", op.sign()))
        }
        (ExprKind::Quantifier(kind, ..), _) => {
            let outer = match kind {
                Quantifier::Exists => "exists",
                Quantifier::Forall => "forall",
                Quantifier::Count => "count",
                Quantifier::Sum => "sum",
                Quantifier::Array => "array",
            };
            inner(e, &format!("appears within `{outer}`"))
        }
        (_, Place::Justice) => inner(e, "appears within `eventually`"),
        _ => inner(e, "appears within a larger formula"),
    }
}

/// Returns the name that messages use for a temporal operator.
fn word(e: &Expr) -> &'static str {
    match &e.kind {
        ExprKind::Always(a) if matches!(a.kind, ExprKind::Eventually(_)) => "`always eventually`",
        ExprKind::Always(_) => "`always`",
        ExprKind::Eventually(a) if matches!(a.kind, ExprKind::Always(_)) => "`eventually always`",
        ExprKind::Eventually(_) => "`eventually`",
        ExprKind::Until(UntilOp::Strong, ..) => "`until`",
        ExprKind::Until(UntilOp::Weak, ..) => "`unless`",
        ExprKind::Until(UntilOp::Release, ..) => "`release`",
        _ => "a pattern",
    }
}

/// Returns the finding for a formula with `next` but without `always`.
pub(super) fn without_always(
    known: &Names<'_>,
    formula: &Expr,
    quantifiers: &[EnclosingQuantifier<'_>],
    label: &Label<'_>,
) -> Diagnostic {
    let help = form(known, formula, Place::Top, quantifiers, label)
        .unwrap_or_else(|| "write `always (...)`, or describe step 0 without `next`".to_owned());
    let span = first_next(formula).unwrap_or(formula).span;
    Diagnostic::error(
        codes::NOT_GR1,
        span,
        "`next` without `always` is outside GR(1)",
    )
    .with_help(help)
}

fn first_next(e: &Expr) -> Option<&Expr> {
    if matches!(e.kind, ExprKind::Next(_)) {
        return Some(e);
    }
    e.children().into_iter().find_map(first_next)
}

/// Returns whether all variables of a formula are inputs, including those in defines and counters.
fn mentions_only_inputs(known: &Names<'_>, formula: &Expr, label: &Label<'_>) -> bool {
    fn outputs(entry: &Entry, label: &Label<'_>) -> bool {
        match entry {
            Entry::One(id) => label
                .variables
                .get(id.index())
                .is_none_or(|v| v.owner == Owner::System),
            Entry::Many(list) => list.iter().any(|e| outputs(e, label)),
            Entry::Record(members) => members.iter().any(|(_, e)| outputs(e, label)),
        }
    }
    let mut open = vec![formula];
    let mut seen: Vec<&str> = Vec::new();
    while let Some(formula) = open.pop() {
        let mut fine = true;
        formula.for_each_path(&mut |names| {
            let name = names[0].text.as_str();
            if let Some(define) = known.defines.get(name) {
                if !seen.contains(&name) {
                    seen.push(name);
                    open.push(&define.value);
                }
            } else if let Some(counter) = known.counters.get(name) {
                open.extend(std::iter::once(&counter.counts).chain(&counter.resets));
            } else if let Some(entry) = known.variables.get(name) {
                fine &= !outputs(entry, label);
            }
        });
        if !fine {
            return false;
        }
    }
    true
}

/// Returns an unused name for a variable: `settled`, or `settled_2` and so on.
fn fresh(known: &Names<'_>) -> String {
    let names = (1..).map(|n| match n {
        1 => "settled".to_owned(),
        n => format!("settled_{n}"),
    });
    names
        .into_iter()
        .find(|n| !known.contains(n))
        .unwrap_or_else(|| "settled".to_owned())
}
