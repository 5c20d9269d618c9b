//! The names that a part of a file mentions, without those that are bound within it.

use linewright_syntax::ast::{
    self, ContractItem, DomainKind, Expr, ExprKind, Item, LayoutItem, LineItem, MachineItem,
    ResourceItem, StationItem, Stop, Supply, TimeValue,
};
use std::collections::BTreeSet;

/// Names that occur in a part of a file, except quantified names and the parameters of definitions.
#[derive(Debug, Default)]
pub(in crate::contract) struct Mentions<'a> {
    names: BTreeSet<&'a str>,
    /// Names that are bound at the current position.
    bound: Vec<&'a str>,
}

impl<'a> Mentions<'a> {
    pub fn has(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    /// Returns whether a label of a type occurs. It counts as a use of the type, because labels are
    /// written without their type.
    pub fn has_label_of(&self, domain: &ast::Domain) -> bool {
        match &domain.kind {
            DomainKind::Labels(labels) => labels.iter().any(|l| self.has(&l.text)),
            _ => false,
        }
    }

    /// Adds a name, unless it is bound at the current position.
    pub fn name(&mut self, name: &'a str) {
        if !self.bound.contains(&name) {
            self.names.insert(name);
        }
    }

    pub fn exprs(&mut self, list: impl IntoIterator<Item = &'a Expr>) {
        for e in list {
            self.expr(e);
        }
    }

    pub fn expr(&mut self, e: &'a Expr) {
        match &e.kind {
            ExprKind::Path(names) => {
                if let Some(first) = names.first() {
                    self.name(&first.text);
                }
            }
            ExprKind::Call(name, _) => self.name(&name.text),
            ExprKind::Quantifier(_, name, domain, body) => {
                self.domain(domain);
                self.bound.push(&name.text);
                self.expr(body);
                self.bound.pop();
                return;
            }
            _ => {}
        }
        self.exprs(e.children());
    }

    pub fn domain(&mut self, domain: &'a ast::Domain) {
        match &domain.kind {
            DomainKind::Range(low, high, _) => self.exprs([low, high]),
            DomainKind::Array(length, of) => {
                self.expr(length);
                self.domain(of);
            }
            DomainKind::Record(members) => members.iter().for_each(|(_, d)| self.domain(d)),
            DomainKind::Named(name) => self.name(&name.text),
            // A quantifier can range over an array with the name of a unit: `h`.
            DomainKind::Unit(name) => self.name(name),
            DomainKind::Labels(_) => {}
        }
    }

    fn arguments(&mut self, list: &'a [ast::Argument]) {
        self.exprs(list.iter().map(|a| &a.value));
    }

    fn header(&mut self, header: &'a ast::Header) {
        for parameter in &header.parameters {
            self.domain(&parameter.domain);
            self.exprs(&parameter.default);
        }
    }

    fn define(&mut self, define: &'a ast::Define) {
        let formals = define.formals.iter();
        formals.clone().for_each(|f| {
            if let Some(domain) = &f.domain {
                self.domain(domain);
            }
        });
        let bound = self.bound.len();
        self.bound.extend(formals.map(|f| f.name.text.as_str()));
        self.expr(&define.value);
        self.bound.truncate(bound);
    }

    fn constant(&mut self, constant: &'a ast::ConstDecl) {
        if let Some(domain) = &constant.domain {
            self.domain(domain);
        }
        self.expr(&constant.value);
    }

    fn typed(&mut self, typed: &'a ast::TypedDecl) {
        self.domain(&typed.domain);
        self.exprs(&typed.values);
    }

    fn performed(&mut self, list: &'a [ast::OperationCall]) {
        for performed in list {
            self.name(&performed.name.text);
            self.arguments(&performed.arguments);
        }
    }

    pub fn contract(&mut self, contract: &'a ast::Contract) {
        self.header(&contract.header);
        for item in &contract.items {
            match item {
                ContractItem::Variables { domain, .. } => self.domain(domain),
                ContractItem::Define(d) => self.define(d),
                ContractItem::Counter(c) => {
                    self.domain(&c.domain);
                    self.expr(&c.counts);
                    self.exprs(&c.resets);
                }
                ContractItem::Formula { expr, .. } => self.expr(expr),
                ContractItem::Type(t) => self.domain(&t.domain),
                ContractItem::Const(c) => self.constant(c),
            }
        }
    }

    pub fn machine(&mut self, machine: &'a ast::Machine) {
        self.header(&machine.header);
        for item in &machine.items {
            match item {
                MachineItem::Step(e)
                | MachineItem::IdlePower(e)
                | MachineItem::Power(e)
                | MachineItem::Limit(e)
                | MachineItem::Done(e)
                | MachineItem::Guarantee { expr: e, .. } => self.expr(e),
                MachineItem::Failures(f) => self.exprs(f.expressions()),
                MachineItem::Property(t)
                | MachineItem::Parameter(t)
                | MachineItem::Signal(t)
                | MachineItem::Abstract(t) => self.typed(t),
                MachineItem::Component(c) | MachineItem::Refines(c) => {
                    self.name(&c.contract.text);
                    self.arguments(&c.arguments);
                    self.exprs(&c.when);
                    self.exprs(c.time.iter().map(|(e, _)| e));
                    self.exprs(&c.power);
                    self.exprs(c.bindings.iter().map(|b| &b.value));
                }
                MachineItem::Skills(s) => {
                    self.name(&s.set.text);
                    self.exprs(s.calls.iter().map(|c| &c.value));
                }
                MachineItem::Operation { sequence, .. } => self.performed(sequence),
                MachineItem::Write { name, index, value } => {
                    self.name(&name.text);
                    self.exprs(index);
                    self.expr(value);
                }
                MachineItem::Const(c) => self.constant(c),
                MachineItem::Type(t) => self.domain(&t.domain),
            }
        }
    }

    fn line(&mut self, line: &'a ast::Line) {
        for item in &line.items {
            match item {
                LineItem::Part { properties, .. } => properties.iter().for_each(|p| self.typed(p)),
                LineItem::Source {
                    supply: Supply::Every { interval, .. },
                    ..
                } => self.exprs(interval.expressions()),
                LineItem::Buffer {
                    dwell, shelf_life, ..
                } => {
                    self.exprs(dwell.iter().flat_map(TimeValue::expressions));
                    self.exprs(shelf_life);
                }
                LineItem::Conveyor {
                    machine, options, ..
                } => {
                    if let Some((name, arguments)) = machine {
                        self.name(&name.text);
                        self.arguments(arguments);
                    }
                    self.exprs(options.iter().map(|(_, e)| e));
                }
                LineItem::Station { machine, items, .. } => {
                    if let Some((name, arguments)) = machine {
                        self.name(&name.text);
                        self.arguments(arguments);
                    }
                    for item in items {
                        self.station_item(item);
                    }
                }
                LineItem::Route { stops, when, .. } => {
                    self.exprs(stops.iter().flat_map(Stop::expressions));
                    self.exprs(when);
                }
                LineItem::Requirement { bound, .. } => self.expr(bound),
                LineItem::Shift(shift) => self.exprs(shift.expressions()),
                LineItem::Limit(e, _) => self.expr(e),
                LineItem::Const(c) => self.constant(c),
                LineItem::Product(_)
                | LineItem::Start(_)
                | LineItem::Holiday(..)
                | LineItem::Source { .. }
                | LineItem::Store { .. }
                | LineItem::Sink { .. } => {}
            }
        }
    }

    fn layout(&mut self, layout: &'a ast::Layout) {
        for item in &layout.items {
            match item {
                LayoutItem::Resource(r) => {
                    r.kind.iter().for_each(|kind| self.name(&kind.text));
                    for item in &r.items {
                        if let ResourceItem::Transition { actions, .. } = item {
                            self.exprs(actions.iter().flat_map(|a| a.time.iter().chain(&a.power)));
                        }
                    }
                }
                LayoutItem::Transport(t) => {
                    self.exprs(t.routes.iter().flat_map(|r| r.time.iter().chain(&r.power)));
                }
                LayoutItem::Const(c) => self.constant(c),
                LayoutItem::Duplicate { .. } | LayoutItem::AtStart { .. } => {}
            }
        }
    }

    fn station_item(&mut self, item: &'a StationItem) {
        match item {
            StationItem::Perform { operations, .. } => self.performed(operations),
            StationItem::Takes { duration, .. } | StationItem::Setup(duration) => {
                self.exprs(duration.expressions());
            }
            StationItem::Sets { index, value, .. } => {
                self.exprs(index);
                self.expr(value);
            }
            StationItem::IdlePower(e) | StationItem::Power(e) => self.expr(e),
            StationItem::Failures(f) => self.exprs(f.expressions()),
            StationItem::Shift(shift) => self.exprs(shift.expressions()),
            StationItem::Defect {
                probability, value, ..
            } => self.exprs([probability, value]),
        }
    }

    pub fn file(&mut self, file: &'a ast::File) {
        for item in &file.items {
            match item {
                // A skill set and a recipe mention no names outside of themselves.
                Item::Import(_) | Item::Skills(_) | Item::Recipe(_) => {}
                Item::Realize(r) => {
                    let names = r.recipes.iter().map(|r| &r.name).chain([&r.layout]);
                    names.for_each(|n| self.name(&n.text));
                }
                Item::Layout(l) => self.layout(l),
                Item::Type(t) => self.domain(&t.domain),
                Item::Const(c) => self.constant(c),
                Item::Define(d) => self.define(d),
                Item::Contract(c) => self.contract(c),
                Item::Machine(m) => self.machine(m),
                Item::Line(l) => self.line(l),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_core::source::FileId;

    #[test]
    fn nearer_names_hide_others() {
        let text = "contract A(n: 1..4 = LEAST) {
            input i, j: 0..n
            define far(k) = k > j
            guarantee always forall i in 0..LAST: far(i)
        }";
        let (file, findings) = linewright_syntax::parse(FileId::default(), text);
        assert_eq!(findings, []);
        let mut used = Mentions::default();
        used.file(&file);
        for (name, wanted) in [
            ("LEAST", true),
            ("n", true),
            ("i", false),
            ("j", true),
            ("k", false),
            ("LAST", true),
            ("far", true),
        ] {
            assert_eq!(used.has(name), wanted, "{name}");
        }
    }
}
