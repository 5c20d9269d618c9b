//! A line as seen by its abstraction: places with room for parts, and the ways between them.
//!
//! A node of the line is one place, with two exceptions. A store is one place for incoming parts
//! and one for each type that leaves it; these places are independent of each other. A belt with a
//! contract that takes parts from other such belts has an extra place before it, as in the runner,
//! because a belt can hand over and take parts only in its own step.

use super::belt::{self, Room};
use super::losses;
use crate::undecided::UndecidedReason;
use linewright_language::contract::line::{
    Belt, BufferOrder, Choice, Line, Node, NodeKind, Supply,
};
use linewright_language::contract::machine::Between;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A place that holds parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The node's name, followed by the part type if the node has several places.
    pub name: String,
    /// Index of its node.
    pub node: usize,
    /// Kind of place.
    pub kind: PlaceKind,
    /// Whether it may take no part for a while although it has room: a station that can be off
    /// shift, or down without work.
    pub pauses: bool,
    /// Part types that can be in it and leave it, each with its possible destinations in source
    /// order.
    pub ways: Vec<Ways>,
    /// Places from which parts come.
    pub from: Vec<usize>,
}

/// Destinations of a part type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ways {
    /// Index of the type.
    pub part: usize,
    /// Destination places, each once; several only if conditions or a choice decide.
    pub to: Vec<usize>,
    /// The ways of which a part takes one. Conditions decide which, or chance, or the order of the
    /// parts.
    pub exits: Vec<Exit>,
}

/// One way onward, or several of which a part takes the first that is free.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exit {
    /// Destination places.
    pub to: Vec<usize>,
    /// Whether a part goes to the first of the destinations that has room, in this order.
    pub in_order: bool,
}

impl Ways {
    /// Pairs of a destination that belongs to one exit alone, and this exit, for the exits with
    /// several destinations: a part that goes there would have gone to any other destination of the
    /// exit that was free before.
    pub fn open(&self) -> impl Iterator<Item = (usize, &Exit)> {
        let open = self.exits.iter().filter(|exit| exit.to.len() > 1);
        open.flat_map(move |exit| {
            let own = move |to: &&usize| {
                let mut others = self.exits.iter().filter(|other| *other != exit);
                !others.any(|other| other.to.contains(to))
            };
            exit.to.iter().filter(own).map(move |to| (*to, exit))
        })
    }
}

/// Kind of a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlaceKind {
    /// Entry of parts of one type into the line.
    Supply {
        /// Index of the type.
        part: usize,
        /// Whether the next part is available as soon as the previous one has left; otherwise, some
        /// time can pass.
        always: bool,
        /// Number of parts of the type in the line at which the supply pauses; `None` if unlimited.
        most: Option<u32>,
    },
    /// Exit of parts from the line.
    End {
        /// Types that are finished here; others are rejected, or wait in a store for their next
        /// way.
        finishes: Vec<usize>,
        /// Types that leave the line here, finished or rejected.
        leaves: Vec<usize>,
    },
    /// A machine that works on one part at a time.
    Station {
        /// Its tasks.
        tasks: Vec<Work>,
    },
    /// A conveyor: parts travel in order.
    Conveyor {
        /// Capacity in parts.
        places: u32,
        /// With fewer parts than this on it, another one is eventually taken even while the first
        /// one waits; otherwise, possibly only after the first one has left. An accumulating
        /// conveyor takes as many as fit.
        sure: u32,
        /// Whether a machine moves it step by step, so that it hands over and takes parts only in
        /// its own steps.
        machine: bool,
    },
    /// A queue: parts wait in order.
    Room {
        /// Capacity in parts.
        capacity: u32,
        /// Whether it can take time until a part is ready to leave, or leaves the line because it
        /// has expired.
        dwells: bool,
    },
}

/// A task of a station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Work {
    /// Type of the part that leaves.
    pub part: usize,
    /// Whether the task accepts parts of this type as they are, without joining.
    pub plain: bool,
    /// Component types with counts; empty if the task joins nothing.
    pub bill: Vec<(usize, u32)>,
}

/// The places of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// All places, in node order.
    pub places: Vec<Place>,
    /// Names of the part types.
    pub types: Vec<String>,
    /// Indices of the end products' types.
    pub products: Vec<usize>,
    /// Number of parts of type `b` in one part of type `a`, at `[a][b]`; 1 if `a` is `b`.
    pub contents: Vec<Vec<u64>>,
}

impl Shape {
    /// Computes the places of a line and their possible contents.
    ///
    /// # Errors
    /// Returns the reason if something in the line has no abstraction.
    pub fn of(line: &Line) -> Result<Self, UndecidedReason> {
        if let Some(node) = losses::untreated(line) {
            return Err(UndecidedReason::because(format!(
                "{} loses parts",
                line.nodes[node].name
            )));
        }
        let mut places = Vec::new();
        // For each node: the place where parts arrive, and the place before a belt.
        let mut intake = vec![None; line.nodes.len()];
        let mut before = vec![None; line.nodes.len()];
        for (node, declared) in line.nodes.iter().enumerate() {
            let mut add = |name: String, kind| {
                places.push(Place {
                    name,
                    node,
                    kind,
                    pauses: pauses(line, node),
                    ways: Vec::new(),
                    from: Vec::new(),
                });
                places.len() - 1
            };
            if let NodeKind::Store { .. } = declared.kind {
                let leaving = (0..line.parts.len()).filter(|part| {
                    line.routes
                        .iter()
                        .any(|r| r.from == node && r.part == *part)
                });
                for part in leaving {
                    let name = format!("{}.{}", declared.name, line.parts[part].name);
                    add(name, stock(line, node, part));
                }
            }
            if belt(declared)
                && line
                    .routes
                    .iter()
                    .any(|r| r.to == node && belt(&line.nodes[r.from]))
            {
                let name = format!("{}.before", declared.name);
                before[node] = Some(add(
                    name,
                    PlaceKind::Room {
                        capacity: 1,
                        dwells: false,
                    },
                ));
            }
            let comes = line.routes.iter().any(|r| r.to == node);
            if let Some(kind) =
                Some(kind(line, node)).filter(|k| comes || !matches!(k, PlaceKind::End { .. }))
            {
                intake[node] = Some(add(declared.name.clone(), kind));
            }
        }
        look_at_belts(line, &mut places)?;
        let mut shape = Self {
            places,
            types: line.parts.iter().map(|p| p.name.clone()).collect(),
            products: line.products.clone(),
            contents: Self::contents(line),
        };
        shape.connect(line, &intake, &before)?;
        shape.slow_down(line);
        Ok(shape)
    }

    /// Lets time pass between the parts that a store gives only to sinks and stores. These are
    /// never full, so it makes no difference to anything else when such a part leaves.
    fn slow_down(&mut self, line: &Line) {
        let to_ends: Vec<bool> = (0..self.places.len())
            .map(|place| self.leads_to_ends_only(place))
            .collect();
        for (place, to_ends) in self.places.iter_mut().zip(to_ends) {
            let of_store = matches!(line.nodes[place.node].kind, NodeKind::Store { .. });
            if let PlaceKind::Supply { always, part, .. } = &mut place.kind
                && of_store
                && to_ends
                && !line.is_endless(place.node, *part)
            {
                *always = false;
            }
        }
    }

    /// Determines which parts can be where, starting from the supplies.
    fn connect(
        &mut self,
        line: &Line,
        intake: &[Option<usize>],
        before: &[Option<usize>],
    ) -> Result<(), UndecidedReason> {
        let mut there: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); self.places.len()];
        let mut open: Vec<(usize, usize)> = Vec::new();
        for (place, declared) in self.places.iter().enumerate() {
            if let PlaceKind::Supply { part, .. } = declared.kind {
                open.push((place, part));
            }
        }
        // `there` holds the types that arrive at a place, joined or not, and `leaves` those that
        // leave it.
        let mut leaves = there.clone();
        while let Some((place, part)) = open.pop() {
            if !leaves[place].insert(part) {
                continue;
            }
            let exits = self.exits(line, place, part, intake, before);
            let mut to: Vec<usize> = Vec::new();
            for destination in exits.iter().flat_map(|exit| &exit.to) {
                if !to.contains(destination) {
                    to.push(*destination);
                }
            }
            if to.is_empty() {
                return Err(UndecidedReason::because(format!(
                    "{} has no way onward from {}",
                    self.types[part], self.places[place].name
                )));
            }
            for next in &to {
                if !self.places[*next].from.contains(&place) {
                    self.places[*next].from.push(place);
                }
                there[*next].insert(part);
                match &self.places[*next].kind {
                    PlaceKind::Station { tasks } => {
                        let all = |bill: &[(usize, u32)]| {
                            bill.iter().all(|(c, _)| there[*next].contains(c))
                        };
                        let made = tasks.iter().filter(|t| {
                            t.plain && t.part == part || !t.bill.is_empty() && all(&t.bill)
                        });
                        open.extend(made.map(|t| (*next, t.part)));
                    }
                    PlaceKind::Conveyor { .. } | PlaceKind::Room { .. } => open.push((*next, part)),
                    PlaceKind::Supply { .. } | PlaceKind::End { .. } => {}
                }
            }
            self.places[place].ways.push(Ways { part, to, exits });
        }
        for (place, there) in self.places.iter_mut().zip(&there) {
            place.from.sort_unstable();
            place.ways.sort_by_key(|w| w.part);
            // A task for which no part ever comes is dropped.
            if let PlaceKind::Station { tasks } = &mut place.kind {
                tasks.retain(|task| {
                    let mut bill = task.bill.iter();
                    task.plain && there.contains(&task.part)
                        || bill.any(|(component, _)| there.contains(component))
                });
            }
        }
        self.check_order(line)?;
        self.check_limits(line)
    }

    /// Rejects buffers that parts do not leave in the order of their arrival, if it matters which
    /// part leaves first.
    fn check_order(&self, line: &Line) -> Result<(), UndecidedReason> {
        let ordered = self.places.iter().filter(|place| {
            matches!(&line.nodes[place.node].kind,
                NodeKind::Buffer { order, dwell, .. }
                    if *order != BufferOrder::FirstIn || dwell.least() < dwell.greatest())
        });
        let is_loss = |exit: &&Exit| {
            let mut to = exit.to.iter();
            to.any(|to| losses::is_loss(line, self.places[*to].node))
        };
        for place in ordered {
            let kept = |ways: &Ways| ways.exits.iter().filter(|exit| !is_loss(exit)).count();
            let one = place.ways.len() <= 1 && place.ways.iter().all(|ways| kept(ways) == 1);
            if !one {
                return Err(UndecidedReason::because(format!(
                    "parts of several types, or with several ways onward, overtake one another in {}",
                    place.name
                )));
            }
        }
        Ok(())
    }

    /// Checks that time passes somewhere on the way of every part; otherwise, everything else would
    /// wait for ever for parts that move at once. Work always takes time here; work without
    /// duration is found by [`crate::calls`], which knows the values of parts.
    pub(super) fn check_time(&self) -> Result<(), UndecidedReason> {
        let Some((from, to)) = self.timeless() else {
            return Ok(());
        };
        Err(UndecidedReason::because(format!(
            "parts go from {} to {} on and on, and no time passes",
            self.places[from].name, self.places[to].name
        )))
    }

    /// Two places between which parts can move for ever without time passing: on a cycle, or from
    /// an endless source or a stock to a sink or a store, which are never full.
    fn timeless(&self) -> Option<(usize, usize)> {
        let mut starts = self.places.iter().enumerate();
        starts.find_map(|(start, declared)| {
            let to = self.at_once_from(start, endless(declared))?;
            Some((start, to))
        })
    }

    /// A place that parts from `start` reach without time passing: `start` itself or, with
    /// `to_ends`, a sink or a store; `None` if there is none.
    fn at_once_from(&self, start: usize, to_ends: bool) -> Option<usize> {
        let moves_at_once = |place: usize| {
            matches!(
                self.places[place].kind,
                PlaceKind::Room { .. } | PlaceKind::Supply { .. }
            )
        };
        if !moves_at_once(start) {
            return None;
        }
        for first in self.places[start].ways.iter().map(|ways| ways.part) {
            let mut seen = BTreeSet::new();
            let mut open = self.onward(start, first);
            while let Some((place, part)) = open.pop() {
                let is_end = matches!(self.places[place].kind, PlaceKind::End { .. });
                if is_end && to_ends || (place, part) == (start, first) {
                    return Some(place);
                }
                if (is_end || moves_at_once(place)) && seen.insert((place, part)) {
                    open.extend(self.onward(place, part));
                }
            }
        }
        None
    }

    /// Places where a part of this type can be next. A store can give out again what it takes in.
    fn onward(&self, place: usize, part: usize) -> Vec<(usize, usize)> {
        let to = self.to(place, part).iter().map(|to| (*to, part));
        let mut next: Vec<(usize, usize)> = to.collect();
        if let PlaceKind::End { .. } = self.places[place].kind {
            let node = self.places[place].node;
            let given_out = self.places.iter().enumerate().filter(|(_, other)| {
                other.node == node
                    && matches!(other.kind, PlaceKind::Supply { part: of, .. } if of == part)
            });
            next.extend(given_out.map(|(other, _)| (other, part)));
        }
        next
    }

    /// Whether parts leave this place only for sinks and stores, which are never full.
    pub(super) fn leads_to_ends_only(&self, place: usize) -> bool {
        let is_end = |to: &usize| matches!(self.places[*to].kind, PlaceKind::End { .. });
        let mut ways = self.places[place].ways.iter();
        ways.all(|ways| ways.to.iter().all(is_end))
    }

    /// Checks the sources whose next part takes time. If such a part is overdue, it comes at once.
    /// Therefore, it must not be able to go on from the source, without time passing, to a place
    /// that is never full. Sources from which parts go directly to such places, and nowhere else,
    /// are allowed: they make no difference to anything else.
    pub(super) fn check_overdue(&self) -> Result<(), UndecidedReason> {
        for (start, declared) in self.places.iter().enumerate() {
            if matches!(declared.kind, PlaceKind::Supply { always: false, .. })
                && !self.leads_to_ends_only(start)
                && let Some(to) = self.at_once_from(start, true)
            {
                return Err(UndecidedReason::because(format!(
                    "parts go from {} to {} without any time passing",
                    declared.name, self.places[to].name
                )));
            }
        }
        Ok(())
    }

    /// Rejects lines in which a limit of work in process would count the parts of its type wrongly.
    fn check_limits(&self, line: &Line) -> Result<(), UndecidedReason> {
        for place in &self.places {
            let PlaceKind::Supply {
                part,
                most: Some(_),
                ..
            } = place.kind
            else {
                continue;
            };
            let name = &self.types[part];
            let others = self.places.iter().filter(|other| {
                matches!(other.kind, PlaceKind::Supply { part: p, .. } if self.contents[p][part] > 0)
            });
            if others.count() > 1 {
                return Err(UndecidedReason::because(format!(
                    "{name} comes from several places, one of which has a limit"
                )));
            }
            let waits = line.routes.iter().any(|r| {
                matches!(line.nodes[r.from].kind, NodeKind::Store { .. })
                    && self.contents[r.part][part] > 0
            });
            if waits {
                return Err(UndecidedReason::because(format!(
                    "{name} has a limit and may be in a store"
                )));
            }
        }
        Ok(())
    }

    /// The ways onward of a part type. A choice in turn or by chance is several ways.
    fn exits(
        &self,
        line: &Line,
        place: usize,
        part: usize,
        intake: &[Option<usize>],
        before: &[Option<usize>],
    ) -> Vec<Exit> {
        let node = self.places[place].node;
        if before[node] == Some(place) {
            let to: Vec<usize> = intake[node].into_iter().collect();
            return vec![Exit {
                to,
                in_order: false,
            }];
        }
        let mut found: Vec<Exit> = Vec::new();
        let mut add = |exit: Exit| {
            if !exit.to.is_empty() && !found.contains(&exit) {
                found.push(exit);
            }
        };
        let mut at = 0;
        while at < line.routes.len() {
            let first = at;
            at = line.end_of_way(first);
            let route = &line.routes[first];
            if (route.from, route.part) != (node, part) {
                continue;
            }
            let to = line.routes[first..at]
                .iter()
                .filter_map(|route| match before[route.to] {
                    Some(room) if belt(&line.nodes[node]) => Some(room),
                    _ => intake[route.to],
                });
            if line.waits_for_any(first) {
                add(Exit {
                    to: to.collect(),
                    in_order: route.choice.map(|c| &line.choices[c]) == Some(&Choice::FirstFree),
                });
            } else {
                to.for_each(|to| {
                    add(Exit {
                        to: vec![to],
                        in_order: false,
                    });
                });
            }
            if route.condition.is_none() {
                break;
            }
        }
        found
    }

    /// Number of parts of type `b` in one part of type `a`, at `[a][b]`; 1 if `a` is `b`.
    pub fn contents(line: &Line) -> Vec<Vec<u64>> {
        let types = line.parts.len();
        let mut contents = vec![vec![0_u64; types]; types];
        for (whole, row) in contents.iter_mut().enumerate() {
            let mut level = vec![(whole, 1_u64)];
            // Bills have no cycles (the resolver rejects them); the bound on the rounds ensures
            // termination in any case.
            for _ in 0..types {
                let mut below = Vec::new();
                for (part, count) in level {
                    row[part] = row[part].saturating_add(count);
                    let bill = line.parts[part].bill.iter();
                    below.extend(bill.map(|(c, n)| (*c, count.saturating_mul(u64::from(*n)))));
                }
                level = below;
            }
        }
        contents
    }

    /// Destinations of a part type from a place.
    pub fn to(&self, place: usize, part: usize) -> &[usize] {
        let ways = self.places[place].ways.iter().find(|w| w.part == part);
        ways.map_or(&[], |w| &w.to)
    }

    /// Types that can go from one place to another.
    pub fn between(&self, from: usize, to: usize) -> impl Iterator<Item = usize> {
        let ways = self.places[from].ways.iter();
        ways.filter(move |w| w.to.contains(&to)).map(|w| w.part)
    }

    /// Destinations of parts from this place.
    pub fn after(&self, place: usize) -> BTreeSet<usize> {
        let ways = self.places[place].ways.iter();
        ways.flat_map(|w| w.to.iter().copied()).collect()
    }

    /// Types that can come to a place.
    pub fn comes(&self, place: usize) -> BTreeSet<usize> {
        let from = self.places[place].from.iter();
        from.flat_map(|from| self.between(*from, place)).collect()
    }
}

/// Derives from the contracts of belts how much room is certain, once for all belts of a machine.
fn look_at_belts(line: &Line, places: &mut [Place]) -> Result<(), UndecidedReason> {
    let mut known: Vec<(&Belt, Room)> = Vec::new();
    for place in places {
        let PlaceKind::Conveyor { sure, .. } = &mut place.kind else {
            continue;
        };
        let NodeKind::Conveyor {
            belt: Some(belt), ..
        } = &line.nodes[place.node].kind
        else {
            continue;
        };
        let same = |other: &Belt| Arc::ptr_eq(&other.machine, &belt.machine);
        let room = match known.iter().find(|(other, _)| same(other)) {
            Some((_, room)) => *room,
            None => belt::room(belt).map_err(|limit| UndecidedReason {
                why: format!(
                    "the contract of {} is too large to determine its capacity: {limit}",
                    place.name
                ),
                limit: Some(limit),
            })?,
        };
        known.push((belt, room));
        match room {
            Room::Sure(number) => *sure = number,
            Room::TakesNone => {
                return Err(UndecidedReason::because(format!(
                    "the contract of {} does not guarantee that it takes a part when it is empty",
                    place.name
                )));
            }
            Room::BringsNone => {
                return Err(UndecidedReason::because(format!(
                    "the contract of {} does not guarantee that a part on it reaches its end",
                    place.name
                )));
            }
        }
    }
    Ok(())
}

fn belt(node: &Node) -> bool {
    matches!(node.kind, NodeKind::Conveyor { belt: Some(_), .. })
}

/// The parts of a type that a store gives out. Stock is assumed to last, unless parts of the type
/// also come in: then each part is available only once it has arrived.
fn stock(line: &Line, node: usize, part: usize) -> PlaceKind {
    let comes = line.routes.iter().any(|r| r.to == node && r.part == part);
    PlaceKind::Supply {
        part,
        always: !comes,
        most: None,
    }
}

/// Whether a node may take no part for a while although it has room. Failures by working time do
/// not count, unless they scrap the part: they interrupt work, which goes on after the repair.
fn pauses(line: &Line, node: usize) -> bool {
    let NodeKind::Station(station) = &line.nodes[node].kind else {
        return false;
    };
    let mut modes = station.failures.iter();
    line.calendar_of(node).is_some()
        || modes.any(|mode| mode.scraps_parts() || !matches!(mode.between, Between::Working(_)))
}

/// Whether there is always another part at once, however many were supplied. A stock counts as
/// endless: if all of it moved in one instant, no other event would ever come, and the guarantees
/// of the places would contradict each other.
fn endless(place: &Place) -> bool {
    matches!(place.kind, PlaceKind::Supply { always: true, .. })
}

fn kind(line: &Line, node: usize) -> PlaceKind {
    let leaves_again = |part: usize| line.routes.iter().any(|r| r.from == node && r.part == part);
    match &line.nodes[node].kind {
        NodeKind::Source { part, supply, most } => PlaceKind::Supply {
            part: *part,
            // Time passes between the instants of a table, even if many replacements do not wait.
            always: !matches!(supply, Supply::At { .. }) && line.is_endless(node, *part),
            most: *most,
        },
        NodeKind::Sink { reject, .. } => PlaceKind::End {
            finishes: (0..line.parts.len()).filter(|_| !reject).collect(),
            leaves: (0..line.parts.len()).collect(),
        },
        NodeKind::Store { .. } => {
            let stays: Vec<usize> = (0..line.parts.len())
                .filter(|p| !leaves_again(*p))
                .collect();
            PlaceKind::End {
                finishes: stays.clone(),
                leaves: stays,
            }
        }
        NodeKind::Station(station) => PlaceKind::Station {
            tasks: station
                .tasks
                .iter()
                .map(|t| work(line, node, t.part))
                .collect(),
        },
        NodeKind::Conveyor { places, belt, .. } => PlaceKind::Conveyor {
            places: *places,
            sure: *places,
            machine: belt.is_some(),
        },
        NodeKind::Buffer {
            capacity,
            dwell,
            shelf_life,
            ..
        } => PlaceKind::Room {
            capacity: *capacity,
            dwells: !dwell.is_zero() || shelf_life.is_some(),
        },
    }
}

/// The work of a task, as defined by
/// [`Task::part`](linewright_language::contract::line::Task::part).
fn work(line: &Line, node: usize, part: usize) -> Work {
    let bill = &line.parts[part].bill;
    Work {
        part,
        plain: bill.is_empty() || line.is_brought(node, part),
        bill: if line.is_joined_at(node, part) {
            bill.clone()
        } else {
            Vec::new()
        },
    }
}
