//! LW202: formulas that constrain variables their side does not control, reported at the place
//! where they do.

use super::{Label, Place};
use crate::contract::elaborate::{Elaborator, Names};
use crate::contract::shape::way;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::monitors::{Kind, Monitors, Obligation};
use linewright_core::gr1::{Expr, Owner, Time, VarId};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, BinaryOp, ExprKind};
use linewright_syntax::format;

/// Checks that the formula constrains variables that its side controls; reports it otherwise.
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
        if !speaks_of_outputs(e.memory.monitors.as_ref(), expr, label)
            && kind != Kind::Justice
            && !matches!(expr, Expr::Const(_))
        {
            let finding = inputs_only(&e.names, &super::whole(formula, place), expr, label);
            e.findings.push(finding);
        }
        return true;
    }
    let (now, next) = outputs(expr, label);
    let (bad, time) = match kind {
        Kind::Safety if looks_back => (next, Time::Next),
        Kind::Justice => return true,
        _ if looks_back && now.is_empty() => (next, Time::Next),
        _ if looks_back => (now, Time::Now),
        Kind::Initial | Kind::Invariant => (now, Time::Now),
        Kind::Safety => (next, Time::Next),
    };
    let Some(first) = bad.first().cloned() else {
        return true;
    };
    let whole = &super::whole(formula, place);
    let text = format::expression(whole);
    let help = match kind {
        _ if looks_back => format!(
            "the plant gives its inputs before it sees `{first}` of the same step; refer to `previous {first}`, or write `guarantee {text}` if the machine is to see to it"
        ),
        Kind::Initial => {
            format!(
                "an initial assumption refers to inputs only; write `guarantee {text}` to say how the machine starts"
            )
        }
        Kind::Safety => format!(
            "the plant chooses its next inputs without seeing `next {first}`; refer to `{first}` in the step before, or write `guarantee {text}` if the machine is to see to it"
        ),
        _ => format!(
            "write `guarantee {text}` if the machine is to see to it; what the plant does after it has seen `{first}` is `assume always ({first} ... -> next input ...)`"
        ),
    };
    let span = atom(&e.names, whole, &bad, time).unwrap_or(whole.span);
    let message = format!(
        "this assumption constrains {}, which the machine chooses",
        listed(&bad)
    );
    let finding = Diagnostic::error(codes::NOT_CONTROLLED, span, message).with_help(help);
    e.findings.push(finding);
    false
}

/// Returns the warning about a guarantee without an output: it holds only if the plant happens to
/// keep it.
fn inputs_only(known: &Names<'_>, whole: &ast::Expr, expr: &Expr, label: &Label<'_>) -> Diagnostic {
    let mut names: Vec<String> = Vec::new();
    expr.for_each_var(&mut |v, _| {
        if let Some(variable) = label.variables.get(v.index()) {
            add(&mut names, way(&variable.name).0);
        }
    });
    // The operand after the last arrow is what is required.
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
    let text = format::expression(whole);
    Diagnostic::warning(codes::NOT_CONTROLLED, span, message).with_help(format!(
        "if the plant promises it, write `assume {text}`; if the machine is to do something, name an output"
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

/// Returns the outputs whose current values occur, and those whose next values occur.
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

/// Returns the first condition without connectives that mentions one of these variables; with
/// [`Time::Next`], its next value.
fn atom(known: &Names<'_>, formula: &ast::Expr, names: &[String], time: Time) -> Option<Span> {
    let bases: Vec<&str> = names.iter().map(|n| way(n).0).collect();
    find(known, formula, &bases, time == Time::Now)
}

/// Searches for such a condition; `reached` says whether the position is about the wanted step.
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
    use BinaryOp::{And, Iff, Implies, Or, Xor};
    matches!(
        e.kind,
        ExprKind::Not(_)
            | ExprKind::Binary(And | Or | Implies | Iff | Xor, ..)
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
        // Circular defines were reported; none is followed for long.
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

/// Returns whether an output occurs, including in a formula that a monitor follows.
fn speaks_of_outputs(monitors: Option<&Monitors>, expr: &Expr, label: &Label<'_>) -> bool {
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
