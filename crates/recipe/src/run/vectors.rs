//! Runs of vectors: a vector begins when all resources have ended the one before it.

use super::clock::Clock;
use super::{Plant, Run, Runner, TestResult};
use crate::model::Layout;
use crate::plan::{Entry, Execution};

/// A run of one product in vectors, which a controller coordinates.
///
/// All events of a vector begin with it: the steps of the product, internal operations and
/// transfers. In lockstep each takes one step. In timed execution a transfer takes the time of the
/// side that gives and then that of the side that takes, as in a plan, and the vector takes as long
/// as its longest event. A resource that has ended before waits until then.
pub struct Vectors<'a, P> {
    runner: Runner<'a, P>,
}

impl<'a, P: Plant> Vectors<'a, P> {
    /// Begins a run with these states of the resources.
    pub fn new(
        layout: &'a Layout,
        plant: &'a mut P,
        execution: Execution,
        states: &[usize],
    ) -> Self {
        let mut clock = Clock::new(layout, 1);
        clock.enter(states);
        let run = Run::new(execution);
        Self {
            runner: Runner {
                layout,
                plant,
                clock,
                run,
            },
        }
    }

    /// Carries out a vector. The times of the entries do not count.
    ///
    /// # Errors
    /// The plant's error, if an operation fails.
    pub fn perform(&mut self, events: &[Vec<Entry>]) -> Result<(), P::Error> {
        for event in events {
            self.runner.event(event)?;
        }
        self.runner.clock.rest(0);
        Ok(())
    }

    /// Tests the product between two vectors. Returns one of the transitions of its recipe.
    pub fn test(&mut self, transitions: &[usize]) -> usize {
        let transition = self.runner.plant.test(0, transitions);
        self.runner.run.tests.push(TestResult {
            time: self.runner.clock.base(),
            product: 0,
            transition,
            entries_before: self.runner.run.entries.len(),
        });
        transition
    }

    /// Notes that the product closed a loop of its recipe. Returns how many times it has.
    pub fn close_loop(&mut self) -> usize {
        let run = &mut self.runner.run;
        run.loops.push(self.runner.clock.base());
        run.loops.len()
    }

    /// Ends the run.
    pub fn end(self, is_finished: bool) -> Run {
        self.runner.end(is_finished)
    }
}
