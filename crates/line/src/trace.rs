//! What a run was: the narrow waist between the runner and everything that shows or checks a run.

use linewright_core::diagnostics::Diagnostic;
use linewright_station::ErrorCode;

/// What happened in one run of a line.
#[derive(Debug, Clone)]
pub struct Trace {
    /// The seed.
    pub seed: u64,
    /// Why it ended.
    pub end: End,
    /// Simulated seconds from the start to the end.
    pub seconds: f64,
    /// Events that were taken from the calendar.
    pub events: u64,
    /// End products in a sink that does not reject, or in a store.
    pub products: u64,
    /// Those of them that are in a store.
    pub stored: u64,
    /// The time of the last end product; 0 where there is none.
    pub makespan: f64,
    /// End products an hour of simulated time.
    pub throughput_per_hour: f64,
    /// Mobile units of all types.
    pub parts: PartCounts,
    /// From a product's first part to its end.
    pub lead_time: LeadTime,
    /// Joules of all stations and conveyors.
    pub joules: f64,
    /// One entry a station, in the line's order.
    pub stations: Vec<StationStatistics>,
    /// One entry a conveyor, in the line's order.
    pub conveyors: Vec<ConveyorStatistics>,
    /// One entry a machine, in the order of its first instance.
    pub machines: Vec<MachineStatistics>,
    /// The station (an index into `stations`) with the greatest share of busy, setup and failed
    /// time.
    pub bottleneck: Option<usize>,
    /// Rejected parts by type, in the line's order; types without any are left out.
    pub rejects: Vec<Reject>,
    /// The first [`MAX_VIOLATIONS`] violations, in the order of time.
    pub violations: Vec<Violation>,
    /// How many there were in all.
    pub violation_count: u64,
    /// The line's requirements, checked; none of a run that was cut off (`End::GaveUp`).
    pub requirements: Vec<RequirementResult>,
    /// Everything that went wrong, as findings.
    pub findings: Vec<Diagnostic>,
    /// Every movement, where [`Options::log`](super::Options::log) asks for it.
    pub log: Vec<LogEntry>,
}

/// So many violations are kept one by one; later ones are only counted.
pub const MAX_VIOLATIONS: usize = 1000;

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum End {
    /// The products that were wanted are made.
    Products,
    /// The time is over.
    Time,
    /// The line can no longer advance, or makes no progress.
    Blocked,
    /// A conveyor's controller lost or doubled a part.
    PartLost,
    /// The deadline of the real clock was reached.
    GaveUp,
}

/// Mobile units of all types: `entered = finished + rejected + consumed + in_progress`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PartCounts {
    /// Left a source or a store's stock, or were made by joining.
    pub entered: u64,
    /// Came into a sink that does not reject, or into a store that nothing of their type leaves.
    pub finished: u64,
    /// Came into a rejecting sink, or were taken out because of a violation.
    pub rejected: u64,
    /// Were joined into another part.
    pub consumed: u64,
    /// Were in the line at the end.
    pub in_progress: u64,
}

/// Seconds from the moment at which the first of a product's parts entered the line to its end. All
/// 0 without products.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeadTime {
    /// The mean of all products.
    pub mean: f64,
    /// Half of the products took no longer (nearest rank; from a sample where there are very many).
    pub p50: f64,
    /// Ninety-five in a hundred took no longer, likewise.
    pub p95: f64,
    /// The longest of all.
    pub max: f64,
}

/// How a station spent its time: shares from 0 to 1 that sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shares {
    /// At work on a part.
    pub busy: f64,
    /// Free, but nothing to work on has come.
    pub starved: f64,
    /// Finished with a part that finds no room.
    pub blocked: f64,
    /// Broken down or under repair, off shift too.
    pub failed: f64,
    /// Off shift; all the waiting of a station that no part ever came to.
    pub idle: f64,
    /// Being set up for another part type.
    pub setup: f64,
}

impl Shares {
    /// The share in which the station held the line up by itself: busy, setup and failed.
    pub fn engaged(&self) -> f64 {
        self.busy + self.setup + self.failed
    }
}

/// A station's figures.
#[derive(Debug, Clone, PartialEq)]
pub struct StationStatistics {
    /// The node.
    pub node: usize,
    /// Its name.
    pub name: String,
    /// Its machine's name.
    pub machine: String,
    /// Parts whose service ended.
    pub processed: u64,
    /// How the time was spent.
    pub shares: Shares,
    /// Seconds at work.
    pub busy_seconds: f64,
    /// Joules: those of the services, and the idle power outside them.
    pub joules: f64,
}

/// A conveyor's figures.
#[derive(Debug, Clone, PartialEq)]
pub struct ConveyorStatistics {
    /// The node.
    pub node: usize,
    /// Its name.
    pub name: String,
    /// Its machine's name, where a contract moves it.
    pub machine: Option<String>,
    /// Parts that left it at its end.
    pub carried: u64,
    /// Seconds in which something moved on it.
    pub moving_seconds: f64,
    /// Joules.
    pub joules: f64,
}

/// The figures of all instances of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineStatistics {
    /// The machine's name.
    pub name: String,
    /// Seconds at work, of all its instances together.
    pub busy_seconds: f64,
    /// Joules of all its instances.
    pub joules: f64,
}

/// Rejected parts of one type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reject {
    /// The part type.
    pub part: usize,
    /// How many.
    pub count: u64,
    /// How many new ones were ordered for them.
    pub reordered: u64,
}

/// A rule that was broken while the line ran.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// When, in simulated seconds.
    pub time: f64,
    /// At which node.
    pub node: usize,
    /// The part that was worked on and its type; none for a conveyor.
    pub part: Option<(u64, usize)>,
    /// What the library answered.
    pub code: ErrorCode,
    /// The rule, component first: `turn: gripped`.
    pub rule: Option<String>,
    /// The library's whole text.
    pub message: String,
}

/// A requirement of the line and what it came to.
#[derive(Debug, Clone, PartialEq)]
pub struct RequirementResult {
    /// Its name.
    pub name: String,
    /// Whether it holds.
    pub holds: bool,
    /// What was measured, in the metric's unit; `None` where there was nothing to measure.
    pub value: Option<f64>,
}

/// One movement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogEntry {
    /// When.
    pub time: f64,
    /// At which node.
    pub node: usize,
    /// The part's number and type; none for breakdowns and repairs.
    pub part: Option<(u64, usize)>,
    /// What happened.
    pub what: What,
}

/// What happened to a part or node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum What {
    /// It entered the line here.
    Entered,
    /// It came to this node.
    Arrived,
    /// It became part of another one.
    Consumed,
    /// The station began to set up for it.
    SetupStarted,
    /// Its service began.
    Started,
    /// Its service ended.
    Ended,
    /// It left this node for the next.
    Left,
    /// It was seen on this place of the belt.
    Place(u32),
    /// It left the line as it should.
    Finished,
    /// It left the line as scrap.
    Rejected,
    /// The station broke down.
    Failed,
    /// The station was repaired.
    Repaired,
}

/// A time as hours, minutes and seconds: `1:05:09`.
pub fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}
