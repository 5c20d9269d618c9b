//! A layout and the products that are made on it, in numbers.

use super::Execution;
use crate::model::{Action, Demand, Layout};
use crate::realize::cell::Cell;
use std::collections::BTreeSet;

/// What a part is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Kind {
    /// A part in stock, by its type.
    Stock(String),
    /// What a finished product has left over.
    Finished { demand: usize, part: usize },
    /// A part of a product.
    Own { product: usize, part: usize },
}

/// States and parts of all resources.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Configuration {
    pub states: Vec<u16>,
    /// Resources and the parts that they hold, sorted.
    pub parts: Vec<(u16, Kind)>,
}

/// Returns the demand of each product.
pub(super) fn products(demands: &[Demand]) -> Vec<usize> {
    let each = demands.iter().enumerate();
    each.flat_map(|(d, demand)| std::iter::repeat_n(d, demand.count))
        .collect()
}

/// Returns the configuration at the start; [`super`] says which parts belong to which product.
pub(super) fn initial(layout: &Layout, demands: &[Demand]) -> Configuration {
    let owners = products(demands);
    let mut given = BTreeSet::new();
    let mut parts = Vec::new();
    for (at, resource) in layout.resources.iter().enumerate() {
        for name in &resource.holds {
            let own = |product: usize| {
                let part = demands[owners[product]].recipe.part(name)?;
                Some((product, part))
            };
            let candidates: Vec<(usize, usize)> = (0..owners.len()).filter_map(own).collect();
            let without = candidates.iter().find(|c| !given.contains(*c));
            let kind = match without.or_else(|| candidates.first()).copied() {
                Some((product, part)) => {
                    given.insert((product, part));
                    Kind::Own { product, part }
                }
                None => Kind::Stock(name.clone()),
            };
            parts.push((at as u16, kind));
        }
    }
    parts.sort_unstable();
    let state = |r: &crate::model::Resource| r.state(&r.initial).unwrap_or(0) as u16;
    Configuration {
        states: layout.resources.iter().map(state).collect(),
        parts,
    }
}

/// Returns the kind of a part that replaces a missing part of a recipe, if it has one.
fn stock_of(demands: &[Demand], demand: usize, part: usize) -> Option<&str> {
    let kind = &demands[demand].recipe.parts[part].kind;
    // A type that is also the name of a part is that part, not stock.
    let is_part = demands
        .iter()
        .any(|d| d.count > 0 && d.recipe.part(kind).is_some());
    (!is_part).then_some(kind.as_str())
}

/// A layout, and some products that are made on it at the same time.
pub(super) struct Shop<'a> {
    pub layout: &'a Layout,
    pub demands: &'a [Demand],
    pub execution: Execution,
    /// For each demand, the resources and its recipe in numbers. Its kinds of parts are not used.
    pub cells: Vec<Cell>,
    /// For each slot, the product that is made in it and its demand. Equal products are neighbors.
    pub slots: Vec<(usize, usize)>,
    /// Kinds of parts, sorted: stock, what is left over, and the parts of products.
    pub kinds: Vec<Kind>,
    /// For each slot, the number of its first part.
    pub own: Vec<u16>,
    /// For each demand, the number of the first part that is left over.
    finished: Vec<u16>,
    /// For each demand and part, the stock that can replace it.
    stock: Vec<Vec<Option<u16>>>,
    /// Duration of each transition of each resource: in lockstep 1, otherwise in nanoseconds.
    pub ticks: Vec<Vec<i64>>,
    /// Energy of each transition in microjoules.
    pub energy: Vec<Vec<i64>>,
    /// Number of labels.
    pub labels: usize,
    /// For each resource and state, the longest time for which it can carry a part that it gives.
    pub lead: Vec<Vec<i64>>,
    /// Whether what happens is put in the order of time. This is not possible where a test may come
    /// between the beginning and the end of a transfer.
    pub is_ordered: bool,
}

impl<'a> Shop<'a> {
    /// Creates a shop in which some products are made. `configuration` is one that can occur; it
    /// may hold parts of products that are made later.
    pub fn new(
        layout: &'a Layout,
        demands: &'a [Demand],
        execution: Execution,
        made: &[usize],
        configuration: &Configuration,
    ) -> Self {
        let of_product = products(demands);
        let slots: Vec<(usize, usize)> = made.iter().map(|p| (*p, of_product[*p])).collect();
        let mut kinds: BTreeSet<Kind> = (configuration.parts.iter()).map(|p| p.1.clone()).collect();
        let parts = |demand: usize| 0..demands[demand].recipe.parts.len();
        for demand in 0..demands.len() {
            kinds.extend(parts(demand).map(|part| Kind::Finished { demand, part }));
        }
        for (product, demand) in &slots {
            let product = *product;
            kinds.extend(parts(*demand).map(|part| Kind::Own { product, part }));
        }
        let kinds: Vec<Kind> = kinds.into_iter().collect();
        let number = |kind: &Kind| kinds.binary_search(kind).ok().map(|at| at as u16);
        let own = |(product, _): &(usize, usize)| {
            let first = Kind::Own {
                product: *product,
                part: 0,
            };
            number(&first).unwrap_or(0)
        };
        let stock = |demand: usize| {
            let of_part = |part| number(&Kind::Stock(stock_of(demands, demand, part)?.to_owned()));
            parts(demand).map(of_part).collect()
        };
        let cells: Vec<Cell> = demands
            .iter()
            .map(|d| Cell::new(layout, &d.recipe))
            .collect();
        let transitions = |of: &dyn Fn(&crate::model::Transition) -> i64| -> Vec<Vec<i64>> {
            let resources = layout.resources.iter();
            resources
                .map(|r| r.transitions.iter().map(of).collect())
                .collect()
        };
        let ticks = transitions(&|t| match execution {
            Execution::Lockstep => 1,
            Execution::Timed => t.nanoseconds(),
        });
        let lead = (layout.resources.iter().zip(&ticks)).map(|(resource, ticks)| {
            let of_state = |state: &crate::model::State| {
                let own = resource.transitions.iter().zip(ticks);
                let gives =
                    own.filter(|(t, _)| t.from == state.name && matches!(t.action, Action::Out(_)));
                gives.map(|(_, ticks)| *ticks).max().unwrap_or(0)
            };
            match execution {
                Execution::Lockstep => vec![0; resource.states.len()],
                Execution::Timed => resource.states.iter().map(of_state).collect(),
            }
        });
        let lead = lead.collect();
        let has_tests = |(_, demand): &(usize, usize)| {
            cells[*demand]
                .recipe_states
                .iter()
                .any(|s| s.leaving.len() > 1 || !s.tests.is_empty())
        };
        let is_ordered = execution == Execution::Lockstep || !slots.iter().any(has_tests);
        Self {
            layout,
            demands,
            execution,
            own: slots.iter().map(own).collect(),
            finished: (0..demands.len())
                .map(|demand| number(&Kind::Finished { demand, part: 0 }).unwrap_or(0))
                .collect(),
            stock: (0..demands.len()).map(stock).collect(),
            ticks,
            lead,
            is_ordered,
            energy: transitions(&crate::model::Transition::microjoules),
            labels: cells.first().map_or(0, |c| c.receivers.len()),
            cells,
            slots,
            kinds,
        }
    }

    /// Returns the number of resources.
    pub fn resources(&self) -> usize {
        self.layout.resources.len()
    }

    /// Returns whether a resource may wait in a state.
    pub fn may_wait(&self, resource: u16, state: u16) -> bool {
        self.layout.resources[resource as usize].states[state as usize].may_wait
    }

    /// Returns the number of a kind.
    pub fn kind(&self, kind: &Kind) -> u16 {
        let found = self.kinds.binary_search(kind);
        found.expect("the shop has the kinds of its configurations") as u16
    }

    /// Returns the recipe of a slot in numbers.
    pub fn cell(&self, slot: usize) -> &Cell {
        &self.cells[self.slots[slot].1]
    }

    /// Returns the part of a slot's product that a kind is.
    pub fn own_part(&self, slot: usize, kind: u16) -> Option<u16> {
        let part = kind.checked_sub(self.own[slot])?;
        let parts = self.demands[self.slots[slot].1].recipe.parts.len();
        ((part as usize) < parts).then_some(part)
    }

    /// Returns what a part becomes when its product is finished.
    pub fn finished(&self, slot: usize, part: u16) -> u16 {
        self.finished[self.slots[slot].1] + part
    }

    /// Returns the kinds that stand for parts of a slot's product: its own, or stock while it has
    /// none.
    pub fn resolve(&self, slot: usize, parts: &[u16], held: &[u16]) -> Vec<u16> {
        let kind = |part: &u16| {
            let own = self.own[slot] + part;
            let exists = || held.chunks_exact(2).any(|pair| pair[1] == own);
            match self.stock[self.slots[slot].1][*part as usize] {
                Some(stock) if !exists() => stock,
                _ => own,
            }
        };
        parts.iter().map(kind).collect()
    }

    /// Returns whether a resource holds all these parts of a slot's product.
    pub fn holds(&self, slot: usize, resource: u16, parts: &[u16], held: &[u16]) -> bool {
        let kinds = self.resolve(slot, parts, held);
        kinds.iter().all(|kind| {
            let needed = kinds.iter().filter(|k| *k == kind).count();
            let pairs = held.chunks_exact(2);
            pairs.filter(|p| p[0] == resource && p[1] == *kind).count() >= needed
        })
    }
}
