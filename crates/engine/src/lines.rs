//! Proofs of lines: what `check` examines before a line runs.

use super::call_check;
use super::internal;
use super::words::{DischargeEntry, ProofPrinter, entry};
use crate::controlled::ControlledMachine;
use linewright_algebra::proof::prove;
use linewright_algebra::system::FormulaRef;
use linewright_core::diagnostics::{Diagnostic, Severity, codes};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::machine::Machine;
use linewright_line::UndecidedReason;
use linewright_line::abstraction::{self, Abstraction, Verdict, findings};
use linewright_line::calls::{self, Bounds, Calls, Premise, premises};
use linewright_solver::game::{Budget, Limit, Limits, RuleKind};
use schemars::JsonSchema;
use serde::Serialize;

/// Maximum number of variables of a line for which progress is examined.
const MOST_VARIABLES: usize = 48;

/// Bounds of the exploration of a line's calls.
const CALLS: Bounds = Bounds {
    values: 20_000,
    steps: 2_000_000,
};

/// Whether parts keep moving in a line, whatever the plant does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LineVerdict {
    /// Proved.
    Proved,
    /// Proved that there is no global deadlock; whether every part goes on was not decided.
    Safe,
    /// Not proved, for the reasons in the findings.
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
    /// If proved or safe: premises that the line itself does not establish.
    pub premises: Vec<Premise>,
    /// If safe: what was not decided.
    pub undecided: Vec<String>,
    /// What each requirement and each assumption of a place rests on.
    pub discharges: Vec<DischargeEntry>,
    /// Whether it was decided for every part that it has a way onward.
    pub routes_decided: bool,
    /// Problems found.
    pub findings: Vec<Diagnostic>,
}

/// Proves a line, or reports what prevents the proof; `docs/proof.md` has the theorem. The table of
/// discharges takes longer than the verdict and is made only if `with_table` is set. `controlled`
/// returns the controllers of a machine, if they exist.
pub fn examine<'a>(
    line: &Line,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
    limits: &Limits,
    with_table: bool,
) -> Proof {
    // That every part is worked on depends on every call being answered.
    let Followed {
        calls,
        wrong,
        remarks,
    } = follow(line, &controlled, limits);
    let reduced = calls.simplified(line);
    let moving = if calls.findings.is_empty() {
        &reduced
    } else {
        line
    };
    // If not all calls could be tried, contracts may still show that none violates an order.
    let unknown = |node: usize| calls.undecided.iter().any(|(n, _)| *n == node);
    let asked = call_check::examine(line, unknown, &controlled, &bounded(limits));
    let mut proof = examine_moves(moving, &bounded(limits), with_table);
    if wrong.is_empty() && asked.findings.is_empty() {
        if matches!(proof.verdict, LineVerdict::Proved | LineVerdict::Safe) {
            proof.premises = premises(line, &calls);
        }
    } else {
        proof.verdict = LineVerdict::Open;
        proof.discharges.clear();
        proof.undecided.clear();
        // Undecided points do not matter as long as something is wrong.
        proof.findings.retain(|f| f.code != codes::LINE_UNDECIDED);
    }
    proof.routes_decided = calls.undecided.is_empty();
    proof.findings.extend(wrong);
    proof.findings.extend(remarks);
    proof.findings.extend(asked.findings);
    let asking = asked.undecided.iter().any(|(_, why)| why.is_of_command());
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

/// Whether a node is no machine, or one with controllers.
fn has_controllers<'a>(
    line: &Line,
    node: usize,
    controlled: impl Fn(&Machine) -> Option<ControlledMachine<'a>>,
) -> bool {
    match &line.nodes[node].kind {
        NodeKind::Station { machine, .. } => controlled(machine).is_some(),
        _ => true,
    }
}

/// Follows the parts of a line and adds the findings common to `check`, `build` and `run`: refused
/// calls, parts without a way, routes that no part takes, and a limit that cut this short. Removes
/// doubts of the resolver once they are decided.
pub fn judge<'a>(
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
        findings.retain(|f| !is_doubt(f, line));
    }
    findings.extend(followed.wrong);
    findings.extend(followed.remarks);
    let cut_short = undecided.iter().filter(|(_, why)| why.is_of_command());
    findings.extend(cut_short.map(|(node, why)| not_followed(line, *node, why)));
}

/// Whether this finding is a doubt about a route of the line that following its parts resolves: the
/// resolver does not know their values.
pub fn is_doubt(finding: &Diagnostic, line: &Line) -> bool {
    let of_line = |span| line.routes.iter().any(|route| route.span == span);
    finding.code == codes::LINE_ROUTE
        && finding.severity == Severity::Warning
        && finding.span.is_some_and(of_line)
}

/// Result of following the parts of a line.
struct Followed {
    /// Calls that were tried.
    calls: Calls,
    /// Findings that prevent a proof: refused calls, parts without a way, work that takes no time.
    wrong: Vec<Diagnostic>,
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
        values: usize::try_from(limits.effort.of(CALLS.values as u64)).unwrap_or(usize::MAX),
        steps: limits.effort.of(CALLS.steps),
    };
    let mut calls = calls::examine(line, interpreter, &bounds, &bounded(limits));
    let mut wrong = calls.findings.clone();
    wrong.extend(timeless(line, &calls));
    let remarks = std::mem::take(&mut calls.remarks);
    Followed {
        calls,
        wrong,
        remarks,
    }
}

/// Finding for a line in which parts move on without time passing.
fn timeless(line: &Line, calls: &Calls) -> Option<Diagnostic> {
    let found = calls.timeless.as_ref()?;
    let [from, to] = [found.from, found.to].map(|node| &line.nodes[node]);
    let message = format!(
        "parts go from {} to {} on and on, and no time passes",
        from.name, to.name
    );
    let mut finding = Diagnostic::error(codes::LINE_TIMELESS, from.span, message).with_help(
        "give the work of a station on the way a time that is greater than 0 for all values",
    );
    if !found.always {
        finding.severity = Severity::Warning;
    }
    for node in &found.stations {
        let node = &line.nodes[*node];
        finding = finding.with_label(
            node.span,
            format!("the work of {} may take no time", node.name),
        );
    }
    Some(finding)
}

/// Limits for one question about a line.
fn bounded(limits: &Limits) -> Limits {
    limits.within(Budget::LINE)
}

/// Examines whether parts keep moving, provided that each operation completes.
fn examine_moves(line: &Line, limits: &Limits, with_table: bool) -> Proof {
    let table = |abstraction: &Abstraction, verdict: &Verdict| {
        if !with_table {
            return (Vec::new(), None);
        }
        match table(line, abstraction, verdict, limits) {
            Ok(rows) => (rows, None),
            Err(limit) => {
                let message = format!(
                    "the verdict on {} is known, but not what rests on what: {limit}",
                    line.name
                );
                (Vec::new(), Some(note(line, message, Some(limit), FEWER)))
            }
        }
    };
    let (abstraction, verdict) = match abstraction::examine(line, limits, MOST_VARIABLES) {
        Ok(decided) => decided,
        Err(why) => {
            let what = format!("whether parts can deadlock in {}", line.name);
            return Proof {
                verdict: LineVerdict::GaveUp,
                findings: vec![not_decided(line, &what, &why, A_RUN)],
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
            "something can always move in {}, but whether every part goes on was not decided ({reason}): {}",
            line.name,
            undecided.join(", ")
        );
        findings.push(note(line, message, verdict.limit, FEWER));
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

/// Table of what rests on what. Omits undecided entries; empty if a limit was reached first, since
/// the verdict is known without it.
fn table(
    line: &Line,
    abstraction: &Abstraction,
    verdict: &Verdict,
    limits: &Limits,
) -> Result<Vec<DischargeEntry>, Limit> {
    let whole = &abstraction.claim;
    let safe = |at: FormulaRef| at.kind != RuleKind::Justice && !whole.lemmas.contains_key(&at);
    let claim = if verdict.undecided.is_empty() {
        whole.clone()
    } else {
        whole.only(safe)
    };
    let proof = prove(&abstraction.system, &claim, limits)?;
    let printer = ProofPrinter {
        system: &abstraction.system,
        claim: &claim,
        whole: &line.name,
    };
    Ok(proof.discharges.iter().map(|d| entry(printer, d)).collect())
}

/// Help text if a station's calls were not decided.
const ASKED: &str = "A run shows what is refused. Fewer values of properties, or a machine that comes back to the same state after each operation, \
                     leave less to try";

/// Help text if something was not decided.
const FEWER: &str =
    "Smaller limits and buffers, or fewer types of parts in one, make the line smaller";

/// Help text if it was not decided whether a line gets stuck.
const A_RUN: &str = "Nothing is known to be wrong. A run shows whether the line gets stuck with the times that it has; smaller buffers, or fewer \
                     types of parts in one, make it smaller";

/// Note on something undecided, with the reason.
fn not_decided(line: &Line, what: &str, why: &UndecidedReason, help: &str) -> Diagnostic {
    let message = format!("{what} was not decided: {why}");
    note(line, message, why.limit, help)
}

/// Note that it was not decided whether a station answers every call.
fn not_followed(line: &Line, node: usize, why: &UndecidedReason) -> Diagnostic {
    let what = format!("whether {} answers every call", line.nodes[node].name);
    let help = match why.limit {
        Some(_) => ASKED.to_owned(),
        None => format!("{ASKED}; `--effort 10` lets the proof try ten times as much"),
    };
    not_decided(line, &what, why, &help)
}

/// Note on something undecided. The help ends with how to lift the limit.
fn note(line: &Line, message: String, limit: Option<Limit>, help: &str) -> Diagnostic {
    let remedy = limit.and_then(Limit::remedy);
    let remedy = remedy
        .map(|remedy| format!(" Or {remedy}."))
        .unwrap_or_default();
    Diagnostic::note(codes::LINE_UNDECIDED, line.span, message)
        .with_help(format!("{help}.{remedy}"))
        .giving_up(limit.is_some_and(Limit::is_of_command))
}
