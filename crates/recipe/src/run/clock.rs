//! When the events of a run happen.

use crate::model::Layout;
use crate::plan::{Entry, EntrySubject};

/// A resource waited in a state where it may not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overrun {
    /// Index of the resource.
    pub resource: usize,
    /// Index of its state.
    pub state: usize,
    /// When it began to wait.
    pub from: i64,
    /// When it went on.
    pub to: i64,
}

/// A time in the plan, from the beginning of the position, and the time at which the same happened.
#[derive(Debug, Clone, Copy, Default)]
struct Moment {
    planned: i64,
    actual: i64,
}

/// Times of a run.
pub(super) struct Clock<'a> {
    layout: &'a Layout,
    /// When the position began.
    base: i64,
    /// End of the last transition of each resource.
    free: Vec<Moment>,
    /// State of each resource.
    states: Vec<usize>,
    /// End of the last step of each product.
    ready: Vec<i64>,
    /// Time of the last test in this position.
    floor: i64,
    pub(super) overruns: Vec<Overrun>,
}

impl<'a> Clock<'a> {
    pub(super) fn new(layout: &'a Layout, products: usize) -> Self {
        Self {
            layout,
            base: 0,
            free: vec![Moment::default(); layout.resources.len()],
            states: Vec::new(),
            ready: vec![0; products],
            floor: 0,
            overruns: Vec::new(),
        }
    }

    /// Returns when the position began.
    pub(super) fn base(&self) -> i64 {
        self.base
    }

    /// Begins a position with these states of the resources.
    pub(super) fn enter(&mut self, states: &[usize]) {
        self.states = states.to_vec();
    }

    /// Ends a position as soon as everything is at rest. Returns when this is.
    pub(super) fn rest(&mut self, planned: i64) -> i64 {
        let free = self.free.iter().map(|m| m.actual);
        let last = free.chain(self.ready.iter().copied()).max().unwrap_or(0);
        let now = last.max(self.base + planned).max(self.floor);
        for resource in 0..self.states.len() {
            self.waits(resource, now);
        }
        self.base = now;
        self.floor = now;
        self.ready.fill(now);
        self.free.fill(Moment {
            planned: 0,
            actual: now,
        });
        now
    }

    /// Makes a test of a product. Returns when.
    pub(super) fn test(&mut self, planned: i64, product: usize) -> i64 {
        let before = self.free.iter().filter(|m| m.planned <= planned);
        let last = before.map(|m| m.actual).max().unwrap_or(0);
        let now = last.max(self.ready[product]).max(self.base + planned);
        self.floor = self.floor.max(now);
        self.ready[product] = self.floor;
        self.floor
    }

    /// Carries out an event whose entries take these durations. With `meets`, it is a transfer in
    /// which this entry gives the part. Returns the start and the end of each entry.
    pub(super) fn event(
        &mut self,
        event: &[Entry],
        durations: &[i64],
        meets: Option<usize>,
    ) -> Vec<(i64, i64)> {
        let performs = |e: &Entry| match e.subject {
            EntrySubject::Operation { product, .. } => Some(product),
            EntrySubject::Part(_) | EntrySubject::Internal => None,
        };
        let product = event.first().and_then(performs);
        let ready = product.map_or(0, |p| self.ready[p]);
        // The instant of the event, and how long before it each entry begins.
        let lead = |number: usize| {
            if meets == Some(number) {
                durations[number]
            } else {
                0
            }
        };
        let mut instant = ready;
        for (number, entry) in event.iter().enumerate() {
            let start = (self.base + entry.start)
                .max(self.free[entry.resource].actual)
                .max(self.floor);
            instant = instant.max(start + lead(number));
        }
        let mut times = Vec::new();
        for (number, entry) in event.iter().enumerate() {
            let start = instant - lead(number);
            let end = start + durations[number];
            self.waits(entry.resource, start);
            let resource = &self.layout.resources[entry.resource];
            let to = resource.state(&resource.transitions[entry.transition].to);
            self.states[entry.resource] = to.expect("transitions enter states of the resource");
            self.free[entry.resource] = Moment {
                planned: entry.end,
                actual: end,
            };
            if let Some(product) = product {
                self.ready[product] = self.ready[product].max(end);
            }
            times.push((start, end));
        }
        times
    }

    /// Lets a resource wait until a time.
    fn waits(&mut self, resource: usize, to: i64) {
        let (from, state) = (self.free[resource].actual, self.states[resource]);
        if from < to && !self.layout.resources[resource].states[state].may_wait {
            self.overruns.push(Overrun {
                resource,
                state,
                from,
                to,
            });
        }
    }
}
