//! Checks whether the play of a violation shows it.

use super::artefacts::Artefact;
use super::copies::checker;
use super::copies::verify::product::Edge;
use super::copies::verify::residual::{Pool, Tree, key};
use super::copies::verify::{self, fair};
use super::definition::{broken, holds, matching, part, valuations, with};
use crate::game::value;
use linewright::game::Limits;
use linewright::gr1::{BinaryOp, Expr, Formula, Owner, Specification, Time, Timing};
use linewright::mealy::{Machine, Transition};

/// The clause, or a text that its play does not show it.
fn shown(clause: String, why: Result<(), &str>) -> String {
    match why {
        Ok(()) => clause,
        Err(why) => format!("{clause}, but in its play {why}"),
    }
}

fn quoted(clause: &str) -> &str {
    clause.split('"').nth(1).unwrap_or_default()
}

/// A play of a machine.
pub fn machine(
    specification: &Specification,
    machine: &Machine,
    clause: String,
    trace: &[Vec<i64>],
    repeats_from: Option<usize>,
) -> String {
    let why = play_of_machine(specification, machine, &clause, trace, repeats_from);
    shown(clause, why)
}

fn play_of_machine(
    specification: &Specification,
    machine: &Machine,
    clause: &str,
    trace: &[Vec<i64>],
    repeats_from: Option<usize>,
) -> Result<(), &'static str> {
    let (assume, guarantee) = (&specification.assumptions, &specification.guarantees);
    let Some(last) = trace.last() else {
        return Ok(());
    };
    let again = repeats_from.map_or(&[][..], |from| &trace[from.min(trace.len())..]);
    let mut at: Option<(usize, &[i64])> = None;
    let mut round: Vec<(&[i64], &[i64])> = Vec::new();
    for (i, next) in trace.iter().chain(again).enumerate() {
        let now = at.map(|(_, now)| now);
        if !broken(assume, now, next).is_empty() {
            return Err("an assumption is broken");
        }
        let inputs = part(specification, next, Owner::Environment);
        let of = matching(machine.transitions(at.map(|(s, _)| s)), &inputs);
        let answered = |t: &Transition| t.output == part(specification, next, Owner::System);
        if repeats_from.is_none() && i + 1 == trace.len() {
            let wrong = broken(guarantee, now, last);
            let lowest = specification.variables.iter().zip(last);
            let lowest = lowest.filter(|(v, _)| v.owner == Owner::System);
            let mut lowest = lowest.map(|(v, x)| v.domain.low() == *x);
            let right = match clause {
                "MissingTransition" => of.is_empty() && lowest.all(|l| l),
                "AmbiguousTransition" => of.len() > 1 && lowest.all(|l| l),
                _ => {
                    of.len() == 1
                        && answered(of[0])
                        && wrong.iter().any(|f| f.name == quoted(clause))
                }
            };
            return if right {
                Ok(())
            } else {
                Err("the last step is another one")
            };
        }
        let [t] = of[..] else {
            return Err("a step has no transition, or two");
        };
        if !answered(t) || !broken(guarantee, now, next).is_empty() {
            return Err("a step is another one, or breaks something");
        }
        if let Some(now) = now
            && i >= trace.len()
        {
            round.push((now, next));
        }
        at = Some((t.to, next));
    }
    let goal = guarantee
        .justice
        .iter()
        .filter(|f| f.name == quoted(clause));
    let met = |f: &Formula| round.iter().any(|(now, next)| holds(f, now, next));
    if round.is_empty() || goal.into_iter().any(met) {
        return Err("the goal is met");
    }
    if assume.justice.iter().all(met) {
        Ok(())
    } else {
        Err("an assumption is starved")
    }
}

/// A play of a counterstrategy.
pub fn counterstrategy(
    specification: &Specification,
    machine: &Machine,
    clause: String,
    trace: &[Vec<i64>],
    repeats_from: Option<usize>,
) -> String {
    let why = play_of_counterstrategy(specification, machine, &clause, trace, repeats_from);
    shown(clause, why)
}

fn play_of_counterstrategy(
    specification: &Specification,
    machine: &Machine,
    clause: &str,
    trace: &[Vec<i64>],
    repeats_from: Option<usize>,
) -> Result<(), &'static str> {
    let (assume, guarantee) = (&specification.assumptions, &specification.guarantees);
    if trace.is_empty() {
        return Ok(());
    }
    let again = repeats_from.map_or(&[][..], |from| &trace[from.min(trace.len())..]);
    let mut round: Vec<(&[i64], &[i64])> = Vec::new();
    let mut at: Option<(usize, &[i64])> = None;
    for (i, next) in trace.iter().chain(again).enumerate() {
        let now = at.map(|(_, now)| now);
        let transitions = machine.transitions(at.map(|(s, _)| s));
        let answer = part(specification, next, Owner::System);
        let of = matching(transitions, &answer);
        let given = part(specification, next, Owner::Environment);
        let legal = broken(guarantee, now, next).is_empty();
        if repeats_from.is_none() && i + 1 == trace.len() {
            let moore = specification.timing == Timing::Moore;
            let outputs = valuations(specification, Owner::System);
            let right = match clause {
                // Values that were not yet chosen are not shown.
                "Unanswered" if moore => outputs.iter().any(|o| {
                    matching(transitions, &part(specification, o, Owner::System)).is_empty()
                }),
                "AnsweredTwice" if moore => of.len() > 1,
                "Unanswered" => of.is_empty() && legal && transitions[0].output == given,
                "AnsweredTwice" => of.len() > 1 && legal && transitions[0].output == given,
                _ => {
                    let step = with(specification, next, Owner::Environment, &given);
                    let wrong = broken(assume, now, &step);
                    transitions.iter().any(|t| t.output == given)
                        && wrong.iter().any(|f| f.name == quoted(clause))
                }
            };
            return if right {
                Ok(())
            } else {
                Err("the last step is another one")
            };
        }
        let [t] = of[..] else {
            return Err("a step has no transition, or two");
        };
        if t.output != given || !legal || !broken(assume, now, next).is_empty() {
            return Err("a step is another one, or breaks something");
        }
        if let Some(now) = now
            && i >= trace.len()
        {
            round.push((now, next));
        }
        at = Some((t.to, next));
    }
    if round.is_empty() {
        return Err("nothing repeats");
    }
    let met = |f: &Formula| round.iter().any(|(now, next)| holds(f, now, next));
    let right = if clause == "MachineWins" {
        guarantee.justice.iter().all(met)
    } else {
        let mut named = assume.justice.iter().filter(|f| f.name == quoted(clause));
        named.any(|f| !met(f))
    };
    if right {
        Ok(())
    } else {
        Err("the round is another one")
    }
}

/// Searches for a fair cycle; a result must be one.
pub fn cycle(edges: &[Vec<(usize, u32)>], met: usize) -> String {
    let edge = |(to, label): &(usize, u32)| Edge {
        to: *to,
        label: *label,
    };
    let graph: Vec<Vec<Edge>> = edges
        .iter()
        .map(|out| out.iter().map(edge).collect())
        .collect();
    let bad = |label: u32| label & 1 == 1;
    let fair = |label: u32, i: usize| label >> (i + 1) & 1 == 1;
    let found = fair::fair_cycle(&graph, met, &bad, &fair, &Limits::default());
    let Some(cycle) = found.expect("no limit") else {
        return "accepted".to_owned();
    };
    let follows = cycle
        .iter()
        .zip(cycle.iter().skip(1))
        .all(|((_, a), (b, _))| a.to == *b);
    let closed = cycle.last().is_some_and(|(_, edge)| edge.to == cycle[0].0);
    let there = cycle
        .iter()
        .all(|(from, edge)| bad(edge.label) && graph[*from].contains(edge));
    let all = (0..met).all(|i| cycle.iter().any(|(_, edge)| fair(edge.label, i)));
    // With one condition it ends where it is a cycle; with several they are met in turn.
    let short = met > 1
        || (1..cycle.len()).all(|end| {
            let closed = cycle[end - 1].1.to == cycle[0].0;
            let mut wanted = 0..met;
            let met = wanted.all(|i| cycle[..end].iter().any(|(_, edge)| fair(edge.label, i)));
            !closed || !met
        });
    let right = follows && closed && there && all && short;
    shown(
        "a cycle".to_owned(),
        if right {
            Ok(())
        } else {
            Err("something is wrong")
        },
    )
}

/// What a verifier builds for a correct artefact: the steps from each node in order, each step and
/// each label once.
pub fn product(specification: &Specification, of: &Artefact, limits: &Limits) -> String {
    let (edges, labels) = match of {
        Artefact::Machine(machine) => {
            let check = verify::Check::new(specification, machine, limits);
            let mut check = check.expect("no limit");
            assert_eq!(check.explore(), Ok(None));
            (check.product.edges, check.product.labels)
        }
        Artefact::Counterstrategy(machine) => {
            let mut check = verify::counter::Check::new(specification, machine, limits);
            assert_eq!(check.explore(), Ok(None));
            (check.product.edges, check.product.labels)
        }
        _ => panic!("nothing is built of it"),
    };
    let each_once = |labels: &[Vec<bool>]| {
        let mut different = labels.to_vec();
        different.sort_unstable();
        different.dedup();
        different.len() == labels.len()
    };
    if edges.iter().all(|e| e.is_sorted_by(|a, b| a < b)) && each_once(&labels) {
        "accepted".to_owned()
    } else {
        "something appears twice or out of order".to_owned()
    }
}

/// Formulas of a specification over all of its valuations, with variables fixed one after the
/// other.
pub fn formulas(specification: &Specification, formulas: &[Expr], values: &[[i64; 2]]) -> String {
    for owner in [Owner::Environment, Owner::System] {
        if checker::valuations(specification, owner) != valuations(specification, owner) {
            return "valuations are others".to_owned();
        }
    }
    let times = [Time::Now, Time::Next];
    let now: Vec<i64> = values.iter().map(|v| v[0]).collect();
    let next: Vec<i64> = values.iter().map(|v| v[1]).collect();
    let mut pool = Pool::default();
    let mut order = Vec::new();
    for (v, variable) in specification.variables.iter().enumerate() {
        for (time, shift) in times.into_iter().zip(0..) {
            if key(v, time) != 2 * v as u32 + shift {
                return "a key is another one".to_owned();
            }
            order.push((key(v, time), variable.domain.low(), variable.domain.high()));
        }
    }
    let ids: Vec<_> = formulas.iter().map(|f| pool.add(f, &|t| t)).collect();
    let shifted: Vec<_> = formulas
        .iter()
        .map(|f| pool.add(f, &|_| Time::Next))
        .collect();
    for (formula, id) in formulas.iter().zip(&shifted) {
        if pool.eval(*id, &next) != value(formula, &next, &next) {
            return "a value of next values is another one".to_owned();
        }
    }
    for (formula, id) in formulas.iter().zip(&ids) {
        let mut mentioned = Vec::new();
        formula.for_each_var(&mut |v, time| mentioned.push(key(v.index(), time)));
        let keys = pool.keys(*id).to_vec();
        if !keys.is_sorted_by(|a, b| a < b) || keys.iter().any(|k| !mentioned.contains(k)) {
            return "keys are out of order, or are not mentioned".to_owned();
        }
        let known = |k: u32| values[k as usize / 2][k as usize % 2];
        let left = keys
            .iter()
            .fold(*id, |left, k| pool.fix(left, *k, known(*k)));
        if pool.value(left) != Some(value(formula, &now, &next)) {
            return "a value is another one".to_owned();
        }
    }
    // Equal formulas on both sides need no query.
    if let Some(i) = ids.iter().position(|id| pool.value(*id).is_none()) {
        let expr = &formulas[i];
        let same = Expr::binary(BinaryOp::Eq, expr.clone(), expr.clone());
        let both = || Box::new(expr.clone());
        let choice = Expr::If(both(), both(), both());
        let same = pool.add(&same, &|t| t);
        if pool.value(same) != Some(1) || pool.add(&choice, &|t| t) != ids[i] {
            return "nothing is left out".to_owned();
        }
    }
    let mut tree = Tree::new(order.clone());
    tree.conjunction = true;
    let (yes, no) = (pool.constant(1), pool.constant(0));
    let place = tree.place(&pool, ids.clone());
    let again = ids
        .iter()
        .rev()
        .copied()
        .chain([yes])
        .chain(ids.iter().copied());
    if tree.place(&pool, again.collect()) != place {
        return "one conjunction has two places".to_owned();
    }
    // A tree that queries everything ends where all is known.
    let mut at = place;
    while let Some(question) = tree.question(at) {
        let asked = order[question].0 as usize;
        at = tree.answer(&mut pool, at, values[asked / 2][asked % 2]);
    }
    let all = formulas.iter().all(|f| value(f, &now, &next) != 0);
    let end: &[_] = if all { &[] } else { &[no] };
    if tree.formulas(at) != end {
        return "the end of a tree is another one".to_owned();
    }
    "accepted".to_owned()
}
