//! The skills that a machine calls, and when: each set with one condition over wires a skill.

use super::Parts;
use crate::contract::elaborate::Elaborator;
use crate::contract::machine::Orders;
use crate::contract::scope::Scope;
use crate::contract::skills::{level, listed, near_or_all};
use crate::diagnostics::{Diagnostic, codes};
use crate::gr1::{Expr, Time};
use crate::order::{Level, Skills};
use crate::source::Span;
use crate::syntax::ast::{self, MachineItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The sets of skills that the machine calls, every skill bound.
pub(super) fn orders<'a>(
    wires: &mut Elaborator<'a>,
    parts: &Parts<'a>,
    scope: &Scope<'_>,
) -> Vec<Orders> {
    let decls = parts.machine.items.iter().filter_map(|item| match item {
        MachineItem::Skills(decl) => Some(decl),
        _ => None,
    });
    let mut sets: BTreeMap<&str, Span> = BTreeMap::new();
    let mut orders = Vec::new();
    for decl in decls {
        let set = &decl.set;
        if let Some(first) = sets.insert(&set.text, set.span) {
            wires.findings.push(
                Diagnostic::error(
                    codes::NAME_DOUBLE,
                    set.span,
                    format!("the skills of `{}` stand twice", set.text),
                )
                .with_label(first, "first here")
                .with_help("leave one of the two out"),
            );
        }
        let level = level(decl.level.as_ref(), &Level::ALL, &mut wires.findings);
        // What is wrong with a condition is said whatever is wrong with the set.
        let called = called(wires, decl);
        let Some(skills) = skills(wires, scope, set) else {
            continue;
        };
        let when = conditions(wires, decl, &skills, called);
        let (Some(level), Some(when)) = (level, when) else {
            wires.tainted = true;
            continue;
        };
        orders.push(Orders {
            skills,
            level,
            when,
            of: String::new(),
            span: set.span,
        });
    }
    orders
}

/// The set of a name; one that cannot be used was reported.
fn skills(wires: &mut Elaborator<'_>, scope: &Scope<'_>, name: &ast::Name) -> Option<Arc<Skills>> {
    match scope.skills.get(name.text.as_str()) {
        Some(Some(skills)) => Some(Arc::clone(skills)),
        Some(None) => {
            wires.tainted = true;
            None
        }
        None => {
            let known = scope.skills.keys().copied();
            let help = match known.len() {
                0 => "import the file that declares it".to_owned(),
                _ => near_or_all(&name.text, known, "those in sight are"),
            };
            wires.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there are no skills `{}`", name.text),
                help,
            );
            None
        }
    }
}

/// By name: where the name stands, and the condition, unless something is wrong with it.
type Called<'a> = BTreeMap<&'a str, (Span, Option<Expr>)>;

fn called<'a>(wires: &mut Elaborator<'a>, decl: &'a ast::SkillCalls) -> Called<'a> {
    let mut called = Called::new();
    for call in &decl.calls {
        let term = wires.boolean(&call.value, Time::Now);
        let expr = term.and_then(|t| wires.formula(&t, call.value.span));
        let name = &call.name;
        if let Some((first, _)) = called.get(name.text.as_str()) {
            wires.findings.push(
                Diagnostic::error(
                    codes::NAME_DOUBLE,
                    name.span,
                    format!("`{}` is bound twice", name.text),
                )
                .with_label(*first, "first here")
                .with_help("join the two with `or`"),
            );
            continue;
        }
        called.insert(&name.text, (name.span, expr));
    }
    called
}

/// One condition a skill, in the order of the skills. `None` when something is wrong; it was reported.
fn conditions(
    wires: &mut Elaborator<'_>,
    decl: &ast::SkillCalls,
    skills: &Skills,
    mut called: Called<'_>,
) -> Option<Vec<Expr>> {
    let name = &decl.set.text;
    let bound: Vec<_> = { skills.skills.iter() }
        .map(|skill| called.remove(skill.name.as_str()))
        .collect();
    let missing = skills.skills.iter().zip(&bound);
    let missing: Vec<&str> = missing
        .filter(|(_, bound)| bound.is_none())
        .map(|(skill, _)| skill.name.as_str())
        .collect();
    for (unknown, (span, _)) in &called {
        // A name with a slip is one of those that are missing, rather than another that is there.
        let known = missing.iter().copied();
        let all = skills.skills.iter().map(|s| s.name.as_str());
        let help = match crate::diagnostics::nearest(unknown, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => near_or_all(unknown, all, "its skills are"),
        };
        wires.error_with(
            codes::NAME_UNKNOWN,
            *span,
            format!("`{name}` has no skill `{unknown}`"),
            help,
        );
    }
    if decl.broken {
        // They may be bound by what could not be understood.
        wires.tainted = true;
        return None;
    }
    if let Some(first) = missing.first() {
        wires.error_with(
            codes::INPUT_UNBOUND,
            decl.set.span,
            format!(
                "it is not said when {} of `{name}` {} called in this machine",
                listed(missing.iter().copied()),
                if missing.len() == 1 { "is" } else { "are" },
            ),
            format!("write `{first} = ...` here: a condition over the machine's wires, such as `component.output = value`; `false` for what it never calls"),
        );
        return None;
    }
    let when: Option<Vec<Expr>> = bound.into_iter().map(|b| b?.1).collect();
    when
}
