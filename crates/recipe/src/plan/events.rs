//! What can happen in a state, when, and what it leads to.

use super::Execution;
use super::shop::Shop;
use super::state::{ENDED, Happening, State};
use super::zone::Shift;
use crate::realize::cell::Taken;
use crate::realize::moves::{Event, find_events};

impl Shop<'_> {
    /// Returns what can happen in a state, apart from tests. The order depends on the state alone.
    pub fn happenings(&self, words: &[u16]) -> Vec<Happening> {
        let mut all = Vec::new();
        for slot in 0..self.slots.len() {
            self.add_steps(words, slot, &mut all);
        }
        let Some(cell) = self.cells.first() else {
            return all;
        };
        let mut events = Vec::new();
        find_events(cell, self.cell_words(words), &mut events);
        all.extend(events.iter().filter_map(|event| match *event {
            Event::Internal(taken) => Some(Happening::Internal(taken)),
            Event::Transfer {
                giver,
                taker,
                label,
                kind,
            } => Some(Happening::Transfer {
                giver,
                taker,
                label,
                kind,
            }),
            Event::Operation { .. } => None,
        }));
        all
    }

    /// Adds the ways to perform a product's next step.
    fn add_steps(&self, words: &[u16], slot: usize, all: &mut Vec<Happening>) {
        let (number, step) = (words[2 * slot], words[2 * slot + 1]);
        if step >= ENDED {
            return;
        }
        let work = &self.cell(slot).works[number as usize];
        let Some(calls) = work.steps.get(step as usize) else {
            return;
        };
        let (states, held) = (self.resource_states(words), self.held(words));
        let mut ways: Vec<Vec<Taken>> = vec![Vec::new()];
        for call in calls {
            let able = |(state, taken): &&(u16, Taken)| {
                let resource = taken.resource as usize;
                let parts = held
                    .chunks_exact(2)
                    .filter(|p| p[0] == taken.resource)
                    .count();
                states[resource] == *state
                    && self.holds(slot, taken.resource, &call.inputs, held)
                    && parts + call.outputs.len()
                        <= self.layout.resources[resource].capacity + call.inputs.len()
            };
            let candidates: Vec<Taken> = call.performers.iter().filter(able).map(|p| p.1).collect();
            let mut longer = Vec::new();
            for way in &ways {
                for taken in &candidates {
                    if way.iter().all(|t| t.resource != taken.resource) {
                        let mut way = way.clone();
                        way.push(*taken);
                        longer.push(way);
                    }
                }
            }
            ways = longer;
        }
        all.extend(ways.into_iter().map(|performers| Happening::Step {
            slot: slot as u16,
            performers,
        }));
    }

    /// Returns what a happening does to the times: shifts, what it follows, and results.
    pub fn timing(&self, happening: &Happening) -> (Vec<Shift>, Vec<u16>, Vec<(u16, i64)>) {
        let shift = |taken: &Taken, begin: i64, end: i64| Shift {
            variable: taken.resource,
            begin,
            end,
            is_anchor: !self.may_wait(taken.resource, taken.to),
        };
        let ticks = |taken: &Taken| self.ticks[taken.resource as usize][taken.transition as usize];
        match happening {
            Happening::Internal(taken) => (vec![shift(taken, 0, ticks(taken))], vec![], vec![]),
            Happening::Step { slot, performers } => {
                let ready = self.ready_variable(*slot as usize);
                let end = performers.iter().map(ticks).max().unwrap_or(0);
                let shifts = performers.iter().map(|t| shift(t, 0, ticks(t))).collect();
                (shifts, vec![ready], vec![(ready, end)])
            }
            Happening::Transfer {
                giver,
                taker,
                label,
                ..
            } => match self.execution {
                Execution::Lockstep => {
                    let label = Shift {
                        variable: self.label_variable(*label),
                        begin: 0,
                        end: 1,
                        is_anchor: false,
                    };
                    let shifts = vec![shift(giver, 0, 1), shift(taker, 0, 1), label];
                    (shifts, vec![], vec![])
                }
                Execution::Timed => {
                    let shifts = vec![
                        shift(giver, -ticks(giver), 0),
                        shift(taker, 0, ticks(taker)),
                    ];
                    (shifts, vec![], vec![])
                }
            },
        }
    }

    /// Returns the state after a happening, or nothing if no times permit it. It is not yet
    /// advanced or sorted.
    pub fn apply(&self, state: &State, happening: &Happening) -> Option<State> {
        let (shifts, mut after, mut results) = self.timing(happening);
        after.extend(self.clock_variable());
        results.extend(self.clock_variable().map(|clock| (clock, 0)));
        let mut zone = state.zone.apply(&shifts, &after, &results)?;
        let (mut words, head) = (state.words.clone(), self.head());
        let mut pairs: Vec<(u16, u16)> = (words[head..].chunks_exact(2))
            .map(|p| (p[0], p[1]))
            .collect();
        words.truncate(head);
        let mut enter = |taken: &Taken| {
            words[2 * self.slots.len() + taken.resource as usize] = taken.to;
        };
        match happening {
            Happening::Internal(taken) => enter(taken),
            Happening::Transfer {
                giver, taker, kind, ..
            } => {
                enter(giver);
                enter(taker);
                if let Some(at) = pairs.iter().position(|p| *p == (giver.resource, *kind)) {
                    pairs[at].0 = taker.resource;
                }
            }
            Happening::Step { slot, performers } => {
                performers.iter().for_each(&mut enter);
                let slot = *slot as usize;
                let number = words[2 * slot] as usize;
                let calls = &self.cell(slot).works[number].steps[words[2 * slot + 1] as usize];
                let held = self.held(&state.words);
                for (call, taken) in calls.iter().zip(performers) {
                    for kind in self.resolve(slot, &call.inputs, held) {
                        if let Some(at) = pairs.iter().position(|p| *p == (taken.resource, kind)) {
                            pairs.remove(at);
                        }
                    }
                    let outputs = call
                        .outputs
                        .iter()
                        .map(|o| (taken.resource, self.own[slot] + o));
                    pairs.extend(outputs);
                }
                words[2 * slot + 1] += 1;
            }
        }
        pairs.sort_unstable();
        words.extend(pairs.iter().flat_map(|(r, k)| [*r, *k]));
        if let Some(clock) = self.clock_variable() {
            let states = self.resource_states(&words);
            let lead = |variable: u16| {
                let state = states.get(variable as usize);
                state.map_or(0, |s| self.lead[variable as usize][*s as usize])
            };
            if !zone.lift(clock, lead) {
                return None;
            }
        }
        Some(State {
            words,
            zone,
            origin: state.origin.clone(),
        })
    }
}
