//! Whether the play of a violation shows what is said of it.

use super::definition::{broken, holds, matching, part, valuations, with};
use linewright::gr1::{Formula, Owner, Specification, Timing};
use linewright::mealy::{Machine, Transition};

/// The clause, or that its play does not show it.
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
                "Gap" => of.is_empty() && lowest.all(|l| l),
                "Overlap" => of.len() > 1 && lowest.all(|l| l),
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
                // The values of what was not decided yet are not told.
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
    let right = if clause == "Won" {
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
