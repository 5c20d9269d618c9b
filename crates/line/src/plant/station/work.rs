//! What a run does with its stations: parts arrive, are joined and worked on, and leave; shifts
//! begin and end.

use super::{Phase, Station};
use crate::log::{EventKind, Other};
use crate::plant::part::PartIndex;
use crate::plant::{Event, Node, Place, Run, WORK};
use crate::statistics::Activity;
use linewright_language::contract::line::NodeKind;
use linewright_language::contract::machine::PropertyKind;
use linewright_station::{CallError, ErrorCode, Service};

/// The properties that the work on a part has changed.
fn changes(before: &[f64], after: &[f64]) -> Vec<(EventKind, Other)> {
    let pairs = before.iter().zip(after).enumerate();
    pairs
        .filter(|(_, (before, after))| before.to_bits() != after.to_bits())
        .map(|(property, (_, after))| (EventKind::Changed, Other::Property(property, *after)))
        .collect()
}

#[inline]
fn station_of(nodes: &mut [Node], node: usize) -> &mut Station {
    match &mut nodes[node].place {
        Place::Station(station) => station,
        _ => unreachable!("node {node} is not a station; please report this"),
    }
}

impl Run<'_> {
    #[inline]
    pub(in crate::plant) fn station(&mut self, node: usize) -> &mut Station {
        station_of(&mut self.nodes, node)
    }

    /// A part arrives at a station that admits it.
    #[inline]
    pub(in crate::plant) fn station_arrival(&mut self, node: usize, part: PartIndex) {
        let arriving = &self.parts[part];
        let kind = arriving.kind;
        let station = station_of(&mut self.nodes, node);
        station.waits.supplier = arriving.came_from;
        if station.joins_some() {
            self.joining_arrival(node, part, kind);
        } else if let Some(task) = station.plain[kind] {
            self.begin(node, task, part);
        }
    }

    /// A part arrives at a station that joins: it is added to the first bill that lacks a component
    /// of its type or, if there is none, begins.
    #[inline(never)]
    fn joining_arrival(&mut self, node: usize, part: PartIndex, kind: usize) {
        self.parts[part].waits_since = self.now;
        let station = self.station(node);
        let Some((task, line)) = station.component_place(kind) else {
            if let Some(task) = station.plain[kind] {
                self.begin(node, task, part);
            }
            return;
        };
        let bill = &mut station.bills[task];
        bill.lines[line].2.push(part);
        let mut lines = bill.lines.iter();
        if lines.all(|(_, count, there)| there.len() == *count) {
            let order = self.next_number();
            self.station(node).bills[task].complete = Some(order);
            self.look_at(node);
        }
    }

    /// Lets a free station join the bill that has been complete longest, unless a part for another
    /// task has waited longer.
    #[inline(never)]
    pub(in crate::plant) fn station_ready(&mut self, node: usize) {
        let Place::Station(station) = &self.nodes[node].place else {
            return;
        };
        if !station.can_begin() {
            return;
        }
        let complete = station
            .bills
            .iter()
            .enumerate()
            .filter_map(|(task, bill)| bill.complete.map(|order| (order, task)))
            .min();
        let Some((order, task)) = complete else {
            return;
        };
        let older = self.nodes[node].requests.iter().any(|request| {
            let kind = request.kind as usize;
            request.order < order && !station.lacks(kind) && station.plain[kind].is_some()
        });
        if !older {
            self.join(node, task);
        }
    }

    /// Joins the components of a complete bill into a new part, and begins work on it.
    fn join(&mut self, node: usize, task: usize) {
        let station = self.station(node);
        let kind = station.kinds[task];
        station.bills[task].complete = None;
        let lines: Vec<(usize, Vec<PartIndex>)> = station.bills[task]
            .lines
            .iter_mut()
            .map(|(component, _, there)| (*component, std::mem::take(there)))
            .collect();
        let components = || lines.iter().flat_map(|(_, parts)| parts).copied();
        let first = |wanted| {
            lines
                .iter()
                .find(|(component, _)| *component == wanted)
                .and_then(|(_, parts)| parts.first().copied())
        };
        let part = self.parts.create(self.line, kind, first);
        let entered_at = components()
            .map(|component| self.parts[component].entered_at)
            .fold(self.now, f64::min);
        let worked = components().map(|component| self.parts[component].worked());
        let worked = worked.sum();
        let reworked = components().map(|component| self.parts[component].reworked());
        let reworked = reworked.sum();
        let joined = Some(Other::Part(self.parts[part].number));
        for component in components() {
            self.record_with(node, Some(component), EventKind::Consumed, joined);
            self.leave_line(component);
            self.counters.consumed += 1;
        }
        self.parts[part].entered_at = entered_at;
        self.parts[part].entered = true;
        self.parts[part].worked_inside = worked;
        self.parts[part].reworked_inside = reworked;
        self.parts[part].since = self.now;
        self.counters.unit_enters(self.now);
        // The components are still counted as in the line, because the new part contains them.
        self.counters.in_line[kind] += 1;
        self.record(node, Some(part), EventKind::Entered);
        if !self.refuse_out_of_range(node, part) {
            self.begin(node, task as u32, part);
        }
        self.look_at(node);
    }

    /// Removes a part that has a value outside its range; returns whether it did.
    #[inline(never)]
    fn refuse_out_of_range(&mut self, node: usize, part: PartIndex) -> bool {
        let kind = &self.line.parts[self.parts[part].kind];
        let Some(property) = kind.first_out_of_range(&self.parts[part].properties) else {
            return false;
        };
        let value = self.parts[part].properties[property];
        let property = &kind.properties[property];
        let error = CallError {
            code: ErrorCode::Domain,
            rule: None,
            message: format!(
                "`{}` of {} is set to {value}, which is outside {}",
                property.name,
                kind.name,
                property.describe()
            ),
        };
        self.take_out(node, part, error);
        true
    }

    /// Removes a part whose service breaks a rule, and orders its replacement.
    fn take_out(&mut self, node: usize, part: PartIndex, error: CallError) {
        self.violate(node, Some(part), error);
        self.progress.limit_violations();
        self.station_left(node);
        let replacement = self.replacement(self.parts[part].kind);
        self.reject(node, part, replacement);
        self.look_at(node);
    }

    /// Removes the part in work as scrap, and orders its replacement. Its work has used energy
    /// nevertheless.
    pub(in crate::plant) fn scrap_work(&mut self, node: usize) {
        let station = self.station(node);
        let (Phase::Service, Some(part)) = (station.phase, station.part) else {
            return;
        };
        station.joules += station.joules_so_far();
        station.scrapped += 1;
        station.broken += 1;
        self.record(node, Some(part), EventKind::Aborted);
        self.station_left(node);
        self.scrap(node, part);
    }

    /// Begins to process a part in a station that can begin, with setup first if the part type has
    /// changed.
    #[expect(
        clippy::inline_always,
        reason = "a call would cost a good part of the body"
    )]
    #[inline(always)]
    fn begin(&mut self, node: usize, task: u32, part: PartIndex) {
        let now = self.now;
        let station = station_of(&mut self.nodes, node);
        debug_assert!(station.can_begin());
        let begun = &mut self.parts[part];
        let changes = station.last_kind.is_some_and(|last| last != begun.kind);
        station.accept(part, task, begun, now);
        let seconds = if changes { None } else { station.draw_time() };
        let Some(seconds) = seconds else {
            return self.begin_otherwise(node, part, changes);
        };
        station.start(seconds, seconds * station.watts, 0.0);
        let (seconds, number) = station.work(now);
        // The wait ends at this instant, so it can be charged after the work has been booked.
        let was_starved = station.waits.is_starved();
        self.schedule_end(node, seconds, number);
        if was_starved {
            self.end_starving(node);
        }
        self.record_start(node, part);
    }

    /// Begins setup, or a service whose duration a controller determines.
    #[inline(never)]
    fn begin_otherwise(&mut self, node: usize, part: PartIndex, changes: bool) {
        if self.station(node).waits.is_starved() {
            self.end_starving(node);
        }
        if changes {
            self.begin_setup(node, part);
        } else {
            self.serve_part(node, part);
        }
    }

    /// Begins setup for a part that the station has accepted or, if this takes no time, its
    /// service.
    fn begin_setup(&mut self, node: usize, part: PartIndex) {
        let station = self.station(node);
        let seconds = station.setup.draw();
        if seconds <= 0.0 {
            self.serve_part(node, part);
            return;
        }
        station.phase = Phase::Setup;
        station.phase_seconds = seconds;
        station.remaining = seconds;
        self.record(node, Some(part), EventKind::SetupStarted);
        self.resume(node);
    }

    /// Begins the service of a part that the station has accepted. A controller, if there is one,
    /// is called for all operations of the task. The station is busy from now on.
    #[inline(never)]
    fn serve_part(&mut self, node: usize, part: PartIndex) {
        self.record(node, Some(part), EventKind::Started);
        let station = self.station(node);
        if let Some(seconds) = station.draw_time() {
            station.start(seconds, seconds * station.watts, 0.0);
            self.resume(node);
        } else {
            self.serve_with_controller(node, part);
        }
    }

    /// Schedules the end of setup or service, or the failure before it.
    #[inline]
    fn schedule_end(&mut self, node: usize, seconds: f64, number: u32) {
        let event = Event::Station(node as u32, number);
        self.schedule(self.now + seconds, WORK, event);
    }

    #[inline(never)]
    fn serve_with_controller(&mut self, node: usize, part: PartIndex) {
        match self.simulate(node, part) {
            Ok(Service {
                seconds,
                joules,
                control_seconds,
                ..
            }) => {
                self.station(node).start(seconds, joules, control_seconds);
                self.resume(node);
            }
            Err(error) => self.take_out(node, part, error),
        }
    }

    /// Simulates the task's operations at one instant. Returns their total cost. The part's new
    /// properties are stored in `outcome` until the end of the service.
    fn simulate(&mut self, node: usize, part: PartIndex) -> Result<Service, CallError> {
        let NodeKind::Station(declared) = &self.line.nodes[node].kind else {
            return Ok(Service::default());
        };
        let Place::Station(station) = &mut self.nodes[node].place else {
            return Ok(Service::default());
        };
        let carried = &self.parts[part].properties;
        station.outcome.clear();
        station.outcome.extend_from_slice(carried);
        let (Some(controller), Some(machine)) = (&mut self.controllers[node], &declared.machine)
        else {
            return Ok(Service::default());
        };
        let task = &declared.tasks[station.task as usize];
        let values = &mut station.values;
        values.clear();
        values.extend(
            machine
                .properties
                .iter()
                .zip(&task.properties)
                .map(|(property, source)| {
                    source.map_or(property.default, |source| carried[source])
                }),
        );
        let mut total = Service::default();
        for (operation, parameters) in &task.operations {
            for (value, property) in values.iter_mut().zip(&machine.properties) {
                if property.kind == PropertyKind::Parameter {
                    *value = property.default;
                }
            }
            for &(index, value) in parameters {
                values[index] = value;
            }
            let service = controller.simulate(*operation, values)?;
            total.seconds += service.seconds;
            total.joules += service.joules;
            total.control_seconds += service.control_seconds;
            total.steps += service.steps;
            if let Some(error) = CallError::check_measurable(total.seconds, total.joules) {
                return Err(error);
            }
        }
        for (value, target) in values.iter().zip(&task.properties) {
            if let Some(target) = target {
                station.outcome[*target] = *value;
            }
        }
        Ok(total)
    }

    /// Starts or continues setup or service, unless the station is broken down or off shift.
    #[inline(never)]
    fn resume(&mut self, node: usize) {
        let now = self.now;
        if let Some((seconds, number)) = self.station(node).resume(now) {
            self.schedule_end(node, seconds, number);
        }
        self.record_state(node);
    }

    /// Setup or service ends, or the station breaks down.
    pub(in crate::plant) fn station_event(&mut self, node: usize, number: u32) {
        let station = self.station(node);
        if !station.running || station.number != number {
            self.progress.skip_event();
            return;
        }
        let until_failure = station.until_failure();
        let fails = until_failure < station.remaining;
        // The exact duration, not the difference of two times, because rounding must not leave a
        // remainder of the service.
        let worked = if fails {
            until_failure
        } else {
            station.remaining
        };
        station.running = false;
        station.remaining -= worked;
        if station.phase == Phase::Service {
            station.failures.worked(worked);
        }
        if fails {
            if let Some(mode) = station.failures.strike_at_work() {
                self.break_down(node, mode);
            }
        } else if let Some(part) = station.part {
            if station.phase == Phase::Setup {
                self.serve_part(node, part);
            } else {
                self.end_service(node, part);
            }
        }
    }

    /// Lets a repaired station continue or begin its work.
    pub(in crate::plant) fn work_again(&mut self, node: usize) {
        let now = self.now;
        let station = self.station(node);
        if matches!(station.phase, Phase::Setup | Phase::Service) {
            self.resume(node);
        } else {
            station.book(now);
            self.record_state(node);
            self.begin_wait(node);
            self.look_at(node);
        }
    }

    /// Ends the service: the part receives its new properties and possibly random defects, and
    /// leaves when it can.
    fn end_service(&mut self, node: usize, part: PartIndex) {
        let now = self.now;
        let station = station_of(&mut self.nodes, node);
        station.processed += 1;
        station.joules += station.service_joules;
        station.control_seconds += station.service_control;
        station.work_seconds += station.phase_seconds;
        station.phase = Phase::Done;
        station.overtime = false;
        // A station that has failed does not end a service.
        let activity = if station.on_shift {
            Activity::Blocked
        } else {
            Activity::Idle
        };
        station.clock.switch(now, activity);
        let can_strike = station.failures.can_strike();
        let finished = &mut self.parts[part];
        finished.worked_at = Some(node as u32);
        let has_properties = !finished.properties.is_empty();
        if has_properties {
            self.change_properties(node, part);
        }
        self.record_end(node, part);
        if can_strike {
            self.strike_finished(node);
        }
        if has_properties && self.refuse_out_of_range(node, part) {
            return;
        }
        self.offer(node, node, part);
    }

    /// Lets the failures strike that come after a number of parts.
    #[inline(never)]
    fn strike_finished(&mut self, node: usize) {
        for mode in self.station(node).failures.part_finished() {
            self.break_down(node, mode);
        }
    }

    /// Gives a part the properties that follow from the work on it, and possibly random defects.
    #[inline(never)]
    fn change_properties(&mut self, node: usize, part: PartIndex) {
        let observed = self.is_observed();
        let NodeKind::Station(declared) = &self.line.nodes[node].kind else {
            return;
        };
        let defects = &declared.defects;
        let Place::Station(station) = &mut self.nodes[node].place else {
            return;
        };
        let finished = &mut self.parts[part];
        let before = observed.then(|| finished.properties.clone());
        if station.times[station.task as usize].is_none() {
            finished.properties.clone_from(&station.outcome);
        }
        declared.set_values(finished.kind, &mut finished.properties);
        let mut changes = before.map(|before| changes(&before, &finished.properties));
        for defect in defects.iter().filter(|d| d.part == finished.kind) {
            if defect.properties.is_empty() || !station.defects.chance(defect.probability) {
                continue;
            }
            let chosen = station.defects.below(defect.properties.len() as u64) as usize;
            let chosen = defect.properties[chosen];
            let count = finished.properties.len();
            finished.properties.push(finished.properties[chosen]);
            let value = defect.value.eval(&finished.properties, &[]);
            finished.properties.truncate(count);
            finished.properties[chosen] = value;
            finished.defect_at = Some(node as u32);
            if let Some(changes) = &mut changes {
                changes.push((EventKind::Defect, Other::Property(chosen, value)));
            }
        }
        for (what, property) in changes.into_iter().flatten() {
            self.record_with(node, Some(part), what, Some(property));
        }
    }

    /// Frees a station that no longer has a part in work.
    #[inline(never)]
    pub(in crate::plant) fn station_left(&mut self, node: usize) {
        let now = self.now;
        self.station(node).clear(now);
        self.record_state(node);
    }

    /// A shift of the station begins or ends. If work that has begun is finished, the station goes
    /// on with its part.
    pub(in crate::plant) fn station_shift(&mut self, node: usize, finishes_work: bool) {
        let (now, on_shift) = (self.now, self.shifts.is_on(node));
        self.end_wait(node);
        let station = self.station(node);
        station.on_shift = on_shift;
        // A part that comes at this very instant waits for the next shift.
        let has_begun =
            matches!(station.phase, Phase::Setup | Phase::Service) && station.begun_at < now;
        station.overtime = !on_shift && finishes_work && has_begun;
        if !on_shift && !station.overtime {
            station.pause(now);
        }
        self.work_again(node);
        self.look_at(node);
    }
}
