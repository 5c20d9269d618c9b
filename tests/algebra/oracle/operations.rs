//! Composition, conjunction, quotient, merging and refinement of random contracts, compared with
//! their definitions.

use super::contracts::{akin, any, system, variables};
use super::lassos::{Meaning, all};
use crate::random::Random;
use linewright::algebra::contract::Contract;
use linewright::algebra::decide::Decider;
use linewright::algebra::replay;
use linewright::algebra::system::{ContractSide, System};
use linewright::game::{Lasso, Limits};

const PAIRS: u64 = 1_200;

/// Counts of the outcomes of questions about an operation.
#[derive(Debug, Default, Clone, Copy)]
struct Outcomes {
    refines: u32,
    assumptions: u32,
    guarantees: u32,
    /// Counterexamples longer than the enumerated lassos.
    longer: u32,
}

/// The operations by name, on contracts and on their meanings.
type Operation = (
    &'static str,
    fn(&Contract, &Contract) -> Contract,
    fn(&Meaning, &Meaning) -> Meaning,
);

const OPERATIONS: [Operation; 5] = [
    ("refine", |a, _| a.clone(), |a, _| a.clone()),
    ("compose", Contract::compose, Meaning::compose),
    ("conjoin", Contract::conjoin, Meaning::conjoin),
    ("quotient", Contract::quotient, Meaning::quotient),
    ("merge", Contract::merge, Meaning::merge),
];

/// Three contracts: two to operate on, and one to compare with, related to one of them or to none.
fn triple(r: &mut Random) -> (System, usize) {
    let (variables, bound) = variables(r);
    let first = any(r, &variables);
    let second = if r.chance(60) {
        akin(r, &variables, &first)
    } else {
        any(r, &variables)
    };
    let of = if r.chance(50) { &first } else { &second };
    let third = akin(r, &variables, of);
    (system(&variables, vec![first, second, third]), bound)
}

/// Membership in each operation equals its definition on every lasso up to the bound. A question
/// whether one contract refines another is answered correctly: with "yes", no such lasso is a
/// counterexample; with "no", the returned run is one.
#[test]
fn operations_are_what_they_are_defined_as() {
    let limits = Limits::default();
    let mut outcomes = [Outcomes::default(); OPERATIONS.len()];
    let mut asked = 0;
    let mut lassos_seen = 0;
    for seed in 0..PAIRS {
        let mut r = Random::new(seed);
        let (system, bound) = triple(&mut r);
        let lassos = all(&system.variables, bound);
        lassos_seen += lassos.len();
        let meanings = Meaning::all(&system, &lassos);
        let mut decider = Decider::new(&system, &limits).expect("room");
        let [a, b, c] = [0, 1, 2].map(Contract::component);
        for ((name, operation, definition), outcomes) in OPERATIONS.iter().zip(&mut outcomes) {
            let made = operation(&a, &b);
            let meant = definition(&meanings[0], &meanings[1]);
            let members = |words| -> Vec<bool> {
                let contained = lassos.iter().map(|l| replay::contains(&system, words, l));
                contained.collect()
            };
            assert_eq!(members(&made.assumption), meant.a, "{name}, seed {seed}");
            assert_eq!(members(&made.guarantee), meant.g, "{name}, seed {seed}");

            let mut check = |small: &Contract,
                             large: &Contract,
                             of: &dyn Fn(&[Lasso]) -> [Meaning; 2],
                             outcomes: &mut Outcomes| {
                asked += 1;
                let found = decider.refutation(small, large).expect("no limit");
                let [less, more] = of(&lassos);
                let Some((half, run)) = found else {
                    assert!(less.refines(&more), "{name}, seed {seed}: {system:#?}");
                    outcomes.refines += 1;
                    return;
                };
                let [less, more] = of(std::slice::from_ref(&run));
                outcomes.longer += u32::from(run.prefix.len() + run.cycle.len() > bound);
                match half {
                    ContractSide::Assumptions => {
                        outcomes.assumptions += 1;
                        assert!(more.a[0] && !less.a[0], "{name}, seed {seed}: {run:?}");
                    }
                    ContractSide::Guarantees | ContractSide::Completions => {
                        outcomes.guarantees += 1;
                        assert!(less.g[0] && !more.g[0], "{name}, seed {seed}: {run:?}");
                    }
                }
            };
            let meaning = |lassos: &[Lasso]| {
                let m = Meaning::all(&system, lassos);
                [definition(&m[0], &m[1]), m[2].clone()]
            };
            check(&made, &c, &meaning, outcomes);
            let meaning = |lassos: &[Lasso]| {
                let [made, other] = meaning(lassos);
                [other, made]
            };
            check(&c, &made, &meaning, outcomes);
        }
    }
    println!("{PAIRS} pairs, {lassos_seen} lassos, {asked} questions");
    for ((name, ..), o) in OPERATIONS.iter().zip(outcomes) {
        println!("{name}: {o:?}");
    }
    for ((name, ..), o) in OPERATIONS.iter().zip(outcomes) {
        let all = o.refines + o.assumptions + o.guarantees;
        assert_eq!(u64::from(all), 2 * PAIRS);
        assert!(
            o.refines * 5 >= all && o.refines * 5 <= 4 * all,
            "{name}: {o:?}"
        );
        assert!(
            o.assumptions * 20 >= all && o.guarantees * 20 >= all,
            "{name}: {o:?}"
        );
    }
}
