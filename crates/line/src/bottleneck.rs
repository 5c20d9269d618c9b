//! What limits the throughput of a line.
//!
//! A line whose sources never have to wait takes in all that they bring: the sources limit it,
//! however busy its stations are. Otherwise, the bottleneck is where most time is lost to work,
//! setup and repair. If stations are nearly equal in this, one run cannot decide between them.

use crate::trace::{SourceStatistics, StationStatistics};
use linewright_language::contract::line::declared_name;

/// What limits the throughput of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum Bottleneck {
    /// No station has worked.
    Nothing,
    /// The sources: their parts never had to wait. The busiest stations come with it, if any.
    Source {
        /// Names of the sources.
        names: Vec<String>,
        /// The busiest stations.
        busiest: Option<Candidate>,
    },
    /// A station, or several that are alike.
    Station(Candidate),
    /// One of several stations, which are nearly equal.
    Undecided(Vec<Candidate>),
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
}

/// Share of the time up to which a part that has to wait in its source does not matter.
const NEVER: f64 = 0.01;

/// Difference of shares up to which stations count as equal.
const EQUAL: f64 = 0.01;

impl Bottleneck {
    /// Determines the bottleneck from the statistics of a run. `all_timed` states whether parts
    /// come from sources with an interval alone.
    pub(crate) fn of(
        stations: &[StationStatistics],
        sources: &[SourceStatistics],
        all_timed: bool,
    ) -> Self {
        let mut candidates = candidates(stations);
        candidates.retain(|candidate| candidate.engaged > 0.0);
        candidates.sort_by(|a, b| b.engaged_on_shift.total_cmp(&a.engaged_on_shift));
        let free = |source: &SourceStatistics| source.blocked < NEVER && source.lost < NEVER;
        if all_timed && !sources.is_empty() && sources.iter().all(free) {
            return Self::Source {
                names: sources.iter().map(|source| source.name.clone()).collect(),
                busiest: candidates.into_iter().next(),
            };
        }
        let Some(first) = candidates.first() else {
            return Self::Nothing;
        };
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
        let on_shift: f64 = alike.iter().map(|s| 1.0 - s.shares.idle).sum();
        found.push(Candidate {
            name: name.to_owned(),
            engaged: sum / count as f64,
            engaged_on_shift: if on_shift > 0.0 { sum / on_shift } else { 0.0 },
        });
        rest = others;
    }
    found
}
