//! Resolution of stations: their work, the values that they set, and their defects.

use super::Builder;
use crate::contract::elaborate::nearest;
use crate::contract::line::{Defect, Line, NodeKind, Setting, Station, Task};
use crate::contract::machine::{Machine, PropertyKind};
use crate::contract::machines::{
    PropertyType, assigned, assignments, check_written_once, declare_property, duration, failures,
    non_negative, property_values,
};
use crate::contract::scope::duplicate_name;
use crate::contract::value::Dimension;
use linewright_core::diagnostics::codes;
use linewright_core::gr1::Domain;
use linewright_core::source::Span;
use linewright_syntax::ast::{self, StationItem};
use std::collections::{BTreeMap, BTreeSet};

impl<'a> Builder<'a, '_> {
    pub(super) fn station(
        &mut self,
        name: &'a ast::Name,
        machine: Option<&'a (ast::Name, Vec<ast::Argument>)>,
        items: &'a [StationItem],
    ) -> Option<(&'a ast::Name, NodeKind)> {
        let machine = match machine {
            None => None,
            Some((machine, arguments)) => Some((machine.span, self.machine(machine, arguments)?)),
        };
        let mut station = Station::default();
        self.report_repeated(items);
        let mut modes: Vec<&'a ast::Failures> = Vec::new();
        let mut shifts: Vec<&'a ast::Shift> = Vec::new();
        // By part type: the properties that are set.
        let mut set: BTreeMap<usize, BTreeMap<usize, Span>> = BTreeMap::new();
        for item in items {
            match item {
                StationItem::Setup(value) => {
                    if let Some(setup) = duration(&mut self.e, value) {
                        station.setup = setup;
                    }
                }
                StationItem::Failures(mode) => modes.push(mode),
                StationItem::Shift(shift) => shifts.push(shift),
                StationItem::Perform { operations, part } => match &machine {
                    Some((_, machine)) => {
                        let task = self.task(machine, operations, part);
                        self.add_task(&mut station, task, &part.text);
                    }
                    None => self.e.findings.error_with(
                        codes::OPERATION,
                        part.span,
                        format!("`{}` has no machine that could perform this", name.text),
                        format!(
                            "name the machine, `station {}: Machine {{ ... }}`, or write how long the work takes: `takes 2 s`",
                            name.text
                        ),
                    ),
                },
                StationItem::Takes { duration, part } => {
                    if machine.is_some() {
                        self.refuse_with_machine(
                            duration.span(),
                            "takes",
                            "the time of its actions: `time 2 s`",
                        );
                    } else {
                        self.takes(name, &mut station, duration, part.as_ref());
                    }
                }
                StationItem::Power(value) | StationItem::IdlePower(value) => {
                    let (word, watts) = match item {
                        StationItem::Power(_) => ("power", &mut station.watts),
                        _ => ("idle power", &mut station.idle_watts),
                    };
                    if machine.is_some() {
                        self.refuse_with_machine(value.span, word, &format!("its `{word}`"));
                    } else if let Some(v) = non_negative(&mut self.e, value, Dimension::Power) {
                        *watts = v;
                    }
                }
                StationItem::Sets {
                    property,
                    index,
                    value,
                    part,
                } => {
                    let settings = self.settings(property, index.as_ref(), value, part.as_ref());
                    for setting in &settings {
                        let set = set.entry(setting.part).or_default();
                        let written = [setting.property];
                        check_written_once(&mut self.e.findings, property, written, set);
                    }
                    station.settings.extend(settings);
                }
                StationItem::Defect {
                    part,
                    probability,
                    one_of,
                    property,
                    value,
                } => {
                    let defect = self.defect(part, probability, *one_of, property, value);
                    station.defects.extend(defect);
                }
            }
        }
        station.failures = failures(&mut self.e, &modes);
        station.calendar = self.calendar(&shifts);
        match machine {
            Some((span, machine)) => {
                if machine.operations.is_empty() {
                    self.e.findings.error_with(
                        codes::OPERATION,
                        span,
                        format!(
                            "`{}` has no operations, so it cannot be a station",
                            machine.name
                        ),
                        "use a machine with operations; one without operations can control a `conveyor`",
                    );
                    return None;
                }
                if modes.is_empty() {
                    station.failures.clone_from(&machine.failures);
                }
                station.idle_watts = machine.idle_watts;
                station.machine = Some(machine);
            }
            None if !items.iter().any(|i| matches!(i, StationItem::Takes { .. })) => {
                self.e.findings.error_about(
                    codes::OPERATION,
                    name,
                    "has neither a machine nor a time",
                    format!(
                        "write how long its work takes, `station {0} {{ takes 2 s }}`, or name its machine, `station {0}: Machine {{ ... }}`",
                        name.text
                    ),
                );
                return None;
            }
            None => {}
        }
        Some((name, NodeKind::Station(Box::new(station))))
    }

    /// Reports second occurrences of statements that a station can have only once.
    fn report_repeated(&mut self, items: &'a [StationItem]) {
        let mut once: BTreeMap<&str, Span> = BTreeMap::new();
        for item in items {
            match item {
                StationItem::Setup(value) => self.once(&mut once, "setup", value.span()),
                StationItem::Power(value) => self.once(&mut once, "power", value.span),
                StationItem::IdlePower(value) => self.once(&mut once, "idle power", value.span),
                StationItem::Takes {
                    duration,
                    part: None,
                } => self.once(&mut once, "takes", duration.span()),
                _ => {}
            }
        }
    }

    /// Reports a statement that a station with a machine cannot have.
    fn refuse_with_machine(&mut self, span: Span, word: &str, instead: &str) {
        self.e.findings.error_with(
            codes::OPERATION,
            span,
            format!("a station with a machine has no `{word}`"),
            format!("write it in the machine, as {instead}; or remove the machine"),
        );
    }

    fn add_task(&mut self, station: &mut Station, task: Option<Task>, part: &str) {
        let Some(task) = task else { return };
        if station.tasks.iter().any(|t| t.part == task.part) {
            self.e.findings.error_with(
                codes::NAME_DUPLICATE,
                task.span,
                format!("the work on `{part}` is already declared"),
                "list all operations in one `perform a, b on P`, or keep one `takes`",
            );
        }
        station.tasks.push(task);
    }

    /// Resolves `takes d a P`. Without a part type, the tasks are added once the routes are known.
    fn takes(
        &mut self,
        name: &ast::Name,
        station: &mut Station,
        written: &'a ast::TimeValue,
        part: Option<&'a ast::Name>,
    ) {
        let time = duration(&mut self.e, written);
        match part {
            Some(part) => {
                let task = self.find_part(part).zip(time).map(|(index, time)| Task {
                    part: index,
                    operations: Vec::new(),
                    properties: Vec::new(),
                    time: Some(time),
                    span: part.span,
                });
                self.add_task(station, task, &part.text);
            }
            None => {
                if let (Some(time), Some(node)) = (time, self.node_index.get(&name.text)) {
                    self.common_times.insert(*node, (time, written.span()));
                }
            }
        }
    }

    /// Adds the tasks of stations with `takes d` for parts of any type: all types that leave the
    /// station, and those that come and are not joined to them.
    pub(super) fn add_common_times(&self, model: &mut Line) {
        for (&node, (time, span)) in &self.common_times {
            let leaves = |part: usize| {
                let mut routes = model.routes.iter();
                routes.any(|route| route.from == node && route.part == part)
            };
            let NodeKind::Station(station) = &model.nodes[node].kind else {
                continue;
            };
            let mut parts: Vec<usize> = station.tasks.iter().map(|task| task.part).collect();
            let declared = parts.len();
            let all = 0..self.parts.len();
            let others = all.clone().filter(|p| leaves(*p) && !parts.contains(p));
            let others: Vec<usize> = others.collect();
            parts.extend(others);
            let is_joined = |part: usize| {
                let mut bills = parts.iter().map(|p| &self.parts[*p].model.bill);
                bills.any(|bill| bill.iter().any(|(component, _)| *component == part))
            };
            let comes = |part: usize| model.is_brought(node, part);
            let kept = all.filter(|p| comes(*p) && !parts.contains(p) && !is_joined(*p));
            let kept: Vec<usize> = kept.collect();
            parts.extend(kept);
            let tasks = parts[declared..].iter().map(|part| Task {
                part: *part,
                operations: Vec::new(),
                properties: Vec::new(),
                time: Some(time.clone()),
                span: *span,
            });
            let tasks: Vec<Task> = tasks.collect();
            if let NodeKind::Station(station) = &mut model.nodes[node].kind {
                station.tasks.extend(tasks);
            }
        }
    }

    /// Resolves `sets x[i] = e on P`. Without a part type, the property is set in all types that
    /// have it.
    fn settings(
        &mut self,
        property: &'a ast::Name,
        index: Option<&'a ast::Expr>,
        value: &'a ast::Expr,
        part: Option<&'a ast::Name>,
    ) -> Vec<Setting> {
        let parts: Vec<usize> = match part {
            Some(part) => self.find_part(part).into_iter().collect(),
            None => (0..self.parts.len()).collect(),
        };
        let mut settings = Vec::new();
        let mut is_known = parts.is_empty();
        for part in parts {
            let declared = &self.parts[part].types;
            let found = declared.iter().find(|(n, ..)| *n == property.text).cloned();
            let Some((_, first, ty)) = found else {
                continue;
            };
            is_known = true;
            let mut scope = self.part_scope(part);
            let place = (property, first, &ty);
            let terms = assignments(&mut self.e, &mut scope, place, index, value);
            self.e.findings.absorb(&mut scope.findings);
            let count = self.parts[part].model.properties.len();
            settings.extend(terms.into_iter().map(|(property, term)| Setting {
                part,
                property,
                value: term.to_real(count),
                span: value.span,
            }));
        }
        if !is_known {
            let who = match part {
                Some(part) => format!("`{}` has no", part.text),
                None => "no part has a".to_owned(),
            };
            self.e.findings.error_with(
                codes::PROPERTY,
                property.span,
                format!("{who} property `{}`", property.text),
                "declare it: `part P { property v: ... }`",
            );
        }
        settings
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
            time: None,
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
        let p = self.e.constant_quantity(probability, Dimension::None)?;
        if !(0.0..=1.0).contains(&p) {
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
            self.e.findings.error_about(
                codes::TYPE_MISMATCH,
                property,
                "is not an array",
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
