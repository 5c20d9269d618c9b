//! Runs of plans: with the durations of the layout, a run is the plan, whatever the outcomes of the
//! tests; with others, the order of the plan is kept.

mod support;

use linewright_recipe::model::{Action, Demand, Layout};
use linewright_recipe::plan::{
    Entry, EntrySubject, Execution, Objective, Plan, PlanLimits, PlanOutcome, plan,
};
use linewright_recipe::run::{Performance, Plant, Run, run};
use std::convert::Infallible;
use support::{pad, random};

const OBJECTIVES: [Objective; 2] = [Objective::Steps, Objective::Time];

fn planned(layout: &Layout, demands: &[Demand], objective: Objective) -> Option<Plan> {
    let limits = PlanLimits {
        nodes: 2_000,
        together: 2_000,
        ..PlanLimits::default()
    };
    match plan(layout, demands, objective, limits) {
        Ok(PlanOutcome::Planned(found)) => Some(found),
        Ok(_) => None,
        Err(problems) => panic!("{problems:?}"),
    }
}

/// A plant in which operations take longer, and which takes given outcomes, then the first ones.
struct Scripted<'a> {
    layout: &'a Layout,
    outcomes: Vec<usize>,
    /// For each test, the number of its possible outcomes.
    asked: Vec<usize>,
    delays: Option<random::Random>,
}

impl Plant for Scripted<'_> {
    type Error = Infallible;

    fn perform(&mut self, at: usize, number: usize) -> Result<Option<Performance>, Infallible> {
        let transition = &self.layout.resources[at].transitions[number];
        Ok(self.delays.as_mut().map(|random| Performance {
            nanoseconds: transition.nanoseconds() + random.below(3) as i64 * 700_000_000,
            microjoules: 1,
        }))
    }

    fn test(&mut self, _: usize, transitions: &[usize]) -> usize {
        let number = self.asked.len();
        self.asked.push(transitions.len());
        transitions[self.outcomes.get(number).copied().unwrap_or(0)]
    }
}

/// Runs a plan once for each way in which its first tests can end, at most 200 times.
fn runs(layout: &Layout, demands: &[Demand], plan: &Plan, tests: usize) -> Vec<Run> {
    let mut open = vec![Vec::new()];
    let mut runs = Vec::new();
    while let Some(outcomes) = open.pop() {
        let fixed = outcomes.len();
        let mut plant = Scripted {
            layout,
            outcomes,
            asked: Vec::new(),
            delays: None,
        };
        let Ok(made) = run(layout, demands, plan, &mut plant, 12);
        for at in fixed..plant.asked.len().min(tests) {
            for other in 1..plant.asked[at] {
                let mut outcomes = plant.outcomes.clone();
                outcomes.resize(at, 0);
                outcomes.push(other);
                open.push(outcomes);
            }
        }
        runs.push(made);
        if runs.len() == 200 {
            break;
        }
    }
    runs
}

/// The value of a plan counts until a loop is closed.
fn counted(run: &Run) -> i64 {
    run.loops.first().copied().unwrap_or(run.time)
}

#[test]
fn the_hinge_takes_the_time_of_its_plan() {
    for objective in OBJECTIVES {
        let mut layout = pad::layout(5);
        random::set_times(7, &mut layout, false);
        let demands = [Demand::new(pad::hinge(false), 1)];
        let plan = planned(&layout, &demands, objective).expect("it can be made");
        let all = runs(&layout, &demands, &plan, 4);
        assert_eq!(all.len(), 3, "vision fails, or force, or neither");
        let worst = all.iter().map(counted).max();
        assert_eq!(worst, Some(plan.value), "{objective:?}");
        for run in &all {
            assert!(run.is_finished && run.overruns.is_empty());
            assert_eq!(run.execution, objective.execution());
            assert_eq!(counted(run), run.time);
        }
    }
}

#[test]
fn runs_of_random_cells_take_the_time_of_their_plans() {
    let (mut plans, mut several, mut loops) = (0, 0, 0);
    for seed in 0..300 {
        let (mut layout, recipe) = random::cell(seed);
        random::set_times(seed, &mut layout, false);
        let demands = [Demand::new(recipe, 1 + usize::from(seed % 3 == 0))];
        for objective in OBJECTIVES {
            let Some(plan) = planned(&layout, &demands, objective) else {
                continue;
            };
            let all = runs(&layout, &demands, &plan, 5);
            let worst = all.iter().map(counted).max();
            if all.len() < 200 {
                assert_eq!(worst, Some(plan.value), "{seed} {objective:?}");
            }
            assert!(all.iter().all(|r| r.overruns.is_empty()), "{seed}");
            plans += 1;
            several += usize::from(all.len() > 1);
            loops += usize::from(all.iter().any(|r| !r.loops.is_empty()));
        }
    }
    println!("{plans} plans, {several} with tests, {loops} with loops");
    assert!(plans > 100 && several > 30 && loops > 10);
}

/// Asserts what holds of every run: a resource does one thing at a time, the operations of a step
/// begin together, and after those of the step before.
fn assert_order(layout: &Layout, products: usize, run: &Run) {
    for at in 0..layout.resources.len() {
        let own = run.entries.iter().filter(|e| e.resource == at);
        let own: Vec<&Entry> = own.collect();
        assert!(own.windows(2).all(|w| w[0].end <= w[1].start));
        for pair in own.windows(2) {
            let to = |e: &Entry| &layout.resources[at].transitions[e.transition];
            assert_eq!(to(pair[0]).to, to(pair[1]).from);
        }
    }
    for product in 0..products {
        let mut last: Option<(usize, i64, i64)> = None;
        for entry in &run.entries {
            match entry.subject {
                EntrySubject::Operation { product: p, .. } if p == product => {}
                _ => continue,
            }
            last = match last {
                Some((event, start, end)) if event == entry.event => {
                    assert_eq!(entry.start, start);
                    Some((event, start, end.max(entry.end)))
                }
                before => {
                    assert!(before.is_none_or(|b| b.2 <= entry.start));
                    Some((entry.event, entry.start, entry.end))
                }
            };
        }
    }
    for entry in &run.entries {
        let action = |e: &Entry| &layout.resources[e.resource].transitions[e.transition].action;
        if run.execution == Execution::Timed && matches!(action(entry), Action::Out(_)) {
            let mut others = run.entries.iter().filter(|e| e.event == entry.event);
            let taker = others.find(|e| matches!(action(e), Action::In(_)));
            assert_eq!(taker.map(|e| e.start), Some(entry.end));
        }
    }
}

#[test]
fn late_operations_make_a_run_late_and_keep_its_order() {
    let (mut late, mut overruns) = (0, 0);
    for seed in 0..300 {
        let (mut layout, recipe) = random::cell(seed);
        random::set_times(seed, &mut layout, false);
        let demands = [Demand::new(recipe, 2)];
        let Some(plan) = planned(&layout, &demands, Objective::Time) else {
            continue;
        };
        let outcomes: Vec<usize> = Vec::new();
        let plant = |delays| {
            let mut plant = Scripted {
                layout: &layout,
                outcomes: outcomes.clone(),
                asked: Vec::new(),
                delays,
            };
            let Ok(made) = run(&layout, &demands, &plan, &mut plant, 6);
            made
        };
        let on_time = plant(None);
        let delayed = plant(Some(random::Random(seed)));
        assert_order(&layout, 2, &on_time);
        assert_order(&layout, 2, &delayed);
        assert!(on_time.time <= delayed.time);
        let order = |run: &Run| -> Vec<(usize, usize)> {
            (run.entries.iter())
                .map(|e| (e.resource, e.transition))
                .collect()
        };
        assert_eq!(order(&on_time), order(&delayed));
        late += usize::from(on_time.time < delayed.time);
        overruns += usize::from(!delayed.overruns.is_empty());
    }
    println!("{late} late, {overruns} with resources that waited where they may not");
    assert!(late > 20 && overruns > 0);
}
