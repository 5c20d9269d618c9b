//! The steps that rules allow, forward and backward.

use crate::game::clusters::Clustering;
use crate::game::heuristics::Heuristics;
use crate::game::relation::Relation;
use crate::symbolic::{BitSet, Kernel, Limit};

/// How the parts of a relation are combined.
const CLUSTERING: Clustering = Clustering::ByBits(3_000);

/// The step relation of a query's rules.
#[derive(Debug, Clone)]
pub struct Steps<K: Kernel> {
    /// The kernel.
    pub m: K,
    /// States that satisfy the invariants and domains.
    pub states: K::Function,
    /// States of step 0.
    pub initial: K::Function,
    /// Conjuncts of the relation: safety, and the invariants and domains of the next step.
    pub parts: Vec<K::Function>,
    /// Relation for forward steps; quantifies current bits.
    pub forward: Relation<K>,
    /// Relation for backward steps; quantifies next bits.
    pub backward: Relation<K>,
    /// Current bits of the mentioned variables.
    pub now: BitSet,
    /// Next bits of the mentioned variables.
    pub next: BitSet,
}

impl<K: Kernel> Steps<K> {
    /// Returns the successors of these states.
    pub fn after(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, states)?)
    }

    /// Returns the states after these steps.
    pub fn after_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        self.m.unprime(&self.forward.product(&self.m, steps)?)
    }

    /// Returns the predecessors of these states.
    pub fn before(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.before_step(&self.m.prime(states)?)
    }

    /// Returns the states from which one of these steps is possible.
    pub fn before_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        let found = self.backward.product(&self.m, steps)?;
        self.m.and(&self.states, &found)
    }

    /// Returns the relation restricted to these steps.
    pub fn only(&self, steps: &K::Function) -> Result<Self, Limit> {
        if self.m.is_true(steps) {
            return Ok(self.clone());
        }
        let mut parts = self.parts.clone();
        parts.push(steps.clone());
        self.with_parts(parts)
    }

    /// Returns the same relation on another handle of the same kernel.
    pub fn on(&self, m: K) -> Self {
        Self { m, ..self.clone() }
    }

    fn with_parts(&self, parts: Vec<K::Function>) -> Result<Self, Limit> {
        let (forward, backward) = relations(&self.m, &parts, &self.now, &self.next)?;
        Ok(Self {
            parts,
            forward,
            backward,
            ..self.clone()
        })
    }
}

/// Returns the relation of these conjuncts for forward steps and for backward steps.
pub fn relations<K: Kernel>(
    m: &K,
    parts: &[K::Function],
    now: &BitSet,
    next: &BitSet,
) -> Result<(Relation<K>, Relation<K>), Limit> {
    let heuristics = Heuristics::default();
    Ok((
        Relation::new(m, parts, now, CLUSTERING, heuristics)?,
        Relation::new(m, parts, next, CLUSTERING, heuristics)?,
    ))
}
