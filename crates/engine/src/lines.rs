//! Proofs of lines: what `check` examines before a line runs.

use super::call_check;
use super::internal;
use super::prover::Prover;
use super::words::{DischargeEntry, ProofPrinter, discharge_entry};
use crate::controlled::ControlledMachine;
use linewright_algebra::system::FormulaRef;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_core::gr1::FormulaKind;
use linewright_language::contract::NONE_HOLDS;
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::machine::Machine;
use linewright_line::UndecidedReason;
use linewright_line::abstraction::{Abstraction, Verdict, findings, with_losses};
use linewright_line::calls::{self, Bounds, Calls, Premise, WorkTime, premises};
use linewright_solver::game::{Budget, Limit, Limits};
use schemars::JsonSchema;
use serde::Serialize;

/// Maximum number of variables of a line for which progress is examined.
const MAX_VARIABLES: usize = 48;

/// Bounds of the exploration of a line's calls.
const CALLS: Bounds = Bounds {
    values: 20_000,
    steps: 2_000_000,
};

/// Whether parts keep moving in a line, whatever the plant does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineVerdict {
    /// It is proved that every part keeps moving.
    Proved,
    /// It is proved that there is no global deadlock; whether every part keeps moving was not
    /// decided.
    Safe,
    /// The proof failed, for the reasons in the findings.
    Open,
    /// A limit was reached.
    #[default]
    GaveUp,
}

/// Result of the proof of a line.
#[derive(Debug, Default)]
pub struct Proof {
    /// Whether parts keep moving.
    pub verdict: LineVerdict,
    /// How long the stations with machines work on a part. Empty if not all calls could be tried.
    pub work_times: Vec<WorkTime>,
    /// If proved or safe: assumptions of the proof that it does not establish itself.
    pub premises: Vec<Premise>,
    /// If safe: names of the goals that were not decided.
    pub undecided: Vec<String>,
    /// For each requirement and each assumption of a place, the formulas from which it follows.
    pub discharges: Vec<DischargeEntry>,
    /// Whether all calls were tried. If so, it is known for every part whether it has a route.
    pub routes_decided: bool,
    /// Problems found.
    pub findings: Vec<Diagnostic>,
}

/// Proves a line, or reports what prevents the proof; `docs/proof.md` has the theorem. The table of
/// discharges takes longer than the verdict and is computed only if `with_table` is set.
/// `controlled` returns a machine with its controllers, if it has all of them.
pub fn examine<'a>(
    line: &Line,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
    prover: Prover<'_>,
    with_table: bool,
) -> Proof {
    // The calls are examined first, because a station works on parts only if it answers every call.
    let Followed {
        calls,
        problems,
        remarks,
    } = follow(line, &controlled, prover.limits());
    let prover = prover.with_budget(Budget::LINE);
    let reduced = calls.simplified(line);
    let moving = if calls.findings.is_empty() {
        &reduced
    } else {
        line
    };
    // If not all calls could be tried, contracts can still show that no call violates an order.
    let unknown = |node: usize| calls.undecided.iter().any(|(n, _)| *n == node);
    let asked = call_check::examine(line, unknown, &controlled, prover);
    let mut proof = examine_moves(&with_losses(moving), prover, with_table);
    if problems.is_empty() && asked.findings.is_empty() {
        if matches!(proof.verdict, LineVerdict::Proved | LineVerdict::Safe) {
            proof.premises = premises(line, &calls);
        }
    } else {
        proof.verdict = LineVerdict::Open;
        proof.discharges.clear();
        proof.undecided.clear();
        // While there are errors, undecided questions are not worth reporting. Findings about a
        // limit that was reached remain, because they determine the exit code.
        proof
            .findings
            .retain(|f| f.code != codes::LINE_UNDECIDED || f.gave_up);
    }
    proof.routes_decided = calls.undecided.is_empty();
    if proof.routes_decided {
        proof.work_times.clone_from(&calls.work_times);
    }
    proof.findings.extend(problems);
    proof.findings.extend(remarks);
    proof.findings.extend(asked.findings);
    let asking = asked.undecided.iter().any(|(_, why)| why.is_external());
    for (node, why) in &calls.undecided {
        // A missing controller is reported at its contract.
        if has_controllers(line, *node, &controlled) {
            let finding = not_followed(line, *node, why);
            let gave_up = finding.gave_up || asking;
            proof.findings.push(finding.giving_up(gave_up));
        }
        if proof.verdict == LineVerdict::Proved {
            proof.verdict = LineVerdict::Safe;
        }
        if proof.verdict == LineVerdict::Safe {
            let station = &line.nodes[*node].name;
            proof.undecided.push(format!("answers_at_{station}"));
        }
    }
    proof
}

/// Whether a node is not a station with a machine, or its machine has controllers.
fn has_controllers<'a>(
    line: &Line,
    node: usize,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
) -> bool {
    match &line.nodes[node].kind {
        NodeKind::Station(station) => {
            let machine = station.machine.as_deref();
            machine.is_none_or(|machine| controlled(machine).is_some())
        }
        _ => true,
    }
}

/// Follows the parts of a line and adds the findings common to `check`, `build` and `run`: refused
/// calls, parts without a route, routes that no part takes, and a limit that stopped the search. If
/// all calls were tried, removes the resolver's warnings about routes.
pub fn add_call_findings<'a>(
    line: &Line,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
    limits: &Limits,
    findings: &mut Vec<Diagnostic>,
) {
    let doing = || format!("following the parts of the line `{}`", line.name);
    let followed = match internal::caught(doing, || follow(line, controlled, limits)) {
        Ok(followed) => followed,
        Err(fault) => {
            findings.push(fault.finding(Some(line.span)));
            return;
        }
    };
    let undecided = &followed.calls.undecided;
    if undecided.is_empty() {
        findings.retain(|f| !is_route_warning(f, line));
    }
    findings.extend(followed.problems);
    findings.extend(followed.remarks);
    let cut_short = undecided.iter().filter(|(_, why)| why.is_external());
    findings.extend(cut_short.map(|(node, why)| not_followed(line, *node, why)));
}

/// Whether a finding is the resolver's warning that a part may stay where a route of the line
/// begins. The resolver does not know the parts' values; following the parts decides whether the
/// warning is justified.
pub fn is_route_warning(finding: &Diagnostic, line: &Line) -> bool {
    let of_line = |span| line.routes.iter().any(|route| route.span == span);
    finding.code == codes::LINE_ROUTE
        && finding.severity == Severity::Warning
        && finding.message.ends_with(NONE_HOLDS)
        && finding.span.is_some_and(of_line)
}

/// Result of following the parts of a line.
struct Followed {
    /// Calls that were tried.
    calls: Calls,
    /// Findings that prevent a proof: refused calls, parts without a route, work that takes no
    /// time.
    problems: Vec<Diagnostic>,
    /// Other findings.
    remarks: Vec<Diagnostic>,
}

/// Follows the parts of a line from call to call.
fn follow<'a>(
    line: &Line,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
    limits: &Limits,
) -> Followed {
    let interpreter = |machine: &Machine| Some(controlled(machine)?.interpreter(machine));
    let bounds = Bounds {
        values: usize::try_from(limits.budget_factor.scale(CALLS.values as u64))
            .unwrap_or(usize::MAX),
        steps: limits.budget_factor.scale(CALLS.steps),
    };
    let mut calls = calls::examine(line, interpreter, &bounds, &bounded(limits));
    let mut problems = calls.findings.clone();
    problems.extend(timeless(line, &calls));
    let remarks = std::mem::take(&mut calls.remarks);
    Followed {
        calls,
        problems,
        remarks,
    }
}

/// Finding for a line in which parts can move in a cycle without time passing.
fn timeless(line: &Line, calls: &Calls) -> Option<Diagnostic> {
    let found = calls.timeless.as_ref()?;
    let [from, to] = [found.from, found.to].map(|node| &line.nodes[node]);
    let message = format!(
        "parts move from {} to {} again and again without time passing",
        from.name, to.name
    );
    let mut finding = Diagnostic::error(codes::LINE_TIMELESS, from.span, message).with_help(
        "give the work of a station on this way a time that is greater than 0 for all values",
    );
    if !found.always {
        finding.severity = Severity::Warning;
    }
    for node in &found.stations {
        let node = &line.nodes[*node];
        finding = finding.with_label(
            node.span,
            format!("the work of {} can take no time", node.name),
        );
    }
    Some(finding)
}

/// Limits for one question about a line.
fn bounded(limits: &Limits) -> Limits {
    limits.with_budget(Budget::LINE)
}

/// Examines whether parts keep moving, provided that each operation completes.
fn examine_moves(line: &Line, prover: Prover<'_>, with_table: bool) -> Proof {
    let table = |abstraction: &Abstraction, verdict: &Verdict| {
        if !with_table {
            return (Vec::new(), None);
        }
        match table(line, abstraction, verdict, prover) {
            Ok(rows) => (rows, None),
            Err(limit) => {
                let message = format!(
                    "the verdict on {} is known, but the table of discharges is not: {limit}",
                    line.name
                );
                (
                    Vec::new(),
                    Some(note(line, message, Some(limit), UNDECIDED_GOAL)),
                )
            }
        }
    };
    let (abstraction, verdict) = match prover.examine_line(line, MAX_VARIABLES) {
        Ok(decided) => decided,
        Err(why) => {
            let what = format!("whether parts can deadlock in {}", line.name);
            return Proof {
                verdict: LineVerdict::GaveUp,
                findings: vec![not_decided(line, &what, &why, UNDECIDED_DEADLOCK)],
                ..Proof::default()
            };
        }
    };
    if !verdict.open.is_empty() {
        return Proof {
            verdict: LineVerdict::Open,
            findings: findings(line, &abstraction, &verdict),
            ..Proof::default()
        };
    }
    let (discharges, unknown) = table(&abstraction, &verdict);
    let undecided = verdict.undecided.iter();
    let undecided: Vec<String> = undecided
        .map(|at| abstraction.goal(*at).name.clone())
        .collect();
    let mut findings: Vec<Diagnostic> = unknown.into_iter().collect();
    if !undecided.is_empty() {
        let reason = match verdict.limit {
            Some(limit) => limit.to_string(),
            None => "the line is too large".to_owned(),
        };
        let message = format!(
            "something can always move in {}, but it was not decided whether every part keeps moving ({reason}): {}",
            line.name,
            undecided.join(", ")
        );
        findings.push(note(line, message, verdict.limit, UNDECIDED_GOAL));
    }
    Proof {
        verdict: if verdict.holds() {
            LineVerdict::Proved
        } else {
            LineVerdict::Safe
        },
        undecided,
        discharges,
        findings,
        ..Proof::default()
    }
}

/// Table of discharges. If goals are undecided, the table leaves out justice and all requirements
/// that were shown with lemmas.
///
/// # Errors
/// A limit was reached first; the verdict does not depend on the table.
fn table(
    line: &Line,
    abstraction: &Abstraction,
    verdict: &Verdict,
    prover: Prover<'_>,
) -> Result<Vec<DischargeEntry>, Limit> {
    let whole = &abstraction.claim;
    let safe = |at: FormulaRef| at.kind != FormulaKind::Justice && !whole.lemmas.contains_key(&at);
    let claim = if verdict.undecided.is_empty() {
        whole.clone()
    } else {
        whole.only(safe)
    };
    let proof = prover.prove(&abstraction.system, &claim)?;
    let printer = ProofPrinter {
        system: &abstraction.system,
        claim: &claim,
        whole: &line.name,
    };
    let entries = proof.discharges.iter();
    Ok(entries.map(|d| discharge_entry(printer, d)).collect())
}

/// Help text if a station's calls were not decided.
const UNDECIDED_CALLS: &str = "A run shows which calls are refused. Fewer values of properties, or a machine that returns to the same state after each operation, \
                     leave less to try";

/// Help text if a goal of the line was not decided.
const UNDECIDED_GOAL: &str =
    "Smaller limits and buffers, or fewer types of parts in a buffer, make the line smaller";

/// Help text if it was not decided whether a line can deadlock.
const UNDECIDED_DEADLOCK: &str = "No problem was found. A run shows whether the line gets stuck with its actual times; smaller buffers, or fewer \
                     types of parts in a buffer, make the line smaller";

/// Note that a question was not decided, with the reason.
fn not_decided(line: &Line, question: &str, why: &UndecidedReason, help: &str) -> Diagnostic {
    let message = format!("could not decide {question}: {why}");
    note(line, message, why.limit, help)
}

/// Note that it was not decided whether a station answers every call.
fn not_followed(line: &Line, node: usize, why: &UndecidedReason) -> Diagnostic {
    let question = format!("whether {} answers every call", line.nodes[node].name);
    let help = match why.limit {
        Some(_) => UNDECIDED_CALLS.to_owned(),
        None => format!("{UNDECIDED_CALLS}; `--effort 10` lets the proof try ten times as much"),
    };
    not_decided(line, &question, why, &help)
}

/// Note on something undecided. The help ends with how to lift the limit.
fn note(line: &Line, message: String, limit: Option<Limit>, help: &str) -> Diagnostic {
    let remedy = limit.and_then(Limit::remedy);
    let remedy = remedy
        .map(|remedy| format!(" Or {remedy}."))
        .unwrap_or_default();
    Diagnostic::note(codes::LINE_UNDECIDED, line.span, message)
        .with_help(format!("{help}.{remedy}"))
        .giving_up(limit.is_some_and(Limit::is_external))
}
