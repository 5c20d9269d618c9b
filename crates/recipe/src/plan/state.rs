//! Where all products and resources are.
//!
//! A state is a row of words: two for each slot (a transition of the recipe and the number of its
//! steps performed, or a state of the recipe), the states of the resources, and pairs of a resource
//! and a part that it holds, sorted. Equal products are interchangeable, so the slots of each
//! recipe are sorted; a state is then the same whichever product is where.

use super::shop::{Configuration, Kind, Shop};
use super::zone::Zone;
use super::{Execution, Progress};
use crate::realize::cell::Taken;

/// Second word of a slot whose product is in a state of the recipe.
pub(super) const PLACE: u16 = u16::MAX;
/// Second word of a slot whose product is finished.
pub(super) const ENDED: u16 = u16::MAX - 1;

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

impl State {
    /// Sets the progress of a slot.
    pub fn set(&mut self, slot: usize, progress: [u16; 2]) {
        self.words[2 * slot..][..2].copy_from_slice(&progress);
    }
}

impl Shop<'_> {
    /// Returns the number of words before the parts.
    pub fn head(&self) -> usize {
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
    pub fn label_variable(&self, label: u16) -> u16 {
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
                            state.set(slot, [work.to, PLACE]);
                            return Settled::Loop;
                        }
                        break;
                    }
                    state.set(slot, [work.to, PLACE]);
                    continue;
                }
                let about = &cell.recipe_states[first as usize];
                if about.is_end {
                    if !self.end(state, slot) {
                        return Settled::Dead;
                    }
                    state.set(slot, [0, ENDED]);
                } else if about.leaving.len() == 1 && about.tests.is_empty() {
                    state.set(slot, [about.leaving[0], 0]);
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
}
