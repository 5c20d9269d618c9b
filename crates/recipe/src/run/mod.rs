//! Runs: a cell carries a plan out.
//!
//! A plan says in which order each resource does what, and when it can begin. A run follows it with
//! the durations and the outcomes of tests that occur, which a [`Plant`] decides:
//!
//! - An event begins when the plan says, or later: when its resources have ended what they did
//!   before, and its product the step before. An event is a step of a product, an internal
//!   operation or a transfer; [`crate::plan`] says how its parts lie in time.
//! - A test is made when the plan says, or later: when the product and all resources that have
//!   ended before it in the plan have ended.
//! - The next position begins when the plan says, or later: when all resources are at rest.
//!
//! So if everything takes its time of the layout, the run is the plan. If something takes longer,
//! the run is late, and a resource may have to wait in a state where it may not; this is an
//! [`Overrun`].
//!
//! [`Vectors`] are a run without a plan: a controller says what each resource does next.

mod clock;
mod vectors;

pub use clock::Overrun;
pub use vectors::Vectors;

use crate::model::{Action, Demand, Layout};
use crate::plan::{Entry, EntrySubject, Execution, Next, Plan, PlanPosition, Schedule};
use clock::Clock;

/// What a run asks the cell for.
pub trait Plant {
    /// Why an operation fails.
    type Error;

    /// Performs an operation: a transition of a resource. Returns `None` if it takes the duration
    /// and power of the layout. In lockstep, only the energy counts.
    fn perform(
        &mut self,
        resource: usize,
        transition: usize,
    ) -> Result<Option<Performance>, Self::Error>;

    /// Tests a product. Returns one of the transitions of its recipe, which leave its state.
    fn test(&mut self, product: usize, transitions: &[usize]) -> usize;
}

/// What an operation took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Performance {
    /// Duration in ns, not negative.
    pub nanoseconds: i64,
    /// Electrical energy in µJ.
    pub microjoules: i64,
}

/// What happened in a run. Times are in nanoseconds, or in vectors in lockstep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// How the plan was executed.
    pub execution: Execution,
    /// Transitions of the resources, in the order of the plan.
    pub entries: Vec<Entry>,
    /// Tests in their order.
    pub tests: Vec<TestResult>,
    /// Times at which a product closed a loop of its recipe.
    pub loops: Vec<i64>,
    /// When the run ended.
    pub time: i64,
    /// Electrical energy of all transitions in µJ.
    pub energy: i64,
    /// Whether all products are finished. If not, the run ended at its limit.
    pub is_finished: bool,
    /// Resources that waited where they may not.
    pub overruns: Vec<Overrun>,
}

/// A test in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TestResult {
    /// When.
    pub time: i64,
    /// Index of the product.
    pub product: usize,
    /// Index of the transition that its recipe takes.
    pub transition: usize,
    /// Number of entries that were decided before the test.
    pub entries_before: usize,
}

impl Run {
    /// Creates a run in which nothing has happened.
    fn new(execution: Execution) -> Self {
        Self {
            execution,
            entries: Vec::new(),
            tests: Vec::new(),
            loops: Vec::new(),
            time: 0,
            energy: 0,
            is_finished: false,
            overruns: Vec::new(),
        }
    }

    /// Returns the run as a plan with one position, whose tests have only the outcomes that
    /// occurred.
    pub fn as_plan(&self, plan: &Plan) -> Plan {
        let mut rest = self.entries.as_slice();
        let mut then = Next::End { time: self.time };
        for test in self.tests.iter().rev() {
            let (before, after) = rest.split_at(test.entries_before);
            rest = before;
            let schedule = Schedule {
                entries: after.to_vec(),
                then,
            };
            then = Next::Test {
                time: test.time,
                product: test.product,
                outcomes: vec![(test.transition, schedule)],
            };
        }
        let schedule = Schedule {
            entries: rest.to_vec(),
            then,
        };
        let start = plan.positions.first().cloned();
        let positions = start.map(|start| PlanPosition { schedule, ..start });
        Plan {
            positions: positions.into_iter().collect(),
            value: self.time,
            ..plan.clone()
        }
    }

    /// Returns how long each of some resources was busy, in the unit of the times.
    pub fn busy(&self, resources: usize) -> Vec<i64> {
        let mut busy = vec![0; resources];
        for entry in &self.entries {
            busy[entry.resource] += entry.end - entry.start;
        }
        busy
    }
}

/// Carries a plan out. The plan must be one that [`crate::replay_plan::verify`] accepts.
///
/// A run of a recipe that never ends stops before it would begin position number `positions + 1`.
/// Takes time proportional to the number of entries, tests times resources, and calls of the plant.
///
/// # Errors
/// The plant's error, if an operation fails.
///
/// # Panics
/// Panics if the plant returns a transition that does not leave the state of the product.
pub fn run<P: Plant>(
    layout: &Layout,
    demands: &[Demand],
    plan: &Plan,
    plant: &mut P,
    positions: usize,
) -> Result<Run, P::Error> {
    let products = demands.iter().map(|d| d.count).sum();
    let mut runner = Runner {
        layout,
        plant,
        clock: Clock::new(layout, products),
        run: Run::new(plan.execution()),
    };
    let mut next = (!plan.positions.is_empty()).then_some(0);
    for _ in 0..positions {
        let Some(position) = next else { break };
        runner
            .clock
            .enter(&plan.positions[position].resource_states);
        next = runner.position(&plan.positions[position].schedule)?;
    }
    Ok(runner.end(next.is_none()))
}

/// A run that goes on.
struct Runner<'a, P> {
    layout: &'a Layout,
    plant: &'a mut P,
    clock: Clock<'a>,
    run: Run,
}

impl<P: Plant> Runner<'_, P> {
    /// Carries out a schedule. Returns the position that follows, if one does.
    fn position(&mut self, schedule: &Schedule) -> Result<Option<usize>, P::Error> {
        let mut schedule = schedule;
        loop {
            let mut entries = schedule.entries.as_slice();
            while let Some(first) = entries.first() {
                let same = entries.iter().take_while(|e| e.event == first.event);
                let (event, rest) = entries.split_at(same.count());
                self.event(event)?;
                entries = rest;
            }
            match &schedule.then {
                Next::End { time } => {
                    self.clock.rest(*time);
                    return Ok(None);
                }
                Next::Goto {
                    time,
                    position,
                    closes_loop,
                } => {
                    let now = self.clock.rest(*time);
                    self.run.loops.extend(closes_loop.then_some(now));
                    return Ok(Some(*position));
                }
                Next::Test {
                    time,
                    product,
                    outcomes,
                } => {
                    let transitions: Vec<usize> = outcomes.iter().map(|o| o.0).collect();
                    let transition = self.plant.test(*product, &transitions);
                    let outcome = outcomes.iter().find(|o| o.0 == transition);
                    schedule = &outcome.expect("the transition leaves the state").1;
                    self.run.tests.push(TestResult {
                        time: self.clock.test(*time, *product),
                        product: *product,
                        transition,
                        entries_before: self.run.entries.len(),
                    });
                }
            }
        }
    }

    /// Ends the run.
    fn end(self, is_finished: bool) -> Run {
        Run {
            is_finished,
            time: self.clock.base(),
            overruns: self.clock.overruns,
            ..self.run
        }
    }

    /// Carries out an event.
    fn event(&mut self, event: &[Entry]) -> Result<(), P::Error> {
        let mut durations = Vec::new();
        for entry in event {
            let transition = &self.layout.resources[entry.resource].transitions[entry.transition];
            let mut took = Performance {
                nanoseconds: transition.nanoseconds(),
                microjoules: transition.microjoules(),
            };
            if matches!(entry.subject, EntrySubject::Operation { .. }) {
                let performed = self.plant.perform(entry.resource, entry.transition)?;
                took = performed.unwrap_or(took);
            }
            self.run.energy += took.microjoules;
            durations.push(match self.run.execution {
                Execution::Lockstep => 1,
                Execution::Timed => took.nanoseconds,
            });
        }
        let gives = |e: &Entry| {
            let transition = &self.layout.resources[e.resource].transitions[e.transition];
            matches!(transition.action, Action::Out(_))
        };
        // In timed execution, the two sides of a transfer meet at an instant.
        let meets = match self.run.execution {
            Execution::Lockstep => None,
            Execution::Timed => event.iter().position(gives),
        };
        let times = self.clock.event(event, &durations, meets);
        let number = self.run.entries.last().map_or(0, |e| e.event + 1);
        for (entry, (start, end)) in event.iter().zip(times) {
            self.run.entries.push(Entry {
                event: number,
                start,
                end,
                ..entry.clone()
            });
        }
        Ok(())
    }
}
