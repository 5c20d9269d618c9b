//! The effect on a discharge table of removing something that one of its lines names.

use super::tables::{name, table};
use linewright::algebra::proof::{Claim, Discharge, DischargeRule, Exports, Proof, decide};
use linewright::algebra::replay;
use linewright::algebra::system::{ContractSide, FormulaRef, System};
use linewright::game::Limits;
use linewright::gr1::{FormulaKind, Side};

/// Every line of a table: what it names suffices, and without any single item the proof fails, with
/// a counterexample that the evaluator accepts. Returns the numbers of lines and of mutants.
#[track_caller]
pub fn nothing_can_be_left_out(system: &System, claim: &Claim, proof: &Proof) -> (usize, usize) {
    let (mut lines, mut mutants) = (0, 0);
    for discharge in &proof.discharges {
        lines += 1;
        let what = name(system, claim, discharge.what);
        let (reduced, own) = alone(system, claim, discharge, None);
        let again = decide(&reduced, &own, &Limits::default()).expect("no limit");
        assert!(again.holds(), "{what}: {}", table(&reduced, &own, &again));
        for named in &discharge.by {
            if named.half == ContractSide::Completions {
                assert!(follows_from_its_contract(system, *named), "{what}");
            }
            mutants += 1;
            let without = name(system, claim, *named);
            let (reduced, own) = alone(system, claim, discharge, Some(*named));
            let again = decide(&reduced, &own, &Limits::default()).expect("no limit");
            assert!(!again.holds(), "{what} does not need {without}");
            assert!(!again.open.is_empty(), "{what} without {without}");
            for open in &again.open {
                assert_eq!(replay::accepts(&reduced, &own, &again, open), Ok(()));
            }
        }
    }
    (lines, mutants)
}

/// Whether a completion follows from the contract of its component, without the others.
fn follows_from_its_contract(system: &System, at: FormulaRef) -> bool {
    let part = &system.components[at.component.expect("a component")];
    let formula = system.formula(at).expect("a formula").clone();
    let mut alone = part.clone();
    alone.assumptions = Side::default();
    alone.completions = Side::default();
    let system = System {
        variables: system.variables.clone(),
        components: vec![alone],
    };
    let claim = Claim {
        given: part.assumptions.clone(),
        goal: Side {
            justice: vec![formula],
            ..Side::default()
        },
        exports: Exports::Never,
        ..Claim::default()
    };
    let proof = decide(&system, &claim, &Limits::default());
    proof.expect("no limit").holds()
}

/// One line of a table by itself: the obligation with what it rests on, except one item.
fn alone(
    system: &System,
    claim: &Claim,
    discharge: &Discharge,
    without: Option<FormulaRef>,
) -> (System, Claim) {
    let names: Vec<FormulaRef> = discharge
        .by
        .iter()
        .copied()
        .filter(|at| Some(*at) != without)
        .collect();
    let pick = |side: &Side, keep: &dyn Fn(FormulaKind, usize) -> bool| {
        let mut picked = Side::default();
        for (kind, index, formula) in side.formulas() {
            if keep(kind, index) {
                picked.list_mut(kind).push(formula.clone());
            }
        }
        picked
    };
    let at = |part, half, kind, index| FormulaRef {
        component: part,
        half,
        kind,
        index,
    };
    let mut reduced = system.clone();
    for (i, part) in reduced.components.iter_mut().enumerate() {
        part.guarantees = pick(&part.guarantees, &|k, n| {
            names.contains(&at(Some(i), ContractSide::Guarantees, k, n))
        });
        part.assumptions = pick(&part.assumptions, &|k, n| {
            discharge.what == at(Some(i), ContractSide::Assumptions, k, n)
        });
        part.completions = Side::default();
    }
    let mut given = pick(&claim.given, &|k, n| {
        names.contains(&at(None, ContractSide::Assumptions, k, n))
    });
    // What was passed on belongs to the environment. What was proved before is known: of the goal,
    // of assumptions, and what follows from a contract alone.
    for name in names.iter().filter(|n| match n.half {
        ContractSide::Assumptions => n.component.is_some(),
        ContractSide::Guarantees => n.component.is_none(),
        ContractSide::Completions => true,
    }) {
        let formula = replay::formula(system, claim, *name);
        given.list_mut(name.kind).push(formula.clone());
    }
    let goal = pick(&claim.goal, &|k, n| {
        discharge.what == at(None, ContractSide::Guarantees, k, n)
    });
    let exports = match discharge.rule {
        DischargeRule::Exported => claim.exports.clone(),
        _ => Exports::Never,
    };
    (
        reduced,
        Claim {
            given,
            goal,
            exports,
            ..Claim::default()
        },
    )
}
