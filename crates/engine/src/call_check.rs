//! Checks whether a line calls its stations as their machines assume. For example, a machine that
//! is called from outside leaves the order of its skills to the caller, so the line has to keep
//! this order.

use super::prover::Prover;
use crate::controlled::ControlledMachine;
use linewright_algebra::caller::{CalledMachine, OperationRequest};
use linewright_algebra::closed::ClosedComposition;
use linewright_algebra::proof::{Open, Refutation};
use linewright_algebra::replay;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Line, Node, NodeKind};
use linewright_language::contract::machine::Machine;
use linewright_line::UndecidedReason;
use linewright_line::calls::in_turn;
use linewright_solver::game::Limit;
use linewright_station::messages;
use std::collections::BTreeSet;

/// Result of the check of a line's stations.
#[derive(Debug, Default)]
pub struct CallCheck {
    /// Calls that may violate an assumption.
    pub findings: Vec<Diagnostic>,
    /// Names of stations whose calls could not be decided, with the reason.
    pub undecided: Vec<(String, UndecidedReason)>,
}

/// Checks the `wanted` stations, given by node index. If the contracts alone do not prove that all
/// calls are as assumed, the machine's controllers are used too, if `controlled` returns them.
pub fn examine<'a>(
    line: &Line,
    wanted: impl Fn(usize) -> bool,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
    prover: Prover<'_>,
) -> CallCheck {
    let mut result = CallCheck::default();
    let nodes = line.nodes.iter().enumerate();
    for (_, node) in nodes.filter(|(i, _)| wanted(*i)) {
        let NodeKind::Station(station) = &node.kind else {
            continue;
        };
        let Some(machine) = &station.machine else {
            continue;
        };
        let sequences = station.tasks.iter().map(|task| {
            let carried = |at: usize| task.properties.get(at).is_some_and(Option::is_some);
            let operations = task.operations.iter();
            operations
                .map(|(operation, given)| {
                    OperationRequest::new(machine, *operation, given, carried)
                })
                .collect()
        });
        // Sequences in operation order; identical sequences of two tasks are checked once.
        let sequences: BTreeSet<Vec<OperationRequest>> = sequences.collect();
        let sequences: Vec<Vec<OperationRequest>> = sequences.into_iter().collect();
        let Some(called) = CalledMachine::of(machine, &sequences) else {
            continue;
        };
        match open_assumptions(&called, controlled(machine), prover) {
            Ok(open) => {
                let is_unsure = |o: &Open| called.uncertain_assumptions.contains(&o.what);
                let (unsure, open): (Vec<Open>, Vec<Open>) = open.into_iter().partition(is_unsure);
                if open.is_empty() && !unsure.is_empty() {
                    let why = UndecidedReason::because("it depends on properties of the parts");
                    result.undecided.push((node.name.clone(), why));
                }
                let mut shown = BTreeSet::new();
                for open in &open {
                    let formula = replay::formula(&called.system, &called.claim, open.what);
                    if shown.insert((open.what.component, formula.span)) {
                        result.findings.push(finding(node, machine, &called, open));
                    }
                }
            }
            Err(limit) => result.undecided.push((node.name.clone(), limit.into())),
        }
    }
    result
}

/// Returns the assumptions about calls that may be violated.
fn open_assumptions(
    called: &CalledMachine,
    controlled: Option<ControlledMachine<'_>>,
    prover: Prover<'_>,
) -> Result<Vec<Open>, Limit> {
    let about_calls = |mut open: Vec<Open>| {
        open.retain(|o| called.operation_assumptions.contains(&o.what));
        open
    };
    let proof = prover
        .decide(&called.system, &called.claim)
        .map(|proof| (proof.loops.is_empty(), about_calls(proof.open)));
    if matches!(&proof, Ok((true, open)) if open.is_empty()) {
        return Ok(Vec::new());
    }
    if let Some(controlled) = controlled {
        let closed =
            ClosedComposition::of_called(controlled.machine, &controlled.controllers, called);
        if let Ok(verdict) = prover.decide_closed(&closed)
            // Once a component is stuck, later calls are not examined.
            && verdict.stuck.is_empty()
            && called.operation_assumptions.iter().all(|at| !verdict.undecided.contains(at))
        {
            return Ok(about_calls(verdict.open));
        }
    }
    match proof {
        Ok((_, open)) if !open.is_empty() => Ok(open),
        Ok(_) => Err(Limit::Size),
        Err(limit) => Err(limit),
    }
}

fn finding(station: &Node, machine: &Machine, called: &CalledMachine, open: &Open) -> Diagnostic {
    let formula = replay::formula(&called.system, &called.claim, open.what);
    let component = &machine.components[open.what.component.unwrap_or_default()];
    let run = match &open.why {
        Refutation::Trace(run) => run,
        Refutation::Lasso(lasso) => &lasso.prefix,
    };
    let asked: Vec<&str> = called
        .requested_operations(machine, run)
        .into_iter()
        .map(|operation| machine.operations[operation].name.as_str())
        .collect();
    Diagnostic::warning(
        codes::LINE_FORBIDDEN_REQUEST,
        station.span,
        format!(
            "{} may be asked for what {} forbids: {}",
            station.name,
            messages::describe_assumption(component, formula),
            formula.text
        ),
    )
    .with_label(formula.span, "this would be broken")
    .with_note(format!(
        "this happens when {} is asked for {}: the part{} is refused, and removed from the line",
        station.name,
        in_turn(&asked),
        if asked.len() == 1 { "" } else { " of the last request" }
    ))
    .with_help(
        "let the station perform other operations, or the same ones in another order; or weaken the assumption",
    )
}
