//! Where all products and resources are, and what can happen next.
//!
//! A state is a row of words: two for each slot (a transition of the recipe and the number of its
//! steps performed, or a state of the recipe), the states of the resources, and pairs of a resource
//! and a part that it holds, sorted. Equal products are interchangeable, so the slots of each
//! recipe are sorted; a state is then the same whichever product is where.

use super::shop::{Configuration, Kind, Shop};
use super::zone::{Shift, Zone};
use super::{Execution, Progress};
use crate::realize::cell::Taken;
use crate::realize::moves::{Event, find_events};

/// Second word of a slot whose product is in a state of the recipe.
pub(super) const PLACE: u16 = u16::MAX;
/// Second word of a slot whose product is finished.
const ENDED: u16 = u16::MAX - 1;

/// A state with what is known of its times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct State {
    pub words: Vec<u16>,
    pub zone: Zone,
    /// The slot of the root in which each slot's product was.
    pub origin: Vec<u16>,
}

/// Something that can happen next.
#[derive(Debug, Clone)]
pub(super) enum Happening {
    /// A product's next step, with what performs each operation.
    Step { slot: u16, performers: Vec<Taken> },
    /// An internal operation.
    Internal(Taken),
    /// A transfer of a part.
    Transfer {
        giver: Taken,
        taker: Taken,
        label: u16,
        kind: u16,
    },
}

/// What a state is after all that happens by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Settled {
    /// Something has to happen.
    Open,
    /// All products are finished.
    Ended,
    /// A product has closed a loop of its recipe.
    Loop,
    /// A product is at an end where a part remains that may not.
    Dead,
}

impl Shop<'_> {
    /// Returns the number of words before the parts.
    fn head(&self) -> usize {
        2 * self.slots.len() + self.resources()
    }

    /// Returns the states of the resources and the parts.
    pub fn cell_words<'w>(&self, words: &'w [u16]) -> &'w [u16] {
        &words[2 * self.slots.len()..]
    }

    /// Returns the states of the resources.
    pub fn resource_states<'w>(&self, words: &'w [u16]) -> &'w [u16] {
        &words[2 * self.slots.len()..self.head()]
    }

    /// Returns the resources and the parts that they hold.
    pub fn held<'w>(&self, words: &'w [u16]) -> &'w [u16] {
        &words[self.head()..]
    }

    /// Number of the variable for the time at which a label is free.
    fn label_variable(&self, label: u16) -> u16 {
        self.resources() as u16 + label
    }

    /// Number of the variable for the time at which a slot's last step has ended.
    pub fn ready_variable(&self, slot: usize) -> u16 {
        let labels = match self.execution {
            Execution::Lockstep => self.labels,
            Execution::Timed => 0,
        };
        (self.resources() + labels + slot) as u16
    }

    /// Number of the variable for the time of the last happening, if they are in order.
    pub fn clock_variable(&self) -> Option<u16> {
        self.is_ordered
            .then(|| self.ready_variable(self.slots.len()))
    }

    /// Returns the number of variables.
    pub fn variables(&self) -> usize {
        self.ready_variable(self.slots.len()) as usize + usize::from(self.is_ordered)
    }

    /// Returns the state in which nothing has happened: all times are 0.
    pub fn root(&self, configuration: &Configuration, progress: &[Progress]) -> State {
        let mut words = Vec::new();
        for progress in progress {
            words.extend(match *progress {
                Progress::At(state) => [state as u16, PLACE],
                Progress::Performing { transition, steps } => [transition as u16, steps as u16],
                Progress::Ended => [0, ENDED],
            });
        }
        words.extend(&configuration.states);
        let mut pairs: Vec<(u16, u16)> = (configuration.parts.iter())
            .map(|(resource, kind)| (*resource, self.kind(kind)))
            .collect();
        pairs.sort_unstable();
        words.extend(pairs.iter().flat_map(|(r, k)| [*r, *k]));
        let mut state = State {
            zone: Zone::new(vec![0; self.variables()], self.anchors(&words)),
            words,
            origin: (0..self.slots.len() as u16).collect(),
        };
        self.sort(&mut state);
        state
    }

    /// Returns the resources that may not wait.
    pub fn anchors(&self, words: &[u16]) -> Vec<u16> {
        let states = self.resource_states(words).iter().enumerate();
        let restless = states.filter(|(r, s)| !self.may_wait(*r as u16, **s));
        restless.map(|(r, _)| r as u16).collect()
    }

    /// Returns the progress of each slot, and the configuration.
    pub fn describe(&self, words: &[u16]) -> (Vec<Progress>, Configuration) {
        let progress = |slot: usize| {
            let (first, second) = (words[2 * slot] as usize, words[2 * slot + 1]);
            match second {
                PLACE => Progress::At(first),
                ENDED => Progress::Ended,
                steps => Progress::Performing {
                    transition: first,
                    steps: steps as usize,
                },
            }
        };
        let mut parts: Vec<(u16, Kind)> = (self.held(words).chunks_exact(2))
            .map(|pair| (pair[0], self.kinds[pair[1] as usize].clone()))
            .collect();
        parts.sort_unstable();
        let configuration = Configuration {
            states: self.resource_states(words).to_vec(),
            parts,
        };
        ((0..self.slots.len()).map(progress).collect(), configuration)
    }

    /// Returns the state of the recipe in which a slot's product waits for a test, or waits to
    /// enter it by a transition that closes a loop.
    pub fn pending(&self, words: &[u16], slot: usize) -> Option<u16> {
        let (first, second) = (words[2 * slot], words[2 * slot + 1]);
        match second {
            PLACE => Some(first),
            ENDED => None,
            steps => {
                let work = &self.cell(slot).works[first as usize];
                (steps as usize == work.steps.len()).then_some(work.to)
            }
        }
    }

    /// Does what happens by itself: products enter states of their recipe, leave those without a
    /// choice, and end.
    pub fn advance(&self, state: &mut State) -> Settled {
        let mut ended = 0;
        for slot in 0..self.slots.len() {
            let cell = self.cell(slot);
            loop {
                let (first, second) = (state.words[2 * slot], state.words[2 * slot + 1]);
                if second == ENDED {
                    ended += 1;
                    break;
                }
                if second != PLACE {
                    let work = &cell.works[first as usize];
                    if (second as usize) < work.steps.len() {
                        break;
                    }
                    if work.closes_loop {
                        if cell.recipe_states[work.to as usize].tests.is_empty() {
                            self.set(state, slot, [work.to, PLACE]);
                            return Settled::Loop;
                        }
                        break;
                    }
                    self.set(state, slot, [work.to, PLACE]);
                    continue;
                }
                let about = &cell.recipe_states[first as usize];
                if about.is_end {
                    if !self.end(state, slot) {
                        return Settled::Dead;
                    }
                    self.set(state, slot, [0, ENDED]);
                } else if about.leaving.len() == 1 && about.tests.is_empty() {
                    self.set(state, slot, [about.leaving[0], 0]);
                } else {
                    break;
                }
            }
        }
        if ended == self.slots.len() {
            Settled::Ended
        } else {
            Settled::Open
        }
    }

    /// Sets the progress of a slot.
    pub fn set(&self, state: &mut State, slot: usize, progress: [u16; 2]) {
        state.words[2 * slot..][..2].copy_from_slice(&progress);
    }

    /// Renames the parts of a finished product. Returns whether all of them may remain.
    fn end(&self, state: &mut State, slot: usize) -> bool {
        let head = self.head();
        let mut pairs: Vec<(u16, u16)> = Vec::new();
        for pair in state.words[head..].chunks_exact(2) {
            match self.own_part(slot, pair[1]) {
                Some(part) if !self.cell(slot).may_remain[part as usize] => return false,
                Some(part) => pairs.push((pair[0], self.finished(slot, part))),
                None => pairs.push((pair[0], pair[1])),
            }
        }
        pairs.sort_unstable();
        state.words.truncate(head);
        state.words.extend(pairs.iter().flat_map(|(r, k)| [*r, *k]));
        true
    }

    /// Sorts the slots of equal products.
    pub fn sort(&self, state: &mut State) {
        let mut first = 0;
        while first < self.slots.len() {
            let demand = self.slots[first].1;
            let mut last = first + 1;
            while last < self.slots.len() && self.slots[last].1 == demand {
                last += 1;
            }
            if last - first > 1 {
                self.sort_group(state, first, last);
            }
            first = last;
        }
    }

    fn sort_group(&self, state: &mut State, first: usize, last: usize) {
        let key = |slot: usize| {
            let own = |pair: &[u16]| Some([pair[0], self.own_part(slot, pair[1])?]);
            let parts: Vec<[u16; 2]> = self
                .held(&state.words)
                .chunks_exact(2)
                .filter_map(own)
                .collect();
            let ready = state.zone.low[self.ready_variable(slot) as usize];
            (
                [state.words[2 * slot], state.words[2 * slot + 1]],
                parts,
                ready,
            )
        };
        let mut order: Vec<usize> = (0..last - first).collect();
        let keys: Vec<_> = (first..last).map(key).collect();
        if keys.is_sorted() {
            return;
        }
        order.sort_by(|a, b| keys[*a].cmp(&keys[*b]));
        let mut place = vec![0; order.len()];
        for (to, from) in order.iter().enumerate() {
            place[*from] = to;
        }
        let (words, origin) = (state.words.clone(), state.origin.clone());
        for (to, from) in order.iter().enumerate() {
            let old = 2 * (first + from);
            state.words[2 * (first + to)..][..2].copy_from_slice(&words[old..old + 2]);
            state.origin[first + to] = origin[first + from];
        }
        state
            .zone
            .reorder(self.ready_variable(first) as usize, &order);
        let head = self.head();
        let mut pairs: Vec<(u16, u16)> = (words[head..].chunks_exact(2))
            .map(|pair| {
                let own = (first..last).find_map(|s| Some((s, self.own_part(s, pair[1])?)));
                let kind = own.map_or(pair[1], |(s, part)| {
                    self.own[first + place[s - first]] + part
                });
                (pair[0], kind)
            })
            .collect();
        pairs.sort_unstable();
        state.words.truncate(head);
        state.words.extend(pairs.iter().flat_map(|(r, k)| [*r, *k]));
    }

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
