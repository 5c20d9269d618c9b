//! The naive machine checker: the machine against all legal inputs, state by state and valuation by
//! valuation.

use crate::game::{Board, Rules, Subset};
use linewright::gr1::{Owner, Timing};
use linewright::mealy::verify::Violation;
use linewright::mealy::{Machine, Transition};
use std::collections::BTreeMap;

/// A transition of the product: from, to, current and next valuation.
type Arc = (usize, usize, usize, usize);

fn part(board: &Board<'_>, valuation: usize, owner: Owner) -> Vec<i64> {
    let pairs = board.specification.variables.iter();
    pairs
        .zip(&board.valuations[valuation])
        .filter(|(v, _)| v.owner == owner)
        .map(|(_, x)| *x)
        .collect()
}

/// The next valuations: for every legal input, the machine's answer.
fn answers(
    board: &Board<'_>,
    rules: &Rules,
    machine: &Machine,
    at: Option<(usize, usize)>,
) -> Result<Vec<(usize, usize)>, String> {
    let transitions: &[Transition] = match at {
        None => &machine.initial,
        Some((state, _)) => &machine.states[state],
    };
    let (legal, right) = match at {
        None => (rules.env_start, rules.sys_start),
        Some((_, v)) => (rules.env_step[v], rules.sys_step[v]),
    };
    let mut found = BTreeMap::new();
    for v in 0..board.valuations.len() {
        if legal >> v & 1 == 0 {
            continue;
        }
        let inputs = part(board, v, Owner::Environment);
        let matching: Vec<&Transition> = transitions
            .iter()
            .filter(|t| {
                let cubes = t.guard.0.iter();
                cubes.map(|c| c.holds(&inputs)).filter(|b| *b).count() > 0
            })
            .collect();
        let [transition] = matching[..] else {
            return Err(format!("{} transitions for {inputs:?}", matching.len()));
        };
        if part(board, v, Owner::System) == transition.output {
            if right >> v & 1 == 0 {
                return Err(format!("breaks safety with {:?}", board.valuations[v]));
            }
            found.insert(inputs, (transition.to, v));
        } else {
            found.entry(inputs).or_insert((usize::MAX, v));
        }
    }
    let found: Vec<_> = found.into_values().collect();
    if found.iter().any(|(to, _)| *to >= machine.states.len()) {
        return Err("an output outside its domain".to_owned());
    }
    Ok(found)
}

/// Whether the machine keeps its specification.
pub fn accepts(board: &Board<'_>, machine: &Machine) -> Result<(), String> {
    if board.specification.timing == Timing::Moore {
        for list in machine.states.iter().chain([&machine.initial]) {
            if list.iter().any(|t| t.output != list[0].output) {
                return Err("not a Moore machine".to_owned());
            }
        }
    }
    let rules = board.rules(&Subset::All);
    let mut nodes: Vec<(usize, usize)> = Vec::new();
    let mut arcs: Vec<Arc> = Vec::new();
    let number = |nodes: &mut Vec<(usize, usize)>, node: (usize, usize)| {
        nodes.iter().position(|n| *n == node).unwrap_or_else(|| {
            nodes.push(node);
            nodes.len() - 1
        })
    };
    for node in answers(board, &rules, machine, None)? {
        number(&mut nodes, node);
    }
    let mut i = 0;
    while i < nodes.len() {
        let node = nodes[i];
        for next in answers(board, &rules, machine, Some(node))? {
            let to = number(&mut nodes, next);
            arcs.push((i, to, node.1, next.1));
        }
        i += 1;
    }
    for goal in &rules.goals {
        let bad: Vec<Arc> = arcs
            .iter()
            .copied()
            .filter(|(_, _, now, next)| goal[*now] >> next & 1 == 0)
            .collect();
        let reach = closure(nodes.len(), &bad);
        let fair_from = |n: usize| {
            rules.assumptions.iter().all(|a| {
                bad.iter().any(|(from, to, now, next)| {
                    a[*now] >> next & 1 == 1
                        && (reach[n][*from] || *from == n)
                        && (reach[*to][n] || *to == n)
                })
            })
        };
        if (0..nodes.len()).any(|n| reach[n][n] && fair_from(n)) {
            return Err("a fair cycle without a goal".to_owned());
        }
    }
    Ok(())
}

/// Reachability between nodes by at least one arc.
fn closure(count: usize, arcs: &[Arc]) -> Vec<Vec<bool>> {
    let mut targets = vec![Vec::new(); count];
    for (from, to, ..) in arcs {
        targets[*from].push(*to);
    }
    let mut reach = vec![vec![false; count]; count];
    for (start, row) in reach.iter_mut().enumerate() {
        let mut stack = targets[start].clone();
        while let Some(node) = stack.pop() {
            if !row[node] {
                row[node] = true;
                stack.extend(&targets[node]);
            }
        }
    }
    reach
}

/// The play of a violation belongs to this machine, and only its last step may violate a rule.
pub fn replay(board: &Board<'_>, machine: &Machine, violation: &Violation) {
    let rules = board.rules(&Subset::All);
    let number = |v: &Vec<i64>| {
        board
            .valuations
            .iter()
            .position(|w| w == v)
            .expect("in its domains")
    };
    let trace: Vec<usize> = violation.trace.iter().map(number).collect();
    let mut at: Option<(usize, usize)> = None;
    let steps = trace.len();
    // A justice violation is repeated once: the cycle must be repeatable.
    let again = violation.repeats_from.map_or(&[][..], |r| &trace[r..]);
    for (i, v) in trace.iter().chain(again).copied().enumerate() {
        let legal = at.map_or(rules.env_start, |(_, now)| rules.env_step[now]);
        let right = at.map_or(rules.sys_start, |(_, now)| rules.sys_step[now]);
        assert!(legal >> v & 1 == 1, "an illegal input in {violation:?}");
        let last = violation.repeats_from.is_none() && i + 1 == steps;
        let inputs = part(board, v, Owner::Environment);
        let taken = machine.step(at.map(|(s, _)| s), &inputs);
        if last {
            let same = taken.is_some_and(|t| t.output == part(board, v, Owner::System));
            assert!(
                !same || right >> v & 1 == 0,
                "nothing is wrong in {violation:?}"
            );
            return;
        }
        let taken = taken.expect("a transition");
        assert_eq!(taken.output, part(board, v, Owner::System), "{violation:?}");
        assert!(
            right >> v & 1 == 1,
            "an earlier rule is broken in {violation:?}"
        );
        at = Some((taken.to, v));
    }
}
