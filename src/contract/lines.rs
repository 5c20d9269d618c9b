//! From a line's syntax tree to its model: machines instantiated, part types, stations, routes.

use super::elaborate::{Elaborator, nearest};
use super::instantiate;
use super::line::{
    Belt, Comparison, Defect, InitialValue, Limit, Line, Metric, Node, NodeKind, PartProperty,
    PartType, Requirement, Route, Shift, Supply, Task,
};
use super::machine::{Machine, PropertyKind};
use super::machines::{
    PropertyType, assigned, element_names, failures, machine, positive, property_type,
    property_values, see_property,
};
use super::routes;
use super::scope::{Scope, double};
use super::value::Dimension;
use crate::diagnostics::{Diagnostic, codes, has_errors};
use crate::gr1::Time;
use crate::source::{SourceMap, Span};
use crate::syntax::ast::{self, ExprKind, LineItem, StationItem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A part type with what expressions see of it.
struct Part {
    model: PartType,
    /// By name: first element and type.
    types: Vec<(String, usize, PropertyType)>,
}

struct Builder<'a, 's> {
    scope: &'s Scope<'a>,
    sources: &'s SourceMap,
    e: Elaborator<'a>,
    parts: Vec<Part>,
    part_index: BTreeMap<String, usize>,
    node_index: BTreeMap<String, usize>,
}

/// A line. `None` when something is wrong; findings say what.
pub(super) fn line<'a>(
    scope: &Scope<'a>,
    sources: &SourceMap,
    decl: &'a ast::Line,
    findings: &mut Vec<Diagnostic>,
) -> Option<Line> {
    let mut e = scope.elaborator();
    e.real = true;
    let mut builder = Builder {
        scope,
        sources,
        e,
        parts: Vec::new(),
        part_index: BTreeMap::new(),
        node_index: BTreeMap::new(),
    };
    let model = builder.build(decl);
    let mut e = builder.e;
    if !has_errors(&e.findings) {
        routes::check(&model, &mut e.findings);
    }
    let broken = has_errors(&e.findings);
    findings.append(&mut e.findings);
    (!broken).then_some(model)
}

impl<'a> Builder<'a, '_> {
    fn build(&mut self, decl: &'a ast::Line) -> Line {
        for item in &decl.items {
            if let LineItem::Const(c) = item {
                super::scope::constant(&mut self.e, c, &mut Vec::new());
            }
        }
        self.declare_names(decl);
        self.declare_parts(decl);
        let mut model = Line {
            name: decl.name.text.clone(),
            doc: decl.doc.clone(),
            parts: Vec::new(),
            product: 0,
            nodes: Vec::new(),
            routes: Vec::new(),
            requirements: Vec::new(),
            limit: None,
            shift: None,
            span: decl.name.span,
        };
        for item in &decl.items {
            if let Some((name, kind)) = self.node(item) {
                model.nodes.push(Node {
                    name: name.text.clone(),
                    kind,
                    span: name.span,
                });
            } else if is_node(item) {
                // Keep the indices right; the findings stop the line anyway.
                model.nodes.push(Node {
                    name: String::new(),
                    kind: NodeKind::Buffer { capacity: 1 },
                    span: decl.name.span,
                });
            }
        }
        self.product(decl, &mut model);
        for item in &decl.items {
            self.statement(item, &mut model);
        }
        model.parts = std::mem::take(&mut self.parts)
            .into_iter()
            .map(|p| p.model)
            .collect();
        model
    }

    fn declare_names(&mut self, decl: &'a ast::Line) {
        let mut spans: BTreeMap<&str, Span> = BTreeMap::new();
        let mut nodes = 0;
        let mut parts = 0;
        for item in &decl.items {
            let (name, node) = match item {
                LineItem::Part { name, .. } => (name, false),
                LineItem::Source { name, .. }
                | LineItem::Store { name, .. }
                | LineItem::Sink { name, .. }
                | LineItem::Buffer { name, .. }
                | LineItem::Conveyor { name, .. }
                | LineItem::Station { name, .. } => (name, true),
                _ => continue,
            };
            if let Some(first) = spans.get(name.text.as_str()) {
                self.e.findings.push(double(name, *first));
            }
            spans.insert(&name.text, name.span);
            let (index, counter) = if node {
                (&mut self.node_index, &mut nodes)
            } else {
                (&mut self.part_index, &mut parts)
            };
            index.insert(name.text.clone(), *counter);
            *counter += 1;
        }
    }

    fn find_part(&mut self, name: &ast::Name) -> Option<usize> {
        if let Some(i) = self.part_index.get(&name.text) {
            return Some(*i);
        }
        let help = match nearest(&name.text, self.part_index.keys().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("declare it: `part {} {{ ... }}`", name.text),
        };
        self.e.error_with(
            codes::LINE_UNKNOWN,
            name.span,
            format!("there is no part type `{}`", name.text),
            help,
        );
        None
    }

    fn find_node(&mut self, name: &ast::Name) -> Option<usize> {
        if let Some(i) = self.node_index.get(&name.text) {
            return Some(*i);
        }
        let help = match nearest(&name.text, self.node_index.keys().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "declare it as a `station`, `conveyor`, `buffer`, `source`, `sink` or `store`"
                .to_owned(),
        };
        self.e.error_with(
            codes::LINE_UNKNOWN,
            name.span,
            format!("this line has no place called `{}`", name.text),
            help,
        );
        None
    }

    // ---- parts -------------------------------------------------------------------------------------------------------

    fn declare_parts(&mut self, decl: &'a ast::Line) {
        // Types first: a product's values may come from parts that are declared after it.
        for item in &decl.items {
            let LineItem::Part {
                name,
                bill,
                properties,
            } = item
            else {
                continue;
            };
            let mut types: Vec<(String, usize, PropertyType)> = Vec::new();
            let mut first = 0;
            for p in properties {
                if let Some((_, _, _)) = types.iter().find(|(n, ..)| *n == p.name.text) {
                    self.e.error(
                        codes::NAME_DOUBLE,
                        p.name.span,
                        format!("`{}` is declared twice", p.name.text),
                    );
                    continue;
                }
                if let Some(ty) = property_type(&mut self.e, &p.domain) {
                    let n = ty.length.unwrap_or(1);
                    types.push((p.name.text.clone(), first, ty));
                    first += n;
                }
            }
            let mut resolved = Vec::new();
            for counted in bill {
                if counted.count == 0 || counted.count > 10_000 {
                    self.e.error(
                        codes::ARGUMENT,
                        counted.name.span,
                        "a bill of materials counts from 1 to 10000",
                    );
                }
                if let Some(part) = self.find_part(&counted.name) {
                    resolved.push((part, counted.count as u32));
                }
            }
            self.parts.push(Part {
                model: PartType {
                    name: name.text.clone(),
                    properties: Vec::new(),
                    bill: resolved,
                    span: name.span,
                },
                types,
            });
        }
        let mut index = 0;
        for item in &decl.items {
            let LineItem::Part { properties, .. } = item else {
                continue;
            };
            for p in properties {
                let Some((_, _, ty)) = self.parts[index]
                    .types
                    .iter()
                    .find(|(n, ..)| *n == p.name.text)
                    .cloned()
                else {
                    continue;
                };
                let initial = self.initial(index, &ty, p.values.first());
                for (i, name) in element_names(&p.name.text, &ty).into_iter().enumerate() {
                    let initial = initial
                        .as_ref()
                        .and_then(|v| v.get(i).copied())
                        .unwrap_or(InitialValue::Number(0.0));
                    self.parts[index].model.properties.push(PartProperty {
                        name,
                        unit: ty.unit.clone(),
                        domain: ty.domain.clone(),
                        initial,
                    });
                }
            }
            index += 1;
        }
    }

    /// `= 0`, `= [0, 1]`, or `= Printed.heights`.
    fn initial(
        &mut self,
        part: usize,
        ty: &PropertyType,
        value: Option<&'a ast::Expr>,
    ) -> Option<Vec<InitialValue>> {
        if let Some(ast::Expr {
            kind: ExprKind::Path(names),
            span,
        }) = value
            && let [component, property] = names.as_slice()
            && let Some(from) = self.part_index.get(&component.text).copied()
        {
            if !self.parts[part].model.bill.iter().any(|(p, _)| *p == from) {
                self.e.error(
                    codes::PROPERTY,
                    *span,
                    format!(
                        "`{}` is not in the bill of materials of `{}`",
                        component.text, self.parts[part].model.name
                    ),
                );
                return None;
            }
            let found = self.parts[from]
                .types
                .iter()
                .find(|(n, ..)| *n == property.text)
                .cloned();
            let Some((_, first, found)) = found else {
                let known = self.parts[from].types.iter().map(|(n, ..)| n.as_str());
                let help = match nearest(&property.text, known) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("declare it in `part {}`", component.text),
                };
                self.e.error_with(
                    codes::PROPERTY,
                    property.span,
                    format!("`{}` has no property `{}`", component.text, property.text),
                    help,
                );
                return None;
            };
            if found.unit != ty.unit || found.length != ty.length || found.domain != ty.domain {
                self.e.error(
                    codes::TYPE_MISMATCH,
                    *span,
                    "this property has another type",
                );
                return None;
            }
            return Some(
                (0..ty.length.unwrap_or(1))
                    .map(|i| InitialValue::Component(from, first + i))
                    .collect(),
            );
        }
        let numbers = property_values(&mut self.e, ty, value)?;
        Some(numbers.into_iter().map(InitialValue::Number).collect())
    }

    /// An elaborator that sees a part's properties, with ids in their order.
    fn part_scope(&self, part: usize) -> Elaborator<'a> {
        let mut e = Elaborator::new();
        e.real = true;
        e.constants.clone_from(&self.e.constants);
        e.types.clone_from(&self.e.types);
        e.named_domains.clone_from(&self.e.named_domains);
        for (name, _, ty) in &self.parts[part].types {
            see_property(&mut e, name, ty);
        }
        e
    }

    // ---- places ------------------------------------------------------------------------------------------------------

    fn node(&mut self, item: &'a LineItem) -> Option<(&'a ast::Name, NodeKind)> {
        match item {
            LineItem::Source { name, part, supply } => {
                let part = self.find_part(part);
                let supply = match supply {
                    ast::Supply::OnOrder => Some(Supply::OnOrder),
                    ast::Supply::Every {
                        seconds,
                        random,
                        limit,
                    } => positive(&mut self.e, seconds, Dimension::Time).map(|s| Supply::Every {
                        seconds: s,
                        random: *random,
                        limit: *limit,
                    }),
                };
                Some((
                    name,
                    NodeKind::Source {
                        part: part?,
                        supply: supply?,
                    },
                ))
            }
            LineItem::Store { name, stock } => {
                let mut resolved = Vec::new();
                for counted in stock {
                    if let Some(part) = self.find_part(&counted.name) {
                        resolved.push((part, counted.count));
                    }
                }
                Some((name, NodeKind::Store { stock: resolved }))
            }
            LineItem::Sink {
                name,
                rejects,
                reorder,
            } => {
                let reorder = match reorder {
                    None => None,
                    Some(r) => Some(self.find_node(r)?),
                };
                Some((
                    name,
                    NodeKind::Sink {
                        reject: *rejects,
                        reorder,
                    },
                ))
            }
            LineItem::Buffer { name, capacity } => {
                if *capacity == 0 || *capacity > 1_000_000 {
                    self.e.error_with(
                        codes::ARGUMENT,
                        name.span,
                        format!("a buffer for {capacity} parts"),
                        "the capacity is 1 to 1000000",
                    );
                    return None;
                }
                Some((
                    name,
                    NodeKind::Buffer {
                        capacity: *capacity as u32,
                    },
                ))
            }
            LineItem::Conveyor {
                name,
                machine,
                options,
            } => self.conveyor(name, machine.as_ref(), options),
            LineItem::Station {
                name,
                machine,
                arguments,
                items,
            } => self.station(name, machine, arguments, items),
            _ => None,
        }
    }

    fn machine(
        &mut self,
        name: &ast::Name,
        arguments: &'a [ast::Argument],
    ) -> Option<Arc<Machine>> {
        let Some(decl) = self.scope.machines.get(name.text.as_str()) else {
            let known = self.scope.machines.keys().copied();
            let help = match nearest(&name.text, known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "declare it with `machine`, or import the file that does".to_owned(),
            };
            self.e.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there is no machine `{}`", name.text),
                help,
            );
            return None;
        };
        let given =
            instantiate::arguments(&mut self.e, &decl.header.parameters, arguments, &name.text);
        let before = self.e.findings.len();
        let mut found = Vec::new();
        let model = machine(
            self.scope,
            self.sources,
            decl,
            &given,
            Some(name.span),
            &mut found,
        );
        if model.is_none() {
            self.e.findings.append(&mut found);
            if self.e.findings.len() == before {
                self.e.error(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("the machine `{}` cannot be used", name.text),
                );
            }
        }
        model.map(Arc::new)
    }

    fn conveyor(
        &mut self,
        name: &'a ast::Name,
        declared: Option<&'a (ast::Name, Vec<ast::Argument>)>,
        options: &'a [(ast::Name, ast::Expr)],
    ) -> Option<(&'a ast::Name, NodeKind)> {
        let (mut places, mut pitch, mut speed, mut watts) = (None, None, None, 0.0);
        for (word, value) in options {
            match word.text.as_str() {
                "places" => places = self.e.constant_int(value).map(|n| (n, value.span)),
                "pitch" => pitch = positive(&mut self.e, value, Dimension::Length),
                "speed" => speed = positive(&mut self.e, value, Dimension::Speed),
                _ => watts = positive(&mut self.e, value, Dimension::Power).unwrap_or(0.0),
            }
        }
        let belt = match declared {
            None => None,
            Some((machine_name, arguments)) => {
                let machine = self.machine(machine_name, arguments)?;
                Some(self.belt(machine_name.span, machine)?)
            }
        };
        let count = match (&belt, places) {
            (Some(belt), Some((n, span))) if n != belt.places.len() as i64 => {
                self.e.error_with(
                    codes::ARGUMENT,
                    span,
                    format!("the contract has {} places, not {n}", belt.places.len()),
                    "leave `places` out; the contract says how many there are",
                );
                return None;
            }
            (Some(belt), _) => belt.places.len() as i64,
            (None, Some((n, span))) => {
                if !(1..=100_000).contains(&n) {
                    self.e
                        .error(codes::ARGUMENT, span, "a conveyor has 1 to 100000 places");
                    return None;
                }
                n
            }
            (None, None) => {
                self.e.error_with(
                    codes::ARGUMENT,
                    name.span,
                    "how many parts fit on this conveyor?",
                    "add `places 3`, or a contract: `conveyor belt: Belt`",
                );
                return None;
            }
        };
        let (pitch, speed) = (pitch.unwrap_or(1.0), speed.unwrap_or(1.0));
        if pitch == 0.0 || speed == 0.0 {
            self.e.error(
                codes::ARGUMENT,
                name.span,
                "pitch and speed of a conveyor are more than 0",
            );
            return None;
        }
        Some((
            name,
            NodeKind::Conveyor {
                places: count as u32,
                pitch,
                speed,
                belt,
                watts,
            },
        ))
    }

    /// The wires of a belt's machine: inputs `load` and `unload_ready`, outputs `s[i]` and `ready`.
    fn belt(&mut self, span: Span, machine: Arc<Machine>) -> Option<Belt> {
        let plant = |name: &str| machine.plant.iter().position(|p| p.name == name);
        let wires: Vec<String> = (0..machine.wire_count())
            .map(|w| machine.wire_name(w))
            .collect();
        let output = |name: &str| wires.iter().position(|w| w.ends_with(&format!(".{name}")));
        let mut places = Vec::new();
        while let Some(wire) = output(&format!("s[{}]", places.len())) {
            places.push(wire);
        }
        let moore = machine
            .components
            .iter()
            .all(|c| c.specification.timing == crate::gr1::Timing::Moore);
        match (
            plant("load"),
            plant("unload_ready"),
            output("ready"),
            places.is_empty() || !machine.operations.is_empty() || !moore,
        ) {
            (Some(load), Some(unload_ready), Some(ready), false) => Some(Belt {
                machine,
                load,
                unload_ready,
                places,
                ready,
            }),
            _ => {
                self.e.error_with(
                    codes::ARGUMENT,
                    span,
                    format!("`{}` cannot move a conveyor", machine.name),
                    "a belt's machine has the signals `load` and `unload_ready`, a `moore` action with the outputs `s: array[n] of bool` and `ready`, and no operations",
                );
                None
            }
        }
    }

    fn station(
        &mut self,
        name: &'a ast::Name,
        machine_name: &'a ast::Name,
        arguments: &'a [ast::Argument],
        items: &'a [StationItem],
    ) -> Option<(&'a ast::Name, NodeKind)> {
        let machine = self.machine(machine_name, arguments)?;
        let mut tasks: Vec<Task> = Vec::new();
        let mut defects = Vec::new();
        let mut setup_seconds = 0.0;
        let mut breakdowns = machine.failures;
        for item in items {
            match item {
                StationItem::Setup(value) => {
                    if let Some(v) = positive(&mut self.e, value, Dimension::Time) {
                        setup_seconds = v;
                    }
                }
                StationItem::Failures(a, b) => breakdowns = failures(&mut self.e, a, b),
                StationItem::Perform { operations, part } => {
                    if let Some(task) = self.task(&machine, operations, part) {
                        if tasks.iter().any(|t| t.part == task.part) {
                            self.e.error_with(
                                codes::NAME_DOUBLE,
                                part.span,
                                format!("`{}` is performed on already", part.text),
                                "name all operations in one `perform a, b on P`",
                            );
                        }
                        tasks.push(task);
                    }
                }
                StationItem::Defect {
                    part,
                    probability,
                    property,
                    value,
                } => {
                    if let Some(defect) = self.defect(part, probability, property, value) {
                        defects.push(defect);
                    }
                }
            }
        }
        if machine.operations.is_empty() {
            self.e.error_with(
                codes::OPERATION,
                machine_name.span,
                format!(
                    "`{}` has no operations, so it cannot be a station",
                    machine.name
                ),
                "a belt's machine moves a `conveyor`",
            );
            return None;
        }
        Some((
            name,
            NodeKind::Station {
                machine,
                tasks,
                defects,
                setup_seconds,
                failures: breakdowns,
            },
        ))
    }

    fn task(
        &mut self,
        machine: &Machine,
        operations: &'a [(ast::Name, Vec<ast::Argument>)],
        part: &'a ast::Name,
    ) -> Option<Task> {
        let index = self.find_part(part);
        let mut resolved = Vec::new();
        for (name, arguments) in operations {
            let Some(operation) = machine.operations.iter().position(|o| o.name == name.text)
            else {
                let known = machine.operations.iter().map(|o| o.name.as_str());
                let help = match nearest(&name.text, known.clone()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!(
                        "its operations are {}",
                        known.collect::<Vec<_>>().join(", ")
                    ),
                };
                self.e.error_with(
                    codes::OPERATION,
                    name.span,
                    format!("`{}` has no operation `{}`", machine.name, name.text),
                    help,
                );
                continue;
            };
            let mut values = Vec::new();
            for argument in arguments {
                let found = machine.properties.iter().position(|p| {
                    p.kind == PropertyKind::Parameter && p.name == argument.name.text
                });
                let Some(i) = found else {
                    self.e.error_with(
                        codes::ARGUMENT,
                        argument.name.span,
                        format!(
                            "`{}` has no parameter `{}`",
                            machine.name, argument.name.text
                        ),
                        "declare it in the machine: `parameter ...`",
                    );
                    continue;
                };
                let ty = PropertyType {
                    unit: machine.properties[i].unit.clone(),
                    domain: machine.properties[i].domain.clone(),
                    length: None,
                };
                if let Some(v) = property_values(&mut self.e, &ty, Some(&argument.value)) {
                    values.push((i, v[0]));
                }
            }
            resolved.push((operation, values));
        }
        let index = index?;
        let carried = &self.parts[index].model.properties;
        let mut mapping = Vec::new();
        let mut clashes = Vec::new();
        for p in &machine.properties {
            let found = (p.kind == PropertyKind::Part)
                .then(|| carried.iter().position(|c| c.name == p.name))
                .flatten();
            if let Some(i) = found
                && (carried[i].unit != p.unit || !same_values(&carried[i].domain, &p.domain))
            {
                clashes.push(p.name.clone());
            }
            mapping.push(found);
        }
        for name in clashes {
            self.e.error_with(
                codes::PROPERTY,
                part.span,
                format!(
                    "`{name}` of `{}` has another type than in the machine `{}`",
                    part.text, machine.name
                ),
                "declare it in both with the same unit, range or labels",
            );
        }
        Some(Task {
            part: index,
            operations: resolved,
            properties: mapping,
            span: part.span,
        })
    }

    fn defect(
        &mut self,
        part: &'a ast::Name,
        probability: &'a ast::Expr,
        property: &'a ast::Name,
        value: &'a ast::Expr,
    ) -> Option<Defect> {
        let index = self.find_part(part)?;
        let p = positive(&mut self.e, probability, Dimension::None)?;
        if p > 1.0 {
            self.e.error(
                codes::ARGUMENT,
                probability.span,
                "a probability is between 0 and 1",
            );
            return None;
        }
        let found = self.parts[index]
            .types
            .iter()
            .find(|(n, ..)| *n == property.text)
            .cloned();
        let Some((_, first, ty)) = found else {
            self.e.error(
                codes::PROPERTY,
                property.span,
                format!("`{}` has no property `{}`", part.text, property.text),
            );
            return None;
        };
        let element = PropertyType {
            length: None,
            ..ty.clone()
        };
        let mut scope = self.part_scope(index);
        see_property(&mut scope, "it", &element);
        let term = assigned(&mut scope, &element, value);
        self.e.findings.append(&mut scope.findings);
        let count = self.parts[index].model.properties.len() + 1;
        Some(Defect {
            part: index,
            probability: p,
            properties: (first..first + ty.length.unwrap_or(1)).collect(),
            value: term?.to_real(count),
            span: property.span,
        })
    }

    // ---- the rest ----------------------------------------------------------------------------------------------------

    fn product(&mut self, decl: &'a ast::Line, model: &mut Line) {
        let mut named = decl.items.iter().filter_map(|i| match i {
            LineItem::Product(name) => Some(name),
            _ => None,
        });
        let joined: Vec<usize> = (0..self.parts.len())
            .filter(|i| !self.parts[*i].model.bill.is_empty())
            .collect();
        match (named.next(), joined.as_slice()) {
            (Some(name), _) => {
                if let Some(p) = self.find_part(name) {
                    model.product = p;
                }
            }
            (None, [one]) => model.product = *one,
            (None, []) if self.parts.len() == 1 => model.product = 0,
            _ => self.e.error_with(
                codes::LINE_UNKNOWN,
                decl.name.span,
                "which part is the end product?",
                "add `product P`",
            ),
        }
        if let Some(second) = named.next() {
            self.e.error(
                codes::NAME_DOUBLE,
                second.span,
                "a line has one end product",
            );
        }
    }

    fn statement(&mut self, item: &'a LineItem, model: &mut Line) {
        match item {
            LineItem::Route { part, stops, when } => self.route(part, stops, when.as_ref(), model),
            LineItem::Shift(from, to) => {
                let a = positive(&mut self.e, from, Dimension::Time);
                let b = positive(&mut self.e, to, Dimension::Time);
                if let (Some(from_s), Some(to_s)) = (a, b) {
                    if from_s >= to_s || to_s > 86_400.0 {
                        self.e.error_with(
                            codes::ARGUMENT,
                            from.span.to(to.span),
                            "a shift begins before it ends, within one day",
                            "write `shift 6 h to 14 h`",
                        );
                    }
                    model.shift = Some(Shift {
                        from: from_s,
                        to: to_s,
                    });
                }
            }
            LineItem::Limit(value, true) => {
                if let Some(n) = self.e.constant_int(value) {
                    if n < 1 {
                        self.e
                            .error(codes::ARGUMENT, value.span, "at least one product");
                    }
                    model.limit = Some(Limit::Products(n.max(1) as u64));
                }
            }
            LineItem::Limit(value, false) => {
                if let Some(s) = positive(&mut self.e, value, Dimension::Time) {
                    model.limit = Some(Limit::Seconds(s));
                }
            }
            LineItem::Requirement {
                name,
                metric,
                of,
                op,
                bound,
                per_hour,
                span,
            } => {
                let Some((metric, dimension, factor)) = self.metric(metric, of.as_ref()) else {
                    return;
                };
                if *per_hour != (metric == Metric::ThroughputPerHour) {
                    self.e.error_with(
                        codes::TYPE_MISMATCH,
                        *span,
                        if *per_hour {
                            "`per hour` belongs to `throughput`"
                        } else {
                            "the throughput of what time?"
                        },
                        "write `throughput >= 20 per hour`",
                    );
                }
                let comparison = match op {
                    ast::BinaryOp::Lt => Comparison::Lt,
                    ast::BinaryOp::Le => Comparison::Le,
                    ast::BinaryOp::Eq => Comparison::Eq,
                    ast::BinaryOp::Ge => Comparison::Ge,
                    ast::BinaryOp::Gt => Comparison::Gt,
                    _ => {
                        self.e.error(
                            codes::TYPE_MISMATCH,
                            *span,
                            "a requirement compares with <, <=, =, >= or >",
                        );
                        return;
                    }
                };
                if let Some(value) = self.e.constant_quantity(bound, dimension) {
                    model.requirements.push(Requirement {
                        name: name.text.clone(),
                        metric,
                        comparison,
                        bound: value / factor,
                        span: *span,
                    });
                }
            }
            _ => {}
        }
    }

    fn metric(
        &mut self,
        name: &ast::Name,
        of: Option<&ast::Name>,
    ) -> Option<(Metric, Dimension, f64)> {
        const NAMES: [&str; 8] = [
            "throughput",
            "makespan",
            "lead_time",
            "energy",
            "rejected",
            "products",
            "violations",
            "busy",
        ];
        Some(match (name.text.as_str(), of) {
            ("throughput", None) => (Metric::ThroughputPerHour, Dimension::None, 1.0),
            ("makespan", None) => (Metric::MakespanSeconds, Dimension::Time, 1.0),
            ("lead_time", None) => (Metric::LeadTimeMeanSeconds, Dimension::Time, 1.0),
            ("energy", None) => (Metric::EnergyKwh, Dimension::Energy, 3.6e6),
            ("rejected", None) => (Metric::Rejected, Dimension::None, 1.0),
            ("products", None) => (Metric::Products, Dimension::None, 1.0),
            ("violations", None) => (Metric::Violations, Dimension::None, 1.0),
            ("busy", Some(station)) => {
                (Metric::Busy(self.find_node(station)?), Dimension::None, 1.0)
            }
            (other, _) => {
                let help = match nearest(other, NAMES.into_iter()) {
                    Some("busy") => "write `busy(station)`".to_owned(),
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("the measures are {}(station)", NAMES.join(", ")),
                };
                self.e.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("`{other}` is not measured"),
                    help,
                );
                return None;
            }
        })
    }

    fn route(
        &mut self,
        part: &'a ast::Name,
        stops: &'a [ast::Name],
        when: Option<&'a ast::Expr>,
        model: &mut Line,
    ) {
        let index = self.find_part(part);
        let nodes: Vec<Option<usize>> = stops.iter().map(|s| self.find_node(s)).collect();
        let Some(index) = index else { return };
        let condition = when.and_then(|c| {
            let mut scope = self.part_scope(index);
            let term = scope.boolean(c, Time::Now);
            self.e.findings.append(&mut scope.findings);
            Some(term?.to_real(self.parts[index].model.properties.len()))
        });
        for (i, pair) in nodes.windows(2).enumerate() {
            let (Some(from), Some(to)) = (pair[0], pair[1]) else {
                continue;
            };
            model.routes.push(Route {
                part: index,
                from,
                to,
                condition: if i == 0 { condition.clone() } else { None },
                span: stops[i].span.to(stops[i + 1].span),
            });
        }
    }
}

fn is_node(item: &LineItem) -> bool {
    matches!(
        item,
        LineItem::Source { .. }
            | LineItem::Store { .. }
            | LineItem::Sink { .. }
            | LineItem::Buffer { .. }
            | LineItem::Conveyor { .. }
            | LineItem::Station { .. }
    )
}

/// Whether two properties have the same values; the name of an enumeration does not matter.
fn same_values(a: &Option<crate::gr1::Domain>, b: &Option<crate::gr1::Domain>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => a.describe() == b.describe(),
        _ => false,
    }
}
