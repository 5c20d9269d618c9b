//! Independent check of counterexamples: evaluates formulas on plain values, step by step.

use super::contract::RunSet;
use super::proof::{Claim, Exports, Open, Proof, Refutation};
use super::system::{ContractSide, FormulaRef, System};
use linewright_core::gr1::{Formula, FormulaKind, Side, VarId, eval};
use linewright_solver::game::Lasso;
use std::collections::BTreeSet;

/// Returns whether an infinite run keeps all formulas of one side.
pub fn keeps(side: &Side, run: &Lasso) -> bool {
    side.formulas()
        .all(|(kind, _, formula)| keeps_formula(kind, formula, run))
}

/// Returns whether an infinite run is in a set of runs. The definitions of monitors are not
/// checked.
pub fn contains(system: &System, set: &RunSet, run: &Lasso) -> bool {
    match set {
        RunSet::Side(component, half) => keeps(system.components[*component].half(*half), run),
        RunSet::Not(inner) => !contains(system, inner, run),
        RunSet::All(all) => all.iter().all(|w| contains(system, w, run)),
        RunSet::Any(any) => any.iter().any(|w| contains(system, w, run)),
    }
}

/// Returns whether a lasso is a run of the system: every value is in its variable's domain, every
/// monitor has the value that its definition gives, and the cycle is not empty.
pub fn is_run(system: &System, run: &Lasso) -> bool {
    let steps = run.prefix.iter().chain(&run.cycle);
    !run.cycle.is_empty()
        && steps.into_iter().all(|step| within_domains(system, step))
        && system.components.iter().all(|p| keeps(&p.definitions, run))
}

/// Returns whether an infinite run keeps a formula.
pub fn keeps_formula(kind: FormulaKind, formula: &Formula, run: &Lasso) -> bool {
    let steps: Vec<&Vec<i64>> = run.prefix.iter().chain(&run.cycle).collect();
    let after = |i: usize| {
        if i + 1 < steps.len() {
            steps[i + 1]
        } else {
            steps[run.prefix.len()]
        }
    };
    let holds = |i: usize| eval::holds(&formula.expr, steps[i], after(i));
    match kind {
        FormulaKind::Initial => holds(0),
        FormulaKind::Invariant | FormulaKind::Safety => (0..steps.len()).all(holds),
        FormulaKind::Justice => (run.prefix.len()..steps.len()).any(holds),
    }
}

/// Checks that a counterexample proves that an obligation is not met.
///
/// A trace has to keep all formulas in all steps but the last. In the last step it has to keep the
/// givens, the definitions of monitors and the exported assumptions (for a goal also all
/// guarantees), and it has to break the open obligation. A lasso has to keep all safety, the
/// givens, and the justice guarantees of components without open justice assumptions, and it has to
/// break the open obligation.
///
/// # Errors
/// If the counterexample does not prove this; the text states what is wrong with it.
pub fn accepts(system: &System, claim: &Claim, proof: &Proof, open: &Open) -> Result<(), String> {
    let what = formula(system, claim, open.what);
    match &open.why {
        Refutation::Trace(steps) => trace(system, claim, proof, open.what, what, steps),
        Refutation::Lasso(run) => lasso(system, claim, proof, open.what, what, run),
    }
}

/// Returns the referenced formula, of a component or of the claim.
pub fn formula<'a>(system: &'a System, claim: &'a Claim, at: FormulaRef) -> &'a Formula {
    match (system.formula(at), at.half) {
        (Some(formula), _) => formula,
        (None, ContractSide::Assumptions) => &claim.given.list(at.kind)[at.index],
        (None, _) => &claim.goal.list(at.kind)[at.index],
    }
}

fn within_domains(system: &System, step: &[i64]) -> bool {
    let values = system.variables.iter().zip(step);
    step.len() >= system.variables.len() && values.into_iter().all(|(v, x)| v.domain.contains(*x))
}

/// Returns all formulas that a run has to keep: definitions, guarantees and assumptions of
/// components, and givens.
fn everything<'a>(
    system: &'a System,
    claim: &'a Claim,
) -> impl Iterator<Item = (FormulaKind, &'a Formula)> {
    let sides = system
        .components
        .iter()
        .flat_map(|p| [&p.definitions, &p.guarantees, &p.assumptions]);
    sides
        .chain([&claim.given])
        .flat_map(|side| side.formulas().map(|(kind, _, formula)| (kind, formula)))
}

/// Returns whether a formula holds in step `at`: safety is evaluated on the step before and this
/// step, and justice is always true.
pub fn holds_at(kind: FormulaKind, formula: &Formula, steps: &[Vec<i64>], at: usize) -> bool {
    match kind {
        FormulaKind::Initial => at > 0 || eval::holds(&formula.expr, &steps[0], &[]),
        FormulaKind::Invariant => eval::holds(&formula.expr, &steps[at], &[]),
        FormulaKind::Safety => at == 0 || eval::holds(&formula.expr, &steps[at - 1], &steps[at]),
        FormulaKind::Justice => true,
    }
}

fn trace(
    system: &System,
    claim: &Claim,
    proof: &Proof,
    at: FormulaRef,
    what: &Formula,
    steps: &[Vec<i64>],
) -> Result<(), String> {
    let Some(last) = steps.len().checked_sub(1) else {
        return Err("the trace has no steps".to_owned());
    };
    if !steps.iter().all(|s| within_domains(system, s)) {
        return Err("a value is outside its domain".to_owned());
    }
    let is_goal = at.component.is_none();
    for (kind, formula) in everything(system, claim) {
        let steps_kept = if is_goal && !is_assumed(system, formula) {
            last + 1
        } else {
            last
        };
        if let Some(broken) = (0..steps_kept).find(|i| !holds_at(kind, formula, steps, *i)) {
            return Err(format!("step {broken} breaks {}", formula.name));
        }
    }
    let binding = claim.given.formulas().map(|(k, _, f)| (k, f)).chain(
        system
            .components
            .iter()
            .flat_map(|p| p.definitions.formulas().map(|(k, _, f)| (k, f))),
    );
    for (kind, formula) in binding {
        if !holds_at(kind, formula, steps, last) {
            return Err(format!("the last step breaks {}", formula.name));
        }
    }
    for discharge in &proof.discharges {
        if discharge.rule == super::proof::DischargeRule::Exported && discharge.what != at {
            let formula = self::formula(system, claim, discharge.what);
            if !holds_at(discharge.what.kind, formula, steps, last) {
                return Err(format!(
                    "the last step breaks {}, which is exported",
                    formula.name
                ));
            }
        }
    }
    if holds_at(at.kind, what, steps, last) {
        return Err(format!("the last step keeps {}", what.name));
    }
    if let (Exports::After(after), true) =
        (&claim.exports, last > 0 && is_outside(system, at, what))
        && eval::holds(after, &steps[last - 1], &[])
    {
        return Err(
            "the environment is responsible for the assumption in the last step".to_owned(),
        );
    }
    Ok(())
}

fn is_assumed(system: &System, formula: &Formula) -> bool {
    let mut assumed = system.components.iter().flat_map(|p| p.assumptions.all());
    assumed.any(|f| std::ptr::eq(f, formula))
}

fn is_outside(system: &System, at: FormulaRef, what: &Formula) -> bool {
    let latest = super::proof::latest(&what.expr, at.kind);
    latest
        .into_iter()
        .any(|v: VarId| system.driver(v).is_none())
}

fn lasso(
    system: &System,
    claim: &Claim,
    proof: &Proof,
    at: FormulaRef,
    what: &Formula,
    run: &Lasso,
) -> Result<(), String> {
    if !is_run(system, run) {
        return Err("the lasso is not a run of the system".to_owned());
    }
    let waiting: BTreeSet<usize> = proof
        .open
        .iter()
        .filter(|o| o.what.kind == FormulaKind::Justice)
        .filter_map(|o| o.what.component)
        .collect();
    for (kind, formula) in everything(system, claim) {
        if kind != FormulaKind::Justice && !keeps_formula(kind, formula, run) {
            return Err(format!("the run breaks {}", formula.name));
        }
    }
    let reliable = system
        .components
        .iter()
        .enumerate()
        .filter(|(i, _)| !waiting.contains(i));
    let owed = reliable.flat_map(|(_, p)| &p.guarantees.justice);
    for formula in owed.chain(&claim.given.justice) {
        if !keeps_formula(FormulaKind::Justice, formula, run) {
            return Err(format!("the run starves {}", formula.name));
        }
    }
    if keeps_formula(at.kind, what, run) {
        return Err(format!("the run keeps {}", what.name));
    }
    Ok(())
}
