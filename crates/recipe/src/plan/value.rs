//! The value of a plan in the worst case.

use super::{Entry, Next, Objective, Plan, Schedule};
use crate::model::{Action, Layout};

/// Returns the value of the plan's objective until all products are finished or a loop is closed.
/// Positions that follow each other without closing a loop do not form circles.
pub(super) fn worst_case(layout: &Layout, plan: &Plan) -> i64 {
    let mut known = vec![None; plan.positions.len()];
    // Each position comes after those that follow it.
    let mut open = vec![0];
    while let Some(at) = open.last().copied() {
        let mut missing = Vec::new();
        let value = of_schedule(
            layout,
            plan,
            &plan.positions[at].schedule,
            &known,
            &mut missing,
        );
        if missing.is_empty() {
            known[at] = Some(value);
            open.pop();
        }
        open.extend(missing);
    }
    known[0].unwrap_or(0)
}

fn of_schedule(
    layout: &Layout,
    plan: &Plan,
    schedule: &Schedule,
    known: &[Option<i64>],
    missing: &mut Vec<usize>,
) -> i64 {
    let is_time = plan.objective.is_time();
    let own: i64 = schedule
        .entries
        .iter()
        .map(|e| cost(layout, plan.objective, e))
        .sum();
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
            let values = each.map(|o| of_schedule(layout, plan, &o.1, known, missing));
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
