//! The numbers of a line that are not those of a declaration alone: conditions and probabilities of
//! routes, hours of shifts, the values that stations and defects give to parts, and the bounds of
//! types.
//!
//! Statements without a name are named after the place where they are, and are counted from 1 if
//! there are several: `camera.Water.when.2` is the second condition on which water leaves the
//! camera.

use super::slots::{Slots, expression};
use linewright_core::source::Span;
use linewright_syntax::ValueSyntax;
use linewright_syntax::ast::{
    self, Domain, DomainKind, Expr, ExprKind, Hours, LineItem, Shift, StationItem, StopChoice,
};
use std::collections::BTreeMap;

/// Counts how often names come, to tell apart those that come several times.
#[derive(Default)]
struct Numbering {
    total: BTreeMap<String, usize>,
    seen: BTreeMap<String, usize>,
}

impl Numbering {
    /// Announces a name.
    fn announce(&mut self, name: String) {
        *self.total.entry(name).or_default() += 1;
    }

    /// The name with its number, `camera.Water.when.2`; `None` if it comes only once.
    fn numbered(&mut self, name: &str) -> Option<String> {
        let seen = self.seen.entry(name.to_owned()).or_default();
        *seen += 1;
        let several = self.total.get(name).is_some_and(|total| *total > 1);
        several.then(|| format!("{name}.{seen}"))
    }
}

impl Slots<'_> {
    /// Conditions and probabilities of routes.
    pub(super) fn ways(&mut self, line: &mut ast::Line) {
        let mut numbering = Numbering::default();
        for item in &line.items {
            if let LineItem::Route { part, stops, when } = item {
                if when.is_some() {
                    let from = stops.iter().take(1).flat_map(|stop| &stop.places);
                    for from in from {
                        numbering.announce(format!("{}.{}.when", from.text, part.text));
                    }
                }
                for pair in stops.windows(2) {
                    let Some(StopChoice::Probability(shares)) = &pair[1].choice else {
                        continue;
                    };
                    for from in &pair[0].places {
                        for to in pair[1].places.iter().take(shares.len()) {
                            numbering.announce(share_of(from, Some(part), to));
                        }
                    }
                }
            }
        }
        for item in &mut line.items {
            let LineItem::Route { part, stops, when } = item else {
                continue;
            };
            if let Some(when) = when {
                let mut names = Vec::new();
                let places = || stops.iter().take(1).flat_map(|stop| &stop.places);
                names.extend(places().map(|from| format!("{}.when", from.text)));
                let full = places().map(|from| format!("{}.{}.when", from.text, part.text));
                let full: Vec<String> = full.collect();
                let numbered: Vec<String> = full
                    .iter()
                    .filter_map(|name| numbering.numbered(name))
                    .collect();
                names.extend(full);
                names.extend(numbered);
                self.expression(names, when);
            }
            for end in 1..stops.len() {
                let (before, rest) = stops.split_at_mut(end);
                let (before, stop) = (&before[end - 1], &mut rest[0]);
                let Some(StopChoice::Probability(shares)) = &mut stop.choice else {
                    continue;
                };
                for (share, to) in shares.iter_mut().zip(&stop.places) {
                    let from = before.places.iter();
                    let short = from.clone().map(|from| share_of(from, None, to));
                    let full = from.map(|from| share_of(from, Some(part), to));
                    let full: Vec<String> = full.collect();
                    let numbered = full.iter().filter_map(|name| numbering.numbered(name));
                    let numbered: Vec<String> = numbered.collect();
                    let names: Vec<String> = short.chain(full).chain(numbered).collect();
                    self.expression_at(names, share, stop.span);
                }
            }
        }
    }

    /// Hours of shifts and breaks. `owner` is the station with a dot, or empty for those of the
    /// line.
    pub(super) fn shifts<'s>(&mut self, owner: &str, shifts: impl Iterator<Item = &'s mut Shift>) {
        for (index, shift) in shifts.enumerate() {
            let of = [
                format!("{owner}shift"),
                format!("{owner}shift.{}", index + 1),
            ];
            self.hours(&of, &mut shift.hours);
            for (at, hours) in shift.breaks.iter_mut().enumerate() {
                let number = at + 1;
                let [short, full] = &of;
                let of = [
                    format!("{short}.break"),
                    format!("{short}.break.{number}"),
                    format!("{full}.break"),
                    format!("{full}.break.{number}"),
                ];
                self.hours(&of, hours);
            }
        }
    }

    fn hours(&mut self, of: &[String], hours: &mut Hours) {
        let Hours { from, to, span } = hours;
        let at = *span;
        for (word, value) in [("from", from), ("to", to)] {
            let names = of.iter().map(|of| format!("{of}.{word}"));
            self.expression_at(names.collect(), value, at);
        }
    }

    /// The probabilities of defects, and the values that the station and its defects give to parts.
    pub(super) fn changes_of_parts(&mut self, station: &str, items: &mut [StationItem]) {
        let mut numbering = Numbering::default();
        for name in items.iter().filter_map(|item| full_name(station, item)) {
            numbering.announce(name);
        }
        for item in items {
            let full = full_name(station, item);
            let numbered = full.as_deref().and_then(|full| numbering.numbered(full));
            match item {
                StationItem::Sets {
                    property,
                    index,
                    value,
                    ..
                } => {
                    let element = element(&property.text, index.as_ref());
                    let mut names = vec![format!("{station}.sets.{}", property.text)];
                    if element != property.text {
                        names.push(format!("{station}.sets.{element}"));
                    }
                    names.extend(full.filter(|full| !names.contains(full)));
                    names.extend(numbered);
                    self.expression(names, value);
                }
                StationItem::Defect {
                    probability,
                    property,
                    value,
                    ..
                } => {
                    let mut names = vec![
                        format!("{station}.defect"),
                        format!("{station}.defect.{}", property.text),
                    ];
                    names.extend(full);
                    names.extend(numbered);
                    let becomes = names.iter().map(|name| format!("{name}.becomes"));
                    let becomes: Vec<String> = becomes.collect();
                    self.expression(names, probability);
                    self.expression(becomes, value);
                }
                _ => {}
            }
        }
    }

    /// The bounds of ranges and the lengths of arrays in a type.
    pub(super) fn bounds(&mut self, of: &str, domain: &mut Domain) {
        let at = domain.span;
        match &mut domain.kind {
            DomainKind::Range(low, high, _) => {
                self.expression_at(vec![format!("{of}.min")], low, at);
                self.expression_at(vec![format!("{of}.max")], high, at);
            }
            DomainKind::Array(length, domain) => {
                self.expression_at(vec![format!("{of}.length")], length, at);
                self.bounds(of, domain);
            }
            DomainKind::Record(members) => {
                for (name, domain) in members {
                    self.bounds(&format!("{of}.{}", name.text), domain);
                }
            }
            DomainKind::Labels(_) | DomainKind::Named(_) | DomainKind::Unit(_) => {}
        }
    }

    /// An expression; `at` is where the resolver may report a wrong value.
    pub(super) fn expression_at(&mut self, names: Vec<String>, value: &mut Expr, at: Span) {
        let present = Some(super::slots::Present::Text(value.span));
        self.slot_at(names, ValueSyntax::Expression, present, Some(at), |new| {
            *value = expression(new).0;
        });
    }
}

/// Name of the probability of one place of a choice.
fn share_of(from: &ast::Name, part: Option<&ast::Name>, to: &ast::Name) -> String {
    match part {
        Some(part) => format!("{}.{}.probability.{}", from.text, part.text, to.text),
        None => format!("{}.probability.{}", from.text, to.text),
    }
}

/// A property, or its element: `heights[1]`. An index that is no number is left out.
pub(super) fn element(property: &str, index: Option<&Expr>) -> String {
    match index.map(|index| &index.kind) {
        Some(ExprKind::Int(index)) => format!("{property}[{index}]"),
        _ => property.to_owned(),
    }
}

/// The full name of a value that a station gives, or of a defect.
fn full_name(station: &str, item: &StationItem) -> Option<String> {
    match item {
        StationItem::Sets {
            property,
            index,
            part,
            ..
        } => {
            let element = element(&property.text, index.as_ref());
            Some(match part {
                Some(part) => format!("{station}.sets.{}.{element}", part.text),
                None => format!("{station}.sets.{element}"),
            })
        }
        StationItem::Defect { part, property, .. } => {
            Some(format!("{station}.defect.{}.{}", part.text, property.text))
        }
        _ => None,
    }
}
