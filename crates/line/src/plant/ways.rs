//! Ways: the routes of which a part takes one, and the choice between them.

use super::part::PartIndex;
use super::{Place, Run};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Choice, Line};
use linewright_language::contract::machine::RealExpr;
use std::num::NonZeroU32;
use std::ops::Range;

/// The routes of which a part takes one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Way(NonZeroU32);

/// What a way consists of.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Routes {
    /// The routes, as a range of [`Ways::to`].
    first: u32,
    end: u32,
    /// The choice to which they belong.
    pub choice: Option<u32>,
    /// The place to which the part goes; `None` if it is open to which of several.
    pub only: Option<u32>,
}

/// Ways by node and part type.
pub(super) struct Ways {
    types: usize,
    /// By node and part type: the way, if all parts take the same one.
    same: Vec<Option<Way>>,
    /// By node and part type: range of `all`.
    index: Vec<Range<u32>>,
    all: Vec<(Way, Option<RealExpr>)>,
    /// By way. That of a choice is followed by one way for each of its routes alone. The first
    /// entry is not used.
    routes: Vec<Routes>,
    /// By route: the place at its end.
    to: Vec<usize>,
}

impl Way {
    /// The way that consists only of one route of this way, which belongs to a choice.
    fn member(self, number: u32) -> Self {
        Self(self.0.saturating_add(1 + number))
    }
}

impl Ways {
    pub(super) fn new(line: &Line) -> Self {
        let types = line.parts.len();
        let mut by_start: Vec<Vec<(Way, Option<RealExpr>)>> =
            vec![Vec::new(); line.nodes.len() * types];
        let mut routes = vec![Routes::default()];
        let mut at = 0;
        while at < line.routes.len() {
            let route = &line.routes[at];
            let end = line.end_of_way(at);
            let way = Way(NonZeroU32::MIN.saturating_add(routes.len() as u32 - 1));
            let choice = route.choice.map(|choice| choice as u32);
            let those = |first: usize, end: usize| Routes {
                first: first as u32,
                end: end as u32,
                choice,
                only: (end == first + 1).then_some(line.routes[first].to as u32),
            };
            routes.push(those(at, end));
            if choice.is_some() {
                routes.extend((at..end).map(|member| those(member, member + 1)));
            }
            by_start[route.from * types + route.part].push((way, route.condition.clone()));
            at = end;
        }
        let mut all = Vec::new();
        let mut index = Vec::new();
        let mut same = Vec::new();
        for ways in by_start {
            same.push(match ways[..] {
                [(way, None), ..] if routes[way.0.get() as usize].choice.is_none() => Some(way),
                _ => None,
            });
            let first = all.len() as u32;
            all.extend(ways);
            index.push(first..all.len() as u32);
        }
        Self {
            types,
            same,
            index,
            all,
            routes,
            to: line.routes.iter().map(|route| route.to).collect(),
        }
    }

    /// What a way consists of.
    #[inline]
    pub(super) fn routes(&self, way: Way) -> &Routes {
        &self.routes[way.0.get() as usize]
    }

    /// The places at the ends of a way.
    pub(super) fn to(&self, way: Way) -> &[usize] {
        let routes = self.routes(way);
        &self.to[routes.first as usize..routes.end as usize]
    }

    /// The way of a part type from a node, if all parts take the same one.
    #[inline]
    pub(super) fn same(&self, node: usize, kind: usize) -> Option<Way> {
        self.same[node * self.types + kind]
    }

    /// Ways of a part type from a node, in order.
    pub(super) fn from(&self, node: usize, kind: usize) -> &[(Way, Option<RealExpr>)] {
        let range = &self.index[node * self.types + kind];
        &self.all[range.start as usize..range.end as usize]
    }
}

impl Run<'_> {
    /// The way of a part, by the first route whose condition holds, to the place that the choice
    /// determines. If there is none, adds a finding.
    #[inline]
    pub(super) fn way(&mut self, node: usize, part: PartIndex) -> Option<Way> {
        let same = self.setup.ways.same(node, self.parts[part].kind);
        same.or_else(|| self.chosen_way(node, part))
    }

    #[inline(never)]
    fn chosen_way(&mut self, node: usize, part: PartIndex) -> Option<Way> {
        let Self {
            setup,
            parts,
            choosers,
            ..
        } = self;
        let part = &parts[part];
        let way = setup
            .ways
            .from(node, part.kind)
            .iter()
            .find(|(_, condition)| {
                condition
                    .as_ref()
                    .is_none_or(|condition| condition.eval(&part.properties, &[]) != 0.0)
            });
        if let Some(&(way, _)) = way {
            let choice = setup.ways.routes(way).choice;
            let chosen = choice.and_then(|choice| choosers[choice as usize].choose());
            return Some(chosen.map_or(way, |number| way.member(number)));
        }
        let (kind, number) = (part.kind, part.number);
        if !self.journal.unroutable.contains(&(node, kind)) {
            self.journal.unroutable.push((node, kind));
            let name = self.type_name(kind);
            let message = format!(
                "{name} {number} has no way onward from {} at {}",
                self.name(node),
                self.moment()
            );
            self.journal.findings.push(
                Diagnostic::error(codes::LINE_ROUTE, self.line.nodes[node].span, message)
                    .with_help(format!(
                        "After the other routes for {name}, add one without a condition."
                    )),
            );
        }
        None
    }

    /// Of the places at the ends of a way that take a part, the first one or, for the shortest
    /// queue, the first with the fewest parts.
    pub(super) fn choose(&self, way: Way, takes: impl Fn(&usize) -> bool) -> Option<usize> {
        let ways = &self.setup.ways;
        let mut places = ways.to(way).iter().copied().filter(takes);
        match ways
            .routes(way)
            .choice
            .map(|choice| &self.line.choices[choice as usize])
        {
            Some(Choice::ShortestQueue) => places.min_by_key(|to| self.load(*to)),
            _ => places.next(),
        }
    }

    /// Number of parts in a place.
    fn load(&self, node: usize) -> usize {
        match &self.nodes[node].place {
            Place::Source(_) | Place::Sink => 0,
            Place::Store(store) => store.parts().count(),
            Place::Station(station) => station.parts().count(),
            Place::Conveyor(conveyor) => conveyor.parts.len(),
            Place::Belt(belt) => belt.held.len() + usize::from(belt.inlet.is_some()),
            Place::Buffer(buffer) => buffer.len(),
        }
    }
}
