//! Which part of a GR(1) specification a formula is.
//!
//! Conjunctions are pulled apart, also under `always` (`G (p & G F q)` is `G p & G F q`), `forall` over temporal formulas is
//! written out, repeated operators are dropped. Patterns and responses (`always (p -> eventually q)`) become monitors and formulas
//! about them. What is then not an initial condition, `always P` or `always eventually P` is refused, pointing at the smallest formula
//! that cannot be taken.

use super::elaborate::Elaborator;
use super::patterns;
use super::value::Value;
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::monitors::{Kind, Obligation, Origin};
use crate::gr1::{Expr, Owner, Side, Time, VarId, Variable};
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
    e.origin = Origin {
        name: label.name.clone(),
        requirement: label.requirement.clone(),
        span: formula.span,
        text: label.text(formula.span),
    };
    visit(e, formula, Place::Top, "", label, side);
}

impl Label<'_> {
    /// What stands in the file, in one line.
    fn text(&self, span: Span) -> String {
        one_line(self.sources.text(span))
    }
}

/// The words of a formula in one line, without comments: one that ends with its line would take what follows for its own. Formulas
/// hold no texts in quotes.
fn one_line(text: &str) -> String {
    let mut words = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("//").into_iter().chain(rest.find("/*")).min() {
        words.push_str(&rest[..start]);
        words.push(' ');
        let comment = &rest[start..];
        let end = if comment.starts_with("//") {
            comment.find(['\n', '\r'])
        } else {
            comment[2..].find("*/").map(|end| end + 4)
        };
        rest = end.map_or("", |end| &comment[end..]);
    }
    words.push_str(rest);
    let words: Vec<&str> = words.split_whitespace().collect();
    words.join(" ")
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
        (ExprKind::Pattern(pattern), Place::Top) => {
            let origin = origin(formula, instance, label);
            let obligations = patterns::lower(e, pattern, &origin);
            promise(e, obligations, &origin, label, side);
        }
        (ExprKind::Eventually(inner), Place::Top) if !temporal(inner) => {
            let origin = origin(formula, instance, label);
            let obligations = patterns::promised(e, None, inner, &origin);
            promise(e, obligations, &origin, label, side);
        }
        (ExprKind::Binary(BinaryOp::Implies, p, q), Place::Always)
            if !temporal(p)
                && matches!(&q.kind, ExprKind::Eventually(inner) if !temporal(inner)) =>
        {
            if let ExprKind::Eventually(q) = &q.kind {
                let origin = origin(formula, instance, label);
                let obligations = patterns::promised(e, Some(p), q, &origin);
                promise(e, obligations, &origin, label, side);
            }
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
        (ExprKind::Always(_), Place::Justice) => (
            formula.span,
            "`eventually always` (persistence) is outside GR(1)",
            "let the machine say when it settles: an output that stays true once set, with `always (settled -> P)` and `always eventually settled`",
        ),
        (ExprKind::Binary(BinaryOp::Implies, _, b), _) if temporal(b) => (
            smallest(b),
            "an implication of temporal formulas is outside GR(1) as it stands",
            "a response stands alone: `always (P -> eventually Q)`, or `Q responds to P after R`",
        ),
        (ExprKind::Pattern(_), _) => (
            formula.span,
            "this pattern stands within a larger formula, which is outside GR(1)",
            "a pattern is an assumption or guarantee by itself; give each one its own, or use `once`, `since` and `previous` within formulas",
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
    let (kind, temporal) = match place {
        Place::Top => (Kind::Initial, ""),
        Place::Always if primed => (Kind::Safety, "always "),
        Place::Always => (Kind::Invariant, "always "),
        Place::Justice => (Kind::Justice, "always eventually "),
    };
    let origin = Origin {
        text: format!("{temporal}{}{instance}", label.text(formula.span)),
        ..origin(formula, "", label)
    };
    let obligation = Obligation { kind, expr };
    promise(e, Some(vec![obligation]), &origin, label, side);
}

/// The name, place and text of a formula.
fn origin(formula: &ast::Expr, instance: &str, label: &Label<'_>) -> Origin {
    Origin {
        name: label.name.clone(),
        requirement: label.requirement.clone(),
        span: formula.span,
        text: format!("{}{instance}", label.text(formula.span)),
    }
}

/// Adds formulas to a side, if it controls what they constrain. An assumption about monitors is first taken apart.
fn promise(
    e: &mut Elaborator<'_>,
    obligations: Option<Vec<Obligation>>,
    origin: &Origin,
    label: &Label<'_>,
    side: &mut Side,
) {
    for obligation in obligations.unwrap_or_default() {
        let parts = match &e.monitors {
            Some(monitors) if !label.guarantee && monitors.occur_in(&obligation.expr) => {
                monitors.assumed(&obligation)
            }
            _ => vec![obligation],
        };
        let looks_back = parts.len() > 1;
        for part in parts {
            // What was taken apart is told of as one.
            if !controls(e, origin.span, &part, looks_back, label) {
                return;
            }
            part.add_to(side, origin);
        }
    }
}

/// Whether the formula constrains what its side controls; reports it otherwise.
fn controls(
    e: &mut Elaborator<'_>,
    span: Span,
    obligation: &Obligation,
    looks_back: bool,
    label: &Label<'_>,
) -> bool {
    let Obligation { kind, expr } = obligation;
    let kind = *kind;
    let (mut outputs_now, mut outputs_next) = (None, None);
    expr.for_each_var(&mut |v, time| {
        if let Some(variable) = label.variables.get(v.index())
            && variable.owner == Owner::System
        {
            if time == Time::Next {
                outputs_next.get_or_insert(variable.name.clone());
            } else {
                outputs_now.get_or_insert(variable.name.clone());
            }
        }
    });
    if label.guarantee {
        if !speaks_of_outputs(e, expr, label)
            && kind != Kind::Justice
            && !matches!(expr, Expr::Const(_))
        {
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
    let bad = match kind {
        _ if looks_back && kind != Kind::Justice => outputs_now.filter(|_| kind != Kind::Safety).or(outputs_next).map(|v| {
            let help = format!("the plant gives its inputs before it sees `{v}` of the same step; speak of `previous {v}`");
            (v, help)
        }),
        Kind::Initial => outputs_now.map(|v| {
            (v, "an initial assumption speaks of inputs only; say how the machine starts with `guarantee`".to_owned())
        }),
        Kind::Safety => outputs_next.map(|v| {
            let help = format!("the plant chooses its next inputs without seeing `next {v}`; speak of `{v}` in the step before");
            (v, help)
        }),
        Kind::Invariant => outputs_now.map(|v| {
            let help = format!("say what the plant does after it has seen `{v}`: `always ({v} ... -> next input ...)`");
            (v, help)
        }),
        Kind::Justice => None,
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

/// Whether an output occurs, be it in what a monitor follows.
fn speaks_of_outputs(e: &Elaborator<'_>, expr: &Expr, label: &Label<'_>) -> bool {
    let mut found = false;
    let mut seen: Vec<VarId> = Vec::new();
    let mut open = Vec::new();
    let visit = |expr: &Expr, open: &mut Vec<VarId>, found: &mut bool| {
        expr.for_each_var(&mut |v, _| match label.variables.get(v.index()) {
            Some(variable) => *found |= variable.owner == Owner::System,
            None => open.push(v),
        });
    };
    visit(expr, &mut open, &mut found);
    while let Some(v) = open.pop() {
        let monitor = e.monitors.as_ref().and_then(|m| m.get(v));
        if let Some(monitor) = monitor
            && !seen.contains(&v)
        {
            seen.push(v);
            visit(&monitor.update, &mut open, &mut found);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn a_text_in_one_line_has_no_comments() {
        for (text, wanted) in [
            ("a -> b", "a -> b"),
            ("(a\n    -> b)\tand  c", "(a -> b) and c"),
            ("a // not ) b\n or b", "a or b"),
            ("a // all\r\nor b // (", "a or b"),
            ("a /* ( // */ or /**/ b", "a or b"),
            ("a/*)*/or/*(*/b", "a or b"),
            ("a or /* never closed", "a or"),
            ("x / 2 * y / z", "x / 2 * y / z"),
            ("x // /* y\n * 2", "x * 2"),
            ("x /*/ y */ * 2", "x * 2"),
            ("", ""),
        ] {
            assert_eq!(one_line(text), wanted, "{text}");
        }
    }
}
