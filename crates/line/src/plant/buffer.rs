//! Buffers: room for parts that wait.
//!
//! A part rests in its buffer for the dwell time, if there is one, and then is ready to leave. The
//! order of the buffer is that of the parts that are ready.

use super::part::{Part, PartIndex};
use super::{Event, Place, Run, WORK};
use crate::calls::Real;
use crate::sampler::Sampler;
use crate::statistics::{Level, Times, Waits};
use crate::trace::Percentiles;
use linewright_language::contract::line::BufferOrder;
use std::collections::{BTreeMap, VecDeque};

/// State of a buffer.
///
/// In the order of declaration: what every part needs comes first, so that a line of many buffers
/// stays in the processor's cache.
#[derive(Debug)]
#[repr(C)]
pub(super) struct Buffer {
    capacity: u32,
    /// Whether parts are ready at once, leave in the order in which they came, and never expire.
    is_plain: bool,
    ready: Ready,
    pub level: Level,
    /// Waiting times of the parts that left, and of those that expired.
    pub waits: Waits,
    /// Waiting times for percentiles; `None` if no requirement speaks of one.
    sample: Option<Box<WaitSample>>,
    /// Number of parts that have come.
    came: i64,
    /// Sequence number of the request of a part that the next one has overtaken, and whose turn it
    /// takes.
    pub turn: Option<u64>,
    /// Parts that are not ready, by the time at which they will be.
    resting: BTreeMap<(Real, i64), (Rank, Waiting)>,
    order: BufferOrder,
    /// Draws the dwell times; `None` if there are none.
    dwell: Option<Sampler>,
    /// Maximum time of a part in the buffer, in seconds.
    shelf_life: Option<f64>,
    /// Parts in the order in which they expire. Some have left already.
    expiries: VecDeque<Expiry>,
    /// Number of parts that have expired.
    pub expired: u64,
    /// Time that the parts in the buffer had waited when counting began, in all, in seconds.
    waited_before: f64,
}

/// Waiting times for percentiles.
#[derive(Debug)]
struct WaitSample {
    /// Numbers of the percentiles.
    numbers: Vec<u8>,
    seed: u64,
    of_run: Times,
    of_batch: Times,
}

/// The lowest leaves first. The number decides between parts of the same rank.
type Rank = (Real, i64);

/// A part in a buffer.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    part: PartIndex,
    /// Time at which it came.
    since: f64,
    /// Its number among the parts that came.
    number: i64,
}

/// Parts that are ready to leave.
#[derive(Debug)]
enum Ready {
    /// The first to leave in front.
    Queue(VecDeque<Waiting>),
    /// By rank.
    Ranked(BTreeMap<Rank, Waiting>),
}

/// A part that expires.
#[derive(Debug)]
struct Expiry {
    time: f64,
    number: i64,
    rank: Rank,
    ready_at: f64,
}

/// What follows from the arrival of a part.
pub(super) struct Arrival {
    /// Whether it will be the next to leave.
    pub is_next: bool,
    /// Time at which it is ready to leave, if that is not now.
    pub ready_at: Option<f64>,
    /// Time at which it expires.
    pub expires_at: Option<f64>,
}

impl Buffer {
    pub(super) fn new(capacity: u32, order: &BufferOrder) -> Self {
        Self {
            capacity,
            order: order.clone(),
            is_plain: matches!(order, BufferOrder::FirstIn),
            ready: match order {
                BufferOrder::FirstIn => Ready::Queue(VecDeque::new()),
                _ => Ready::Ranked(BTreeMap::new()),
            },
            came: 0,
            sample: None,
            dwell: None,
            resting: BTreeMap::new(),
            shelf_life: None,
            expiries: VecDeque::new(),
            turn: None,
            level: Level::new(capacity),
            waits: Waits::default(),
            expired: 0,
            waited_before: 0.0,
        }
    }

    /// Lets each part rest for a time that is drawn.
    pub(super) fn with_dwell(self, dwell: Option<Sampler>) -> Self {
        Self {
            is_plain: self.is_plain && dwell.is_none(),
            dwell,
            ..self
        }
    }

    /// Keeps waiting times for the percentiles with these numbers. `seed` seeds the sample.
    pub(super) fn with_percentiles(self, numbers: Vec<u8>, seed: u64) -> Self {
        let sample = (!numbers.is_empty()).then(|| WaitSample {
            numbers,
            seed,
            of_run: Times::new(seed),
            of_batch: Times::new(seed),
        });
        Self {
            sample: sample.map(Box::new),
            ..self
        }
    }

    /// Lets each part expire after these seconds.
    pub(super) fn with_shelf_life(self, shelf_life: Option<f64>) -> Self {
        Self {
            is_plain: self.is_plain && shelf_life.is_none(),
            shelf_life,
            ..self
        }
    }

    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        let ready = match &self.ready {
            Ready::Queue(queue) => queue.len(),
            Ready::Ranked(ranked) => ranked.len(),
        };
        ready + self.resting.len()
    }

    /// Whether there is room for another part.
    #[inline]
    pub(super) fn has_room(&self) -> bool {
        self.level.level() < self.capacity
    }

    /// Whether parts expire.
    pub(super) fn has_shelf_life(&self) -> bool {
        self.shelf_life.is_some()
    }

    /// Whether a part that comes could leave before one that waits.
    pub(super) fn ranks_newcomers(&self) -> bool {
        self.has_room() && matches!(self.ready, Ready::Ranked(_))
    }

    /// Whether a part that still rests could leave before one that waits.
    pub(super) fn ranks_resting(&self) -> bool {
        !self.resting.is_empty() && matches!(self.ready, Ready::Ranked(_))
    }

    /// The part that leaves next.
    #[inline]
    pub(super) fn first(&self) -> Option<PartIndex> {
        match &self.ready {
            Ready::Queue(queue) => queue.front().map(|waiting| waiting.part),
            Ready::Ranked(ranked) => first(ranked),
        }
    }

    pub(super) fn parts(&self) -> Box<dyn Iterator<Item = PartIndex> + '_> {
        let resting = self.resting.values().map(|(_, waiting)| waiting.part);
        match &self.ready {
            Ready::Queue(queue) => Box::new(queue.iter().map(|w| w.part).chain(resting)),
            Ready::Ranked(ranked) => Box::new(ranked.values().map(|w| w.part).chain(resting)),
        }
    }

    /// Whether parts are ready at once, leave in the order in which they came, and never expire.
    #[inline]
    pub(super) fn is_plain(&self) -> bool {
        self.is_plain
    }

    /// A part comes to a plain buffer. Returns whether it will be the next to leave.
    #[inline]
    pub(super) fn put(&mut self, part: PartIndex, now: f64) -> bool {
        let waiting = self.admit(part, now);
        match &mut self.ready {
            Ready::Queue(queue) => {
                queue.push_back(waiting);
                queue.len() == 1
            }
            Ready::Ranked(_) => unreachable!("the buffer ranks its parts; please report this"),
        }
    }

    /// Counts a part that comes.
    #[inline]
    fn admit(&mut self, part: PartIndex, now: f64) -> Waiting {
        self.came += 1;
        self.level.increase(now);
        Waiting {
            part,
            since: now,
            number: self.came,
        }
    }

    /// A part comes to a buffer of any kind.
    fn put_ranked(&mut self, index: PartIndex, part: &Part, now: f64) -> Arrival {
        let waiting = self.admit(index, now);
        let rank = self.rank(part);
        let dwell = self.dwell.as_mut().map_or(0.0, Sampler::draw);
        let ready_at = now + dwell;
        let expires_at = self.shelf_life.map(|seconds| now + seconds);
        self.expiries.extend(expires_at.map(|time| Expiry {
            time,
            number: self.came,
            rank,
            ready_at,
        }));
        if dwell > 0.0 {
            self.resting
                .insert((Real(ready_at), self.came), (rank, waiting));
        } else {
            self.make_ready(rank, waiting);
        }
        Arrival {
            is_next: dwell <= 0.0 && self.first() == Some(waiting.part),
            ready_at: (dwell > 0.0).then_some(ready_at),
            expires_at,
        }
    }

    fn rank(&self, part: &Part) -> Rank {
        let (value, number) = match &self.order {
            BufferOrder::FirstIn => (0.0, self.came),
            BufferOrder::LastIn => (0.0, -self.came),
            BufferOrder::Property { highest, of } => {
                let value = of[part.kind].and_then(|property| part.properties.get(property));
                let value = value.copied().unwrap_or(0.0);
                (if *highest { -value } else { value }, self.came)
            }
        };
        // The sum makes -0 and 0 equal.
        (Real(value + 0.0), number)
    }

    fn make_ready(&mut self, rank: Rank, waiting: Waiting) {
        match &mut self.ready {
            Ready::Queue(queue) => queue.push_back(waiting),
            Ready::Ranked(ranked) => {
                ranked.insert(rank, waiting);
            }
        }
    }

    /// The next part has rested long enough at `now`. Returns whether it will be the next to leave;
    /// `None` if there is no such part, because it has expired.
    fn end_rest(&mut self, now: f64) -> Option<bool> {
        let first = self.resting.first_entry()?;
        if first.key().0.0 > now {
            return None;
        }
        let (rank, waiting) = first.remove();
        self.make_ready(rank, waiting);
        Some(self.first() == Some(waiting.part))
    }

    /// The first part leaves.
    #[inline]
    pub(super) fn take(&mut self, now: f64) {
        let since = match &mut self.ready {
            Ready::Queue(queue) => queue.pop_front().map(|taken| taken.since),
            Ready::Ranked(ranked) => pop_first(ranked).map(|taken| taken.since),
        };
        if let Some(since) = since {
            self.turn = None;
            self.count_out(now, since);
        }
    }

    /// Counts a part that leaves or expires, and that came at `since`.
    #[inline]
    fn count_out(&mut self, now: f64, since: f64) {
        self.level.decrease(now);
        self.waits.add(now - since);
        if let Some(sample) = &mut self.sample {
            sample.of_run.add(now - since);
            sample.of_batch.add(now - since);
        }
    }

    /// Number of parts that have left without those that have expired.
    pub(super) fn passed(&self) -> u64 {
        self.waits.count - self.expired
    }

    /// Time that the parts in the buffer have waited so far, in all, in seconds.
    fn waiting_seconds(&self, now: f64) -> f64 {
        let resting = self
            .resting
            .values()
            .map(|(_, waiting)| now - waiting.since);
        let ready: f64 = match &self.ready {
            Ready::Queue(queue) => queue.iter().map(|waiting| now - waiting.since).sum(),
            Ready::Ranked(ranked) => ranked.values().map(|waiting| now - waiting.since).sum(),
        };
        ready + resting.sum::<f64>()
    }

    /// The two sides of Little's law: the integral of the number of parts up to `now`, and the time
    /// that all parts have waited since counting began, in seconds.
    pub(super) fn littles_law(&mut self, now: f64) -> (f64, f64) {
        self.level.advance(now);
        let waited = self.waits.sum() + self.waiting_seconds(now) - self.waited_before;
        (self.level.area(), waited)
    }

    /// Removes the part that expires at `now`. Returns it, and whether it was the next to leave;
    /// `None` if it has left already.
    fn expire(&mut self, now: f64) -> Option<(PartIndex, bool)> {
        if self.expiries.front()?.time > now {
            return None;
        }
        let expiry = self.expiries.pop_front()?;
        let first = self.first();
        let resting = self.resting.remove(&(Real(expiry.ready_at), expiry.number));
        let found = resting.map(|(_, waiting)| waiting);
        let found = found.or_else(|| match &mut self.ready {
            Ready::Queue(queue) => {
                let at = queue.iter().position(|w| w.number == expiry.number)?;
                queue.remove(at)
            }
            Ready::Ranked(ranked) => ranked.remove(&expiry.rank),
        });
        let Waiting { part, since, .. } = found?;
        self.count_out(now, since);
        self.expired += 1;
        Some((part, first == Some(part)))
    }

    /// Percentiles of the waiting times since counting began.
    pub(super) fn wait_percentiles(&mut self) -> Percentiles {
        let sample = self.sample.as_mut();
        sample.map_or_else(Percentiles::default, |sample| {
            sample.of_run.percentiles(&sample.numbers)
        })
    }

    /// Percentiles of the waiting times in the batch that ends.
    pub(super) fn end_batch(&mut self) -> Percentiles {
        let sample = self.sample.as_mut();
        sample.map_or_else(Percentiles::default, |sample| {
            let percentiles = sample.of_batch.percentiles(&sample.numbers);
            sample.of_batch = Times::new(sample.seed);
            percentiles
        })
    }

    /// Forgets what has been counted.
    pub(super) fn forget(&mut self, now: f64) {
        if let Some(sample) = &mut self.sample {
            sample.of_run = Times::new(sample.seed);
            sample.of_batch = Times::new(sample.seed);
        }
        self.level.forget(now);
        self.waits = Waits::default();
        self.waited_before = self.waiting_seconds(now);
        self.expired = 0;
    }
}

#[inline(never)]
fn first(ranked: &BTreeMap<Rank, Waiting>) -> Option<PartIndex> {
    ranked.first_key_value().map(|(_, waiting)| waiting.part)
}

#[inline(never)]
fn pop_first(ranked: &mut BTreeMap<Rank, Waiting>) -> Option<Waiting> {
    ranked.pop_first().map(|(_, taken)| taken)
}

impl Run<'_> {
    fn buffer(&mut self, node: usize) -> &mut Buffer {
        match &mut self.nodes[node].place {
            Place::Buffer(buffer) => buffer,
            _ => unreachable!("node {node} is not a buffer; please report this"),
        }
    }

    /// A part comes to a buffer that is not plain.
    #[inline(never)]
    pub(super) fn buffer_arrival(&mut self, node: usize, part: PartIndex) {
        let now = self.now;
        let arrival = match &mut self.nodes[node].place {
            Place::Buffer(buffer) => buffer.put_ranked(part, &self.parts[part], now),
            _ => unreachable!("node {node} is not a buffer; please report this"),
        };
        if let Some(time) = arrival.ready_at {
            self.schedule(time, WORK, Event::Rested(node as u32));
        }
        if let Some(time) = arrival.expires_at {
            self.schedule(time, WORK, Event::Expiry(node as u32));
        }
        if arrival.is_next {
            self.overtake(node);
        }
    }

    /// A part has rested long enough in its buffer.
    pub(super) fn rested(&mut self, node: usize) {
        let now = self.now;
        match self.buffer(node).end_rest(now) {
            Some(true) => self.overtake(node),
            Some(false) => {}
            None => self.progress.skip_event(),
        }
    }

    /// A part expires, and leaves the line as scrap.
    pub(super) fn expire(&mut self, node: usize) {
        let now = self.now;
        let Some((part, was_next)) = self.buffer(node).expire(now) else {
            self.progress.skip_event();
            return;
        };
        if was_next {
            self.overtake(node);
            // The next part does not take the turn of one that is gone.
            self.buffer(node).turn = None;
        }
        self.scrap(node, part);
        self.look_at(node);
    }
}
