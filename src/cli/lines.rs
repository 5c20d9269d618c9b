//! Lines and their proofs: what `check` asks of a line before it runs.

use super::algebra::words::{DischargeEntry, Told, entry};
use super::asked;
use super::libraries::Controlled;
use crate::algebra::proof::prove;
use crate::algebra::system::FormulaRef;
use crate::contract::line::Line;
use crate::contract::machine::Machine;
use crate::diagnostics::{Diagnostic, codes};
use crate::game::{Budget, Limit, Limits, RuleKind};
use crate::line::abstraction::Verdict;
use crate::line::abstraction::{self, Abstraction, findings};

/// Of lines with more variables it is not asked whether everything goes on.
const MOST_VARIABLES: usize = 48;

/// What is known of a line.
#[derive(Debug, Default)]
pub struct Proof {
    /// `proved`, `safe` where it was not decided that everything goes on, `open` or `gave_up`.
    pub verdict: &'static str,
    /// Of a safe one: what was not decided.
    pub undecided: Vec<String>,
    /// What each requirement and each assumption of a place rests on.
    pub discharges: Vec<DischargeEntry>,
    /// What is wrong.
    pub findings: Vec<Diagnostic>,
}

/// Proves a line, or says what keeps it from being true. The table of what rests on what takes longer than the verdict, and is made where it is
/// wanted. `controlled` has the controllers of a machine, as far as they are there.
pub fn examine<'a>(
    line: &Line,
    controlled: impl Fn(&Machine) -> Option<Controlled<'a>>,
    limits: &Limits,
    with_table: bool,
) -> Proof {
    // That every part is worked on rests on every operation being one that the station may be asked for.
    let asked = asked::examine(line, controlled, &bounded(limits));
    let mut proof = examine_moves(line, &bounded(limits), with_table);
    if !asked.findings.is_empty() {
        proof.verdict = "open";
        proof.discharges.clear();
        proof.undecided.clear();
    } else if !asked.undecided.is_empty() && proof.verdict == "proved" {
        proof.verdict = "safe";
    }
    proof.findings.extend(asked.findings);
    for (station, why) in asked.undecided {
        let message = format!(
            "whether {station} is asked only for what its machine allows was not decided: {why}"
        );
        proof.findings.push(note(line, message, ASKED));
        if proof.verdict == "safe" {
            proof.undecided.push(format!("asked_rightly_at_{station}"));
        }
    }
    proof
}

/// What one question about a line may take.
fn bounded(limits: &Limits) -> Limits {
    limits.within(Budget::LINE)
}

/// Whether parts move on, each operation being done.
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
                (Vec::new(), Some(note(line, message, FEWER)))
            }
        }
    };
    let (abstraction, verdict) = match abstraction::examine(line, limits, MOST_VARIABLES) {
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
    let (discharges, unknown) = table(&abstraction, &verdict);
    let undecided = verdict.undecided.iter();
    let undecided: Vec<String> = undecided
        .map(|at| abstraction.goal(*at).name.clone())
        .collect();
    let mut findings: Vec<Diagnostic> = unknown.into_iter().collect();
    if !undecided.is_empty() {
        let message = format!(
            "parts cannot block one another in {}, but whether everything goes on was not decided: {}",
            line.name,
            undecided.join(", ")
        );
        findings.push(note(line, message, FEWER));
    }
    Proof {
        verdict: if verdict.holds() { "proved" } else { "safe" },
        undecided,
        discharges,
        findings,
    }
}

/// What rests on what. Of what was not decided nothing is said; nothing at all where a limit was reached first, for the verdict is known without
/// it.
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
    let told = Told {
        system: &abstraction.system,
        claim: &claim,
        whole: &line.name,
    };
    Ok(proof.discharges.iter().map(|d| entry(told, d)).collect())
}

/// What to do where it was not decided what a station is asked for.
const ASKED: &str = "A run shows what is refused; orders about operations alone are decided, whatever the parts are like.";

/// What to do where something was not decided.
const FEWER: &str = "Smaller limits and buffers, or fewer types of parts in one, make the line smaller; `--effort 10` lets the proof do ten times \
                     the work.";

fn undecided(line: &Line, why: &str) -> Proof {
    let message = format!(
        "whether parts can block one another in {} was not decided: {why}",
        line.name
    );
    let help = "Nothing is known to be wrong. A run shows whether the line gets stuck with the times that it has; smaller buffers, or fewer \
                types of parts in one, make it smaller.";
    Proof {
        verdict: "gave_up",
        findings: vec![note(line, message, help)],
        ..Proof::default()
    }
}

fn note(line: &Line, message: String, help: &str) -> Diagnostic {
    Diagnostic::note(codes::LINE_UNDECIDED, line.span, message).with_help(help)
}
