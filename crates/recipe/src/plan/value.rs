//! The value of a plan in the worst case, and how long it takes.

use super::{Entry, Next, Objective, Plan, Schedule};
use crate::model::{Action, Layout};

/// Returns the value of the plan's objective until all products are finished or a loop is closed.
/// Positions that follow each other without closing a loop do not form circles.
pub(super) fn worst_case(layout: &Layout, plan: &Plan) -> i64 {
    let cost = |entry: &Entry| cost(layout, plan.objective, entry);
    let totals = totals(plan, plan.objective.is_time(), &cost);
    totals.first().copied().flatten().unwrap_or(0)
}

/// Returns how long it takes from each position that can follow the first, until all products are
/// finished or a loop is closed, whatever the objective.
pub(super) fn times(plan: &Plan) -> Vec<Option<i64>> {
    totals(plan, true, &|_| 0)
}

/// Sums costs of entries, and times if they count, from each position on.
fn totals(plan: &Plan, is_time: bool, cost: &dyn Fn(&Entry) -> i64) -> Vec<Option<i64>> {
    let mut known = vec![None; plan.positions.len()];
    // Each position comes after those that follow it.
    let mut open = if known.is_empty() { vec![] } else { vec![0] };
    while let Some(at) = open.last().copied() {
        let mut missing = Vec::new();
        let schedule = &plan.positions[at].schedule;
        let value = of_schedule(schedule, is_time, cost, &known, &mut missing);
        if missing.is_empty() {
            known[at] = Some(value);
            open.pop();
        }
        open.extend(missing);
    }
    known
}

fn of_schedule(
    schedule: &Schedule,
    is_time: bool,
    cost: &dyn Fn(&Entry) -> i64,
    known: &[Option<i64>],
    missing: &mut Vec<usize>,
) -> i64 {
    let own: i64 = schedule.entries.iter().map(cost).sum();
    let rest = match &schedule.then {
        Next::End { time } => i64::from(is_time) * time,
        Next::Goto {
            time,
            position,
            closes_loop,
        } => {
            let after = match known[*position] {
                _ if *closes_loop => 0,
                Some(value) => value,
                None => {
                    missing.push(*position);
                    0
                }
            };
            i64::from(is_time) * time + after
        }
        Next::Test { outcomes, .. } => {
            let each = outcomes.iter();
            let values = each.map(|o| of_schedule(&o.1, is_time, cost, known, missing));
            values.max().unwrap_or(0)
        }
    };
    own + rest
}

/// Returns the cost of an entry, if the objective is not a time.
fn cost(layout: &Layout, objective: Objective, entry: &Entry) -> i64 {
    let transition = &layout.resources[entry.resource].transitions[entry.transition];
    match objective {
        Objective::Steps | Objective::Time => 0,
        Objective::Transfers => i64::from(matches!(transition.action, Action::Out(_))),
        Objective::Energy => transition.microjoules(),
    }
}
