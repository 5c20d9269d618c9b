//! Operations in a given order.
//!
//! A schedule in which buffers are ample and transports are never busy says in which order the
//! operations should begin. Here each of them, in this order, gets the transfers that it needs: a
//! search for the earliest end of that operation alone. The result is a plan; whether it is a good
//! one is seen by comparison with the length of the schedule, which is a lower bound.

use super::bounds::is_never;
use super::search::{NONE, Search, Solved, Stop};
use super::shop::{Shop, initial, products};
use super::state::{Happening, Settled, State};
use super::{Method, Objective, Plan, PlanLimits, Progress, extract};
use crate::jobshop::{Instance, Task, solve};
use crate::model::{Demand, Layout};
use crate::realize::cell::Call;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

/// Maximum number of states for the transfers before one operation.
const MAX_STATES: usize = 5_000;
/// Maximum number of products.
const MAX_PRODUCTS: usize = 200;

/// Plans products without tests. Returns the plan, if one was found, and a lower bound of all
/// plans.
pub(super) fn plan(layout: &Layout, demands: &[Demand], limits: PlanLimits) -> (Option<Plan>, i64) {
    let all: Vec<usize> = (0..products(demands).len()).collect();
    let configuration = initial(layout, demands);
    let execution = Objective::Time.execution();
    let mut shop = Shop::new(layout, demands, execution, &all, &configuration);
    // Operations come in their order, so the transfers before them may be earlier.
    shop.is_ordered = false;
    let mut search = Search::new(&shop, Objective::Time, limits.nodes);
    let mut tasks: Vec<Task> = Vec::new();
    // The product and the number of the step of each task.
    let mut of_task: Vec<(usize, usize)> = Vec::new();
    for slot in 0..shop.slots.len() {
        let Some(steps) = steps(&shop, slot) else {
            return (None, 0);
        };
        search.bounds.tasks(&shop, slot, &steps, &mut tasks);
        let calls = steps.iter().enumerate();
        of_task.extend(calls.flat_map(|(at, step)| step.iter().map(move |_| (slot, at))));
    }
    if tasks
        .iter()
        .flat_map(|t| &t.after)
        .any(|(_, lag)| is_never(*lag))
        || all.len() > MAX_PRODUCTS
    {
        return (None, 0);
    }
    let instance = Instance {
        machines: shop.resources(),
        tasks,
    };
    let solution = solve(&instance, limits.job_shop);
    let by_start = sorted(&of_task, |task| solution.start[task]);
    let by_turn = sorted(&of_task, |task| of_task[task].1 as i64);
    let mut best: Option<(i64, Vec<Happening>)> = None;
    let progress: Vec<Progress> = (shop.slots.iter())
        .map(|(_, demand)| Progress::At(shop.cells[*demand].start as usize))
        .collect();
    let root = shop.root(&configuration, &progress);
    for order in [by_start, by_turn] {
        let found = perform(&mut search, &root, &order);
        if let Some((value, way)) = found
            && best.as_ref().is_none_or(|b| value < b.0)
        {
            best = Some((value, way));
        }
        if best.as_ref().is_some_and(|b| b.0 <= solution.lower_bound) {
            break;
        }
    }
    let plan = best.map(|(value, way)| {
        let solved = Solved {
            value: Some(value),
            lower: 0,
            way,
            stop: Stop::Ended,
        };
        Plan {
            objective: Objective::Time,
            products: shop.slots.iter().map(|s| s.1).collect(),
            positions: extract::positions(&search, &root, &Rc::new(solved)),
            value,
            lower_bound: solution.lower_bound.min(value),
            method: Method::JobShop,
            nodes: search.nodes + solution.nodes,
        }
    });
    (plan, solution.lower_bound)
}

/// Returns the steps of a product, if its recipe has no loop.
fn steps<'s>(shop: &'s Shop<'_>, slot: usize) -> Option<Vec<&'s [Call]>> {
    let cell = shop.cell(slot);
    let (mut state, mut steps) = (cell.start, Vec::new());
    loop {
        let about = &cell.recipe_states[state as usize];
        if about.is_end {
            return Some(steps);
        }
        let work = &cell.works[*about.leaving.first()? as usize];
        if work.closes_loop {
            return None;
        }
        steps.extend(work.steps.iter().map(Vec::as_slice));
        state = work.to;
    }
}

/// Returns the steps in an order of their tasks: slots of products.
fn sorted(of_task: &[(usize, usize)], key: impl Fn(usize) -> i64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..of_task.len()).collect();
    // The tasks of one step are neighbors; the first stands for all.
    order.retain(|task| *task == 0 || of_task[task - 1] != of_task[*task]);
    order.sort_by_key(|task| (key(*task), *task));
    order.into_iter().map(|task| of_task[task].0).collect()
}

/// Performs the next step of each product in an order. Returns the time of the end and what
/// happens.
fn perform(
    search: &mut Search<'_>,
    root: &State,
    order: &[usize],
) -> Option<(i64, Vec<Happening>)> {
    let shop = search.shop;
    let (mut state, _) = search.follow(root, &[]);
    let mut way = Vec::new();
    for product in order {
        let is_own = |slot: &usize| root.origin[state.origin[*slot] as usize] as usize == *product;
        let slot = (0..shop.slots.len()).find(is_own)?;
        let part = [false, true]
            .into_iter()
            .find_map(|all| reach(search, &state, slot, all))?;
        for happening in part {
            state = shop.apply(&state, &happening)?;
            match shop.advance(&mut state) {
                Settled::Dead => return None,
                Settled::Open => shop.sort(&mut state),
                Settled::Ended | Settled::Loop => {}
            }
            way.push(happening);
        }
    }
    if shop.advance(&mut state) != Settled::Ended {
        return None;
    }
    let variables: Vec<u16> = (0..shop.variables() as u16).collect();
    let (time, _) = state.zone.settle(&variables, 0, true)?;
    Some((time, way))
}

/// Returns what has to happen for the earliest end of a product's next step, and the step. Without
/// `all`, only the parts that it needs and those at resources that can perform it are moved.
fn reach(search: &mut Search<'_>, start: &State, slot: usize, all: bool) -> Option<Vec<Happening>> {
    let shop = search.shop;
    let product = start.origin[slot];
    // Equal products are sorted after each happening, so the product's slot changes.
    let slot_in = |state: &State| state.origin.iter().position(|o| *o == product);
    // States with their parent, what has led to them, and whether the step has been performed.
    let mut nodes: Vec<(State, usize, Option<Happening>, bool)> = Vec::new();
    let mut seen: FxHashMap<(usize, Vec<u16>), Vec<usize>> = FxHashMap::default();
    let mut queue = BinaryHeap::new();
    let bound = search.bounds.step_end(shop, start, slot);
    nodes.push((start.clone(), 0, None, false));
    queue.push(Reverse((bound, 0_usize, 0_usize)));
    while let Some(Reverse((bound, events, number))) = queue.pop() {
        let (state, _, _, is_done) = nodes[number].clone();
        if is_done {
            let (mut way, mut at) = (Vec::new(), number);
            while let Some(happening) = nodes[at].2.clone() {
                way.push(happening);
                at = nodes[at].1;
            }
            way.reverse();
            return Some(way);
        }
        let slot = slot_in(&state)?;
        let (needed, able) = wanted(shop, &state, slot);
        for happening in shop.happenings(&state.words) {
            let (is_wanted, is_step) = match &happening {
                Happening::Step { slot: s, .. } => (*s as usize == slot, *s as usize == slot),
                Happening::Internal(_) => (true, false),
                Happening::Transfer { giver, kind, .. } => (
                    all || needed.contains(kind) || able.contains(&giver.resource),
                    false,
                ),
            };
            if !is_wanted || nodes.len() >= MAX_STATES {
                continue;
            }
            let Some(mut next) = shop.apply(&state, &happening) else {
                continue;
            };
            let bound = if is_step {
                next.zone.low[shop.ready_variable(slot) as usize]
            } else {
                shop.sort(&mut next);
                let slot = slot_in(&next)?;
                search.bounds.step_end(shop, &next, slot).max(bound)
            };
            let key = (slot_in(&next)?, next.words.clone());
            let known = seen.entry(key).or_default();
            let includes = |n: &usize| nodes[*n].0.zone.includes(&next.zone);
            if bound == NONE || is_never(bound) || known.iter().any(includes) {
                continue;
            }
            known.push(nodes.len());
            queue.push(Reverse((bound, events + 1, nodes.len())));
            nodes.push((next, number, Some(happening), is_step));
            search.nodes += 1;
        }
    }
    None
}

/// Returns the parts that a slot's next step needs, and the resources that can perform one of its
/// operations.
fn wanted(shop: &Shop<'_>, state: &State, slot: usize) -> (Vec<u16>, Vec<u16>) {
    let (work, step) = (state.words[2 * slot], state.words[2 * slot + 1]);
    let calls = &shop.cell(slot).works[work as usize].steps[step as usize];
    let needed = calls
        .iter()
        .flat_map(|call| shop.resolve(slot, &call.inputs, shop.held(&state.words)));
    let able = calls
        .iter()
        .flat_map(|call| call.performers.iter().map(|p| p.1.resource));
    (needed.collect(), able.collect())
}
