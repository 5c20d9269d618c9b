//! Schedules by priority rules, improved by tabu search.
//!
//! A move swaps two tasks at the edge of a block of the critical path: E. Nowicki and C. Smutnicki,
//! "A fast taboo search algorithm for the job shop problem", Management Science 42 (1996), 797-813.
//! Moves are valued as proposed by É. Taillard, "Parallel taboo search techniques for the job shop
//! scheduling problem", ORSA Journal on Computing 6 (1994), 108-117. Ties are broken by order, so
//! there is no chance in it.

use super::{Instance, Solution};

/// Number of moves for which a swap may not be taken back, at least.
const TENURE: usize = 8;

/// Order of the tasks of each machine, with what follows from it.
struct Schedule<'i> {
    instance: &'i Instance,
    /// Tasks that need the end of each task, with lags.
    following: Vec<Vec<(usize, i64)>>,
    order: Vec<Vec<usize>>,
    /// Place of each task in the order of its machine.
    place: Vec<usize>,
    /// Length of the longest path before each task, and after its end.
    head: Vec<i64>,
    tail: Vec<i64>,
    makespan: i64,
}

impl<'i> Schedule<'i> {
    fn new(instance: &'i Instance, order: Vec<Vec<usize>>) -> Self {
        let mut following = vec![Vec::new(); instance.tasks.len()];
        for (number, task) in instance.tasks.iter().enumerate() {
            for (other, lag) in &task.after {
                following[*other].push((number, *lag));
            }
        }
        let count = instance.tasks.len();
        let mut schedule = Self {
            instance,
            following,
            order,
            place: vec![0; count],
            head: vec![0; count],
            tail: vec![0; count],
            makespan: 0,
        };
        schedule.evaluate();
        schedule
    }

    /// Returns the task before one on its machine.
    fn before(&self, task: usize) -> Option<usize> {
        let order = &self.order[self.instance.tasks[task].machine?];
        order.get(self.place[task].wrapping_sub(1)).copied()
    }

    /// Returns the task after one on its machine.
    fn after(&self, task: usize) -> Option<usize> {
        let order = &self.order[self.instance.tasks[task].machine?];
        order.get(self.place[task] + 1).copied()
    }

    /// Computes heads, tails and the makespan. Returns whether the order is free of circles.
    fn evaluate(&mut self) -> bool {
        let tasks = &self.instance.tasks;
        for order in &self.order {
            for (at, task) in order.iter().enumerate() {
                self.place[*task] = at;
            }
        }
        let mut missing: Vec<usize> = (0..tasks.len())
            .map(|t| tasks[t].after.len() + usize::from(self.before(t).is_some()))
            .collect();
        let mut sorted: Vec<usize> = (0..tasks.len()).filter(|t| missing[*t] == 0).collect();
        let mut done = 0;
        while let Some(task) = sorted.get(done).copied() {
            done += 1;
            let mut head = tasks[task].release;
            for (other, lag) in &tasks[task].after {
                head = head.max(self.head[*other] + tasks[*other].duration + lag);
            }
            if let Some(other) = self.before(task) {
                head = head.max(self.head[other] + tasks[other].duration);
            }
            self.head[task] = head;
            let next = self.following[task].iter().map(|f| f.0);
            for other in next.chain(self.after(task)) {
                missing[other] -= 1;
                if missing[other] == 0 {
                    sorted.push(other);
                }
            }
        }
        self.makespan = 0;
        for task in sorted.iter().rev().copied() {
            let mut tail = tasks[task].tail;
            for (other, lag) in &self.following[task] {
                tail = tail.max(lag + tasks[*other].duration + self.tail[*other]);
            }
            if let Some(other) = self.after(task) {
                tail = tail.max(tasks[other].duration + self.tail[other]);
            }
            self.tail[task] = tail;
            self.makespan = (self.makespan).max(self.head[task] + tasks[task].duration + tail);
        }
        sorted.len() == tasks.len()
    }

    /// Returns the swaps at the edges of the blocks of one critical path.
    fn swaps(&self) -> Vec<(usize, usize)> {
        let tasks = &self.instance.tasks;
        let is_critical =
            |t: &usize| self.head[*t] + tasks[*t].duration + self.tail[*t] == self.makespan;
        let mut path = Vec::new();
        let mut next =
            (0..tasks.len()).find(|t| is_critical(t) && self.head[*t] == tasks[*t].release);
        while let Some(task) = next {
            path.push(task);
            let end = self.head[task] + tasks[task].duration;
            let by_machine = self.after(task).filter(|t| self.head[*t] == end);
            let by_job = || {
                let fitting = self.following[task]
                    .iter()
                    .find(|(t, lag)| is_critical(t) && self.head[*t] == end + lag);
                fitting.map(|f| f.0)
            };
            next = by_machine.filter(is_critical).or_else(by_job);
        }
        let mut swaps = Vec::new();
        let mut from = 0;
        while from < path.len() {
            let machine = tasks[path[from]].machine;
            let mut to = from + 1;
            while to < path.len()
                && machine.is_some()
                && self.before(path[to]) == Some(path[to - 1])
            {
                to += 1;
            }
            let block = &path[from..to];
            if block.len() > 1 {
                // The first swap of the first block and the last of the last cannot help.
                if from > 0 || tasks[path[0]].release > 0 || block.len() == 2 {
                    swaps.push((block[0], block[1]));
                }
                if to < path.len() || tasks[block[block.len() - 1]].tail > 0 || from == 0 {
                    swaps.push((block[block.len() - 2], block[block.len() - 1]));
                }
            }
            from = to;
        }
        swaps.dedup();
        // A task that has to follow the other cannot be swapped with it.
        swaps.retain(|(a, b)| !self.must_follow(*a, *b));
        swaps
    }

    /// Returns whether the second task has to follow the first one through other tasks or directly.
    fn must_follow(&self, first: usize, second: usize) -> bool {
        self.following[first]
            .iter()
            .any(|(t, _)| *t == second || (*t < second && self.must_follow(*t, second)))
    }

    /// Returns an estimate of the makespan after a swap: the longest path through the two tasks.
    fn value(&self, first: usize, second: usize) -> i64 {
        let tasks = &self.instance.tasks;
        let head = |task: usize, before: Option<i64>| {
            let others = tasks[task].after.iter();
            let ends = others.map(|(t, lag)| self.head[*t] + tasks[*t].duration + lag);
            ends.chain(before)
                .max()
                .unwrap_or(0)
                .max(tasks[task].release)
        };
        let tail = |task: usize, after: Option<i64>| {
            let others = self.following[task].iter();
            let rests = others.map(|(t, lag)| lag + tasks[*t].duration + self.tail[*t]);
            rests.chain(after).max().unwrap_or(0).max(tasks[task].tail)
        };
        let before = self.before(first).map(|t| self.head[t] + tasks[t].duration);
        let after = self.after(second).map(|t| tasks[t].duration + self.tail[t]);
        let head_second = head(second, before);
        let head_first = head(first, Some(head_second + tasks[second].duration));
        let tail_first = tail(first, after);
        let tail_second = tail(second, Some(tail_first + tasks[first].duration));
        (head_second + tasks[second].duration + tail_second)
            .max(head_first + tasks[first].duration + tail_first)
    }

    fn swap(&mut self, first: usize, second: usize) -> bool {
        let machine = self.instance.tasks[first]
            .machine
            .expect("it has a machine");
        let (a, b) = (self.place[first], self.place[second]);
        self.order[machine].swap(a, b);
        self.evaluate()
    }
}

/// Priority rules: which of the tasks that could begin is the next.
#[derive(Clone, Copy)]
enum Rule {
    /// The one whose job has most work left.
    MostWork,
    /// The shortest one.
    Shortest,
    /// The longest one.
    Longest,
    /// The one that can begin first.
    Earliest,
}

/// Returns an active schedule's order: B. Giffler and G. L. Thompson, "Algorithms for solving
/// production-scheduling problems", Operations Research 8 (1960), 487-503.
fn dispatch(instance: &Instance, rule: Rule) -> Vec<Vec<usize>> {
    let tasks = &instance.tasks;
    let mut work = vec![0; tasks.len()];
    for task in (0..tasks.len()).rev() {
        work[task] += tasks[task].duration + tasks[task].tail;
        for (other, lag) in &tasks[task].after {
            work[*other] = work[*other].max(work[task] + lag);
        }
    }
    let mut end: Vec<Option<i64>> = vec![None; tasks.len()];
    let mut free = vec![0; instance.machines];
    let mut order = vec![Vec::new(); instance.machines];
    for _ in 0..tasks.len() {
        let start = |task: usize| {
            let mut start = tasks[task].release;
            for (other, lag) in &tasks[task].after {
                start = start.max(end[*other]? + lag);
            }
            Some(start.max(tasks[task].machine.map_or(0, |m| free[m])))
        };
        let ready: Vec<(usize, i64)> = (0..tasks.len())
            .filter(|t| end[*t].is_none())
            .filter_map(|t| Some((t, start(t)?)))
            .collect();
        let soonest = ready
            .iter()
            .min_by_key(|(t, s)| (s + tasks[*t].duration, *t));
        let (soonest, at) = *soonest.expect("precedences have no circle");
        let machine = tasks[soonest].machine;
        let limit = at + tasks[soonest].duration;
        let rivals = ready.iter().filter(|(t, s)| {
            *t == soonest || (machine.is_some() && tasks[*t].machine == machine && *s < limit)
        });
        let priority = |(task, start): &&(usize, i64)| match rule {
            Rule::MostWork => (-work[*task], *task),
            Rule::Shortest => (tasks[*task].duration, *task),
            Rule::Longest => (-tasks[*task].duration, *task),
            Rule::Earliest => (*start, *task),
        };
        let (task, at) = *rivals.min_by_key(priority).expect("there is one");
        end[task] = Some(at + tasks[task].duration);
        if let Some(machine) = tasks[task].machine {
            free[machine] = at + tasks[task].duration;
            order[machine].push(task);
        }
    }
    order
}

/// Finds a good schedule. Stops when the makespan is the bound, or after a number of moves without
/// an improvement.
pub(super) fn search(instance: &Instance, bound: i64, max_moves: usize) -> Solution {
    let rules = [
        Rule::MostWork,
        Rule::Earliest,
        Rule::Shortest,
        Rule::Longest,
    ];
    let mut best: Option<Solution> = None;
    for rule in rules {
        let mut schedule = Schedule::new(instance, dispatch(instance, rule));
        keep(&mut best, &schedule);
        let mut own = schedule.makespan;
        // For each pair, the move until which it may not be swapped.
        let mut tabu: Vec<(usize, usize, usize)> = Vec::new();
        let (mut number, mut last) = (0, 0);
        while own > bound && number - last < max_moves {
            number += 1;
            tabu.retain(|t| t.2 > number);
            let choices = schedule.swaps();
            let chosen = (choices.iter().copied())
                .map(|(a, b)| (schedule.value(a, b), a, b))
                .filter(|(value, a, b)| {
                    *value < own || !tabu.iter().any(|t| (t.0, t.1) == (*a, *b))
                })
                .min();
            // If all are forbidden, the oldest prohibition is lifted.
            let Some((_, a, b)) = chosen.or_else(|| {
                let age = |(a, b): &(usize, usize)| {
                    let found = tabu.iter().find(|t| (t.0, t.1) == (*a, *b));
                    found.map_or(0, |t| t.2)
                };
                let (a, b) = choices.iter().copied().min_by_key(age)?;
                Some((0, a, b))
            }) else {
                break;
            };
            if !schedule.swap(a, b) {
                // A longer way joins the two, which the swap would make a circle.
                schedule.swap(b, a);
                tabu.push((a, b, number + max_moves));
                continue;
            }
            tabu.push((b, a, number + TENURE + number % 7));
            if schedule.makespan < own {
                own = schedule.makespan;
                last = number;
                keep(&mut best, &schedule);
            }
        }
    }
    best.expect("there are rules")
}

fn keep(best: &mut Option<Solution>, schedule: &Schedule<'_>) {
    if (best.as_ref()).is_none_or(|b| schedule.makespan < b.makespan) {
        *best = Some(Solution {
            start: schedule.head.clone(),
            makespan: schedule.makespan,
            lower_bound: 0,
            nodes: 0,
        });
    }
}
