//! The slowest station of a line, from the times of the work.

use super::document::WorkEntry;
use crate::contract::line::{Line, NodeKind, declared_name};
use crate::line::trace::duration_in_units;
use crate::report::html::parts::figure;

/// A station with its work on a part of one type.
struct Pace<'a> {
    station: &'a str,
    part: &'a str,
    /// Least and greatest time of the work, in seconds.
    seconds: [f64; 2],
    /// Number of alike stations that work in parallel.
    copies: usize,
}

impl Pace<'_> {
    /// The least time from one part to the next, in seconds.
    fn interval(&self) -> f64 {
        self.seconds[0] / self.copies as f64
    }
}

/// Says which station is the slowest, and how many parts can pass it in an hour; `None` if the time
/// of some station is not known, or no work takes time.
pub(super) fn slowest(line: &Line, work: &[WorkEntry]) -> Option<String> {
    let mut slowest: Option<Pace<'_>> = None;
    for pace in paces(line, work)? {
        if slowest
            .as_ref()
            .is_none_or(|s| pace.interval() > s.interval())
        {
            slowest = Some(pace);
        }
    }
    let pace = slowest.filter(|pace| pace.interval() > 0.0)?;
    let most = figure(3600.0 / pace.interval());
    let (station, part, time) = (pace.station, pace.part, range(pace.seconds));
    Some(match pace.copies {
        1 => format!(
            "The slowest station is {station}: {time} a part ({part}), so at most {most} parts an hour pass it."
        ),
        copies => format!(
            "The slowest station is {station}, of which there are {copies} in parallel: {time} a part ({part}), one part every {} of all {copies}, so at most {most} parts an hour pass them.",
            range([pace.interval(); 2])
        ),
    })
}

/// A time with its least and greatest value: `3 min 24 s`, or `11.2 s to 12.2 s`.
pub(super) fn range([least, greatest]: [f64; 2]) -> String {
    if least < greatest {
        format!(
            "{} to {}",
            duration_in_units(least),
            duration_in_units(greatest)
        )
    } else {
        duration_in_units(least)
    }
}

/// The work of all stations; `None` if a time is not known. A station that is given by its times
/// has known ones if they are constant.
fn paces<'a>(line: &'a Line, work: &'a [WorkEntry]) -> Option<Vec<Pace<'a>>> {
    let mut paces = Vec::new();
    for (number, node) in line.nodes.iter().enumerate() {
        let NodeKind::Station(station) = &node.kind else {
            continue;
        };
        // Stations of one declaration share its place.
        let alike = line.nodes.iter().filter(|other| other.span == node.span);
        let copies = alike.count();
        let mut add = |part: &'a str, seconds: [f64; 2]| {
            paces.push(Pace {
                station: declared_name(&node.name),
                part,
                seconds,
                copies,
            });
        };
        if station.machine.is_some() {
            let is_reached = line.routes.iter().any(|route| route.to == number);
            let mut rows = work.iter().filter(|w| w.station == node.name).peekable();
            if is_reached {
                rows.peek()?;
            }
            rows.for_each(|w| add(&w.part, w.seconds));
            continue;
        }
        for task in &station.tasks {
            let time = task.time.as_ref()?;
            let seconds = [time.least(), time.greatest()];
            if seconds[0] < seconds[1] {
                return None;
            }
            add(&line.parts[task.part].name, seconds);
        }
    }
    Some(paces)
}
