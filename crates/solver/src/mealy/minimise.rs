//! Reduces the number of states of a machine without changing its behavior on inputs that keep the
//! assumptions.
//!
//! The first method is partition refinement (after Hopcroft and Moore); its signatures are
//! canonical diagrams, so that input valuations are not enumerated. The second method merges states
//! that agree wherever both have a transition: where one is don't-care, the other decides (Paull
//! and Unger 1959, greedily and with closure). The result gives the same outputs in every play that
//! keeps the assumptions. States are numbered breadth-first in order of discovery.

use super::diagram::{DONT_CARE, Diagrams, Leaf, Ref};
use super::{Guard, Machine, Transition};
use crate::game::{Limit, Limits};
use linewright_core::gr1::Timing;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Maximum number of pairs of diagram nodes visited while merging by don't-cares. Merging that
/// would take more steps saves only a few states.
const MERGE_STEPS: u64 = 300_000;

/// A machine during minimization, with its states as diagrams.
struct Work {
    diagrams: Diagrams,
    outputs: Vec<Vec<i64>>,
    initial: Ref,
    states: Vec<Ref>,
    /// See [`Machine::goals`].
    goals: Vec<BTreeSet<usize>>,
    timing: Timing,
}

/// Returns the minimized machine, without unreachable states.
pub fn minimise(machine: &Machine, limits: &Limits) -> Result<Machine, Limit> {
    let mut work = Work::new(machine, limits)?;
    work.refine(limits)?;
    work.merge(limits)?;
    work.refine(limits)?;
    Ok(work.into_machine(machine))
}

impl Work {
    fn new(machine: &Machine, limits: &Limits) -> Result<Self, Limit> {
        let mut work = Self {
            diagrams: Diagrams::new(&machine.inputs),
            outputs: Vec::new(),
            initial: DONT_CARE,
            states: Vec::new(),
            goals: machine
                .goals
                .iter()
                .map(|own| own.iter().copied().collect())
                .collect(),
            timing: machine.timing,
        };
        let mut numbers = FxHashMap::default();
        work.initial = work.diagram_of(&machine.initial, &mut numbers);
        for transitions in &machine.states {
            limits.check_time()?;
            let diagram = work.diagram_of(transitions, &mut numbers);
            work.states.push(diagram);
        }
        Ok(work)
    }

    fn diagram_of(
        &mut self,
        transitions: &[Transition],
        numbers: &mut FxHashMap<Vec<i64>, u32>,
    ) -> Ref {
        let mut parts = Vec::new();
        for transition in transitions {
            let output = *numbers.entry(transition.output.clone()).or_insert_with(|| {
                self.outputs.push(transition.output.clone());
                self.outputs.len() as u32 - 1
            });
            let leaf = Leaf {
                output,
                to: transition.to as u32,
            };
            for cube in &transition.guard.0 {
                parts.push(self.diagrams.cube(cube, leaf));
            }
        }
        // Combines the parts, which are disjoint, in pairs, so that large diagrams are combined
        // only a few times.
        while parts.len() > 1 {
            let mut halves = Vec::with_capacity(parts.len().div_ceil(2));
            for pair in parts.chunks(2) {
                let mut seen = FxHashMap::default();
                let (a, b) = (pair[0], pair.get(1).copied().unwrap_or(DONT_CARE));
                let both = self.diagrams.overlay(
                    a,
                    b,
                    &mut |x, y| (x == y).then_some(x),
                    &mut seen,
                    &mut u64::MAX.clone(),
                );
                halves.push(both.expect("the guards of a state overlap; please report this"));
            }
            parts = halves;
        }
        parts.first().copied().unwrap_or(DONT_CARE)
    }

    /// Combines states with equal behavior by partition refinement.
    fn refine(&mut self, limits: &Limits) -> Result<(), Limit> {
        let mut blocks = vec![0u32; self.states.len()];
        let mut count = 1;
        loop {
            limits.check_time()?;
            let change = |leaf: Leaf| Leaf {
                to: blocks[leaf.to as usize],
                ..leaf
            };
            let mut seen = FxHashMap::default();
            let mut numbers: FxHashMap<Ref, u32> = FxHashMap::default();
            let mut finer = Vec::with_capacity(blocks.len());
            for state in &self.states {
                let signature = self.diagrams.relabel(*state, &change, &mut seen);
                let next = numbers.len() as u32;
                finer.push(*numbers.entry(signature).or_insert(next));
            }
            let found = numbers.len();
            blocks = finer;
            if found == count {
                break;
            }
            count = found;
        }
        self.quotient(&blocks);
        Ok(())
    }

    /// Replaces the states by blocks, each represented by its first state.
    fn quotient(&mut self, blocks: &[u32]) {
        let change = |leaf: Leaf| Leaf {
            to: blocks[leaf.to as usize],
            ..leaf
        };
        let mut seen = FxHashMap::default();
        let mut states: Vec<Option<Ref>> =
            vec![None; blocks.iter().max().map_or(0, |b| *b as usize + 1)];
        for (state, block) in self.states.iter().zip(blocks) {
            if states[*block as usize].is_none() {
                states[*block as usize] = Some(self.diagrams.relabel(*state, &change, &mut seen));
            }
        }
        let mut goals = vec![BTreeSet::new(); states.len()];
        for (own, block) in self.goals.iter().zip(blocks) {
            goals[*block as usize].extend(own);
        }
        if !self.goals.is_empty() {
            self.goals = goals;
        }
        self.initial = self.diagrams.relabel(self.initial, &change, &mut seen);
        self.states = states.into_iter().map(|s| s.unwrap_or(DONT_CARE)).collect();
    }

    /// Merges states that agree wherever both have a transition, within [`MERGE_STEPS`].
    fn merge(&mut self, limits: &Limits) -> Result<(), Limit> {
        let count = self.states.len();
        let moore: Vec<Option<u32>> = self
            .states
            .iter()
            .map(|s| {
                let mut output = None;
                if self.timing == Timing::Moore {
                    self.diagrams
                        .leaves(*s, &mut |leaf| output = Some(leaf.output));
                }
                output
            })
            .collect();
        let mut merged = StatePartition {
            parent: (0..count as u32).collect(),
            diagram: self.states.clone(),
            moore,
        };
        let mut steps = MERGE_STEPS;
        let mut sizes = FxHashMap::default();
        'states: for b in 1..count as u32 {
            limits.check_time()?;
            for a in 0..b {
                if merged.find(b) != b {
                    break;
                }
                if merged.find(a) != a {
                    continue;
                }
                if let Some(better) =
                    merged.try_merge(&mut self.diagrams, a, b, &mut steps, &mut sizes)
                {
                    merged = better;
                }
                if steps == 0 {
                    break 'states;
                }
            }
        }
        let mut numbers = FxHashMap::default();
        let mut blocks = Vec::with_capacity(count);
        for state in 0..count as u32 {
            let next = numbers.len() as u32;
            blocks.push(*numbers.entry(merged.find(state)).or_insert(next));
        }
        // Every class is represented by its smallest state.
        self.states = (0..count as u32)
            .map(|s| merged.diagram[merged.find(s) as usize])
            .collect();
        self.quotient(&blocks);
        Ok(())
    }

    fn into_machine(self, machine: &Machine) -> Machine {
        let mut numbers: Vec<Option<usize>> = vec![None; self.states.len()];
        let mut order: Vec<usize> = Vec::new();
        let mut write = |diagram: Ref, order: &mut Vec<usize>| -> Vec<Transition> {
            let rows = self.diagrams.read(diagram).into_iter();
            rows.map(|(leaf, cubes)| {
                let to = *numbers[leaf.to as usize].get_or_insert_with(|| {
                    order.push(leaf.to as usize);
                    order.len() - 1
                });
                Transition {
                    guard: Guard(cubes),
                    output: self.outputs[leaf.output as usize].clone(),
                    to,
                }
            })
            .collect()
        };
        let initial = write(self.initial, &mut order);
        let mut states = Vec::new();
        while let Some(next) = order.get(states.len()) {
            let diagram = self.states[*next];
            states.push(write(diagram, &mut order));
        }
        let goals = order.iter().filter_map(|state| self.goals.get(*state));
        Machine {
            initial,
            states,
            goals: goals.map(|own| own.iter().copied().collect()).collect(),
            ..machine.clone()
        }
    }
}

/// Classes of merged states.
#[derive(Clone)]
struct StatePartition {
    /// For each state, a smaller member of its class. The smallest member refers to itself.
    parent: Vec<u32>,
    /// Behavior of the class; valid at the index of its smallest member.
    diagram: Vec<Ref>,
    /// Output of the class in a Moore machine, if it has transitions; valid at the index of its
    /// smallest member.
    moore: Vec<Option<u32>>,
}

impl StatePartition {
    /// Returns the smallest member of a state's class.
    fn find(&self, mut state: u32) -> u32 {
        while self.parent[state as usize] != state {
            state = self.parent[state as usize];
        }
        state
    }

    /// Merges the classes of `a` and `b`, and all classes that must be merged as a consequence.
    /// Returns `None` if two of these classes disagree, `steps` is used up, or the number of cubes
    /// would grow.
    fn try_merge(
        &self,
        diagrams: &mut Diagrams,
        a: u32,
        b: u32,
        steps: &mut u64,
        sizes: &mut FxHashMap<Ref, u64>,
    ) -> Option<Self> {
        let mut result: Option<Self> = None;
        let mut pairs = vec![(a, b)];
        while let Some((a, b)) = pairs.pop() {
            let current = result.as_ref().unwrap_or(self);
            let (a, b) = (current.find(a), current.find(b));
            if a == b {
                continue;
            }
            let (a, b) = (a.min(b), a.max(b));
            let (x, y) = (current.moore[a as usize], current.moore[b as usize]);
            if x.is_some() && y.is_some() && x != y {
                return None;
            }
            let (left, right) = (current.diagram[a as usize], current.diagram[b as usize]);
            let mut join = |x: Leaf, y: Leaf| {
                if x.output != y.output {
                    return None;
                }
                if x.to != y.to {
                    pairs.push((x.to, y.to));
                }
                Some(x)
            };
            let joined =
                diagrams.overlay(left, right, &mut join, &mut FxHashMap::default(), steps)?;
            // Saving a state is not worthwhile if the number of cubes grows.
            let mut count = |node| diagrams.cubes(node, sizes);
            if count(joined) > count(left).saturating_add(count(right)) {
                return None;
            }
            let next = result.get_or_insert_with(|| self.clone());
            next.parent[b as usize] = a;
            next.diagram[a as usize] = joined;
            next.moore[a as usize] = x.or(y);
        }
        result
    }
}
