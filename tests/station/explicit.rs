//! Controllers for fixtures, by trying every valuation: no part of the solver is used.
//!
//! For each state (the values of the previous step) and each input, the first output in ascending
//! order that keeps the guarantees is taken. So a contract whose guarantees leave no choice gets
//! its only machine; there is no lookahead.

use linewright::gr1::{Domain, Formula, Side, Specification, Time, Timing, eval};
use linewright::mealy::{Cube, Guard, Machine, Port, Test, Transition};
use std::collections::BTreeMap;

/// The machine of a contract whose guarantees can be kept step by step.
pub fn controller(specification: &Specification) -> Machine {
    let ports = |ids: Vec<linewright::gr1::VarId>| -> Vec<Port> {
        ids.into_iter()
            .map(|id| {
                let v = specification.variable(id);
                Port {
                    name: v.name.clone(),
                    domain: v.domain.clone(),
                    internal: v.internal,
                    unit: v.unit.clone(),
                }
            })
            .collect()
    };
    let inputs = ports(specification.inputs().collect());
    let outputs = ports(specification.outputs().collect());
    // Only values to which safety formulas refer are part of a state.
    let mut remembered = vec![false; specification.variables.len()];
    for side in [&specification.assumptions, &specification.guarantees] {
        for formula in &side.safety {
            formula
                .expr
                .for_each_var(&mut |v, t| remembered[v.index()] |= t == Time::Now);
        }
    }
    let mut numbers: BTreeMap<Vec<i64>, usize> = BTreeMap::new();
    let mut queue: Vec<Vec<i64>> = Vec::new();
    let mut number = |mut values: Vec<i64>, queue: &mut Vec<Vec<i64>>| {
        for (value, remembered) in values.iter_mut().zip(&remembered) {
            *value *= i64::from(*remembered);
        }
        *numbers.entry(values.clone()).or_insert_with(|| {
            queue.push(values);
            queue.len() - 1
        })
    };
    let initial = transitions(specification, None, &inputs, &outputs, &mut |v| {
        number(v, &mut queue)
    });
    let mut states = Vec::new();
    while states.len() < queue.len() {
        let state = queue[states.len()].clone();
        let next = transitions(specification, Some(&state), &inputs, &outputs, &mut |v| {
            number(v, &mut queue)
        });
        states.push(next);
        assert!(queue.len() < 100_000, "a fixture is small");
    }
    Machine {
        name: specification.name.clone(),
        timing: specification.timing,
        inputs,
        outputs,
        initial,
        states,
        goals: Vec::new(),
    }
}

fn transitions(
    specification: &Specification,
    previous: Option<&[i64]>,
    inputs: &[Port],
    outputs: &[Port],
    number: &mut dyn FnMut(Vec<i64>) -> usize,
) -> Vec<Transition> {
    let all_inputs = valuations(inputs);
    let all_outputs = valuations(outputs);
    let whole = |input: &[i64], output: &[i64]| {
        let mut values = vec![0; specification.variables.len()];
        for (id, v) in specification.inputs().zip(input) {
            values[id.index()] = *v;
        }
        for (id, v) in specification.outputs().zip(output) {
            values[id.index()] = *v;
        }
        values
    };
    let kept = |side: &Side, values: &[i64]| keeps(side, previous, values);
    let fits =
        |input: &[i64], output: &[i64]| kept(&specification.guarantees, &whole(input, output));
    let nothing = vec![0; outputs.len()];
    let allowed: Vec<&Vec<i64>> = all_inputs
        .iter()
        .filter(|i| {
            // A Moore machine's assumptions may not mention its outputs of the same step, either.
            kept(&specification.assumptions, &whole(i, &nothing))
        })
        .collect();
    let moore = (specification.timing == Timing::Moore).then(|| {
        all_outputs
            .iter()
            .find(|o| allowed.iter().all(|i| fits(i, o)))
    });
    // Cubes by their result.
    let mut groups: BTreeMap<(Vec<i64>, usize), Vec<Cube>> = BTreeMap::new();
    for input in allowed {
        let output = match moore {
            Some(output) => output,
            None => all_outputs.iter().find(|o| fits(input, o)),
        };
        let output = output.unwrap_or_else(|| panic!("{} cannot be kept", specification.name));
        let to = number(whole(input, output));
        let tests = input.iter().enumerate();
        let cube = Cube(
            tests
                .map(|(i, v)| Test {
                    input: i,
                    low: *v,
                    high: *v,
                })
                .collect(),
        );
        groups.entry((output.clone(), to)).or_default().push(cube);
    }
    let domains: Vec<Domain> = inputs.iter().map(|p| p.domain.clone()).collect();
    groups
        .into_iter()
        .map(|((output, to), cubes)| Transition {
            guard: Guard(merge(cubes, &domains)),
            output,
            to,
        })
        .collect()
}

/// Whether one side's formulas hold in this step.
fn keeps(side: &Side, previous: Option<&[i64]>, values: &[i64]) -> bool {
    let now = |f: &Formula| eval::holds(&f.expr, values, &[]);
    let first = match previous {
        None => side.initial.iter().all(now),
        Some(previous) => side
            .safety
            .iter()
            .all(|f| eval::holds(&f.expr, previous, values)),
    };
    first && side.invariants.iter().all(now)
}

fn valuations(ports: &[Port]) -> Vec<Vec<i64>> {
    let mut all = vec![vec![]];
    for port in ports {
        all = all
            .into_iter()
            .flat_map(|v| {
                (port.domain.low()..=port.domain.high()).map(move |x| [v.clone(), vec![x]].concat())
            })
            .collect();
    }
    all
}

/// Joins cubes that differ in one adjacent interval, and drops tests that always hold.
fn merge(mut cubes: Vec<Cube>, domains: &[Domain]) -> Vec<Cube> {
    for input in 0..domains.len() {
        let mut joined: Vec<Cube> = Vec::new();
        cubes.sort();
        'next: for cube in cubes {
            for other in &mut joined {
                let same = other
                    .0
                    .iter()
                    .zip(&cube.0)
                    .all(|(a, b)| a.input == input || a == b);
                if same && other.0[input].high + 1 == cube.0[input].low {
                    other.0[input].high = cube.0[input].high;
                    continue 'next;
                }
            }
            joined.push(cube);
        }
        cubes = joined;
    }
    for cube in &mut cubes {
        cube.0.retain(|t| {
            let domain = &domains[t.input];
            (t.low, t.high) != (domain.low(), domain.high())
        });
    }
    cubes
}
