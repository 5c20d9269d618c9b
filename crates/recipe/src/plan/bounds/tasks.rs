//! The steps of products as tasks of a job shop, and a bound for one of them.

use super::tables::last_touch;
use super::{Bounds, NEVER, performers};
use crate::jobshop::Task;
use crate::plan::shop::Shop;
use crate::plan::state::State;
use crate::realize::cell::Call;

impl Bounds {
    /// Returns the steps of a product as tasks, with the least times of the ways between them. Each
    /// operation that only one resource can perform needs it.
    pub fn tasks(&self, shop: &Shop<'_>, slot: usize, steps: &[&[Call]], tasks: &mut Vec<Task>) {
        let demand = shop.slots[slot].1;
        // The first task of each step.
        let mut first = Vec::new();
        for (at, step) in steps.iter().enumerate() {
            first.push(tasks.len());
            for call in *step {
                let able = performers(call);
                let mut after = Vec::new();
                if at > 0 {
                    after.extend((first[at - 1]..first[at]).map(|task| (task, 0)));
                }
                for input in &call.inputs {
                    if let Some(last) = last_touch(steps, *input, at)
                        && self.single[demand][*input as usize]
                    {
                        let way = self.between(&self.way, &last.1, &able);
                        let makes = |c: &Call| c.outputs.contains(input);
                        let maker = steps[last.0].iter().position(makes);
                        after.extend(maker.map(|call| (first[last.0] + call, way)));
                    }
                }
                let ticks = call.performers.iter();
                let ticks =
                    ticks.map(|p| shop.ticks[p.1.resource as usize][p.1.transition as usize]);
                let [only] = able[..] else {
                    tasks.push(Task {
                        machine: None,
                        duration: ticks.min().unwrap_or(0),
                        after,
                        ..Task::default()
                    });
                    continue;
                };
                tasks.push(Task {
                    machine: Some(only as usize),
                    duration: ticks.min().unwrap_or(0),
                    after,
                    ..Task::default()
                });
            }
        }
    }

    /// Returns a lower bound of the end of a product's next step.
    pub fn step_end(&self, shop: &Shop<'_>, state: &State, slot: usize) -> i64 {
        let low = |variable: u16| state.zone.low[variable as usize];
        let (work, step) = (state.words[2 * slot], state.words[2 * slot + 1]);
        let held = shop.held(&state.words);
        let calls = &shop.cell(slot).works[work as usize].steps[step as usize];
        let mut begin = low(shop.ready_variable(slot));
        let mut longest = 0;
        for call in calls {
            let kinds = shop.resolve(slot, &call.inputs, held);
            let each = call.performers.iter().map(|(_, taken)| {
                let resource = taken.resource;
                let mut begin = low(resource);
                for kind in &kinds {
                    let places = held.chunks_exact(2).filter(|p| p[1] == *kind);
                    let ways =
                        places.map(|p| low(p[0]) + self.between(&self.way, &[p[0]], &[resource]));
                    begin = begin.max(ways.min().unwrap_or(NEVER));
                }
                let ticks = shop.ticks[resource as usize][taken.transition as usize];
                (begin, ticks)
            });
            let all: Vec<(i64, i64)> = each.collect();
            begin = begin.max(all.iter().map(|a| a.0).min().unwrap_or(NEVER));
            longest = longest.max(all.iter().map(|a| a.1).min().unwrap_or(0));
        }
        (begin + longest).min(NEVER)
    }
}
