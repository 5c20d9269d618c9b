//! Proofs of verdicts, checked by what stands in `docs/proof.md` and nothing else: valuations are counted through, formulas are
//! evaluated directly, diagrams are walked from their roots.

#[path = "oracle/game.rs"]
#[allow(dead_code, reason = "only its evaluator is used")]
mod game;
#[path = "oracle/random.rs"]
#[allow(dead_code, reason = "only its specifications are used")]
mod random;

use linewright::cli::{files, proof};
use linewright::game::{KernelChoice, Limits, Options, Outcome, solve_with};
use linewright::gr1::{Formula, Owner, Specification, Timing};
use random::Random;
use serde_json::{Value, json};

/// A proof, read as the page describes it.
struct Proof {
    bits: Vec<Vec<usize>>,
    lows: Vec<i64>,
    nodes: Vec<[usize; 3]>,
    region: usize,
    /// Per goal: assumption, wait, reached.
    goals: Vec<Vec<[usize; 3]>>,
}

fn number(value: &Value) -> Result<usize, String> {
    let number = value.as_u64().ok_or("a number is missing")?;
    usize::try_from(number).map_err(|e| e.to_string())
}

fn list(value: &Value) -> Result<&Vec<Value>, String> {
    value
        .as_array()
        .ok_or_else(|| "a list is missing".to_owned())
}

fn numbers<const N: usize>(values: [&Value; N]) -> Result<[usize; N], String> {
    let mut result = [0; N];
    for (to, from) in result.iter_mut().zip(values) {
        *to = number(from)?;
    }
    Ok(result)
}

impl Proof {
    fn read(document: &Value) -> Result<Self, String> {
        let variables = list(&document["variables"])?;
        let bits = |v: &Value| list(&v["bits"])?.iter().map(number).collect();
        let node = |n: &Value| numbers([&n[0], &n[1], &n[2]]);
        let layer = |l: &Value| numbers([&l["assumption"], &l["wait"], &l["reached"]]);
        let proof = Self {
            bits: variables.iter().map(bits).collect::<Result<_, String>>()?,
            lows: variables
                .iter()
                .map(|v| v["low"].as_i64().unwrap_or(0))
                .collect(),
            nodes: list(&document["nodes"])?
                .iter()
                .map(node)
                .collect::<Result<_, _>>()?,
            region: number(&document["region"])?,
            goals: list(&document["goals"])?
                .iter()
                .map(|g| list(&g["layers"])?.iter().map(layer).collect())
                .collect::<Result<_, String>>()?,
        };
        let forward = proof.nodes.iter().enumerate();
        if forward
            .into_iter()
            .any(|(i, [_, high, low])| high.max(low) / 2 > i)
        {
            return Err("a node leads to a later one".to_owned());
        }
        let roots = proof
            .goals
            .iter()
            .flatten()
            .flat_map(|[_, wait, reached]| [wait, reached]);
        if roots
            .chain([&proof.region])
            .any(|r| r / 2 > proof.nodes.len())
        {
            return Err("a root is missing".to_owned());
        }
        Ok(proof)
    }

    /// Whether a function holds of a state. An edge is 0 (false), 1 (true), or twice a node's number, which counts from 1; one
    /// more for its negation.
    fn holds(&self, mut edge: usize, state: &[i64]) -> bool {
        let mut negated = false;
        loop {
            negated ^= edge % 2 == 1;
            if edge < 2 {
                return negated;
            }
            let [bit, high, low] = self.nodes[edge / 2 - 1];
            edge = if self.bit(bit, state) { high } else { low };
        }
    }

    fn bit(&self, bit: usize, state: &[i64]) -> bool {
        for (v, bits) in self.bits.iter().enumerate() {
            if let Some(place) = bits.iter().position(|b| *b == bit) {
                let code = state[v] - self.lows[v];
                return code >> (bits.len() - 1 - place) & 1 == 1;
            }
        }
        panic!("no variable has bit {bit}");
    }
}

/// All valuations of one side's variables; the others are 0.
fn valuations(specification: &Specification, owner: Owner) -> Vec<Vec<i64>> {
    let mut all = vec![vec![0; specification.variables.len()]];
    for (v, variable) in specification.variables.iter().enumerate() {
        if variable.owner == owner {
            let values = variable.domain.low()..=variable.domain.high();
            let extend = |state: &Vec<i64>| {
                let with = |x| {
                    let mut state = state.clone();
                    state[v] = x;
                    state
                };
                values.clone().map(with).collect::<Vec<_>>()
            };
            all = all.iter().flat_map(extend).collect();
        }
    }
    all
}

fn joined(specification: &Specification, inputs: &[i64], outputs: &[i64]) -> Vec<i64> {
    let variables = specification.variables.iter().enumerate();
    let value = variables.map(|(i, v)| match v.owner {
        Owner::Environment => inputs[i],
        Owner::System => outputs[i],
    });
    value.collect()
}

/// How much is checked.
#[derive(Clone, Copy)]
enum Extent {
    /// Every state and every input.
    All,
    /// So many random states, and so many random inputs of each.
    Some { seed: u64, states: u64, inputs: u64 },
}

/// Checks a proof by the obligations of the page.
fn accepts(specification: &Specification, document: &Value, extent: Extent) -> Result<(), String> {
    let proof = Proof::read(document)?;
    let (assume, guarantee) = (&specification.assumptions, &specification.guarantees);
    let all = |formulas: &[Formula], now: &[i64], next: &[i64]| {
        formulas
            .iter()
            .all(|f| game::value(&f.expr, now, next) != 0)
    };
    let justice = |formulas: &[Formula], i: usize, now: &[i64], next: &[i64]| {
        formulas
            .get(i)
            .is_none_or(|f| game::value(&f.expr, now, next) != 0)
    };
    let inputs = valuations(specification, Owner::Environment);
    let outputs = valuations(specification, Owner::System);
    let legal = |state: &[i64]| {
        all(&assume.invariants, state, &[]) && all(&guarantee.invariants, state, &[])
    };
    let region = |state: &[i64]| proof.holds(proof.region, state);

    // 1. Every first choice of the plant has an answer within the region.
    let first: Vec<&Vec<i64>> = inputs
        .iter()
        .filter(|x| all(&assume.initial, x, &[]) && all(&assume.invariants, x, &[]))
        .collect();
    let starts = |x: &[i64], y: &[i64]| {
        let state = joined(specification, x, y);
        legal(&state) && all(&guarantee.initial, &state, &[]) && region(&state)
    };
    let begins = match specification.timing {
        Timing::Mealy => first.iter().all(|x| outputs.iter().any(|y| starts(x, y))),
        // Without any first choice of the plant an answer must exist all the same.
        Timing::Moore => outputs.iter().any(|y| first.iter().all(|x| starts(x, y))),
    };
    if !begins {
        return Err("1: a first choice has no answer".to_owned());
    }
    let goals = guarantee.justice.len().max(1);
    if proof.goals.len() != goals {
        return Err("a goal has no layers".to_owned());
    }

    let (states, tried): (Vec<Vec<i64>>, u64) = match extent {
        Extent::All => {
            let states = inputs
                .iter()
                .flat_map(|x| outputs.iter().map(|y| joined(specification, x, y)));
            (states.collect(), u64::MAX)
        }
        Extent::Some {
            seed,
            states,
            inputs: tried,
        } => {
            let mut r = Random::new(seed);
            let mut pick = |of: &[Vec<i64>]| of[r.below(of.len() as u64) as usize].clone();
            let states =
                (0..states).map(|_| joined(specification, &pick(&inputs), &pick(&outputs)));
            (states.collect(), tried)
        }
    };
    let mut r = Random::new(1);
    for state in &states {
        // 2. The region is legal.
        if !region(state) {
            continue;
        }
        if !legal(state) {
            return Err("2: an illegal state in the region".to_owned());
        }
        for (j, layers) in proof.goals.iter().enumerate() {
            let mut before = None;
            let mut found = false;
            for [assumption, wait, reached] in layers {
                let below = |s: &[i64]| before.is_some_and(|b: usize| proof.holds(b, s));
                // 3. A layer is what was there before and those that wait in it.
                let (waits, nearer) = (proof.holds(*wait, state), below(state));
                if proof.holds(*reached, state) && !(waits || nearer) {
                    return Err("3: a state that was reached from nowhere".to_owned());
                }
                found |= proof.holds(*reached, state);
                if waits && !nearer {
                    // 4. From a layer the machine can go on: to the goal, nearer to it, or waiting.
                    let good = |x: &[i64], y: &[i64]| {
                        let next = joined(specification, x, y);
                        legal(&next)
                            && all(&guarantee.safety, state, &next)
                            && (justice(&guarantee.justice, j, state, &next) && region(&next)
                                || below(&next)
                                || !justice(&assume.justice, *assumption, state, &next)
                                    && !assume.justice.is_empty()
                                    && proof.holds(*wait, &next))
                    };
                    let possible = |x: &&Vec<i64>| {
                        // Assumptions on transitions speak of next inputs; the next outputs do not matter to them.
                        all(&assume.invariants, x, &[]) && all(&assume.safety, state, x)
                    };
                    let all_moves: Vec<&Vec<i64>> = inputs.iter().filter(possible).collect();
                    let moves: Vec<&Vec<i64>> = if (all_moves.len() as u64) <= tried {
                        all_moves
                    } else {
                        let n = all_moves.len() as u64;
                        (0..tried).map(|_| all_moves[r.below(n) as usize]).collect()
                    };
                    let answered = match specification.timing {
                        Timing::Mealy => moves.iter().all(|x| outputs.iter().any(|y| good(x, y))),
                        Timing::Moore => outputs.iter().any(|y| moves.iter().all(|x| good(x, y))),
                    };
                    if !answered {
                        return Err(format!("4: no answer on the way to goal {j} in {state:?}"));
                    }
                }
                before = Some(*reached);
            }
            // 5. From all of the region every goal is reached.
            if !found {
                return Err(format!("5: no layer of goal {j} holds {state:?}"));
            }
        }
    }
    // 6. What is waited for stays within the region.
    for state in states.iter().filter(|s| !region(s)) {
        let functions = proof.goals.iter().flatten().flat_map(|[_, w, r]| [w, r]);
        for function in functions {
            if proof.holds(*function, state) {
                return Err("6: a layer leaves the region".to_owned());
            }
        }
    }
    Ok(())
}

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
        let kernel = [KernelChoice::Biodivine, KernelChoice::OxiDd][(seed % 2) as usize];
        let Some(proof) = document(&spec, kernel) else {
            continue;
        };
        proofs += 1;
        assert_eq!(
            accepts(&spec, &proof, Extent::All),
            Ok(()),
            "seed {seed}\n{spec:#?}\n{proof:#}"
        );

        // What no proof can survive.
        let mut nowhere = proof.clone();
        nowhere["region"] = json!(0);
        for goal in nowhere["goals"].as_array_mut().expect("goals") {
            goal["layers"] = json!([]);
        }
        // Only where the plant has no first choice is there nothing to answer.
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
        // What may: most damage is seen, none of it makes the checker fall over.
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

/// A contract with a single answer: the region is known by hand, and so is each way of spoiling it.
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
        let error = accepts(spec, &other, Extent::All).expect_err("it is broken");
        error.chars().next().unwrap_or_default()
    };
    let layers = proof["goals"][0]["layers"]
        .as_array()
        .expect("layers")
        .len();
    assert_eq!(layers, 3);
    assert_eq!(broken(&|p| p["region"] = json!(0)), '1');
    assert_eq!(broken(&|p| p["region"] = json!(1)), '2');
    assert_eq!(
        broken(&|p| p["goals"][0]["layers"][0]["reached"] = json!(1)),
        '3'
    );
    assert_eq!(
        broken(&|p| drop(
            p["goals"][0]["layers"]
                .as_array_mut()
                .expect("layers")
                .remove(1)
        )),
        '4'
    );
    assert_eq!(
        broken(&|p| drop(
            p["goals"][0]["layers"]
                .as_array_mut()
                .expect("layers")
                .pop()
        )),
        '5'
    );
}
