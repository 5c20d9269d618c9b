//! Ways: the routes of which a part takes one, and the choice between them.

use super::part::PartIndex;
use super::{Place, Run};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Choice, Line};
use linewright_language::contract::machine::RealExpr;
use std::ops::Range;

/// The routes of which a part takes one: indices into [`Ways::to`], and the choice to which they
/// belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Way {
    first: u32,
    end: u32,
    pub choice: Option<u32>,
    /// The place to which the part goes; `None` if it is open to which of several.
    pub only: Option<u32>,
}

/// Routes by node and part type.
pub(super) struct Ways {
    types: usize,
    /// By node and part type: the way, if all parts take the same one.
    same: Vec<Option<Way>>,
    /// By node and part type: range of `all`.
    index: Vec<Range<u32>>,
    all: Vec<(Way, Option<RealExpr>)>,
    to: Vec<usize>,
}

impl Ways {
    pub(super) fn new(line: &Line) -> Self {
        let types = line.parts.len();
        let mut by_start: Vec<Vec<(Way, Option<RealExpr>)>> =
            vec![Vec::new(); line.nodes.len() * types];
        let mut at = 0;
        while at < line.routes.len() {
            let route = &line.routes[at];
            let end = line.end_of_way(at);
            let way = Way {
                first: at as u32,
                end: end as u32,
                choice: route.choice.map(|choice| choice as u32),
                only: (end == at + 1).then_some(route.to as u32),
            };
            by_start[route.from * types + route.part].push((way, route.condition.clone()));
            at = end;
        }
        let mut all = Vec::new();
        let mut index = Vec::new();
        let mut same = Vec::new();
        for ways in by_start {
            same.push(match ways[..] {
                [(way, None), ..] if way.choice.is_none() => Some(way),
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
            to: line.routes.iter().map(|route| route.to).collect(),
        }
    }

    /// The places at the ends of a way.
    pub(super) fn to(&self, way: Way) -> &[usize] {
        &self.to[way.first as usize..way.end as usize]
    }

    /// The way of a part type from a node, if all parts take the same one.
    #[inline]
    fn same(&self, node: usize, part: usize) -> Option<Way> {
        self.same[node * self.types + part]
    }

    /// Ways of a part type from a node, in order.
    pub(super) fn from(&self, node: usize, part: usize) -> &[(Way, Option<RealExpr>)] {
        let range = &self.index[node * self.types + part];
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
            let chosen = way
                .choice
                .and_then(|choice| choosers[choice as usize].choose());
            return Some(match chosen {
                None => way,
                Some(member) => Way {
                    first: way.first + member,
                    end: way.first + member + 1,
                    only: Some(setup.ways.to[(way.first + member) as usize] as u32),
                    ..way
                },
            });
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
        let mut places = self.setup.ways.to(way).iter().copied().filter(takes);
        match way.choice.map(|choice| &self.line.choices[choice as usize]) {
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
