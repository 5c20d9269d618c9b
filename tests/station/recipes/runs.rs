//! Runs that a machine coordinates: in lockstep they have the steps of the plan with the same
//! outcomes of tests; timed, each vector takes as long as its longest event.
//!
//! Least steps are least in the worst case, until a loop is closed. So there are cells in which the
//! plan has more steps after a loop, or makes a test later: few, and none of those of
//! [`super::cells::all`].

use super::cells::Made;
use crate::random_cells::set_times;
use linewright::engine::recipes::machine::run;
use linewright_recipe::model::{Action, Demand, Layout};
use linewright_recipe::plan::{Entry, Execution, Objective, Plan, PlanLimits, PlanOutcome, plan};
use linewright_recipe::run::{self as plans, Performance, Plant, Run};
use std::collections::BTreeMap;
use std::convert::Infallible;

/// Loops of a recipe after which a run ends.
const LOOPS: usize = 3;

/// Maximum number of runs of a machine.
const RUNS: usize = 60;

/// What was compared.
#[derive(Debug, Default)]
pub struct Counts {
    pub runs: usize,
    pub loops: usize,
    pub tests: usize,
    pub overruns: usize,
    /// Runs with other steps than the plan.
    pub others: usize,
    /// Machines whose worst case was compared with that of the plan with least time.
    pub timed: usize,
}

/// A plant that takes these outcomes of tests, then the first ones.
#[derive(Default)]
struct Scripted {
    outcomes: Vec<usize>,
    /// For each test, the transitions that were possible.
    asked: Vec<Vec<usize>>,
}

impl Plant for Scripted {
    type Error = Infallible;

    fn perform(&mut self, _: usize, _: usize) -> Result<Option<Performance>, Infallible> {
        Ok(None)
    }

    fn test(&mut self, _: usize, transitions: &[usize]) -> usize {
        let number = self.outcomes.get(self.asked.len()).copied().unwrap_or(0);
        self.asked.push(transitions.to_vec());
        transitions[number]
    }
}

/// A plant that takes these transitions after tests.
struct Following(std::vec::IntoIter<usize>);

impl Plant for Following {
    type Error = Infallible;

    fn perform(&mut self, _: usize, _: usize) -> Result<Option<Performance>, Infallible> {
        Ok(None)
    }

    fn test(&mut self, _: usize, transitions: &[usize]) -> usize {
        let next = self.0.next().expect("a test of the run");
        assert!(transitions.contains(&next));
        next
    }
}

/// Runs a machine with these outcomes.
fn by_machine(made: &Made, layout: &Layout, how: Execution, outcomes: &[usize]) -> (Run, Scripted) {
    let mut plant = Scripted {
        outcomes: outcomes.to_vec(),
        ..Scripted::default()
    };
    let run = run(layout, &made.recipe, &made.built, &mut plant, how, LOOPS);
    (run.expect("the machine is verified"), plant)
}

/// Runs with all outcomes of the tests, at most [`RUNS`].
fn all(made: &Made, layout: &Layout, how: Execution) -> Vec<(Vec<usize>, Run)> {
    let mut open = vec![Vec::new()];
    let mut found = Vec::new();
    while let Some(outcomes) = open.pop().filter(|_| found.len() < RUNS) {
        let (run, plant) = by_machine(made, layout, how, &outcomes);
        for at in outcomes.len()..plant.asked.len() {
            for other in 1..plant.asked[at].len() {
                let mut next = outcomes.clone();
                next.resize(at, 0);
                next.push(other);
                open.push(next);
            }
        }
        found.push((outcomes, run));
    }
    found
}

fn planned(made: &Made, layout: &Layout, objective: Objective) -> Option<Plan> {
    let demands = [Demand::new(made.recipe.clone(), 1)];
    match plan(layout, &demands, objective, PlanLimits::default()) {
        Ok(PlanOutcome::Planned(plan)) => Some(plan),
        _ => None,
    }
}

/// The value of a plan counts until a loop is closed.
fn counted(run: &Run) -> i64 {
    run.loops.first().copied().unwrap_or(run.time)
}

/// Compares the runs of a machine with those of the plan with least steps, and the times with those
/// of its vectors.
pub fn compare(made: &Made, seed: u64, counts: &mut Counts) {
    let least = planned(made, &made.layout, Objective::Steps).expect("a controller is a plan");
    let demands = [Demand::new(made.recipe.clone(), 1)];
    let timed = timed(made, seed);
    for (outcomes, run) in all(made, &made.layout, Execution::Lockstep) {
        assert!(run.overruns.is_empty());
        let taken: Vec<usize> = run.tests.iter().map(|t| t.transition).collect();
        let mut plant = Following(taken.into_iter());
        let Ok(follows) = plans::run(&made.layout, &demands, &least, &mut plant, LOOPS);
        assert_eq!(run.is_finished, follows.is_finished);
        let is_same = (run.time, &run.loops) == (follows.time, &follows.loops);
        let longer = by_machine(made, &timed, Execution::Timed, &outcomes).0;
        assert_eq!(longer.time, longest_events(&timed, &run));
        let again = by_machine(made, &timed, Execution::Timed, &outcomes).0;
        assert_eq!(longer, again);
        counts.runs += 1;
        counts.loops += usize::from(!run.loops.is_empty());
        counts.tests += usize::from(!run.tests.is_empty());
        counts.overruns += usize::from(!longer.overruns.is_empty());
        counts.others += usize::from(!is_same);
    }
}

/// Compares the worst case of a machine with that of the plans with least steps and least time, if
/// all its runs can be made.
pub fn compare_worst_cases(made: &Made, seed: u64, counts: &mut Counts) {
    let timed = timed(made, seed);
    let runs = |layout, how| {
        let runs = all(made, layout, how);
        (runs.len() < RUNS).then_some(runs)
    };
    let worst = |runs: &[(Vec<usize>, Run)]| runs.iter().map(|(_, run)| counted(run)).max();
    let (Some(in_steps), Some(in_time)) = (
        runs(&made.layout, Execution::Lockstep),
        runs(&timed, Execution::Timed),
    ) else {
        return;
    };
    let least = planned(made, &made.layout, Objective::Steps);
    assert_eq!(worst(&in_steps), least.map(|plan| plan.value));
    if let Some(least) = planned(made, &timed, Objective::Time)
        && in_time.iter().all(|(_, run)| run.overruns.is_empty())
    {
        assert!(worst(&in_time) >= Some(least.lower_bound));
        counts.timed += 1;
    }
}

/// The layout with random times.
fn timed(made: &Made, seed: u64) -> Layout {
    let mut timed = made.layout.clone();
    set_times(seed, &mut timed, false);
    timed
}

/// The sum of the longest durations of the events of each vector of a run in lockstep. A transfer
/// takes the time of both sides.
fn longest_events(timed: &Layout, run: &Run) -> i64 {
    let mut longest: BTreeMap<i64, i64> = BTreeMap::new();
    for event in run.entries.chunk_by(|a, b| a.event == b.event) {
        let transition = |e: &Entry| &timed.resources[e.resource].transitions[e.transition];
        let durations = event.iter().map(|e| transition(e).nanoseconds());
        let gives = |e: &Entry| matches!(transition(e).action, Action::Out(_));
        let duration = if event.iter().any(gives) {
            durations.sum()
        } else {
            durations.max().unwrap_or(0)
        };
        let vector = longest.entry(event[0].start).or_default();
        *vector = duration.max(*vector);
    }
    longest.values().sum()
}
