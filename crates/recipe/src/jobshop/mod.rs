//! Disjunctive scheduling: tasks with precedences on machines that do one task at a time, and the
//! least makespan.
//!
//! This is the job shop problem in the notation of R. L. Graham et al., "Optimization and
//! approximation in deterministic sequencing and scheduling", Annals of Discrete Mathematics 5
//! (1979), 287-326, with time lags between tasks. Buffers have room for everything, and the ways
//! between machines take the lags. [`crate::plan`] uses it as a relaxation of a cell.
//!
//! 1. `local` finds a good schedule by priority rules and tabu search.
//! 2. `propagate` derives bounds of start times (edge finding).
//! 3. `branch` proves that no schedule is shorter, or finds a shorter one.
//!
//! All limits are counts, so the result is the same on every machine.

mod branch;
mod local;
mod propagate;

/// A task.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Task {
    /// Index of the machine; `None` if the task needs time only.
    pub machine: Option<usize>,
    /// Duration in any unit of time.
    pub duration: i64,
    /// Tasks that have to end before this one begins, with the minimum time between the two. Their
    /// indices are smaller than that of the task.
    pub after: Vec<(usize, i64)>,
    /// Minimum time from the beginning of the schedule to the task's start.
    pub release: i64,
    /// Minimum time from the end of the task to the end of the schedule.
    pub tail: i64,
}

/// Tasks on machines.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Instance {
    /// Number of machines.
    pub machines: usize,
    /// Tasks. Times are not negative, and their sum is below 2^60.
    pub tasks: Vec<Task>,
}

/// Limits of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of moves of the tabu search without an improvement.
    pub moves: usize,
    /// Maximum number of nodes of the branch and bound.
    pub nodes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            moves: 3_000,
            nodes: 100_000,
        }
    }
}

/// A schedule with a bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Solution {
    /// Start of each task.
    pub start: Vec<i64>,
    /// Time at which the last task and its tail end.
    pub makespan: i64,
    /// No schedule has a smaller makespan than this. The schedule is optimal if the two are equal.
    pub lower_bound: i64,
    /// Number of nodes of the branch and bound.
    pub nodes: usize,
}

impl Instance {
    /// Returns a job shop: for each job its tasks in their order, as machine and duration.
    pub fn job_shop(jobs: &[Vec<(usize, i64)>]) -> Self {
        let mut instance = Self::default();
        for job in jobs {
            for (at, (machine, duration)) in job.iter().enumerate() {
                let before = (at > 0).then(|| (instance.tasks.len() - 1, 0));
                instance.machines = instance.machines.max(machine + 1);
                instance.tasks.push(Task {
                    machine: Some(*machine),
                    duration: *duration,
                    after: before.into_iter().collect(),
                    ..Task::default()
                });
            }
        }
        instance
    }

    /// Returns the tasks of each machine.
    fn by_machine(&self) -> Vec<Vec<usize>> {
        let mut tasks = vec![Vec::new(); self.machines];
        for (number, task) in self.tasks.iter().enumerate() {
            if let Some(machine) = task.machine {
                tasks[machine].push(number);
            }
        }
        tasks
    }
}

/// Finds a schedule of least makespan, or a good one with a bound if the limits are reached.
///
/// The number of nodes is exponential in the number of tasks; each takes time proportional to the
/// square of the number of tasks of a machine, for each machine and round of propagation.
pub fn solve(instance: &Instance, limits: Limits) -> Solution {
    let lower_bound = propagate::root_bound(instance);
    let mut best = local::search(instance, lower_bound, limits.moves);
    best.lower_bound = lower_bound;
    if best.makespan > lower_bound {
        branch::improve(instance, &mut best, limits.nodes);
    }
    best
}
