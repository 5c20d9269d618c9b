//! Removes the source positions from syntax trees, so that the content of two texts can be
//! compared.

mod recipe;
mod skills;

use super::ast::{
    Argument, Between, BufferOrder, Column, Component, ConstDecl, Contract, ContractItem, Counter,
    Define, Domain, DomainKind, Expr, ExprKind, Failures, File, Header, Item, Line, LineItem,
    Machine, MachineItem, Name, OperationCall, PartCount, Scope, Shift, StationItem, Stop,
    StopChoice, Supply, TimeValue, TypeDecl, TypedDecl,
};
use linewright_core::source::Span;

impl File {
    /// Clears all spans and places, so that trees of texts that differ only in layout and comments
    /// are equal.
    #[must_use]
    pub fn without_spans(mut self) -> Self {
        self.places.clear();
        self.tables.clear();
        for item in &mut self.items {
            match item {
                Item::Import(i) => i.span = Span::default(),
                Item::Type(t) => type_decl(t),
                Item::Const(c) => const_decl(c),
                Item::Define(d) => define(d),
                Item::Contract(c) => contract(c),
                Item::Machine(m) => machine(m),
                Item::Line(l) => line(l),
                Item::Skills(s) => skills::skills(s),
                Item::Layout(l) => recipe::layout(l),
                Item::Recipe(r) => recipe::recipe(r),
                Item::Realize(r) => recipe::realize(r),
            }
        }
        self
    }
}

fn name(n: &mut Name) {
    n.span = Span::default();
}

fn names<'n>(list: impl IntoIterator<Item = &'n mut Name>) {
    list.into_iter().for_each(name);
}

fn exprs<'e>(list: impl IntoIterator<Item = &'e mut Expr>) {
    list.into_iter().for_each(expr);
}

fn arguments(list: &mut [Argument]) {
    for a in list {
        name(&mut a.name);
        expr(&mut a.value);
    }
}

fn performed(list: &mut [OperationCall]) {
    for p in list {
        name(&mut p.name);
        arguments(&mut p.arguments);
    }
}

fn counted(list: &mut [PartCount]) {
    names(list.iter_mut().map(|c| &mut c.name));
}

fn type_decl(t: &mut TypeDecl) {
    name(&mut t.name);
    domain(&mut t.domain);
}

fn const_decl(c: &mut ConstDecl) {
    name(&mut c.name);
    c.domain.iter_mut().for_each(domain);
    expr(&mut c.value);
}

fn define(d: &mut Define) {
    name(&mut d.name);
    for f in &mut d.formals {
        name(&mut f.name);
        f.domain.iter_mut().for_each(domain);
    }
    expr(&mut d.value);
}

fn counter(c: &mut Counter) {
    name(&mut c.name);
    domain(&mut c.domain);
    expr(&mut c.counts);
    exprs(&mut c.resets);
}

fn typed(t: &mut TypedDecl) {
    name(&mut t.name);
    domain(&mut t.domain);
    exprs(&mut t.values);
}

fn header(h: &mut Header) {
    name(&mut h.name);
    for p in &mut h.parameters {
        name(&mut p.name);
        domain(&mut p.domain);
        exprs(&mut p.default);
    }
    names(&mut h.codes);
}

fn contract(c: &mut Contract) {
    header(&mut c.header);
    for item in &mut c.items {
        match item {
            ContractItem::Variables {
                names: list,
                domain: d,
                ..
            } => {
                names(list);
                domain(d);
            }
            ContractItem::Define(d) => define(d),
            ContractItem::Counter(c) => counter(c),
            ContractItem::Formula {
                name: label,
                expr: e,
                ..
            } => {
                names(label);
                expr(e);
            }
            ContractItem::Type(t) => type_decl(t),
            ContractItem::Const(c) => const_decl(c),
        }
    }
}

fn machine(m: &mut Machine) {
    header(&mut m.header);
    for item in &mut m.items {
        match item {
            MachineItem::Step(e)
            | MachineItem::IdlePower(e)
            | MachineItem::Power(e)
            | MachineItem::Limit(e)
            | MachineItem::Done(e) => expr(e),
            MachineItem::Failures(f) => failures(f),
            MachineItem::Property(t)
            | MachineItem::Parameter(t)
            | MachineItem::Signal(t)
            | MachineItem::Abstract(t) => typed(t),
            MachineItem::Component(c) | MachineItem::Refines(c) => component(c),
            MachineItem::Skills(s) => skills::skill_calls(s),
            MachineItem::Guarantee {
                name: label,
                expr: e,
                ..
            } => {
                names(label);
                expr(e);
            }
            MachineItem::Operation {
                name: n,
                codes,
                sequence,
            } => {
                name(n);
                names(codes);
                performed(sequence);
            }
            MachineItem::Write {
                name: n,
                index,
                value,
            } => {
                name(n);
                exprs(index);
                expr(value);
            }
            MachineItem::Const(c) => const_decl(c),
            MachineItem::Type(t) => type_decl(t),
        }
    }
}

fn component(c: &mut Component) {
    names([&mut c.name, &mut c.contract]);
    arguments(&mut c.arguments);
    exprs(&mut c.when);
    exprs(c.time.iter_mut().map(|(e, _)| e));
    exprs(&mut c.power);
    for b in &mut c.bindings {
        name(&mut b.name);
        names(&mut b.member);
        expr(&mut b.value);
    }
}

fn line(l: &mut Line) {
    name(&mut l.name);
    for item in &mut l.items {
        match item {
            LineItem::Part {
                name: n,
                bill,
                properties,
            } => {
                name(n);
                counted(bill);
                properties.iter_mut().for_each(typed);
            }
            LineItem::Product(names) => names.iter_mut().for_each(name),
            LineItem::Buffer {
                name: n,
                order,
                dwell,
                shelf_life,
                ..
            } => {
                name(n);
                dwell.iter_mut().for_each(duration);
                exprs(shelf_life);
                if let Some(BufferOrder::Highest(p) | BufferOrder::Lowest(p)) = order {
                    name(p);
                }
            }
            LineItem::Source {
                name: n,
                part,
                supply,
                ..
            } => {
                names([n, part]);
                match supply {
                    Supply::Every { interval, .. } => duration(interval),
                    Supply::At(c) => column(c),
                    Supply::OnOrder => {}
                }
            }
            LineItem::Store { name: n, stock } => {
                name(n);
                counted(stock);
            }
            LineItem::Sink {
                name: n, reorder, ..
            } => {
                name(n);
                names(reorder);
            }
            LineItem::Conveyor {
                name: n,
                machine,
                options,
            } => {
                name(n);
                if let Some((machine, list)) = machine {
                    name(machine);
                    arguments(list);
                }
                for (word, value) in options {
                    name(word);
                    expr(value);
                }
            }
            LineItem::Station {
                name: n,
                machine,
                times,
                items,
            } => {
                name(n);
                if let Some(times) = times {
                    times.span = Span::default();
                }
                if let Some((machine, list)) = machine {
                    name(machine);
                    arguments(list);
                }
                items.iter_mut().for_each(station);
            }
            LineItem::Route { part, stops, when } => {
                name(part);
                stops.iter_mut().for_each(stop);
                exprs(when);
            }
            LineItem::Requirement {
                name: n,
                metric,
                of,
                bound,
                span,
                ..
            } => {
                names([n, metric]);
                names(of);
                expr(bound);
                *span = Span::default();
            }
            LineItem::Shift(s) => shift(s),
            LineItem::Start(date) => name(date),
            LineItem::Holiday(first, last) => {
                name(first);
                names(last);
            }
            LineItem::Limit(e, _) => expr(e),
            LineItem::Const(c) => const_decl(c),
        }
    }
}

fn stop(stop: &mut Stop) {
    names(&mut stop.places);
    if let Some(StopChoice::Probability(shares)) = &mut stop.choice {
        exprs(shares);
    }
    stop.span = Span::default();
}

fn station(item: &mut StationItem) {
    match item {
        StationItem::Perform { operations, part } => {
            performed(operations);
            name(part);
        }
        StationItem::Takes { duration: d, part } => {
            duration(d);
            names(part);
        }
        StationItem::Sets {
            property,
            index,
            value,
            part,
        } => {
            name(property);
            exprs(index);
            expr(value);
            names(part);
        }
        StationItem::Setup(d) => duration(d),
        StationItem::IdlePower(e) | StationItem::Power(e) => expr(e),
        StationItem::Failures(f) => failures(f),
        StationItem::Shift(s) => shift(s),
        StationItem::Defect {
            part,
            probability,
            one_of: _,
            property,
            value,
        } => {
            names([part, property]);
            exprs([probability, value]);
        }
    }
}

fn shift(s: &mut Shift) {
    for hours in std::iter::once(&mut s.hours).chain(&mut s.breaks) {
        exprs([&mut hours.from, &mut hours.to]);
        hours.span = Span::default();
    }
    for days in &mut s.days {
        name(&mut days.first);
        names(&mut days.last);
    }
}

fn duration(d: &mut TimeValue) {
    match d {
        TimeValue::Value(value) => expr(value),
        TimeValue::Drawn {
            name: n,
            outcomes,
            span,
        } => {
            name(n);
            for outcome in outcomes {
                expr(&mut outcome.value);
                exprs(&mut outcome.weight);
            }
            *span = Span::default();
        }
        TimeValue::Empirical { column: c, span } => {
            column(c);
            *span = Span::default();
        }
    }
}

fn column(c: &mut Column) {
    names([&mut c.path, &mut c.header, &mut c.unit]);
}

fn failures(f: &mut Failures) {
    names(&mut f.name);
    if let Between::Time(value) | Between::DrawnParts(value) = &mut f.between {
        duration(value);
    }
    duration(&mut f.mttr);
    f.span = Span::default();
}

fn domain(d: &mut Domain) {
    d.span = Span::default();
    match &mut d.kind {
        DomainKind::Labels(list) => names(list),
        DomainKind::Range(low, high, _) => exprs([low, high]),
        DomainKind::Record(members) => {
            for (n, d) in members {
                name(n);
                domain(d);
            }
        }
        DomainKind::Array(length, d) => {
            expr(length);
            domain(d);
        }
        DomainKind::Named(n) => name(n),
        DomainKind::Unit(_) => {}
    }
}

fn expr(e: &mut Expr) {
    e.span = Span::default();
    match &mut e.kind {
        ExprKind::Unknown | ExprKind::Bool(_) | ExprKind::Int(_) | ExprKind::Quantity(..) => {}
        ExprKind::Path(list) => names(list),
        ExprKind::Index(a, b)
        | ExprKind::Binary(_, a, b)
        | ExprKind::Since(a, b)
        | ExprKind::Until(_, a, b) => {
            exprs([&mut **a, &mut **b]);
        }
        ExprKind::Next(a)
        | ExprKind::Always(a)
        | ExprKind::Eventually(a)
        | ExprKind::Not(a)
        | ExprKind::Neg(a) => expr(a),
        ExprKind::If(a, b, c) | ExprKind::Within(a, b, c) => {
            exprs([&mut **a, &mut **b, &mut **c]);
        }
        ExprKind::Quantifier(_, n, d, a) => {
            name(n);
            domain(d);
            expr(a);
        }
        ExprKind::Call(n, list) => {
            name(n);
            exprs(list);
        }
        ExprKind::List(list) => exprs(list),
        ExprKind::Member(a, list) => {
            expr(a);
            exprs(list);
        }
        ExprKind::Field(a, n) => {
            expr(a);
            name(n);
        }
        ExprKind::Record(list) => arguments(list),
        ExprKind::Past(_, a, bound) => {
            expr(a);
            exprs(bound.as_deref_mut());
        }
        ExprKind::Pattern(pattern) => {
            use super::ast::PatternKind::{Absence, Existence, Precedence, Response, Universality};
            match &mut pattern.kind {
                Absence(a) | Existence(a) | Universality(a) => expr(a),
                Precedence(a, b) | Response(a, b) => exprs([&mut **a, &mut **b]),
            }
            exprs(pattern.bound.as_deref_mut());
            match &mut pattern.scope {
                Scope::Globally => {}
                Scope::Before(a) | Scope::After(a) => expr(a),
                Scope::Between(a, b) | Scope::AfterUntil(a, b) => exprs([&mut **a, &mut **b]),
            }
        }
    }
}
