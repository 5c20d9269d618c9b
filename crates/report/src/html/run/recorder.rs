//! Gathers what a page shows of a run over time, while the run goes on.

use super::series::{CURVE, Curve, Histogram, Steps, Sums};
use linewright_language::contract::line::{Line, NodeKind};
use linewright_line::log::{Activity, EventKind, LogEntry, Moment, Observer, Other};
use linewright_line::trace::{End, Violation};
use std::collections::{BTreeMap, HashMap};

/// Maximum number of movements that the animation shows. Later ones are left out.
const MAX_MOVES: usize = 250_000;

/// Maximum number of changes of state that the chart of the stations shows, over all stations.
/// After them, it shows the share of each state in bins of time.
const MAX_CHANGES: usize = 600_000;

/// Maximum number of refusals that the chart of the stations marks. Later ones are left out.
const MAX_REFUSALS: usize = 100_000;

/// What happens to a part in the animation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Move {
    /// In seconds.
    pub time: f64,
    /// Number of the part.
    pub part: u64,
    /// Type of the part, if it enters the line here.
    pub enters: Option<usize>,
    pub to: Target,
}

/// Where a part goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    Node(usize),
    /// It is seen at this place of the belt on which it is.
    Place(u32),
    Finished,
    Rejected,
    /// It becomes a component of another part.
    Joined,
}

/// Parts of one type while figures count: `before + entered` is the sum of the others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Balance {
    /// Parts that were in the line when counting began.
    pub before: u64,
    pub entered: u64,
    pub finished: u64,
    /// Parts that came into a sink for rejects.
    pub rejected: u64,
    /// Parts that were taken out anywhere else: scrapped by a failure, expired, or refused.
    pub scrapped: u64,
    /// Parts that were joined into others.
    pub joined: u64,
    /// Parts that were in the line at the end.
    pub remaining: u64,
}

/// Records one run for a page. Needs memory for the parts in the line, for curves of a few hundred
/// points, and for the movements and changes of state that a page shows, whose number is bounded.
#[derive(Debug)]
pub struct Recorder {
    /// By node: its changes of state.
    pub(super) states: Vec<Vec<(f64, Activity)>>,
    changes: usize,
    /// Time from which on changes of state were left out, in seconds.
    pub(super) states_end: Option<f64>,
    /// By node: its state, and since when.
    current: Vec<Option<(f64, Activity)>>,
    /// By node: from the end of the changes on, seconds in each state.
    later: Vec<[Sums; 7]>,
    pub(super) moves: Vec<Move>,
    /// Time from which on movements were left out, in seconds.
    pub(super) moves_end: Option<f64>,
    units: Steps,
    /// By part type: the number of parts in the line.
    units_by_type: Vec<Steps>,
    /// Type of each part in the line.
    types: HashMap<u64, usize>,
    /// End products that were finished.
    finished: Sums,
    /// By node: whether a part has ever come.
    visited: Vec<bool>,
    /// By node: the number of parts, if it is a buffer.
    buffers: Vec<Option<Steps>>,
    /// Whether the parts of a type are end products.
    is_product: Vec<bool>,
    pub(super) lead_times: Histogram,
    /// For each part in the line, when it or the oldest component in it entered.
    entered: HashMap<u64, f64>,
    /// For each part that is being joined, when the oldest component so far entered.
    joined: HashMap<u64, f64>,
    /// By pair of nodes: number of parts of each type that went from one to the other.
    pub(super) flow: BTreeMap<(usize, usize), Vec<u64>>,
    /// By node that is no sink: number of parts of each type that were taken out there.
    pub(super) scrapped: BTreeMap<usize, Vec<u64>>,
    /// By part type.
    balance: Vec<Balance>,
    /// By node: the times at which its controller refused something, in seconds.
    pub(super) refusals: Vec<Vec<f64>>,
    refusal_count: usize,
    /// By node: number of parts that its controller refused while figures count.
    pub(super) refused: Vec<u64>,
    is_sink: Vec<bool>,
    /// By node: joules by state; those of conveyors count as busy.
    pub(super) joules: Vec<[f64; 7]>,
    power: Sums,
    /// By node: time of its last entry with joules, and its state.
    last: Vec<(f64, Activity)>,
    /// Time from which on the figures count, and end of the run, in seconds.
    pub(super) counting: f64,
    pub(super) end: f64,
}

impl Recorder {
    /// Creates a recorder for one run of a line.
    pub fn new(line: &Line) -> Self {
        let nodes = line.nodes.len();
        let is_buffer = |kind: &NodeKind| matches!(kind, NodeKind::Buffer { .. });
        let is_sink = |kind: &NodeKind| matches!(kind, NodeKind::Sink { .. });
        let buffers = line.nodes.iter();
        let buffers = buffers.map(|node| is_buffer(&node.kind).then(Steps::new));
        let types = 0..line.parts.len();
        Self {
            states: vec![Vec::new(); nodes],
            changes: 0,
            states_end: None,
            current: vec![None; nodes],
            later: vec![std::array::from_fn(|_| Sums::new()); nodes],
            moves: Vec::new(),
            moves_end: None,
            units: Steps::new(),
            units_by_type: vec![Steps::new(); line.parts.len()],
            types: HashMap::new(),
            finished: Sums::new(),
            visited: vec![false; nodes],
            buffers: buffers.collect(),
            is_product: types.map(|part| line.is_product(part)).collect(),
            lead_times: Histogram::new(),
            entered: HashMap::new(),
            joined: HashMap::new(),
            flow: BTreeMap::new(),
            scrapped: BTreeMap::new(),
            balance: vec![Balance::default(); line.parts.len()],
            refusals: vec![Vec::new(); nodes],
            refusal_count: 0,
            refused: vec![0; nodes],
            is_sink: line.nodes.iter().map(|node| is_sink(&node.kind)).collect(),
            joules: vec![[0.0; 7]; nodes],
            power: Sums::new(),
            last: vec![(0.0, Activity::Busy); nodes],
            counting: 0.0,
            end: 0.0,
        }
    }

    /// Number of parts in the line over time.
    pub(super) fn units(&self) -> Curve {
        self.units.clone().until(self.end)
    }

    /// Number of parts of a type in the line over time.
    pub(super) fn units_of(&self, kind: usize) -> Curve {
        self.units_by_type[kind].clone().until(self.end)
    }

    /// End products an hour in each bin of time, and the width of a bin in seconds. The last one
    /// goes up to the end. What is left there and is less than half as wide is part of the bin
    /// before it: a product more or less would look like a burst.
    pub(super) fn throughput(&self) -> (Vec<f64>, f64) {
        /// Maximum number of bins: a product that is finished must not look like a burst.
        const BINS: usize = 48;
        let (sums, width) = self.finished.clone().until(self.end, BINS);
        let per_hour = |products: f64, seconds: f64| {
            if seconds > 0.0 {
                products * 3600.0 / seconds
            } else {
                0.0
            }
        };
        let length = |bin: usize| (self.end - bin as f64 * width).min(width);
        let mut bins: Vec<f64> = sums
            .iter()
            .enumerate()
            .map(|(bin, products)| per_hour(*products, length(bin)))
            .collect();
        if let [.., before, last] = sums[..]
            && length(sums.len() - 1) < width / 2.0
        {
            bins.truncate(sums.len() - 2);
            let start = bins.len() as f64 * width;
            bins.push(per_hour(before + last, self.end - start));
        }
        (bins, width)
    }

    /// The state as which a station's waiting for parts is shown: idle if no part ever came.
    pub(super) fn waiting(&self, node: usize) -> Activity {
        if self.visited[node] {
            Activity::Starved
        } else {
            Activity::Idle
        }
    }

    /// Number of parts in a buffer over time; `None` if the node is no buffer.
    pub(super) fn buffer(&self, node: usize) -> Option<Curve> {
        let steps = self.buffers.get(node)?.clone()?;
        Some(steps.until(self.end))
    }

    /// Mean power in each bin of time in watts, and the width of a bin in seconds.
    pub(super) fn power(&self) -> (Vec<f64>, f64) {
        let (sums, width) = self.power.clone().until(self.end, CURVE);
        let bins = sums.iter().enumerate();
        let watts = bins.map(|(bin, joules)| {
            let seconds = (self.end - bin as f64 * width).min(width);
            if seconds > 0.0 { joules / seconds } else { 0.0 }
        });
        (watts.collect(), width)
    }

    /// Number of parts of each type that went from one node to another.
    pub(super) fn flow(&self, from: usize, to: usize) -> &[u64] {
        self.flow.get(&(from, to)).map_or(&[], Vec::as_slice)
    }

    /// Whether there were more refusals than are marked.
    pub(super) fn has_more_refusals(&self) -> bool {
        self.refusal_count >= MAX_REFUSALS
    }

    /// What became of the parts of a type.
    pub(super) fn balance(&self, kind: usize) -> Balance {
        let remaining = self.types.values().filter(|of| **of == kind).count() as u64;
        Balance {
            remaining,
            ..self.balance[kind]
        }
    }

    /// For the time after the changes of state that were recorded: the seconds in each state in
    /// each bin of time from 0 on, and the width of a bin in seconds; `None` if all were recorded.
    pub(super) fn later_states(&self, node: usize) -> Option<(Vec<[f64; 7]>, f64)> {
        self.states_end?;
        let mut bins = Vec::new();
        let mut width = 0.0;
        for (state, sums) in self.later[node].iter().enumerate() {
            let (seconds, of_state) = sums.clone().until(self.end, CURVE);
            bins.resize(seconds.len(), [0.0; 7]);
            for (bin, seconds) in bins.iter_mut().zip(seconds) {
                bin[state] = seconds;
            }
            width = of_state;
        }
        Some((bins, width))
    }

    /// Counts the time of a node in its state up to `time`, if its changes are not recorded any
    /// more.
    fn count_later_state(&mut self, time: f64, node: usize) {
        if let (Some(from), Some((since, state))) = (self.states_end, self.current[node]) {
            let since = since.max(from);
            self.later[node][state as usize].spread(since, time, (time - since).max(0.0));
        }
    }

    fn change_state(&mut self, time: f64, node: usize, state: Activity) {
        self.count_later_state(time, node);
        self.current[node] = Some((time, state));
        self.last[node].1 = state;
        let known = self.states[node].last();
        if known.is_some_and(|(_, last)| *last == state) {
            return;
        }
        if self.changes < MAX_CHANGES {
            self.changes += 1;
            // A state that lasted no time is not seen.
            match self.states[node].last_mut() {
                Some(last) if last.0 >= time => last.1 = state,
                _ => self.states[node].push((time, state)),
            }
        } else {
            self.states_end.get_or_insert(time);
        }
    }

    fn moved(&mut self, time: f64, part: u64, enters: Option<usize>, to: Target) {
        if self.moves_end.is_none() && self.moves.len() >= MAX_MOVES {
            self.moves_end = Some(time);
        }
        if self.moves_end.is_none() {
            self.moves.push(Move {
                time,
                part,
                enters,
                to,
            });
        }
    }

    fn uses(&mut self, time: f64, node: usize, joules: f64) {
        let (since, state) = &mut self.last[node];
        self.joules[node][*state as usize] += joules;
        self.power.spread(*since, time, joules);
        *since = time;
    }

    fn changes_buffer(&mut self, time: f64, node: usize, change: i64) {
        if let Some(steps) = self.buffers.get_mut(node).and_then(Option::as_mut) {
            steps.add(time, change);
        }
    }

    fn leaves_line(&mut self, time: f64, part: u64, to: Target) {
        self.units.add(time, -1);
        if let Some(kind) = self.types.remove(&part) {
            self.units_by_type[kind].add(time, -1);
        }
        self.moved(time, part, None, to);
    }

    fn record_part(&mut self, entry: &LogEntry, part: u64, kind: usize) {
        let LogEntry { time, node, .. } = *entry;
        match entry.what {
            EventKind::Entered => {
                self.balance[kind].entered += 1;
                let since = self.joined.remove(&part).unwrap_or(time);
                self.entered.insert(part, since);
                self.units.add(time, 1);
                self.units_by_type[kind].add(time, 1);
                self.types.insert(part, kind);
                self.moved(time, part, Some(kind), Target::Node(node));
            }
            EventKind::Arrived => {
                self.visited[node] = true;
                self.changes_buffer(time, node, 1);
            }
            EventKind::Left => {
                self.changes_buffer(time, node, -1);
                if let Some(Other::Node(to)) = entry.other {
                    let types = self.balance.len();
                    let flow = self.flow.entry((node, to));
                    flow.or_insert_with(|| vec![0; types])[kind] += 1;
                    self.moved(time, part, None, Target::Node(to));
                }
            }
            EventKind::Place(place) => self.moved(time, part, None, Target::Place(place)),
            EventKind::Consumed => {
                self.balance[kind].joined += 1;
                let since = self.entered.remove(&part).unwrap_or(time);
                if let Some(Other::Part(whole)) = entry.other {
                    let oldest = self.joined.entry(whole).or_insert(since);
                    *oldest = oldest.min(since);
                }
                self.leaves_line(time, part, Target::Joined);
            }
            EventKind::Finished => {
                self.balance[kind].finished += 1;
                let since = self.entered.remove(&part).unwrap_or(time);
                if self.is_product[kind] {
                    self.lead_times.add(time - since);
                    self.finished.spread(time, time, 1.0);
                }
                self.leaves_line(time, part, Target::Finished);
            }
            EventKind::Rejected => {
                if self.is_sink[node] {
                    self.balance[kind].rejected += 1;
                } else {
                    self.balance[kind].scrapped += 1;
                    let types = self.balance.len();
                    let scrapped = self.scrapped.entry(node);
                    scrapped.or_insert_with(|| vec![0; types])[kind] += 1;
                }
                self.entered.remove(&part);
                self.changes_buffer(time, node, -1);
                self.leaves_line(time, part, Target::Rejected);
            }
            _ => {}
        }
    }
}

impl Observer for Recorder {
    fn record(&mut self, entry: &LogEntry) {
        // Energy is used in the state that ends with this entry.
        if let Some(joules) = entry.joules {
            self.uses(entry.time, entry.node, joules);
        }
        if let EventKind::State(state) = entry.what {
            self.change_state(entry.time, entry.node, state);
        }
        if let Some((part, kind)) = entry.part {
            self.record_part(entry, part, kind);
        }
    }

    fn record_violation(&mut self, violation: &Violation) {
        self.refused[violation.node] += u64::from(violation.part.is_some());
        let refusals = &mut self.refusals[violation.node];
        if self.refusal_count < MAX_REFUSALS && refusals.last() != Some(&violation.time) {
            refusals.push(violation.time);
            self.refusal_count += 1;
        }
    }

    fn begin_counting(&mut self, moment: Moment) {
        self.counting = moment.time;
        self.lead_times = Histogram::new();
        self.flow.clear();
        self.scrapped.clear();
        self.refused.fill(0);
        self.balance.fill(Balance::default());
        for kind in self.types.values() {
            self.balance[*kind].before += 1;
        }
        for joules in &mut self.joules {
            *joules = [0.0; 7];
        }
    }

    fn end(&mut self, moment: Moment, _end: End) {
        self.end = moment.time;
        for node in 0..self.current.len() {
            self.count_later_state(moment.time, node);
        }
    }
}
