//! Counters of a run: parts, products and their times.

use super::part::Part;
use crate::statistics::{Level, Profile, Times};
use crate::trace::Yields;
use linewright_language::contract::line::Line;

/// Maximum number of observations that are stored to find a warm-up.
const MAX_OBSERVATIONS: usize = 1 << 20;

/// The counters of one run.
#[derive(Debug)]
pub(super) struct Counters {
    /// Number of complete end products, in a sink or in a store.
    pub products: u64,
    /// Number of `products` that are in a store.
    pub stored: u64,
    /// Time at which the last end product was complete, in seconds.
    pub makespan: f64,
    /// Lead times of the end products.
    pub lead_times: Times,
    /// By type, if there are several types of end products: its lead times. Empty otherwise.
    pub by_type: Vec<(usize, Times)>,
    /// Completion and lead time of each end product, in seconds, up to [`MAX_OBSERVATIONS`]; `None`
    /// if they are not wanted.
    pub observations: Option<Vec<(f64, f64)>>,
    /// Number of parts that have entered the line.
    pub entered: u64,
    /// Number of parts that have left the line as finished.
    pub finished: u64,
    /// By type: single parts in the parts of this type that have left the line.
    pub yields: Vec<Yields>,
    /// Number of parts that were joined to others.
    pub consumed: u64,
    /// Number of parts that were in the line when counting began.
    pub before: u64,
    /// Number of parts in the line: those that have entered and not left.
    pub units: Level,
    /// The same over time.
    pub units_over_time: Profile,
    /// Sum over the parts that have left the line of the time that they spent there while it was
    /// counted, in seconds.
    pub unit_seconds: f64,
    /// By type: number of parts that were made or given out and have not left the line, whether
    /// separate or joined to others.
    pub in_line: Vec<u64>,
    /// By type: number of rejected parts, and number of parts ordered to replace them.
    pub rejects: Vec<(u64, u64)>,
}

impl Counters {
    /// Creates counters, all 0. `seed` seeds the sample of lead times.
    pub(super) fn new(line: &Line, seed: u64) -> Self {
        let types = line.parts.len();
        let several = line.only_product().is_none();
        let by_type = line.products.iter().filter(|_| several);
        Self {
            by_type: by_type.map(|part| (*part, Times::new(seed))).collect(),
            products: 0,
            stored: 0,
            makespan: 0.0,
            lead_times: Times::new(seed),
            observations: None,
            entered: 0,
            finished: 0,
            yields: vec![Yields::default(); types],
            consumed: 0,
            before: 0,
            units: Level::new(u32::MAX),
            units_over_time: Profile::default(),
            unit_seconds: 0.0,
            in_line: vec![0; types],
            rejects: vec![(0, 0); types],
        }
    }

    /// Forgets what has been counted, but not which parts are in the line. `seed` seeds the sample
    /// of lead times.
    pub(super) fn forget(&mut self, line: &Line, now: f64, seed: u64) {
        self.units_over_time.forget(now, &self.units);
        self.units.forget(now);
        *self = Self {
            before: u64::from(self.units.level()),
            units: self.units.clone(),
            units_over_time: std::mem::take(&mut self.units_over_time),
            in_line: std::mem::take(&mut self.in_line),
            observations: self.observations.take(),
            ..Self::new(line, seed)
        };
    }

    /// Counts a part that comes into the line.
    pub(super) fn unit_enters(&mut self, now: f64) {
        self.entered += 1;
        self.units_over_time.advance(now, &self.units);
        self.units.increase(now);
    }

    /// Counts a part that leaves the line, and that has been in it since `since`. Counting began at
    /// `start`.
    pub(super) fn unit_leaves(&mut self, now: f64, since: f64, start: f64) {
        self.units_over_time.advance(now, &self.units);
        self.units.decrease(now);
        self.unit_seconds += now - since.max(start);
    }

    /// Counts an end product that is complete at `now`. `stored` states whether it is in a store.
    pub(super) fn count_product(&mut self, now: f64, product: &Part, stored: bool) {
        let seconds = now - product.entered_at;
        self.products += 1;
        self.stored += u64::from(stored);
        self.makespan = now;
        self.lead_times.add(seconds);
        let mut by_type = self.by_type.iter_mut();
        if let Some((_, lead_times)) = by_type.find(|(kind, _)| *kind == product.kind) {
            lead_times.add(seconds);
        }
        if let Some(observations) = &mut self.observations
            && observations.len() < MAX_OBSERVATIONS
        {
            observations.push((now, seconds));
        }
    }
}
