//! Refinement with its reasons.

use super::contracts::{akin, any, part, system, variables};
use super::graph::Board;
use super::lassos::{all, keeps};
use crate::random::Random;
use linewright::algebra::contract::{Contract, RunSet};
use linewright::algebra::decide::Decider;
use linewright::algebra::proof::{Discharge, DischargeRule, Open, Refutation};
use linewright::algebra::refine::{Question, refine};
use linewright::algebra::replay;
use linewright::algebra::system::{ContractSide, FormulaRef, System};
use linewright::game::{Lasso, Limits};
use linewright::gr1::{FormulaKind, Side};

const PAIRS: u64 = 1_500;

#[derive(Debug, Default)]
struct Counts {
    refines: u32,
    vacuous: u32,
    assumptions_fail: u32,
    guarantees_fail: u32,
    traces: u32,
    lassos: u32,
    discharges: u32,
    reasons: u32,
    /// Reasons without which no infinite run violates the formula, but a step does.
    for_the_step: u32,
    environment: u32,
    induction: u32,
    justice: u32,
}

/// A side with these formulas alone.
fn only(question: &Question, refs: &[FormulaRef]) -> Side {
    let mut side = Side::default();
    for at in refs {
        let formula = replay::formula(&question.system, &question.claim, *at).clone();
        side.list_mut(at.kind).push(formula);
    }
    side
}

/// A run of any length that keeps one side and not the other.
fn between(question: &Question, kept: &Side, broken: &Side) -> Option<Lasso> {
    let reduced = part("reduced", kept.clone(), broken.clone());
    let reduced = system(&question.system.variables, vec![reduced]);
    let mut decider = Decider::new(&reduced, &Limits::default()).expect("room");
    let [kept_runs, promised] =
        [ContractSide::Assumptions, ContractSide::Guarantees].map(|h| RunSet::Side(0, h));
    let found = decider.difference(&kept_runs, &promised).expect("no limit");
    if let Some(run) = &found {
        assert!(keeps(kept, run) && !keeps(broken, run), "{run:?}");
    }
    found
}

/// Whether a finite run keeps one side, and its last step violates the only formula of the other.
fn a_step_breaks(board: &Board, kept: &Side, broken: &Side) -> bool {
    let runs = board.steps([kept]);
    let right = board.steps([broken]);
    let reached = runs.reach(runs.start);
    let mut everything = 0..board.valuations.len();
    runs.start & !right.start != 0
        || everything.any(|s| reached >> s & 1 == 1 && runs.step[s] & !right.step[s] != 0)
}

/// The reasons of a discharge suffice, and none can be omitted.
fn check_discharge(question: &Question, lassos: &[Lasso], found: &Discharge, counts: &mut Counts) {
    let what = only(question, &[found.what]);
    let by = only(question, &found.by);
    for run in lassos {
        assert!(!keeps(&by, run) || keeps(&what, run), "{run:?}");
    }
    assert_eq!(between(question, &by, &what), None);
    let board = Board::new(&question.system.variables);
    for i in 0..found.by.len() {
        let mut fewer = found.by.clone();
        fewer.remove(i);
        let fewer = only(question, &fewer);
        counts.reasons += 1;
        if between(question, &fewer, &what).is_none() {
            assert!(
                found.what.kind != FormulaKind::Justice && a_step_breaks(&board, &fewer, &what),
                "reason {i} is not needed for {found:?}"
            );
            counts.for_the_step += 1;
        }
    }
    // A goal may rest on others proved before it.
    let given = |at: &FormulaRef| at.component.is_none() && at.half == ContractSide::Assumptions;
    let environment = found.by.iter().all(given);
    let justice = found.by.iter().any(|at| at.kind == FormulaKind::Justice);
    match found.rule {
        DischargeRule::Environment => assert!(environment),
        DischargeRule::Induction => assert!(!environment && !justice),
        DischargeRule::Justice { .. } => assert!(!environment && justice),
        DischargeRule::Exported => panic!("nobody to hand it on to"),
    }
    counts.discharges += 1;
    match found.rule {
        DischargeRule::Environment => counts.environment += 1,
        DischargeRule::Induction => counts.induction += 1,
        _ => counts.justice += 1,
    }
}

/// A counterexample is one, by the evaluator of the algebra and by the definitions. A trace keeps
/// what is known, its last step violates the formula, and from there an infinite run keeps what is
/// known, including justice.
fn check_open(question: &Question, open: &Open, counts: &mut Counts) {
    let Question {
        system,
        claim,
        proof,
    } = question;
    assert_eq!(replay::accepts(system, claim, proof, open), Ok(()));
    let what = only(question, &[open.what]);
    let known: Vec<&Side> = [&claim.given]
        .into_iter()
        .chain(system.components.iter().map(|p| &p.guarantees))
        .collect();
    match &open.why {
        Refutation::Lasso(run) => {
            counts.lassos += 1;
            assert!(open.what.kind == FormulaKind::Justice);
            assert!(known.iter().all(|side| keeps(side, run)), "{run:?}");
            assert!(!keeps(&what, run), "{run:?}");
        }
        Refutation::Trace(steps) => {
            counts.traces += 1;
            assert!(open.what.kind != FormulaKind::Justice);
            let board = Board::new(&system.variables);
            let states: Vec<usize> = steps
                .iter()
                .map(|s| board.number(&s[..system.variables.len()]))
                .collect();
            let follows = |steps: &super::graph::Steps, states: &[usize]| {
                let pairs = states.windows(2);
                states.first().is_none_or(|s| steps.start >> s & 1 == 1)
                    && pairs.into_iter().all(|p| steps.step[p[0]] >> p[1] & 1 == 1)
            };
            let kept = board.steps(known.iter().copied());
            assert!(follows(&kept, &states), "{steps:?}");
            let right = board.steps([&what]);
            assert!(!follows(&right, &states), "{steps:?}");
            assert!(follows(&right, &states[..states.len() - 1]), "{steps:?}");
            let justice = known.iter().flat_map(|side| board.relations(&side.justice));
            let lasting = kept.lasting(&justice.collect::<Vec<_>>());
            assert!(lasting >> states[states.len() - 1] & 1 == 1, "{steps:?}");
        }
    }
}

/// Every formula to be proved is discharged or open, and the reported reason is true.
fn check(question: &Question, lassos: &[Lasso], counts: &mut Counts) {
    let proof = &question.proof;
    assert!(proof.loops.is_empty() && proof.cycles.is_empty());
    let mut goals: Vec<FormulaRef> = Vec::new();
    for kind in FormulaKind::ALL {
        let count = question.claim.goal.list(kind).len();
        goals.extend((0..count).map(|index| FormulaRef {
            component: None,
            half: ContractSide::Guarantees,
            kind,
            index,
        }));
    }
    let shown = proof
        .discharges
        .iter()
        .map(|d| d.what)
        .chain(proof.open.iter().map(|o| o.what));
    let mut shown: Vec<FormulaRef> = shown.collect();
    shown.sort();
    goals.sort();
    assert_eq!(shown, goals);
    for discharge in &proof.discharges {
        check_discharge(question, lassos, discharge, counts);
    }
    for open in &proof.open {
        check_open(question, open, counts);
    }
}

/// Explained refinement gives the verdict of the exact decision; its reasons suffice on every lasso
/// up to the bound and on all runs; without any of them the formula can be violated; and every
/// counterexample is one.
#[test]
fn refinement_is_explained_right() {
    let limits = Limits::default();
    let mut counts = Counts::default();
    for seed in 60_000..60_000 + PAIRS {
        let mut r = Random::new(seed);
        let (variables, bound) = variables(&mut r);
        let large = any(&mut r, &variables);
        let small = akin(&mut r, &variables, &large);
        let system: System = system(&variables, vec![small, large]);
        let lassos = all(&variables, bound);
        let found = refine(&system, 0, 1, &limits).expect("no limit");
        let mut decider = Decider::new(&system, &limits).expect("room");
        let [small, large] = [0, 1].map(Contract::component);
        let refutation = decider.refutation(&small, &large).expect("no limit");
        assert_eq!(found.holds(), refutation.is_none(), "seed {seed}");
        let [a1, a2] = [0, 1].map(|i| RunSet::Side(i, ContractSide::Assumptions));
        let [g1, g2] = [0, 1].map(|i| RunSet::Side(i, ContractSide::Guarantees));
        let assumed = decider.difference(&a2, &a1).expect("no limit").is_none();
        let promised = decider
            .difference(&a2.clone().and(g1), &g2)
            .expect("no limit")
            .is_none();
        assert_eq!(found.assumptions.proof.holds(), assumed, "seed {seed}");
        assert_eq!(found.guarantees.proof.holds(), promised, "seed {seed}");
        let nothing = decider.difference(&a2, &RunSet::Any(Vec::new()));
        let is_vacuous = nothing.expect("no limit").is_none();
        assert_eq!(found.is_vacuous, is_vacuous, "seed {seed}");
        counts.vacuous += u32::from(is_vacuous);
        counts.refines += u32::from(found.holds());
        counts.assumptions_fail += u32::from(!assumed);
        counts.guarantees_fail += u32::from(!promised);
        check(&found.assumptions, &lassos, &mut counts);
        check(&found.guarantees, &lassos, &mut counts);
    }
    println!("{PAIRS} pairs: {counts:?}");
    let pairs = PAIRS as u32;
    assert!(counts.refines * 5 >= pairs && counts.refines * 5 <= 4 * pairs);
    assert!(counts.assumptions_fail * 10 >= pairs && counts.guarantees_fail * 10 >= pairs);
    assert!(counts.traces >= 300 && counts.lassos >= 300);
    assert!(counts.environment >= 200 && counts.induction >= 200 && counts.justice >= 100);
}
