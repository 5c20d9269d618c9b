//! Moves parts from node to node: outlets, admission, and order.
//!
//! Each node has an *outlet* for the part that would leave next; a store has one for each type that
//! leaves it. Once a part is at an outlet, its way is fixed. The part moves when the next node
//! admits it; until then, it waits in that node's queue. A node that has handed on a part, or that
//! might have received a part to hand on, is put on a list of nodes to examine again. The list is
//! processed until nothing moves any more at this instant.
//!
//! # Turns
//!
//! A part that is ready to leave and finds no room becomes a *request* to the next node. Requests
//! are numbered as they begin. A part on a belt becomes a request in the step in which it is seen
//! at the last place. The components of a complete bill count as a request from the arrival of the
//! last one. **Room is given to the oldest request that the node would take**; a newcomer waits as
//! long as there is such a request. So no request is overtaken by a later one.
//!
//! A belt can hand over a part only when it is stepped. When a belt has its turn, it is woken, and
//! the room is reserved until its step, even if another part could go at once. This must not last
//! for ever, whatever a controller does. A belt therefore goes to the end of the queue
//!
//! - if it had its turn in more than `places + 2` steps and did not hand over its part,
//! - if its controller refused a step in which it had its turn, or
//! - if it falls asleep without handing over its part.
//!
//! The belt is then skipped until something changes at the node. So as long as a node has room that
//! some request waits for, one of the following holds: the node will be examined, a belt that has
//! its turn will be stepped, or every part that could come has had a turn and did not come.

use super::part::PartIndex;
use super::queue::Request;
use super::ways::Way;
use super::{Node, Place, Run};
use crate::trace::EventKind;
use linewright_language::contract::line::{Line, NodeKind};
use std::ops::Range;

/// The point where a node's next part waits to leave.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outlet {
    /// The node.
    pub node: usize,
    /// The only part type that the outlet of a store serves; `None` at other nodes.
    pub kind: Option<usize>,
    /// The part that would leave; `None` if the outlet is empty.
    pub part: Option<PartIndex>,
    /// Where it goes; `None` if no route applies.
    pub to: Option<Way>,
    /// Sequence number of the request of a part that the next one has overtaken, and whose turn it
    /// takes.
    pub since: Option<u64>,
}

/// The outlets of a line, all empty, and the index of each node's first outlet, followed by the
/// number of outlets.
pub(super) fn outlets(line: &Line) -> (Vec<Outlet>, Vec<usize>) {
    let mut outlets = Vec::new();
    let mut first = Vec::new();
    for (node, declared) in line.nodes.iter().enumerate() {
        first.push(outlets.len());
        let outlet = |kind| Outlet {
            node,
            kind,
            part: None,
            to: None,
            since: None,
        };
        match declared.kind {
            NodeKind::Sink { .. } => {}
            NodeKind::Store { .. } => outlets.extend(
                (0..line.parts.len())
                    .filter(|&part| {
                        line.routes
                            .iter()
                            .any(|route| route.from == node && route.part == part)
                    })
                    .map(|part| outlet(Some(part))),
            ),
            _ => outlets.push(outlet(None)),
        }
    }
    first.push(outlets.len());
    (outlets, first)
}

impl Run<'_> {
    /// The outlets of a node.
    pub(super) fn outlets_of(&self, node: usize) -> Range<usize> {
        self.setup.first_outlet[node]..self.setup.first_outlet[node + 1]
    }

    /// Schedules the node to be examined again.
    pub(super) fn look_at(&mut self, node: usize) {
        self.agenda.push(node);
    }

    /// Examines nodes until nothing moves any more at this instant.
    pub(super) fn settle(&mut self) {
        while self.end.is_none()
            && let Some(node) = self.agenda.pop()
        {
            self.examine(node);
            if self.progress.is_stuck_at_instant() {
                break;
            }
        }
    }

    /// Moves a node's next parts to its outlets, or lets a station join. Then gives the node's room
    /// to the parts that wait for it.
    fn examine(&mut self, node: usize) {
        let Node { place, outlet, .. } = &self.nodes[node];
        let outlet = *outlet;
        match place {
            Place::Station(station) => {
                if station.joins_some() {
                    self.station_ready(node);
                }
                self.serve(node);
                self.begin_wait(node);
                return;
            }
            Place::Belt(_) | Place::Sink => {}
            Place::Buffer(_) => {
                while self.is_free(outlet)
                    && let Place::Buffer(buffer) = &self.nodes[node].place
                    && let Some(next) = buffer.first()
                {
                    self.offer(outlet, next);
                }
            }
            Place::Source(_) => {
                while self.is_free(outlet)
                    && let Some(next) = self.make(node)
                {
                    self.offer(outlet, next);
                }
            }
            Place::Conveyor(_) => {
                while self.is_free(outlet)
                    && let Some(next) = self.conveyor_end(node)
                {
                    self.offer(outlet, next);
                }
                self.serve(node);
                self.reopen_later(node);
                return;
            }
            Place::Store(_) => {
                for outlet in self.outlets_of(node) {
                    while self.is_free(outlet)
                        && let Some(next) = self.give_out(node, outlet)
                    {
                        self.offer(outlet, next);
                    }
                }
            }
        }
        self.serve(node);
    }

    /// Whether an outlet can take another part, and the run goes on.
    #[inline]
    fn is_free(&self, outlet: usize) -> bool {
        self.outlets[outlet].part.is_none()
            && self.end.is_none()
            && !self.progress.is_stuck_at_instant()
    }

    /// Handles a part that is ready to leave: chooses its way, then moves it or lets it wait.
    pub(super) fn offer(&mut self, outlet: usize, part: PartIndex) {
        let kind = self.parts[part].kind;
        let node = self.outlets[outlet].node;
        let way = self.way(node, part);
        let offered = &mut self.outlets[outlet];
        let since = offered.since.take();
        offered.part = Some(part);
        offered.to = way;
        let Some(way) = way else { return };
        if let Some(to) = way.only {
            let to = to as usize;
            let admitted = self.admits(to, kind, node);
            if admitted && !self.others_first(to, None) && !self.bill_first(to, kind) {
                self.transfer(outlet, to);
                return;
            }
            self.request(outlet, to, kind, since);
            if admitted {
                // An older request or a complete bill goes first, so the node is examined to serve
                // it.
                self.look_at(to);
            }
        } else if let Some(to) = self.free_place(outlet, way) {
            self.transfer(outlet, to);
        } else {
            let setup = self.setup;
            for &to in setup.ways.to(way) {
                self.request(outlet, to, kind, since);
                if self.admits(to, kind, node) {
                    self.look_at(to);
                }
            }
        }
    }

    /// The place to which a newcomer can go at once, of those at the ends of its way.
    fn free_place(&self, outlet: usize, way: Way) -> Option<usize> {
        let Outlet { node, part, .. } = self.outlets[outlet];
        let kind = self.parts[part?].kind;
        self.choose(way, |to: &usize| {
            self.admits(*to, kind, node)
                && !self.others_first(*to, Some(outlet))
                && !self.bill_first(*to, kind)
        })
    }

    /// Registers that the outlet waits for a node. With `since`, it takes the turn of an earlier
    /// request with this sequence number.
    pub(super) fn request(&mut self, outlet: usize, to: usize, kind: usize, since: Option<u64>) {
        let mut request = Request {
            order: 0,
            outlet: outlet as u32,
            kind: kind as u32,
            from: self.outlets[outlet].node as u32,
            declined: false,
        };
        match since {
            None => {
                request.order = self.next_number();
                self.nodes[to].requests.push(request);
            }
            Some(order) => {
                request.order = order;
                self.nodes[to].requests.insert(request);
            }
        }
        match self.nodes[to].place {
            Place::Conveyor(_) => self.reopen_later(to),
            Place::Belt(_) => self.wake(to),
            _ => {}
        }
    }

    /// Next sequence number for requests and complete bills.
    #[inline]
    pub(super) fn next_number(&mut self) -> u64 {
        self.requests += 1;
        self.requests
    }

    /// Moves an outlet that had its turn to the end of a node's queue. Returns whether the outlet
    /// was in the queue.
    pub(super) fn lose_turn(&mut self, to: usize, outlet: usize) -> bool {
        let Some(request) = self.nodes[to].requests.withdraw(outlet) else {
            return false;
        };
        let request = Request {
            order: self.next_number(),
            declined: true,
            ..request
        };
        self.nodes[to].requests.push(request);
        true
    }

    /// Whether a node has room for a part of this type coming from `from`. A belt takes parts only
    /// when it is stepped, except from another belt; see `belt.rs`.
    #[inline]
    pub(super) fn admits(&self, node: usize, kind: usize, from: usize) -> bool {
        match &self.nodes[node].place {
            Place::Source(_) => false,
            Place::Sink | Place::Store(_) => true,
            Place::Buffer(buffer) => buffer.has_room(),
            Place::Conveyor(_) => self.conveyor_admits(node),
            Place::Belt(belt) => {
                matches!(self.nodes[from].place, Place::Belt(_)) && belt.inlet.is_none()
            }
            Place::Station(station) => station.admits(kind),
        }
    }

    /// Whether a part that has waited longer for a node than outlet `own` (or than a newcomer)
    /// could go there now.
    #[inline]
    pub(super) fn others_first(&self, node: usize, own: Option<usize>) -> bool {
        let requests = &self.nodes[node].requests;
        if requests.is_empty() {
            return false;
        }
        let mut earlier = requests
            .iter()
            .take_while(|request| Some(request.outlet as usize) != own);
        earlier.any(|request| self.admits(node, request.kind as usize, request.from as usize))
    }

    /// Whether the components of a complete bill wait at a node for the same work as a newcomer of
    /// this type. They arrived before it.
    #[inline]
    fn bill_first(&self, node: usize, kind: usize) -> bool {
        match &self.nodes[node].place {
            Place::Station(station) => station.has_complete_bill() && !station.lacks(kind),
            _ => false,
        }
    }

    /// Admits waiting parts to a node as long as there is room; see [Turns](self#turns).
    #[inline]
    fn serve(&mut self, node: usize) {
        let mut next = 0;
        while let Some(&request) = self.nodes[node].requests.get(next) {
            if self.end.is_some() || self.progress.is_stuck_at_instant() {
                return;
            }
            let from = request.from as usize;
            if !self.admits(node, request.kind as usize, from) {
                next += 1;
            } else if matches!(self.nodes[from].place, Place::Belt(_)) {
                let request = self.nodes[node].requests.get_mut(next);
                if request.is_some_and(|request| std::mem::take(&mut request.declined)) {
                    next += 1;
                    continue;
                }
                self.wake(from);
                break;
            } else {
                self.nodes[node].requests.remove(next);
                self.transfer(request.outlet as usize, node);
                next = 0;
            }
        }
    }

    /// Moves an outlet's part to this place at the end of its way. The caller has checked that the
    /// place has room for it, and has removed the outlet's request to it.
    #[inline(never)]
    pub(super) fn transfer(&mut self, outlet: usize, to: usize) {
        let Outlet {
            node,
            ref mut part,
            to: ref mut way,
            ..
        } = self.outlets[outlet];
        let (Some(part), Some(way)) = (part.take(), way.take()) else {
            return;
        };
        if way.choice.is_some() {
            self.take_chosen_way(outlet, to, way);
        }
        self.progress.count_movement();
        match &mut self.nodes[node].place {
            Place::Buffer(buffer) => buffer.take(self.now),
            Place::Station(_) => {
                self.end_wait(node);
                self.station_left(node);
                self.parts[part].came_from = Some(node as u32);
            }
            Place::Store(store) => {
                store.left(self.parts[part].kind);
                self.enter(node, part);
            }
            Place::Source(source) => {
                let to = &self.line.nodes[to].kind;
                let is_lost = matches!(to, NodeKind::Sink { reject: true, .. });
                source.left(self.now, is_lost);
                self.enter(node, part);
            }
            Place::Conveyor(_) => self.conveyor_left(node),
            Place::Belt(_) => self.belt_left(node),
            Place::Sink => {}
        }
        self.record(node, Some(part), EventKind::Left);
        self.look_at(node);
        self.arrive(node, to, part);
    }

    /// A part takes one of the routes between which it could choose: it no longer waits at the ends
    /// of the others.
    fn take_chosen_way(&mut self, outlet: usize, to: usize, way: Way) {
        let Some(choice) = way.choice else { return };
        self.choosers[choice as usize].chosen();
        let from = self.outlets[outlet].node;
        let setup = self.setup;
        for &other in setup.ways.to(way) {
            let withdrawn = other != to && self.nodes[other].requests.withdraw(outlet).is_some();
            if withdrawn && matches!(self.nodes[from].place, Place::Belt(_)) {
                // Room may have been reserved for the belt; see [Turns](self#turns).
                self.look_at(other);
            }
        }
    }

    #[inline]
    fn arrive(&mut self, from: usize, node: usize, part: PartIndex) {
        match &mut self.nodes[node].place {
            Place::Sink => self.sink(node, part),
            Place::Store(_) => self.store(node, part),
            Place::Buffer(buffer) => {
                let arrival = buffer.put(part, &self.parts[part], self.now);
                self.record(node, Some(part), EventKind::Arrived);
                self.buffer_arrival(node, &arrival);
            }
            Place::Station(_) => self.station_arrival(node, part),
            Place::Conveyor(_) => self.conveyor_arrival(node, part),
            Place::Belt(_) => self.belt_arrival(from, node, part),
            Place::Source(_) => {}
        }
    }

    /// Lets another part of a buffer leave next than the one that waits, if any. It takes the turn
    /// of that part.
    pub(super) fn overtake(&mut self, node: usize) {
        let setup = self.setup;
        let outlet = setup.first_outlet[node];
        let Outlet { part, to, .. } = &mut self.outlets[outlet];
        if part.take().is_some()
            && let Some(way) = to.take()
        {
            for &to in setup.ways.to(way) {
                let withdrawn = self.nodes[to].requests.withdraw(outlet);
                let since = withdrawn.map(|request| request.order);
                self.outlets[outlet].since = since.or(self.outlets[outlet].since);
            }
        }
        self.look_at(node);
    }
}
