//! Tables of what is left of each recipe, and of the ways between resources.

use super::{Bounds, NEVER, Table, Uses, performers};
use crate::model::Action;
use crate::plan::shop::Shop;
use crate::realize::cell::{Call, Cell, Work};
use rustc_hash::FxHashMap;

impl Bounds {
    pub(super) fn time_rest(&self, shop: &Shop<'_>, with_loops: bool) -> Table {
        let of = |demand: usize| {
            let cell = &shop.cells[demand];
            let rest = |number: usize, after: i64| {
                let steps = &cell.works[number].steps;
                let from = |begin: usize| {
                    let mut end = vec![0; steps.len() + 1];
                    for at in begin..steps.len() {
                        let mut start = if at > begin { end[at - 1] } else { 0 };
                        let mut longest = 0;
                        for call in &steps[at] {
                            let able = performers(call);
                            for input in &call.inputs {
                                if let Some(last) = last_touch(steps, *input, at)
                                    && last.0 >= begin
                                    && self.single[demand][*input as usize]
                                {
                                    let way = self.between(&self.way, &last.1, &able);
                                    start = start.max(end[last.0] + way);
                                }
                            }
                            let own = call.performers.iter();
                            let least = own.map(|p| {
                                shop.ticks[p.1.resource as usize][p.1.transition as usize]
                            });
                            longest = longest.max(least.min().unwrap_or(NEVER));
                        }
                        end[at] = (start + longest).min(NEVER);
                    }
                    let last = if begin < steps.len() {
                        end[steps.len() - 1]
                    } else {
                        0
                    };
                    (last + after).min(NEVER)
                };
                (0..=steps.len()).map(from).collect()
            };
            backward(cell, with_loops, rest)
        };
        (0..shop.demands.len()).map(of).collect()
    }

    pub(super) fn cost_rest(
        &self,
        shop: &Shop<'_>,
        way: &[i64],
        cost: &dyn Fn(usize, usize) -> i64,
        with_loops: bool,
    ) -> Table {
        let of = |demand: usize| {
            let cell = &shop.cells[demand];
            let rest = |number: usize, after: i64| {
                let steps = &cell.works[number].steps;
                let from = |begin: usize| {
                    let mut total = after;
                    for (at, step) in steps.iter().enumerate().skip(begin) {
                        for call in step {
                            let able = performers(call);
                            let own = call.performers.iter();
                            let least =
                                own.map(|p| cost(p.1.resource as usize, p.1.transition as usize));
                            total = (total + least.min().unwrap_or(NEVER)).min(NEVER);
                            for input in &call.inputs {
                                if let Some(last) = last_touch(steps, *input, at)
                                    && last.0 >= begin
                                    && self.single[demand][*input as usize]
                                {
                                    total = (total + self.between(way, &last.1, &able)).min(NEVER);
                                }
                            }
                        }
                    }
                    total
                };
                (0..=steps.len()).map(from).collect()
            };
            backward(cell, with_loops, rest)
        };
        (0..shop.demands.len()).map(of).collect()
    }
}

/// Returns the step before `at` that makes the part which is needed there, and the resources that
/// can perform it.
pub(super) fn last_touch(
    steps: &[impl AsRef<[Call]>],
    part: u16,
    at: usize,
) -> Option<(usize, Vec<u16>)> {
    for step in (0..at).rev() {
        let calls = steps[step].as_ref();
        let makes = calls.iter().filter(|c| c.outputs.contains(&part));
        let able: Vec<u16> = makes.flat_map(performers).collect();
        if !able.is_empty() {
            return Some((step, able));
        }
        // If it is gone, stock replaces it.
        if calls.iter().any(|c| c.inputs.contains(&part)) {
            return None;
        }
    }
    None
}

/// Returns for each part of a recipe whether a product never has more than one of it.
pub(super) fn single(shop: &Shop<'_>, demand: usize) -> Vec<bool> {
    let (cell, recipe) = (&shop.cells[demand], &shop.demands[demand].recipe);
    let count = recipe.parts.len();
    // The most that there can be in each state of the recipe, counted up to 2.
    let held = |p: &crate::model::Part| {
        let all = shop.layout.resources.iter().flat_map(|r| &r.holds);
        all.filter(|h| **h == p.name).count().min(2)
    };
    let mut most = vec![vec![0; count]; cell.recipe_states.len()];
    most[cell.start as usize] = recipe.parts.iter().map(held).collect();
    let mut is_single: Vec<bool> = most[cell.start as usize].iter().map(|n| *n < 2).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for state in 0..most.len() {
            for work in &cell.recipe_states[state].leaving {
                let work = &cell.works[*work as usize];
                let mut now = most[state].clone();
                for step in &work.steps {
                    for input in step.iter().flat_map(|c| &c.inputs) {
                        let left = &mut now[*input as usize];
                        *left = usize::saturating_sub(*left, 1);
                    }
                    for output in step.iter().flat_map(|c| &c.outputs) {
                        let left = &mut now[*output as usize];
                        *left = (*left + 1).min(2);
                        is_single[*output as usize] &= *left < 2;
                    }
                }
                for (old, new) in most[work.to as usize].iter_mut().zip(now) {
                    changed |= new > *old;
                    *old = new.max(*old);
                }
            }
        }
    }
    is_single
}

/// Returns the greatest rest over the outcomes of a test that are not [`NEVER`].
pub(super) fn greatest(each: impl Iterator<Item = i64>, is_end: bool) -> i64 {
    let most = each.filter(|rest| *rest < NEVER).max();
    most.unwrap_or(if is_end { 0 } else { NEVER })
}

/// Evaluates the transitions of a recipe from its ends, or from the transitions that close loops.
fn backward(cell: &Cell, with_loops: bool, rest: impl Fn(usize, i64) -> Vec<i64>) -> Vec<Vec<i64>> {
    let mut table: Vec<Vec<i64>> = vec![Vec::new(); cell.works.len()];
    let after = |table: &[Vec<i64>], work: &Work| -> Option<i64> {
        if work.closes_loop {
            return Some(if with_loops { 0 } else { NEVER });
        }
        let to = &cell.recipe_states[work.to as usize];
        let each = to
            .leaving
            .iter()
            .map(|w| table[*w as usize].first().copied());
        let each: Option<Vec<i64>> = each.collect();
        Some(greatest(each?.into_iter(), to.is_end))
    };
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for number in (0..cell.works.len()).rev() {
            if table[number].is_empty()
                && let Some(after) = after(&table, &cell.works[number])
            {
                table[number] = rest(number, after);
                changed = true;
            }
        }
    }
    // What is in a circle of the recipe that nothing enters is never used.
    for (number, row) in table.iter_mut().enumerate() {
        row.resize(cell.works[number].steps.len() + 1, 0);
    }
    table
}

/// Returns the first use of each part after some steps of each transition.
pub(super) fn uses(shop: &Shop<'_>) -> Vec<Vec<Vec<Uses>>> {
    let of_work = |work: &Work| {
        let from = |begin: usize| {
            let mut found: Vec<(u16, Vec<u16>)> = Vec::new();
            // Parts that are made after `begin` are not the ones that exist now.
            let mut made: Vec<u16> = Vec::new();
            for step in &work.steps[begin..] {
                for call in step {
                    let able = performers(call);
                    for input in &call.inputs {
                        if !made.contains(input) && !found.iter().any(|f| f.0 == *input) {
                            found.push((*input, able.clone()));
                        }
                    }
                }
                made.extend(step.iter().flat_map(|c| &c.outputs));
            }
            found
        };
        (0..=work.steps.len()).map(from).collect()
    };
    let each = shop
        .cells
        .iter()
        .map(|cell| cell.works.iter().map(of_work).collect());
    each.collect()
}

/// Returns the least cost of a way between each two resources: R. W. Floyd, "Algorithm 97: shortest
/// path", Communications of the ACM 5 (1962), 345. In lockstep, the two sides of a transfer take
/// the same time (`shared`).
pub(super) fn ways(shop: &Shop<'_>, cost: &dyn Fn(usize, usize) -> i64, shared: bool) -> Vec<i64> {
    let resources = shop.resources();
    let mut way = vec![NEVER; resources * resources];
    let offers = |r: usize, gives: bool| {
        let transitions = shop.layout.resources[r].transitions.iter().enumerate();
        transitions.filter_map(move |(t, transition)| match &transition.action {
            Action::Out(label) if gives => Some((t, label)),
            Action::In(label) if !gives => Some((t, label)),
            _ => None,
        })
    };
    let mut takers: FxHashMap<&String, Vec<(usize, i64)>> = FxHashMap::default();
    for r in 0..resources {
        for (t, label) in offers(r, false) {
            takers.entry(label).or_default().push((r, cost(r, t)));
        }
    }
    for a in 0..resources {
        way[a * resources + a] = 0;
        for (t, label) in offers(a, true) {
            for (b, taken) in takers.get(label).into_iter().flatten() {
                let given = cost(a, t);
                let sum = if shared {
                    given.max(*taken)
                } else {
                    given + taken
                };
                let cell = &mut way[a * resources + b];
                *cell = (*cell).min(sum);
            }
        }
    }
    for via in 0..resources {
        for a in 0..resources {
            let first = way[a * resources + via];
            if first >= NEVER {
                continue;
            }
            for b in 0..resources {
                let sum = first + way[via * resources + b];
                let cell = &mut way[a * resources + b];
                *cell = (*cell).min(sum);
            }
        }
    }
    way
}
