//! Proofs of verdicts are accepted by an independent checker (`proof/checker.rs`), and damaged ones
//! are rejected.

use crate::checker::{Clause, Extent, accepts, valuations};
use crate::random::Random;
use crate::{game, random};
use linewright::cli::proof;
use linewright::engine::files;
use linewright::game::{KernelChoice, Limits, Options, Outcome, solve_with};
use linewright::gr1::{Owner, Specification};
use serde_json::{Value, json};

/// Whether the plant has a first choice.
fn can_start(specification: &Specification) -> bool {
    let assume = &specification.assumptions;
    let inputs = valuations(specification, Owner::Environment);
    let good = |x: &Vec<i64>| {
        assume
            .initial
            .iter()
            .chain(&assume.invariants)
            .all(|f| game::value(&f.expr, x, &[]) != 0)
    };
    inputs.iter().any(good)
}

fn document(specification: &Specification, kernel: KernelChoice) -> Option<Value> {
    let options = Options {
        kernel,
        ..Options::default()
    };
    let Outcome::Realizable(won) = solve_with(specification, &options).outcome else {
        return None;
    };
    let ranking = won
        .ranking(specification, &Limits::default())
        .expect("no limit");
    let text = proof::to_text(specification, &ranking);
    Some(serde_json::from_str(&text).expect("a document"))
}

#[test]
fn proofs_of_random_specifications_are_accepted_and_damaged_ones_are_not() {
    let (mut proofs, mut refused, mut damaged) = (0, 0, 0);
    for seed in 0..400 {
        let spec = random::specification(&mut Random::new(seed));
        let kernel = [KernelChoice::Biodivine, KernelChoice::Shared][(seed % 2) as usize];
        let Some(proof) = document(&spec, kernel) else {
            continue;
        };
        proofs += 1;
        assert_eq!(
            accepts(&spec, &proof, Extent::All),
            Ok(()),
            "seed {seed}\n{spec:#?}\n{proof:#}"
        );

        // Damage that no proof survives.
        let mut nowhere = proof.clone();
        nowhere["region"] = json!(0);
        for goal in nowhere["goals"].as_array_mut().expect("goals") {
            goal["layers"] = json!([]);
        }
        // Only if the plant has no first choice is there nothing to answer.
        let nothing = !can_start(&spec);
        assert_eq!(
            accepts(&spec, &nowhere, Extent::All).is_ok(),
            nothing,
            "seed {seed}"
        );
        let mut without_layers = proof.clone();
        without_layers["goals"][0]["layers"] = json!([]);
        if proof["region"] != json!(0) {
            assert!(
                accepts(&spec, &without_layers, Extent::All).is_err(),
                "seed {seed}"
            );
        }
        // Damage that may be harmless: most is detected, and none makes the checker panic.
        let mut r = Random::new(seed);
        for _ in 0..10 {
            let mut other = proof.clone();
            let nodes = other["nodes"].as_array().map_or(0, Vec::len) as u64;
            if nodes > 0 && r.chance(50) {
                let node = &mut other["nodes"][r.below(nodes) as usize];
                let child = 1 + r.below(2) as usize;
                node[child] = json!(node[child].as_u64().unwrap_or(0) ^ 1);
            } else {
                let layers = other["goals"][0]["layers"].as_array_mut().expect("layers");
                let n = layers.len() as u64;
                if n == 0 {
                    continue;
                }
                let layer = r.below(n) as usize;
                match r.below(3) {
                    0 => drop(layers.remove(layer)),
                    1 => layers[layer]["wait"] = json!(1),
                    _ => layers[layer]["reached"] = json!(1),
                }
            }
            damaged += 1;
            refused += u32::from(accepts(&spec, &other, Extent::All).is_err());
        }
    }
    assert!(proofs >= 50, "{proofs}");
    assert!(refused * 2 > damaged, "{refused} of {damaged}");
}

#[test]
fn contracts_of_the_library() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/contracts/handling");
    let loaded = files::load(&[path.to_owned()], &files::StandardLibrary::new(None));
    let mut checked = 0;
    for contract in &loaded.library.contracts {
        let spec = &contract.specification;
        let proof = document(spec, KernelChoice::Automatic).expect("realizable");
        let extent = Extent::Some {
            seed: 7,
            states: 60,
            inputs: 12,
        };
        assert_eq!(accepts(spec, &proof, extent), Ok(()), "{}", contract.name);
        checked += 1;
    }
    assert!(checked >= 5, "{checked}");
}

/// A contract with a single answer: the region is known, and so is each way of damaging it.
#[test]
fn every_obligation_can_be_broken() {
    let text = "contract Lift {\n input up: bool\n output height: 0..3\n guarantee low: height = 0\n \
                guarantee step: always (next height = min(height + 1, 3) or next height = 0)\n \
                guarantee safe: always (height < 3)\n guarantee high: always eventually (height = 2)\n}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lift.lw");
    std::fs::write(&path, text).expect("a file");
    let loaded = files::load(
        &[path.display().to_string()],
        &files::StandardLibrary::new(None),
    );
    let spec = &loaded.library.contracts[0].specification;
    let proof = document(spec, KernelChoice::Automatic).expect("realizable");
    assert_eq!(accepts(spec, &proof, Extent::All), Ok(()));
    let broken = |change: &dyn Fn(&mut Value)| {
        let mut other = proof.clone();
        change(&mut other);
        accepts(spec, &other, Extent::All).expect_err("it is broken")
    };
    let layers = proof["goals"][0]["layers"]
        .as_array()
        .expect("layers")
        .len();
    assert_eq!(layers, 3);
    assert_eq!(broken(&|p| p["region"] = json!(0)), Clause::Start);
    assert_eq!(broken(&|p| p["region"] = json!(1)), Clause::Region);
    assert_eq!(
        broken(&|p| p["goals"][0]["layers"][0]["reached"] = json!(1)),
        Clause::Layer
    );
    assert_eq!(
        broken(&|p| drop(
            p["goals"][0]["layers"]
                .as_array_mut()
                .expect("layers")
                .remove(1)
        )),
        Clause::Answer
    );
    assert_eq!(
        broken(&|p| drop(
            p["goals"][0]["layers"]
                .as_array_mut()
                .expect("layers")
                .pop()
        )),
        Clause::Reached
    );
}
