//! Bounds of start times: precedences, pairs of tasks, and edge finding.
//!
//! Edge finding is due to J. Carlier and E. Pinson, "An algorithm for solving the job-shop
//! problem", Management Science 35 (1989), 164-176. The form with two nested loops is that of W.
//! Nuijten (1994) as given in P. Baptiste, C. Le Pape and W. Nuijten, "Constraint-Based Scheduling"
//! (2001), section 2.2. The bound at the root is destructive: R. Klein and A. Scholl, "Computing
//! lower bounds by destructive improvement", EJOR 112 (1999), 322-346.

use super::Instance;

/// What is known of each task.
#[derive(Clone)]
pub(super) struct Domain {
    /// Earliest start.
    pub earliest: Vec<i64>,
    /// Latest end.
    pub latest: Vec<i64>,
}

/// The tables of an instance.
pub(super) struct Propagator<'i> {
    pub instance: &'i Instance,
    /// Tasks of each machine.
    pub tasks: Vec<Vec<usize>>,
    /// Buffers of edge finding.
    sorted: Vec<usize>,
    gain: Vec<i64>,
    reversed: Domain,
}

/// Stands for no bound.
const NONE: i64 = i64::MIN / 4;

impl<'i> Propagator<'i> {
    pub fn new(instance: &'i Instance) -> Self {
        Self {
            instance,
            tasks: instance.by_machine(),
            sorted: Vec::new(),
            gain: Vec::new(),
            reversed: Domain {
                earliest: Vec::new(),
                latest: Vec::new(),
            },
        }
    }

    /// Returns the domain in which only the makespan is bounded.
    pub fn initial(&self, makespan: i64) -> Domain {
        let tasks = &self.instance.tasks;
        Domain {
            earliest: tasks.iter().map(|t| t.release).collect(),
            latest: tasks.iter().map(|t| makespan - t.tail).collect(),
        }
    }

    /// Narrows a domain until nothing changes. `before` holds decided pairs of tasks. Returns
    /// whether a schedule may exist.
    pub fn narrow(&mut self, domain: &mut Domain, before: &[(u32, u32)]) -> bool {
        loop {
            let mut changed = false;
            if !self.precede(domain, before) {
                return false;
            }
            for machine in 0..self.tasks.len() {
                let tasks = std::mem::take(&mut self.tasks[machine]);
                let result = self.narrow_machine(domain, &tasks);
                self.tasks[machine] = tasks;
                match result {
                    None => return false,
                    Some(narrowed) => changed |= narrowed,
                }
            }
            if !changed {
                return true;
            }
        }
    }

    /// Applies the precedences and the decided pairs.
    fn precede(&self, domain: &mut Domain, before: &[(u32, u32)]) -> bool {
        let tasks = &self.instance.tasks;
        loop {
            for (number, task) in tasks.iter().enumerate() {
                for (other, lag) in &task.after {
                    let end = domain.earliest[*other] + tasks[*other].duration + lag;
                    domain.earliest[number] = domain.earliest[number].max(end);
                }
            }
            for (number, task) in tasks.iter().enumerate().rev() {
                for (other, lag) in &task.after {
                    let start = domain.latest[number] - task.duration - lag;
                    domain.latest[*other] = domain.latest[*other].min(start);
                }
            }
            let mut changed = false;
            for (first, second) in before {
                let (first, second) = (*first as usize, *second as usize);
                let end = domain.earliest[first] + tasks[first].duration;
                if domain.earliest[second] < end {
                    domain.earliest[second] = end;
                    changed = true;
                }
                let start = domain.latest[second] - tasks[second].duration;
                if domain.latest[first] > start {
                    domain.latest[first] = start;
                    changed = true;
                }
            }
            // Beyond its latest end a task would rise for ever if the decided pairs are circular.
            let fits =
                |(n, t): (usize, &super::Task)| domain.earliest[n] + t.duration <= domain.latest[n];
            if !tasks.iter().enumerate().all(fits) {
                return false;
            }
            if !changed {
                return true;
            }
        }
    }

    /// Applies pairs and edge finding to one machine. Returns whether something changed; `None` if
    /// there is no schedule.
    fn narrow_machine(&mut self, domain: &mut Domain, tasks: &[usize]) -> Option<bool> {
        let duration = |t: usize| self.instance.tasks[t].duration;
        let mut changed = false;
        for (at, first) in tasks.iter().enumerate() {
            for second in &tasks[at + 1..] {
                for (a, b) in [(*first, *second), (*second, *first)] {
                    // If b cannot precede a, then a precedes b.
                    if domain.earliest[b] + duration(b) + duration(a) > domain.latest[a] {
                        let end = domain.earliest[a] + duration(a);
                        if domain.earliest[b] < end {
                            domain.earliest[b] = end;
                            changed = true;
                        }
                        let start = domain.latest[b] - duration(b);
                        if domain.latest[a] > start {
                            domain.latest[a] = start;
                            changed = true;
                        }
                        if domain.earliest[a] + duration(a) > domain.latest[a]
                            || domain.earliest[b] + duration(b) > domain.latest[b]
                        {
                            return None;
                        }
                    }
                }
            }
        }
        changed |= self.find_edges(domain, tasks)?;
        // The same in reversed time.
        let mut reversed = std::mem::replace(
            &mut self.reversed,
            Domain {
                earliest: Vec::new(),
                latest: Vec::new(),
            },
        );
        reversed.earliest.clear();
        reversed.earliest.extend(domain.latest.iter().map(|l| -l));
        reversed.latest.clear();
        reversed.latest.extend(domain.earliest.iter().map(|e| -e));
        let found = self.find_edges(&mut reversed, tasks);
        for task in tasks {
            domain.latest[*task] = -reversed.earliest[*task];
        }
        self.reversed = reversed;
        Some(changed | found?)
    }

    /// Raises the earliest starts of tasks that have to follow a set of others.
    fn find_edges(&mut self, domain: &mut Domain, tasks: &[usize]) -> Option<bool> {
        let duration = |t: usize| self.instance.tasks[t].duration;
        self.sorted.clear();
        self.sorted.extend_from_slice(tasks);
        self.sorted.sort_by_key(|t| (domain.earliest[*t], *t));
        let count = self.sorted.len();
        let mut raised: Vec<(usize, i64)> = Vec::new();
        for last in tasks {
            let deadline = domain.latest[*last];
            self.gain.clear();
            self.gain.resize(count + 1, NONE);
            // Work of the set, and the end of the set from each task on.
            let (mut work, mut end) = (0, NONE);
            for at in (0..count).rev() {
                let task = self.sorted[at];
                if domain.latest[task] <= deadline {
                    work += duration(task);
                    end = end.max(domain.earliest[task] + work);
                }
                self.gain[at] = end;
            }
            if end > deadline {
                return None;
            }
            let mut begun = NONE;
            for at in 0..count {
                let task = self.sorted[at];
                if domain.latest[task] <= deadline {
                    begun = begun.max(domain.earliest[task] + work);
                    work -= duration(task);
                    continue;
                }
                // The task precedes neither those of the set that follow it here, nor all of it.
                if work > 0 && domain.earliest[task] + work + duration(task) > deadline {
                    raised.push((task, self.gain[at]));
                }
                if begun + duration(task) > deadline {
                    raised.push((task, end));
                }
            }
        }
        let mut changed = false;
        for (task, bound) in raised {
            if domain.earliest[task] < bound {
                domain.earliest[task] = bound;
                changed = true;
                if bound + duration(task) > domain.latest[task] {
                    return None;
                }
            }
        }
        Some(changed)
    }
}

/// Returns a lower bound of the makespan: the least for which nothing is refuted.
pub(super) fn root_bound(instance: &Instance) -> i64 {
    let mut propagator = Propagator::new(instance);
    let mut may_exist = |makespan: i64| {
        let mut domain = propagator.initial(makespan);
        propagator.narrow(&mut domain, &[])
    };
    let all = instance.tasks.iter();
    let mut high: i64 = all
        .map(|t| t.release + t.duration + t.tail + t.after.iter().map(|a| a.1).sum::<i64>())
        .sum();
    let mut low = 0;
    while low < high {
        let middle = low + (high - low) / 2;
        if may_exist(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}
