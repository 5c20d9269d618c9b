//! LW202: findings for assumptions that constrain outputs, and for guarantees that mention only
//! inputs.

use super::{Label, Place};
use crate::contract::elaborate::{Elaborator, Names};
use crate::contract::shape::leaf_path;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::monitors::{Monitors, Obligation};
use linewright_core::gr1::{Expr, FormulaKind, Owner, Time, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, BinaryOp, ExprKind};
use linewright_syntax::format;

/// Checks whether a formula constrains variables that its side controls. Reports an error and
/// returns `false` if an assumption constrains outputs. Only warns, and returns `true`, if a
/// guarantee mentions no outputs.
pub(super) fn controls(
    e: &mut Elaborator<'_>,
    (formula, place): (&ast::Expr, Place),
    obligation: &Obligation,
    looks_back: bool,
    label: &Label<'_>,
) -> bool {
    let Obligation { kind, expr } = obligation;
    let kind = *kind;
    if label.guarantee {
        if !mentions_outputs(e.memory.monitors.as_ref(), expr, label)
            && kind != FormulaKind::Justice
            && !matches!(expr, Expr::Const(_))
        {
            let finding = inputs_only(&e.names, &super::whole(formula, place), expr, label);
            e.findings.push(finding);
        }
        return true;
    }
    let (now, next) = outputs(expr, label);
    let (bad, time) = match kind {
        FormulaKind::Safety if looks_back => (next, Time::Next),
        FormulaKind::Justice => return true,
        _ if looks_back && now.is_empty() => (next, Time::Next),
        _ if looks_back => (now, Time::Now),
        FormulaKind::Initial | FormulaKind::Invariant => (now, Time::Now),
        FormulaKind::Safety => (next, Time::Next),
    };
    let Some(first) = bad.first().cloned() else {
        return true;
    };
    let whole = &super::whole(formula, place);
    let text = format::format_expression(whole);
    let help = match kind {
        _ if looks_back => format!(
            "an assumption cannot depend on `{first}` of the same step: refer to `previous {first}`, or write `guarantee {text}` if the machine has to ensure this"
        ),
        FormulaKind::Initial => {
            format!(
                "an initial assumption can refer only to inputs: write `guarantee {text}` to constrain the start of the machine"
            )
        }
        FormulaKind::Safety => format!(
            "an assumption cannot depend on `next {first}`: refer to the current `{first}`, or write `guarantee {text}` if the machine has to ensure this"
        ),
        _ => format!(
            "write `guarantee {text}` if the machine has to ensure this; to describe how the plant reacts to `{first}`, write `assume always ({first} ... -> next input ...)`"
        ),
    };
    let span = atom(&e.names, whole, &bad, time).unwrap_or(whole.span);
    let message = format!(
        "this assumption constrains {}, which the machine controls",
        listed(&bad)
    );
    let finding = Diagnostic::error(codes::NOT_CONTROLLED, span, message).with_help(help);
    e.findings.push(finding);
    false
}

/// Returns the warning for a guarantee without outputs, which the machine cannot influence.
fn inputs_only(known: &Names<'_>, whole: &ast::Expr, expr: &Expr, label: &Label<'_>) -> Diagnostic {
    let mut names: Vec<String> = Vec::new();
    expr.for_each_var(&mut |v, _| {
        if let Some(variable) = label.variables.get(v.index()) {
            add(&mut names, leaf_path(&variable.name).0);
        }
    });
    // The operand after the last arrow is the condition that is required.
    let mut demanded = whole;
    loop {
        demanded = match &demanded.kind {
            ExprKind::Always(a) | ExprKind::Eventually(a) => a,
            ExprKind::Binary(BinaryOp::Implies, _, b) => b,
            _ => break,
        };
    }
    let span = atom(known, demanded, &names, Time::Now)
        .filter(|_| !names.is_empty())
        .unwrap_or(demanded.span);
    let message = if names.is_empty() {
        "this guarantee refers to inputs only, which the machine does not control".to_owned()
    } else {
        format!(
            "this guarantee refers to inputs only: {}, which the machine does not control",
            listed(&names)
        )
    };
    let text = format::format_expression(whole);
    Diagnostic::warning(codes::NOT_CONTROLLED, span, message).with_help(format!(
        "if the plant ensures this, write `assume {text}`; otherwise, refer to an output"
    ))
}

fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    match quoted.as_slice() {
        [most @ .., last] if !most.is_empty() => format!("{} and {last}", most.join(", ")),
        other => other.concat(),
    }
}

fn add(names: &mut Vec<String>, name: &str) {
    if !names.iter().any(|n| n == name) {
        names.push(name.to_owned());
    }
}

/// Returns two lists: the outputs whose current values occur in an expression, and the outputs
/// whose next values occur in it.
fn outputs(expr: &Expr, label: &Label<'_>) -> (Vec<String>, Vec<String>) {
    let (mut now, mut next) = (Vec::new(), Vec::new());
    expr.for_each_var(&mut |v, time| {
        if let Some(variable) = label.variables.get(v.index())
            && variable.owner == Owner::System
        {
            let list = if time == Time::Next {
                &mut next
            } else {
                &mut now
            };
            add(list, &variable.name);
        }
    });
    (now, next)
}

/// Returns the position of the first condition without connectives that mentions one of the
/// variables `names`. If `time` is [`Time::Next`], the condition has to mention the next value of
/// one.
fn atom(known: &Names<'_>, formula: &ast::Expr, names: &[String], time: Time) -> Option<Span> {
    let bases: Vec<&str> = names.iter().map(|n| leaf_path(n).0).collect();
    find(known, formula, &bases, time == Time::Now)
}

/// Implements the search of [`atom`]. `bases` are the names of the variables. `reached` tells
/// whether the formula already refers to the required step.
fn find(known: &Names<'_>, formula: &ast::Expr, bases: &[&str], reached: bool) -> Option<Span> {
    let logic = match &formula.kind {
        ExprKind::Next(a) if connects(a) => return find(known, a, bases, true),
        _ => connects(formula),
    };
    if logic {
        let mut children = formula.children().into_iter();
        return children.find_map(|c| find(known, c, bases, reached));
    }
    mentions(known, formula, bases, reached, 0).then_some(formula.span)
}

fn connects(e: &ast::Expr) -> bool {
    matches!(&e.kind, ExprKind::Binary(op, ..) if op.is_logical())
        || matches!(
            e.kind,
            ExprKind::Not(_)
                | ExprKind::If(..)
                | ExprKind::Quantifier(..)
                | ExprKind::Always(_)
                | ExprKind::Eventually(_)
                | ExprKind::Past(..)
                | ExprKind::Since(..)
                | ExprKind::Pattern(_)
        )
}

fn mentions(
    known: &Names<'_>,
    formula: &ast::Expr,
    bases: &[&str],
    reached: bool,
    depth: usize,
) -> bool {
    let here = match &formula.kind {
        ExprKind::Next(a) => return mentions(known, a, bases, true, depth),
        ExprKind::Path(names) => Some(&names[0]),
        ExprKind::Call(name, _) => Some(name),
        _ => None,
    };
    if let Some(name) = here {
        if reached && bases.contains(&name.text.as_str()) {
            return true;
        }
        // The depth is limited because defines can be circular, which is reported elsewhere.
        if depth < 16
            && let Some(define) = known.defines.get(&name.text)
            && mentions(known, &define.value, bases, reached, depth + 1)
        {
            return true;
        }
        if depth < 16
            && let Some(counter) = known.counters.get(&name.text)
            && std::iter::once(&counter.counts)
                .chain(&counter.resets)
                .any(|c| mentions(known, c, bases, reached, depth + 1))
        {
            return true;
        }
    }
    let mut children = formula.children().into_iter();
    children.any(|c| mentions(known, c, bases, reached, depth))
}

/// Returns whether an expression depends on an output, directly or through a monitor.
fn mentions_outputs(monitors: Option<&Monitors>, expr: &Expr, label: &Label<'_>) -> bool {
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
        let monitor = monitors.and_then(|m| m.get(v));
        if let Some(monitor) = monitor
            && !seen.contains(&v)
        {
            seen.push(v);
            visit(&monitor.update, &mut open, &mut found);
        }
    }
    found
}
