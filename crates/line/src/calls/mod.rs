//! What a line requires of its stations: every value that a part can have at a station, every state
//! that the station can be in, and its answers.
//!
//! The proof of a line ([`super::abstraction`]) omits properties and times. What it takes for
//! granted is proved here: that no part is refused, that no value leaves its range, that every part
//! has a way onward, and that time passes. `docs/proof.md` has the theorem.
//!
//! ```text
//! Line, controllers ─walk→ Walk (a graph of parts with their values) ─examine→ Calls ─findings→ Diagnostics
//! ```
//!
//! # How
//!
//! A station's answer to a call is determined by its controllers, its state and the values of the
//! part. So the calls of a line are explored one by one, with the same interpreter that the station
//! libraries are tested against ([`linewright_station::interpret`]). The order in which parts reach
//! a station is left open: every possible part is tried in every state that calls can lead to
//! (`station.rs`). Chance leads to one branch per outcome. All other information about times and
//! orders is ignored, so the exploration covers at least everything that can happen.
//!
//! - Within the limits, the exploration is exact except for the order of parts. Therefore, a
//!   refusal is an error if it does not depend on the station's state, and a warning if it does.
//! - What could not be explored is undecided, and the line is not proved.
//!
//! If several routes remain for parts of a type, a proof of progress requires that each of them is
//! taken again and again. Chance guarantees this almost surely if every new part has a chance to
//! reach the route whatever the stations' states are (`chance.rs`).

mod attractor;
mod belt;
mod chance;
mod findings;
mod orders;
mod premises;
mod station;
mod time;
mod unread;
mod walk;

pub use findings::in_turn;
pub use premises::{Premise, premises};
pub use time::{Range, Timeless, WorkTime};

use crate::undecided::UndecidedReason;
use linewright_core::diagnostics::Diagnostic;
use linewright_language::contract::line::{Line, NodeKind};
use linewright_language::contract::machine::Machine;
use linewright_solver::game::Limits;
use linewright_station::interpret::Interpreter;
use std::cmp::Ordering;

/// Bounds of the exploration.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Maximum number of combinations of part values, over all places.
    pub values: usize,
    /// Maximum number of controller steps.
    pub steps: u64,
}

/// Result of exploring the calls of a line.
#[derive(Debug, Default)]
pub struct Calls {
    /// Refused parts, values out of range, parts without a way onward: any of these prevents a
    /// proof of the line.
    pub findings: Vec<Diagnostic>,
    /// Harmless findings: routes that no part takes, and stores that no part leaves.
    pub remarks: Vec<Diagnostic>,
    /// Stations and belts for which it was not decided whether they refuse a part, each with the
    /// reason.
    pub undecided: Vec<(usize, UndecidedReason)>,
    /// By route: whether a part can take the route. All are set if something was not decided.
    pub taken: Vec<bool>,
    /// By route: whether every part for which the route's condition is evaluated takes the route.
    pub always: Vec<bool>,
    /// By route: whether chance guarantees that the route is taken again and again as long as parts
    /// come.
    pub by_chance: Vec<bool>,
    /// A way on which parts keep moving without time passing; `None` if there is none.
    pub timeless: Option<Timeless>,
    /// How long the stations with machines work on parts of each type.
    pub work_times: Vec<WorkTime>,
}

impl Calls {
    /// The line without routes that no part takes, and without conditions that always hold.
    pub fn simplified(&self, line: &Line) -> Line {
        let routes = line
            .routes
            .iter()
            .enumerate()
            .filter(|(at, _)| self.taken[*at])
            .map(|(at, route)| {
                let mut route = route.clone();
                if self.always[at] {
                    route.condition = None;
                }
                route
            });
        Line {
            routes: routes.collect(),
            ..line.clone()
        }
    }
}

/// Explores the calls of a line accepted by the resolver. `interpreter` returns an interpreter of a
/// station's machine with its controllers. If it returns `None`, nothing is known about that
/// station.
pub fn examine(
    line: &Line,
    interpreter: impl Fn(&Machine) -> Option<Interpreter>,
    bounds: &Bounds,
    limits: &Limits,
) -> Calls {
    let walk = walk::Walk::new(line, interpreter, bounds).explore(limits);
    let taken = vec![true; line.routes.len()];
    let by_chance = (0..line.routes.len()).map(|r| is_alone(line, &taken, r));
    let mut calls = Calls {
        findings: Vec::new(),
        remarks: Vec::new(),
        undecided: walk.undecided.clone(),
        always: vec![false; line.routes.len()],
        by_chance: by_chance.collect(),
        taken,
        timeless: time::timeless(&walk),
        work_times: time::work_times(&walk),
    };
    if walk.is_complete() {
        walk.routes(&mut calls);
        chance::branches(&walk, &mut calls);
    }
    findings::add(&walk, &mut calls);
    belt::examine(line, limits, &mut calls);
    calls
}

/// A number carried by a part, with a total order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Real(pub f64);

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Real {}

impl PartialOrd for Real {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Real {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Converts to plain numbers.
fn plain(numbers: &[Real]) -> Vec<f64> {
    numbers.iter().map(|n| n.0).collect()
}

/// Converts to ordered numbers.
fn ordered(numbers: &[f64]) -> Vec<Real> {
    numbers.iter().map(|n| Real(*n)).collect()
}

/// Whether no other route that parts take leads its part from its starting node to another node.
/// The routes of a choice count as one.
fn is_alone(line: &Line, taken: &[bool], route: usize) -> bool {
    let way = line.first_of_way(route)..line.end_of_way(route);
    let route = &line.routes[route];
    let mut others = line.routes.iter().zip(taken).enumerate();
    others.all(|(index, (other, taken))| {
        let is_other = (other.from, other.part) == (route.from, route.part);
        !taken || !is_other || way.contains(&index) || other.to == route.to
    })
}

/// The machine of a station; `None` if the node is not a station, or has no machine.
fn machine_of(line: &Line, node: usize) -> Option<&Machine> {
    match &line.nodes[node].kind {
        NodeKind::Station(station) => station.machine.as_deref(),
        _ => None,
    }
}
