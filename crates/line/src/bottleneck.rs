//! What limits the throughput of a line.
//!
//! A line whose sources never have to wait takes in all that they bring: the sources limit it,
//! however busy its stations are. Otherwise, the bottleneck is where most time is lost to work,
//! setup and repair. If stations are nearly equal in this, one run cannot decide between them. If
//! that station waits much of its time on shift for parts of sources that bring them at times of
//! their own, these sources limit the line, and not the station: it could work on more.

use crate::trace::{SourceStatistics, StationStatistics, WaitKind};
use linewright_language::contract::line::{Line, NodeKind, Supply, declared_name};

/// What limits the throughput of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum Bottleneck {
    /// No station has worked.
    Nothing,
    /// The sources: all of the line, if their parts never had to wait, or those for whose parts the
    /// busiest station waits. The busiest stations come with it, if any.
    Source {
        /// Names of the sources.
        names: Vec<String>,
        /// The busiest stations.
        busiest: Option<Candidate>,
        /// Whether parts had to wait in sources at some time, such as off shift.
        parts_wait: bool,
    },
    /// A station, or several that are alike.
    Station(Candidate),
    /// One of several stations, which are nearly equal.
    Undecided(Vec<Candidate>),
    /// Nothing that could be measured: places whose parts wait for one another for ever.
    Deadlock(Deadlock),
}

/// Parts that wait for one another for ever.
#[derive(Debug, Clone, PartialEq)]
pub struct Deadlock {
    /// Names of the places, each of which waits for the next one, and the last for the first.
    pub places: Vec<String>,
    /// Time at which it began, in seconds.
    pub since: f64,
}

/// A station, or several that are alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Name, without the number of one of several stations.
    pub name: String,
    /// Share of the time in which it was busy, set up or failed: the mean if there are several.
    pub engaged: f64,
    /// The same share of the time in which it was not idle, that is, on shift. It decides, because
    /// stations may have different shifts.
    pub engaged_on_shift: f64,
    /// Share of its time on shift in which it waited for a part.
    pub starved_on_shift: f64,
}

/// Share of the time up to which a part that has to wait in its source does not matter.
const NEVER: f64 = 0.01;

/// Difference of shares up to which stations count as equal.
const EQUAL: f64 = 0.01;

/// Share of its time on shift from which on the busiest station is limited by the sources for which
/// it waits.
const MUCH: f64 = 0.1;

/// Maximum number of places of a deadlock in a text.
const SHOWN: usize = 8;

impl Deadlock {
    /// The places in a text: `a, b and c`, or the first of many.
    pub fn listed(&self) -> String {
        match &self.places[..] {
            [] => String::new(),
            [only] => only.clone(),
            many if many.len() > SHOWN => {
                let more = many.len() - SHOWN;
                format!("{} and {more} more", many[..SHOWN].join(", "))
            }
            [first @ .., last] => format!("{} and {last}", first.join(", ")),
        }
    }
}

impl Bottleneck {
    /// Determines the bottleneck from the statistics of a run of a line.
    pub(crate) fn of(
        line: &Line,
        stations: &[StationStatistics],
        sources: &[SourceStatistics],
    ) -> Self {
        let mut candidates = candidates(stations);
        candidates.retain(|candidate| candidate.engaged > 0.0);
        candidates.sort_by(|a, b| b.engaged_on_shift.total_cmp(&a.engaged_on_shift));
        let free = |source: &SourceStatistics| source.blocked < NEVER && source.lost < NEVER;
        if all_timed(line) && !sources.is_empty() && sources.iter().all(free) {
            return Self::Source {
                names: sources.iter().map(|source| source.name.clone()).collect(),
                busiest: candidates.into_iter().next(),
                parts_wait: false,
            };
        }
        let Some(first) = candidates.first() else {
            return Self::Nothing;
        };
        let timed = sources.iter();
        let timed =
            timed.filter(|source| source.lost < NEVER && is_timed(&line.nodes[source.node].kind));
        let names = awaited(first, stations, timed);
        if !names.is_empty() {
            return Self::Source {
                names,
                busiest: candidates.into_iter().next(),
                parts_wait: true,
            };
        }
        let least = first.engaged_on_shift - EQUAL;
        candidates.retain(|candidate| candidate.engaged_on_shift > least);
        if candidates.len() > 1 {
            Self::Undecided(candidates)
        } else {
            Self::Station(candidates.remove(0))
        }
    }

    /// The station, if it is one.
    pub fn station(&self) -> Option<&Candidate> {
        match self {
            Self::Station(candidate) => Some(candidate),
            _ => None,
        }
    }

    /// The station that is most in use: the bottleneck, or the one that the sources do not keep
    /// busy.
    pub fn busiest(&self) -> Option<&Candidate> {
        match self {
            Self::Station(candidate) => Some(candidate),
            Self::Source { busiest, .. } => busiest.as_ref(),
            _ => None,
        }
    }
}

/// Names of those of the sources for which a station waits, if it waits for them much of its time.
fn awaited<'a>(
    candidate: &Candidate,
    stations: &[StationStatistics],
    sources: impl Iterator<Item = &'a SourceStatistics>,
) -> Vec<String> {
    let alike = stations
        .iter()
        .filter(|station| declared_name(&station.name) == candidate.name);
    let on_shift: f64 = alike.clone().map(|s| 1.0 - s.shares.idle).sum();
    let shares = sources.map(|source| {
        let waits = alike.clone().flat_map(|station| &station.waits);
        let of_source = waits.filter(|w| w.kind == WaitKind::Starved && w.place == source.name);
        (&source.name, of_source.map(|wait| wait.share).sum::<f64>())
    });
    let shares: Vec<(&String, f64)> = shares.filter(|(_, share)| *share > NEVER).collect();
    let all: f64 = shares.iter().map(|(_, share)| share).sum();
    if on_shift > 0.0 && all >= MUCH * on_shift {
        shares.into_iter().map(|(name, _)| name.clone()).collect()
    } else {
        Vec::new()
    }
}

/// Whether parts come only from sources that have an interval or the instants of a table, and no
/// limit of parts in the line.
fn all_timed(line: &Line) -> bool {
    line.nodes.iter().all(|node| match &node.kind {
        NodeKind::Source { .. } => is_timed(&node.kind),
        NodeKind::Store { stock } => stock.is_empty(),
        _ => true,
    })
}

/// Whether it is a source that has an interval or the instants of a table, and no limit of parts in
/// the line.
fn is_timed(kind: &NodeKind) -> bool {
    match kind {
        NodeKind::Source {
            supply: Supply::Every { interval, .. },
            most: None,
            ..
        } => !interval.is_zero(),
        NodeKind::Source {
            supply: Supply::At { .. },
            most: None,
            ..
        } => true,
        _ => false,
    }
}

/// The stations; those of one declaration as one.
fn candidates(stations: &[StationStatistics]) -> Vec<Candidate> {
    let mut found = Vec::new();
    let mut rest = stations;
    while let Some(first) = rest.first() {
        let name = declared_name(&first.name);
        let alike = |s: &&StationStatistics| declared_name(&s.name) == name;
        let count = rest.iter().take_while(alike).count();
        let (alike, others) = rest.split_at(count);
        let sum: f64 = alike.iter().map(|s| s.shares.engaged()).sum();
        let starved: f64 = alike.iter().map(|s| s.shares.starved).sum();
        let on_shift: f64 = alike.iter().map(|s| 1.0 - s.shares.idle).sum();
        found.push(Candidate {
            name: name.to_owned(),
            engaged: sum / count as f64,
            engaged_on_shift: if on_shift > 0.0 { sum / on_shift } else { 0.0 },
            starved_on_shift: if on_shift > 0.0 {
                starved / on_shift
            } else {
                0.0
            },
        });
        rest = others;
    }
    found
}
