//! The vectors that the resources can take in a configuration.
//!
//! A vector is a set of *events* of different resources: an operation, an internal operation, or a
//! transfer of one part between two resources. Events are found from the parts and from the
//! resources with internal operations; the resources that have none of them and may wait cost
//! nothing. A vector that contains operations contains those of the whole step.

use super::cell::{Call, Cell, Taken};

/// Something that one or two resources do in a vector.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Event {
    /// An operation, as an index into the step.
    Operation { call: u16, taken: Taken },
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

impl Event {
    /// Returns the transitions that it takes.
    pub fn taken(&self) -> impl Iterator<Item = Taken> {
        let (first, second) = match *self {
            Self::Operation { taken, .. } | Self::Internal(taken) => (taken, None),
            Self::Transfer { giver, taker, .. } => (giver, Some(taker)),
        };
        std::iter::once(first).chain(second)
    }

    /// Returns the least resource that takes part in it.
    fn first(&self) -> u16 {
        self.taken().map(|t| t.resource).min().unwrap_or(0)
    }
}

/// Which vectors are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stride {
    /// All.
    Vectors,
    /// Those with one event, or with the operations of one step. This finds the right verdict only
    /// if every resource may wait in every state.
    Events,
}

/// Enumerates vectors. Has no state of its own but buffers.
pub(super) struct Moves<'c> {
    cell: &'c Cell,
    stride: Stride,
    /// Internal operations and transfers, by their first resource.
    events: Vec<Event>,
    /// Whether a resource takes part in the vector.
    busy: Vec<bool>,
    label_used: Vec<bool>,
    vector: Vec<Event>,
    target: Vec<u16>,
    pairs: Vec<(u16, u16)>,
    /// Decisions: a resource, its events (a range), and the next option.
    levels: Vec<(u16, usize, usize, usize)>,
    /// Number of decisions that may still be made.
    pub effort: usize,
}

/// Adds the internal operations and the transfers of a configuration. Whether a part is worth
/// moving is not asked.
pub(crate) fn find_events(cell: &Cell, from: &[u16], events: &mut Vec<Event>) {
    let (states, held) = from.split_at(cell.resources());
    let table = |r: u16| &cell.states[r as usize][states[r as usize] as usize];
    for resource in &cell.with_internal {
        let internal = table(*resource).internal.iter();
        events.extend(internal.map(|t| Event::Internal(*t)));
    }
    let mut last = None;
    for pair in held.chunks_exact(2) {
        if last == Some(pair) {
            continue;
        }
        last = Some(pair);
        for (label, giver) in &table(pair[0]).gives {
            for receiver in &cell.receivers[*label as usize] {
                let taker = *receiver as usize;
                let room = || {
                    let parts = held.chunks_exact(2).filter(|p| p[0] == *receiver).count();
                    parts < cell.capacity[taker]
                };
                if *receiver == pair[0] || !room() {
                    continue;
                }
                let takes = table(*receiver).takes.iter().filter(|(l, _)| l == label);
                events.extend(takes.map(|(_, taker)| Event::Transfer {
                    giver: *giver,
                    taker: *taker,
                    label: *label,
                    kind: pair[1],
                }));
            }
        }
    }
}

/// Receives each vector with the next configuration and whether it performs the step. Returns
/// whether to go on.
pub(super) type Sink<'s> = dyn FnMut(&[Event], &[u16], bool) -> bool + 's;

impl<'c> Moves<'c> {
    pub fn new(cell: &'c Cell, stride: Stride) -> Self {
        Self {
            cell,
            stride,
            events: Vec::new(),
            busy: vec![false; cell.resources()],
            label_used: vec![false; cell.receivers.len()],
            vector: Vec::new(),
            target: Vec::new(),
            pairs: Vec::new(),
            levels: Vec::new(),
            effort: usize::MAX,
        }
    }

    /// Calls `sink` with each vector. `step` is the step that can be performed; with `None`, only
    /// vectors without operations are found. Returns whether the sink wanted all of them, and the
    /// effort was sufficient.
    ///
    /// The order depends only on the cell and the configuration.
    pub fn each(&mut self, from: &[u16], step: Option<&[Call]>, sink: &mut Sink<'_>) -> bool {
        self.find_events(from);
        self.vector.clear();
        self.busy.fill(false);
        self.label_used.fill(false);
        if let Some(step) = step
            && !self.perform(from, step, sink)
        {
            return false;
        }
        self.combine(from, false, sink)
    }

    /// Finds the internal operations and transfers.
    fn find_events(&mut self, from: &[u16]) {
        self.events.clear();
        find_events(self.cell, from, &mut self.events);
        self.events.sort_by_key(Event::first);
    }

    /// Calls `sink` with each vector that performs the step.
    fn perform(&mut self, from: &[u16], step: &[Call], sink: &mut Sink<'_>) -> bool {
        let cell = self.cell;
        let (states, held) = from.split_at(cell.resources());
        let mut candidates: Vec<Vec<Taken>> = Vec::with_capacity(step.len());
        for call in step {
            let able = |(state, taken): &&(u16, Taken)| {
                let resource = taken.resource as usize;
                let parts = held
                    .chunks_exact(2)
                    .filter(|p| p[0] == taken.resource)
                    .count();
                states[resource] == *state
                    && cell.holds(taken.resource, &call.inputs, held)
                    && parts + call.outputs.len() <= cell.capacity[resource] + call.inputs.len()
            };
            let found: Vec<Taken> = (call.performers.iter()).filter(able).map(|p| p.1).collect();
            if found.is_empty() {
                return true;
            }
            candidates.push(found);
        }
        // The next candidate of each operation.
        let mut cursor = vec![0];
        while let Some(next) = cursor.last_mut() {
            let at = *next;
            *next += 1;
            let call = cursor.len() - 1;
            if let Some(Event::Operation { taken, .. }) = self.vector.get(call) {
                self.busy[taken.resource as usize] = false;
                self.vector.pop();
            }
            let Some(taken) = candidates[call].get(at) else {
                cursor.pop();
                continue;
            };
            if self.busy[taken.resource as usize] {
                continue;
            }
            self.busy[taken.resource as usize] = true;
            self.vector.push(Event::Operation {
                call: call as u16,
                taken: *taken,
            });
            if cursor.len() < step.len() {
                cursor.push(0);
            } else if !self.finish_step(from, step, sink) {
                return false;
            }
        }
        true
    }

    /// Calls `sink` with each vector that has the operations chosen so far.
    fn finish_step(&mut self, from: &[u16], step: &[Call], sink: &mut Sink<'_>) -> bool {
        let cell = self.cell;
        let held = &from[cell.resources()..];
        // The parts after the operations. Transfers do not involve the resources that perform.
        self.pairs.clear();
        self.pairs
            .extend(held.chunks_exact(2).map(|p| (p[0], p[1])));
        for event in &self.vector {
            let Event::Operation { call, taken } = event else {
                continue;
            };
            let call = &step[*call as usize];
            for input in &call.inputs {
                let pair = (taken.resource, cell.resolve(*input, held));
                if let Some(at) = self.pairs.iter().position(|p| *p == pair) {
                    self.pairs.remove(at);
                }
            }
            self.pairs
                .extend(call.outputs.iter().map(|o| (taken.resource, *o)));
        }
        let mut after = from[..cell.resources()].to_vec();
        after.extend(self.pairs.iter().flat_map(|(r, k)| [*r, *k]));
        self.combine(&after, true, sink)
    }

    /// Calls `sink` with each extension of the vector by events of other resources.
    fn combine(&mut self, from: &[u16], performs: bool, sink: &mut Sink<'_>) -> bool {
        if self.stride == Stride::Events {
            if performs {
                return self.emit(from, true, sink);
            }
            for at in 0..self.events.len() {
                self.vector.push(self.events[at]);
                let go_on = self.emit(from, false, sink);
                self.vector.pop();
                if !go_on {
                    return false;
                }
            }
            return true;
        }
        if !self.find_levels(from) {
            return true;
        }
        let mut depth = 0;
        loop {
            if self.effort == 0 {
                return false;
            }
            self.effort -= 1;
            if depth == self.levels.len() {
                let go_on = self.vector.is_empty() || self.emit(from, performs, sink);
                if !go_on {
                    return false;
                }
            } else if self.choose(depth, from) {
                depth += 1;
                if let Some(level) = self.levels.get_mut(depth) {
                    level.3 = 0;
                }
                continue;
            }
            if depth == 0 {
                return true;
            }
            depth -= 1;
            self.withdraw(depth);
        }
    }

    /// Finds the resources that have to decide: those with events, and those that may not wait.
    /// Returns whether each of the latter can do something.
    fn find_levels(&mut self, from: &[u16]) -> bool {
        self.levels.clear();
        let mut at = 0;
        while at < self.events.len() {
            let first = self.events[at].first();
            let count = (self.events[at..].iter())
                .take_while(|e| e.first() == first)
                .count();
            self.levels.push((first, at, at + count, 0));
            at += count;
        }
        let cell = self.cell;
        let with_events = self.levels.len();
        for resource in &cell.restless {
            let state = from[*resource as usize];
            if cell.states[*resource as usize][state as usize].may_wait {
                continue;
            }
            let involves = |e: &Event| e.taken().any(|t| t.resource == *resource);
            if !self.busy[*resource as usize] && !self.events.iter().any(involves) {
                return false;
            }
            if !self.levels[..with_events].iter().any(|l| l.0 == *resource) {
                self.levels.push((*resource, 0, 0, 0));
            }
        }
        self.levels.sort_unstable();
        true
    }

    /// Takes the next option of a level: first to wait, then its events. Returns whether there was
    /// one.
    fn choose(&mut self, depth: usize, from: &[u16]) -> bool {
        let (resource, begin, end, option) = self.levels[depth];
        let state = from[resource as usize];
        let may_wait = self.cell.states[resource as usize][state as usize].may_wait;
        let busy = self.busy[resource as usize];
        if option == 0 && (busy || may_wait) {
            self.levels[depth].3 = 1;
            return true;
        }
        let mut next = begin + option.max(1) - 1;
        while !busy && next < end {
            let event = self.events[next];
            next += 1;
            let label = match event {
                Event::Transfer { label, .. } => Some(label),
                _ => None,
            };
            let free = event.taken().all(|t| !self.busy[t.resource as usize])
                && label.is_none_or(|l| !self.label_used[l as usize]);
            if free {
                self.mark(&event, true);
                self.vector.push(event);
                self.levels[depth].3 = next - begin + 1;
                return true;
            }
        }
        self.levels[depth].3 = end - begin + 1;
        false
    }

    /// Takes back what a level has chosen.
    fn withdraw(&mut self, depth: usize) {
        let (resource, ..) = self.levels[depth];
        let own = self
            .vector
            .last()
            .copied()
            .filter(|e| !matches!(e, Event::Operation { .. }) && e.first() == resource);
        if let Some(event) = own {
            self.mark(&event, false);
            self.vector.pop();
        }
    }

    fn mark(&mut self, event: &Event, value: bool) {
        for taken in event.taken() {
            self.busy[taken.resource as usize] = value;
        }
        if let Event::Transfer { label, .. } = event {
            self.label_used[*label as usize] = value;
        }
    }

    /// Calls `sink` with the vector. `from` has the parts after its operations.
    fn emit(&mut self, from: &[u16], performs: bool, sink: &mut Sink<'_>) -> bool {
        let resources = self.cell.resources();
        self.target.clear();
        self.target.extend_from_slice(&from[..resources]);
        self.pairs.clear();
        self.pairs
            .extend(from[resources..].chunks_exact(2).map(|p| (p[0], p[1])));
        for event in &self.vector {
            for taken in event.taken() {
                self.target[taken.resource as usize] = taken.to;
            }
            if let Event::Transfer {
                giver, taker, kind, ..
            } = event
            {
                let pair = (giver.resource, *kind);
                if let Some(at) = self.pairs.iter().position(|p| *p == pair) {
                    self.pairs[at].0 = taker.resource;
                }
            }
        }
        self.pairs.sort_unstable();
        self.target
            .extend(self.pairs.iter().flat_map(|(r, k)| [*r, *k]));
        sink(&self.vector, &self.target, performs)
    }
}
