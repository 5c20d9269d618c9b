//! Whether the parts of the last orders can be kept from leaving.
//!
//! In the abstraction of a line, a source on order makes parts without end. A run for a number of
//! products orders only what these products need. The difference matters where parts are joined:
//! after the last ordered part, the other components wait for ever. That is harmless if nothing
//! that is still needed has to pass the places where they wait, and if they could not be of use
//! elsewhere. Where this is not certain, a proof has the premise that orders continue.
//!
//! # Why the conditions suffice
//!
//! Suppose that parts of the last orders are stuck, and that further orders would free them. Then a
//! further part completes a joined part for which components wait, before one that is already in
//! the line can. Call those components the waiting ones.
//!
//! - If they contain nothing on order, they can be in any number. So they must not share a place
//!   with parts that are still needed ([`LastOrders::obstacle`]).
//! - If they do, then as many of what they wait for are ordered as of them, and some of these are
//!   in the line, stuck elsewhere. A further part can only overtake them if its way branches. If no
//!   way branches, nothing changes; otherwise, the waiting ones must not share a place either.
//! - With several stations or types that take the waiting ones, they could have gone to the wrong
//!   one ([`LastOrders::elsewhere`]).

use crate::abstraction::Shape;
use crate::abstraction::words::an;
use linewright_language::contract::line::{Line, NodeKind, Supply};
use std::collections::{BTreeMap, BTreeSet};

/// The sources whose orders have to continue, each with the reason. `line` is without routes that
/// no part takes.
pub(super) fn needed(line: &Line) -> BTreeMap<usize, String> {
    let mut found = BTreeMap::new();
    let Some(orders) = LastOrders::of(line) else {
        return found;
    };
    for join in &orders.joins {
        let bill = &line.parts[join.whole].bill;
        for &(waiting, _) in bill {
            // Components for which it can wait. It can wait for another one of its own type.
            let awaited = bill.iter().filter(|(component, count)| {
                orders.has_orders(*component) && (*component != waiting || *count > 1)
            });
            let awaited: Vec<usize> = awaited.map(|(component, _)| *component).collect();
            if awaited.is_empty() {
                continue;
            }
            let Some(reason) = orders
                .elsewhere(waiting)
                .or_else(|| orders.obstacle(join, waiting))
            else {
                continue;
            };
            for (source, part) in orders.sources() {
                if awaited.iter().any(|a| orders.contains(*a, part)) {
                    let part = &line.parts[part].name;
                    let reason = || format!("after the last {part}, {reason}");
                    found.entry(source).or_insert_with(reason);
                }
            }
        }
    }
    found
}

/// A station that joins components to a part type.
struct Join {
    station: usize,
    whole: usize,
}

struct LastOrders<'a> {
    line: &'a Line,
    /// The only product.
    product: usize,
    contents: Vec<Vec<u64>>,
    joins: Vec<Join>,
}

impl<'a> LastOrders<'a> {
    /// `None` if there are several types of products: then, orders have no end.
    fn of(line: &'a Line) -> Option<Self> {
        let product = line.only_product()?;
        let mut joins = Vec::new();
        for station in 0..line.nodes.len() {
            let wholes = (0..line.parts.len()).filter(|part| line.is_joined_at(station, *part));
            joins.extend(wholes.map(|whole| Join { station, whole }));
        }
        Some(Self {
            line,
            product,
            contents: Shape::contents(line),
            joins,
        })
    }

    /// The sources on order, each with its part type.
    fn sources(&self) -> impl Iterator<Item = (usize, usize)> {
        let nodes = self.line.nodes.iter().enumerate();
        nodes.filter_map(|(node, declared)| match declared.kind {
            NodeKind::Source {
                part,
                supply: Supply::OnOrder,
                ..
            } => Some((node, part)),
            _ => None,
        })
    }

    fn contains(&self, whole: usize, part: usize) -> bool {
        self.contents[whole][part] > 0
    }

    /// Whether a type is made on order, or contains such a type.
    fn has_orders(&self, part: usize) -> bool {
        self.sources()
            .any(|(_, ordered)| self.contains(part, ordered))
    }

    /// Whether exactly as many parts of a type are ordered as products need, and none come from
    /// elsewhere.
    fn is_counted(&self, part: usize) -> bool {
        let makers = |part: usize| {
            let nodes = self.line.nodes.iter();
            nodes.filter(move |node| match &node.kind {
                NodeKind::Source { part: made, .. } => *made == part,
                NodeKind::Store { stock } => stock.iter().any(|(of, _)| *of == part),
                _ => false,
            })
        };
        let inside = (0..self.line.parts.len()).filter(|p| self.contains(part, *p));
        let mut ordered = inside.filter(|p| self.has_orders(*p));
        self.contains(self.product, part)
            && ordered.all(|p| {
                let is_joined = !self.line.parts[p].bill.is_empty();
                makers(p).count() == usize::from(!is_joined)
            })
    }

    /// Whether a part of what is joined has a choice of where to go.
    fn branches(&self, whole: usize) -> bool {
        let routes = &self.line.routes;
        routes.iter().enumerate().any(|(at, route)| {
            let is_inside = route.part != whole && self.contains(whole, route.part);
            let is_end = |node: usize| matches!(self.line.nodes[node].kind, NodeKind::Sink { .. });
            let mut others = routes[..at].iter();
            is_inside
                && self.has_orders(route.part)
                && !is_end(route.to)
                && others.any(|o| {
                    (o.part, o.from) == (route.part, route.from)
                        && o.to != route.to
                        && !is_end(o.to)
                })
        })
    }

    /// Whether this is a component of what is joined.
    fn takes(&self, join: &Join, part: usize) -> bool {
        let mut bill = self.line.parts[join.whole].bill.iter();
        bill.any(|(component, _)| *component == part) && self.line.is_brought(join.station, part)
    }

    /// Says that a component, or something in it, is joined in several stations or to several
    /// types; `None` if it is not.
    fn elsewhere(&self, waiting: usize) -> Option<String> {
        let inside = (0..self.line.parts.len()).filter(|part| self.contains(waiting, *part));
        for part in inside {
            let mut takers = self.joins.iter().filter(|j| self.takes(j, part));
            let (Some(first), Some(second)) = (takers.next(), takers.next()) else {
                continue;
            };
            let Line { parts, nodes, .. } = self.line;
            return Some(format!(
                "{} can be kept for {} at {} that is needed for {} at {}",
                an(&parts[part].name),
                an(&parts[first.whole].name),
                nodes[first.station].name,
                an(&parts[second.whole].name),
                nodes[second.station].name,
            ));
        }
        None
    }

    /// Says that a component, or something in it, can wait where something else has to pass; `None`
    /// if it cannot.
    fn obstacle(&self, join: &Join, waiting: usize) -> Option<String> {
        if self.has_orders(waiting) && self.is_counted(waiting) && !self.branches(join.whole) {
            return None;
        }
        let inside = (0..self.line.parts.len()).filter(|part| self.contains(waiting, *part));
        for part in inside {
            for place in self.places(part) {
                let others = (0..self.line.parts.len()).filter(|other| {
                    *other != part
                        && self.places(*other).contains(&place)
                        // What is joined with it is of no use either.
                        && !(*other != join.whole
                            && self.contains(join.whole, *other)
                            && !self.has_orders(*other))
                });
                for other in others {
                    if !self.meet_to_be_joined(place, part, other) {
                        return Some(format!(
                            "{} can wait in {place} for ever where {other} has to pass",
                            an(&self.line.parts[part].name),
                            place = self.line.nodes[place].name,
                            other = an(&self.line.parts[other].name),
                        ));
                    }
                }
            }
        }
        None
    }

    /// The stations, conveyors and buffers through which parts of a type go.
    fn places(&self, part: usize) -> BTreeSet<usize> {
        let routes = self.line.routes.iter().filter(|r| r.part == part);
        let nodes = routes.flat_map(|r| [r.from, r.to]);
        let holds = |node: &usize| {
            matches!(
                self.line.nodes[*node].kind,
                NodeKind::Station(_) | NodeKind::Conveyor { .. } | NodeKind::Buffer { .. }
            )
        };
        nodes.filter(holds).collect()
    }

    /// Whether these two types are at a station only because one of them is joined to the other, or
    /// both to the same.
    fn meet_to_be_joined(&self, station: usize, a: usize, b: usize) -> bool {
        let NodeKind::Station(declared) = &self.line.nodes[station].kind else {
            return false;
        };
        let has_task = |part: usize| declared.tasks.iter().any(|task| task.part == part);
        self.joins
            .iter()
            .filter(|j| j.station == station)
            .any(|join| {
                [a, b].into_iter().all(|part| {
                    if part == join.whole {
                        !self.line.is_brought(station, part)
                    } else {
                        self.takes(join, part) && !has_task(part)
                    }
                })
            })
    }
}
