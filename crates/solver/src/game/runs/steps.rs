//! The steps that rules allow, forward and backward.

use crate::game::clusters::Clustering;
use crate::game::heuristics::Heuristics;
use crate::game::relation::Relation;
use crate::symbolic::{BitSet, Kernel, Limit};
use std::sync::{Arc, OnceLock};

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
    /// Relation for forward steps, built on first use; quantifies current bits.
    forward: Arc<OnceLock<Relation<K>>>,
    /// Relation for backward steps, built on first use; quantifies next bits.
    backward: Arc<OnceLock<Relation<K>>>,
    /// Current bits of the mentioned variables.
    pub now: BitSet,
    /// Next bits of the mentioned variables.
    pub next: BitSet,
}

impl<K: Kernel> Steps<K> {
    /// Creates the steps between `states` that satisfy all `parts`. `now` and `next` are the bits
    /// of the mentioned variables.
    pub fn new(
        m: K,
        states: K::Function,
        initial: K::Function,
        parts: Vec<K::Function>,
        (now, next): (BitSet, BitSet),
    ) -> Self {
        Self {
            m,
            states,
            initial,
            parts,
            forward: Arc::default(),
            backward: Arc::default(),
            now,
            next,
        }
    }

    /// Returns the successors of these states, or the states after these steps.
    pub fn after(&self, states: &K::Function) -> Result<K::Function, Limit> {
        let forward = self.relation(&self.forward, &self.now)?;
        self.m.unprime(&forward.product(&self.m, states)?)
    }

    /// Returns the predecessors of these states.
    pub fn before(&self, states: &K::Function) -> Result<K::Function, Limit> {
        self.before_step(&self.m.prime(states)?)
    }

    /// Returns the states from which one of these steps is possible.
    pub fn before_step(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        let found = self.before_any(steps)?;
        self.m.and(&self.states, &found)
    }

    /// Returns the valuations from which one of these steps is possible, even if they do not
    /// satisfy the invariants.
    pub fn before_any(&self, steps: &K::Function) -> Result<K::Function, Limit> {
        let backward = self.relation(&self.backward, &self.next)?;
        backward.product(&self.m, steps)
    }

    /// Returns the relation restricted to these steps.
    #[must_use]
    pub fn only(&self, steps: &K::Function) -> Self {
        if self.m.is_true(steps) {
            return self.clone();
        }
        let mut parts = self.parts.clone();
        parts.push(steps.clone());
        Self {
            parts,
            forward: Arc::default(),
            backward: Arc::default(),
            ..self.clone()
        }
    }

    /// Returns the same relation on another handle of the same kernel.
    pub fn on(&self, m: K) -> Self {
        Self { m, ..self.clone() }
    }

    /// Returns the relation in one direction, and builds it on first use. `gone` are the bits that
    /// it quantifies.
    fn relation<'a>(
        &self,
        known: &'a OnceLock<Relation<K>>,
        gone: &BitSet,
    ) -> Result<&'a Relation<K>, Limit> {
        if let Some(known) = known.get() {
            return Ok(known);
        }
        let built = Relation::new(
            &self.m,
            &self.parts,
            gone,
            CLUSTERING,
            Heuristics::default(),
        )?;
        Ok(known.get_or_init(|| built))
    }
}
