//! Classification: finds the part of a GR(1) specification to which a formula belongs.
//!
//! Conjunctions are split, also under `always` (`G (p & G F q)` is `G p & G F q`). `forall` over
//! temporal formulas is expanded, and repeated operators are dropped. Patterns and responses
//! (`always (p -> eventually q)`) become monitors and formulas over them. The remaining formulas
//! have to be initial conditions, `always P` or `always eventually P`; others are rejected
//! ([`refusal`]). The finding points at the smallest formula outside GR(1), and suggests a GR(1)
//! form if possible ([`ltl`], [`forms`]).

mod control;
mod forms;
mod ltl;
mod refusal;

use super::elaborate::Elaborator;
use super::patterns;
use super::value::Value;
use linewright_core::gr1::monitors::{Obligation, Origin};
use linewright_core::gr1::{FormulaKind, Side, Time, Variable};
use linewright_core::source::{SourceMap, Span};
use linewright_syntax::ast::{self, BinaryOp, ExprKind, Quantifier};
use refusal::EnclosingQuantifier;

/// Name and context of an assumption or guarantee, shared by all of its parts.
pub(super) struct Label<'t> {
    pub name: String,
    pub requirement: Option<String>,
    pub guarantee: bool,
    pub sources: &'t SourceMap,
    pub variables: &'t [Variable],
}

/// Position of a formula relative to temporal operators.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Top,
    Always,
    Justice,
}

/// Context of a formula within its assumption or guarantee.
#[derive(Clone)]
struct At<'a> {
    place: Place,
    /// Values of the quantified names as text, appended to the text of the formula.
    instance: String,
    /// Enclosing quantifiers.
    quantifiers: Vec<EnclosingQuantifier<'a>>,
}

impl Place {
    /// The temporal operators for which the place stands.
    fn words(self) -> &'static str {
        match self {
            Self::Top => "",
            Self::Always => "always ",
            Self::Justice => "always eventually ",
        }
    }
}

impl At<'_> {
    fn under(&self, place: Place) -> Self {
        Self {
            place,
            ..self.clone()
        }
    }
}

/// Returns a formula inside the temporal operators for which `place` stands.
fn whole(formula: &ast::Expr, place: Place) -> ast::Expr {
    let under = |kind: fn(Box<ast::Expr>) -> ExprKind, inner: ast::Expr| ast::Expr {
        span: inner.span,
        kind: kind(Box::new(inner)),
    };
    match place {
        Place::Top => formula.clone(),
        Place::Always => under(ExprKind::Always, formula.clone()),
        Place::Justice => under(
            ExprKind::Always,
            under(ExprKind::Eventually, formula.clone()),
        ),
    }
}

/// Splits an assumption or guarantee into the parts of a GR(1) specification and adds them to a
/// side. Reports parts outside GR(1).
pub(super) fn classify<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    label: &Label<'_>,
    side: &mut Side,
) {
    e.memory.origin = Origin {
        name: label.name.clone(),
        requirement: label.requirement.clone(),
        span: formula.span,
        text: label.text(formula.span),
    };
    let at = At {
        place: Place::Top,
        instance: String::new(),
        quantifiers: Vec::new(),
    };
    visit(e, formula, &at, label, side);
}

impl Label<'_> {
    /// Returns the source text of a formula on one line.
    fn text(&self, span: Span) -> String {
        one_line(self.sources.text(span))
    }

    /// Returns the source text of a formula after the temporal operators `words`, in brackets if it
    /// has some in the source, or if the operators would otherwise belong to its first operand.
    fn text_under(&self, words: &str, formula: &ast::Expr) -> String {
        let text = self.text(formula.span);
        let binds_looser = match &formula.kind {
            ExprKind::Binary(op, ..) => matches!(
                op,
                BinaryOp::Iff | BinaryOp::Implies | BinaryOp::Or | BinaryOp::Xor | BinaryOp::And
            ),
            ExprKind::Since(..) => true,
            _ => false,
        };
        if words.is_empty() {
            text
        } else if binds_looser || self.is_in_brackets(formula.span) {
            format!("{words}({text})")
        } else {
            format!("{words}{text}")
        }
    }

    /// Whether brackets around this place in the source enclose nothing else.
    fn is_in_brackets(&self, span: Span) -> bool {
        let text = &self.sources.file(span.file).text;
        let before = text.get(..span.start as usize).unwrap_or_default();
        let after = text.get(span.end as usize..).unwrap_or_default();
        before.trim_end().ends_with('(') && after.trim_start().starts_with(')')
    }
}

/// Returns the text of a formula on one line. Comments are removed, because a line comment would
/// also include the words that followed on the next line. Formulas contain no strings.
pub(super) fn one_line(text: &str) -> String {
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
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Adds a formula to a side; returns whether its shape is in GR(1). A formula outside GR(1) is
/// reported once, not for each value of its quantified names.
fn visit<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    at: &At<'a>,
    label: &Label<'_>,
    side: &mut Side,
) -> bool {
    let place = at.place;
    if !temporal(formula) {
        return leaf(e, formula, at, label, side);
    }
    match (&formula.kind, place) {
        (ExprKind::Binary(BinaryOp::And, a, b), Place::Top | Place::Always) => {
            let first = visit(e, a, at, label, side);
            visit(e, b, at, label, side) && first
        }
        (ExprKind::Always(inner), Place::Top | Place::Always) => {
            visit(e, inner, &at.under(Place::Always), label, side)
        }
        (ExprKind::Pattern(pattern), Place::Top) => {
            let origin = origin(formula, at, label);
            let obligations = patterns::lower(e, pattern, &origin);
            add_obligations(e, obligations, (formula, place), &origin, label, side);
            true
        }
        (ExprKind::Eventually(inner), Place::Top) if !temporal(inner) => {
            let origin = origin(formula, at, label);
            let obligations = patterns::response(e, None, inner, &origin);
            add_obligations(e, obligations, (formula, place), &origin, label, side);
            true
        }
        (ExprKind::Binary(BinaryOp::Implies, p, q), Place::Always)
            if !temporal(p)
                && matches!(&q.kind, ExprKind::Eventually(inner) if !temporal(inner)) =>
        {
            if let ExprKind::Eventually(q) = &q.kind {
                let origin = origin(formula, at, label);
                let obligations = patterns::response(e, Some(p), q, &origin);
                add_obligations(e, obligations, (formula, place), &origin, label, side);
            }
            true
        }
        (ExprKind::Eventually(inner), Place::Always | Place::Justice) if !matches!(&inner.kind, ExprKind::Always(x) if !matches!(x.kind, ExprKind::Eventually(_))) => {
            visit(e, inner, &at.under(Place::Justice), label, side)
        }
        // `G F G F p` is `G F p`.
        (ExprKind::Always(inner), Place::Justice)
            if matches!(inner.kind, ExprKind::Eventually(_)) =>
        {
            visit(e, inner, at, label, side)
        }
        (
            ExprKind::Quantifier(Quantifier::Forall, name, domain, body),
            Place::Top | Place::Always,
        ) => {
            let Some(values) = e.quantified(domain) else {
                return true;
            };
            for value in values {
                let shown = match &value {
                    Value::Scalar(super::value::Term::Int(i), _) => i.to_string(),
                    _ => String::new(),
                };
                let mut at = at.clone();
                at.instance = format!("{} [{} = {shown}]", at.instance, name.text);
                at.quantifiers.push((name, domain));
                if !e.with_bound(&name.text, value, |e| visit(e, body, &at, label, side)) {
                    return false;
                }
            }
            true
        }
        _ => {
            let finding = refusal::refusal(&e.names, formula, place, &at.quantifiers, label);
            e.findings.push(finding);
            false
        }
    }
}

/// Returns whether the formula contains `always`, `eventually`, `until` or a pattern.
fn temporal(e: &ast::Expr) -> bool {
    is_temporal(e) || e.children().into_iter().any(temporal)
}

/// Returns whether the formula itself is a temporal operator or a pattern.
fn is_temporal(e: &ast::Expr) -> bool {
    matches!(
        e.kind,
        ExprKind::Always(_) | ExprKind::Eventually(_) | ExprKind::Pattern(_) | ExprKind::Until(..)
    )
}

/// Returns whether the formula contains `next`, even if it is applied to a constant.
fn mentions_next(e: &ast::Expr) -> bool {
    let mut open = vec![e];
    while let Some(e) = open.pop() {
        if matches!(e.kind, ExprKind::Next(_)) {
            return true;
        }
        open.extend(e.children());
    }
    false
}

/// Returns the first outermost temporal operator in a formula.
fn first_temporal(e: &ast::Expr) -> &ast::Expr {
    if is_temporal(e) {
        return e;
    }
    let mut children = e.children().into_iter();
    children.find(|c| temporal(c)).map_or(e, first_temporal)
}

/// Adds a formula without temporal operators to a side; returns whether its shape is in GR(1).
fn leaf<'a>(
    e: &mut Elaborator<'a>,
    formula: &'a ast::Expr,
    at: &At<'a>,
    label: &Label<'_>,
    side: &mut Side,
) -> bool {
    let place = at.place;
    let Some(term) = e.boolean(formula, Time::Now) else {
        return true;
    };
    let Some(expr) = e.formula(&term, formula.span) else {
        return true;
    };
    // `always (next true -> P)` is a condition on transitions, not an invariant, because it
    // requires `P` only in steps that have a next step.
    let primed = expr.mentions_next() || place == Place::Always && mentions_next(formula);
    if place == Place::Top && primed {
        let finding = refusal::without_always(&e.names, formula, &at.quantifiers, label);
        e.findings.push(finding);
        return false;
    }
    let kind = match place {
        Place::Top => FormulaKind::Initial,
        Place::Always if primed => FormulaKind::Safety,
        Place::Always => FormulaKind::Invariant,
        Place::Justice => FormulaKind::Justice,
    };
    let origin = origin(formula, at, label);
    let obligation = Obligation { kind, expr };
    add_obligations(
        e,
        Some(vec![obligation]),
        (formula, place),
        &origin,
        label,
        side,
    );
    true
}

/// Returns the name, position and text of a formula, with the temporal operators around it.
fn origin(formula: &ast::Expr, at: &At<'_>, label: &Label<'_>) -> Origin {
    Origin {
        name: label.name.clone(),
        requirement: label.requirement.clone(),
        span: formula.span,
        text: label.text_under(at.place.words(), formula) + &at.instance,
    }
}

/// Adds formulas to a side, if the side controls the variables that they constrain. An assumption
/// over monitors is split first.
fn add_obligations(
    e: &mut Elaborator<'_>,
    obligations: Option<Vec<Obligation>>,
    (formula, place): (&ast::Expr, Place),
    origin: &Origin,
    label: &Label<'_>,
    side: &mut Side,
) {
    for obligation in obligations.unwrap_or_default() {
        let parts = match &e.memory.monitors {
            Some(monitors) if !label.guarantee && monitors.occur_in(&obligation.expr) => {
                monitors.as_assumptions(&obligation)
            }
            _ => vec![obligation],
        };
        let looks_back = parts.len() > 1;
        for part in parts {
            // A formula that was split is reported only once.
            if !control::controls(e, (formula, place), &part, looks_back, label) {
                return;
            }
            part.add_to(side, origin);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::one_line;
    use crate::contract::load;
    use std::fmt::Write as _;

    #[test]
    fn the_text_of_a_formula_keeps_its_brackets() {
        let mut source = "contract A {\n    input a, b: bool\n    output c: bool\n".to_owned();
        let formulas = [
            ("a -> c", "a -> c"),
            ("always (a -> c)", "always (a -> c)"),
            ("always c", "always c"),
            ("always (next c)", "always (next c)"),
            ("always eventually (c or b)", "always eventually (c or b)"),
            ("always (a -> eventually c)", "always (a -> eventually c)"),
            (
                "always (forall i in 0..0: a -> c)",
                "always (forall i in 0..0: a -> c)",
            ),
            (
                "always ((a or b -> c) and eventually c)",
                "always (a or b -> c)",
            ),
        ];
        for (formula, _) in formulas {
            let _ = writeln!(source, "    guarantee {formula}");
        }
        source += "}\n";
        let none = |path: &str, _: &str| Err(format!("{path} is not needed"));
        let (library, findings) = load(&[("a.lw".to_owned(), source)], &none);
        let [contract] = library.contracts.as_slice() else {
            panic!("{findings:?}");
        };
        let guarantees = &contract.specification.guarantees;
        for (number, (_, wanted)) in formulas.iter().enumerate() {
            let name = format!("guarantee {}", number + 1);
            let mut own = guarantees.all().filter(|formula| formula.name == name);
            let texts: Vec<&str> = own.by_ref().map(|formula| formula.text.as_str()).collect();
            assert!(texts.contains(wanted), "{wanted:?} is not in {texts:?}");
        }
    }

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
