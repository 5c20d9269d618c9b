//! The certificate check: correct functions pass on both kernels, and whatever passes is correct.

use super::{benchmark, explicit, fixtures, functions};
use crate::random::{self, Random};
use linewright::game::{Aim, KernelChoice, Limits, Mode};
use linewright::gr1::Specification;
use linewright::mealy::certify::{certify, certify_on};
use linewright::mealy::functions::Functions;
use linewright::mealy::verify::verify;
use linewright::symbolic::{Biodivine, Bit, DiagramNode, Edge, SharedStore};

const KERNELS: [KernelChoice; 2] = [KernelChoice::Biodivine, KernelChoice::Shared];

/// Certifies on both kernels, which must agree.
fn certified(specification: &Specification, functions: &Functions) -> Result<(), String> {
    let limits = Limits::default();
    let one = certify_on::<Biodivine>(specification, functions, &limits).expect("no limit");
    let other = certify_on::<SharedStore>(specification, functions, &limits).expect("no limit");
    assert_eq!(one, other);
    one.map_err(|fault| fault.clause.to_string())
}

/// The verdict of the explicit checker, which is complete.
fn verified(specification: &Specification, functions: &Functions) -> Result<(), String> {
    let machine = explicit::machine(functions);
    let verdict = verify(specification, &machine, &Limits::default()).expect("no limit");
    verdict.map_err(|violation| violation.clause.to_string())
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

/// Flips an edge of the diagram, or redirects a root.
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

/// Changes a certificate.
fn mutate_certificate(random: &mut Random, specification: &Specification, mutant: &mut Functions) {
    let controls = &mut mutant.controls;
    let certificate = &mut controls.certificate;
    let nodes = certificate.diagram.nodes.len() as u64;
    let goal = random.below(controls.goals.len() as u64) as usize;
    let modes = &mut controls.goals[goal].modes;
    let layers = &mut certificate.goals[goal];
    let layer = random.below(layers.len().max(1) as u64) as usize;
    match random.below(8) {
        0 | 1 if nodes > 0 => {
            let node = &mut certificate.diagram.nodes[random.below(nodes) as usize];
            let edge = if random.chance(50) {
                &mut node.high
            } else {
                &mut node.low
            };
            *edge = match random.below(3) {
                // The edge for 1 may be negated here: readers of a diagram must handle it.
                0 => edge.negated(),
                1 => Edge::TRUE,
                _ => Edge::FALSE,
            };
        }
        2 if !layers.is_empty() => {
            let assumptions = specification.assumptions.justice.len().max(1) as u64;
            layers[layer].assumption = random.below(assumptions) as usize;
        }
        3 if !layers.is_empty() => {
            layers.remove(layer);
            for of in modes.iter_mut().filter_map(layer_of) {
                *of -= usize::from(*of > layer);
            }
        }
        4 if !layers.is_empty() => {
            layers.insert(layer, layers[layer]);
            for of in modes.iter_mut().filter_map(layer_of) {
                *of += usize::from(*of > layer);
            }
        }
        5 if !layers.is_empty() => {
            let mode = random.below(modes.len() as u64) as usize;
            modes[mode].aim = match random.below(10) {
                0 => Aim::Goal,
                1..=3 => Aim::Nearer,
                _ => Aim::Layer(layer),
            };
        }
        6 if !layers.is_empty() => layers[layer].reached = certificate.region,
        _ => {
            let count = modes.len() as u64;
            modes.swap(random.below(count) as usize, random.below(count) as usize);
            if let Some(last) = modes.last_mut() {
                last.when = Edge::TRUE;
            }
        }
    }
}

/// The layer that a mode refers to.
fn layer_of(mode: &mut Mode) -> Option<&mut usize> {
    match &mut mode.aim {
        Aim::Layer(layer) => Some(layer),
        Aim::Goal | Aim::Nearer => None,
    }
}

#[test]
fn wrong_controllers_do_not_pass_with_another_certificate_either() {
    let (mut refused, mut passed, mut changed, mut moore) = (0, 0, 0, 0);
    for seed in 0..500 {
        let mut random = Random::new(seed);
        let specification = random::specification(&mut random);
        let Some(right) = functions(&specification, KERNELS[seed as usize % 2]) else {
            continue;
        };
        for round in 0..6 {
            let mut mutant = right.clone();
            if round % 2 == 0
                && let Some(other) = mutate(&mut random, &right)
            {
                mutant = other;
            }
            for _ in 0..=random.below(3) {
                mutate_certificate(&mut random, &specification, &mut mutant);
            }
            if certified(&specification, &mutant).is_err() {
                refused += 1;
                continue;
            }
            passed += 1;
            changed += i32::from(mutant.controls.goals != right.controls.goals);
            moore += i32::from(right.timing == linewright::gr1::Timing::Moore);
            assert_eq!(
                verified(&specification, &mutant),
                Ok(()),
                "seed {seed}, round {round}"
            );
        }
    }
    println!("{passed} passed ({changed} with other modes, {moore} Moore), {refused} refused");
    assert!(passed > 200 && changed > 50 && moore > 50 && refused > 400);
}

/// Where the twin of every bit equals the bit: as a "set of states" it would make every state one
/// that is never left.
#[test]
fn sets_of_states_do_not_speak_of_next_values() {
    let mut tried = 0;
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let specification = random::specification(&mut random);
        let Some(mut functions) = functions(&specification, KERNELS[seed as usize % 2]) else {
            continue;
        };
        let controls = &mut functions.controls;
        let nodes = &mut controls.certificate.diagram.nodes;
        let mut same = Edge::TRUE;
        for pair in controls.order.pairs().iter().rev() {
            let now = Bit(2 * pair);
            let mut node = |bit, high, low| {
                nodes.push(DiagramNode { bit, high, low });
                Edge::to(nodes.len() - 1)
            };
            let one = node(now.primed(), same, Edge::FALSE);
            let zero = node(now.primed(), Edge::FALSE, same);
            same = node(now, one, zero);
        }
        controls.certificate.region = same;
        for layer in controls.certificate.goals.iter_mut().flatten() {
            layer.reached = Edge::FALSE;
        }
        let verdict = certified(&specification, &functions);
        assert_eq!(
            verdict,
            Err("a set of states refers to next values".to_owned()),
            "seed {seed}"
        );
        tried += 1;
    }
    assert!(tried > 30);
}

#[test]
fn functions_of_a_benchmark_pass_and_corrupted_ones_do_not() {
    let Some(specification) = benchmark("genbuf5.slugsin") else {
        return;
    };
    let right = functions(&specification, KernelChoice::Shared).expect("realizable");
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
