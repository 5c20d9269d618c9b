//! One product after the other.
//!
//! Each product begins when the one before it is finished and all resources are at rest. Equal
//! products that begin in the same configuration are planned once. Products of which parts are on
//! the line at the start come first.

use super::extract::{Leaf, describe, schedule};
use super::search::{NONE, Search};
use super::shop::{Configuration, Kind, Shop, initial, products};
use super::{Method, Next, Objective, Plan, PlanPosition, Progress};
use crate::model::{Demand, Layout};
use rustc_hash::FxHashMap;
use std::cmp::Ordering;

/// Maximum number of positions, times the number of products.
const MAX_PROGRESS: usize = 4_000_000;

/// Plans the products one after the other: in the order of the demands, or else in the reverse
/// order. Returns nothing if this is not possible, or not within the limit of nodes.
pub(super) fn plan(
    layout: &Layout,
    demands: &[Demand],
    objective: Objective,
    max_nodes: usize,
) -> Option<Plan> {
    let mut order: Vec<usize> = (0..demands.len()).collect();
    let found = in_order(layout, demands, objective, max_nodes, &order);
    if found.is_some() || demands.len() < 2 {
        return found;
    }
    order.reverse();
    in_order(layout, demands, objective, max_nodes, &order)
}

/// Where a product begins, or goes on after a loop.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Place {
    /// Index into the order of products.
    turn: usize,
    progress: Progress,
    configuration: Configuration,
}

fn in_order(
    layout: &Layout,
    demands: &[Demand],
    objective: Objective,
    max_nodes: usize,
    order: &[usize],
) -> Option<Plan> {
    let of_product = products(demands);
    let start = initial(layout, demands);
    let has_parts = |product: usize| {
        let own =
            |(_, kind): &(u16, Kind)| matches!(kind, Kind::Own { product: p, .. } if *p == product);
        start.parts.iter().any(own)
    };
    let mut turns: Vec<usize> = (0..of_product.len()).collect();
    let rank = |product: &usize| {
        let demand = of_product[*product];
        let place = order.iter().position(|d| *d == demand).unwrap_or(0);
        (!has_parts(*product), place, *product)
    };
    turns.sort_by_key(rank);
    // Products without parts at the start share a shop with the others of their demand.
    let mut groups: Vec<(usize, usize, bool)> = Vec::new();
    let mut group_of = Vec::new();
    for product in &turns {
        let (demand, own) = (of_product[*product], has_parts(*product));
        let known = groups.iter().position(|g| g.1 == demand && !g.2 && !own);
        group_of.push(known.unwrap_or(groups.len()));
        if known.is_none() {
            groups.push((*product, demand, own));
        }
    }
    let shops: Vec<Shop<'_>> = (groups.iter())
        .map(|g| Shop::new(layout, demands, objective.execution(), &[g.0], &start))
        .collect();
    let mut searches: Vec<Search<'_>> = shops
        .iter()
        .map(|shop| Search::new(shop, objective, max_nodes))
        .collect();
    let begin = |turn: usize| {
        let demand = of_product[*turns.get(turn)?];
        Some(Progress::At(shops.first()?.cells[demand].start as usize))
    };
    let mut open = vec![Place {
        turn: 0,
        progress: begin(0)?,
        configuration: start.clone(),
    }];
    let mut numbers: FxHashMap<Place, usize> = FxHashMap::from_iter([(open[0].clone(), 0)]);
    let mut turn_of = vec![0; turns.len()];
    for (turn, product) in turns.iter().enumerate() {
        turn_of[*product] = turn;
    }
    let mut positions: Vec<PlanPosition> = Vec::new();
    while let Some(place) = open.get(positions.len()).cloned() {
        if open.len().saturating_mul(turns.len()) > MAX_PROGRESS {
            return None;
        }
        let search = &mut searches[group_of[place.turn]];
        let shop = search.shop;
        let root = shop.root(&place.configuration, &[place.progress]);
        let solved = search.run(&root, NONE).ok()?;
        solved.value?;
        let search = &searches[group_of[place.turn]];
        let product = turns[place.turn];
        let mut leaf = |leaf: Leaf| {
            let (progress, configuration) = shop.describe(&leaf.state.words);
            let (turn, progress) = if leaf.closes_loop {
                (place.turn, progress[0])
            } else {
                match begin(place.turn + 1) {
                    Some(progress) => (place.turn + 1, progress),
                    None => return Next::End { time: leaf.time },
                }
            };
            let next = Place {
                turn,
                progress,
                configuration,
            };
            let position = *numbers.entry(next.clone()).or_insert_with(|| {
                open.push(next);
                open.len() - 1
            });
            Next::Goto {
                time: leaf.time,
                position,
                closes_loop: leaf.closes_loop,
            }
        };
        let schedule = schedule(search, &root, &solved, &[product], (0, &mut 0), &mut leaf);
        let (resource_states, parts) = describe(shop, &place.configuration, &[product]);
        let progress = turn_of.iter().map(|turn| match turn.cmp(&place.turn) {
            Ordering::Less => Progress::Ended,
            Ordering::Equal => place.progress,
            Ordering::Greater => begin(*turn).unwrap_or(Progress::At(0)),
        });
        positions.push(PlanPosition {
            progress: progress.collect(),
            resource_states,
            parts,
            schedule,
        });
    }
    let mut plan = Plan {
        objective,
        products: of_product,
        positions,
        value: 0,
        lower_bound: 0,
        method: Method::OneAfterTheOther(order.to_vec()),
        nodes: searches.iter().map(|s| s.nodes).sum(),
    };
    plan.value = super::value::worst_case(layout, &plan);
    Some(plan)
}
