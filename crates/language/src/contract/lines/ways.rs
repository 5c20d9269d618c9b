//! Resolution of routes, of the choices between them, and of the order of parts in buffers.

use super::Builder;
use crate::contract::distribution::Distribution;
use crate::contract::line::{BufferOrder, Choice, Line, NodeKind, Route};
use crate::contract::machines::non_negative;
use crate::contract::value::Dimension;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Time;
use linewright_syntax::ast::{self, Stop, StopChoice};

/// Largest number of stations in `times`.
const MAX_COPIES: u64 = 1000;

/// Largest deviation of the sum of probabilities from 1.
const ROUNDING: f64 = 1e-9;

impl<'a> Builder<'a, '_> {
    /// Notes that a station stands for several.
    pub(super) fn copies(&mut self, name: &ast::Name, times: ast::Copies) {
        if !(1..=MAX_COPIES).contains(&times.count) {
            self.e.findings.error_with(
                codes::ARGUMENT,
                times.span,
                format!("there cannot be {} stations of a kind", times.count),
                format!("write a number from 1 to {MAX_COPIES}"),
            );
        } else if times.count > 1
            && let Some(node) = self.node_index.get(&name.text)
        {
            self.times.insert(*node, times.count as usize);
        }
    }

    /// Resolves the order of a buffer. A property is looked up in all part types; those that come
    /// to the buffer without it are reported by [`Builder::check_buffers`].
    pub(super) fn buffer_order(&mut self, order: Option<&'a ast::BufferOrder>) -> BufferOrder {
        match order {
            None => BufferOrder::FirstIn,
            Some(ast::BufferOrder::LastIn) => BufferOrder::LastIn,
            Some(ast::BufferOrder::Highest(property) | ast::BufferOrder::Lowest(property)) => {
                let find = |part: &super::Part| {
                    let properties = part.types.iter();
                    let found = properties
                        .filter(|(_, _, ty)| ty.length.is_none())
                        .find(|(name, ..)| *name == property.text);
                    found.map(|(_, index, _)| *index)
                };
                BufferOrder::Property {
                    highest: matches!(order, Some(ast::BufferOrder::Highest(_))),
                    of: self.parts.iter().map(find).collect(),
                }
            }
        }
    }

    /// Resolves the shelf life of parts in a buffer, in seconds. It must be longer than the
    /// shortest dwell time; otherwise every part would expire.
    pub(super) fn shelf_life(
        &mut self,
        written: &'a ast::Expr,
        dwell: Option<&Distribution>,
    ) -> Option<f64> {
        let seconds = non_negative(&mut self.e, written, Dimension::Time)?;
        let least = dwell.map_or(0.0, Distribution::least);
        if seconds > least {
            return Some(seconds);
        }
        let (message, help) = if seconds > 0.0 {
            (
                "every part expires before its dwell time is over",
                "write a shelf life that is longer than the dwell time",
            )
        } else {
            (
                "every part expires at once",
                "write a time such as `shelf life 8 h`",
            )
        };
        self.e
            .findings
            .error_with(codes::ARGUMENT, written.span, message, help);
        None
    }

    /// Reports part types that come to a buffer without the property that decides the order there.
    pub(super) fn check_buffers(&mut self, decl: &'a ast::Line, model: &Line) {
        for item in &decl.items {
            let ast::LineItem::Buffer {
                name,
                order:
                    Some(ast::BufferOrder::Highest(property) | ast::BufferOrder::Lowest(property)),
                ..
            } = item
            else {
                continue;
            };
            let Some(&node) = self.node_index.get(&name.text) else {
                continue;
            };
            let Some(NodeKind::Buffer {
                order: BufferOrder::Property { of, .. },
                ..
            }) = model.nodes.get(node).map(|node| &node.kind)
            else {
                continue;
            };
            for (part, found) in of.iter().enumerate() {
                if found.is_none() && model.is_brought(node, part) {
                    let part = &self.parts[part].model.name;
                    self.e.findings.error_with(
                        codes::PROPERTY,
                        property.span,
                        format!(
                            "`{part}` comes to `{}` and has no property `{}` with a single value",
                            name.text, property.text
                        ),
                        format!(
                            "declare it in `part {part}`: `property {}: 0..9 = 0`",
                            property.text
                        ),
                    );
                }
            }
        }
    }

    /// Adds the routes between consecutive stops. A condition applies to the first of them only.
    pub(super) fn route(
        &mut self,
        part: &'a ast::Name,
        stops: &'a [Stop],
        when: Option<&'a ast::Expr>,
        model: &mut Line,
    ) {
        let index = self.find_part(part);
        let nodes: Vec<Vec<Option<usize>>> = stops.iter().map(|stop| self.places(stop)).collect();
        let choices: Vec<Option<Choice>> = stops
            .iter()
            .enumerate()
            .map(|(position, stop)| self.choice(position, stop))
            .collect();
        let Some(index) = index else { return };
        let condition = when.and_then(|c| {
            let mut scope = self.part_scope(index);
            let term = scope.boolean(c, Time::Now);
            self.e.findings.absorb(&mut scope.findings);
            Some(term?.to_real(self.parts[index].model.properties.len()))
        });
        for (i, pair) in nodes.windows(2).enumerate() {
            for (j, from) in pair[0].iter().enumerate() {
                let choice = choices[i + 1].as_ref().map(|choice| {
                    model.choices.push(choice.clone());
                    model.choices.len() - 1
                });
                for (k, to) in pair[1].iter().enumerate() {
                    let (Some(from), Some(to)) = (*from, *to) else {
                        continue;
                    };
                    let (start, end) = (&stops[i].places[j], &stops[i + 1].places[k]);
                    model.routes.push(Route {
                        part: index,
                        from,
                        to,
                        condition: condition.clone().filter(|_| i == 0),
                        condition_span: when.map(|written| written.span).filter(|_| i == 0),
                        choice,
                        span: start.span.to(end.span),
                    });
                }
            }
        }
    }

    /// Finds the places of a stop; `None` for an unknown place, or one that is named twice.
    fn places(&mut self, stop: &Stop) -> Vec<Option<usize>> {
        let find = |(i, name): (usize, &ast::Name)| {
            let mut earlier = stop.places[..i].iter();
            if let Some(first) = earlier.find(|other| other.text == name.text) {
                self.e.findings.push(
                    Diagnostic::error(
                        codes::NAME_DUPLICATE,
                        name.span,
                        format!("`{}` is listed twice", name.text),
                    )
                    .with_label(first.span, "first listed here")
                    .with_help("remove one of the two"),
                );
                return None;
            }
            self.find_node(name)
        };
        stop.places.iter().enumerate().map(find).collect()
    }

    /// Resolves how parts choose between the places of a stop; `None` if there is only one place.
    fn choice(&mut self, position: usize, stop: &'a Stop) -> Option<Choice> {
        let count = stop.places.len();
        if let Some(written) = &stop.choice
            && (position == 0 || count == 1)
        {
            let (message, help) = if position == 0 {
                ("nothing is chosen where a route begins", "remove")
            } else {
                (
                    "there is only one place to choose",
                    "name several places, `a -> b, c`, or remove",
                )
            };
            self.e.findings.error_with(
                codes::ARGUMENT,
                stop.span,
                message,
                format!("{help} `{}`", written.words()),
            );
            return None;
        }
        if count == 1 {
            return None;
        }
        match &stop.choice {
            None | Some(StopChoice::FirstFree) => Some(Choice::FirstFree),
            Some(StopChoice::ShortestQueue) => Some(Choice::ShortestQueue),
            Some(StopChoice::RoundRobin) => Some(Choice::RoundRobin),
            Some(StopChoice::Probability(written)) => self.probabilities(stop, written),
        }
    }

    /// Resolves the probabilities of the places of a stop. The last one may be left out.
    fn probabilities(&mut self, stop: &'a Stop, written: &'a [ast::Expr]) -> Option<Choice> {
        let count = stop.places.len();
        let found = written
            .iter()
            .map(|share| self.e.constant_quantity(share, Dimension::None));
        let mut shares = found.collect::<Option<Vec<f64>>>()?;
        if written.len() + 1 == count {
            shares.push(1.0 - shares.iter().sum::<f64>());
        }
        let message = if shares.len() != count {
            format!(
                "there are {count} places and {} probabilities",
                written.len()
            )
        } else if written.len() < count && shares.last().is_some_and(|last| *last <= ROUNDING) {
            format!("nothing is left for `{}`", stop.places[count - 1].text)
        } else if shares.iter().any(|share| *share <= ROUNDING) {
            "each place must have a probability greater than 0".to_owned()
        } else if (shares.iter().sum::<f64>() - 1.0).abs() > ROUNDING {
            "the probabilities do not add up to 100 %".to_owned()
        } else {
            return Some(Choice::Probability { shares });
        };
        self.e.findings.error_with(
            codes::ARGUMENT,
            stop.span,
            message,
            "write one probability for each place; the last one may be left out: `a, b by probability 5 %`",
        );
        None
    }
}
