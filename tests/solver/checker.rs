//! A checker of proofs, based only on `docs/proof.md`: valuations are enumerated, formulas are
//! evaluated directly, diagrams are walked from their roots.

use super::game;
use super::random::Random;
use linewright::gr1::{Formula, Owner, Specification, Timing};
use serde_json::Value;

/// A missing part of a proof, by the numbers on the page.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Clause {
    /// The document does not have the form on the page.
    Form(String),
    /// 1: every first choice of the plant has an answer within the region.
    Start,
    /// 2: the region is legal.
    Region,
    /// 3: a layer consists of the previous states and those that wait in it.
    Layer,
    /// 4: from a layer the machine can continue.
    Answer,
    /// 5: from all of the region every goal is reached.
    Reached,
    /// 6: layers lie within the region.
    Within,
}

/// A proof, parsed as the page describes it.
pub struct Proof {
    pub bits: Vec<Vec<usize>>,
    pub lows: Vec<i64>,
    pub nodes: Vec<[usize; 3]>,
    pub region: usize,
    /// Per goal: assumption, wait, reached.
    pub goals: Vec<Vec<[usize; 3]>>,
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

fn numbers([a, b, c]: [&Value; 3]) -> Result<[usize; 3], String> {
    Ok([number(a)?, number(b)?, number(c)?])
}

impl Proof {
    pub fn read(document: &Value) -> Result<Self, String> {
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
        let missing = |root: &usize| root / 2 > proof.nodes.len();
        let layers = || proof.goals.iter().flatten();
        if missing(&proof.region)
            || layers().any(|[_, wait, reached]| missing(wait) || missing(reached))
        {
            return Err("a root is missing".to_owned());
        }
        Ok(proof)
    }

    /// Whether a function holds in a state. An edge is 0 (false), 1 (true), or twice a node's
    /// number, counted from 1; plus one for its negation.
    pub fn holds(&self, mut edge: usize, state: &[i64]) -> bool {
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

/// All valuations of one side's variables; the other variables are 0.
pub fn valuations(specification: &Specification, owner: Owner) -> Vec<Vec<i64>> {
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

pub fn joined(specification: &Specification, inputs: &[i64], outputs: &[i64]) -> Vec<i64> {
    let variables = specification.variables.iter().enumerate();
    let value = variables.map(|(i, v)| match v.owner {
        Owner::Environment => inputs[i],
        Owner::System => outputs[i],
    });
    value.collect()
}

/// Extent of the check.
#[derive(Clone, Copy, Debug)]
pub enum Extent {
    /// Every state and every input.
    All,
    /// This many random states, and random inputs for each.
    Some { seed: u64, states: u64, inputs: u64 },
}

/// Checks the obligations on the page.
pub fn accepts(
    specification: &Specification,
    document: &Value,
    extent: Extent,
) -> Result<(), Clause> {
    let proof = Proof::read(document).map_err(Clause::Form)?;
    let (assume, guarantee) = (&specification.assumptions, &specification.guarantees);
    let goals = guarantee.justice.len().max(1);
    if proof.goals.len() != goals {
        return Err(Clause::Form("a goal has no layers".to_owned()));
    }
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
        // Even without a first choice of the plant an answer must exist.
        Timing::Moore => outputs.iter().any(|y| first.iter().all(|x| starts(x, y))),
    };
    if !begins {
        return Err(Clause::Start);
    }

    let (states, mut sample): (Vec<Vec<i64>>, Option<(u64, Random)>) = match extent {
        Extent::All => {
            let states = inputs
                .iter()
                .flat_map(|x| outputs.iter().map(|y| joined(specification, x, y)));
            (states.collect(), None)
        }
        Extent::Some {
            seed,
            states,
            inputs: tried,
        } => {
            let mut r = Random::new(seed);
            let mut pick = |of: &[Vec<i64>]| of[r.below(of.len() as u64) as usize].clone();
            let states = std::iter::repeat_n((), states as usize)
                .map(|()| joined(specification, &pick(&inputs), &pick(&outputs)))
                .collect();
            (states, Some((tried, r)))
        }
    };
    for state in &states {
        // 2. The region is legal.
        if !region(state) {
            continue;
        }
        if !legal(state) {
            return Err(Clause::Region);
        }
        for (j, layers) in proof.goals.iter().enumerate() {
            let mut before = None;
            let mut found = false;
            for [assumption, wait, reached] in layers {
                let below = |s: &[i64]| before.is_some_and(|b: usize| proof.holds(b, s));
                // 3. 3. A layer consists of the previous states and those that wait in it.
                let (waits, nearer) = (proof.holds(*wait, state), below(state));
                if proof.holds(*reached, state) && !(waits || nearer) {
                    return Err(Clause::Layer);
                }
                found |= proof.holds(*reached, state);
                if waits && !nearer {
                    // 4. 4. From a layer the machine can continue: to the goal, nearer to it, or
                    //    waiting.
                    let good = |x: &[i64], y: &[i64]| {
                        let next = joined(specification, x, y);
                        legal(&next)
                            && all(&guarantee.safety, state, &next)
                            && (justice(&guarantee.justice, j, state, &next) && region(&next)
                                || below(&next)
                                || !justice(&assume.justice, *assumption, state, &next)
                                    && proof.holds(*wait, &next))
                    };
                    let possible = |x: &&Vec<i64>| {
                        // Assumptions on transitions mention next inputs; the next outputs do not
                        // matter to them.
                        all(&assume.invariants, x, &[]) && all(&assume.safety, state, x)
                    };
                    let all_moves: Vec<&Vec<i64>> = inputs.iter().filter(possible).collect();
                    let moves: Vec<&Vec<i64>> = match &mut sample {
                        Some((tried, r)) if !all_moves.is_empty() => {
                            let n = all_moves.len() as u64;
                            std::iter::repeat_n((), *tried as usize)
                                .map(|()| all_moves[r.below(n) as usize])
                                .collect()
                        }
                        _ => all_moves,
                    };
                    let answered = match specification.timing {
                        Timing::Mealy => moves.iter().all(|x| outputs.iter().any(|y| good(x, y))),
                        Timing::Moore => outputs.iter().any(|y| moves.iter().all(|x| good(x, y))),
                    };
                    if !answered {
                        return Err(Clause::Answer);
                    }
                }
                before = Some(*reached);
            }
            // 5. From all of the region every goal is reached.
            if !found {
                return Err(Clause::Reached);
            }
        }
    }
    // 6. 6. Waiting stays within the region.
    for state in states.iter().filter(|s| !region(s)) {
        let functions = proof.goals.iter().flatten().flat_map(|[_, w, r]| [w, r]);
        for function in functions {
            if proof.holds(*function, state) {
                return Err(Clause::Within);
            }
        }
    }
    Ok(())
}
