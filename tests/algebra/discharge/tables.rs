//! Proofs as text, for snapshots.

use linewright::algebra::proof::{Claim, DischargeRule, Proof, Refutation};
use linewright::algebra::replay;
use linewright::algebra::system::{FormulaRef, System};
use std::fmt::Write as _;

/// `cell: pick_open`
pub fn name(system: &System, claim: &Claim, at: FormulaRef) -> String {
    let formula = replay::formula(system, claim, at);
    match at.component {
        Some(part) => format!("{}: {}", system.components[part].name, formula.name),
        None => formula.name.clone(),
    }
}

/// One obligation per line. Every counterexample must be accepted by the evaluator.
#[track_caller]
pub fn table(system: &System, claim: &Claim, proof: &Proof) -> String {
    let mut text = String::new();
    for d in &proof.discharges {
        let by: Vec<String> = d.by.iter().map(|b| name(system, claim, *b)).collect();
        let rule = match d.rule {
            DischargeRule::Environment => "environment".to_owned(),
            DischargeRule::Exported => "exported".to_owned(),
            DischargeRule::Induction => "induction".to_owned(),
            DischargeRule::Justice { turn } => format!("justice {}", turn + 1),
        };
        let _ = writeln!(
            text,
            "{} | {rule} | {}",
            name(system, claim, d.what),
            by.join(", ")
        );
    }
    for o in &proof.open {
        assert_eq!(replay::accepts(system, claim, proof, o), Ok(()), "{o:?}");
        let how = match &o.why {
            Refutation::Trace(steps) => format!("a trace of {} steps", steps.len()),
            Refutation::Lasso(run) => format!("a cycle of {} steps", run.cycle.len()),
        };
        let _ = writeln!(text, "{} | OPEN | {how}", name(system, claim, o.what));
    }
    for circle in &proof.cycles {
        let names: Vec<String> = circle
            .assumptions
            .iter()
            .map(|a| name(system, claim, *a))
            .collect();
        let _ = writeln!(text, "circle: {}", names.join(" -> "));
    }
    for found in &proof.loops {
        let names: Vec<&str> = found
            .variables
            .iter()
            .map(|v| system.variables[v.index()].name.as_str())
            .collect();
        let _ = writeln!(text, "loop: {}", names.join(" -> "));
    }
    text
}
