//! Lines and their proofs: what `check` asks of a line before it runs.

use crate::algebra::proof::{Discharged, prove};
use crate::algebra::system::{FormulaRef, Half, list};
use crate::contract::line::Line;
use crate::diagnostics::{Diagnostic, codes};
use crate::game::{Limit, Limits};
use crate::line::abstraction::{self, Abstraction, findings};
use std::time::{Duration, Instant};

/// A line gets so long, and so many nodes, and is then said to be too large.
const SECONDS: u64 = 30;
const NODES: u64 = 2_000_000;
/// So long is asked whether everything goes on, when nothing can get lost or stuck.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is known of a line.
#[derive(Debug, Default)]
pub struct Proof {
    /// `proved`, `safe` where it was not decided in time that everything goes on, `open` or `gave_up`.
    pub verdict: &'static str,
    /// Of a safe one: what was not decided.
    pub undecided: Vec<String>,
    /// What each requirement and each assumption of a place rests on: place (or the line), formula, and by what.
    pub discharges: Vec<(String, String, String)>,
    /// What is wrong.
    pub findings: Vec<Diagnostic>,
}

/// Proves a line, or says what keeps it from being true.
pub fn examine(line: &Line, limits: &Limits) -> Proof {
    let own = Instant::now() + Duration::from_secs(SECONDS);
    let limits = Limits {
        deadline: Some(limits.deadline.map_or(own, |given| given.min(own))),
        most_nodes: Some(NODES),
        ..*limits
    };
    let (abstraction, verdict) = match abstraction::examine(line, &limits, PATIENCE) {
        Ok(decided) => decided,
        Err(unfit) => return undecided(line, &unfit.0),
    };
    if !verdict.open.is_empty() {
        return Proof {
            verdict: "open",
            findings: findings(line, &abstraction, &verdict),
            ..Proof::default()
        };
    }
    if !verdict.holds() {
        let undecided = verdict
            .undecided
            .iter()
            .map(|at| abstraction.goal(*at).name.clone());
        return Proof {
            verdict: "safe",
            undecided: undecided.collect(),
            ..Proof::default()
        };
    }
    Proof {
        verdict: "proved",
        discharges: table(line, &abstraction, &limits).unwrap_or_default(),
        ..Proof::default()
    }
}

/// What rests on what; nothing where a limit was reached first, for the verdict is known without it.
fn table(
    line: &Line,
    abstraction: &Abstraction,
    limits: &Limits,
) -> Result<Vec<(String, String, String)>, Limit> {
    let proof = prove(&abstraction.system, &abstraction.claim, limits)?;
    let place = |at: FormulaRef| {
        at.part
            .map_or(line.name.as_str(), |part| {
                &abstraction.system.parts[part].name
            })
            .to_owned()
    };
    let name = |at: FormulaRef| {
        let side = match (at.part, at.half) {
            (Some(part), half) => abstraction.system.parts[part].half(half),
            (None, Half::Assumptions) => &abstraction.claim.given,
            (None, Half::Guarantees) => &abstraction.claim.goal,
        };
        list(side, at.kind)[at.index].name.clone()
    };
    let whole = |at: FormulaRef| format!("{}.{}", place(at), name(at));
    let discharges = proof.discharges.iter().map(|discharge| {
        let by: Vec<String> = discharge.by.iter().map(|at| whole(*at)).collect();
        let rule = match discharge.rule {
            Discharged::Environment => "given".to_owned(),
            Discharged::Exported => "left to the environment".to_owned(),
            Discharged::Induction => "step by step".to_owned(),
            Discharged::Justice { turn } => format!("again and again, turn {turn}"),
        };
        (
            place(discharge.what),
            name(discharge.what),
            format!("{rule}: {}", by.join(", ")),
        )
    });
    Ok(discharges.collect())
}

fn undecided(line: &Line, why: &str) -> Proof {
    let message = format!(
        "whether parts can block one another in {} was not decided: {why}",
        line.name
    );
    let note = Diagnostic::note(codes::LINE_UNDECIDED, line.span, message).with_help(
        "Nothing is known to be wrong. A run shows whether the line gets stuck with the times that it has; smaller buffers, or fewer \
         types of parts in one, make it smaller.",
    );
    Proof {
        verdict: "gave_up",
        findings: vec![note],
        ..Proof::default()
    }
}
