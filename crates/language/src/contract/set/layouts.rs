//! The numbers of a layout that can be set.

use super::slots::{Present, Slots, count, expression};
use linewright_core::source::Span;
use linewright_syntax::ValueSyntax;
use linewright_syntax::ast::{
    ActionKind, CountedName, Dock, Expr, Layout, LayoutItem, PartCapacity, Resource, ResourceItem,
    Transport,
};

impl Slots<'_> {
    /// Visits the numbers of a layout: constants, capacities, stocks, durations and powers.
    pub(super) fn layout(&mut self, layout: &mut Layout) {
        for item in &mut layout.items {
            match item {
                LayoutItem::Const(c) => self.expression([c.name.text.clone()], &mut c.value),
                LayoutItem::Resource(r) => self.resource(r),
                LayoutItem::Transport(t) => self.transport(t),
                LayoutItem::AtStart {
                    resource, parts, ..
                } => self.stock(&resource.text, parts),
                LayoutItem::Duplicate { .. } => {}
            }
        }
    }

    fn resource(&mut self, resource: &mut Resource) {
        let name = &resource.name;
        self.room(&name.text, name.span, &mut resource.capacity);
        for item in &mut resource.items {
            let ResourceItem::Transition { from, to, actions } = item else {
                continue;
            };
            for action in actions {
                let word = match &action.kind {
                    ActionKind::Operation(word) | ActionKind::Internal(word) => word.text.clone(),
                    ActionKind::In(label) => transfer("in", label.as_ref().map(|l| &*l.text)),
                    ActionKind::Out(label) => transfer("out", label.as_ref().map(|l| &*l.text)),
                };
                let names = [
                    format!("{}.{word}", name.text),
                    format!("{}.{}.{}.{word}", name.text, from.text, to.text),
                ];
                self.ride(&names, &mut action.time, &mut action.power);
            }
        }
    }

    fn transport(&mut self, transport: &mut Transport) {
        let name = &transport.name;
        self.room(&name.text, name.span, &mut transport.capacity);
        for route in &mut transport.routes {
            let pairs = || {
                let ends = |from| route.to.iter().map(move |to| (from, to));
                route.from.iter().flat_map(ends)
            };
            let of_resources = pairs().map(|(from, to)| {
                let (from, to) = (&from.resource.text, &to.resource.text);
                format!("{}.{from}.{to}", name.text)
            });
            let of_docks = pairs().map(|(from, to)| {
                let (from, to) = (dock(from), dock(to));
                format!("{}.{from}.{to}", name.text)
            });
            let mut names: Vec<String> = of_resources.collect();
            names.extend(of_docks);
            names.dedup();
            self.ride(&names, &mut route.time, &mut route.power);
        }
    }

    /// The duration and the power of an action or a route, which may be absent.
    fn ride(&mut self, of: &[String], time: &mut Option<Expr>, power: &mut Option<Expr>) {
        for (word, value) in [("time", time), ("power", power)] {
            let names: Vec<String> = of.iter().map(|name| format!("{name}.{word}")).collect();
            let present = value.as_ref().map(|value| Present::Text(value.span));
            self.slot(names, ValueSyntax::Expression, present, |new| {
                *value = Some(expression(new).0);
            });
        }
    }

    /// The capacity of a resource or transport, which is 1 if absent.
    fn room(&mut self, name: &str, place: Span, capacity: &mut Option<PartCapacity>) {
        let present = Some(Present::Count(capacity.map_or(1, |c| c.count)));
        let span = capacity.map_or(place, |c| c.span);
        let names = [format!("{name}.holds")];
        self.slot_at(names, ValueSyntax::Count, present, Some(span), |new| {
            let count = count(&new);
            *capacity = Some(PartCapacity { count, span });
        });
    }

    fn stock(&mut self, resource: &str, parts: &mut [CountedName]) {
        for part in parts {
            let names = [format!("{resource}.{}", part.name.text)];
            let present = Some(Present::Count(part.count.unwrap_or(1)));
            let place = Some(part.name.span);
            self.slot_at(names, ValueSyntax::Count, present, place, |new| {
                part.count = Some(count(&new));
            });
        }
    }
}

fn transfer(word: &str, label: Option<&str>) -> String {
    label.map_or_else(|| word.to_owned(), |label| format!("{word}.{label}"))
}

fn dock(dock: &Dock) -> String {
    transfer(&dock.resource.text, dock.label.as_ref().map(|l| &*l.text))
}
