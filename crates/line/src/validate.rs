//! Checks the conditions that a line must satisfy before it runs, so that no index in the runner
//! can be out of range.
//!
//! The resolver reports most of this earlier and with better messages; a line that it accepts gets
//! no findings here.

use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_core::source::Span;
use linewright_language::contract::calendar::WorkCalendar;
use linewright_language::contract::distribution::Distribution;
use linewright_language::contract::line::{
    Belt, BufferOrder, Choice, InitialValue, Line, Node, NodeKind, Route, Supply, Task,
};
use linewright_language::contract::machine::{Between, Machine, RealExpr};
use linewright_language::contract::{MAX_SECONDS, is_duration};

/// Returns everything that prevents the runner from running this line. `has_controller` states
/// whether a node has a controller.
pub(super) fn validate(line: &Line, has_controller: impl Fn(usize) -> bool) -> Vec<Diagnostic> {
    let mut check = Check {
        line,
        findings: Vec::new(),
    };
    check.parts();
    for (index, node) in line.nodes.iter().enumerate() {
        check.node(node, has_controller(index));
    }
    check.routes();
    check.findings
}

struct Check<'a> {
    line: &'a Line,
    findings: Vec<Diagnostic>,
}

impl Check<'_> {
    fn refuse(&mut self, span: Span, message: String) {
        let finding = Diagnostic::error(codes::LINE_UNKNOWN, span, message);
        self.findings
            .push(finding.with_help("`linewright explain LW401` shows the declarations of a line"));
    }

    fn require(&mut self, holds: bool, span: Span, message: impl FnOnce() -> String) {
        if !holds {
            self.refuse(span, message());
        }
    }

    fn is_part(&self, part: usize) -> bool {
        part < self.line.parts.len()
    }

    fn parts(&mut self) {
        let line = self.line;
        let products = &line.products;
        let known = !products.is_empty() && products.iter().all(|part| self.is_part(*part));
        self.require(known, line.span, || {
            "an end product of the line is not one of its part types".to_owned()
        });
        let calendar = line.calendar.as_ref();
        self.require(
            calendar.is_none_or(WorkCalendar::is_valid),
            line.span,
            || format!("the calendar of {} is not valid", line.name),
        );
        for part in &line.parts {
            let bill = part
                .bill
                .iter()
                .all(|&(component, count)| self.is_part(component) && count > 0);
            self.require(bill, part.span, || {
                format!(
                    "the bill of {} names an unknown part type, or a count of 0",
                    part.name
                )
            });
            let initial = part
                .properties
                .iter()
                .all(|property| match property.initial {
                    InitialValue::Number(_) => true,
                    InitialValue::Component(component, index) => {
                        part.bill.iter().any(|&(b, _)| b == component)
                            && line
                                .parts
                                .get(component)
                                .is_some_and(|c| index < c.properties.len())
                    }
                });
            self.require(initial, part.span, || {
                format!(
                    "a property of {} comes from a component that it does not have",
                    part.name
                )
            });
        }
    }

    fn node(&mut self, node: &Node, has_controller: bool) {
        let line = self.line;
        let name = &node.name;
        match &node.kind {
            NodeKind::Source { part, supply, .. } => {
                self.require(self.is_part(*part), node.span, || {
                    format!("{name} makes an unknown part type")
                });
                match supply {
                    Supply::Every { interval, .. } => {
                        self.distribution(interval, node.span, name, "interval");
                    }
                    Supply::At { instants } => {
                        let sound = instants.iter().all(|at| (0.0..=MAX_SECONDS).contains(at));
                        self.require(sound && instants.is_sorted(), node.span, || {
                            format!("{name} has invalid instants")
                        });
                    }
                    Supply::OnOrder => {}
                }
            }
            NodeKind::Sink { reorder, .. } => {
                let known = reorder.is_none_or(|source| {
                    matches!(
                        line.nodes.get(source).map(|n| &n.kind),
                        Some(NodeKind::Source { .. })
                    )
                });
                self.require(known, node.span, || {
                    format!("{name} reorders parts from a place that is not a source")
                });
            }
            NodeKind::Store { stock } => {
                let known = stock.iter().all(|&(part, _)| self.is_part(part));
                self.require(known, node.span, || {
                    format!("{name} has an unknown part type in stock")
                });
            }
            NodeKind::Station(station) => {
                self.require(
                    has_controller == station.machine.is_some(),
                    node.span,
                    || format!("{name} has no controller"),
                );
                let calendar = station.calendar.as_ref();
                self.require(
                    calendar.is_none_or(WorkCalendar::is_valid),
                    node.span,
                    || format!("the calendar of {name} is not valid"),
                );
                self.distribution(&station.setup, node.span, name, "setup time");
                for mode in &station.failures {
                    self.distribution(&mode.repair, node.span, name, "time to repair");
                    let sound = match &mode.between {
                        Between::Working(time) | Between::Calendar(time) => {
                            time.is_valid() && time.takes_time()
                        }
                        Between::Parts(count) => *count > 0,
                        Between::DrawnParts(count) => count.is_valid(),
                    };
                    self.require(sound, node.span, || {
                        format!("{name} has an invalid time between failures")
                    });
                }
                let sound = [station.watts, station.idle_watts]
                    .iter()
                    .all(|watts| watts.is_finite());
                self.require(sound, node.span, || {
                    format!("{name} has a power that is not finite")
                });
                for task in &station.tasks {
                    match (&station.machine, &task.time) {
                        (Some(machine), None) => self.task(name, machine, task),
                        (None, Some(time)) => {
                            self.distribution(time, task.span, name, "time");
                            self.require(self.is_part(task.part), task.span, || {
                                format!("{name} works on an unknown part type")
                            });
                        }
                        _ => self.refuse(
                            task.span,
                            format!("a task of {name} needs either a machine or a time"),
                        ),
                    }
                }
                for setting in &station.settings {
                    let count = line.parts.get(setting.part).map(|p| p.properties.len());
                    let sound = count.is_some_and(|count| {
                        setting.property < count && fits(&setting.value, count)
                    });
                    self.require(sound, setting.span, || {
                        format!("a value that {name} sets does not fit its part type")
                    });
                }
                for defect in &station.defects {
                    let count = self.line.parts.get(defect.part).map(|p| p.properties.len());
                    let sound = count.is_some_and(|count| {
                        (0.0..=1.0).contains(&defect.probability)
                            && defect.properties.iter().all(|&p| p < count)
                            && fits(&defect.value, count + 1)
                    });
                    self.require(sound, defect.span, || {
                        format!("a defect of {name} does not fit its part type")
                    });
                }
            }
            NodeKind::Conveyor {
                places,
                pitch,
                speed,
                belt,
                watts,
            } => {
                let period = pitch / speed;
                let sound = *places > 0 && period > 0.0 && is_duration(period) && watts.is_finite();
                self.require(sound, node.span, || {
                    format!("{name} needs places, a pitch and a speed, all greater than 0")
                });
                if let Some(belt) = belt {
                    self.require(has_controller, node.span, || {
                        format!("{name} has no controller")
                    });
                    self.require(belt_fits(belt, *places), node.span, || {
                        format!(
                            "the wires of {name} do not fit its machine and its {places} places"
                        )
                    });
                }
            }
            NodeKind::Buffer {
                capacity,
                order,
                dwell,
                shelf_life,
            } => {
                self.distribution(dwell, node.span, name, "dwell time");
                self.require(shelf_life.is_none_or(is_duration), node.span, || {
                    format!("the shelf life of {name} is not a valid time")
                });
                self.require(*capacity > 0, node.span, || {
                    format!("the capacity of {name} is 0")
                });
                if let BufferOrder::Property { of, .. } = order {
                    let exists = |(part, property): (usize, &Option<usize>)| {
                        let known = self.line.parts.get(part).map_or(0, |p| p.properties.len());
                        property.is_none_or(|property| property < known)
                    };
                    let sound =
                        of.len() == self.line.parts.len() && of.iter().enumerate().all(exists);
                    self.require(sound, node.span, || {
                        format!("the order of {name} reads a property that does not exist")
                    });
                }
            }
        }
    }

    fn distribution(&mut self, it: &Distribution, span: Span, node: &str, what: &str) {
        self.require(it.is_valid(), span, || {
            format!("the {what} of {node} is not a valid distribution: {it:?}")
        });
    }

    fn task(&mut self, station: &str, machine: &Machine, task: &Task) {
        let properties = machine.properties.len();
        let carried = self.line.parts.get(task.part).map(|p| p.properties.len());
        let operations = task.operations.iter().all(|(operation, parameters)| {
            *operation < machine.operations.len()
                && parameters.iter().all(|&(index, _)| index < properties)
        });
        let sound = operations
            && task.properties.len() == properties
            && carried.is_some_and(|count| task.properties.iter().flatten().all(|&p| p < count));
        self.require(sound, task.span, || {
            format!(
                "a task of {station} does not fit its machine {}",
                machine.name
            )
        });
    }

    fn routes(&mut self) {
        let line = self.line;
        for (index, route) in line.routes.iter().enumerate() {
            if let Some(choice) = route.choice {
                let first = line.first_of_way(index);
                let count = line.end_of_way(index) - first;
                let alike = |r: &Route| (r.from, r.part) == (route.from, route.part);
                let sound = match line.choices.get(choice) {
                    None => false,
                    Some(Choice::Probability { shares }) => shares.len() == count,
                    Some(_) => true,
                };
                self.require(
                    sound && line.routes[first..first + count].iter().all(alike),
                    route.span,
                    || "the routes of a choice do not belong together".to_owned(),
                );
            }
            let part = line.parts.get(route.part);
            let from = line.nodes.get(route.from);
            let to = line.nodes.get(route.to);
            let (Some(part), Some(from), Some(to)) = (part, from, to) else {
                self.refuse(
                    route.span,
                    "a route names an unknown part type or place".to_owned(),
                );
                continue;
            };
            let condition = route
                .condition
                .as_ref()
                .is_none_or(|c| fits(c, part.properties.len()));
            self.require(condition, route.span, || {
                format!(
                    "the condition of a route reads a property that {} does not have",
                    part.name
                )
            });
            self.require(
                !matches!(from.kind, NodeKind::Sink { .. }),
                route.span,
                || format!("a route starts at the sink {}", from.name),
            );
            self.require(
                !matches!(to.kind, NodeKind::Source { .. }),
                route.span,
                || format!("a route leads to the source {}", to.name),
            );
            if let NodeKind::Station(station) = &to.kind {
                let taken = station.tasks.iter().any(|task| {
                    let bill = line.parts.get(task.part).map_or(&[][..], |p| &p.bill);
                    task.part == route.part
                        || bill.iter().any(|&(component, _)| component == route.part)
                });
                self.require(taken, route.span, || {
                    format!("{} has no task for a part of type {}", to.name, part.name)
                });
            }
        }
    }
}

/// Whether an expression reads only the first `properties` properties, and no wires.
fn fits(expression: &RealExpr, properties: usize) -> bool {
    match expression {
        RealExpr::Number(_) => true,
        RealExpr::Property(index) => *index < properties,
        RealExpr::Wire(_) => false,
        RealExpr::Unary(_, a) => fits(a, properties),
        RealExpr::Binary(_, a, b) => fits(a, properties) && fits(b, properties),
        RealExpr::If(c, a, b) => fits(c, properties) && fits(a, properties) && fits(b, properties),
    }
}

/// Whether a belt's wires exist where they are needed.
fn belt_fits(belt: &Belt, places: u32) -> bool {
    let plant = belt.machine.plant.len();
    let wires = belt.machine.wire_count();
    let output = |wire: usize| (plant..wires).contains(&wire);
    belt.load < plant
        && belt.unload_ready < plant
        && belt.load != belt.unload_ready
        && belt.places.len() == places as usize
        && belt.places.iter().all(|&wire| output(wire))
        && output(belt.ready)
}
