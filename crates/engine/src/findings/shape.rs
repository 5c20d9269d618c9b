//! Findings about formulas of a realizable contract that demand less than they seem to: LW212 to
//! LW219.

use super::lost::statement;
use super::shown;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::text::text;
use linewright_core::gr1::{
    BinaryOp, Expr, Formula, FormulaKind, Owner, Side, Specification, Time, VarId,
};
use linewright_core::source::Span;
use linewright_interchange::Format;
use linewright_solver::game::{GuaranteeRef, WeaknessFindings, negation};

/// Whether a formula of `idle` is reported. Several formulas can come from the same text, such as a
/// quantifier, a conjunction or a rule of a skill order: only the first of them is reported, and
/// only if none of them requires anything.
fn is_reported(side: &Side, at: GuaranteeRef, idle: &[GuaranteeRef]) -> bool {
    let formula = at.formula(side);
    let is_sibling = |f: &Formula| f.span == formula.span && !f.defines;
    let siblings = side.formulas().filter(|(.., f)| is_sibling(f));
    let siblings = siblings.map(|(kind, index, _)| GuaranteeRef { kind, index });
    let siblings: Vec<GuaranteeRef> = siblings.collect();
    let first = idle.iter().find(|other| siblings.contains(other));
    first == Some(&at) && siblings.iter().all(|sibling| idle.contains(sibling))
}

/// Places of the first guarantees, besides one, that are about the next value of a variable.
fn others_about_next(s: &Specification, variable: VarId, besides: &Formula) -> Vec<Span> {
    const MOST: usize = 3;
    let is_about = |formula: &&Formula| {
        let mut is_about = false;
        formula.expr.for_each_var(&mut |v, time| {
            is_about |= v == variable && time == Time::Next;
        });
        is_about && !formula.defines && formula.span != besides.span
    };
    let mut spans: Vec<Span> = Vec::new();
    for formula in s.guarantees.safety.iter().filter(is_about) {
        if !spans.contains(&formula.span) {
            spans.push(formula.span);
        }
    }
    spans.truncate(MOST);
    spans
}

/// Returns the findings. If a `format` is given, suggestions are in the notation of that tool
/// wherever it can express them.
pub fn findings(
    specification: &Specification,
    format: Option<Format>,
    found: &WeaknessFindings,
) -> Vec<Diagnostic> {
    let s = specification;
    let mut findings = Vec::new();
    let formula = |g: &GuaranteeRef| -> &Formula { g.formula(&s.guarantees) };
    let variable = |v: VarId| (&s.variable(v).name, s.variable(v).span);
    for guarantee in &found.unbreakable {
        if !is_reported(&s.guarantees, *guarantee, &found.unbreakable) {
            continue;
        }
        let formula = formula(guarantee);
        findings.push(
            Diagnostic::warning(
                codes::UNBREAKABLE,
                formula.span,
                format!(
                    "the machine cannot break `{}`: the domains and the assumptions already ensure it",
                    formula.name
                ),
            )
            .with_help("remove it, or write what it was meant to require of the machine"),
        );
    }
    for guarantee in &found.unreachable {
        if found.unbreakable.contains(guarantee)
            || !is_reported(&s.guarantees, *guarantee, &found.unreachable)
        {
            continue;
        }
        let formula = formula(guarantee);
        findings.push(
            Diagnostic::warning(
                codes::CONDITION_NEVER_HOLDS,
                formula.span,
                format!(
                    "`{}` never requires anything: the condition before its `->` never holds, whatever the controller does",
                    formula.name
                ),
            )
            .with_help(
                "look for a guarantee or an assumption that excludes the condition, or for a mistake in the condition",
            ),
        );
    }
    for assumption in &found.unneeded {
        if !is_reported(&s.assumptions, *assumption, &found.unneeded) {
            continue;
        }
        let formula = assumption.formula(&s.assumptions);
        findings.push(
            Diagnostic::warning(
                codes::CONDITION_NEVER_HOLDS,
                formula.span,
                format!(
                    "`{}` never requires anything of the plant: the condition before its `->` never holds, whatever the controller does",
                    formula.name
                ),
            )
            .with_help(
                "look for a guarantee or an assumption that excludes the condition, or for a mistake in the condition; if the condition is as intended, remove the assumption",
            ),
        );
    }
    for v in &found.unconstrained {
        let (name, span) = variable(*v);
        findings.push(
            Diagnostic::warning(
                codes::UNCONSTRAINED,
                span,
                format!(
                    "no guarantee restricts `{name}`: the machine can give it any value at any time"
                ),
            )
            .with_help("add a guarantee about it, or make it an input if the plant sets it"),
        );
    }
    for (v, value) in &found.constant {
        let (name, span) = variable(*v);
        let value = s.variable(*v).show(*value);
        findings.push(
            Diagnostic::warning(
                codes::CONSTANT,
                span,
                format!(
                    "`{name}` is {value} in every step, whatever the plant and the controller do"
                ),
            )
            .with_help(
                "look for the guarantees that exclude all other values, or remove the output",
            ),
        );
    }
    let mut framed = Vec::new();
    for unframed in &found.unframed {
        let (name, span) = variable(unframed.variable);
        // The elements of an array are declared together.
        if framed.contains(&span) {
            continue;
        }
        framed.push(span);
        let fixer = formula(&unframed.fixed_by);
        let mut finding =
            Diagnostic::warning(
                codes::UNFRAMED,
                span,
                format!(
                    "in some situations nothing restricts the next value of `{name}`: the machine can give it any value"
                ),
            )
            .with_label(
                fixer.span,
                format!("in other situations, this formula determines the next value of `{name}`"),
            )
            .with_note(match shown(s, &unframed.situation) {
                Some(values) => format!("one such situation is {values}"),
                None => "this is the case in every situation that can occur".to_owned(),
            })
            .with_help(frame(s, format, unframed.variable));
        for span in others_about_next(s, unframed.variable, fixer) {
            finding = finding.with_label(span, "this formula is also about its next value");
        }
        findings.push(finding);
    }
    for request in &found.requests {
        let (name, span) = variable(request.output);
        let up = text(s, &request.request);
        let answered = negation(request.request.clone()).or(request.done.clone());
        let completes = guarantee(s, format, "completes", FormulaKind::Justice, &answered);
        let mut finding = if request.enforceable {
            Diagnostic::warning(
                codes::REQUEST_OPEN,
                span,
                format!("no guarantee completes the request `{up}`: `{name}` may never answer it"),
            )
            .with_help(format!("add `{completes}`"))
        } else {
            Diagnostic::warning(
                codes::REQUEST_BY_CHANCE,
                span,
                format!("the request `{up}` is completed only by chance: no controller can ensure that `{name}` answers it"),
            )
            .with_help(format!(
                "add `{completes}`, then repair what `check` reports: usually the plant changes or drops the request"
            ))
        };
        if let Some(held) = request.held_by {
            let formula = held.formula(&s.assumptions);
            finding = finding.with_label(formula.span, "this holds the request until it is done");
        }
        findings.push(finding);
    }
    if found.idle
        && let Some(output) = s.outputs().find(|v| !s.variable(*v).internal)
    {
        let (_, span) = variable(output);
        findings.push(
            Diagnostic::warning(
                codes::IDLE,
                span,
                format!("a machine that never changes an output keeps `{}`", s.name),
            )
            .with_help(match format {
                None => "require what the machine is for, with your own conditions for `requested` and `done`: `guarantee completes: always eventually (not requested or done)`",
                Some(_) => "require what the machine is for, as a guarantee that holds again and again",
            }),
        );
    }
    findings
}

/// Writes a guarantee as a statement for the file.
fn guarantee(
    s: &Specification,
    format: Option<Format>,
    label: &str,
    kind: FormulaKind,
    expr: &Expr,
) -> String {
    statement(s, format, Owner::System, Some(label), kind, expr)
}

/// Suggests a guarantee by which an output keeps its value. The exceptions are the conditions under
/// which the existing guarantees set the output.
fn frame(s: &Specification, format: Option<Format>, v: VarId) -> String {
    let mut conditions: Vec<&Expr> = Vec::new();
    for formula in &s.guarantees.safety {
        for part in formula.expr.conjuncts() {
            if let Expr::Binary(BinaryOp::Implies, before, after) = part
                && sets(after, v)
                && !before.mentions_next()
                && !conditions.contains(&&**before)
            {
                conditions.push(before);
            }
        }
    }
    let mentions_auxiliary = |formula: &Formula| {
        let mut found = false;
        formula
            .expr
            .for_each_var(&mut |w, _| found |= s.is_auxiliary(w));
        found
    };
    let keeps = Expr::Var(v, Time::Next).equals(Expr::Var(v, Time::Now));
    let mut setting = s.guarantees.safety.iter().filter(|f| sets(&f.expr, v));
    let moves = conditions.into_iter().cloned().reduce(Expr::or);
    match moves {
        Some(moves) if !setting.any(mentions_auxiliary) => {
            let frame = Expr::not(moves).implies(keeps);
            format!(
                "let it keep its value: `{}`",
                guarantee(s, format, "frame", FormulaKind::Safety, &frame)
            )
        }
        _ if format.is_none() => format!(
            "add a guarantee that states when it keeps its value: `{}`",
            text(s, &keeps)
        ),
        _ => "add a guarantee that states when it keeps its value".to_owned(),
    }
}

/// Whether the next value of a variable occurs in a formula.
pub(super) fn sets(expr: &Expr, v: VarId) -> bool {
    let mut found = false;
    expr.for_each_var(&mut |w, t| found |= w == v && t == Time::Next);
    found
}
