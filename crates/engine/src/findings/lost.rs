//! LW203: the guarantees that clash in an unrealizable contract, a play that the plant wins, and
//! possible repairs.

use super::{list, play};
use crate::pipeline::Explanation;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::text::{operand, text};
use linewright_core::gr1::{BinaryOp, Expr, Formula, FormulaKind, Owner, Side, Specification};
use linewright_core::source::Span;
use linewright_interchange::{Format, statement as foreign_statement};
use linewright_solver::game::{Advice, GuaranteeRef, NewAssumption, Weakening, negation};
use schemars::JsonSchema;
use serde::Serialize;

/// Returns the finding about an unrealizable contract. `core` holds the names of the guarantees
/// that clash.
pub fn finding(
    specification: &Specification,
    format: Option<Format>,
    span: Span,
    core: &[String],
    explained: Option<&Explanation>,
) -> Diagnostic {
    let s = specification;
    let name = &s.name;
    let advice = explained.and_then(|e| e.advice.as_ref());
    let contradictory = advice.is_some_and(|a| a.contradictory);
    let message = format!("no controller can keep the guarantees of `{name}`");
    let mut finding = Diagnostic::error(codes::UNREALIZABLE, span, message);
    let clashing = spans(&s.guarantees, core);
    let label = match clashing.len() {
        1 => "cannot be kept",
        _ => "cannot be kept together",
    };
    for span in clashing {
        finding = finding.with_label(span, label);
    }
    let matters = matters(s, advice);
    for span in spans(&s.assumptions, &matters) {
        finding = finding.with_label(span, "does not help enough");
    }
    if let Some(explained) = explained
        && let Some(found) = &explained.play
    {
        let clashing = s.guarantees.all().filter(|f| core.contains(&f.name));
        let helping = s.assumptions.all().filter(|f| matters.contains(&f.name));
        let shown = play::mentioned(s, clashing.chain(helping));
        finding = finding.with_note(format!(
            "the plant can always win, for instance like this:\n{}",
            play::table(s, &shown, found)
        ));
    }
    if contradictory {
        finding = finding.with_note(note_on_contradiction(s, advice));
    }
    if let Some(limit) = explained.and_then(|e| e.stopped_by) {
        let remedy = limit.remedy().map(|remedy| format!("; {remedy}"));
        finding = finding.with_note(format!(
            "this explanation is incomplete: {limit}{}",
            remedy.unwrap_or_default()
        ));
    }
    let suggestions = advice
        .map(|a| suggestions(s, format, a))
        .unwrap_or_default();
    let of_kind = |kind: Change| -> Vec<&Suggestion> {
        suggestions.iter().filter(|x| x.kind == kind).collect()
    };
    let mut help = Vec::new();
    for (kind, heading) in [
        (
            Change::Assume,
            "if one of these is true of your plant, add it:",
        ),
        (Change::Weaken, "if a guarantee can be weaker, change it:"),
    ] {
        let lines: Vec<String> = of_kind(kind)
            .into_iter()
            .map(|x| format!("    {}    // {}", x.text, x.cost))
            .collect();
        if !lines.is_empty() {
            help.push(format!("{heading}\n{}", lines.join("\n")));
        }
    }
    let help = if help.is_empty() {
        "weaken a guarantee or add an assumption; `linewright explain LW203` shows how".to_owned()
    } else {
        help.join("\n")
    };
    finding.with_help(help)
}

/// Explains why no further assumption makes the contract realizable.
fn note_on_contradiction(s: &Specification, advice: Option<&Advice>) -> String {
    let refs = advice
        .map(|a| a.contradiction.as_slice())
        .unwrap_or_default();
    let mut names: Vec<String> = Vec::new();
    for guarantee in refs {
        let name = format!("`{}`", guarantee.formula(&s.guarantees).name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    match names.as_slice() {
        [] => {
            "no further assumption helps: the existing assumptions contradict each other".to_owned()
        }
        [one] => {
            format!("no further assumption helps: {one} contradicts itself or the assumptions")
        }
        _ => format!(
            "no further assumption helps: {} contradict each other",
            list(&names)
        ),
    }
}

/// Names of the assumptions that matter: if one of them is left out, fewer guarantees already
/// clash.
fn matters(s: &Specification, advice: Option<&Advice>) -> Vec<String> {
    let refs = advice.map(|a| a.matters.as_slice()).unwrap_or_default();
    let names = refs.iter().map(|a| a.formula(&s.assumptions).name.clone());
    names.collect()
}

/// Places of the formulas with these names; only the outermost of nested places.
fn spans(side: &Side, names: &[String]) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for formula in side.all().filter(|f| names.contains(&f.name)) {
        if !spans.iter().any(|s| s.contains(formula.span)) {
            spans.retain(|s| !formula.span.contains(*s));
            spans.push(formula.span);
        }
    }
    spans
}

/// What a suggestion changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "SuggestionKind")]
pub enum Change {
    /// An assumption is added.
    Assume,
    /// A guarantee is weakened or removed.
    Weaken,
}

/// A change that makes the contract realizable.
#[derive(Debug, Clone, PartialEq, JsonSchema, Serialize)]
pub struct Suggestion {
    /// Kind of change.
    pub kind: Change,
    /// The line to write.
    pub text: String,
    /// Name of the guarantee that the new line replaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replaces: Option<String>,
    /// Share (0 to 1) of the combinations of values: for a new assumption, those that it forbids
    /// the plant; for a weakened guarantee, those in which it no longer has to hold.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share: f64,
    /// The same share in words.
    #[serde(skip)]
    pub cost: String,
}

/// All suggested changes, assumptions first.
///
/// If a `format` is given, the lines are in the notation of that tool wherever it can express them.
pub fn suggestions(s: &Specification, format: Option<Format>, advice: &Advice) -> Vec<Suggestion> {
    let assumed = advice.assumptions.iter().map(|a| assumption(s, format, a));
    let left_out = (!advice.leave_out.is_empty()).then(|| leave_out(s, &advice.leave_out));
    let weaker = advice.weakenings.iter().map(|w| weakening(s, format, w));
    assumed.chain(weaker).chain(left_out).collect()
}

fn leave_out(s: &Specification, guarantees: &[GuaranteeRef]) -> Suggestion {
    let mut names: Vec<String> = Vec::new();
    for guarantee in guarantees {
        let name = format!("`{}`", guarantee.formula(&s.guarantees).name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    Suggestion {
        kind: Change::Weaken,
        text: format!("leave out {}", list(&names)),
        replaces: None,
        share: 1.0,
        cost: "several problems: repair one, then check again".to_owned(),
    }
}

fn assumption(s: &Specification, format: Option<Format>, new: &NewAssumption) -> Suggestion {
    let cost = match new.kind {
        FormulaKind::Justice => "requires something infinitely often".to_owned(),
        FormulaKind::Initial => "only at the start".to_owned(),
        _ => format!(
            "rules out {} of the combinations of values",
            percent(new.forbids)
        ),
    };
    Suggestion {
        kind: Change::Assume,
        text: statement(s, format, Owner::Environment, None, new.kind, &new.formula),
        replaces: None,
        share: new.forbids,
        cost,
    }
}

fn weakening(s: &Specification, format: Option<Format>, weaker: &Weakening) -> Suggestion {
    let formula: &Formula = weaker.guarantee.formula(&s.guarantees);
    let name = &formula.name;
    let (text, cost) = match &weaker.unless {
        None => (
            format!("leave out `{name}`"),
            "no weaker form was found".to_owned(),
        ),
        Some(unless) => {
            let weak = unless_holds(&formula.expr, unless);
            let label = is_label(name).then_some(name.as_str());
            let kind = weaker.guarantee.kind;
            (
                statement(s, format, Owner::System, label, kind, &weak),
                format!(
                    "no longer required in {} of the combinations of values",
                    percent(weaker.gives_up)
                ),
            )
        }
    };
    Suggestion {
        kind: Change::Weaken,
        text,
        replaces: Some(name.clone()),
        share: weaker.gives_up,
        cost,
    }
}

/// Writes a formula as a statement for the file: in the notation of `format` if that can express
/// the formula, otherwise in the notation of contracts.
pub(super) fn statement(
    s: &Specification,
    format: Option<Format>,
    side: Owner,
    label: Option<&str>,
    kind: FormulaKind,
    expr: &Expr,
) -> String {
    let written = format.and_then(|format| foreign_statement(format, s, side, label, kind, expr));
    written.unwrap_or_else(|| {
        let keyword = match side {
            Owner::Environment => "assume",
            Owner::System => "guarantee",
        };
        let label = label.map_or(String::new(), |label| format!("{label}: "));
        format!("{keyword} {label}{}", temporal(s, kind, expr))
    })
}

/// Whether a name can be used as the label of a formula.
fn is_label(name: &str) -> bool {
    name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// Weakens a formula so that it is required only where `unless` does not hold.
fn unless_holds(expr: &Expr, unless: &Expr) -> Expr {
    let not = |unless: &Expr| negation(unless.clone());
    match expr {
        Expr::Binary(BinaryOp::Implies, a, b) => {
            // Conditions that the guarantee already states are not repeated.
            let known = a.conjuncts();
            let rest = unless
                .conjuncts()
                .into_iter()
                .filter(|u| !known.contains(u));
            let rest = rest
                .cloned()
                .reduce(Expr::and)
                .unwrap_or_else(|| unless.clone());
            (**a).clone().and(not(&rest)).implies((**b).clone())
        }
        whole => {
            // `w or (u and not w)` is the same as `w or u`.
            let against = negation(whole.clone());
            let rest = unless.conjuncts().into_iter().filter(|u| **u != against);
            match rest.cloned().reduce(Expr::and) {
                Some(rest) => whole.clone().or(rest),
                None => not(unless).implies(whole.clone()),
            }
        }
    }
}

/// Formats a formula with the keywords of its kind.
fn temporal(s: &Specification, kind: FormulaKind, expr: &Expr) -> String {
    match kind {
        FormulaKind::Initial => text(s, expr),
        FormulaKind::Justice => format!("always eventually {}", operand(s, expr)),
        // A safety formula covers two steps, even if it mentions only one.
        FormulaKind::Safety if !expr.mentions_next() => {
            format!("always (next true -> {})", operand(s, expr))
        }
        _ => format!("always {}", operand_of_always(s, expr)),
    }
}

/// Formats the operand of `always`, with parentheses for readability only: `always` extends to the
/// end of the formula.
fn operand_of_always(s: &Specification, expr: &Expr) -> String {
    match expr {
        Expr::Var(..) | Expr::Unary(..) => text(s, expr),
        _ => format!("({})", text(s, expr)),
    }
}

/// Formats a share as a percentage: `25 %`, `0.3 %`.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 10.0 {
        format!("{percent:.0} %")
    } else if percent >= 0.1 {
        format!("{percent:.1} %")
    } else {
        "less than 0.1 %".to_owned()
    }
}

/// Names of the assumptions that matter, each once: without any one of them, fewer guarantees would
/// already clash.
pub fn relevant_assumptions(s: &Specification, explained: &Explanation) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in matters(s, explained.advice.as_ref()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_rounded() {
        assert_eq!(percent(0.25), "25 %");
        assert_eq!(percent(0.003), "0.3 %");
        assert_eq!(percent(0.000_1), "less than 0.1 %");
    }

    #[test]
    fn names_are_listed() {
        let names = ["a", "b", "c"].map(str::to_owned);
        assert_eq!(list(&names), "a, b and c");
        assert_eq!(list(&names[..1]), "a");
    }
}
