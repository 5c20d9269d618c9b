//! Resolution of places: sources, stores, sinks, buffers, conveyors and stations.

use super::Builder;
use crate::contract::elaborate::nearest;
use crate::contract::instantiate;
use crate::contract::line::{Belt, Defect, NodeKind, Supply, Task};
use crate::contract::machine::{Machine, PropertyKind, RealExpr};
use crate::contract::machines::{
    PropertyType, assigned, declare_property, failures, machine, non_negative, property_values,
};
use crate::contract::scope::{duplicate_name, duplicate_statement};
use crate::contract::value::{Dimension, Value};
use crate::contract::{MAX_SECONDS, MIN_SECONDS, is_duration};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::gr1::Domain;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, LineItem, StationItem};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

impl<'a> Builder<'a, '_> {
    /// Resolves a place; `None` if the item is not a place or has an error.
    pub(super) fn node(&mut self, item: &'a LineItem) -> Option<(&'a ast::Name, NodeKind)> {
        match item {
            LineItem::Source {
                name,
                part,
                supply,
                most,
            } => {
                let part = self.find_part(part);
                let most = match *most {
                    None => None,
                    Some(count @ 1..=1_000_000) => Some(count as u32),
                    Some(count) => {
                        self.e.findings.error_with(
                            codes::ARGUMENT,
                            name.span,
                            format!("the limit of {count} parts in the line is not allowed"),
                            "write a number from 1 to 1000000",
                        );
                        return None;
                    }
                };
                let supply = match supply {
                    ast::Supply::OnOrder => Some(Supply::OnOrder),
                    ast::Supply::Every {
                        seconds,
                        random,
                        limit,
                    } => {
                        non_negative(&mut self.e, seconds, Dimension::Time).map(|s| Supply::Every {
                            seconds: s,
                            random: *random,
                            limit: *limit,
                        })
                    }
                };
                Some((
                    name,
                    NodeKind::Source {
                        part: part?,
                        supply: supply?,
                        most,
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
                    Some(r) => {
                        let node = self.find_node(r)?;
                        if !self.sources_of_parts.contains(&node) {
                            self.e.findings.error_with(
                                codes::LINE_UNKNOWN,
                                r.span,
                                format!("`{}` is not a source", r.text),
                                "name a `source` after `reorder`",
                            );
                            return None;
                        }
                        if !rejects {
                            self.e.findings.push(
                                Diagnostic::warning(
                                    codes::UNUSED,
                                    r.span,
                                    format!(
                                        "`reorder` has no effect: the sink `{}` does not take rejects",
                                        name.text
                                    ),
                                )
                                .with_help(format!(
                                    "write `sink {} rejects reorder {}`, or remove `reorder`",
                                    name.text, r.text
                                )),
                            );
                        }
                        Some(node)
                    }
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
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        name.span,
                        format!("a buffer cannot have the capacity {capacity}"),
                        "write a capacity from 1 to 1000000",
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

    /// Returns the instance of a machine with these arguments, which all stations with the same
    /// arguments share.
    pub(super) fn machine(
        &mut self,
        name: &ast::Name,
        arguments: &'a [ast::Argument],
    ) -> Option<Arc<Machine>> {
        let Some(decl) = self.scope.machines.get(name.text.as_str()) else {
            let known = self.scope.machines.keys().copied();
            let help = match nearest(&name.text, known) {
                _ if self.scope.contracts.contains_key(name.text.as_str()) => format!(
                    "`{0}` is a contract; declare a machine with an action of this contract: `action work: {0}`",
                    name.text
                ),
                Some(near) => format!("did you mean `{near}`?"),
                None => "declare it with `machine`, or import the file that declares it".to_owned(),
            };
            self.e.findings.error_with(
                codes::NAME_UNKNOWN,
                name.span,
                format!("there is no machine `{}`", name.text),
                help,
            );
            return None;
        };
        let given = instantiate::machine_arguments(&mut self.e, decl, arguments);
        let key = (name.text.clone(), format!("{:?}", values_of(&given)));
        if let Some(machine) = self.machines.get(&key) {
            return Some(Arc::clone(machine));
        }
        let before = self.e.findings.list.len();
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
            self.e.findings.tainted = true;
            self.e.findings.list.append(&mut found);
            // If there are no arguments, the error is in the machine itself and was reported at its
            // declaration.
            if self.e.findings.list.len() == before && !arguments.is_empty() {
                self.e.findings.error_with(
                    codes::NAME_UNKNOWN,
                    name.span,
                    format!("the machine `{}` cannot be used", name.text),
                    format!("correct the errors in `{}`", name.text),
                );
            }
        }
        let model = Arc::new(model?);
        self.machines.insert(key, Arc::clone(&model));
        Some(model)
    }

    pub(super) fn conveyor(
        &mut self,
        name: &'a ast::Name,
        declared: Option<&'a (ast::Name, Vec<ast::Argument>)>,
        options: &'a [(ast::Name, ast::Expr)],
    ) -> Option<(&'a ast::Name, NodeKind)> {
        let (mut places, mut pitch, mut speed, mut watts) = (None, None, None, 0.0);
        let mut once: BTreeMap<&str, Span> = BTreeMap::new();
        for (word, value) in options {
            self.once(&mut once, &word.text, word.span);
            match word.text.as_str() {
                "places" => places = self.e.constant_int(value).map(|n| (n, value.span)),
                "pitch" => pitch = non_negative(&mut self.e, value, Dimension::Length),
                "speed" => speed = non_negative(&mut self.e, value, Dimension::Speed),
                _ => watts = non_negative(&mut self.e, value, Dimension::Power).unwrap_or(0.0),
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
                self.e.findings.error_with(
                    codes::ARGUMENT,
                    span,
                    format!("the contract has {} places, not {n}", belt.places.len()),
                    "remove `places`: the contract determines the number",
                );
                return None;
            }
            (Some(belt), _) => belt.places.len() as i64,
            (None, Some((n, span))) => {
                if !(1..=100_000).contains(&n) {
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        span,
                        "a conveyor must have 1 to 100000 places",
                        "write the number of parts that fit on it: `places 3`",
                    );
                    return None;
                }
                n
            }
            (None, None) => {
                self.e.findings.error_with(
                    codes::ARGUMENT,
                    name.span,
                    "this conveyor has no number of places",
                    "add `places N`, where N is its length divided by the distance between two parts, or add a machine: `conveyor belt: Belt`",
                );
                return None;
            }
        };
        let (pitch, speed) = (pitch.unwrap_or(1.0), speed.unwrap_or(1.0));
        if pitch == 0.0 || speed == 0.0 {
            self.e.findings.error_with(
                codes::ARGUMENT,
                name.span,
                "the pitch and the speed of a conveyor must be greater than 0",
                "write both with their unit: `pitch 0.5 m speed 0.25 m/s`",
            );
            return None;
        }
        let period = pitch / speed;
        if period == 0.0 || !is_duration(period) {
            self.e.findings.error_with(
                codes::ARGUMENT,
                name.span,
                format!("a part takes {period:e} s from place to place, which is not a valid duration"),
                format!(
                    "choose pitch and speed so that pitch/speed is between {MIN_SECONDS:e} s and {MAX_SECONDS:e} s"
                ),
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

    /// Reports a second occurrence of a statement that is allowed only once.
    fn once<'w>(&mut self, seen: &mut BTreeMap<&'w str, Span>, word: &'w str, span: Span) {
        if let Some(first) = seen.insert(word, span) {
            let finding = duplicate_statement(word, span, first, "remove one of the two");
            self.e.findings.push(finding);
        }
    }

    /// Finds the wires by which a machine controls a conveyor: inputs `load` and `unload_ready`,
    /// outputs `s[i]` and `ready`. Reports a machine without these wires, with operations, or with
    /// a component that is not a Moore machine.
    pub(super) fn belt(&mut self, span: Span, machine: Arc<Machine>) -> Option<Belt> {
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
            .all(|c| c.specification.timing == linewright_core::gr1::Timing::Moore);
        if let (Some(load), Some(unload_ready), Some(ready), false) = (
            plant("load"),
            plant("unload_ready"),
            output("ready"),
            places.is_empty() || !machine.operations.is_empty() || !moore,
        ) {
            self.warn_without_effect(span, &machine);
            Some(Belt {
                machine,
                load,
                unload_ready,
                places,
                ready,
            })
        } else {
            self.e.findings.error_with(
                codes::ARGUMENT,
                span,
                format!("`{}` cannot control a conveyor", machine.name),
                "use a machine with the signals `load` and `unload_ready`, and a `moore` action with the outputs `s: array[n] of bool` and `ready`, but without operations",
            );
            None
        }
    }

    /// Warns about times, powers and failures of a machine that controls a conveyor, because they
    /// have an effect only in stations.
    fn warn_without_effect(&mut self, span: Span, machine: &Machine) {
        let components = &machine.components;
        let is_zero = |watts: &RealExpr| *watts == RealExpr::Number(0.0);
        let statements = [
            ("failures", machine.failures.is_some()),
            (
                "power",
                machine.base_watts != 0.0 || components.iter().any(|c| !is_zero(&c.watts)),
            ),
            ("time", components.iter().any(|c| c.time.is_some())),
        ];
        for (word, _) in statements.iter().filter(|(_, is_there)| *is_there) {
            self.e.findings.push(
                Diagnostic::warning(
                    codes::UNUSED,
                    span,
                    format!("`{word}` of the machine `{}` has no effect on a conveyor", machine.name),
                )
                .with_help(
                    "a conveyor advances one place every pitch/speed seconds, draws its `power`, and does not fail",
                ),
            );
        }
    }

    pub(super) fn station(
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
        let mut once: BTreeMap<&str, Span> = BTreeMap::new();
        for item in items {
            match item {
                StationItem::Setup(value) => self.once(&mut once, "setup", value.span),
                StationItem::Failures(mtbf, mttr) => {
                    self.once(&mut once, "failures", mtbf.span.to(mttr.span));
                }
                StationItem::Perform { .. } | StationItem::Defect { .. } => {}
            }
            match item {
                StationItem::Setup(value) => {
                    if let Some(v) = non_negative(&mut self.e, value, Dimension::Time) {
                        setup_seconds = v;
                    }
                }
                StationItem::Failures(a, b) => breakdowns = failures(&mut self.e, a, b),
                StationItem::Perform { operations, part } => {
                    if let Some(task) = self.task(&machine, operations, part) {
                        if tasks.iter().any(|t| t.part == task.part) {
                            self.e.findings.error_with(
                                codes::NAME_DUPLICATE,
                                part.span,
                                format!("operations on `{}` are already declared", part.text),
                                "list all operations in one `perform a, b on P`",
                            );
                        }
                        tasks.push(task);
                    }
                }
                StationItem::Defect {
                    part,
                    probability,
                    one_of,
                    property,
                    value,
                } => {
                    if let Some(defect) = self.defect(part, probability, *one_of, property, value) {
                        defects.push(defect);
                    }
                }
            }
        }
        if machine.operations.is_empty() {
            self.e.findings.error_with(
                codes::OPERATION,
                machine_name.span,
                format!(
                    "`{}` has no operations, so it cannot be a station",
                    machine.name
                ),
                "use a machine with operations; one without operations can control a `conveyor`",
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

    /// Resolves the operations of a station on a part type.
    pub(super) fn task(
        &mut self,
        machine: &Machine,
        operations: &'a [ast::OperationCall],
        part: &'a ast::Name,
    ) -> Option<Task> {
        let index = self.find_part(part);
        let mut resolved = Vec::new();
        for ast::OperationCall { name, arguments } in operations {
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
                self.e.findings.error_with(
                    codes::OPERATION,
                    name.span,
                    format!("`{}` has no operation `{}`", machine.name, name.text),
                    help,
                );
                continue;
            };
            let mut values = Vec::new();
            for (i, argument) in arguments.iter().enumerate() {
                let mut earlier = arguments[..i].iter().map(|a| &a.name);
                if let Some(first) = earlier.find(|n| n.text == argument.name.text) {
                    self.e
                        .findings
                        .push(duplicate_name(&argument.name, first.span));
                    continue;
                }
                let found = machine.properties.iter().position(|p| {
                    p.kind == PropertyKind::Parameter && p.name == argument.name.text
                });
                let Some(i) = found else {
                    let is_array = machine.properties.iter().any(|p| {
                        p.kind == PropertyKind::Parameter
                            && p.name != array_of(&p.name)
                            && array_of(&p.name) == argument.name.text
                    });
                    let (message, help) = if is_array {
                        (
                            format!(
                                "the parameter `{}` is an array, which a station cannot set",
                                argument.name.text
                            ),
                            "declare one parameter for each element that a station sets",
                        )
                    } else {
                        (
                            format!(
                                "`{}` has no parameter `{}`",
                                machine.name, argument.name.text
                            ),
                            "declare it in the machine: `parameter ...`",
                        )
                    };
                    self.e
                        .findings
                        .error_with(codes::ARGUMENT, argument.name.span, message, help);
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
                && (carried[i].unit != p.unit
                    || !same_values(carried[i].domain.as_ref(), p.domain.as_ref()))
            {
                clashes.push(p.name.clone());
            }
            mapping.push(found);
        }
        // Two arrays of different lengths, or an array and a scalar, would have only some elements
        // in common. Their types clash, too.
        let elements = |names: &mut dyn Iterator<Item = &str>, array: &str| -> BTreeSet<String> {
            let own = names.filter(|name| array_of(name) == array);
            own.map(str::to_owned).collect()
        };
        for p in &machine.properties {
            let array = array_of(&p.name);
            if p.kind != PropertyKind::Part || clashes.iter().any(|c| array_of(c) == array) {
                continue;
            }
            let in_part = elements(&mut carried.iter().map(|c| c.name.as_str()), array);
            let in_machine = elements(
                &mut machine.properties.iter().map(|p| p.name.as_str()),
                array,
            );
            if !in_part.is_empty() && in_part != in_machine {
                clashes.push(array.to_owned());
            }
        }
        for name in clashes {
            self.e.findings.error_with(
                codes::PROPERTY,
                part.span,
                format!(
                    "`{name}` of `{}` and of the machine `{}` have different types",
                    part.text, machine.name
                ),
                "declare it in both with the same unit, range or labels, and the same length",
            );
        }
        Some(Task {
            part: index,
            operations: resolved,
            properties: mapping,
            span: part.span,
        })
    }

    pub(super) fn defect(
        &mut self,
        part: &'a ast::Name,
        probability: &'a ast::Expr,
        one_of: bool,
        property: &'a ast::Name,
        value: &'a ast::Expr,
    ) -> Option<Defect> {
        let index = self.find_part(part)?;
        let p = non_negative(&mut self.e, probability, Dimension::None)?;
        if p > 1.0 {
            self.e.findings.error_with(
                codes::ARGUMENT,
                probability.span,
                "a probability must be between 0 and 1",
                "write a percentage or a fraction: `probability 5 %`, or `probability 0.05`",
            );
            return None;
        }
        let found = self.parts[index]
            .types
            .iter()
            .find(|(n, ..)| *n == property.text)
            .cloned();
        let Some((_, first, ty)) = found else {
            self.e.findings.error_with(
                codes::PROPERTY,
                property.span,
                format!("`{}` has no property `{}`", part.text, property.text),
                format!(
                    "declare it: `part {} {{ property {}: ... }}`",
                    part.text, property.text
                ),
            );
            return None;
        };
        if one_of && ty.length.is_none() {
            self.e.findings.error_with(
                codes::TYPE_MISMATCH,
                property.span,
                format!("`{}` is not an array", property.text),
                "remove `one of`, which selects an element of an array",
            );
        }
        let element = PropertyType {
            length: None,
            ..ty.clone()
        };
        let mut scope = self.part_scope(index);
        declare_property(&mut scope, "it", &element);
        let term = assigned(&mut scope, &element, value);
        self.e.findings.absorb(&mut scope.findings);
        let count = self.parts[index].model.properties.len() + 1;
        Some(Defect {
            part: index,
            probability: p,
            properties: (first..first + ty.length.unwrap_or(1)).collect(),
            value: term?.to_real(count),
            span: property.span,
        })
    }
}

/// Returns arguments without their positions.
fn values_of(given: &instantiate::Arguments) -> Vec<(&String, &Value)> {
    given.iter().map(|(n, (v, _))| (n, v)).collect()
}

/// Returns whether two properties have the same domain, regardless of the name of an enumeration.
fn same_values(a: Option<&Domain>, b: Option<&Domain>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => a.describe() == b.describe(),
        _ => false,
    }
}

/// Returns the name of the array that contains a property, or the name itself for a scalar.
fn array_of(property: &str) -> &str {
    property.split('[').next().unwrap_or(property)
}
