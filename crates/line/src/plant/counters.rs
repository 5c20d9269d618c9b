//! What a run counts: parts, products and their times.

use crate::statistics::LeadTimes;

/// The counters of one run.
#[derive(Debug)]
pub(super) struct Counters {
    /// End products that are complete, in a sink or in a store.
    pub products: u64,
    /// Those of them that lie in a store.
    pub stored: u64,
    /// When the last end product was complete, in seconds.
    pub makespan: f64,
    /// The lead times of the end products.
    pub lead_times: LeadTimes,
    /// Parts that have entered the line.
    pub entered: u64,
    /// Parts that have left the line as they should.
    pub finished: u64,
    /// Parts that were joined to others.
    pub consumed: u64,
    /// By type: how many have been made or given out and have not left the line, by themselves or
    /// joined to others.
    pub in_line: Vec<u64>,
    /// By type: how many were rejected, and how many were ordered again for them.
    pub rejects: Vec<(u64, u64)>,
}

impl Counters {
    /// Nothing counted yet, for this many part types. `seed` draws the sample of lead times.
    pub(super) fn new(types: usize, seed: u64) -> Self {
        Self {
            products: 0,
            stored: 0,
            makespan: 0.0,
            lead_times: LeadTimes::new(seed),
            entered: 0,
            finished: 0,
            consumed: 0,
            in_line: vec![0; types],
            rejects: vec![(0, 0); types],
        }
    }

    /// An end product that entered at `birth` is complete at `now`; `stored` if it lies in a store.
    pub(super) fn count_product(&mut self, now: f64, birth: f64, stored: bool) {
        self.products += 1;
        self.stored += u64::from(stored);
        self.makespan = now;
        self.lead_times.add(now - birth);
    }
}
