//! Dependencies between components within a step.
//!
//! A component that sees the inputs of the current step waits for the components that set them, if
//! its possible answers depend on them. This is decided from the meaning of its guarantees, not
//! from their text. A component that answers first does not wait.

use super::super::system::{ContractSide, System};
use super::SameStepLoop;
use super::book::ProofRules;
use linewright_core::gr1::{Timing, VarId};
use linewright_solver::game::Limit;
use std::collections::{BTreeMap, BTreeSet};

/// Dependencies between answers in the same step.
#[derive(Debug, Clone, Default)]
pub struct AnswerDependencies {
    /// For each variable that waits: the variables of other components that it waits for.
    pub variables: BTreeMap<VarId, BTreeSet<VarId>>,
    /// For each component: the components whose answers it waits for.
    pub components: Vec<BTreeSet<usize>>,
}

impl AnswerDependencies {
    /// Computes the dependencies. For a component that is on no cycle of wires, `components`
    /// contains the dependencies by wires, and `variables` contains nothing.
    pub fn new(book: &mut ProofRules<'_>) -> Result<Self, Limit> {
        let system = book.system;
        let mut waits = Self {
            components: wires(system),
            ..Self::default()
        };
        for component in in_cycles(&waits.components) {
            waits.components[component].clear();
            let own = system.components[component].drives.clone();
            let rules: Vec<usize> = (0..book.entries.len())
                .filter(|i| {
                    let entry = &book.entries[*i];
                    let own = entry.component == Some(component) && !book.is_justice(*i);
                    own && entry
                        .at
                        .is_none_or(|at| at.half == ContractSide::Guarantees)
                })
                .collect();
            for answer in &own {
                let seen = book.runs.dependencies(&rules, *answer, &own)?;
                let others: BTreeSet<VarId> = seen
                    .into_iter()
                    .filter(|v| system.driver(*v).is_some())
                    .collect();
                waits.components[component].extend(others.iter().filter_map(|v| system.driver(*v)));
                if !others.is_empty() {
                    waits.variables.insert(*answer, others);
                }
            }
        }
        Ok(waits)
    }

    /// Returns the loops, each only once.
    pub fn loops(&self) -> Vec<SameStepLoop> {
        let mut found: Vec<SameStepLoop> = Vec::new();
        let mut shown: BTreeSet<VarId> = BTreeSet::new();
        let next = |v: VarId| {
            self.variables
                .get(&v)
                .into_iter()
                .flatten()
                .copied()
                .collect()
        };
        for start in self.variables.keys() {
            if shown.contains(start) {
                continue;
            }
            if let Some(variables) = cycle_through(next, *start) {
                shown.extend(&variables);
                found.push(SameStepLoop { variables });
            }
        }
        found
    }
}

/// Returns the nodes of a shortest cycle through a node of a graph, beginning with that node;
/// `None` if there is no cycle.
pub fn cycle_through<N: Copy + Ord>(next: impl Fn(N) -> Vec<N>, start: N) -> Option<Vec<N>> {
    let mut ways = vec![vec![start]];
    let mut seen = BTreeSet::new();
    let mut place = 0;
    while let Some(way) = ways.get(place).cloned() {
        place += 1;
        for on in next(way[way.len() - 1]) {
            if on == start {
                return Some(way);
            }
            if seen.insert(on) {
                ways.push([&way[..], &[on]].concat());
            }
        }
    }
    None
}

/// Returns the dependencies by wires: for each component that sees the inputs of the current step,
/// the components whose outputs its guarantees read.
fn wires(system: &System) -> Vec<BTreeSet<usize>> {
    let reads = system.components.iter().enumerate().map(|(i, component)| {
        if component.timing == Timing::Moore {
            return BTreeSet::new();
        }
        let mut read = BTreeSet::new();
        for formula in component.guarantees.all() {
            formula.expr.for_each_var(&mut |v, _| {
                read.extend(system.driver(v).filter(|j| *j != i));
            });
        }
        read
    });
    reads.collect()
}

/// Returns the components that are on a cycle.
fn in_cycles(edges: &[BTreeSet<usize>]) -> Vec<usize> {
    let leads_back = |start: usize| {
        let mut open: Vec<usize> = edges[start].iter().copied().collect();
        let mut seen = BTreeSet::new();
        while let Some(at) = open.pop() {
            if at == start {
                return true;
            }
            if seen.insert(at) {
                open.extend(&edges[at]);
            }
        }
        false
    };
    (0..edges.len()).filter(|i| leads_back(*i)).collect()
}
