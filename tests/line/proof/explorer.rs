//! All behavior of a small line, state by state, implemented from the text of
//! `crates/line/src/lib.rs`: moving takes no time, everything else takes some. It shares nothing
//! with the abstraction but the line itself.

use linewright::contract::line::{Choice, Line, NodeKind, Route, Supply};
use std::collections::{BTreeSet, HashSet, VecDeque};

/// A part that waits at an outlet, by its type, and the destinations to one of which it goes.
type Offer = (usize, Vec<usize>);

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Holds {
    /// A source or sink, or a store: its stock does not run out.
    Nothing,
    Station {
        at_work: Option<usize>,
        /// No part in work, and none that waits to leave.
        free: bool,
        /// By task and line of its bill, the number present.
        there: Vec<Vec<u32>>,
    },
    Queue {
        parts: Vec<usize>,
        /// For a conveyor: its first place is free again.
        open: bool,
    },
}

/// What waits for a node: an outlet, or a complete bill of the node's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Waits {
    Outlet(usize),
    Bill(usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct State {
    holds: Vec<Holds>,
    offers: Vec<Option<Offer>>,
    /// By node, the longest wait first.
    waiting: Vec<Vec<Waits>>,
    /// By type: in the line, or kept by a source.
    in_line: Vec<u32>,
}

/// Results of the exploration of a line.
#[derive(Debug, PartialEq, Eq)]
pub struct Explored {
    /// Whether nothing can move in some reachable state.
    pub stuck: bool,
    /// Queues that can be full.
    pub full: BTreeSet<usize>,
    /// Number of states.
    pub states: usize,
}

pub struct Explorer<'a> {
    line: &'a Line,
    /// Node and, at a store, type.
    outlets: Vec<(usize, Option<usize>)>,
    /// By node and task: its components, and whether it takes its type as it is.
    tasks: Vec<Vec<Task>>,
}

/// A type, its components, and whether it is taken as it is.
type Task = (usize, Vec<(usize, u32)>, bool);

impl<'a> Explorer<'a> {
    pub fn new(line: &'a Line) -> Self {
        let mut outlets = Vec::new();
        let mut all_tasks = Vec::new();
        for (node, declared) in line.nodes.iter().enumerate() {
            let comes = |part: usize| line.routes.iter().any(|r| r.to == node && r.part == part);
            let mut own = Vec::new();
            match &declared.kind {
                NodeKind::Sink { .. } => {}
                NodeKind::Store { stock } => {
                    for (part, _) in stock {
                        assert!(!comes(*part), "not for stores that give out what comes in");
                        outlets.push((node, Some(*part)));
                    }
                }
                NodeKind::Station(station) => {
                    let tasks = &station.tasks;
                    for task in tasks {
                        let bill = &line.parts[task.part].bill;
                        let joins = !comes(task.part)
                            || bill
                                .iter()
                                .all(|(c, _)| comes(*c) && tasks.iter().all(|t| t.part != *c));
                        own.push((
                            task.part,
                            if joins { bill.clone() } else { Vec::new() },
                            bill.is_empty() || comes(task.part),
                        ));
                    }
                    outlets.push((node, None));
                }
                _ => outlets.push((node, None)),
            }
            all_tasks.push(own);
        }
        Self {
            line,
            outlets,
            tasks: all_tasks,
        }
    }

    fn first(&self) -> State {
        let holds =
            self.line
                .nodes
                .iter()
                .enumerate()
                .map(|(node, declared)| match declared.kind {
                    NodeKind::Station(_) => Holds::Station {
                        at_work: None,
                        free: true,
                        there: self.tasks[node]
                            .iter()
                            .map(|(_, bill, _)| vec![0; bill.len()])
                            .collect(),
                    },
                    NodeKind::Conveyor { .. } | NodeKind::Buffer { .. } => Holds::Queue {
                        parts: Vec::new(),
                        open: true,
                    },
                    _ => Holds::Nothing,
                });
        State {
            holds: holds.collect(),
            offers: vec![None; self.outlets.len()],
            waiting: vec![Vec::new(); self.line.nodes.len()],
            in_line: vec![0; self.line.parts.len()],
        }
    }

    /// Where a part may go: by any of the routes up to the first one without a condition. Of the
    /// places of a choice, it goes to whichever is free, or to one that is determined before.
    fn ways(&self, node: usize, part: usize) -> Vec<Vec<usize>> {
        let mut found: Vec<Vec<usize>> = Vec::new();
        let routes = &self.line.routes;
        for (at, route) in routes.iter().enumerate() {
            if (route.from, route.part) != (node, part) {
                continue;
            }
            let alike = |r: &&Route| r.choice == route.choice;
            let any = route.choice.map(|c| &self.line.choices[c]);
            match any {
                Some(Choice::FirstFree | Choice::ShortestQueue) => {
                    if at == 0 || routes[at - 1].choice != route.choice {
                        let way = routes[at..].iter().take_while(alike);
                        found.push(way.map(|r| r.to).collect());
                    }
                }
                _ => found.push(vec![route.to]),
            }
            let last =
                route.choice.is_none() || !routes[at + 1..].iter().take(1).any(|r| alike(&r));
            if route.condition.is_none() && last {
                break;
            }
        }
        found.sort();
        found.dedup();
        found
    }

    fn room(&self, state: &State, node: usize, part: usize) -> bool {
        match (&self.line.nodes[node].kind, &state.holds[node]) {
            (NodeKind::Buffer { capacity, .. }, Holds::Queue { parts, .. }) => {
                parts.len() < *capacity as usize
            }
            (NodeKind::Conveyor { places, .. }, Holds::Queue { parts, open }) => {
                *open && parts.len() < *places as usize
            }
            (_, Holds::Station { free, .. }) => {
                let plain = self.tasks[node]
                    .iter()
                    .any(|(t, _, plain)| *plain && *t == part);
                self.component(state, node, part).is_some() || *free && plain
            }
            (NodeKind::Sink { .. } | NodeKind::Store { .. }, _) => true,
            _ => false,
        }
    }

    fn component(&self, state: &State, node: usize, part: usize) -> Option<(usize, usize)> {
        let Holds::Station { there, .. } = &state.holds[node] else {
            return None;
        };
        for (task, (_, bill, _)) in self.tasks[node].iter().enumerate() {
            for (line, (wanted, count)) in bill.iter().enumerate() {
                if *wanted == part && there[task][line] < *count {
                    return Some((task, line));
                }
            }
        }
        None
    }

    fn offer(&self, state: &State, outlet: usize, part: usize) -> Vec<State> {
        let ways = self.ways(self.outlets[outlet].0, part);
        let mut found = Vec::new();
        for way in ways {
            let mut next = state.clone();
            next.offers[outlet] = Some((part, way.clone()));
            for to in &way {
                next.waiting[*to].push(Waits::Outlet(outlet));
            }
            // Of several places it goes at once to one that has room for it and nobody else; to the
            // first of them, unless the shortest queue decides.
            let own = |to: &&usize| {
                let first = self.served_next(&next, **to);
                first.is_some_and(|at| next.waiting[**to][at] == Waits::Outlet(outlet))
            };
            let free: Vec<usize> = way.iter().filter(own).copied().collect();
            if way.len() < 2 || free.is_empty() {
                found.push(next);
                continue;
            }
            let node = self.outlets[outlet].0;
            let first_free = self.line.routes.iter().any(|r| {
                let choice = r.choice.map(|c| &self.line.choices[c]);
                (r.from, r.part) == (node, part) && choice == Some(&Choice::FirstFree)
            });
            let taken = if first_free { &free[..1] } else { &free[..] };
            for to in taken {
                let place = next.waiting[*to]
                    .iter()
                    .position(|w| *w == Waits::Outlet(outlet));
                found.push(self.go(&next, *to, place.unwrap()));
            }
        }
        found
    }

    /// Which of those that wait for a node is served next, as a position in `waiting`: the one of
    /// the longest wait that there is room for.
    fn served_next(&self, state: &State, node: usize) -> Option<usize> {
        let free = matches!(state.holds[node], Holds::Station { free: true, .. });
        state.waiting[node].iter().position(|waits| match waits {
            Waits::Outlet(outlet) => state.offers[*outlet]
                .as_ref()
                .is_some_and(|(part, _)| self.room(state, node, *part)),
            Waits::Bill(_) => free,
        })
    }

    /// Events that happen at once.
    fn at_once(&self, state: &State) -> Vec<State> {
        let mut found = Vec::new();
        for (outlet, (node, kind)) in self.outlets.iter().enumerate() {
            if state.offers[outlet].is_some() {
                continue;
            }
            match (&self.line.nodes[*node].kind, &state.holds[*node]) {
                (NodeKind::Source { part, supply, most }, _) => {
                    let timed =
                        matches!(supply, Supply::Every { interval, .. } if !interval.is_zero());
                    if !timed && most.is_none_or(|most| state.in_line[*part] < most) {
                        let mut made = state.clone();
                        made.in_line[*part] += 1;
                        found.extend(self.offer(&made, outlet, *part));
                    }
                }
                (NodeKind::Store { .. }, _) => {
                    let part = kind.unwrap();
                    found.extend(self.offer(state, outlet, part));
                }
                (NodeKind::Buffer { .. }, Holds::Queue { parts, .. }) => {
                    if let Some(part) = parts.first() {
                        found.extend(self.offer(state, outlet, *part));
                    }
                }
                _ => {}
            }
        }
        for node in 0..self.line.nodes.len() {
            if let Some(place) = self.served_next(state, node) {
                found.push(self.go(state, node, place));
            }
        }
        found
    }

    fn go(&self, state: &State, node: usize, place: usize) -> State {
        let mut next = state.clone();
        let outlet = match next.waiting[node].remove(place) {
            Waits::Bill(task) => {
                if let Holds::Station {
                    at_work,
                    free,
                    there,
                } = &mut next.holds[node]
                {
                    there[task].fill(0);
                    *free = false;
                    *at_work = Some(self.tasks[node][task].0);
                }
                return next;
            }
            Waits::Outlet(outlet) => outlet,
        };
        let (part, way) = next.offers[outlet].take().unwrap();
        for to in way {
            next.waiting[to].retain(|waits| *waits != Waits::Outlet(outlet));
        }
        match &mut next.holds[self.outlets[outlet].0] {
            Holds::Station { free, .. } => *free = true,
            Holds::Queue { parts, .. } => {
                assert_eq!(parts.remove(0), part);
            }
            Holds::Nothing => {}
        }
        let component = self.component(&next, node, part);
        match &mut next.holds[node] {
            Holds::Queue { parts, open } => {
                parts.push(part);
                *open = !matches!(self.line.nodes[node].kind, NodeKind::Conveyor { .. });
            }
            Holds::Station {
                at_work,
                free,
                there,
            } => {
                if let Some((task, line)) = component {
                    there[task][line] += 1;
                    let bill = &self.tasks[node][task].1;
                    if bill
                        .iter()
                        .zip(&there[task])
                        .all(|((_, count), there)| count == there)
                    {
                        next.waiting[node].push(Waits::Bill(task));
                    }
                } else {
                    assert!(*free, "a station takes one part at a time");
                    *free = false;
                    *at_work = Some(part);
                }
            }
            Holds::Nothing => self.leave(&mut next, part),
        }
        next
    }

    fn leave(&self, state: &mut State, part: usize) {
        state.in_line[part] = state.in_line[part].saturating_sub(1);
        for (component, count) in &self.line.parts[part].bill {
            for _ in 0..*count {
                self.leave(state, *component);
            }
        }
    }

    /// Events that take time, once nothing moves at once.
    fn in_time(&self, state: &State) -> Vec<State> {
        let mut found = Vec::new();
        for (outlet, (node, _)) in self.outlets.iter().enumerate() {
            match (&self.line.nodes[*node].kind, &state.holds[*node]) {
                (
                    _,
                    Holds::Station {
                        at_work: Some(part),
                        ..
                    },
                ) => {
                    let mut done = state.clone();
                    if let Holds::Station { at_work, .. } = &mut done.holds[*node] {
                        *at_work = None;
                    }
                    found.extend(self.offer(&done, outlet, *part));
                }
                (NodeKind::Conveyor { .. }, Holds::Queue { parts, open }) => {
                    if let (Some(part), None) = (parts.first(), &state.offers[outlet]) {
                        found.extend(self.offer(state, outlet, *part));
                    }
                    if !open {
                        let mut opened = state.clone();
                        if let Holds::Queue { open, .. } = &mut opened.holds[*node] {
                            *open = true;
                        }
                        found.push(opened);
                    }
                }
                _ => {}
            }
        }
        found.extend(self.due(state));
        found
    }

    /// The next parts of sources that take their time. A part that is overdue, because the one
    /// before it had to wait, comes at once, while other parts move.
    fn due(&self, state: &State) -> Vec<State> {
        let mut found = Vec::new();
        for (outlet, (node, _)) in self.outlets.iter().enumerate() {
            if let NodeKind::Source { part, supply, most } = &self.line.nodes[*node].kind {
                let timed = matches!(supply, Supply::Every { interval, .. } if !interval.is_zero());
                let may = most.is_none_or(|most| state.in_line[*part] < most);
                if timed && may && state.offers[outlet].is_none() {
                    let mut made = state.clone();
                    made.in_line[*part] += 1;
                    found.extend(self.offer(&made, outlet, *part));
                }
            }
        }
        found
    }

    /// All reachable states; `None` if there are more than `most`.
    pub fn explore(&self, most: usize) -> Option<Explored> {
        let counted = self
            .line
            .nodes
            .iter()
            .any(|n| matches!(n.kind, NodeKind::Source { most: Some(_), .. }));
        let bare = |mut state: State| {
            // Without a limit the number does not matter.
            if !counted {
                state.in_line.fill(0);
            }
            state
        };
        let first = self.first();
        let mut seen: HashSet<State> = HashSet::from([first.clone()]);
        let mut open = VecDeque::from([first]);
        let mut explored = Explored {
            stuck: false,
            full: BTreeSet::new(),
            states: 0,
        };
        while let Some(state) = open.pop_front() {
            for (node, holds) in state.holds.iter().enumerate() {
                let room = match self.line.nodes[node].kind {
                    NodeKind::Conveyor { places: n, .. } | NodeKind::Buffer { capacity: n, .. } => {
                        n as usize
                    }
                    _ => continue,
                };
                if matches!(holds, Holds::Queue { parts, .. } if parts.len() == room) {
                    explored.full.insert(node);
                }
            }
            let mut next = self.at_once(&state);
            if next.is_empty() {
                next = self.in_time(&state);
                explored.stuck |= next.is_empty();
            } else {
                next.extend(self.due(&state));
            }
            for state in next.into_iter().map(bare) {
                if seen.insert(state.clone()) {
                    open.push_back(state);
                }
            }
            if seen.len() > most {
                return None;
            }
        }
        explored.states = seen.len();
        Some(explored)
    }
}
