//! Interprets a machine in this process: the reference semantics of a station library, written for
//! clarity.
//!
//! The emitted C does the same with tables (`ffi/step.c`) and is tested against this interpreter.
//! Both check in the same order, so that they return the same error if several errors apply:
//!
//! 1. the domains of the plant's wires, in order;
//! 2. Moore components write their outputs to their wires;
//! 3. each Mealy component in order: bind its inputs, check their domains, check its assumptions
//!    (initial conditions in step 0 or safety in later steps, then invariants), take the
//!    transition, write its outputs, check its guarantees in the same way;
//! 4. each Moore component in order, including the coordinator, in the same way.
//!
//! The machine advances only after all components have answered, so an error changes nothing.

use super::messages::Party;
use super::{CallError, Controller, Service};
use linewright_core::gr1::{Formula, Side, Time, Timing, VarId, eval};
use linewright_language::contract::machine::{
    ActionTime, Component, Machine, PlantSource, RealExpr,
};
use linewright_solver::mealy;
use linewright_solver::mealy::functions::Functions;
use std::sync::Arc;

/// Maximum distance from an integer at which a property value counts as that integer.
const INTEGER_TOLERANCE: f64 = 1e-9;

/// A machine interpreted in this process.
#[derive(Debug, Clone)]
pub struct Interpreter {
    machine: Arc<Machine>,
    controllers: Arc<Vec<mealy::Controller>>,
    state: State,
}

/// The mutable state of an instance between calls.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct State {
    /// Whether step 0 has been made.
    started: bool,
    /// Each component's state, or the goal pursued by its functions; `None` before step 0.
    places: Vec<Option<usize>>,
    /// Each component's variables in the last step, in specification order.
    values: Vec<Vec<i64>>,
    /// Wires in the last step; zeros before step 0.
    wires: Vec<i64>,
}

/// Evaluates an expression that reads no next values.
fn now(expr: &linewright_core::gr1::Expr, values: &[i64]) -> i64 {
    eval::eval(expr, values, &[])
}

impl Interpreter {
    /// Prepares a machine with the controller of each of its components, in order.
    ///
    /// # Panics
    /// Panics if a controller does not fit its component's contract.
    pub fn new(machine: Arc<Machine>, controllers: Arc<Vec<mealy::Controller>>) -> Self {
        super::assert_fit(&machine, &controllers);
        let state = State::new(&machine);
        Self {
            machine,
            controllers,
            state,
        }
    }

    /// Computes all wires of the next step for these plant wires, without advancing the machine.
    pub fn peek(&self, plant: &[i64]) -> Result<Vec<i64>, CallError> {
        self.advance(&self.state, plant).map(|next| next.wires)
    }

    fn advance(&self, before: &State, plant: &[i64]) -> Result<State, CallError> {
        let machine = &*self.machine;
        if plant.len() != machine.plant.len() {
            return Err(CallError::plant_count());
        }
        let mut after = State::new(machine);
        after.started = true;
        for (input, &value) in machine.plant.iter().zip(plant) {
            if !input.domain.contains(value) {
                return Err(CallError::plant_domain(
                    &input.name,
                    value,
                    &input.describe(),
                ));
            }
        }
        after.wires[..plant.len()].copy_from_slice(plant);
        let timing = |c: usize| machine.components[c].specification.timing;
        let all = 0..machine.components.len();
        for c in all.clone().filter(|&c| timing(c) == Timing::Moore) {
            let output = match &self.controllers[c] {
                mealy::Controller::Machine(controller) => {
                    let first = controller.transitions(before.places[c]).first();
                    let missing = || CallError::no_legal_inputs(&machine.components[c].name);
                    first.ok_or_else(missing)?.output.clone()
                }
                mealy::Controller::Functions(functions) => {
                    let mut signals = self.signals(c, functions, before, None);
                    functions.compute_outputs(before.places[c], &mut signals)
                }
            };
            self.put(c, &output, &mut after);
        }
        for c in all.clone().filter(|&c| timing(c) == Timing::Mealy) {
            self.answer(c, before, &mut after)?;
        }
        for c in all.filter(|&c| timing(c) == Timing::Moore) {
            self.answer(c, before, &mut after)?;
        }
        Ok(after)
    }

    /// Performs the step of one component: computes its inputs, checks its assumptions, computes
    /// its answer, and checks its guarantees.
    fn answer(&self, c: usize, before: &State, after: &mut State) -> Result<(), CallError> {
        let component = &self.machine.components[c];
        let specification = &*component.specification;
        let mut inputs = Vec::with_capacity(component.bindings.len());
        for (id, binding) in specification.inputs().zip(&component.bindings) {
            let value = now(binding, &after.wires);
            after.values[c][id.index()] = value;
            inputs.push(value);
        }
        for (id, &value) in specification.inputs().zip(&inputs) {
            let variable = specification.variable(id);
            if !variable.domain.contains(value) {
                return Err(CallError::input_domain(
                    &component.name,
                    &variable.name,
                    value,
                    &variable.describe(),
                ));
            }
        }
        let check = |side: &Side, party: Party, after: &State| {
            let broken = first_broken(side, before.started, &before.values[c], &after.values[c]);
            broken.map_or(Ok(()), |f| Err(CallError::formula(component, f, party)))
        };
        check(
            &specification.assumptions,
            Party::of_assumptions(component),
            after,
        )?;
        let place = before.places[c];
        let (output, to) = match &self.controllers[c] {
            mealy::Controller::Machine(controller) => {
                let missing = || CallError::no_transition(&component.name);
                let transition = controller.step(place, &inputs).ok_or_else(missing)?;
                (transition.output.clone(), transition.to)
            }
            mealy::Controller::Functions(functions) => {
                let mut signals = self.signals(c, functions, before, Some(&inputs));
                let output = functions.compute_outputs(place, &mut signals);
                (output, functions.next_goal(place, &signals))
            }
        };
        self.put(c, &output, after);
        check(&specification.guarantees, Party::Machine, after)?;
        after.places[c] = Some(to);
        Ok(())
    }

    /// The signals that a component's functions read: the values of the previous step, and the
    /// inputs of this step if given. Besides the pursued goal, the previous values are the
    /// functions' only memory.
    fn signals(
        &self,
        c: usize,
        functions: &Functions,
        before: &State,
        inputs: Option<&[i64]>,
    ) -> Vec<bool> {
        let specification = &self.machine.components[c].specification;
        let values = |ids: &mut dyn Iterator<Item = VarId>| -> Vec<i64> {
            ids.map(|id| before.values[c][id.index()]).collect()
        };
        let mut signals = vec![false; 2 * functions.pairs()];
        functions.write_inputs(
            &mut signals,
            Time::Now,
            &values(&mut specification.inputs()),
        );
        functions.write_outputs(
            &mut signals,
            Time::Now,
            &values(&mut specification.outputs()),
        );
        if let Some(inputs) = inputs {
            functions.write_inputs(&mut signals, Time::Next, inputs);
        }
        signals
    }

    /// Stores a component's outputs in its wires and its values.
    fn put(&self, c: usize, output: &[i64], state: &mut State) {
        let first = self.machine.first_wire(c);
        let specification = &self.machine.components[c].specification;
        for (i, (id, &value)) in specification.outputs().zip(output).enumerate() {
            state.wires[first + i] = value;
            state.values[c][id.index()] = value;
        }
    }

    /// Computes the plant's wires for the first step of an operation. In later steps, only the
    /// wires of scripted signals change.
    fn abstract_properties(
        &self,
        from: &State,
        operation: usize,
        values: &[f64],
    ) -> Result<Vec<i64>, CallError> {
        let machine = &*self.machine;
        for (property, value) in machine.properties.iter().zip(values) {
            if !value.is_finite() {
                return Err(CallError::property_not_finite(&property.name));
            }
        }
        let mut plant = Vec::with_capacity(machine.plant.len());
        for input in &machine.plant {
            plant.push(match &input.source {
                PlantSource::Operation => machine.operations[operation].value,
                PlantSource::Signal { script } => script[0],
                PlantSource::Property(expr) => {
                    let value = expr.eval(values, &from.wires);
                    let nearest = value.round();
                    let domain = input.domain.low() as f64..=input.domain.high() as f64;
                    if (value - nearest).abs() <= INTEGER_TOLERANCE && domain.contains(&nearest) {
                        nearest as i64
                    } else {
                        return Err(CallError::abstraction(machine, input, value));
                    }
                }
            });
        }
        Ok(plant)
    }

    /// The interpreted machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Returns an interpreter with the same controllers for `machine`, which must differ from this
    /// interpreter's machine only in its limits.
    #[must_use]
    pub fn with_machine(&self, machine: Machine) -> Self {
        Self::new(Arc::new(machine), Arc::clone(&self.controllers))
    }

    /// The state of a new instance.
    pub fn initial(&self) -> State {
        State::new(&self.machine)
    }

    /// Runs an operation from the state `from`. Returns the final state, the new values of the
    /// properties, and the cost. Does not change this interpreter.
    ///
    /// # Errors
    /// Returns the error that a station library reports for the same call. The instance then stays
    /// in the state `from`, except after [`super::ErrorCode::Limit`], where the caller must reset
    /// it.
    pub fn perform(
        &self,
        from: &State,
        operation: usize,
        values: &[f64],
    ) -> Result<(State, Vec<f64>, Service), CallError> {
        let machine = &*self.machine;
        let Some(job) = machine.operations.get(operation) else {
            return Err(CallError::operation(operation));
        };
        if values.len() != machine.properties.len() {
            return Err(CallError::value_count());
        }
        let mut plant = self.abstract_properties(from, operation, values)?;
        let mut meter = Meter::new(machine, values, &from.wires);
        let mut state = from.clone();
        for step in 0..machine.step_limit {
            for (wire, input) in plant.iter_mut().zip(&machine.plant) {
                if let PlantSource::Signal { script } = &input.source {
                    *wire = script[(step % script.len() as u64) as usize];
                }
            }
            let next = self.advance(&state, &plant)?;
            meter.charge(&state, &next)?;
            state = next;
            if machine
                .done
                .as_ref()
                .is_some_and(|d| now(d, &state.wires) != 0)
            {
                let after = self.write(values, &state.wires)?;
                return Ok((state, after, meter.service));
            }
        }
        Err(CallError::limit(
            &job.name,
            machine.step_limit,
            meter.longest_silence(),
        ))
    }

    /// Computes the values of the properties after an operation.
    fn write(&self, values: &[f64], wires: &[i64]) -> Result<Vec<f64>, CallError> {
        let mut after = values.to_vec();
        for (property, expr) in &self.machine.writes {
            after[*property] = expr.eval(values, wires);
        }
        for ((property, before), v) in self.machine.properties.iter().zip(values).zip(&after) {
            if !v.is_finite() {
                return Err(CallError::write(&property.name));
            }
            #[expect(clippy::float_cmp, reason = "a value that was not written is the same")]
            if let Some(domain) = &property.domain
                && v != before
                && (*v < domain.low() as f64 || *v > domain.high() as f64 || *v != v.floor())
            {
                return Err(CallError::write_range(&property.name));
            }
        }
        Ok(after)
    }
}

impl Controller for Interpreter {
    fn simulate(&mut self, operation: usize, values: &mut [f64]) -> Result<Service, CallError> {
        match self.perform(&self.state, operation, values) {
            Ok((state, after, service)) => {
                self.state = state;
                values.copy_from_slice(&after);
                Ok(service)
            }
            Err(error) => {
                if error.code == super::ErrorCode::Limit {
                    self.reset();
                }
                Err(error)
            }
        }
    }

    fn step(&mut self, plant: &[i64], outputs: &mut [i64]) -> Result<(), CallError> {
        if plant.len() != self.machine.plant.len() {
            return Err(CallError::plant_count());
        }
        if outputs.len() != self.machine.wire_count() - plant.len() {
            return Err(CallError::output_count());
        }
        self.state = self.advance(&self.state, plant)?;
        outputs.copy_from_slice(&self.state.wires[plant.len()..]);
        Ok(())
    }

    fn reset(&mut self) {
        self.state = State::new(&self.machine);
    }
}

impl State {
    fn new(machine: &Machine) -> Self {
        Self {
            started: false,
            places: vec![None; machine.components.len()],
            values: machine
                .components
                .iter()
                .map(|c| vec![0; c.specification.variables.len()])
                .collect(),
            wires: vec![0; machine.wire_count()],
        }
    }
}

/// The parts of a state that can affect later calls. Two states that agree in these parts give the
/// same answers to every sequence of calls.
#[derive(Debug, Clone)]
pub struct Relevance {
    /// By component and variable: whether the next step reads the value that the variable has now.
    values: Vec<Vec<bool>>,
    /// By wire: whether a later operation reads the value that the wire has now.
    wires: Vec<bool>,
}

impl Relevance {
    /// Determines which values of the previous step a machine with these controllers reads.
    pub fn of(interpreter: &Interpreter) -> Self {
        let machine = &*interpreter.machine;
        let components = machine.components.iter().zip(&*interpreter.controllers);
        let values = components.map(|(component, controller)| {
            let specification = &component.specification;
            // A symbolic controller reads all values of the previous step.
            let all = controller.machine().is_none();
            let mut read = vec![all; specification.variables.len()];
            let sides = [&specification.assumptions, &specification.guarantees];
            for formula in sides.into_iter().flat_map(|side| &side.safety) {
                formula
                    .expr
                    .for_each_var(&mut |v, time| read[v.index()] |= time == Time::Now);
            }
            read
        });
        let mut wires = vec![false; machine.wire_count()];
        let mut reads = |expr: &RealExpr| {
            expr.for_each(&mut |part| {
                if let RealExpr::Wire(wire) = part {
                    wires[*wire] = true;
                }
            });
        };
        for input in &machine.plant {
            if let PlantSource::Property(expr) = &input.source {
                reads(expr);
            }
        }
        for component in &machine.components {
            reads(&component.watts);
            if let Some(ActionTime::PerStep(expr) | ActionTime::PerExecution(expr)) =
                &component.time
            {
                reads(expr);
            }
        }
        Self {
            values: values.collect(),
            wires,
        }
    }

    /// Replaces all irrelevant values of the state by zeros.
    pub fn reduce(&self, mut state: State) -> State {
        for (values, read) in state.values.iter_mut().zip(&self.values) {
            for (value, _) in values.iter_mut().zip(read).filter(|(_, read)| !**read) {
                *value = 0;
            }
        }
        for (wire, _) in state
            .wires
            .iter_mut()
            .zip(&self.wires)
            .filter(|(_, r)| !**r)
        {
            *wire = 0;
        }
        state
    }
}

/// Finds the first formula of a side that this step violates.
fn first_broken<'a>(
    side: &'a Side,
    started: bool,
    previous: &[i64],
    current: &[i64],
) -> Option<&'a Formula> {
    let over_time = if started {
        side.safety
            .iter()
            .find(|f| !eval::holds(&f.expr, previous, current))
    } else {
        side.initial
            .iter()
            .find(|f| !eval::holds(&f.expr, current, &[]))
    };
    over_time.or_else(|| {
        side.invariants
            .iter()
            .find(|f| !eval::holds(&f.expr, current, &[]))
    })
}

/// Sums up time and energy, and tracks unmet justice assumptions, while an operation runs.
struct Meter<'a> {
    machine: &'a Machine,
    properties: &'a [f64],
    wires_at_start: &'a [i64],
    service: Service,
    /// Components that were active in the previous step.
    running: Vec<bool>,
    /// Each justice assumption with its component and the step, counted from 1, in which it last
    /// held; 0 if it has not held in this operation.
    justice: Vec<(usize, &'a Formula, u64)>,
}

impl<'a> Meter<'a> {
    fn new(machine: &'a Machine, properties: &'a [f64], wires_at_start: &'a [i64]) -> Self {
        let justice = machine.components.iter().enumerate().flat_map(|(c, k)| {
            let justice = &k.specification.assumptions.justice;
            justice.iter().map(move |f| (c, f, 0))
        });
        Self {
            machine,
            properties,
            wires_at_start,
            service: Service::default(),
            running: vec![false; machine.components.len()],
            justice: justice.collect(),
        }
    }

    /// Adds the duration and energy of one step. All actions work at the same time, so the step
    /// takes as long as the slowest one.
    fn charge(&mut self, before: &State, after: &State) -> Result<(), CallError> {
        self.service.steps += 1;
        for (c, formula, held) in &mut self.justice {
            let holds = if formula.expr.mentions_next() {
                before.started && eval::holds(&formula.expr, &before.values[*c], &after.values[*c])
            } else {
                eval::holds(&formula.expr, &after.values[*c], &[])
            };
            if holds {
                *held = self.service.steps;
            }
        }
        let mut longest: Option<f64> = None;
        let mut watts = self.machine.base_watts;
        for (c, component) in self.machine.components.iter().enumerate() {
            let active = component
                .active
                .as_ref()
                .is_some_and(|a| now(a, &after.wires) != 0);
            if active {
                watts += self.watts(component)?;
                let seconds = self.seconds(component, !self.running[c])?;
                longest = Some(longest.unwrap_or(0.0).max(seconds));
            }
            self.running[c] = active;
        }
        let seconds = longest.unwrap_or(self.machine.step_seconds);
        self.service.seconds += seconds;
        if longest.is_none() {
            self.service.control_seconds += seconds;
        }
        self.service.joules += seconds * watts;
        Ok(())
    }

    fn watts(&self, component: &Component) -> Result<f64, CallError> {
        let watts = component.watts.eval(self.properties, self.wires_at_start);
        if watts.is_finite() {
            Ok(watts)
        } else {
            Err(CallError::power(&component.name))
        }
    }

    /// Duration of a step in which the action is active; `first` is true in the first step of an
    /// execution. An action without a declared time takes the machine's time per step.
    fn seconds(&self, component: &Component, first: bool) -> Result<f64, CallError> {
        let expr = match &component.time {
            None => return Ok(self.machine.step_seconds),
            Some(ActionTime::PerExecution(_)) if !first => return Ok(0.0),
            Some(ActionTime::PerStep(expr) | ActionTime::PerExecution(expr)) => expr,
        };
        let seconds = expr.eval(self.properties, self.wires_at_start);
        if seconds.is_finite() && seconds >= 0.0 {
            Ok(seconds)
        } else {
            Err(CallError::time(&component.name))
        }
    }

    /// Returns the justice assumption that has not held for the longest time, with its component
    /// and the number of steps. Of several such assumptions, it returns the last, because actions
    /// come after the coordinator that waits for them.
    fn longest_silence(&self) -> Option<(&'a Component, &'a Formula, u64)> {
        let (c, formula, held) = self.justice.iter().rev().min_by_key(|(_, _, held)| *held)?;
        let component = &self.machine.components[*c];
        Some((component, formula, self.service.steps - held))
    }
}
