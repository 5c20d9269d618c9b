//! The calls of one station: every possible call in every state that calls can lead to.
//!
//! A call is a task with the values given to the machine. After a refused call, the station is in
//! the same state as in the runner: the state before the operation that failed, or the initial
//! state if the operation reached the step limit. Earlier operations of the same task have taken
//! effect.

use super::{Real, ordered, plain};
use linewright_language::contract::line::Task;
use linewright_language::contract::machine::{Machine, PropertyKind};
use linewright_station::interpret::{Interpreter, Relevance, State};
use linewright_station::{CallError, ErrorCode};
use std::collections::{BTreeMap, VecDeque};

/// A station: its states, its calls, and its answers.
#[derive(Debug)]
pub(super) struct StationModel {
    interpreter: Interpreter,
    relevance: Relevance,
    states: Vec<State>,
    known: BTreeMap<State, usize>,
    /// By state: the state and the call from which it was first reached; `None` for the initial
    /// state.
    before: Vec<Option<(usize, usize)>>,
    /// Possible calls.
    pub calls: Vec<Call>,
    asked: BTreeMap<(usize, Vec<Real>), usize>,
    /// Pairs of state and call still to try.
    open: VecDeque<(usize, usize)>,
}

/// A task with the values of the machine's properties.
#[derive(Debug)]
pub(super) struct Call {
    /// Index into the station's tasks.
    pub task: usize,
    /// Values of the machine's properties.
    pub values: Vec<Real>,
    /// Answers and refusals, by the state in which the call was tried.
    pub answers: BTreeMap<usize, Result<Answer, Refusal>>,
}

/// Result of a task.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Answer {
    /// Values of the machine's properties after the task.
    pub values: Vec<Real>,
    /// Duration in seconds.
    pub seconds: Real,
    /// The part of the duration in which no action is active, in seconds.
    pub control: Real,
}

/// A call that is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Refusal {
    /// Index of the operation in the machine.
    pub operation: usize,
    /// The error that the station library reports.
    pub error: CallError,
}

impl StationModel {
    pub fn new(interpreter: Interpreter) -> Self {
        let relevance = Relevance::of(&interpreter);
        let first = relevance.reduce(interpreter.initial());
        Self {
            relevance,
            known: BTreeMap::from([(first.clone(), 0)]),
            states: vec![first],
            before: vec![None],
            calls: Vec::new(),
            asked: BTreeMap::new(),
            open: VecDeque::new(),
            interpreter,
        }
    }

    /// Adds a possible call. Returns its index, and whether it is new.
    pub fn ask(&mut self, task: usize, values: Vec<Real>) -> (usize, bool) {
        let key = (task, values);
        if let Some(known) = self.asked.get(&key) {
            return (*known, false);
        }
        let index = self.calls.len();
        self.calls.push(Call {
            task,
            values: key.1.clone(),
            answers: BTreeMap::new(),
        });
        self.asked.insert(key, index);
        self.open.extend((0..self.states.len()).map(|s| (s, index)));
        (index, true)
    }

    /// Tries one call in one state. Returns the state, the call and the number of steps used;
    /// `None` if all have been tried.
    pub fn try_next(&mut self, tasks: &[Task]) -> Option<(usize, usize, u64)> {
        let (state, call) = self.open.pop_front()?;
        let task = &tasks[self.calls[call].task];
        let (after, answer, steps) = self.perform(state, task, &plain(&self.calls[call].values));
        let after = self.relevance.reduce(after);
        if !self.known.contains_key(&after) {
            let index = self.states.len();
            self.known.insert(after.clone(), index);
            self.states.push(after);
            self.before.push(Some((state, call)));
            self.open.extend((0..self.calls.len()).map(|c| (index, c)));
        }
        self.calls[call].answers.insert(state, answer);
        Some((state, call, steps))
    }

    /// Runs the operations of a task in a state, as the runner does. Returns the next state, the
    /// answer and the number of steps.
    fn perform(
        &self,
        state: usize,
        task: &Task,
        values: &[f64],
    ) -> (State, Result<Answer, Refusal>, u64) {
        let machine = self.interpreter.machine();
        let mut state = self.states[state].clone();
        let mut values = values.to_vec();
        let (mut seconds, mut joules, mut steps) = (0.0, 0.0, 1);
        let mut control = 0.0;
        for (operation, parameters) in &task.operations {
            set_parameters(machine, parameters, &mut values);
            match self.interpreter.perform(&state, *operation, &values) {
                Ok((after, new, service)) => {
                    state = after;
                    values = new;
                    seconds += service.seconds;
                    control += service.control_seconds;
                    joules += service.joules;
                    steps += service.steps;
                }
                Err(error) => {
                    if error.code == ErrorCode::Limit {
                        state = self.interpreter.initial();
                        steps += machine.step_limit;
                    }
                    let refusal = Refusal {
                        operation: *operation,
                        error,
                    };
                    return (state, Err(refusal), steps);
                }
            }
            if let Some(error) = CallError::check_measurable(seconds, joules) {
                let refusal = Refusal {
                    operation: *operation,
                    error,
                };
                return (state, Err(refusal), steps);
            }
        }
        let answer = Answer {
            values: ordered(&values),
            seconds: Real(seconds),
            control: Real(control),
        };
        (state, Ok(answer), steps)
    }

    /// Number of states that calls can lead to.
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// The calls that lead from the initial state to this state, in order.
    pub fn way_to(&self, mut state: usize) -> Vec<usize> {
        let mut calls = Vec::new();
        while let Some((from, call)) = self.before[state] {
            calls.push(call);
            state = from;
        }
        calls.reverse();
        calls
    }

    /// Number of steps of the longest operation of a call, under a far larger step limit (at most
    /// `most`); `None` if an operation does not end within it.
    pub fn steps_needed(&self, state: usize, task: &Task, call: &Call, most: u64) -> Option<u64> {
        let mut machine = self.interpreter.machine().clone();
        machine.step_limit = machine.step_limit.saturating_mul(1000).min(most);
        let patient = self.interpreter.with_machine(machine);
        let mut state = self.states[state].clone();
        let mut values = plain(&call.values);
        let mut longest = None;
        for (operation, parameters) in &task.operations {
            set_parameters(patient.machine(), parameters, &mut values);
            let (after, new, service) = patient.perform(&state, *operation, &values).ok()?;
            (state, values) = (after, new);
            longest = longest.max(Some(service.steps));
        }
        longest
    }
}

fn set_parameters(machine: &Machine, given: &[(usize, f64)], values: &mut [f64]) {
    for (value, property) in values.iter_mut().zip(&machine.properties) {
        if property.kind == PropertyKind::Parameter {
            *value = property.default;
        }
    }
    for &(index, value) in given {
        values[index] = value;
    }
}
