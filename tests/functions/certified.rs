//! The certificate check: right functions pass on both kernels, and whatever passes is right.

use super::random::{self, Random};
use super::{benchmark, explicit, fixtures, functions};
use linewright::game::{KernelChoice, Limits};
use linewright::gr1::Specification;
use linewright::mealy::certify::{certify, certify_on};
use linewright::mealy::functions::Functions;
use linewright::mealy::verify::verify;
use linewright::symbolic::{Biodivine, Edge, OxiDd};

const KERNELS: [KernelChoice; 2] = [KernelChoice::Biodivine, KernelChoice::OxiDd];

/// Certifies on both kernels, which must agree.
fn certified(specification: &Specification, functions: &Functions) -> Result<(), String> {
    let limits = Limits::default();
    let one = certify_on::<Biodivine>(specification, functions, &limits).expect("no limit");
    let other = certify_on::<OxiDd>(specification, functions, &limits).expect("no limit");
    assert_eq!(one, other);
    one.map_err(|fault| fault.rule)
}

/// The verdict of the explicit checker, which is complete.
fn verified(specification: &Specification, functions: &Functions) -> Result<(), String> {
    let machine = explicit::machine(functions);
    let verdict = verify(specification, &machine, &Limits::default()).expect("no limit");
    verdict.map_err(|violation| violation.rule)
}

#[test]
fn functions_of_the_fixtures_are_right() {
    for specification in fixtures::contracts() {
        for kernel in KERNELS {
            let functions = functions(&specification, kernel).expect("realizable");
            assert_eq!(certified(&specification, &functions), Ok(()));
            assert_eq!(verified(&specification, &functions), Ok(()));
        }
    }
}

#[test]
fn functions_of_random_specifications_are_right_and_no_wrong_ones_pass() {
    let (mut realizable, mut refused, mut passed, mut wrong, mut moore) = (0, 0, 0, 0, 0);
    for seed in 0..700 {
        let mut random = Random::new(seed);
        let specification = random::specification(&mut random);
        let kernel = KERNELS[seed as usize % 2];
        let Some(right) = functions(&specification, kernel) else {
            continue;
        };
        realizable += 1;
        moore += i32::from(right.timing == linewright::gr1::Timing::Moore);
        assert_eq!(certified(&specification, &right), Ok(()), "seed {seed}");
        assert_eq!(verified(&specification, &right), Ok(()), "seed {seed}");
        for _ in 0..4 {
            let Some(mutant) = mutate(&mut random, &right) else {
                continue;
            };
            if certified(&specification, &mutant).is_ok() {
                passed += 1;
                assert_eq!(verified(&specification, &mutant), Ok(()), "seed {seed}");
            } else {
                refused += 1;
                wrong += i32::from(verified(&specification, &mutant).is_err());
            }
        }
    }
    println!(
        "{realizable} realizable ({moore} moore), mutants: {refused} refused, {wrong} of them wrong, {passed} passed"
    );
    assert!(realizable > 150 && moore > 20);
    assert!(wrong > 100 && passed > 50);
}

/// Flips an edge of the diagram, or lets a root lead elsewhere.
fn mutate(random: &mut Random, functions: &Functions) -> Option<Functions> {
    let mut mutant = functions.clone();
    let controls = &mut mutant.controls;
    let nodes = controls.diagram.nodes.len() as u64;
    if nodes > 0 && random.chance(60) {
        let node = &mut controls.diagram.nodes[random.below(nodes) as usize];
        let edge = if random.chance(50) {
            &mut node.high
        } else {
            &mut node.low
        };
        *edge = edge.negated();
        return Some(mutant);
    }
    let goals = controls.goals.len() as u64;
    let goal = &mut controls.goals[random.below(goals) as usize];
    let modes = goal.modes.len() as u64;
    match random.below(4) {
        0 => goal.reached = goal.reached.negated(),
        1 if modes > 1 => {
            let mode = &mut goal.modes[random.below(modes - 1) as usize];
            mode.when = if random.chance(50) {
                Edge::TRUE
            } else {
                Edge::FALSE
            };
        }
        2 => {
            let count = controls.first.len() as u64;
            let edge = &mut controls.first[random.below(count) as usize].1;
            *edge = edge.negated();
        }
        _ => {
            let mode = &mut goal.modes[random.below(modes) as usize];
            let count = mode.outputs.len() as u64;
            if count == 0 {
                return None;
            }
            let edge = &mut mode.outputs[random.below(count) as usize].1;
            *edge = match random.below(3) {
                0 => Edge::TRUE,
                1 => Edge::FALSE,
                _ => edge.negated(),
            };
        }
    }
    (mutant != *functions).then_some(mutant)
}

#[test]
fn functions_of_a_benchmark_pass_and_corrupted_ones_do_not() {
    let Some(specification) = benchmark("genbuf5.slugsin") else {
        return;
    };
    let right = functions(&specification, KernelChoice::OxiDd).expect("realizable");
    let limits = Limits::default();
    assert_eq!(certify(&specification, &right, &limits), Ok(Ok(())));
    let mut random = Random::new(5);
    let mut refused = 0;
    for _ in 0..10 {
        if let Some(mutant) = mutate(&mut random, &right) {
            refused += i32::from(certify(&specification, &mutant, &limits) != Ok(Ok(())));
        }
    }
    assert!(refused > 3, "only {refused} mutants were refused");
}
