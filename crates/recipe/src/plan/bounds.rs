//! Lower bounds of what remains to be done.
//!
//! Time: each product needs at least the durations of its steps and of the ways between them, and
//! each resource at least the work that only it can do, and its share of the ways. Other costs:
//! the sum over the steps and the ways. Ways are shortest paths in the graph of transfers, without
//! regard to the states of resources, so that no plan has shorter ones.

use super::Objective;
use super::shop::Shop;
use super::state::{PLACE, State};
use crate::jobshop::Task;
use crate::model::Action;
use crate::realize::cell::{Call, Work};

/// Stands for a way that does not exist.
const NEVER: i64 = i64::MAX / 8;
/// Maximum number of resources for which the share of each in the ways is computed.
const MAX_RESOURCES: usize = 24;

/// For each demand, transition and number of steps performed: the least rest.
type Table = Vec<Vec<Vec<i64>>>;

/// Least costs of what is left of a recipe.
struct Rest {
    /// Until an end, or until a loop is closed.
    all: Table,
    /// Until an end, if the tests never make the recipe close a loop; [`NEVER`] if it has to.
    open: Table,
}

/// A cost that adds up over a plan.
struct Metric {
    /// The resource whose time is counted, if it is time.
    resource: Option<usize>,
    /// Least cost of a way between two resources.
    way: Vec<i64>,
    rest: Rest,
}

/// Tables of bounds.
pub(super) struct Bounds {
    resources: usize,
    objective: Objective,
    /// Least time of a way between two resources.
    way: Vec<i64>,
    /// Least times.
    rest: Rest,
    /// Whether there are several products, and recipes with loops. Then the first loop that is
    /// closed ends the count, and the other products may be anywhere.
    has_loops: bool,
    metrics: Vec<Metric>,
    /// Number of transfers. It only decides between equal bounds.
    transfers: Metric,
    /// For each demand, transition and number of steps performed: parts that are needed later, each
    /// with the resources that can need it first.
    uses: Vec<Vec<Vec<Uses>>>,
    /// For each demand and part, whether there is never more than one of it for a product.
    single: Vec<Vec<bool>>,
}

/// Parts, each with the resources that can need it first.
type Uses = Vec<(u16, Vec<u16>)>;

/// Returns the resources that can perform an operation.
fn performers(call: &Call) -> Vec<u16> {
    let mut all: Vec<u16> = call.performers.iter().map(|p| p.1.resource).collect();
    all.sort_unstable();
    all.dedup();
    all
}

impl Bounds {
    pub fn new(shop: &Shop<'_>, objective: Objective) -> Self {
        let resources = shop.resources();
        let ticks = |r: usize, t: usize| shop.ticks[r][t];
        let way = ways(shop, &ticks, shop.execution == super::Execution::Lockstep);
        let mut bounds = Self {
            resources,
            objective,
            rest: Rest {
                all: Vec::new(),
                open: Vec::new(),
            },
            has_loops: shop.slots.len() > 1
                && shop
                    .cells
                    .iter()
                    .any(|c| c.works.iter().any(|w| w.closes_loop)),
            metrics: Vec::new(),
            transfers: Metric {
                resource: None,
                way: Vec::new(),
                rest: Rest {
                    all: Vec::new(),
                    open: Vec::new(),
                },
            },
            uses: uses(shop),
            single: (0..shop.demands.len()).map(|d| single(shop, d)).collect(),
            way,
        };
        bounds.rest = Rest {
            all: bounds.time_rest(shop, true),
            open: bounds.time_rest(shop, false),
        };
        bounds.transfers = bounds.metric(shop, None, &|r, t| {
            let action = &shop.layout.resources[r].transitions[t].action;
            i64::from(matches!(action, Action::Out(_)))
        });
        bounds.metrics = match objective {
            Objective::Steps | Objective::Time => (0..resources.min(MAX_RESOURCES))
                .map(|own| {
                    let ticks = |r: usize, t: usize| if r == own { shop.ticks[r][t] } else { 0 };
                    bounds.metric(shop, Some(own), &ticks)
                })
                .collect(),
            Objective::Energy => vec![bounds.metric(shop, None, &|r, t| shop.energy[r][t])],
            Objective::Transfers => Vec::new(),
        };
        bounds
    }

    fn metric(
        &self,
        shop: &Shop<'_>,
        resource: Option<usize>,
        cost: &dyn Fn(usize, usize) -> i64,
    ) -> Metric {
        let way = ways(shop, cost, false);
        let rest = Rest {
            all: self.cost_rest(shop, &way, cost, true),
            open: self.cost_rest(shop, &way, cost, false),
        };
        Metric {
            resource,
            way,
            rest,
        }
    }

    /// Returns the least way between two sets of resources.
    fn between(&self, way: &[i64], from: &[u16], to: &[u16]) -> i64 {
        let pairs = from.iter().flat_map(|a| to.iter().map(move |b| (*a, *b)));
        let each = pairs.map(|(a, b)| way[a as usize * self.resources + b as usize]);
        each.min().unwrap_or(NEVER)
    }

    fn time_rest(&self, shop: &Shop<'_>, with_loops: bool) -> Table {
        let of = |demand: usize| {
            let cell = &shop.cells[demand];
            let rest = |number: usize, after: i64| {
                let steps = &cell.works[number].steps;
                let from = |begin: usize| {
                    let mut end = vec![0; steps.len() + 1];
                    for at in begin..steps.len() {
                        let mut start = if at > begin { end[at - 1] } else { 0 };
                        let mut longest = 0;
                        for call in &steps[at] {
                            let able = performers(call);
                            for input in &call.inputs {
                                if let Some(last) = last_touch(steps, *input, at)
                                    && last.0 >= begin
                                    && self.single[demand][*input as usize]
                                {
                                    let way = self.between(&self.way, &last.1, &able);
                                    start = start.max(end[last.0] + way);
                                }
                            }
                            let own = call.performers.iter();
                            let least = own.map(|p| {
                                shop.ticks[p.1.resource as usize][p.1.transition as usize]
                            });
                            longest = longest.max(least.min().unwrap_or(NEVER));
                        }
                        end[at] = (start + longest).min(NEVER);
                    }
                    let last = if begin < steps.len() {
                        end[steps.len() - 1]
                    } else {
                        0
                    };
                    (last + after).min(NEVER)
                };
                (0..=steps.len()).map(from).collect()
            };
            backward(cell, with_loops, rest)
        };
        (0..shop.demands.len()).map(of).collect()
    }

    fn cost_rest(
        &self,
        shop: &Shop<'_>,
        way: &[i64],
        cost: &dyn Fn(usize, usize) -> i64,
        with_loops: bool,
    ) -> Table {
        let of = |demand: usize| {
            let cell = &shop.cells[demand];
            let rest = |number: usize, after: i64| {
                let steps = &cell.works[number].steps;
                let from = |begin: usize| {
                    let mut total = after;
                    for (at, step) in steps.iter().enumerate().skip(begin) {
                        for call in step {
                            let able = performers(call);
                            let own = call.performers.iter();
                            let least =
                                own.map(|p| cost(p.1.resource as usize, p.1.transition as usize));
                            total = (total + least.min().unwrap_or(NEVER)).min(NEVER);
                            for input in &call.inputs {
                                if let Some(last) = last_touch(steps, *input, at)
                                    && last.0 >= begin
                                    && self.single[demand][*input as usize]
                                {
                                    total = (total + self.between(way, &last.1, &able)).min(NEVER);
                                }
                            }
                        }
                    }
                    total
                };
                (0..=steps.len()).map(from).collect()
            };
            backward(cell, with_loops, rest)
        };
        (0..shop.demands.len()).map(of).collect()
    }

    /// Returns what is left of a slot's product at least, in the worst case over the tests.
    fn rest_of(shop: &Shop<'_>, slot: usize, table: &Table, words: &[u16]) -> i64 {
        let demand = shop.slots[slot].1;
        let (first, second) = (words[2 * slot] as usize, words[2 * slot + 1]);
        if second == PLACE {
            let place = &shop.cell(slot).recipe_states[first];
            let each = place.leaving.iter().map(|w| table[demand][*w as usize][0]);
            return greatest(each, place.is_end);
        }
        let steps = table[demand]
            .get(first)
            .and_then(|row| row.get(second as usize));
        steps.copied().unwrap_or(0)
    }

    /// Returns the parts of a slot's product that have to be somewhere else: the part, the resource
    /// that holds it, and those that need it.
    fn ways_to_go<'b>(
        &'b self,
        shop: &Shop<'_>,
        slot: usize,
        words: &'b [u16],
    ) -> Vec<(u16, u16, &'b [u16])> {
        let demand = shop.slots[slot].1;
        let (first, second) = (words[2 * slot] as usize, words[2 * slot + 1] as usize);
        let Some(uses) = self.uses[demand].get(first).and_then(|u| u.get(second)) else {
            return Vec::new();
        };
        let way = |pair: &[u16]| {
            let part = shop.own_part(slot, pair[1])?;
            let (_, able) = uses.iter().find(|u| u.0 == part)?;
            self.single[demand][part as usize].then_some((part, pair[0], able.as_slice()))
        };
        shop.held(words).chunks_exact(2).filter_map(way).collect()
    }

    /// Returns the earliest time at which a slot's next step can begin.
    fn begin(&self, shop: &Shop<'_>, slot: usize, state: &State) -> i64 {
        let low = |variable: u16| state.zone.low[variable as usize];
        let mut begin = low(shop.ready_variable(slot));
        let (first, second) = (state.words[2 * slot] as usize, state.words[2 * slot + 1]);
        if second == PLACE {
            return begin;
        }
        let work = shop.cell(slot).works.get(first);
        let Some(step) = work.and_then(|w| w.steps.get(second as usize)) else {
            return begin;
        };
        for (part, at, able) in self.ways_to_go(shop, slot, &state.words) {
            if step.iter().any(|c| c.inputs.contains(&part)) {
                begin = begin.max(low(at) + self.between(&self.way, &[at], able));
            }
        }
        begin
    }

    /// Returns a lower bound of the objective over all plans from a state, where `spent` is what it
    /// has cost so far. Time is counted from the zero of the state's times.
    pub fn least(&self, shop: &Shop<'_>, state: &State, spent: i64) -> i64 {
        let is_time = self.objective.is_time();
        let latest = || state.zone.low.iter().copied().max().unwrap_or(0);
        let base = if is_time { latest() } else { spent };
        let slots = 0..shop.slots.len();
        // Products that have to close a loop end the count.
        let closes = |slot: &usize| {
            self.has_loops && Self::rest_of(shop, *slot, &self.rest.open, &state.words) >= NEVER
        };
        let closing: Vec<usize> = slots.clone().filter(closes).collect();
        if !closing.is_empty() {
            let each = closing.iter().map(|slot| {
                if is_time {
                    let rest = Self::rest_of(shop, *slot, &self.rest.all, &state.words);
                    return self.begin(shop, *slot, state) + rest;
                }
                let metric = self.metrics.first().unwrap_or(&self.transfers);
                spent + self.sum(shop, *slot, metric, true, &state.words)
            });
            return base.max(each.min().unwrap_or(0)).min(NEVER);
        }
        let with_loops = !self.has_loops;
        let mut most = base;
        let transfers = (self.objective == Objective::Transfers).then_some(&self.transfers);
        if is_time {
            let table = if with_loops {
                &self.rest.all
            } else {
                &self.rest.open
            };
            for slot in slots.clone() {
                let rest = Self::rest_of(shop, slot, table, &state.words);
                most = most.max(self.begin(shop, slot, state) + rest);
            }
        }
        for metric in self.metrics.iter().chain(transfers) {
            let each = slots.clone();
            let each = each.map(|slot| self.sum(shop, slot, metric, with_loops, &state.words));
            let sum = each.fold(0, |a, b| (a + b).min(NEVER));
            match metric.resource {
                None => most += sum,
                Some(resource) if sum > 0 => most = most.max(state.zone.low[resource] + sum),
                Some(_) => {}
            }
        }
        most.min(NEVER)
    }

    /// Returns the number of transfers that are left at least.
    pub fn transfers_left(&self, shop: &Shop<'_>, state: &State) -> i64 {
        let of = |slot| self.sum(shop, slot, &self.transfers, true, &state.words);
        (0..shop.slots.len())
            .map(of)
            .fold(0, |a, b| (a + b).min(NEVER))
    }

    /// Returns what a slot's product still costs at least.
    fn sum(
        &self,
        shop: &Shop<'_>,
        slot: usize,
        metric: &Metric,
        with_loops: bool,
        words: &[u16],
    ) -> i64 {
        let table = if with_loops {
            &metric.rest.all
        } else {
            &metric.rest.open
        };
        let mut sum = Self::rest_of(shop, slot, table, words);
        for (_, at, able) in self.ways_to_go(shop, slot, words) {
            sum += self.between(&metric.way, &[at], able);
        }
        sum.min(NEVER)
    }
}

impl Bounds {
    /// Returns the steps of a product as tasks, with the least times of the ways between them. Each
    /// operation that only one resource can perform needs it.
    pub fn tasks(&self, shop: &Shop<'_>, slot: usize, steps: &[&[Call]], tasks: &mut Vec<Task>) {
        let demand = shop.slots[slot].1;
        // The first task of each step.
        let mut first = Vec::new();
        for (at, step) in steps.iter().enumerate() {
            first.push(tasks.len());
            for call in *step {
                let able = performers(call);
                let mut after = Vec::new();
                if at > 0 {
                    after.extend((first[at - 1]..first[at]).map(|task| (task, 0)));
                }
                for input in &call.inputs {
                    if let Some(last) = last_touch(steps, *input, at)
                        && self.single[demand][*input as usize]
                    {
                        let way = self.between(&self.way, &last.1, &able);
                        let makes = |c: &Call| c.outputs.contains(input);
                        let maker = steps[last.0].iter().position(makes);
                        after.extend(maker.map(|call| (first[last.0] + call, way)));
                    }
                }
                let ticks = call.performers.iter();
                let ticks =
                    ticks.map(|p| shop.ticks[p.1.resource as usize][p.1.transition as usize]);
                let [only] = able[..] else {
                    tasks.push(Task {
                        machine: None,
                        duration: ticks.min().unwrap_or(0),
                        after,
                        ..Task::default()
                    });
                    continue;
                };
                tasks.push(Task {
                    machine: Some(only as usize),
                    duration: ticks.min().unwrap_or(0),
                    after,
                    ..Task::default()
                });
            }
        }
    }

    /// Returns a lower bound of the end of a product's next step.
    pub fn step_end(&self, shop: &Shop<'_>, state: &State, slot: usize) -> i64 {
        let low = |variable: u16| state.zone.low[variable as usize];
        let (work, step) = (state.words[2 * slot], state.words[2 * slot + 1]);
        let held = shop.held(&state.words);
        let calls = &shop.cell(slot).works[work as usize].steps[step as usize];
        let mut begin = low(shop.ready_variable(slot));
        let mut longest = 0;
        for call in calls {
            let kinds = shop.resolve(slot, &call.inputs, held);
            let each = call.performers.iter().map(|(_, taken)| {
                let resource = taken.resource;
                let mut begin = low(resource);
                for kind in &kinds {
                    let places = held.chunks_exact(2).filter(|p| p[1] == *kind);
                    let ways =
                        places.map(|p| low(p[0]) + self.between(&self.way, &[p[0]], &[resource]));
                    begin = begin.max(ways.min().unwrap_or(NEVER));
                }
                let ticks = shop.ticks[resource as usize][taken.transition as usize];
                (begin, ticks)
            });
            let all: Vec<(i64, i64)> = each.collect();
            begin = begin.max(all.iter().map(|a| a.0).min().unwrap_or(NEVER));
            longest = longest.max(all.iter().map(|a| a.1).min().unwrap_or(0));
        }
        (begin + longest).min(NEVER)
    }
}

/// Returns whether a bound says that there is no plan at all.
pub(super) fn is_never(bound: i64) -> bool {
    bound >= NEVER
}

/// Returns the step before `at` that makes the part which is needed there, and the resources that
/// can perform it.
fn last_touch(steps: &[impl AsRef<[Call]>], part: u16, at: usize) -> Option<(usize, Vec<u16>)> {
    for step in (0..at).rev() {
        let calls = steps[step].as_ref();
        let makes = calls.iter().filter(|c| c.outputs.contains(&part));
        let able: Vec<u16> = makes.flat_map(performers).collect();
        if !able.is_empty() {
            return Some((step, able));
        }
        // If it is gone, stock replaces it.
        if calls.iter().any(|c| c.inputs.contains(&part)) {
            return None;
        }
    }
    None
}

/// Returns for each part of a recipe whether a product never has more than one of it.
fn single(shop: &Shop<'_>, demand: usize) -> Vec<bool> {
    let (cell, recipe) = (&shop.cells[demand], &shop.demands[demand].recipe);
    let count = recipe.parts.len();
    // The most that there can be in each state of the recipe, counted up to 2.
    let held = |p: &crate::model::Part| {
        let all = shop.layout.resources.iter().flat_map(|r| &r.holds);
        all.filter(|h| **h == p.name).count().min(2)
    };
    let mut most = vec![vec![0; count]; cell.recipe_states.len()];
    most[cell.start as usize] = recipe.parts.iter().map(held).collect();
    let mut is_single: Vec<bool> = most[cell.start as usize].iter().map(|n| *n < 2).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for state in 0..most.len() {
            for work in &cell.recipe_states[state].leaving {
                let work = &cell.works[*work as usize];
                let mut now = most[state].clone();
                for step in &work.steps {
                    for input in step.iter().flat_map(|c| &c.inputs) {
                        let left = &mut now[*input as usize];
                        *left = usize::saturating_sub(*left, 1);
                    }
                    for output in step.iter().flat_map(|c| &c.outputs) {
                        let left = &mut now[*output as usize];
                        *left = (*left + 1).min(2);
                        is_single[*output as usize] &= *left < 2;
                    }
                }
                for (old, new) in most[work.to as usize].iter_mut().zip(now) {
                    changed |= new > *old;
                    *old = new.max(*old);
                }
            }
        }
    }
    is_single
}

/// Returns the greatest rest over the outcomes of a test that are not [`NEVER`].
fn greatest(each: impl Iterator<Item = i64>, is_end: bool) -> i64 {
    let most = each.filter(|rest| *rest < NEVER).max();
    most.unwrap_or(if is_end { 0 } else { NEVER })
}

/// Evaluates the transitions of a recipe from its ends, or from the transitions that close loops.
fn backward(
    cell: &crate::realize::cell::Cell,
    with_loops: bool,
    rest: impl Fn(usize, i64) -> Vec<i64>,
) -> Vec<Vec<i64>> {
    let mut table: Vec<Vec<i64>> = vec![Vec::new(); cell.works.len()];
    let after = |table: &[Vec<i64>], work: &Work| -> Option<i64> {
        if work.closes_loop {
            return Some(if with_loops { 0 } else { NEVER });
        }
        let to = &cell.recipe_states[work.to as usize];
        let each = to
            .leaving
            .iter()
            .map(|w| table[*w as usize].first().copied());
        let each: Option<Vec<i64>> = each.collect();
        Some(greatest(each?.into_iter(), to.is_end))
    };
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for number in (0..cell.works.len()).rev() {
            if table[number].is_empty()
                && let Some(after) = after(&table, &cell.works[number])
            {
                table[number] = rest(number, after);
                changed = true;
            }
        }
    }
    // What is in a circle of the recipe that nothing enters is never used.
    for (number, row) in table.iter_mut().enumerate() {
        row.resize(cell.works[number].steps.len() + 1, 0);
    }
    table
}

/// Returns the first use of each part after some steps of each transition.
fn uses(shop: &Shop<'_>) -> Vec<Vec<Vec<Uses>>> {
    let of_work = |work: &Work| {
        let from = |begin: usize| {
            let mut found: Vec<(u16, Vec<u16>)> = Vec::new();
            // Parts that are made after `begin` are not the ones that exist now.
            let mut made: Vec<u16> = Vec::new();
            for step in &work.steps[begin..] {
                for call in step {
                    let able = performers(call);
                    for input in &call.inputs {
                        if !made.contains(input) && !found.iter().any(|f| f.0 == *input) {
                            found.push((*input, able.clone()));
                        }
                    }
                }
                made.extend(step.iter().flat_map(|c| &c.outputs));
            }
            found
        };
        (0..=work.steps.len()).map(from).collect()
    };
    let each = shop
        .cells
        .iter()
        .map(|cell| cell.works.iter().map(of_work).collect());
    each.collect()
}

/// Returns the least cost of a way between each two resources: R. W. Floyd, "Algorithm 97: shortest
/// path", Communications of the ACM 5 (1962), 345. In lockstep, the two sides of a transfer take the
/// same time (`shared`).
fn ways(shop: &Shop<'_>, cost: &dyn Fn(usize, usize) -> i64, shared: bool) -> Vec<i64> {
    let resources = shop.resources();
    let mut way = vec![NEVER; resources * resources];
    let offers = |r: usize, gives: bool| {
        let transitions = shop.layout.resources[r].transitions.iter().enumerate();
        transitions.filter_map(move |(t, transition)| match &transition.action {
            Action::Out(label) if gives => Some((t, label)),
            Action::In(label) if !gives => Some((t, label)),
            _ => None,
        })
    };
    let mut takers: rustc_hash::FxHashMap<&String, Vec<(usize, i64)>> =
        rustc_hash::FxHashMap::default();
    for r in 0..resources {
        for (t, label) in offers(r, false) {
            takers.entry(label).or_default().push((r, cost(r, t)));
        }
    }
    for a in 0..resources {
        way[a * resources + a] = 0;
        for (t, label) in offers(a, true) {
            for (b, taken) in takers.get(label).into_iter().flatten() {
                let given = cost(a, t);
                let sum = if shared {
                    given.max(*taken)
                } else {
                    given + taken
                };
                let cell = &mut way[a * resources + b];
                *cell = (*cell).min(sum);
            }
        }
    }
    for via in 0..resources {
        for a in 0..resources {
            let first = way[a * resources + via];
            if first >= NEVER {
                continue;
            }
            for b in 0..resources {
                let sum = first + way[via * resources + b];
                let cell = &mut way[a * resources + b];
                *cell = (*cell).min(sum);
            }
        }
    }
    way
}
