//! Formats refusals as text.

use crate::diagnostics::{Diagnostic, codes};
use crate::order::supervisor::{Call, Refusal};
use crate::order::{Serialisation, Skills};
use crate::source::Span;

/// Formats calls: `Up, Left & Down`.
pub fn calls(calls: &[Call], skills: &Skills) -> String {
    let calls: Vec<String> = calls.iter().map(|c| c.text(skills)).collect();
    calls.join(", ")
}

/// Formats why a call is refused; the text refers to the call as `it`.
pub fn why(call: Call, refusal: &Refusal, skills: &Skills, serialisation: Serialisation) -> String {
    let name = |skill: &usize| skills.skills[*skill].name.as_str();
    match refusal {
        Refusal::SameComponent {
            component,
            skills: both,
        } => format!(
            "`{}` and `{}` both change `{}`: they cannot be called at once",
            name(&both[0]),
            name(&both[1]),
            skills.components[*component].name
        ),
        Refusal::Recall { skill } => {
            let skill = &skills.skills[*skill];
            let component = &skills.components[skill.component];
            let situation = skill.effect.and_then(|e| component.situations.get(e));
            let it = match call.skills().count() {
                1 => "it".to_owned(),
                _ => format!("`{}`", skill.name),
            };
            format!(
                "{it} changes nothing: `{}` is {} already",
                component.name,
                situation.map_or("there", String::as_str)
            )
        }
        Refusal::Rule { rule, order } => {
            let rule = &skills.rules[*rule].name;
            match (order.as_slice(), serialisation) {
                ([] | [_], _) => format!("it breaks the rule `{rule}`"),
                (order, Serialisation::Every) => {
                    let order: Vec<&str> = order.iter().map(name).collect();
                    format!(
                        "called in the order {}, it breaks the rule `{rule}`",
                        order.join(", ")
                    )
                }
                (_, Serialisation::Some) => {
                    format!(
                        "every order of calling them breaks a rule; the first order breaks `{rule}`"
                    )
                }
            }
        }
        Refusal::Deleted { rule } => format!(
            "the published model deletes this transition for the rule `{}`",
            skills.rules[*rule].name
        ),
    }
}

/// Index of the rule that refuses a call; `None` if no rule does.
pub fn rule(refusal: &Refusal) -> Option<usize> {
    match refusal {
        Refusal::Rule { rule, .. } | Refusal::Deleted { rule } => Some(*rule),
        _ => None,
    }
}

/// Finding for a refused call.
pub fn refused(
    call: Call,
    refusal: &Refusal,
    skills: &Skills,
    serialisation: Serialisation,
    span: Option<Span>,
) -> Diagnostic {
    let finding = Diagnostic::error(
        codes::ORDER_BROKEN,
        span,
        format!(
            "`{}` is refused: {}",
            call.text(skills),
            why(call, refusal, skills, serialisation)
        ),
    );
    match rule(refusal).map(|r| &skills.rules[r]) {
        None => finding,
        Some(rule) if rule.doc.is_empty() => finding.with_label(rule.span, "this rule"),
        Some(rule) => {
            let doc = rule.doc.split_whitespace().collect::<Vec<_>>().join(" ");
            finding.with_label(rule.span, doc)
        }
    }
}
