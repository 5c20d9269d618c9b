//! Cuts a run into batches: at each end of a batch, the accounts are read, and nothing is changed.
//! What a batch contributed is the difference of two readings. A run with batches is therefore the
//! same as one without, and its figures are those of the whole run.
//!
//! If time ends the run, all batches last equally long. If products end it, all batches have as
//! many of them, or one more: how long the run will last is not known when a batch has to end.

use super::part::PartIndex;
use super::{BATCH, Event, Place, Run};
use crate::batches::{Batch, CauseTime, PlaceFigures, ProductFigures, StationFigures};
use crate::metric::percentiles_of_lead_time;
use crate::statistics::{Activity, Clock, Level, Output, Times, Waits};
use crate::trace::{End, LeadTime, Percentiles, Yields};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Line, NodeKind};

/// Minimum number of products in a batch that products end.
const MIN_PRODUCTS: u64 = 10;

/// The readings of a run so far.
pub(super) struct Cuts {
    /// Number of batches that are wanted.
    count: u32,
    /// At the beginning of the first batch, and at the end of each.
    readings: Vec<Reading>,
    /// Lead times of the products of this batch.
    lead_times: Times,
    /// The same by type, if there are several.
    by_type: Vec<(usize, Times)>,
    /// Whether the end of this batch is scheduled.
    is_due: bool,
}

/// What has been counted up to a moment.
struct Reading {
    /// In seconds.
    time: f64,
    products: u64,
    rejected: u64,
    /// By part type.
    yields: Vec<Yields>,
    /// Of the products of the batch that ends here.
    lead_time: LeadTime,
    percentiles: Percentiles,
    by_type: Vec<ProductFigures>,
    units: Level,
    accounts: Vec<Account>,
}

/// What has been counted at a node.
enum Account {
    Station(Box<StationAccount>),
    /// Energy in joules, and the number of parts.
    Conveyor(f64, Level),
    /// With the percentiles of the waiting time in the batch that ends here, and the number of
    /// parts that have expired.
    Buffer(Level, Waits, Percentiles, u64),
    /// Number of parts that have left, and of those that were lost.
    Source(u64, u64),
    Nothing,
}

/// What has been counted at a station.
struct StationAccount {
    clock: Clock,
    joules: f64,
    output: Output,
    causes: Vec<CauseTime>,
}

impl StationAccount {
    /// What was counted after `earlier`.
    fn after(&self, earlier: &Self, idle_watts: f64, visited: bool) -> StationFigures {
        let clock = self.clock.after(&earlier.clock);
        let output = self.output.after(earlier.output);
        let causes = self.causes.iter().filter_map(|cause| {
            let is_same = |of: &&CauseTime| {
                (of.kind, of.place, of.station) == (cause.kind, cause.place, cause.station)
            };
            let before = earlier.causes.iter().find(is_same);
            let seconds = cause.seconds - before.map_or(0.0, |before| before.seconds);
            (seconds > 0.0).then_some(CauseTime { seconds, ..*cause })
        });
        StationFigures {
            shares: clock.shares(visited),
            oee: output.oee(&clock),
            planned: clock.planned(),
            busy: clock.seconds(Activity::Busy),
            parts: output.processed + output.broken,
            joules: clock.energy(self.joules - earlier.joules, idle_watts, visited),
            causes: causes.collect(),
        }
    }
}

/// Why a run cannot be cut into this many batches.
pub(super) fn refused(
    line: &Line,
    count: u32,
    target: Option<u64>,
    horizon: Option<f64>,
) -> Option<Diagnostic> {
    let least = u64::from(count).saturating_mul(MIN_PRODUCTS);
    let (message, help) = match (target, horizon) {
        (Some(_), Some(_)) => (
            format!(
                "the run of {} has two ends, and its batches need one",
                line.name
            ),
            "Give either --parts or --until with --batches.".to_owned(),
        ),
        (Some(target), None) if target < least => (
            format!(
                "the {target} products of {} are too few for {count} batches",
                line.name
            ),
            format!(
                "A batch needs at least {MIN_PRODUCTS} products, and better some hundreds: `--parts {least}` or more, or fewer batches."
            ),
        ),
        _ => return None,
    };
    Some(Diagnostic::error(codes::LINE_LIMIT, line.span, message).with_help(help))
}

impl Run<'_> {
    /// Begins the first batch, if batches are wanted.
    pub(super) fn begin_batches(&mut self) {
        let Some(count) = self.setup.options.batches else {
            return;
        };
        self.cuts = Some(Cuts {
            count,
            readings: Vec::new(),
            lead_times: Times::new(self.seed),
            by_type: self.no_times_by_type(),
            is_due: false,
        });
        self.end_batch();
    }

    /// Ends a batch, and begins the next one.
    pub(super) fn end_batch(&mut self) {
        let Some(mut cuts) = self.cuts.take() else {
            return;
        };
        let mut lead_times = std::mem::replace(&mut cuts.lead_times, Times::new(self.seed));
        let by_type = std::mem::replace(&mut cuts.by_type, self.no_times_by_type());
        cuts.readings.push(self.reading(&mut lead_times, by_type));
        cuts.is_due = false;
        self.cuts = Some(cuts);
        if let Some(time) = self.next_cut() {
            self.schedule(time, BATCH, Event::Batch);
        }
        self.cut_after_products();
    }

    /// By type, if there are several types of end products: no lead times.
    fn no_times_by_type(&self) -> Vec<(usize, Times)> {
        let by_type = self.counters.by_type.iter();
        by_type
            .map(|(part, _)| (*part, Times::new(self.seed)))
            .collect()
    }

    /// Counts an end product in its batch.
    pub(super) fn count_in_batch(&mut self, part: PartIndex) {
        if let Some(cuts) = &mut self.cuts {
            let part = &self.parts[part];
            let seconds = self.now - part.entered_at;
            cuts.lead_times.add(seconds);
            let mut by_type = cuts.by_type.iter_mut();
            if let Some((_, times)) = by_type.find(|(kind, _)| *kind == part.kind) {
                times.add(seconds);
            }
            self.cut_after_products();
        }
    }

    /// When this batch ends, in seconds; `None` if it is the last one, or if products end it.
    pub(super) fn next_cut(&self) -> Option<f64> {
        let cuts = self.cuts.as_ref()?;
        let number = cuts.readings.len() as u32;
        let (start, end) = (cuts.readings.first()?.time, self.setup.horizon?);
        let share = f64::from(number) / f64::from(cuts.count);
        (number < cuts.count).then_some(start + (end - start) * share)
    }

    /// Schedules the end of this batch for this instant if it has its products. Later ones at the
    /// same instant belong to it, too.
    fn cut_after_products(&mut self) {
        let (Some(cuts), Some(target)) = (&mut self.cuts, self.setup.target) else {
            return;
        };
        let (number, count) = (cuts.readings.len() as u64, u64::from(cuts.count));
        let products = u128::from(target) * u128::from(number) / u128::from(count);
        if number < count && !cuts.is_due && u128::from(self.counters.products) >= products {
            cuts.is_due = true;
            self.schedule(self.now, BATCH, Event::Batch);
        }
    }

    /// Reads all accounts, at the end of a batch with these lead times.
    fn reading(&mut self, lead_times: &mut Times, by_type: Vec<(usize, Times)>) -> Reading {
        let now = self.now;
        let line = self.line;
        let counted = now - self.counting_start();
        let places = self.nodes.iter_mut().map(|node| &mut node.place);
        let nodes = line.nodes.iter().zip(places);
        let accounts = nodes.map(|(node, place)| match (&node.kind, place) {
            (NodeKind::Station(declared), Place::Station(station)) => {
                Account::Station(Box::new(StationAccount {
                    clock: station.clock.at(now),
                    joules: station.joules(now, declared.idle_watts),
                    output: station.output(),
                    causes: station.waits.charged(),
                }))
            }
            (NodeKind::Conveyor { watts, .. }, Place::Conveyor(conveyor)) => {
                let joules = conveyor.moving_seconds(now) * watts;
                Account::Conveyor(joules, conveyor.level.at(now))
            }
            (
                NodeKind::Conveyor {
                    watts,
                    belt: Some(declared),
                    ..
                },
                Place::Belt(belt),
            ) => {
                let (_, joules, _) = belt.moved(counted, *watts, declared.machine.idle_watts);
                Account::Conveyor(joules, belt.level.at(now))
            }
            (_, Place::Buffer(buffer)) => {
                let percentiles = buffer.end_batch();
                Account::Buffer(
                    buffer.level.at(now),
                    buffer.waits,
                    percentiles,
                    buffer.expired,
                )
            }
            (_, Place::Source(source)) => {
                let (passed, lost) = source.passed_and_lost();
                Account::Source(passed, lost)
            }
            _ => Account::Nothing,
        });
        let accounts = accounts.collect();
        let numbers = percentiles_of_lead_time(line);
        let by_type = by_type.into_iter();
        let by_type = by_type.map(|(part, mut times)| ProductFigures {
            part,
            products: times.count(),
            lead_time: times.summary(),
            percentiles: times.percentiles(&numbers),
        });
        Reading {
            time: now,
            products: self.counters.products,
            rejected: self.counters.rejects.iter().map(|(count, _)| count).sum(),
            yields: self.counters.yields.clone(),
            lead_time: lead_times.summary(),
            percentiles: lead_times.percentiles(&numbers),
            by_type: by_type.collect(),
            units: self.counters.units.at(now),
            accounts,
        }
    }

    /// The batches of a run that has ended; empty if it ended before the last one.
    pub(super) fn close_batches(&mut self, end: End) -> Vec<Batch> {
        let Some(count) = self.cuts.as_ref().map(|cuts| cuts.count as usize) else {
            return Vec::new();
        };
        // The last products may have come at one instant with those that end the batch before.
        let is_open = |run: &Self| {
            let cuts = run.cuts.as_ref();
            cuts.is_some_and(|cuts| cuts.readings.len() <= count)
        };
        while matches!(end, End::Products | End::Time) && is_open(self) {
            self.end_batch();
        }
        let readings = self.cuts.take().map_or(Vec::new(), |cuts| cuts.readings);
        if readings.len() <= count {
            return Vec::new();
        }
        let pairs = readings.iter().zip(readings.iter().skip(1));
        pairs
            .map(|(from, to)| self.batch(count, from, to))
            .collect()
    }

    /// The batch between two readings, one of `count`.
    fn batch(&self, count: usize, from: &Reading, to: &Reading) -> Batch {
        let mut joules = 0.0;
        let nodes = self.line.nodes.iter().zip(&self.nodes);
        let accounts = from.accounts.iter().zip(&to.accounts).zip(nodes);
        let places = accounts.map(
            |((before, after), (declared, node))| match (before, after) {
                (Account::Station(before), Account::Station(after)) => {
                    joules += after.joules - before.joules;
                    let (NodeKind::Station(declared), Place::Station(station)) =
                        (&declared.kind, &node.place)
                    else {
                        return PlaceFigures::Other;
                    };
                    let visited = station.is_visited();
                    let figures = after.after(before, declared.idle_watts, visited);
                    PlaceFigures::Station(Box::new(figures))
                }
                (Account::Conveyor(before, earlier), Account::Conveyor(after, level)) => {
                    joules += after - before;
                    PlaceFigures::Conveyor {
                        joules: after - before,
                        length: level.after(earlier).mean(),
                    }
                }
                (
                    Account::Buffer(earlier, waited, _, gone),
                    Account::Buffer(level, waits, percentiles, expired),
                ) => {
                    let (level, waits) = (level.after(earlier), waits.after(*waited));
                    PlaceFigures::Buffer {
                        waited: waits.count,
                        length: level.mean(),
                        full: level.full_share(),
                        wait: waits.mean(),
                        percentiles: percentiles.clone(),
                        expired: expired - gone,
                    }
                }
                (Account::Source(left, lost), Account::Source(passed, all_lost)) => {
                    PlaceFigures::Source {
                        passed: passed - left,
                        lost: all_lost - lost,
                    }
                }
                _ => PlaceFigures::Other,
            },
        );
        let places = places.collect();
        let yields = to.yields.iter().zip(&from.yields);
        let yields: Vec<Yields> = yields.map(|(to, from)| to.after(*from)).collect();
        let calendar = self.line.calendar.as_ref();
        let worked = calendar
            .map(|calendar| calendar.worked_until(to.time) - calendar.worked_until(from.time));
        Batch {
            count,
            seconds: to.time - from.time,
            on_shift_seconds: worked,
            products: to.products - from.products,
            rejected: to.rejected - from.rejected,
            yields: Yields::sum(&yields),
            yields_by_type: yields,
            lead_time: to.lead_time,
            percentiles: to.percentiles.clone(),
            by_type: to.by_type.clone(),
            wip: to.units.after(&from.units).mean(),
            joules,
            places,
        }
    }
}
