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
use linewright_language::contract::line::{Line, NodeKind};
use std::ops::Range;

/// The point where a node's next part waits to leave. The outlet of a node has the number of the
/// node; those of stores, one for each type that leaves them, are numbered from there on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outlet {
    /// The part that would leave; `None` if the outlet is empty.
    pub part: Option<PartIndex>,
    /// Where it goes; `None` if no route applies.
    pub to: Option<Way>,
}

/// The outlets of stores: for each, the store, and the only part type that it serves.
pub(super) fn store_outlets(line: &Line) -> Vec<(usize, usize)> {
    let nodes = line.nodes.iter().enumerate();
    let stores = nodes.filter(|(_, declared)| matches!(declared.kind, NodeKind::Store { .. }));
    let outlets =
        stores.flat_map(|(store, _)| (0..line.parts.len()).map(move |kind| (store, kind)));
    let leaves = |&(store, kind): &(usize, usize)| {
        let mut routes = line.routes.iter();
        routes.any(|route| route.from == store && route.part == kind)
    };
    outlets.filter(leaves).collect()
}

impl Run<'_> {
    /// The outlets of a node.
    pub(super) fn outlets_of(&self, node: usize) -> Range<usize> {
        match &self.nodes[node].place {
            Place::Store(store) => {
                let first = self.nodes.len();
                first + store.outlets.start..first + store.outlets.end
            }
            _ => node..node + 1,
        }
    }

    /// An outlet.
    #[inline]
    pub(super) fn outlet(&self, outlet: usize) -> &Outlet {
        match self.nodes.get(outlet) {
            Some(node) => &node.outlet,
            None => &self.store_outlets[outlet - self.nodes.len()],
        }
    }

    /// An outlet.
    #[inline]
    pub(super) fn outlet_mut(&mut self, outlet: usize) -> &mut Outlet {
        let count = self.nodes.len();
        match self.nodes.get_mut(outlet) {
            Some(node) => &mut node.outlet,
            None => &mut self.store_outlets[outlet - count],
        }
    }

    /// Schedules the node to be examined again.
    #[inline]
    pub(super) fn look_at(&mut self, node: usize) {
        self.agenda.push(node, &mut self.nodes[node].is_listed);
    }

    /// Whether nothing must move any more, because the run ends.
    #[inline]
    fn is_over(&self) -> bool {
        self.progress.is_stuck_at_instant()
    }

    /// Examines nodes until nothing moves any more at this instant.
    pub(super) fn settle(&mut self) {
        if self.is_over() {
            return;
        }
        while let Some(node) = self.agenda.pop() {
            self.examine(node);
            if self.is_over() {
                break;
            }
        }
    }

    /// Moves a node's next parts to its outlets, or lets a station join. Then gives the node's room
    /// to the parts that wait for it.
    #[inline]
    fn examine(&mut self, node: usize) {
        let examined = &mut self.nodes[node];
        examined.is_listed = false;
        match &examined.place {
            Place::Station(station) if !station.joins_some() => {}
            Place::Station(_) => {
                self.station_ready(node);
                if self.is_over() {
                    return;
                }
            }
            Place::Buffer(_) => {
                while let examined = &self.nodes[node]
                    && examined.outlet.part.is_none()
                    && let Place::Buffer(buffer) = &examined.place
                    && let Some(next) = buffer.first()
                {
                    self.offer(node, node, next);
                    if self.is_over() {
                        return;
                    }
                }
            }
            _ => return self.examine_otherwise(node),
        }
        self.serve(node);
        self.begin_wait(node);
    }

    /// Examines a node that is neither a station nor a buffer.
    #[inline(never)]
    fn examine_otherwise(&mut self, node: usize) {
        match &self.nodes[node].place {
            Place::Source(_) => {
                while self.is_free(node)
                    && let Some(next) = self.make(node)
                {
                    self.offer(node, node, next);
                }
            }
            Place::Conveyor(_) => {
                while self.is_free(node)
                    && let Some(next) = self.conveyor_end(node)
                {
                    self.offer(node, node, next);
                }
            }
            Place::Store(_) => {
                for outlet in self.outlets_of(node) {
                    while self.is_free(outlet)
                        && let Some(next) = self.give_out(node, outlet)
                    {
                        self.offer(node, outlet, next);
                    }
                }
            }
            Place::Belt(_) | Place::Sink | Place::Station(_) | Place::Buffer(_) => {}
        }
        if !self.is_over() {
            self.serve_several(node);
            self.reopen_later(node);
        }
    }

    /// Whether an outlet can take another part, and the run goes on.
    fn is_free(&self, outlet: usize) -> bool {
        self.outlet(outlet).part.is_none() && !self.is_over()
    }

    /// Handles a part that is ready to leave: chooses its way, then moves it or lets it wait.
    ///
    /// Most parts go to a place for which nobody waits, or are the first to wait for a station or a
    /// buffer without room. That is decided here, and everything else in [`Self::offer_in_turn`].
    pub(super) fn offer(&mut self, node: usize, outlet: usize, part: PartIndex) {
        let kind = self.parts[part].kind;
        let Some(to) = self.setup.ways.always(node, kind) else {
            return self.offer_in_turn(node, outlet, part);
        };
        let to = to as usize;
        let Node {
            place, requests, ..
        } = &self.nodes[to];
        let has_room = match place {
            Place::Buffer(buffer) => buffer.has_room(),
            Place::Station(station) if !station.joins_some() => station.takes_alone(kind),
            Place::Sink => true,
            _ => return self.offer_in_turn(node, outlet, part),
        };
        if !requests.is_empty() {
            self.offer_in_turn(node, outlet, part);
        } else if has_room {
            self.hand_over(node, to, part);
        } else {
            self.wait_for(node, outlet, part, kind, to);
        }
    }

    /// Lets a part wait at an outlet for the only place to which it goes: a buffer or a station for
    /// which nobody waits.
    #[inline(never)]
    fn wait_for(&mut self, node: usize, outlet: usize, part: PartIndex, kind: usize, to: usize) {
        let offered = Outlet {
            part: Some(part),
            to: Some(Way::To(to as u32)),
        };
        let waiting = &mut self.nodes[node];
        let (since, is_station) = match &mut waiting.place {
            Place::Buffer(buffer) => (buffer.turn.take(), false),
            place => (None, matches!(place, Place::Station(_))),
        };
        if outlet == node {
            waiting.outlet = offered;
        } else {
            *self.outlet_mut(outlet) = offered;
        }
        self.parts[part].waits_since = self.now;
        let request = self.new_request(node, outlet, kind, since);
        self.nodes[to].requests.insert_only(request);
        if is_station {
            self.begin_wait(node);
        }
    }

    /// Handles a part that is ready to leave, and that may have to choose, or to let others go
    /// first.
    #[inline(never)]
    fn offer_in_turn(&mut self, node: usize, outlet: usize, part: PartIndex) {
        let kind = self.parts[part].kind;
        self.parts[part].waits_since = self.now;
        let Some(way) = self.way(node, part) else {
            self.turn(node);
            self.outlet_mut(outlet).part = Some(part);
            return;
        };
        let is_free = |to: &usize| self.admits(*to, kind, node) && self.is_first(*to, kind);
        if let Some(to) = self.choose(way, is_free) {
            if let Way::Choice(_) = way {
                self.take_chosen_way(node, outlet, to, way);
            }
            self.hand_over(node, to, part);
            return;
        }
        let offered = self.outlet_mut(outlet);
        offered.part = Some(part);
        offered.to = Some(way);
        let since = self.turn(node);
        for &to in self.setup.ways.to(&way) {
            let to = to as usize;
            self.request(node, outlet, to, kind, since);
            if self.admits(to, kind, node) {
                // An older request or a complete bill goes first, so the node is examined to serve
                // it.
                self.look_at(to);
            }
        }
        self.begin_wait(node);
    }

    /// Takes the sequence number of the request of a part that the next part of a buffer has
    /// overtaken.
    #[inline]
    fn turn(&mut self, node: usize) -> Option<u64> {
        match &mut self.nodes[node].place {
            Place::Buffer(buffer) => buffer.turn.take(),
            _ => None,
        }
    }

    /// Registers that the outlet of a node that is no belt waits for another node. It takes the
    /// turn of an earlier request with the sequence number `since`, if there is one.
    #[inline]
    fn request(&mut self, from: usize, outlet: usize, to: usize, kind: usize, since: Option<u64>) {
        let request = self.new_request(from, outlet, kind, since);
        self.register(to, request);
    }

    /// The request of an outlet of a node that is no belt.
    #[inline]
    fn new_request(
        &mut self,
        from: usize,
        outlet: usize,
        kind: usize,
        since: Option<u64>,
    ) -> Request {
        Request {
            order: since.unwrap_or_else(|| self.next_number()),
            outlet: outlet as u32,
            kind: kind as u32,
            from: from as u32,
            is_belt: false,
            declined: false,
        }
    }

    /// Registers a request to a node.
    #[inline]
    pub(super) fn register(&mut self, to: usize, request: Request) {
        let awaited = &mut self.nodes[to];
        awaited.requests.insert(request);
        if let Place::Conveyor(_) | Place::Belt(_) = awaited.place {
            self.expect(to);
        }
    }

    /// Lets a conveyor or a belt take a part that waits for it.
    #[inline(never)]
    fn expect(&mut self, node: usize) {
        match self.nodes[node].place {
            Place::Conveyor(_) => self.reopen_later(node),
            Place::Belt(_) => self.wake(node),
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
        self.nodes[to].requests.insert(request);
        true
    }

    /// Whether a node has room for a part of this type coming from `from`. A belt takes parts only
    /// when it is stepped, except from another belt; see `belt.rs`.
    #[inline]
    pub(super) fn admits(&self, node: usize, kind: usize, from: usize) -> bool {
        match &self.nodes[node].place {
            Place::Buffer(buffer) => buffer.has_room(),
            Place::Station(station) => station.admits(kind),
            place => self.admits_otherwise(place, from),
        }
    }

    /// The same for a place that is neither a station nor a buffer.
    #[inline(never)]
    fn admits_otherwise(&self, place: &Place, from: usize) -> bool {
        match place {
            Place::Source(_) | Place::Station(_) | Place::Buffer(_) => false,
            Place::Sink | Place::Store(_) => true,
            Place::Conveyor(conveyor) => conveyor.admits(self.now),
            Place::Belt(belt) => {
                matches!(self.nodes[from].place, Place::Belt(_)) && belt.inlet.is_none()
            }
        }
    }

    /// Whether no part that came before a newcomer of this type would take its room at a node.
    #[inline]
    fn is_first(&self, node: usize, kind: usize) -> bool {
        let Node {
            place, requests, ..
        } = &self.nodes[node];
        let bill_first = match place {
            Place::Station(station) => station.joins_some() && station.bill_first(kind),
            _ => false,
        };
        !bill_first && (requests.is_empty() || !self.others_first(node, None))
    }

    /// Whether a part that has waited longer for a node than outlet `own` (or than a newcomer)
    /// could go there now.
    #[inline(never)]
    pub(super) fn others_first(&self, node: usize, own: Option<usize>) -> bool {
        let requests = self.nodes[node].requests.iter();
        let mut earlier = requests.take_while(|request| Some(request.outlet as usize) != own);
        earlier.any(|request| self.admits(node, request.kind as usize, request.from as usize))
    }

    /// Admits waiting parts to a node as long as there is room; see [Turns](self#turns).
    #[inline]
    fn serve(&mut self, node: usize) {
        let awaited = &mut self.nodes[node];
        if awaited.requests.is_empty() {
            return;
        }
        let Some(&request) = awaited.requests.only() else {
            return self.serve_several(node);
        };
        let admits = match &awaited.place {
            Place::Buffer(buffer) if !request.is_belt => buffer.has_room(),
            Place::Station(station) if !request.is_belt => station.admits(request.kind as usize),
            _ => return self.serve_several(node),
        };
        if admits {
            awaited.requests.clear();
            self.transfer(request.from as usize, request.outlet as usize, node);
        }
    }

    /// The same for any number of requests, also those of belts, to any place.
    #[inline(never)]
    fn serve_several(&mut self, node: usize) {
        let mut next = 0;
        while let Some(&request) = self.nodes[node].requests.get(next) {
            let from = request.from as usize;
            if !self.admits(node, request.kind as usize, from) {
                next += 1;
            } else if request.is_belt {
                let request = self.nodes[node].requests.get_mut(next);
                if request.is_some_and(|request| std::mem::take(&mut request.declined)) {
                    next += 1;
                    continue;
                }
                self.wake(from);
                break;
            } else {
                self.nodes[node].requests.remove(next);
                self.transfer(from, request.outlet as usize, node);
                if self.is_over() {
                    break;
                }
                next = 0;
            }
        }
    }

    /// Moves an outlet's part to this place at the end of its way. The caller has checked that the
    /// place has room for it, and has removed the outlet's request to it.
    #[inline]
    pub(super) fn transfer(&mut self, from: usize, outlet: usize, to: usize) {
        let left = self.outlet_mut(outlet);
        let (Some(part), Some(way)) = (left.part.take(), left.to.take()) else {
            return;
        };
        if let Way::Choice(_) = way {
            self.take_chosen_way(from, outlet, to, way);
        }
        self.hand_over(from, to, part);
    }

    /// Moves a part from one node to another.
    #[inline(never)]
    fn hand_over(&mut self, from: usize, to: usize, part: PartIndex) {
        self.progress.count_movement();
        let now = self.now;
        let left = &mut self.nodes[from];
        self.agenda.push(from, &mut left.is_listed);
        match &mut left.place {
            Place::Buffer(buffer) => buffer.take(now),
            Place::Station(station) => {
                self.parts[part].came_from = Some(from as u32);
                if station.waits.is_waiting() {
                    self.end_wait(from);
                    self.station(from).clear(now);
                } else {
                    station.clear(now);
                }
            }
            _ => self.leave_otherwise(from, to, part),
        }
        self.record_movement(from, to, part);
        let reached = &mut self.nodes[to];
        match &mut reached.place {
            Place::Buffer(buffer) if buffer.is_plain() => {
                // Its outlet is empty if it was empty.
                if buffer.put(part, now) {
                    self.agenda.push(to, &mut reached.is_listed);
                }
            }
            Place::Station(_) => self.station_arrival(to, part),
            _ => self.arrive_otherwise(from, to, part),
        }
    }

    /// A part arrives at a node that is neither a station nor a plain buffer.
    #[inline(never)]
    fn arrive_otherwise(&mut self, from: usize, to: usize, part: PartIndex) {
        match &self.nodes[to].place {
            Place::Sink => self.sink(to, part),
            Place::Store(_) => self.store(to, part),
            Place::Conveyor(_) => self.conveyor_arrival(to, part),
            Place::Belt(_) => self.belt_arrival(from, to, part),
            Place::Buffer(_) => self.buffer_arrival(to, part),
            Place::Source(_) | Place::Station(_) => {}
        }
    }

    /// A part leaves a node that is neither a station nor a buffer.
    #[inline(never)]
    fn leave_otherwise(&mut self, from: usize, to: usize, part: PartIndex) {
        match &mut self.nodes[from].place {
            Place::Store(store) => {
                store.left(self.parts[part].kind);
                self.enter(from, part);
            }
            Place::Source(source) => {
                let to = &self.line.nodes[to].kind;
                let is_lost = matches!(to, NodeKind::Sink { reject: true, .. });
                source.left(self.now, is_lost);
                self.enter(from, part);
            }
            Place::Conveyor(conveyor) => conveyor.left(self.now),
            Place::Belt(_) => self.belt_left(from),
            Place::Sink | Place::Station(_) | Place::Buffer(_) => {}
        }
    }

    /// A part takes one of the routes between which it could choose: it no longer waits at the ends
    /// of the others.
    #[inline(never)]
    fn take_chosen_way(&mut self, from: usize, outlet: usize, to: usize, way: Way) {
        let setup = self.setup;
        let Some(choice) = setup.ways.choice(way) else {
            return;
        };
        self.choosers[choice].chosen();
        for &other in setup.ways.to(&way) {
            let other = other as usize;
            let withdrawn = other != to && self.nodes[other].requests.withdraw(outlet).is_some();
            if withdrawn && matches!(self.nodes[from].place, Place::Belt(_)) {
                // Room may have been reserved for the belt; see [Turns](self#turns).
                self.look_at(other);
            }
        }
    }

    /// Lets another part of a buffer leave next than the one that waits, if any. It takes the turn
    /// of that part.
    pub(super) fn overtake(&mut self, node: usize) {
        let setup = self.setup;
        let outlet = &mut self.nodes[node].outlet;
        if outlet.part.take().is_some()
            && let Some(way) = outlet.to.take()
        {
            for &to in setup.ways.to(&way) {
                let withdrawn = self.nodes[to as usize].requests.withdraw(node);
                if let (Some(request), Place::Buffer(buffer)) =
                    (withdrawn, &mut self.nodes[node].place)
                {
                    buffer.turn = Some(request.order);
                }
            }
        }
        self.look_at(node);
    }
}
