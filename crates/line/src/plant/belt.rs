//! Conveyors with a contract: the runner steps the conveyor's controller and moves the parts
//! according to its outputs.
//!
//! A belt is a Moore machine: `s[i]` and `ready` of a step describe the state before that step's
//! inputs take effect. Every pitch/speed seconds, the runner sets `load` (a part waits to come on)
//! and `unload_ready` (the next node would take the first part), and reads the outputs. The number
//! of occupied places must equal the number of parts that the runner counts on the belt, and no
//! part must have moved backward; otherwise a part was lost or doubled. Then the first part comes
//! off if `unload_ready` is set and the last place is occupied, and a part comes on if both `load`
//! and `ready` are set.
//!
//! A belt is no longer stepped once its inputs and outputs have not changed for a while, so that
//! the calendar becomes empty if nothing in the line can move. A change at a neighbor wakes the
//! belt at the next multiple of its period. The belt falls asleep only after more unchanged steps
//! than it has places, because the controller might pass through states that its outputs do not
//! show.
//!
//! A belt can hand over and take parts only in its own step, so each belt has an `inlet`: a place
//! for a part that the belt before it has handed over. Turns at the next node are decided as for
//! all other nodes; see `flow.rs`.

use super::queue::Request;
use super::ways::Way;
use super::{BELT, Event, Place, Run};
use crate::log::EventKind;
use crate::plant::part::PartIndex;
use crate::statistics::Level;
use crate::trace::End;
use linewright_core::diagnostics::{Diagnostic, codes};
use linewright_language::contract::line::{Belt, NodeKind};
use linewright_language::contract::machine::PlantSource;
use std::collections::VecDeque;

/// Parts on a belt, and the last outputs of its controller.
#[derive(Debug)]
pub(super) struct BeltState {
    /// Parts with their places, the first to leave in front; `None` for one that has just come on.
    pub held: VecDeque<(PartIndex, Option<usize>)>,
    /// A part handed over by another belt and not yet on this one, with the sequence number of its
    /// arrival.
    pub inlet: Option<(PartIndex, u64)>,
    /// Values of the plant's wires in the current step.
    plant: Vec<i64>,
    /// By plant wire: its constant value, from the defaults of the machine's properties; `None` if
    /// a script sets it. Unused for `load` and `unload_ready`.
    constants: Vec<Option<i64>>,
    outputs: Vec<i64>,
    last_outputs: Vec<i64>,
    last_inputs: (bool, bool),
    /// Number of steps made.
    steps: u64,
    /// The multiple of the period at which the next step takes place.
    tick: u64,
    ticking: bool,
    /// Number of successive steps without a change.
    quiet: u32,
    /// Whether a part came on or off in the last step.
    handed: bool,
    /// Number of steps in which the first part had its turn at the next node but was not handed
    /// over.
    kept: usize,
    pub moving_seconds: f64,
    pub carried: u64,
    /// Number of parts over time, with that in the inlet.
    pub level: Level,
}

/// The part that would come on next.
#[derive(Clone, Copy)]
enum Next {
    Inlet(PartIndex),
    Waiting(usize),
}

impl BeltState {
    /// Of these counted seconds, those in which the belt moved, and its energy in joules: in all,
    /// and while it stood still.
    pub(super) fn moved(&self, counted: f64, watts: f64, idle_watts: f64) -> (f64, f64, f64) {
        let moving = self.moving_seconds.min(counted);
        let standing = (counted - moving) * idle_watts;
        (moving, moving * watts + standing, standing)
    }

    /// Whether the belt is stepped.
    pub(super) fn is_awake(&self) -> bool {
        self.ticking
    }

    /// Whether there is a part for each place, with that in the inlet.
    pub(super) fn is_full(&self) -> bool {
        self.level.is_full()
    }

    pub(super) fn new(belt: &Belt) -> Self {
        let machine = &belt.machine;
        let defaults: Vec<f64> = machine.properties.iter().map(|p| p.default).collect();
        let constants = machine
            .plant
            .iter()
            .map(|input| match &input.source {
                PlantSource::Operation => Some(input.domain.low()),
                PlantSource::Signal { .. } => None,
                PlantSource::Property(value) => Some(value.eval(&defaults, &[]) as i64),
            })
            .collect();
        let outputs = machine.wire_count() - machine.plant.len();
        Self {
            held: VecDeque::new(),
            inlet: None,
            plant: vec![0; machine.plant.len()],
            constants,
            outputs: vec![0; outputs],
            last_outputs: vec![0; outputs],
            last_inputs: (false, false),
            steps: 0,
            tick: 0,
            ticking: false,
            quiet: 0,
            handed: false,
            kept: 0,
            moving_seconds: 0.0,
            carried: 0,
            level: Level::new(belt.places.len() as u32),
        }
    }
}

impl<'a> Run<'a> {
    fn belt(&mut self, node: usize) -> &mut BeltState {
        match &mut self.nodes[node].place {
            Place::Belt(belt) => belt,
            _ => unreachable!("node {node} is not a belt; please report this"),
        }
    }

    /// Declaration and period of a belt.
    fn belt_declared(&self, node: usize) -> Option<(&'a Belt, f64)> {
        match &self.line.nodes[node].kind {
            NodeKind::Conveyor {
                pitch,
                speed,
                belt: Some(belt),
                ..
            } => Some((belt, pitch / speed)),
            _ => None,
        }
    }

    /// Resumes the steps of a belt because a neighbor has changed.
    pub(super) fn wake(&mut self, node: usize) {
        let now = self.now;
        let Some((_, period)) = self.belt_declared(node) else {
            return;
        };
        let belt = self.belt(node);
        belt.quiet = 0;
        if std::mem::replace(&mut belt.ticking, true) {
            return;
        }
        belt.tick = belt.tick.max((now / period).ceil() as u64);
        let time = (belt.tick as f64 * period).max(now);
        self.schedule(time, BELT, Event::Tick(node as u32));
    }

    /// Steps the controller once.
    pub(super) fn tick(&mut self, node: usize) {
        let Some((declared, period)) = self.belt_declared(node) else {
            return;
        };
        let unload_ready = self.unload_ready(node);
        let next = self.next_on(node);
        let load = next.is_some();
        let belt = self.belt(node);
        belt.tick += 1;
        let steps = belt.steps;
        for (wire, value) in belt.plant.iter_mut().enumerate() {
            *value = match (&declared.machine.plant[wire].source, belt.constants[wire]) {
                _ if wire == declared.load => i64::from(load),
                _ if wire == declared.unload_ready => i64::from(unload_ready),
                (_, Some(constant)) => constant,
                (PlantSource::Signal { script }, None) if !script.is_empty() => {
                    script[(steps % script.len() as u64) as usize]
                }
                _ => 0,
            };
        }
        let (Some(controller), Place::Belt(belt)) =
            (&mut self.controllers[node], &mut self.nodes[node].place)
        else {
            return;
        };
        if let Err(error) = controller.step(&belt.plant, &mut belt.outputs) {
            // The step changed nothing and would break the same rule again: it is retried when a
            // neighbor has changed.
            belt.ticking = false;
            self.violate(node, None, error);
            self.progress.limit_violations();
            self.ask(node);
            if unload_ready {
                self.decline(node);
            }
            return;
        }
        belt.steps += 1;
        let first = belt.plant.len();
        let on = |wire: usize| belt.outputs.get(wire - first).is_some_and(|&v| v != 0);
        let occupied: Vec<usize> = (0..declared.places.len())
            .filter(|&place| on(declared.places[place]))
            .collect();
        let accepted = load && on(declared.ready);
        let unloaded = unload_ready && on(declared.places[declared.places.len() - 1]);
        let moved = match self.compare(node, &occupied) {
            Ok(moved) => moved,
            Err(message) => {
                self.stop(End::PartLost);
                self.journal.findings.push(
                    Diagnostic::error(codes::LINE_PART_LOST, self.line.nodes[node].span, message)
                        .with_help(
                            "The conveyor's contract must keep every part: compare the guarantee about each place \
                             with those about the places before it.",
                        ),
                );
                return;
            }
        };
        let belt = self.belt(node);
        if moved || belt.handed {
            belt.moving_seconds += period;
        }
        belt.handed = accepted || unloaded;
        let unchanged = !belt.handed
            && belt.outputs == belt.last_outputs
            && belt.last_inputs == (load, unload_ready);
        belt.quiet = if unchanged { belt.quiet + 1 } else { 0 };
        belt.last_inputs = (load, unload_ready);
        let BeltState {
            outputs,
            last_outputs,
            ..
        } = belt;
        last_outputs.copy_from_slice(outputs);
        if unloaded {
            self.unload(node);
        }
        let had_turn = unload_ready && !unloaded && self.nodes[node].outlet.part.is_some();
        if accepted {
            match next {
                Some(Next::Inlet(part)) => {
                    self.belt(node).inlet = None;
                    self.belt(node).held.push_back((part, None));
                    self.look_at(node);
                }
                Some(Next::Waiting(position)) => {
                    if let Some(request) = self.nodes[node].requests.remove(position) {
                        let (from, outlet) = (request.from as usize, request.outlet as usize);
                        self.transfer(from, outlet, node);
                    }
                }
                None => {}
            }
        }
        let last = declared.places.len() - 1;
        let belt = self.belt(node);
        let at_end = !unloaded && belt.held.front().is_some_and(|(_, p)| *p == Some(last));
        let asleep = belt.quiet as usize > declared.places.len() + 1;
        belt.kept += usize::from(had_turn);
        let too_long = belt.kept > declared.places.len() + 2;
        if had_turn && (too_long || asleep) {
            self.decline(node);
        }
        if at_end || asleep {
            self.ask(node);
        }
        let belt = self.belt(node);
        belt.ticking = !asleep;
        if !asleep {
            let time = (belt.tick as f64 * period).max(self.now);
            self.schedule(time, BELT, Event::Tick(node as u32));
        }
    }

    /// Whether the next node would take the first part; true if there is no part on the belt,
    /// because then nothing is in the way of the next one.
    fn unload_ready(&mut self, node: usize) -> bool {
        let Some(&(part, _)) = self.belt(node).held.front() else {
            return true;
        };
        let way = match self.nodes[node].outlet.to {
            Some(way) => Some(way),
            None => self.way(node, part),
        };
        way.is_some_and(|way| self.room_at_end(node, part, way).is_some())
    }

    /// The place at the end of a way that would take a part now.
    fn room_at_end(&self, node: usize, part: PartIndex, way: Way) -> Option<usize> {
        let kind = self.parts[part].kind;
        self.choose(way, |to: &usize| {
            self.admits(*to, kind, node) && !self.others_first(*to, Some(node))
        })
    }

    /// The part that would come on: the one handed over by another belt or the first waiting one,
    /// whichever came first.
    fn next_on(&self, node: usize) -> Option<Next> {
        let Place::Belt(belt) = &self.nodes[node].place else {
            return None;
        };
        let mut requests = self.nodes[node].requests.iter().enumerate();
        let waiting = requests.find(|(_, request)| !request.is_belt);
        match (belt.inlet, waiting) {
            (Some((_, order)), Some((position, request))) if request.order < order => {
                Some(Next::Waiting(position))
            }
            (Some((part, _)), _) => Some(Next::Inlet(part)),
            (None, Some((position, _))) => Some(Next::Waiting(position)),
            (None, None) => None,
        }
    }

    /// Assigns the parts to the occupied places that the controller reports. Returns whether any
    /// part has moved, or the message if one was lost or doubled.
    fn compare(&mut self, node: usize, occupied: &[usize]) -> Result<bool, String> {
        let held = self.belt(node).held.len();
        if occupied.len() != held {
            let verb = if occupied.len() < held {
                "lost"
            } else {
                "doubled"
            };
            return Err(format!(
                "{} {verb} a part at {}: its controller says that {} of its places are occupied, but {held} parts are on it",
                self.name(node),
                self.moment(),
                occupied.len()
            ));
        }
        let mut moved = false;
        for (position, &place) in occupied.iter().rev().enumerate() {
            let (part, before) = self.belt(node).held[position];
            if before.is_some_and(|before| place < before) {
                return Err(format!(
                    "{} lost a part at {}: {} {} was on place {} and would now be behind it, on place {place}",
                    self.name(node),
                    self.moment(),
                    self.type_name(self.parts[part].kind),
                    self.parts[part].number,
                    before.unwrap_or(0),
                ));
            }
            if before != Some(place) {
                moved = true;
                self.belt(node).held[position].1 = Some(place);
                self.record(node, Some(part), EventKind::Place(place as u32));
            }
        }
        Ok(moved)
    }

    /// Registers that the first part waits for its next node, unless this is already registered.
    fn ask(&mut self, node: usize) {
        if self.nodes[node].outlet.part.is_some() {
            return;
        }
        let Some(&(part, _)) = self.belt(node).held.front() else {
            return;
        };
        let way = self.way(node, part);
        self.parts[part].waits_since = self.now;
        self.nodes[node].outlet.part = Some(part);
        self.nodes[node].outlet.to = way;
        if let Some(way) = way {
            let setup = self.setup;
            for &to in setup.ways.to(&way) {
                let to = to as usize;
                let request = Request {
                    order: self.next_number(),
                    outlet: node as u32,
                    kind: self.parts[part].kind as u32,
                    from: node as u32,
                    is_belt: true,
                    declined: false,
                };
                self.register(to, request);
            }
        }
    }

    /// Ends the turn of the first part, which was not handed over to the next node: parts that wait
    /// behind it go first.
    fn decline(&mut self, node: usize) {
        self.belt(node).kept = 0;
        let Some(way) = self.nodes[node].outlet.to else {
            return;
        };
        let setup = self.setup;
        for &to in setup.ways.to(&way) {
            let to = to as usize;
            if self.lose_turn(to, node) {
                self.look_at(to);
            }
        }
    }

    /// Removes the first part from the belt.
    fn unload(&mut self, node: usize) {
        let Some(&(part, _)) = self.belt(node).held.front() else {
            return;
        };
        if self.nodes[node].outlet.part.is_none() {
            let way = self.way(node, part);
            self.nodes[node].outlet.part = Some(part);
            self.nodes[node].outlet.to = way;
        }
        self.belt(node).kept = 0;
        let way = self.nodes[node].outlet.to;
        if let Some(to) = way.and_then(|way| self.room_at_end(node, part, way)) {
            self.nodes[to].requests.withdraw(node);
            self.transfer(node, node, to);
            // The requests behind this one had to wait for it; now they are examined.
            self.look_at(to);
        }
    }

    /// Updates the belt after the first part has left.
    pub(super) fn belt_left(&mut self, node: usize) {
        let now = self.now;
        let belt = self.belt(node);
        belt.level.decrease(now);
        belt.held.pop_front();
        belt.carried += 1;
    }

    /// Puts an arriving part onto the belt or, if it comes from another belt, into the inlet.
    pub(super) fn belt_arrival(&mut self, from: usize, node: usize, part: PartIndex) {
        let now = self.now;
        self.belt(node).level.increase(now);
        if matches!(self.nodes[from].place, Place::Belt(_)) {
            let order = self.next_number();
            self.belt(node).inlet = Some((part, order));
            self.wake(node);
        } else {
            self.belt(node).held.push_back((part, None));
        }
    }
}
