//! Dependencies between parts within a step.
//!
//! A part that sees the inputs of the step it answers waits for the parts that set them, if its
//! possible answers depend on them. This is decided from the meaning of its guarantees, not from
//! their text. A part that answers first waits for no one.

use super::super::system::{ContractSide, System};
use super::SameStepLoop;
use super::book::ProofRules;
use linewright_core::gr1::{Timing, VarId};
use linewright_solver::game::Limit;
use std::collections::{BTreeMap, BTreeSet};

/// Which answers wait for which.
#[derive(Debug, Clone, Default)]
pub struct AnswerDependencies {
    /// For every variable that waits: the variables of other parts that it waits for.
    pub variables: BTreeMap<VarId, BTreeSet<VarId>>,
    /// For every part: the parts whose answers it waits for.
    pub parts: Vec<BTreeSet<usize>>,
}

impl AnswerDependencies {
    /// Computes the dependencies. Parts that are in no circle by their wires alone are not examined
    /// further.
    pub fn new(book: &mut ProofRules<'_>) -> Result<Self, Limit> {
        let system = book.system;
        let mut waits = Self {
            parts: wires(system),
            ..Self::default()
        };
        for part in in_circles(&waits.parts) {
            waits.parts[part].clear();
            let own = system.parts[part].drives.clone();
            let rules: Vec<usize> = (0..book.entries.len())
                .filter(|i| {
                    let entry = &book.entries[*i];
                    let own = entry.part == Some(part) && !book.is_justice(*i);
                    own && entry
                        .at
                        .is_none_or(|at| at.half == ContractSide::Guarantees)
                })
                .collect();
            for answer in &own {
                let seen = book.runs.depends(&rules, *answer, &own)?;
                let others: BTreeSet<VarId> = seen
                    .into_iter()
                    .filter(|v| system.driver(*v).is_some())
                    .collect();
                waits.parts[part].extend(others.iter().filter_map(|v| system.driver(*v)));
                if !others.is_empty() {
                    waits.variables.insert(*answer, others);
                }
            }
        }
        Ok(waits)
    }

    /// Returns the loops, each once.
    pub fn loops(&self) -> Vec<SameStepLoop> {
        let mut found: Vec<SameStepLoop> = Vec::new();
        let mut told: BTreeSet<VarId> = BTreeSet::new();
        let next = |v: VarId| {
            self.variables
                .get(&v)
                .into_iter()
                .flatten()
                .copied()
                .collect()
        };
        for start in self.variables.keys() {
            if told.contains(start) {
                continue;
            }
            if let Some(variables) = way_back(next, *start) {
                told.extend(&variables);
                found.push(SameStepLoop { variables });
            }
        }
        found
    }
}

/// Returns a shortest path from a node of a graph back to itself.
pub fn way_back<N: Copy + Ord>(next: impl Fn(N) -> Vec<N>, start: N) -> Option<Vec<N>> {
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

/// Returns the dependencies by wires alone: for every part that sees inputs, the parts whose
/// outputs it reads.
fn wires(system: &System) -> Vec<BTreeSet<usize>> {
    let reads = system.parts.iter().enumerate().map(|(i, part)| {
        if part.timing == Timing::Moore {
            return BTreeSet::new();
        }
        let mut read = BTreeSet::new();
        for formula in part.guarantees.all() {
            formula.expr.for_each_var(&mut |v, _| {
                read.extend(system.driver(v).filter(|j| *j != i));
            });
        }
        read
    });
    reads.collect()
}

/// Returns the parts that lie on a circle.
fn in_circles(edges: &[BTreeSet<usize>]) -> Vec<usize> {
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
