//! Findings where a realizable contract demands less than it seems to: LW212 to LW219.

use super::shown;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::text::{operand, text};
use linewright_core::gr1::{BinaryOp, Expr, Formula, Specification, Time, VarId};
use linewright_solver::game::{GuaranteeRef, Shape, negation};

/// Returns the findings.
pub fn findings(specification: &Specification, found: &Shape) -> Vec<Diagnostic> {
    let s = specification;
    let mut findings = Vec::new();
    let formula = |g: &GuaranteeRef| -> &Formula { g.formula(&s.guarantees) };
    let variable = |v: VarId| (&s.variable(v).name, s.variable(v).span);
    for guarantee in &found.unbreakable {
        let formula = formula(guarantee);
        findings.push(
            Diagnostic::warning(
                codes::UNBREAKABLE,
                formula.span,
                format!(
                    "nothing the machine does could break `{}`: the domains and the assumptions ensure it already",
                    formula.name
                ),
            )
            .with_help("leave it out, or say what it was meant to ask of the machine"),
        );
    }
    for guarantee in &found.unreachable {
        if found.unbreakable.contains(guarantee) {
            continue;
        }
        let formula = formula(guarantee);
        findings.push(
            Diagnostic::warning(
                codes::NEVER_ASKED,
                formula.span,
                format!(
                    "`{}` never asks for anything: the condition before its `->` never holds, whatever the controller does",
                    formula.name
                ),
            )
            .with_help(
                "look for a guarantee or an assumption that forbids that situation, or for a slip in the condition",
            ),
        );
    }
    for assumption in &found.unneeded {
        let formula = assumption.formula(&s.assumptions);
        findings.push(
            Diagnostic::warning(
                codes::NEVER_ASKED,
                formula.span,
                format!(
                    "`{}` never asks for anything of the plant: the condition before its `->` never holds, whatever the controller does",
                    formula.name
                ),
            )
            .with_help(
                "look for a guarantee or an assumption that forbids that situation, or for a slip in the condition; if it is as it should be, leave the assumption out",
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
                    "no guarantee restricts `{name}`: the machine may give it any value at any time"
                ),
            )
            .with_help(
                "say in a guarantee what it is to be, or make it an input if the plant decides it",
            ),
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
                "look for the guarantees that leave it no other value, or leave the output out",
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
        findings.push(
            Diagnostic::warning(
                codes::UNFRAMED,
                span,
                format!(
                    "in some situations nothing restricts the next value of `{name}`: the machine may give it any value"
                ),
            )
            .with_label(fixer.span, "elsewhere this fixes its next value")
            .with_note(match shown(s, &unframed.situation) {
                Some(values) => format!("one such situation is {values}"),
                None => "this is so in every situation that can occur".to_owned(),
            })
            .with_help(frame(s, unframed.variable)),
        );
    }
    for request in &found.requests {
        let (name, span) = variable(request.output);
        let up = text(s, &request.request);
        let completes = format!(
            "guarantee completes: always eventually ({} or {})",
            operand(s, &negation(request.request.clone())),
            operand(s, &request.done)
        );
        let mut finding = if request.enforceable {
            Diagnostic::warning(
                codes::REQUEST_OPEN,
                span,
                format!("nothing asks that the request `{up}` is ever completed: `{name}` may stay away for ever"),
            )
            .with_help(format!("add `{completes}`"))
        } else {
            Diagnostic::warning(
                codes::BY_CHANCE,
                span,
                format!("the request `{up}` is completed by chance only: no controller can make sure that `{name}` comes"),
            )
            .with_help(format!(
                "add `{completes}`, and mend what `check` then says: mostly the plant changes what was asked for, or drops the request"
            ))
        };
        if let Some(held) = request.held_by {
            let formula = held.formula(&s.assumptions);
            finding = finding.with_label(formula.span, "this says what is held until it is done");
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
            .with_help(
                "ask for what the machine is there for, with your own conditions for `requested` and `done`: `guarantee completes: always eventually (not requested or done)`",
            ),
        );
    }
    findings
}

/// A frame for an output: its value stays unless a condition holds under which a guarantee sets it.
fn frame(s: &Specification, v: VarId) -> String {
    let name = &s.variable(v).name;
    let mut conditions: Vec<String> = Vec::new();
    for formula in &s.guarantees.safety {
        for part in formula.expr.conjuncts() {
            if let Expr::Binary(BinaryOp::Implies, before, after) = part
                && sets(after, v)
                && !before.mentions_next()
            {
                let text = operand(s, before);
                if !conditions.contains(&text) {
                    conditions.push(text);
                }
            }
        }
    }
    let made_up = |formula: &Formula| {
        let mut found = false;
        formula
            .expr
            .for_each_var(&mut |w, _| found |= s.is_auxiliary(w));
        found
    };
    let mut setting = s.guarantees.safety.iter().filter(|f| sets(&f.expr, v));
    if conditions.is_empty() || setting.any(made_up) {
        return format!("say in a guarantee when it stays: `next {name} = {name}`");
    }
    let moves = conditions.join(" or ");
    let moves = match conditions.as_slice() {
        [_] => moves,
        _ => format!("({moves})"),
    };
    format!("say that it stays: `guarantee frame: always (not {moves} -> next {name} = {name})`")
}

/// Whether the next value of a variable occurs in a formula.
pub(super) fn sets(expr: &Expr, v: VarId) -> bool {
    let mut found = false;
    expr.for_each_var(&mut |w, t| found |= w == v && t == Time::Next);
    found
}
