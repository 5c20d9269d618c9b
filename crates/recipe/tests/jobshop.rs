//! Disjunctive scheduling: published job shops, and random ones against trying all orders.

mod support;

use linewright_recipe::jobshop::{Instance, Limits, Solution, Task, solve};
use support::jobs;
use support::random::Random;

/// Asserts that a solution is a schedule.
fn assert_schedule(instance: &Instance, solution: &Solution) {
    let end = |t: usize| solution.start[t] + instance.tasks[t].duration;
    for (number, task) in instance.tasks.iter().enumerate() {
        assert!(solution.start[number] >= task.release);
        assert!(end(number) + task.tail <= solution.makespan);
        for (before, lag) in &task.after {
            assert!(end(*before) + lag <= solution.start[number]);
        }
        for other in 0..number {
            let apart =
                end(other) <= solution.start[number] || end(number) <= solution.start[other];
            let same = task.machine.is_some() && instance.tasks[other].machine == task.machine;
            assert!(apart || !same, "{other} and {number}");
        }
    }
}

#[test]
fn published_job_shops_are_solved_to_proved_optimality() {
    // The others are solved as layouts and recipes in `floor.rs`, and in the long form.
    for (name, jobs, optimum) in jobs::published().into_iter().take(3) {
        let instance = Instance::job_shop(&jobs);
        let solution = solve(&instance, Limits::default());
        assert_schedule(&instance, &solution);
        println!("{name}: {} nodes", solution.nodes);
        assert_eq!(
            (solution.makespan, solution.lower_bound),
            (optimum, optimum),
            "{name}"
        );
    }
}

/// Returns the least makespan by appending tasks in every order.
fn exhaustive(instance: &Instance) -> i64 {
    fn append(
        instance: &Instance,
        end: &mut Vec<Option<i64>>,
        free: &mut Vec<i64>,
        best: &mut i64,
    ) {
        let done = end
            .iter()
            .zip(&instance.tasks)
            .filter_map(|(e, t)| Some((*e)? + t.tail));
        let makespan = done.max().unwrap_or(0);
        if makespan >= *best {
            return;
        }
        if end.iter().all(Option::is_some) {
            *best = makespan;
        }
        for (number, task) in instance.tasks.iter().enumerate() {
            if end[number].is_some() || task.after.iter().any(|(t, _)| end[*t].is_none()) {
                continue;
            }
            let ready = task
                .after
                .iter()
                .map(|(t, lag)| end[*t].expect("it is done") + lag);
            let mut start = ready.max().unwrap_or(0).max(task.release);
            let before = task.machine.map(|m| (m, free[m]));
            if let Some((machine, at)) = before {
                start = start.max(at);
                free[machine] = start + task.duration;
            }
            end[number] = Some(start + task.duration);
            append(instance, end, free, best);
            end[number] = None;
            if let Some((machine, at)) = before {
                free[machine] = at;
            }
        }
    }
    let mut best = i64::MAX;
    let mut end = vec![None; instance.tasks.len()];
    append(
        instance,
        &mut end,
        &mut vec![0; instance.machines],
        &mut best,
    );
    best
}

/// Returns a random instance of up to nine tasks with lags, releases and tails.
fn random_instance(random: &mut Random) -> Instance {
    let machines = 1 + random.below(3);
    let mut tasks: Vec<Task> = Vec::new();
    for _ in 0..=random.below(4) {
        for step in 0..=random.below(3) {
            if tasks.len() == 9 {
                break;
            }
            let number = tasks.len();
            let mut after = Vec::new();
            if step > 0 {
                after.push((number - 1, random.below(3) as i64));
            } else if number > 0 && random.percent(20) {
                after.push((random.below(number), 0));
            }
            let mut rarely = |most: usize| {
                if random.percent(25) {
                    random.below(most) as i64
                } else {
                    0
                }
            };
            let (release, tail) = (rarely(6), rarely(6));
            tasks.push(Task {
                machine: random.percent(85).then(|| random.below(machines)),
                duration: random.below(7) as i64,
                after,
                release,
                tail,
            });
        }
    }
    Instance { machines, tasks }
}

#[test]
fn random_instances_agree_with_an_exhaustive_search() {
    let mut random = Random(31);
    let mut branched = 0;
    for number in 0..1_500 {
        let instance = random_instance(&mut random);
        // Without moves, the branch and bound has more to do.
        let moves = [0, 200][number % 2];
        let solution = solve(
            &instance,
            Limits {
                moves,
                nodes: 100_000,
            },
        );
        assert_schedule(&instance, &solution);
        let least = exhaustive(&instance);
        assert_eq!(
            (solution.makespan, solution.lower_bound),
            (least, least),
            "{instance:?}"
        );
        branched += usize::from(solution.nodes > 0);
    }
    println!("{branched} needed a branch and bound");
    assert!(branched > 30);
}

#[test]
fn limits_leave_a_gap_that_is_stated() {
    let (_, jobs, optimum) = jobs::published().remove(0);
    let instance = Instance::job_shop(&jobs);
    let solution = solve(&instance, Limits { moves: 0, nodes: 1 });
    assert_schedule(&instance, &solution);
    assert!(solution.lower_bound <= optimum && optimum <= solution.makespan);
    assert!(solution.lower_bound < solution.makespan);
}

/// Measures job shops in a release build: each published one may take 60 s of CPU.
#[test]
#[ignore = "measures: cargo test --release -p linewright-recipe --test jobshop -- --ignored --nocapture"]
fn times_of_published_job_shops() {
    for (name, jobs, optimum) in jobs::published().into_iter().chain(jobs::hard()) {
        let start = std::time::Instant::now();
        let solution = solve(
            &Instance::job_shop(&jobs),
            Limits {
                nodes: 2_000_000,
                ..Limits::default()
            },
        );
        let taken = start.elapsed();
        println!(
            "{name}: {} (bound {}) in {taken:?}, {} nodes",
            solution.makespan, solution.lower_bound, solution.nodes
        );
        assert_eq!(
            (solution.makespan, solution.lower_bound),
            (optimum, optimum)
        );
    }
}
