//! Lower bounds of what remains to be done.
//!
//! Time: each product needs at least the durations of its steps and of the ways between them, and
//! each resource at least the work that only it can do, and its share of the ways. Other costs:
//! the sum over the steps and the ways. Ways are shortest paths in the graph of transfers, without
//! regard to the states of resources, so that no plan has shorter ones.

mod tables;
mod tasks;

use super::Objective;
use super::shop::Shop;
use super::state::{PLACE, State};
use crate::model::Action;
use crate::realize::cell::Call;
use tables::{greatest, single, uses, ways};

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
pub(in crate::plan) struct Bounds {
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

/// Returns whether a bound says that there is no plan at all.
pub(in crate::plan) fn is_never(bound: i64) -> bool {
    bound >= NEVER
}
