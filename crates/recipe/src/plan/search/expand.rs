//! What can follow a state of a segment.

use super::{Item, LimitReached, Search, Segment, Stop, Test};
use crate::plan::bounds::is_never;
use crate::plan::state::{Happening, PLACE, State};
use crate::plan::zone::Zone;
use crate::plan::{Execution, Objective};
use crate::realize::cell::Taken;

impl Search<'_> {
    /// Adds what can follow a state.
    pub(super) fn expand(
        &mut self,
        segment: &mut Segment,
        node: u32,
        bound: i64,
        lower: &mut i64,
    ) -> Result<(), LimitReached> {
        let at = &segment.nodes[node as usize];
        let (state, cost) = (at.state.clone(), at.cost);
        for slot in 0..self.shop.slots.len() {
            if let Some(place) = self.shop.pending(&state.words, slot) {
                self.add_tests(segment, node, &state, slot, place, (cost, bound), lower)?;
            }
        }
        for happening in self.shop.happenings(&state.words) {
            if let Some(next) = self.shop.apply(&state, &happening) {
                let cost = cost + self.cost(&happening);
                self.add(segment, next, Some(happening), node, cost)?;
            }
        }
        Ok(())
    }

    /// Adds the tests of a slot's product.
    #[expect(
        clippy::too_many_arguments,
        reason = "they are the state of the search"
    )]
    fn add_tests(
        &mut self,
        segment: &mut Segment,
        node: u32,
        state: &State,
        slot: usize,
        place: u16,
        (cost, bound): (i64, i64),
        lower: &mut i64,
    ) -> Result<(), LimitReached> {
        // Variables that the test follows, for each choice of resources that can perform it.
        let mut ways = vec![vec![self.shop.ready_variable(slot)]];
        let held = self.shop.held(&state.words);
        for (inputs, testers) in &self.shop.cell(slot).recipe_states[place as usize].tests {
            let able = testers
                .iter()
                .filter(|r| self.shop.holds(slot, **r, inputs, held));
            let able: Vec<u16> = able.copied().collect();
            let longer = ways.iter().flat_map(|way| {
                able.iter().map(move |r| {
                    let mut way = way.clone();
                    way.push(*r);
                    way
                })
            });
            ways = longer.collect();
        }
        let closes_loop = state.words[2 * slot + 1] != PLACE;
        let left = self.events_left(state);
        for after in ways {
            if closes_loop {
                let mut state = state.clone();
                state.set(slot, [place, PLACE]);
                self.finish(segment, state, None, node, cost, Stop::Loop(Some(slot)))?;
                continue;
            }
            let mut push = |after: &[u16], least: i64, ends: bool| {
                let (time, low) = state.zone.settle(after, least, ends)?;
                let mut later = state.clone();
                let raised = low.iter().map(|l| (*l).max(time)).collect();
                later.zone = Zone::new(raised, state.zone.anchors.clone());
                let own = self.bounds.least(self.shop, &later, cost).max(bound);
                if !is_never(own) {
                    let test = Test {
                        slot,
                        after: after.to_vec(),
                        least,
                        time,
                        low: low.clone(),
                    };
                    segment.push(own, left, node, Item::Test(test));
                }
                Some((time, low, own))
            };
            if self.shop.execution == Execution::Lockstep {
                let all: Vec<u16> = (0..state.zone.low.len() as u16).collect();
                push(&all, 0, true);
                break;
            }
            let Some((time, low, own)) = push(&after, 0, false) else {
                continue;
            };
            let is_anchor = |v: usize| state.zone.anchors.binary_search(&(v as u16)).is_ok();
            let mut later: Vec<i64> = (low.iter().copied().enumerate())
                .filter(|(v, low)| *low > time && !is_anchor(*v))
                .map(|(_, low)| low)
                .collect();
            later.sort_unstable();
            later.dedup();
            if !state.zone.anchors.is_empty() && !later.is_empty() {
                *lower = (*lower).min(own);
                for least in later {
                    push(&after, least, false);
                }
            }
        }
        Ok(())
    }

    /// Returns the cost of a happening, if the objective is not a time.
    fn cost(&self, happening: &Happening) -> i64 {
        let energy = |t: &Taken| self.shop.energy[t.resource as usize][t.transition as usize];
        match (self.objective, happening) {
            (Objective::Transfers, Happening::Transfer { .. }) => 1,
            (Objective::Energy, Happening::Transfer { giver, taker, .. }) => {
                energy(giver) + energy(taker)
            }
            (Objective::Energy, Happening::Internal(taken)) => energy(taken),
            (Objective::Energy, Happening::Step { performers, .. }) => {
                performers.iter().map(energy).sum()
            }
            _ => 0,
        }
    }

    /// Returns the number of steps and transfers that are left at least. It only decides between
    /// equal costs.
    pub(super) fn events_left(&self, state: &State) -> u32 {
        let of = |slot: usize| {
            let (first, second) = (state.words[2 * slot], state.words[2 * slot + 1]);
            let cell = self.shop.cell(slot);
            match cell.works.get(first as usize) {
                Some(work) if (second as usize) <= work.steps.len() => {
                    (work.steps.len() - second as usize) as u32 + cell.steps_after(work)
                }
                _ => cell.recipe_states[first as usize].steps_to_go,
            }
        };
        let steps: u32 = (0..self.shop.slots.len()).map(of).sum();
        let transfers = self.bounds.transfers_left(self.shop, state);
        steps.saturating_add(u32::try_from(transfers).unwrap_or(u32::MAX))
    }
}
