//! The result of a run: the only interface between the runner and everything that shows or checks a
//! run.

use super::batches::Batch;
use super::bottleneck::Bottleneck;
use super::requirement::Verdict;
use linewright_core::diagnostics::Diagnostic;
use linewright_language::contract::metric::Measure;
use linewright_station::ErrorCode;

/// The result of one run of a line.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Random seed.
    pub seed: u64,
    /// Why the run ended.
    pub end: End,
    /// Simulated seconds from start to end.
    pub seconds: f64,
    /// Number of events processed.
    pub events: u64,
    /// Number of end products in a sink that does not reject, or in a store.
    pub products: u64,
    /// Number of `products` that are in a store.
    pub stored: u64,
    /// Time of the last end product in seconds; 0 if there is none.
    pub makespan: f64,
    /// Simulated seconds at the beginning in which nothing was counted.
    pub warm_up: f64,
    /// Whether the warm-up was found by a pilot run.
    pub warm_up_found: bool,
    /// Number of end products after which the warm-up was to end; 0 if a time ended it.
    pub warm_up_products: u64,
    /// End products per hour of simulated time, after the warm-up.
    pub throughput_per_hour: f64,
    /// End products per hour of working time; `None` if the line has no calendar. Calendars of
    /// stations do not count.
    pub throughput_on_shift: Option<f64>,
    /// Number of parts in the line.
    pub wip: WorkInProgress,
    /// The same over time, from the start of the warm-up on; `None` for all replications but the
    /// first.
    pub wip_over_time: Option<OverTime>,
    /// Counts of mobile units of all types.
    pub parts: PartCounts,
    /// Time from the entry of a product's first part to the completion of the product.
    pub lead_time: LeadTime,
    /// Percentiles of the same that the requirements speak of.
    pub lead_time_percentiles: Percentiles,
    /// One entry for each type of end products, if there are several; empty otherwise.
    pub by_type: Vec<ProductStatistics>,
    /// Energy of all stations and conveyors in joules.
    pub joules: f64,
    /// One entry per station, in line order.
    pub stations: Vec<StationStatistics>,
    /// One entry per conveyor, in line order.
    pub conveyors: Vec<ConveyorStatistics>,
    /// One entry per buffer, in line order.
    pub buffers: Vec<BufferStatistics>,
    /// One entry per machine, in the order of their first instances.
    pub machines: Vec<MachineStatistics>,
    /// One entry per source, in line order.
    pub sources: Vec<SourceStatistics>,
    /// What limits the throughput.
    pub bottleneck: Bottleneck,
    /// Rejected parts by type, in line order; types without any are omitted.
    pub rejects: Vec<Reject>,
    /// First-pass yield and scrap of the line.
    pub yields: Yields,
    /// The same by the type of the part that left the line, in line order.
    pub yields_by_type: Vec<Yields>,
    /// The first [`MAX_VIOLATIONS`] violations, in time order.
    pub violations: Vec<Violation>,
    /// Total number of violations.
    pub violation_count: u64,
    /// Results of the line's requirements; empty for a run that was cut off (`End::GaveUp`).
    pub requirements: Vec<RequirementResult>,
    /// All problems, as findings.
    pub findings: Vec<Diagnostic>,
    /// The batches of the run, in order; empty if none were wanted, or if the run ended before the
    /// last one.
    pub batches: Vec<Batch>,
}

/// Maximum number of violations that are stored; later ones are only counted.
pub const MAX_VIOLATIONS: usize = 1000;

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum End {
    /// The requested number of products was made.
    Products,
    /// The end of the simulated time was reached.
    Time,
    /// The line can no longer advance.
    Blocked,
    /// The line makes no progress, although parts move.
    NoProgress,
    /// A conveyor's controller lost or doubled a part.
    PartLost,
    /// The wall-clock deadline was reached.
    GaveUp,
}

impl End {
    /// The word for it in documents and logs.
    pub fn word(self) -> &'static str {
        match self {
            Self::Products => "products",
            Self::Time => "time",
            Self::Blocked | Self::NoProgress => "blocked",
            Self::PartLost => "part_lost",
            Self::GaveUp => "gave_up",
        }
    }
}

/// Counts of mobile units of all types:
/// `before + entered = finished + rejected + consumed + in_progress`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PartCounts {
    /// Parts that were in the line when counting began: 0 without a warm-up.
    pub before: u64,
    /// Parts that left a source or a store's stock, or were made by joining.
    pub entered: u64,
    /// Parts that came into a sink that does not reject, or into a store that no part of their type
    /// leaves.
    pub finished: u64,
    /// Parts that came into a rejecting sink, or were taken out because of a violation.
    pub rejected: u64,
    /// Parts that were joined into another part.
    pub consumed: u64,
    /// Parts that were in the line at the end.
    pub in_progress: u64,
}

/// Number of mobile units in the line, over time: those that have entered and not left. A part that
/// waits in its source has not entered. Joined parts count as one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WorkInProgress {
    /// Mean over time.
    pub mean: f64,
    /// Maximum.
    pub max: u64,
}

/// A number over time: its mean in each of equal bins, at most some hundreds, from time 0 on.
#[derive(Debug, Clone, PartialEq)]
pub struct OverTime {
    /// Width of a bin in seconds. The last one may be cut off by the end of the run.
    pub bin_seconds: f64,
    /// Mean in each bin.
    pub means: Vec<f64>,
}

/// Seconds from the entry of a product's first part to the completion of the product. All 0 without
/// products.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeadTime {
    /// Mean over all products.
    pub mean: f64,
    /// Median (nearest rank; from a sample if there are very many).
    pub p50: f64,
    /// 95th percentile, computed in the same way.
    pub p95: f64,
    /// Maximum.
    pub max: f64,
}

/// Percentiles of times, in seconds, each with its number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Percentiles(pub(crate) Vec<(u8, f64)>);

impl Percentiles {
    /// The percentile with this number, if it is known.
    pub fn get(&self, number: u8) -> Option<f64> {
        let known = self.0.iter().find(|(known, _)| *known == number);
        known.map(|(_, seconds)| *seconds)
    }
}

/// End products of one type.
#[derive(Debug, Clone, PartialEq)]
pub struct ProductStatistics {
    /// Part type.
    pub part: usize,
    /// Number of finished parts.
    pub products: u64,
    /// Parts per hour of simulated time, after the warm-up.
    pub throughput_per_hour: f64,
    /// Time from the entry of a product's first part to the completion of the product.
    pub lead_time: LeadTime,
    /// Percentiles of the same that the requirements speak of.
    pub lead_time_percentiles: Percentiles,
}

/// Figures of a station by its state: shares of its time, whose sum is 1, or its energy in joules.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ByState {
    /// In work on a part.
    pub busy: f64,
    /// Free, but no part to work on has come.
    pub starved: f64,
    /// Done with a part, for which the next place has no room.
    pub blocked: f64,
    /// Broken down or under repair, on shift or off shift.
    pub failed: f64,
    /// Off shift. At a station that no part ever reached, waiting counts as idle, too.
    pub idle: f64,
    /// In setup for another part type.
    pub setup: f64,
}

impl ByState {
    /// The states, each by the measure of the time in it, whose name is that of the state.
    pub const STATES: [Measure; 6] = [
        Measure::Busy,
        Measure::Starved,
        Measure::Blocked,
        Measure::Failed,
        Measure::Idle,
        Measure::Setup,
    ];

    /// The figures in the order of [`Self::STATES`].
    pub fn figures(&self) -> [f64; 6] {
        [
            self.busy,
            self.starved,
            self.blocked,
            self.failed,
            self.idle,
            self.setup,
        ]
    }

    /// The figure of a state; `None` for a measure that is none.
    pub fn of(&self, state: Measure) -> Option<f64> {
        let at = Self::STATES.iter().position(|of| *of == state)?;
        Some(self.figures()[at])
    }

    /// What the station itself took as the constraint: busy, setup and failed.
    pub fn engaged(&self) -> f64 {
        self.busy + self.setup + self.failed
    }
}

/// Statistics of a source.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceStatistics {
    /// Index of the node.
    pub node: usize,
    /// Name of the source.
    pub name: String,
    /// Number of parts that have left the source.
    pub passed: u64,
    /// Share of the time in which a part waited in the source for room.
    pub blocked: f64,
    /// Share of the parts that went from the source into a sink with `rejects`: they found no room.
    pub lost: f64,
}

/// Statistics of a station.
#[derive(Debug, Clone, PartialEq)]
pub struct StationStatistics {
    /// Index of the node.
    pub node: usize,
    /// Name of the node.
    pub name: String,
    /// Name of the machine; `None` for a station that is given by its times.
    pub machine: Option<String>,
    /// Number of parts whose service ended.
    pub processed: u64,
    /// Shares of the station's time.
    pub shares: ByState,
    /// Seconds in work.
    pub busy_seconds: f64,
    /// Energy in joules: services, plus idle power outside them.
    pub joules: f64,
    /// The same by state: outside `busy` it is idle power.
    pub joules_by_state: ByState,
    /// Mean time of the work on a part, without failures; `None` if no service ended.
    pub work_time: Option<WorkTime>,
    /// Overall equipment effectiveness; `None` without planned time, without work, or if no service
    /// ended.
    pub oee: Option<Oee>,
    /// Number of parts that were rejected because of this station: one of its defects was the last
    /// to change them, or no defect did and it was the last station to work on them.
    pub scrapped: u64,
    /// What the station waited for: first the causes of its blocked time, then those of its starved
    /// time, the greatest first.
    pub waits: Vec<Wait>,
}

/// A cause of the time in which a station waited. The shares are of the station's time.
#[derive(Debug, Clone, PartialEq)]
pub struct Wait {
    /// Whether the station was blocked or starved.
    pub kind: WaitKind,
    /// Name of the place: while blocked, the place that had no room; while starved, the station,
    /// source or store from which the missing part came in the end.
    pub place: String,
    /// While blocked: name of the station at that place, or behind the full buffers and conveyors
    /// that begin there; `None` if there is none.
    pub station: Option<String>,
    /// The share of this cause.
    pub share: f64,
    /// The part of `share` in which that station had failed or was under repair.
    pub failed: f64,
    /// The part of `share` in which that station was off shift.
    pub off_shift: f64,
}

/// How a station waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WaitKind {
    /// For room.
    Blocked,
    /// For a part.
    Starved,
}

/// Mean time of the work on a part, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkTime {
    /// Seconds of the work, without failures.
    pub seconds: f64,
    /// The part of `seconds` in which no action of the machine is active: its control steps. 0 for
    /// a station without a machine.
    pub control_seconds: f64,
}

impl WorkTime {
    /// Seconds in which some action of the machine is active.
    pub fn action_seconds(&self) -> f64 {
        self.seconds - self.control_seconds
    }
}

/// Overall equipment effectiveness (the OEE index of ISO 22400-2) as its three factors, each from 0
/// to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oee {
    /// Time in work, divided by the planned time. All time on shift and all overtime is planned.
    pub availability: f64,
    /// Planned time of the completed work, divided by the time in work. It is less than 1 if work
    /// began again after failures.
    pub effectiveness: f64,
    /// Share of the processed parts that were not rejected because of this station.
    pub quality: f64,
}

impl Oee {
    /// The product of the factors.
    pub fn index(&self) -> f64 {
        self.availability * self.effectiveness * self.quality
    }
}

/// Statistics of a conveyor.
#[derive(Debug, Clone, PartialEq)]
pub struct ConveyorStatistics {
    /// Index of the node.
    pub node: usize,
    /// Name of the node.
    pub name: String,
    /// Name of the machine whose contract controls it; `None` for a conveyor without a contract.
    pub machine: Option<String>,
    /// Number of parts that left the conveyor at its end.
    pub carried: u64,
    /// Seconds in which at least one part moved on the conveyor.
    pub moving_seconds: f64,
    /// Energy in joules.
    pub joules: f64,
    /// The part of `joules` that was used while nothing moved.
    pub standing_joules: f64,
    /// Number of parts on the conveyor: its mean over time.
    pub length: f64,
    /// Maximum number of parts on the conveyor.
    pub longest: u64,
}

/// Statistics of a buffer.
#[derive(Debug, Clone, PartialEq)]
pub struct BufferStatistics {
    /// Index of the node.
    pub node: usize,
    /// Name of the node.
    pub name: String,
    /// Number of parts that left the buffer.
    pub passed: u64,
    /// Mean number of parts in the buffer, over time.
    pub length: f64,
    /// Maximum number of parts in the buffer.
    pub longest: u64,
    /// Share of the time in which the buffer was full, from 0 to 1.
    pub full: f64,
    /// Mean waiting time of the parts that left or expired, in seconds.
    pub wait: f64,
    /// Maximum of the same waiting times, in seconds.
    pub longest_wait: f64,
    /// Percentiles of the waiting time that the requirements speak of.
    pub wait_percentiles: Percentiles,
    /// Number of parts that expired; they count as rejected, not as passed.
    pub expired: u64,
}

/// Statistics of a machine, over all its instances.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineStatistics {
    /// Name of the machine.
    pub name: String,
    /// Seconds in work, summed over the instances of the machine.
    pub busy_seconds: f64,
    /// Energy of the instances in joules.
    pub joules: f64,
}

/// Parts that left the line good at the first pass, and as scrap: those that finished, and those
/// that were rejected after a station had worked on them. A joined part counts as the single parts
/// in it on which a station had worked before they were joined, so that parts that are only bought
/// and joined to others do not count; it counts as one if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Yields {
    /// Number of single parts that finished after a station had worked on them.
    pub finished: u64,
    /// Number of `finished` parts on which no station worked twice.
    pub first_pass: u64,
    /// Number of single parts that were rejected after a station had worked on them, that a failure
    /// scrapped, or that expired.
    pub scrapped: u64,
}

impl Yields {
    /// The sum of the counts.
    pub(crate) fn sum(all: &[Self]) -> Self {
        let of = |count: fn(&Self) -> u64| all.iter().map(count).sum();
        Self {
            finished: of(|yields| yields.finished),
            first_pass: of(|yields| yields.first_pass),
            scrapped: of(|yields| yields.scrapped),
        }
    }

    /// What was counted after `earlier`.
    pub(crate) fn after(self, earlier: Self) -> Self {
        Self {
            finished: self.finished - earlier.finished,
            first_pass: self.first_pass - earlier.first_pass,
            scrapped: self.scrapped - earlier.scrapped,
        }
    }

    /// The share of the parts that finished at the first pass; `None` without parts.
    pub fn first_pass_yield(&self) -> Option<f64> {
        self.share(self.first_pass)
    }

    /// The share of the parts that were scrapped; `None` without parts.
    pub fn scrap_ratio(&self) -> Option<f64> {
        self.share(self.scrapped)
    }

    fn share(&self, parts: u64) -> Option<f64> {
        let all = self.finished + self.scrapped;
        (all > 0).then(|| parts as f64 / all as f64)
    }
}

/// Rejected parts of one type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reject {
    /// Index of the part type.
    pub part: usize,
    /// Number of rejected parts.
    pub count: u64,
    /// Number of new parts ordered as replacements.
    pub reordered: u64,
}

/// A violation of a rule during the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// Time in simulated seconds.
    pub time: f64,
    /// Index of the node.
    pub node: usize,
    /// Number and type of the part in work; `None` for a conveyor.
    pub part: Option<(u64, usize)>,
    /// Error code of the library.
    pub code: ErrorCode,
    /// The violated rule, prefixed with its component: `turn: gripped`.
    pub rule: Option<String>,
    /// Complete message of the library.
    pub message: String,
}

/// A requirement of the line and its result.
#[derive(Debug, Clone, PartialEq)]
pub struct RequirementResult {
    /// Name of the requirement.
    pub name: String,
    /// Whether the requirement holds in the run.
    pub holds: bool,
    /// Measured value in the metric's unit; `None` if there was nothing to measure.
    pub value: Option<f64>,
}

impl RequirementResult {
    /// The verdict on the run.
    pub fn verdict(&self) -> Verdict {
        if self.holds {
            Verdict::Holds
        } else {
            Verdict::Fails
        }
    }
}

/// Formats a duration for a table: below a minute with three significant digits (`2.4 s`, `9 ms`),
/// otherwise as hours, minutes and seconds (`1:05:09`).
pub fn duration(seconds: f64) -> String {
    if seconds < LEAST_CLOCK {
        below_a_minute(seconds)
    } else {
        clock(seconds)
    }
}

/// Formats a duration for a text: below a minute like [`duration`], otherwise with at most three
/// units (`6 min 28 s`, `1 h 5 min 9 s`, `2 d 3 h`).
pub fn duration_in_units(seconds: f64) -> String {
    if seconds < LEAST_CLOCK {
        return below_a_minute(seconds);
    }
    // From a day on, seconds do not matter.
    let whole = if seconds < 86_400.0 {
        seconds.round() as u64
    } else {
        (seconds / 60.0).round() as u64 * 60
    };
    let units = [
        (whole / 86_400, "d"),
        (whole / 3600 % 24, "h"),
        (whole / 60 % 60, "min"),
        (whole % 60, "s"),
    ];
    let units = units.into_iter().filter(|(count, _)| *count > 0);
    let units: Vec<String> = units
        .map(|(count, unit)| format!("{count} {unit}"))
        .collect();
    units.join(" ")
}

/// Seconds from which on a duration has minutes: less is shown as `59.9 s` or less.
const LEAST_CLOCK: f64 = 59.95;

fn below_a_minute(seconds: f64) -> String {
    let seconds = seconds.max(0.0);
    let (value, unit) = if seconds > 0.0 && seconds < 0.0995 {
        (seconds * 1000.0, "ms")
    } else {
        (seconds, "s")
    };
    let magnitude = if value > 0.0 {
        value.log10().floor() as i32
    } else {
        0
    };
    let places = (2 - magnitude).clamp(0, 9) as usize;
    let digits = format!("{value:.places$}");
    let digits = if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        &digits
    };
    format!("{digits} {unit}")
}

/// Formats a time in seconds as hours, minutes and seconds: `1:05:09`.
pub fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_a_unit_that_shows_them() {
        for (seconds, wanted) in [
            (0.0, "0 s"),
            (1e-6, "0.001 ms"),
            (0.000_512_34, "0.512 ms"),
            (0.008_94, "8.94 ms"),
            (0.0994, "99.4 ms"),
            (0.0996, "0.0996 s"),
            (0.25, "0.25 s"),
            (2.4, "2.4 s"),
            (2.396, "2.4 s"),
            (9.999, "10 s"),
            (45.25, "45.2 s"),
            (59.94, "59.9 s"),
            (59.96, "0:01:00"),
            (3909.0, "1:05:09"),
        ] {
            assert_eq!(duration(seconds), wanted);
        }
    }

    #[test]
    fn durations_in_texts_have_units() {
        for (seconds, wanted) in [
            (0.0, "0 s"),
            (0.25, "0.25 s"),
            (59.94, "59.9 s"),
            (59.96, "1 min"),
            (388.4, "6 min 28 s"),
            (3600.0, "1 h"),
            (3909.0, "1 h 5 min 9 s"),
            (86_399.7, "1 d"),
            (97_229.0, "1 d 3 h"),
            (400_000.0, "4 d 15 h 7 min"),
        ] {
            assert_eq!(duration_in_units(seconds), wanted);
        }
    }
}
