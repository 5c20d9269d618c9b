//! Determines how long the stations of a line work, and whether parts can keep moving at one
//! instant.
//!
//! Moving, waiting in a buffer without a dwell time or in a store, and work shorter than
//! [`MIN_SECONDS`] take no time. The graph distinguishes the values of parts, so that a part that
//! goes round three times and then leaves is not a cycle. Parts can move for ever at one instant if
//! there is
//!
//! - a cycle of edges that take no time, or
//! - a path of such edges from a source that always has another part to a sink or a store, since
//!   neither is ever full. The stock of a store is finite, but a very large stock counts as
//!   endless. A joined part comes as often as the slowest of its components.

use super::attractor::attractor;
use super::station::Answer;
use super::walk::{Stage, Vertex, Walk};
use linewright_language::contract::MIN_SECONDS;
use linewright_language::contract::line::NodeKind;
use std::collections::BTreeSet;

/// A way on which parts keep moving without time passing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Timeless {
    /// Start node.
    pub from: usize,
    /// End node; the same as the start for a cycle.
    pub to: usize,
    /// Whether parts certainly stay on this way; if false, values, chance or the order of parts can
    /// lead them to a place where time passes.
    pub always: bool,
    /// Stations that can work on a part without time passing.
    pub stations: Vec<usize>,
}

/// The least and the greatest of some durations, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least.
    pub least: f64,
    /// Greatest.
    pub greatest: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let none = Self {
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
        };
        values.fold(none, |range, value| Self {
            least: range.least.min(value),
            greatest: range.greatest.max(value),
        })
    }
}

/// How long a station with a machine works on a part of one type, over all calls that were tried.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkTime {
    /// Index of the node.
    pub node: usize,
    /// Index of the part type.
    pub part: usize,
    /// Duration of the work.
    pub work: Range,
    /// The part of it in which some action is active.
    pub actions: Range,
    /// The part of it in which no action is active: each control step takes the machine's `step`.
    pub control: Range,
}

/// The durations of the work of all stations with machines, by node and part type. Parts that are
/// refused in every call are left out.
pub(super) fn work_times(walk: &Walk<'_>) -> Vec<WorkTime> {
    let mut times = Vec::new();
    for (node, station) in walk.stations.iter().enumerate() {
        let (Some(station), NodeKind::Station(declared)) = (station, &walk.line.nodes[node].kind)
        else {
            continue;
        };
        for (index, task) in declared.tasks.iter().enumerate() {
            let calls = station.calls.iter().filter(|call| call.task == index);
            let answers: Vec<_> = calls.flat_map(|c| c.answers.values()).flatten().collect();
            if answers.is_empty() {
                continue;
            }
            let range = |seconds: &dyn Fn(&Answer) -> f64| {
                Range::of(answers.iter().map(|answer| seconds(answer)))
            };
            times.push(WorkTime {
                node,
                part: task.part,
                work: range(&|a| a.seconds.0),
                actions: range(&|a| a.seconds.0 - a.control.0),
                control: range(&|a| a.control.0),
            });
        }
    }
    times
}

/// An edge of the walk: a possible next step of a part.
struct Edge {
    to: usize,
    /// Whether the step can happen without time passing.
    free: bool,
    /// Whether the step never takes time.
    always_free: bool,
}

/// The graph of a walk, in which each edge tells whether it can take no time, or never takes any.
struct Timed<'a> {
    walk: &'a Walk<'a>,
    edges: Vec<Vec<Edge>>,
}

/// Finds a way on which no time passes. The run time is linear in the edges of the walk, except for
/// joined parts.
pub(super) fn timeless(walk: &Walk<'_>) -> Option<Timeless> {
    let all = 0..walk.vertices.len();
    let timed = Timed {
        walk,
        edges: all.map(|at| edges(walk, at)).collect(),
    };
    let (from, to, always) = timed.cycle().or_else(|| timed.endless())?;
    let stations = 0..walk.stations.len();
    Some(Timeless {
        from,
        to,
        always,
        stations: stations.filter(|node| is_quick(walk, *node)).collect(),
    })
}

/// Durations of the answers to a call.
fn seconds(walk: &Walk<'_>, node: usize, call: usize) -> impl Iterator<Item = f64> {
    let station = walk.stations[node].iter();
    let answers = station.flat_map(move |d| d.calls[call].answers.values());
    answers.flatten().map(|a| a.seconds.0)
}

/// Whether a station can work on a part in no time.
fn is_quick(walk: &Walk<'_>, node: usize) -> bool {
    if let NodeKind::Station(station) = &walk.line.nodes[node].kind
        && station.machine.is_none()
    {
        let mut times = station.tasks.iter().filter_map(|task| task.time.as_ref());
        return times.any(|time| !time.takes_time());
    }
    let calls = walk.stations[node].as_ref().map_or(0, |d| d.calls.len());
    (0..calls).any(|call| seconds(walk, node, call).any(|s| s < MIN_SECONDS))
}

fn edges(walk: &Walk<'_>, at: usize) -> Vec<Edge> {
    let vertex = &walk.vertices[at];
    let rests = match &walk.line.nodes[vertex.node].kind {
        NodeKind::Conveyor { .. } => true,
        NodeKind::Buffer { dwell, .. } => dwell.takes_time(),
        _ => false,
    };
    let edge = |to: usize| {
        let (free, always_free) = match (walk.vertices[to].stage, vertex.call) {
            (Stage::Served, Some(call)) => {
                let mut known = seconds(walk, vertex.node, call);
                let quick = |s: f64| s < MIN_SECONDS;
                let free = seconds(walk, vertex.node, call).any(quick);
                (free, free && known.all(quick))
            }
            (Stage::Served, None) if vertex.takes_time => (false, false),
            (Stage::Leaves, _) if rests => (false, false),
            _ => (true, true),
        };
        Edge {
            to,
            free,
            always_free,
        }
    };
    vertex.next.iter().copied().map(edge).collect()
}

impl Timed<'_> {
    fn vertex(&self, at: usize) -> &Vertex {
        &self.walk.vertices[at]
    }

    /// Finds a cycle of edges that take no time: what is left after repeatedly removing vertices
    /// without outgoing or without incoming edges.
    fn cycle(&self) -> Option<(usize, usize, bool)> {
        let count = self.edges.len();
        let mut before = vec![Vec::new(); count];
        for (from, edges) in self.edges.iter().enumerate() {
            for edge in edges.iter().filter(|e| e.free) {
                before[edge.to].push(from);
            }
        }
        let after = |at: usize| self.edges[at].iter().filter(|e| e.free).map(|e| e.to);
        let mut there = vec![true; count];
        let mut onward: Vec<usize> = (0..count).map(|at| after(at).count()).collect();
        let mut towards: Vec<usize> = before.iter().map(Vec::len).collect();
        let mut open: Vec<usize> = (0..count).collect();
        while let Some(at) = open.pop() {
            if !there[at] || onward[at] > 0 && towards[at] > 0 {
                continue;
            }
            there[at] = false;
            for next in after(at) {
                towards[next] -= 1;
                open.push(next);
            }
            for previous in &before[at] {
                onward[*previous] -= 1;
                open.push(*previous);
            }
        }
        let left = (0..count).filter(|at| there[*at]);
        let node = left.map(|at| self.vertex(at).node).min()?;
        let caught = self.never_out_of(&there, |_| false);
        Some((node, node, caught.contains(&true)))
    }

    /// Finds a way from an endless source to a place that is never full.
    fn endless(&self) -> Option<(usize, usize, bool)> {
        let is_end = |at: usize| {
            let vertex = self.vertex(at);
            let kind = &self.walk.line.nodes[vertex.node].kind;
            vertex.stage == Stage::Comes
                && matches!(kind, NodeKind::Sink { .. } | NodeKind::Store { .. })
        };
        // By vertex: the node of a source from which parts reach it in no time.
        let mut origin: Vec<Option<usize>> = vec![None; self.edges.len()];
        let mut open: Vec<usize> = Vec::new();
        for at in self.walk.origins.iter().filter(|at| self.is_endless(**at)) {
            origin[*at] = Some(self.vertex(*at).node);
            open.push(*at);
        }
        let origins = open.clone();
        let mut ends = BTreeSet::new();
        while let Some(at) = open.pop() {
            if is_end(at) {
                let end = self.vertex(at).node;
                if origin[at].is_some_and(|from| !self.walk.line.ends_supply(from, end)) {
                    ends.insert((origin[at], end));
                }
                continue;
            }
            for edge in self.edges[at].iter().filter(|e| e.free) {
                if origin[edge.to].is_none() && self.is_complete(edge.to, &origin) {
                    origin[edge.to] = origin[at];
                    open.push(edge.to);
                }
            }
        }
        let (from, to) = ends.into_iter().next()?;
        let reached: Vec<bool> = origin.iter().map(Option::is_some).collect();
        let caught = self.never_out_of(&reached, is_end);
        Some((from?, to, origins.iter().any(|at| caught[*at])))
    }

    /// Whether a source or a store always has another part at once, however many have left it.
    fn is_endless(&self, origin: usize) -> bool {
        let origin = self.vertex(origin);
        self.walk.line.is_endless(origin.node, origin.part)
    }

    /// Whether all components of a joined part have come.
    fn is_complete(&self, at: usize, origin: &[Option<usize>]) -> bool {
        let joined = self.vertex(at);
        let bill = &self.walk.line.parts[joined.part].bill;
        joined.stage != Stage::Joined
            || bill.iter().all(|(kind, _)| {
                let mut known = origin.iter().enumerate();
                known.any(|(from, origin)| {
                    let (of, there) = (self.vertex(from), origin.is_some());
                    there && of.part == *kind && of.next.contains(&at)
                })
            })
    }

    /// By vertex: whether parts there never reach a place where time passes, and leave the set
    /// `there` only at an end.
    fn never_out_of(&self, there: &[bool], is_end: impl Fn(usize) -> bool) -> Vec<bool> {
        let takes_time = |at: usize| {
            let edges = &self.edges[at];
            !is_end(at) && (edges.is_empty() || !edges.iter().all(|e| e.always_free))
        };
        let out = (0..there.len()).filter(|at| !there[*at] || takes_time(*at));
        let out = attractor(&self.walk.before(), out, |at| (!is_end(at)).then_some(1));
        out.into_iter().map(|out| !out).collect()
    }
}
