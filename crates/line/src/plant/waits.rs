//! What stations wait for: the places that block them, and the places whose parts they lack.
//!
//! A station waits in an *interval* in which it is booked as blocked or starved. An interval ends
//! when the part leaves or comes, and when a failure or the end of a shift interrupts the wait. At
//! both ends of an interval, the time in which the awaited station has been down so far is read.
//! The effort of a wait therefore does not depend on what happens meanwhile. It is constant for a
//! blocked station, and proportional to the number of its suppliers for a starved one.

use super::ways::Way;
use super::{Place, Run, Setup};
use crate::batches::CauseTime;
use crate::statistics::Activity;
use crate::trace::{Wait, WaitKind};
use linewright_language::contract::line::{Line, NodeKind};

/// Maximum number of buffers and conveyors between a station and the one that blocks it.
const MAX_PLACES_BETWEEN: usize = 16;

/// The waits of a station.
#[derive(Debug, Default)]
#[repr(C)]
pub(super) struct Waits {
    /// The activity of the current interval, and its start in seconds.
    interval: Option<(Activity, f64)>,
    /// Seconds of the intervals since the station became starved.
    starved_seconds: f64,
    /// The place from which the last part came.
    pub supplier: Option<u32>,
    /// While blocked: the place without room, and the station at or behind it.
    blocker: (u32, Option<u32>),
    blocked: Vec<Cause>,
    starved: Vec<Cause>,
    /// Down times at the start of the interval: of the blocking station, or of each supplier, if
    /// they can be down.
    start: Vec<Down>,
    /// Down times of each supplier in the intervals since the station became starved.
    starved_down: Vec<Down>,
}

/// Seconds in which a station has failed or is under repair, and in which it is off shift.
#[derive(Debug, Clone, Copy, Default)]
struct Down {
    failed: f64,
    off_shift: f64,
}

impl Down {
    fn add(&mut self, now: Self, start: Self) {
        self.failed += now.failed - start.failed;
        self.off_shift += now.off_shift - start.off_shift;
    }
}

/// Seconds for which a station has waited for a place.
#[derive(Debug)]
struct Cause {
    place: u32,
    station: Option<u32>,
    seconds: f64,
    down: Down,
}

fn charge(causes: &mut Vec<Cause>, place: u32, station: Option<u32>, seconds: f64, down: Down) {
    let known = causes
        .iter_mut()
        .find(|cause| (cause.place, cause.station) == (place, station));
    if let Some(cause) = known {
        cause.seconds += seconds;
        cause.down.add(down, Down::default());
    } else {
        causes.push(Cause {
            place,
            station,
            seconds,
            down,
        });
    }
}

impl Waits {
    /// Whether an interval lasts.
    #[inline]
    pub(super) fn is_waiting(&self) -> bool {
        self.interval.is_some()
    }

    /// Whether the station has been starved since its last part.
    #[inline]
    pub(super) fn is_starved(&self) -> bool {
        self.interval.is_some() || self.starved_seconds > 0.0
    }

    /// Forgets what has been counted, after the interval has ended.
    pub(super) fn forget(&mut self) {
        self.starved_seconds = 0.0;
        self.starved_down.clear();
        self.blocked.clear();
        self.starved.clear();
    }

    /// What has been charged to each cause so far. A wait is charged when it ends.
    pub(super) fn charged(&self) -> Vec<CauseTime> {
        let of = |kind| {
            move |cause: &Cause| CauseTime {
                kind,
                place: cause.place,
                station: cause.station,
                seconds: cause.seconds,
            }
        };
        let blocked = self.blocked.iter().map(of(WaitKind::Blocked));
        let starved = self.starved.iter().map(of(WaitKind::Starved));
        blocked.chain(starved).collect()
    }

    /// The causes, as shares of `total` seconds; the greatest come first.
    pub(super) fn causes(&self, line: &Line, total: f64) -> Vec<Wait> {
        let name = |node: u32| line.nodes[node as usize].name.clone();
        let waits = |kind, causes: &[Cause]| {
            let mut waits: Vec<Wait> = causes
                .iter()
                .map(|cause| Wait {
                    kind,
                    place: name(cause.place),
                    station: cause.station.map(name),
                    share: cause.seconds / total,
                    failed: cause.down.failed / total,
                    off_shift: cause.down.off_shift / total,
                })
                .collect();
            waits.sort_by(|a, b| b.share.total_cmp(&a.share));
            waits
        };
        let mut all = waits(WaitKind::Blocked, &self.blocked);
        all.extend(waits(WaitKind::Starved, &self.starved));
        all
    }
}

impl Run<'_> {
    /// Begins an interval if a station is booked as blocked or starved. Does nothing during one.
    #[inline]
    pub(super) fn begin_wait(&mut self, node: usize) {
        if let Place::Station(station) = &self.nodes[node].place
            && let Some(activity) = station.begins_wait()
        {
            self.begin_interval(node, activity);
        }
    }

    #[inline(never)]
    fn begin_interval(&mut self, node: usize, activity: Activity) {
        match activity {
            Activity::Blocked => {
                let Some(place) = self.awaited_place(node) else {
                    return;
                };
                let behind = self.station_behind(place);
                let watched = behind.filter(|station| self.setup.can_be_down[*station]);
                let down = watched.map(|station| self.down(station));
                let waits = &mut self.station(node).waits;
                waits.blocker = (place as u32, behind.map(|station| station as u32));
                waits.start.clear();
                waits.start.extend(down);
            }
            Activity::Starved => {
                let setup: &Setup = self.setup;
                let suppliers = &setup.suppliers[node];
                if !suppliers.is_empty() {
                    let mut start = std::mem::take(&mut self.station(node).waits.start);
                    start.clear();
                    start.extend(suppliers.iter().map(|station| self.down(*station as usize)));
                    self.station(node).waits.start = start;
                }
            }
            _ => return,
        }
        let now = self.now;
        self.station(node).waits.interval = Some((activity, now));
    }

    /// Ends the interval of a station, if there is one, before anything else is booked.
    #[inline]
    pub(super) fn end_wait(&mut self, node: usize) {
        if let Place::Station(station) = &mut self.nodes[node].place
            && let Some((activity, since)) = station.waits.interval.take()
            && self.now > since
        {
            self.end_interval(node, activity, self.now - since);
        }
    }

    #[inline(never)]
    fn end_interval(&mut self, node: usize, activity: Activity, seconds: f64) {
        let waits = &self.station(node).waits;
        if activity == Activity::Blocked {
            let (place, behind) = waits.blocker;
            let start = waits.start.first().copied();
            let mut down = Down::default();
            if let (Some(station), Some(start)) = (behind, start) {
                down.add(self.down(station as usize), start);
            }
            let causes = &mut self.station(node).waits.blocked;
            charge(causes, place, behind, seconds, down);
            return;
        }
        let setup: &Setup = self.setup;
        let suppliers = &setup.suppliers[node];
        let waits = &mut self.station(node).waits;
        waits.starved_seconds += seconds;
        if suppliers.is_empty() {
            return;
        }
        waits.starved_down.resize(suppliers.len(), Down::default());
        for (index, &supplier) in suppliers.iter().enumerate() {
            let down = self.down(supplier as usize);
            let waits = &mut self.station(node).waits;
            let start = waits.start[index];
            waits.starved_down[index].add(down, start);
        }
    }

    /// Charges the time for which a station was starved to the place from which the last part came.
    /// At the end of a run, in which no part has ended the wait, this is the part before.
    #[inline(never)]
    pub(super) fn end_starving(&mut self, node: usize) {
        self.end_wait(node);
        let setup: &Setup = self.setup;
        let waits = &mut self.station(node).waits;
        if waits.starved_seconds <= 0.0 {
            return;
        }
        let seconds = std::mem::take(&mut waits.starved_seconds);
        if let Some(supplier) = waits.supplier {
            let mut suppliers = setup.suppliers[node].iter();
            let index = suppliers.position(|other| *other == supplier);
            let down = index.and_then(|index| waits.starved_down.get(index));
            let down = down.copied().unwrap_or_default();
            charge(&mut waits.starved, supplier, None, seconds, down);
        }
        waits.starved_down.clear();
    }

    /// Counts the seconds for which a station waits in a line that rests, after its interval has
    /// ended: for the same places as in the interval.
    pub(super) fn wait_on(&mut self, node: usize, blocked: f64, starved: f64) {
        let waits = &mut self.station(node).waits;
        waits.starved_seconds += starved;
        if blocked > 0.0 {
            let (place, station) = waits.blocker;
            let down = Down::default();
            charge(&mut waits.blocked, place, station, blocked, down);
        }
    }

    /// The place for which the part of a station waits, the first one if there are several.
    #[inline]
    fn awaited_place(&self, node: usize) -> Option<usize> {
        let outlet = &self.nodes[node].outlet;
        match outlet.part.and(outlet.to)? {
            Way::To(place) => Some(place as usize),
            way @ Way::Choice(_) => self.setup.ways.to(&way).first().map(|to| *to as usize),
        }
    }

    /// The station at a place, or behind the full buffers and conveyors that begin there.
    fn station_behind(&self, mut place: usize) -> Option<usize> {
        for _ in 0..MAX_PLACES_BETWEEN {
            match &self.nodes[place].place {
                Place::Station(_) => return Some(place),
                Place::Buffer(_) | Place::Conveyor(_) | Place::Belt(_) => {
                    place = self.awaited_place(place)?;
                }
                Place::Source(_) | Place::Sink | Place::Store(_) => return None,
            }
        }
        None
    }

    /// The seconds for which a station has been down until now.
    fn down(&self, node: usize) -> Down {
        let Place::Station(station) = &self.nodes[node].place else {
            return Down::default();
        };
        let seconds = |activity| station.clock.seconds_at(self.now, activity);
        Down {
            failed: seconds(Activity::Failed) + seconds(Activity::FailedOffShift),
            off_shift: seconds(Activity::Idle),
        }
    }
}

/// For each node, whether it is a station that can fail or be off shift.
pub(super) fn can_be_down(line: &Line) -> Vec<bool> {
    let nodes = line.nodes.iter().enumerate();
    let can_be_down = nodes.map(|(index, node)| match &node.kind {
        NodeKind::Station(station) => {
            !station.failures.is_empty() || line.calendar_of(index).is_some()
        }
        _ => false,
    });
    can_be_down.collect()
}

/// For each station, the stations that can be down and from which parts come to it, directly or
/// through buffers and conveyors. Empty for other nodes.
pub(super) fn suppliers(line: &Line, can_be_down: &[bool]) -> Vec<Vec<u32>> {
    let passes_on = |node: usize| {
        matches!(
            line.nodes[node].kind,
            NodeKind::Buffer { .. } | NodeKind::Conveyor { .. }
        )
    };
    let of = |node: usize| {
        let (mut open, mut seen, mut found) = (vec![node], vec![node], Vec::new());
        while let Some(at) = open.pop() {
            for route in line.routes.iter().filter(|route| route.to == at) {
                if passes_on(route.from) {
                    if !seen.contains(&route.from) {
                        seen.push(route.from);
                        open.push(route.from);
                    }
                } else if can_be_down[route.from] && !found.contains(&(route.from as u32)) {
                    found.push(route.from as u32);
                }
            }
        }
        found.sort_unstable();
        found
    };
    let is_station = |node: usize| matches!(line.nodes[node].kind, NodeKind::Station(_));
    let nodes = 0..line.nodes.len();
    nodes
        .map(|node| {
            if is_station(node) {
                of(node)
            } else {
                Vec::new()
            }
        })
        .collect()
}
