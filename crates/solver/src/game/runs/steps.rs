//! The steps that rules allow, forward and backward.

use crate::game::clusters::Clustering;
use crate::game::heuristics::Heuristics;
use crate::game::relation::Relation;
use crate::symbolic::{BitSet, Kernel, Limit};
use std::sync::{Arc, Mutex, PoisonError};

/// How the parts of a relation are combined.
const CLUSTERING: Clustering = Clustering::ByBits(3_000);

/// Minimum number of nodes of a set for which the clusters of a relation are rescheduled: with a
/// smaller one, all orders look equally good.
const RESCHEDULED_NODES: usize = 300;

/// Factor by which sets have to grow until the clusters are rescheduled again.
const RESCHEDULED_FACTOR: usize = 4;

/// The relation for steps in one direction.
#[derive(Debug)]
struct Direction<K: Kernel> {
    relation: Relation<K>,
    /// Minimum number of nodes of a set for which the clusters are rescheduled.
    due: usize,
}

impl<K: Kernel> Direction<K> {
    fn new(relation: Relation<K>) -> Self {
        let due = if relation.count() > 1 {
            RESCHEDULED_NODES
        } else {
            usize::MAX
        };
        Self { relation, due }
    }

    /// Returns the product of a set with the relation.
    fn product(&mut self, m: &K, set: &K::Function) -> Result<K::Function, Limit> {
        if self.due < usize::MAX {
            let nodes = m.size(set);
            if nodes >= self.due {
                let product = self.relation.reschedule(m, set)?;
                m.ignore_growth();
                self.due = RESCHEDULED_FACTOR * nodes;
                return Ok(product);
            }
        }
        self.relation.product(m, set)
    }
}

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
    forward: Arc<Mutex<Option<Direction<K>>>>,
    /// Relation for backward steps, built on first use; quantifies next bits.
    backward: Arc<Mutex<Option<Direction<K>>>>,
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
        let next = self.product(&self.forward, &self.now, states)?;
        self.m.unprime(&next)
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
        self.product(&self.backward, &self.next, steps)
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

    /// Returns the product of a set with the relation in one direction, which is built on first use
    /// and quantifies the bits `gone`.
    fn product(
        &self,
        direction: &Mutex<Option<Direction<K>>>,
        gone: &BitSet,
        set: &K::Function,
    ) -> Result<K::Function, Limit> {
        let (m, parts) = (&self.m, &self.parts);
        let mut direction = direction.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(direction) = &mut *direction {
            return direction.product(m, set);
        }
        let relation = Relation::new(m, parts, gone, CLUSTERING, Heuristics::default())?;
        direction.insert(Direction::new(relation)).product(m, set)
    }
}
