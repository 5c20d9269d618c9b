//! Explains why a line stands still: follows from node to node who waits for whom, until a cycle
//! closes or the chain ends at something that will never come.
//!
//! A part at an outlet waits for one node, so each waiting node has one successor: the node that it
//! waits for. The successor of a station that lacks a component is the node that holds or makes
//! such a component. If there is a cycle, following the successors from every outlet in order finds
//! one.

use super::deadlock::Prospects;
use super::{Place, Run};
use crate::plant::part::PartIndex;
use crate::statistics::Activity;
use crate::trace::End;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{NodeKind, Supply};

/// Why a node does not proceed, and the node that it waits for, if any.
struct Reason {
    text: String,
    next: Option<usize>,
}

/// A chain of reasons starting at some node.
pub(super) struct Chain {
    pub nodes: Vec<usize>,
    pub texts: Vec<String>,
    /// Whether the last node waits for the first.
    pub cycle: bool,
}

impl Run<'_> {
    /// Ends a run in which nothing will happen any more. Adds a finding, unless the run was limited
    /// only by time and all work is done.
    pub(super) fn end_blocked(&mut self) -> End {
        self.rests = true;
        let chain = self.chain(None);
        if let (Some(horizon), None) = (self.setup.horizon, self.setup.target)
            && !chain.as_ref().is_some_and(|chain| chain.cycle)
            && self.journal.unroutable.is_empty()
        {
            if let Some(chain) = chain {
                let message = format!(
                    "nothing moves any more from {} on: {}",
                    self.moment(),
                    chain.texts.join(", ")
                );
                self.journal.findings.push(
                    Diagnostic::note(codes::LINE_BLOCKED, self.line.span, message)
                        .with_help(self.advice(&chain)),
                );
            }
            self.wait_until(horizon);
            return End::Time;
        }
        let progress = self.products_made();
        let (why, help) = match &chain {
            Some(chain) => (chain.texts.join(", "), self.advice(chain)),
            None => (
                format!(
                    "nothing is left to do: {}{}",
                    self.supplies(None),
                    self.not_replaced()
                ),
                "Let a source make more parts (a sink that rejects parts can order replacements), or require fewer products."
                    .to_owned(),
            ),
        };
        let mut finding = Diagnostic::error(
            codes::LINE_BLOCKED,
            self.line.span,
            format!(
                "the line can no longer advance at {}{progress}: {why}",
                self.moment()
            ),
        )
        .with_help(help);
        for text in self.paused_sources() {
            finding = finding.with_note(text);
        }
        if let Some(chain) = chain {
            finding = self.with_places(finding, &chain.nodes);
            self.deadlock = chain.cycle.then(|| self.deadlock_of(&chain.nodes, None));
        }
        self.journal.findings.push(finding);
        End::Blocked
    }

    /// The number of products that were made, for a message, if a number of them is wanted.
    pub(super) fn products_made(&self) -> String {
        let made = self.counters.products;
        self.setup.target.map_or(String::new(), |target| {
            format!(", with {made} of {target} products made")
        })
    }

    /// Adds the places of nodes to a finding.
    pub(super) fn with_places(&self, mut finding: Diagnostic, nodes: &[usize]) -> Diagnostic {
        for &node in nodes {
            let declared = &self.line.nodes[node];
            finding = finding.with_label(declared.span, format!("{} is here", declared.name));
        }
        finding
    }

    /// Advances the run to its end, because from now on only shifts begin and end.
    fn wait_until(&mut self, horizon: f64) {
        let warm_up = self.setup.options.warm_up;
        if !self.is_counting() && warm_up > 0.0 && warm_up < horizon {
            self.wait_until(warm_up);
            self.end_warm_up();
        }
        while let Some(time) = self.next_cut().filter(|time| *time < horizon) {
            self.rest_until(time);
            self.end_batch();
        }
        self.rest_until(horizon);
    }

    /// Advances the run to `horizon` without anything that ends before.
    fn rest_until(&mut self, horizon: f64) {
        self.record_rest(horizon);
        let rest = horizon - self.now;
        for node in 0..self.nodes.len() {
            self.end_wait(node);
            let worked = self.working_seconds(node, horizon);
            if let Place::Station(station) = &mut self.nodes[node].place {
                let kinds = [Activity::Blocked, Activity::Starved];
                let before = kinds.map(|kind| station.clock.seconds_at(self.now, kind));
                station.wait(self.now, worked.clamp(0.0, rest), horizon);
                let after = kinds.map(|kind| station.clock.seconds_at(horizon, kind));
                self.wait_on(node, after[0] - before[0], after[1] - before[1]);
            }
        }
        self.now = horizon;
    }

    /// Text about the number of rejected parts that were not ordered again; empty if there are
    /// none.
    fn not_replaced(&self) -> String {
        match self
            .counters
            .rejects
            .iter()
            .filter(|(_, ordered)| *ordered == 0)
            .map(|(count, _)| count)
            .sum()
        {
            0_u64 => String::new(),
            1 => ", and 1 part was rejected and not ordered again".to_owned(),
            count => format!(", and {count} parts were rejected and not ordered again"),
        }
    }

    pub(super) fn advice(&self, chain: &Chain) -> String {
        let roomy = chain.nodes.iter().copied().find(|&node| {
            matches!(
                self.line.nodes[node].kind,
                NodeKind::Conveyor { .. } | NodeKind::Buffer { .. }
            )
        });
        if !chain.cycle && !self.journal.unroutable.is_empty() {
            return "Give every part a route onward from every place that it can reach.".to_owned();
        }
        match (chain.cycle, roomy) {
            (true, Some(node)) => format!(
                "Keep the cycle from filling up: add room in {}, admit fewer parts at a time, or add another route \
                 out of it.",
                self.name(node)
            ),
            (true, None) if chain.nodes.iter().any(|&node| self.limit_reached(node).is_some()) => {
                "Allow more parts in the line, or let those in it go on without further ones.".to_owned()
            }
            (true, None) => {
                "Let fewer parts into the line than fill the cycle, or add another route out of it.".to_owned()
            }
            (false, _) => {
                "Make sure that enough of the missing parts are made or stocked and that rejected parts are \
                 reordered, or require fewer products."
                    .to_owned()
            }
        }
    }

    /// Returns the first cycle; if there is none, the first chain that ends somewhere; `None` if
    /// nothing waits. Nothing moves in the line, or what may still move follows from the
    /// `prospects`; then only what can never go on counts.
    pub(super) fn chain(&self, prospects: Option<&Prospects>) -> Option<Chain> {
        let waiting = (0..self.nodes.len()).filter(|&node| self.is_stuck(node, prospects));
        let begun = (0..self.nodes.len()).filter(|&node| match &self.nodes[node].place {
            Place::Station(_) => self.has_components(node),
            Place::Belt(belt) => prospects.is_none() && !belt.held.is_empty(),
            _ => false,
        });
        let mut open = None;
        for start in waiting.chain(begun) {
            let chain = self.follow(start, prospects);
            if chain.cycle {
                return Some(chain);
            }
            open = open.or((!chain.texts.is_empty()).then_some(chain));
        }
        open
    }

    /// Whether components wait in a node to be joined.
    pub(super) fn has_components(&self, node: usize) -> bool {
        match &self.nodes[node].place {
            Place::Station(station) => station.components().next().is_some(),
            _ => false,
        }
    }

    fn follow(&self, start: usize, prospects: Option<&Prospects>) -> Chain {
        let mut nodes = vec![start];
        let mut texts = Vec::new();
        let mut node = start;
        loop {
            let Some(reason) = self.reason(node, prospects) else {
                return Chain {
                    nodes,
                    texts,
                    cycle: false,
                };
            };
            texts.push(reason.text);
            let Some(next) = reason.next else {
                return Chain {
                    nodes,
                    texts,
                    cycle: false,
                };
            };
            if let Some(first) = nodes.iter().position(|&seen| seen == next) {
                return Chain {
                    nodes: nodes.split_off(first),
                    texts: texts.split_off(first),
                    cycle: true,
                };
            }
            nodes.push(next);
            node = next;
        }
    }

    fn reason(&self, node: usize, prospects: Option<&Prospects>) -> Option<Reason> {
        let name = self.name(node);
        let waiting = self
            .outlets_of(node)
            .filter(|outlet| self.is_stuck_at(*outlet, prospects))
            .map(|outlet| self.outlet(outlet))
            .find_map(|outlet| outlet.part.map(|part| (part, outlet.to)));
        match (waiting, &self.nodes[node].place) {
            (Some((_, Some(way))), _) => {
                let places = self.setup.ways.to(&way).iter().map(|to| *to as usize);
                let rooms = places.clone().map(|to| {
                    let room = match self.nodes[to].place {
                        Place::Conveyor(_) | Place::Belt(_) => "room on ",
                        Place::Buffer(_) => "room in ",
                        _ => "",
                    };
                    format!("{room}{}", self.name(to))
                });
                let rooms: Vec<String> = rooms.collect();
                Some(Reason {
                    text: format!("{name} waits for {}", rooms.join(" or ")),
                    next: places.clone().next(),
                })
            }
            (Some((part, None)), _) => Some(Reason {
                text: format!(
                    "{name} holds {} {}, which has no way onward",
                    self.type_name(self.parts[part].kind),
                    self.parts[part].number
                ),
                next: None,
            }),
            (None, Place::Belt(belt)) if !belt.held.is_empty() => Some(Reason {
                text: format!("{name} does not move its parts"),
                next: None,
            }),
            (None, Place::Station(_)) if self.shifts.is_off_for_ever(node) => Some(Reason {
                text: format!("{name} has no further shift"),
                next: None,
            }),
            (None, Place::Station(station)) => {
                let never_comes = |kind: &usize| {
                    prospects.is_none_or(|prospects| !prospects.arrives(node, *kind))
                };
                let missing = station.missing().into_iter().find(never_comes);
                missing.map(|kind| self.lack(node, kind, prospects))
            }
            (None, Place::Source(_)) => {
                let (kind, most) = self.stopped_by_limit(node, prospects)?;
                let keeps = |node: &usize| self.has(*node, |part| self.setup.contains(part, kind));
                let keepers = || (0..self.nodes.len()).filter(keeps);
                let stuck = keepers().find(|keeper| self.is_stuck(*keeper, prospects));
                Some(Reason {
                    text: format!(
                        "{name} makes no part while {} in the line",
                        self.there_are(most, kind)
                    ),
                    next: stuck.or_else(|| keepers().next()),
                })
            }
            _ => None,
        }
    }

    /// Why a component does not reach a station.
    fn lack(&self, node: usize, kind: usize, prospects: Option<&Prospects>) -> Reason {
        let start = format!(
            "{} waits for a part of type {}",
            self.name(node),
            self.type_name(kind)
        );
        let others = || (0..self.nodes.len()).filter(|&other| other != node);
        if let Some(holder) = others().find(|&other| {
            let stays = prospects.is_none() || self.is_stuck(other, prospects);
            stays && self.holds(other, kind)
        }) {
            let place = match self.nodes[holder].place {
                Place::Conveyor(_) | Place::Belt(_) => "on",
                Place::Source(_) | Place::Station(_) => "at",
                _ => "in",
            };
            return Reason {
                text: format!("{start}, which is {place} {}", self.name(holder)),
                next: Some(holder),
            };
        }
        let maker = others().find(|&other| match &self.nodes[other].place {
            Place::Station(station) => station.joins(kind),
            _ => false,
        });
        if let Some(maker) = maker {
            return Reason {
                text: format!("{start}, which {} makes", self.name(maker)),
                next: Some(maker),
            };
        }
        let mut routes = self.line.routes.iter();
        let way = routes.find(|route| {
            let leads_here = route.to == node && route.part == kind;
            leads_here && prospects.is_some() && self.is_stuck(route.from, prospects)
        });
        if let Some(way) = way {
            return Reason {
                text: format!("{start}, which would come from {}", self.name(way.from)),
                next: Some(way.from),
            };
        }
        let mut routes = self.line.routes.iter();
        let is_served = routes.any(|route| (route.to, route.part) == (node, kind));
        let limited = others().find(|&other| {
            let limit = self.stopped_by_limit(other, prospects);
            is_served && limit.is_some_and(|(part, _)| part == kind)
        });
        if let Some(source) = limited {
            return Reason {
                text: format!("{start}, which {} makes", self.name(source)),
                next: Some(source),
            };
        }
        Reason {
            text: format!("{start}, but {}", self.supplies(Some(kind))),
            next: None,
        }
    }

    /// Whether a part of this type is at a node.
    fn holds(&self, node: usize, kind: usize) -> bool {
        self.has(node, |other| other == kind)
    }

    /// Whether a part of such a type is at a node.
    fn has(&self, node: usize, is: impl Fn(usize) -> bool) -> bool {
        let is = |part: PartIndex| is(self.parts[part].kind);
        self.outlets_of(node)
            .filter_map(|outlet| self.outlet(outlet).part)
            .any(is)
            || self.held(node).into_iter().any(is)
    }

    /// All parts at a node that have entered the line.
    pub(super) fn held(&self, node: usize) -> Vec<PartIndex> {
        match &self.nodes[node].place {
            // A part at the outlet of a source has not entered the line, and a sink holds no parts.
            Place::Source(_) | Place::Sink => Vec::new(),
            Place::Store(store) => store.parts().collect(),
            Place::Station(station) => station.parts().collect(),
            Place::Conveyor(conveyor) => conveyor.parts.iter().map(|(part, _)| *part).collect(),
            Place::Belt(belt) => belt
                .held
                .iter()
                .map(|(part, _)| *part)
                .chain(belt.inlet.map(|(part, _)| part))
                .collect(),
            Place::Buffer(buffer) => buffer.parts().collect(),
        }
    }

    /// The part type of a source and its `at most N in the line`, if this limit prevents the source
    /// from making a part.
    pub(super) fn limit_reached(&self, node: usize) -> Option<(usize, u32)> {
        match (&self.line.nodes[node].kind, &self.nodes[node].place) {
            (
                NodeKind::Source {
                    part,
                    most: Some(most),
                    ..
                },
                Place::Source(source),
            ) if !source.exhausted() && self.counters.in_line[*part] >= u64::from(*most) => {
                Some((*part, *most))
            }
            _ => None,
        }
    }

    /// The same if the limit prevents this for ever.
    fn stopped_by_limit(&self, node: usize, prospects: Option<&Prospects>) -> Option<(usize, u32)> {
        let limit = self.limit_reached(node);
        limit.filter(|(part, _)| prospects.is_none_or(|prospects| !self.may_end(*part, prospects)))
    }

    /// `3 Raw are`, or `1 Raw is`.
    fn there_are(&self, count: u32, kind: usize) -> String {
        let are = if count == 1 { "is" } else { "are" };
        format!("{count} {} {are}", self.type_name(kind))
    }

    /// Describes the sources that make no part because of their `at most N in the line`.
    fn paused_sources(&self) -> Vec<String> {
        let paused = (0..self.nodes.len()).filter_map(|node| {
            let (part, most) = self.limit_reached(node)?;
            Some(format!(
                "{} makes no part while {} in the line or held by a source",
                self.name(node),
                self.there_are(most, part)
            ))
        });
        paused.collect()
    }

    /// Describes the state of the sources and stocks of a part type or, with `None`, of all.
    fn supplies(&self, wanted: Option<usize>) -> String {
        let is = |kind: usize| wanted.is_none_or(|wanted| wanted == kind);
        let mut texts = Vec::new();
        for (node, declared) in self.line.nodes.iter().enumerate() {
            let name = &declared.name;
            match (&declared.kind, &self.nodes[node].place) {
                (NodeKind::Source { part, supply, .. }, Place::Source(source)) if is(*part) => {
                    texts.push(match supply {
                        Supply::OnOrder if source.exhausted() => {
                            format!("{name} has made all {} that were ordered", source.made())
                        }
                        Supply::At { .. } if source.exhausted() => {
                            format!("{name} has made all {} of its table", source.made())
                        }
                        Supply::Every {
                            limit: Some(limit), ..
                        } if source.exhausted() => {
                            let replaced = match source.made().saturating_sub(*limit) {
                                0 => String::new(),
                                1 => " and 1 replacement".to_owned(),
                                more => format!(" and {more} replacements"),
                            };
                            format!("{name} has made all {limit} of its limit{replaced}")
                        }
                        _ => match self.limit_reached(node) {
                            Some((_, most)) => format!(
                                "{name} makes no part while {} in the line",
                                self.there_are(most, *part)
                            ),
                            None => format!("{name} makes more, but no route brings them here"),
                        },
                    });
                }
                (NodeKind::Store { stock }, Place::Store(store)) => {
                    let empty = stock
                        .iter()
                        .any(|&(kind, _)| is(kind) && store.stock(kind) == 0);
                    let full = stock
                        .iter()
                        .any(|&(kind, _)| is(kind) && store.stock(kind) > 0);
                    if full && wanted.is_some() {
                        texts.push(format!("no route brings the stock of {name} here"));
                    } else if empty {
                        texts.push(format!("the stock of {name} is used up"));
                    }
                }
                _ => {}
            }
        }
        if texts.is_empty() {
            return match wanted {
                Some(kind) => format!(
                    "no source makes {} and no store has it",
                    self.type_name(kind)
                ),
                None => "there is neither a source nor a stock".to_owned(),
            };
        }
        texts.join(" and ")
    }
}
