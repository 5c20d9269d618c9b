//! Findings about the closed composition of a machine.

use super::findings::list;
use super::found;
use super::machine::MachineContext;
use super::words::{ProofPrinter, lasso_end, steps_table};
use linewright_algebra::closed::{
    ClosedComposition, FailureKind, OperationFailure, StuckComponent, Verdict,
};
use linewright_algebra::machine::COMPLETES;
use linewright_algebra::proof::{Open, Proof};
use linewright_algebra::replay;
use linewright_algebra::system::FormulaRef;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_core::gr1::{VarId, eval};
use linewright_core::source::Span;
use linewright_language::contract::machine::{Machine, Operation, Role};
use linewright_solver::game::{Limit, Limits};
use linewright_station::messages;
use std::collections::BTreeSet;

/// Finding for an obligation that the closed composition does not meet.
pub fn open(closed: &ClosedComposition<'_>, whole: &str, open: &Open, span: Span) -> Diagnostic {
    let printer = ProofPrinter {
        system: &closed.system,
        claim: &closed.claim,
        whole,
    };
    let proof = Proof {
        open: vec![open.clone()],
        ..Proof::default()
    };
    let at = |part: Option<usize>| -> Option<Span> {
        let component = part.and_then(|p| closed.machine.components.get(p));
        Some(component.map_or(span, |c| c.span))
    };
    let mut findings = found::of_proof(printer, &proof, &at);
    findings.swap_remove(0)
}

/// Finding for a component without an answer: after some run, its assumptions contradict each
/// other.
///
/// # Panics
/// If the component's table has no row although its assumptions are kept, which the verifier has
/// excluded.
pub fn stuck(closed: &ClosedComposition<'_>, stuck: &StuckComponent) -> Diagnostic {
    let component = &closed.machine.components[stuck.component];
    assert!(
        stuck.silent,
        "the controller of `{}` has no answer although its assumptions are kept; please report this",
        component.name
    );
    let before = stuck.trace.len().saturating_sub(1);
    let place = match before {
        0 => "at the start",
        _ => "after the run below",
    };
    let among = closed
        .contradiction(stuck, &Limits::default())
        .unwrap_or_default();
    let names: Vec<String> = among.iter().map(|f| format!("`{}`", f.name)).collect();
    let what = match names.as_slice() {
        [] => format!(
            "the assumptions of `{}` contradict each other",
            component.name
        ),
        [one] => format!(
            "the assumption {one} of `{}` contradicts itself",
            component.name
        ),
        several => format!(
            "the assumptions {} of `{}` contradict each other",
            list(several),
            component.name
        ),
    };
    let them = if names.len() == 1 { "it" } else { "them" };
    let mut finding = Diagnostic::error(
        codes::ASSUMPTION_UNDISCHARGED,
        component.span,
        format!("{what} {place}: no inputs satisfy {them}, so the component has no answer"),
    );
    for formula in among {
        finding = finding.with_label(formula.span, "this is assumed");
    }
    if before > 0 {
        let first = closed.participants[stuck.component].first;
        let wires = component.specification.outputs().count();
        let mut shown: BTreeSet<VarId> = (first..first + wires).map(|w| VarId(w as u32)).collect();
        for binding in &component.bindings {
            binding.for_each_var(&mut |v, _| {
                shown.insert(v);
            });
        }
        let shown: Vec<VarId> = shown.into_iter().collect();
        finding = finding.with_note(steps_table(&closed.system, &shown, &stuck.trace[..before]));
    }
    finding.with_help("weaken an assumption, or let the machine avoid the steps that lead there")
}

/// Whether an obligation is the completion goal. It is not reported as an obligation, because
/// completion is reported per operation.
pub fn is_completion(closed: &ClosedComposition<'_>, open: &Open) -> bool {
    let formula = replay::formula(&closed.system, &closed.claim, open.what);
    open.what.component.is_none() && formula.name == COMPLETES
}

/// Findings about operations. If the machine works only within others, an operation that can never
/// begin is reported as a warning instead of an error.
pub fn operations(
    closed: &ClosedComposition<'_>,
    verdict: &Verdict,
    context: MachineContext,
) -> Vec<Diagnostic> {
    let misruns = verdict.operation_failures.iter().map(|m| {
        let mut finding = misrun(closed, m);
        if context == MachineContext::Within && matches!(m.why, FailureKind::NeverBegins(_)) {
            finding.severity = Severity::Warning;
            let alone =
                "this holds for the machine on its own; within another machine its signals are bound";
            finding = finding.with_note(alone);
        }
        finding
    });
    let unclear = verdict
        .undecided_operations
        .iter()
        .map(|o| unclear(closed.machine, *o));
    misruns.chain(unclear).collect()
}

fn misrun(closed: &ClosedComposition<'_>, misrun: &OperationFailure) -> Diagnostic {
    let operation = &closed.machine.operations[misrun.operation];
    match &misrun.why {
        FailureKind::NeverBegins(by) => never_begins(closed, operation, by),
        FailureKind::Order(steps) => order(closed, misrun.operation, steps),
        FailureKind::Endless(run) => {
            let last = &run.cycle[0];
            let begun = begun(closed, last);
            let waits = match (active(closed, last), operation.sequence.get(begun)) {
                (Some(action), _) => format!("wait for {action}"),
                (None, Some(next)) => format!("wait before {}", name(closed.machine, *next)),
                (None, None) => "wait before the end".to_owned(),
            };
            let steps = [run.prefix.clone(), run.cycle.clone()].concat();
            Diagnostic::error(
                codes::REQUEST_INCOMPLETE,
                operation.span,
                format!(
                    "the operation `{}` may never end: it can {waits} for ever",
                    operation.name
                ),
            )
            .with_note(table(closed, &steps) + &lasso_end(run))
            .with_help("let the coordinator guarantee that it continues once an action is executed")
        }
    }
}

fn never_begins(
    closed: &ClosedComposition<'_>,
    operation: &Operation,
    by: &[FormulaRef],
) -> Diagnostic {
    let assumptions: Vec<String> = by.iter().map(|at| assumed(closed, *at)).collect();
    let forbids = match assumptions.as_slice() {
        [] => "the assumptions prevent it".to_owned(),
        [one] => format!("{one} prevents it"),
        [several @ .., last] => {
            format!("{} and {last} prevent it", several.join(", "))
        }
    };
    let mut finding = Diagnostic::error(
        codes::OPERATION,
        operation.span,
        format!(
            "the operation `{}` can never begin: {forbids}",
            operation.name
        ),
    );
    for at in by {
        let formula = replay::formula(&closed.system, &closed.claim, *at);
        finding = finding.with_label(formula.span, "it is forbidden here");
    }
    finding.with_help(
        "weaken the assumptions, or add an operation that leads to a state where it is allowed",
    )
}

fn assumed(closed: &ClosedComposition<'_>, at: FormulaRef) -> String {
    let component = &closed.machine.components[at.component.unwrap_or_default()];
    let formula = replay::formula(&closed.system, &closed.claim, at);
    messages::describe_assumption(component, formula)
}

fn order(closed: &ClosedComposition<'_>, operation: usize, steps: &[Vec<i64>]) -> Diagnostic {
    let machine = closed.machine;
    let operation = &machine.operations[operation];
    let last = &steps[steps.len() - 1];
    let begun = begun(closed, last);
    let named = |place: usize| {
        let action = operation.sequence.get(place);
        action.map_or("to be done".to_owned(), |i| name(machine, *i))
    };
    let coordinated = (machine.components.iter()).any(|c| c.role == Role::Coordinator);
    let (before, does) = match active(closed, last) {
        Some(action) if begun.checked_sub(1).map(named) != Some(action.clone()) => (
            begun.saturating_sub(1),
            if coordinated {
                format!("the coordinator asks for {action}")
            } else {
                format!("{action} becomes active")
            },
        ),
        _ if coordinated => (begun, "the coordinator says that it is done".to_owned()),
        _ => (begun, "`done` holds".to_owned()),
    };
    let message = format!(
        "after {} of `{}` {does}, but the operation names {}",
        messages::format_action_count(before),
        operation.name,
        named(before)
    );
    let next = operation.sequence.get(before);
    let next = next.map(|i| &machine.components[*i]);
    let help = match next.filter(|c| c.active.is_none()) {
        Some(action) => format!(
            "`{}` is never active: state when it is active, as in `action {}: {} when ...`",
            action.name, action.name, action.contract
        ),
        None if coordinated => {
            "make the operation's list and the coordinator's contract agree".to_owned()
        }
        None => "make the operation's list agree with `done` and with each `when`".to_owned(),
    };
    Diagnostic::error(codes::OPERATION, operation.span, message)
        .with_note(table(closed, steps) + &format!("this happens in step {}", steps.len() - 1))
        .with_help(help)
}

fn name(machine: &Machine, component: usize) -> String {
    format!("`{}`", machine.components[component].name)
}

/// Number of actions that have begun.
fn begun(closed: &ClosedComposition<'_>, values: &[i64]) -> usize {
    let watch = closed.watch.as_ref();
    watch.map_or(0, |w| usize::try_from(values[w.begun.index()]).unwrap_or(0))
}

/// The active action; the first declared one if there are several.
fn active(closed: &ClosedComposition<'_>, values: &[i64]) -> Option<String> {
    let mut components = closed.machine.components.iter();
    let active = components.position(|c| {
        let active = c.active.as_ref();
        active.is_some_and(|a| eval::holds(a, values, &[]))
    });
    active.map(|i| name(closed.machine, i))
}

/// A run as a table: the requested operation, the variables that show an action as active, and
/// those that show the operation as done.
fn table(closed: &ClosedComposition<'_>, steps: &[Vec<i64>]) -> String {
    let mut shown: BTreeSet<VarId> = BTreeSet::new();
    let machine = closed.machine;
    shown.extend(closed.watch.as_ref().and_then(|w| w.operation));
    let active = machine.components.iter().filter_map(|c| c.active.as_ref());
    for expr in active.chain(&machine.done) {
        expr.for_each_var(&mut |v, _| {
            shown.insert(v);
        });
    }
    steps_table(
        &closed.system,
        &shown.into_iter().collect::<Vec<_>>(),
        steps,
    )
}

fn unclear(machine: &Machine, operation: usize) -> Diagnostic {
    let operation = &machine.operations[operation];
    Diagnostic::warning(
        codes::OPERATION,
        operation.span,
        format!(
            "could not decide whether the operation `{}` runs its actions in order: a controller is too large",
            operation.name
        ),
    )
    .with_help("the library checks this when it runs; to decide it beforehand, make the domains smaller")
}

/// Help text for a proof that reached a limit.
pub fn limit_help(limit: Limit) -> String {
    let remedy = limit.remedy().map(|remedy| format!("{remedy}, or "));
    format!("{}make the domains smaller", remedy.unwrap_or_default())
}

/// Finding for a composition that was not decided because of a limit.
pub fn undecided(span: Span, name: &str, limit: Limit) -> Diagnostic {
    Diagnostic::warning(
        codes::GAVE_UP,
        span,
        format!("could not decide whether the parts of `{name}` fit together: {limit}"),
    )
    .with_help(limit_help(limit))
    .giving_up(limit.is_external())
}
