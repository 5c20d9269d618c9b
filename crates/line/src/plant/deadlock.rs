//! Finds parts that can never move again, although other parts of the line still do: a deadlock in
//! a part of the line.
//!
//! A line in which nothing happens any more ends; see `blocked.rs`. If a source still loses parts,
//! if parts expire, or if another part of the line works, it does not end. Then it is computed
//! which parts may still move. This is a least fixed point: a part may leave its place if the place
//! for which it waits may take it some day, and a place may take a part if it has room, or if
//! something in it may go. What depends on times, draws, conditions or controllers counts as
//! possible: repairs and later shifts come, rest ends, and a source makes what it can. Parts that
//! are not found this way can never move again, whatever happens.

use super::part::PartIndex;
use super::station::Phase;
use super::{Place, Run};
use crate::bottleneck::Deadlock;
use crate::trace::End;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::NodeKind;

/// What may still happen in a run from now on.
pub(super) struct Prospects {
    types: usize,
    /// By outlet: whether its part may leave some day. Without a part, not used.
    leaves: Vec<bool>,
    /// By node and part type: whether such a part may still arrive.
    arrives: Vec<bool>,
    /// By node and part type: whether the node holds such a part.
    holds: Vec<bool>,
}

impl Prospects {
    /// Whether a part of this type may still arrive at a node.
    pub(super) fn arrives(&self, node: usize, kind: usize) -> bool {
        self.arrives[node * self.types + kind]
    }

    fn has_some(&self, node: usize, kind: usize) -> bool {
        self.holds[node * self.types + kind] || self.arrives(node, kind)
    }
}

impl Run<'_> {
    /// Computes what may still happen.
    fn prospects(&self) -> Prospects {
        let types = self.line.parts.len();
        let mut prospects = Prospects {
            types,
            leaves: vec![false; self.nodes.len() + self.store_outlets.len()],
            arrives: vec![false; self.nodes.len() * types],
            holds: vec![false; self.nodes.len() * types],
        };
        for node in 0..self.nodes.len() {
            for part in self.held(node) {
                prospects.holds[node * types + self.parts[part].kind] = true;
            }
        }
        // In lines, prospects spread along the routes, and room against them. The direction
        // alternates, so that few rounds suffice.
        let mut is_forward = true;
        loop {
            let mut changed = false;
            let outlets = prospects.leaves.len();
            for index in 0..outlets.max(self.line.routes.len()) {
                let at = |count: usize| (index < count).then_some(index);
                let turn = |count: usize| {
                    at(count).map(|index| if is_forward { index } else { count - 1 - index })
                };
                if let Some(outlet) = turn(outlets) {
                    changed |= self.note_leaving(outlet, &mut prospects);
                }
                if let Some(route) = turn(self.line.routes.len()) {
                    changed |= self.note_arrival(route, &mut prospects);
                }
            }
            if !changed {
                return prospects;
            }
            is_forward = !is_forward;
        }
    }

    /// Notes that the part at an outlet may leave, if this was not known. Returns whether it was
    /// noted.
    fn note_leaving(&self, outlet: usize, prospects: &mut Prospects) -> bool {
        if prospects.leaves[outlet] {
            return false;
        }
        let waiting = self.outlet(outlet);
        let Some(part) = waiting.part else {
            return false;
        };
        let kind = self.parts[part].kind;
        let expires = match self.nodes.get(outlet).map(|node| &node.place) {
            Some(Place::Buffer(buffer)) => buffer.has_shelf_life(),
            _ => false,
        };
        let to = waiting
            .to
            .as_ref()
            .map_or(&[][..], |way| self.setup.ways.to(way));
        let mut places = to.iter().map(|to| *to as usize);
        let leaves = expires || places.any(|to| self.may_admit(to, kind, prospects));
        prospects.leaves[outlet] = leaves;
        leaves
    }

    /// The same for the arrival of a part by a route.
    fn note_arrival(&self, route: usize, prospects: &mut Prospects) -> bool {
        let route = &self.line.routes[route];
        let new = !prospects.arrives(route.to, route.part)
            && self.may_depart(route.from, route.part, prospects)
            && self.may_admit(route.to, route.part, prospects);
        if new {
            prospects.arrives[route.to * prospects.types + route.part] = true;
        }
        new
    }

    /// Whether a part that waits at the outlet of a node that is no store may leave; true if none
    /// waits.
    fn gets_free(&self, node: usize, prospects: &Prospects) -> bool {
        self.nodes[node].outlet.part.is_none() || prospects.leaves[node]
    }

    /// Whether a station may begin to work on a part some day.
    fn may_work(&self, node: usize, prospects: &Prospects) -> bool {
        let Place::Station(station) = &self.nodes[node].place else {
            return false;
        };
        match station.phase {
            Phase::Done => self.gets_free(node, prospects),
            _ => !self.shifts.is_off_for_ever(node) || station.is_in_overtime(),
        }
    }

    /// Whether a node may take a part of this type some day.
    fn may_admit(&self, node: usize, kind: usize, prospects: &Prospects) -> bool {
        match &self.nodes[node].place {
            Place::Source(_) => false,
            Place::Sink | Place::Store(_) => true,
            Place::Conveyor(conveyor) => !conveyor.is_full() || self.gets_free(node, prospects),
            Place::Belt(belt) => {
                belt.is_awake() || !belt.is_full() || self.gets_free(node, prospects)
            }
            Place::Buffer(buffer) => {
                buffer.has_room() || buffer.ranks_resting() || self.gets_free(node, prospects)
            }
            Place::Station(station) => {
                let comes = |missing: usize| prospects.arrives(node, missing);
                station.lacks(kind)
                    || self.may_work(node, prospects)
                        && (station.works_alone_on(kind) || station.may_use(kind, comes))
            }
        }
    }

    /// Whether a part of this type may leave a node some day.
    fn may_depart(&self, node: usize, kind: usize, prospects: &Prospects) -> bool {
        let waiting = self.nodes[node].outlet.part;
        match &self.nodes[node].place {
            Place::Source(source) => {
                let makes = matches!(self.line.nodes[node].kind, NodeKind::Source { part, .. } if part == kind);
                makes
                    && match waiting {
                        Some(_) => prospects.leaves[node],
                        None if source.exhausted() => self.may_be_reordered(node, prospects),
                        None => self.limit_reached(node).is_none() || self.may_end(kind, prospects),
                    }
            }
            Place::Sink => false,
            Place::Store(_) => {
                let mut outlets = self.outlets_of(node);
                let of =
                    |outlet: &usize| self.setup.store_outlets[*outlet - self.nodes.len()].1 == kind;
                let outlet = outlets.find(of);
                outlet.is_some_and(|outlet| match self.outlet(outlet).part {
                    Some(_) => prospects.leaves[outlet],
                    None => prospects.arrives(node, kind),
                })
            }
            Place::Station(station) => {
                let is = |part: PartIndex| self.parts[part].kind == kind;
                let comes = station.works_alone_on(kind) && prospects.arrives(node, kind);
                let is_joined = station.may_make(kind, |part| prospects.arrives(node, part));
                self.may_work(node, prospects)
                    && (station.part.is_some_and(is) || comes || is_joined)
            }
            Place::Buffer(buffer) => {
                let overtakes = buffer.ranks_newcomers() || buffer.ranks_resting();
                (overtakes || self.gets_free(node, prospects)) && prospects.has_some(node, kind)
            }
            Place::Conveyor(_) | Place::Belt(_) => {
                self.gets_free(node, prospects) && prospects.has_some(node, kind)
            }
        }
    }

    /// Whether a part that is of this type, or contains one, may leave the line some day.
    pub(super) fn may_end(&self, kind: usize, prospects: &Prospects) -> bool {
        let containing = |whole: &usize| self.setup.contains(*whole, kind);
        let mut wholes = (0..prospects.types).filter(containing);
        wholes.any(|whole| {
            let mut nodes = 0..self.nodes.len();
            nodes.any(|node| match self.nodes[node].place {
                Place::Sink => prospects.arrives(node, whole),
                Place::Store(_) => {
                    self.setup.ways.from(node, whole).is_empty() && prospects.arrives(node, whole)
                }
                _ => self.may_discard(node, whole, prospects),
            })
        })
    }

    /// Whether more parts may be ordered from a source some day, to replace others.
    fn may_be_reordered(&self, source: usize, prospects: &Prospects) -> bool {
        self.line.is_reordered_from(source)
            && (0..self.nodes.len()).any(|node| {
                let mut kinds = 0..prospects.types;
                match self.line.nodes[node].kind {
                    NodeKind::Sink { reorder, .. } => {
                        reorder == Some(source) && kinds.any(|kind| prospects.arrives(node, kind))
                    }
                    _ => kinds.any(|kind| self.may_discard(node, kind, prospects)),
                }
            })
    }

    /// Whether a node that is no sink may remove a part of this type from the line some day: a
    /// station that works on it, or a buffer in which it expires.
    fn may_discard(&self, node: usize, kind: usize, prospects: &Prospects) -> bool {
        match &self.nodes[node].place {
            Place::Station(_) => self.may_depart(node, kind, prospects),
            Place::Buffer(buffer) => buffer.has_shelf_life() && prospects.has_some(node, kind),
            _ => false,
        }
    }

    /// Whether some part waits that can never leave its place.
    pub(super) fn is_stuck(&self, node: usize, prospects: Option<&Prospects>) -> bool {
        self.outlets_of(node)
            .any(|outlet| self.is_stuck_at(outlet, prospects))
    }

    /// Whether a part waits at an outlet and, given the `prospects`, can never leave it.
    pub(super) fn is_stuck_at(&self, outlet: usize, prospects: Option<&Prospects>) -> bool {
        let waits = self.outlet(outlet).part.is_some();
        waits && prospects.is_none_or(|prospects| !prospects.leaves[outlet])
    }

    /// Whether an end product may still come to its end.
    fn may_finish_some(&self, prospects: &Prospects) -> bool {
        let nodes = self.line.nodes.iter().enumerate();
        let mut ends = nodes.filter(|(_, node)| {
            matches!(
                node.kind,
                NodeKind::Sink { reject: false, .. } | NodeKind::Store { .. }
            )
        });
        ends.any(|(node, _)| {
            let mut products = self.line.products.iter();
            products.any(|product| prospects.arrives(node, *product))
        })
    }

    /// Reports a deadlock in a part of the line, of which the rest has gone on to the end of the
    /// run. Parts that wait for what never comes, without a cycle, are a note.
    pub(super) fn report_deadlock(&mut self, end: End) {
        let may_be_there = match end {
            End::Time | End::Products => !self.rests,
            End::NoProgress => !self.progress.is_stuck_at_instant(),
            End::Blocked | End::PartLost | End::GaveUp => false,
        };
        let waits = |node| self.is_stuck(node, None) || self.has_components(node);
        if !may_be_there || !(0..self.nodes.len()).any(waits) {
            return;
        }
        let prospects = self.prospects();
        let is_deadlock = self.report_cycle(&prospects, |since| {
            format!(
                "parts of the line can never move again (deadlock since {since}), although the rest goes on"
            )
        });
        // A run that has made what was wanted may leave parts behind.
        let has_all = end == End::Products;
        if !is_deadlock
            && !has_all
            && let Some(chain) = self.chain(Some(&prospects))
        {
            let message = format!(
                "parts of the line can never move again, although the rest goes on: {}",
                chain.texts.join(", ")
            );
            self.journal.findings.push(
                Diagnostic::note(codes::LINE_BLOCKED, self.line.span, message)
                    .with_help(self.advice(&chain)),
            );
        }
    }

    /// Reports the parts that wait for one another in a cycle, if there are any. `says` is given
    /// since when. Returns whether there are.
    fn report_cycle(&mut self, prospects: &Prospects, says: impl Fn(String) -> String) -> bool {
        let Some(chain) = self.chain(Some(prospects)).filter(|chain| chain.cycle) else {
            return false;
        };
        let deadlock = self.deadlock_of(&chain.nodes, Some(prospects));
        let says = says(crate::trace::clock(deadlock.since));
        let message = format!("{says}: {}", chain.texts.join(", "));
        let finding = Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message);
        let finding = finding.with_help(self.advice(&chain));
        let finding = self.with_places(finding, &chain.nodes);
        self.journal.findings.push(finding);
        self.deadlock = Some(deadlock);
        true
    }

    /// Ends a run that waits for products of which none can be finished any more, because of a
    /// deadlock or for lack of parts.
    #[cold]
    pub(super) fn end_if_deadlocked(&mut self) {
        let prospects = self.prospects();
        if self.may_finish_some(&prospects) {
            return;
        }
        let progress = self.products_made();
        let is_deadlock = self.report_cycle(&prospects, |since| {
            format!(
                "no product can be finished any more{progress}: parts can never move again (deadlock since {since})"
            )
        });
        if is_deadlock {
            self.end = Some(End::Blocked);
        } else if let Some(chain) = self.chain(Some(&prospects)) {
            let message = format!(
                "no product can be finished any more{progress}: {}",
                chain.texts.join(", ")
            );
            let finding = Diagnostic::error(codes::LINE_BLOCKED, self.line.span, message);
            let finding = finding.with_help(self.advice(&chain));
            let finding = self.with_places(finding, &chain.nodes);
            self.journal.findings.push(finding);
            self.end = Some(End::Blocked);
        }
    }

    /// The deadlock in which these places wait for one another. It began when the last of their
    /// parts began to wait.
    pub(super) fn deadlock_of(&self, places: &[usize], prospects: Option<&Prospects>) -> Deadlock {
        let outlets = places.iter().flat_map(|node| self.outlets_of(*node));
        let stuck = outlets.filter(|outlet| self.is_stuck_at(*outlet, prospects));
        let parts = stuck.filter_map(|outlet| self.outlet(outlet).part);
        let components = places
            .iter()
            .flat_map(|node| match &self.nodes[*node].place {
                Place::Station(station) => station.components().collect(),
                _ => Vec::new(),
            });
        Deadlock {
            places: places
                .iter()
                .map(|node| self.name(*node).to_owned())
                .collect(),
            since: parts
                .chain(components)
                .map(|part| self.parts[part].waits_since)
                .fold(0.0, f64::max),
        }
    }
}
