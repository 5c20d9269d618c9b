//! Resolution of places: sources, stores, sinks, buffers, conveyors and stations.

use super::Builder;
use crate::contract::distribution::Distribution;
use crate::contract::elaborate::nearest;
use crate::contract::instantiate;
use crate::contract::line::{Belt, NodeKind, Supply};
use crate::contract::machine::{Machine, RealExpr};
use crate::contract::machines::{duration, machine, non_negative, random_duration};
use crate::contract::metric::PlaceKind;
use crate::contract::scope::duplicate_statement;
use crate::contract::table;
use crate::contract::value::{Dimension, Value};
use crate::contract::{MAX_SECONDS, MIN_SECONDS, is_duration};
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_syntax::ast::{self, LineItem};
use std::collections::BTreeMap;
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
                    ast::Supply::At(column) => {
                        table::instants(&mut self.e, column).map(|instants| Supply::At { instants })
                    }
                    ast::Supply::Every {
                        interval,
                        random,
                        limit,
                    } => self
                        .interval(interval, *random)
                        .map(|interval| Supply::Every {
                            interval,
                            limit: *limit,
                        }),
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
                        if self.kinds.get(&node) != Some(&PlaceKind::Source) {
                            self.e.findings.error_about(
                                codes::LINE_UNKNOWN,
                                r,
                                "is not a source",
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
            LineItem::Buffer {
                name,
                capacity,
                order,
                dwell,
                shelf_life,
            } => {
                if *capacity == 0 || *capacity > 1_000_000 {
                    self.e.findings.error_with(
                        codes::ARGUMENT,
                        name.span,
                        format!("a buffer cannot have the capacity {capacity}"),
                        "write a capacity from 1 to 1000000",
                    );
                    return None;
                }
                let dwell = match dwell {
                    None => Some(Distribution::default()),
                    Some(dwell) => duration(&mut self.e, dwell),
                };
                let shelf_life = match shelf_life {
                    None => Some(None),
                    Some(life) => self.shelf_life(life, dwell.as_ref()).map(Some),
                };
                Some((
                    name,
                    NodeKind::Buffer {
                        capacity: *capacity as u32,
                        order: self.buffer_order(order.as_ref()),
                        dwell: dwell?,
                        shelf_life: shelf_life?,
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
                times,
                items,
            } => {
                if let Some(times) = times {
                    self.copies(name, *times);
                }
                self.station(name, machine.as_ref(), items)
            }
            _ => None,
        }
    }

    /// Resolves the time between two parts of a source. `random` means that it is exponentially
    /// distributed with this mean.
    fn interval(&mut self, written: &'a ast::TimeValue, random: bool) -> Option<Distribution> {
        match written {
            ast::TimeValue::Value(_) if random => random_duration(&mut self.e, written),
            ast::TimeValue::Drawn { span, .. } | ast::TimeValue::Empirical { span, .. }
                if random =>
            {
                self.e.findings.error_with(
                    codes::ARGUMENT,
                    *span,
                    "`random` is followed by the mean of an exponential distribution",
                    "remove `random`, since a distribution is given",
                );
                None
            }
            _ => duration(&mut self.e, written),
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
        let variant = self.scope.variants.and_then(|v| v.get(&name.span));
        let decl = variant.unwrap_or(decl);
        let given = instantiate::machine_arguments(&mut self.e, decl, arguments);
        let key = (
            name.text.clone(),
            format!("{:?}", values_of(&given)),
            variant.map(|_| name.span),
        );
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
    pub(super) fn once<'w>(
        &mut self,
        seen: &mut BTreeMap<&'w str, Span>,
        word: &'w str,
        span: Span,
    ) {
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
            ("failures", !machine.failures.is_empty()),
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
}

/// Returns arguments without their positions.
fn values_of(given: &instantiate::Arguments) -> Vec<(&String, &Value)> {
    given.iter().map(|(n, (v, _))| (n, v)).collect()
}
