//! Ways: the routes of which a part takes one, and the choice between them.

use super::part::PartIndex;
use super::{Place, Run};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Choice, Line};
use linewright_language::contract::machine::RealExpr;
use std::ops::Range;

/// Where a part goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// To this place.
    To(u32),
    /// To a place at the end of a route that belongs to a choice: an index into [`Ways::choices`].
    Choice(u32),
}

/// Routes that belong to a choice, of which a part takes one.
#[derive(Debug, Clone, Copy)]
struct Routes {
    /// The routes, as a range of [`Ways::to`].
    first: u32,
    end: u32,
    /// The choice to which they belong.
    choice: u32,
}

/// Ways by node and part type.
pub(super) struct Ways {
    types: usize,
    /// By node and part type: the place to which all parts go, if they do not choose.
    always: Vec<Option<u32>>,
    /// By node and part type: range of `all`.
    index: Vec<Range<u32>>,
    all: Vec<(Way, Option<RealExpr>)>,
    /// All routes of each choice, followed by each of these routes alone.
    choices: Vec<Routes>,
    /// By route: the place at its end.
    to: Vec<u32>,
}

impl Ways {
    pub(super) fn new(line: &Line) -> Self {
        let types = line.parts.len();
        let mut by_start: Vec<Vec<(Way, Option<RealExpr>)>> =
            vec![Vec::new(); line.nodes.len() * types];
        let mut choices = Vec::new();
        let mut at = 0;
        while at < line.routes.len() {
            let route = &line.routes[at];
            let end = line.end_of_way(at);
            let way = match route.choice {
                None => Way::To(route.to as u32),
                Some(choice) => {
                    let way = Way::Choice(choices.len() as u32);
                    let routes = |first: usize, end: usize| Routes {
                        first: first as u32,
                        end: end as u32,
                        choice: choice as u32,
                    };
                    choices.push(routes(at, end));
                    choices.extend((at..end).map(|member| routes(member, member + 1)));
                    way
                }
            };
            by_start[route.from * types + route.part].push((way, route.condition.clone()));
            at = end;
        }
        let mut all = Vec::new();
        let mut index = Vec::new();
        let mut always = Vec::new();
        for ways in by_start {
            always.push(match ways[..] {
                [(Way::To(place), None), ..] => Some(place),
                _ => None,
            });
            let first = all.len() as u32;
            all.extend(ways);
            index.push(first..all.len() as u32);
        }
        Self {
            types,
            always,
            index,
            all,
            choices,
            to: line.routes.iter().map(|route| route.to as u32).collect(),
        }
    }

    /// The choice between the routes of a way; `None` if there is none.
    #[inline]
    pub(super) fn choice(&self, way: Way) -> Option<usize> {
        match way {
            Way::To(_) => None,
            Way::Choice(index) => Some(self.choices[index as usize].choice as usize),
        }
    }

    /// The places at the ends of a way.
    pub(super) fn to<'a>(&'a self, way: &'a Way) -> &'a [u32] {
        match way {
            Way::To(place) => std::slice::from_ref(place),
            Way::Choice(index) => {
                let Routes { first, end, .. } = self.choices[*index as usize];
                &self.to[first as usize..end as usize]
            }
        }
    }

    /// The place to which all parts of a type go from a node, if they do not choose.
    #[inline]
    pub(super) fn always(&self, node: usize, kind: usize) -> Option<u32> {
        self.always[node * self.types + kind]
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
        match self.setup.ways.always(node, self.parts[part].kind) {
            Some(place) => Some(Way::To(place)),
            None => self.chosen_way(node, part),
        }
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
            let choice = setup.ways.choice(way);
            let chosen = choice.and_then(|choice| choosers[choice].choose());
            return Some(match (way, chosen) {
                (Way::Choice(index), Some(number)) => Way::Choice(index + 1 + number),
                _ => way,
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
        let ways = &self.setup.ways;
        let places = ways.to(&way).iter().map(|to| *to as usize);
        let mut places = places.filter(takes);
        match ways.choice(way).map(|choice| &self.line.choices[choice]) {
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
