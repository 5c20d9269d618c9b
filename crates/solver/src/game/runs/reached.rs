//! Exploration of the reachable states, ring by ring.

use super::aside::{Allowance, BackwardSearch};
use super::steps::Steps;
use crate::symbolic::{Kernel, Limit};

/// Rings are dropped when the last one has more nodes. They are only needed for counterexamples,
/// but would make up most of the nodes that a collection keeps and that sifting moves.
const KEPT_RING_NODES: usize = 500;

/// Reachable states by number of steps. A ring contains the states that are first reached after a
/// number of steps.
#[derive(Debug, Clone)]
pub struct ReachableStates<K: Kernel> {
    /// The step relation of the query.
    pub steps: Steps<K>,
    /// The rings found so far, unless they were dropped.
    rings: Option<Vec<K::Function>>,
    /// Whether the rings were dropped and then needed: they are not dropped again.
    needed: bool,
    /// Number of rings found so far.
    pub depth: usize,
    /// The last ring found.
    last: K::Function,
    /// All reachable states so far.
    pub all: K::Function,
    /// Whether all reachable states have been found.
    pub complete: bool,
}

/// Rings, and states of the ring after them.
type Rings<K> = (Vec<<K as Kernel>::Function>, <K as Kernel>::Function);

impl<K: Kernel> ReachableStates<K> {
    /// Starts with the initial states.
    pub fn new(steps: Steps<K>) -> Self {
        let first = steps.initial.clone();
        Self {
            rings: Some(vec![first.clone()]),
            needed: false,
            depth: 1,
            last: first.clone(),
            all: first,
            complete: false,
            steps,
        }
    }

    /// Computes the next ring; returns false if there are no new states.
    pub fn grow(&mut self) -> Result<bool, Limit> {
        if self.complete {
            return Ok(false);
        }
        let m = &self.steps.m;
        let new = m.and_not(&self.steps.after(&self.last)?, &self.all)?;
        if m.is_false(&new) {
            self.complete = true;
            return Ok(false);
        }
        self.all = m.or(&self.all, &new)?;
        if let Some(rings) = &mut self.rings {
            rings.push(new.clone());
            if !self.needed && m.size(&new) > KEPT_RING_NODES {
                self.rings = None;
            }
        }
        self.last = new;
        self.depth += 1;
        self.steps.m.safe_point()?;
        Ok(true)
    }

    /// Returns the rings found so far. They are computed again if they were dropped.
    fn rings(&mut self) -> Result<Vec<K::Function>, Limit> {
        if let Some(rings) = &self.rings {
            return Ok(rings.clone());
        }
        let mut again = Self::new(self.steps.clone());
        again.needed = true;
        while again.depth < self.depth && again.grow()? {}
        self.needed = true;
        self.rings.clone_from(&again.rings);
        Ok(again.rings.unwrap_or_default())
    }

    /// Returns the rings up to the first one that contains states of `goal`, and these states.
    ///
    /// # Panics
    /// When no state of the goal is reachable.
    pub fn rings_to(&mut self, goal: &K::Function) -> Result<Rings<K>, Limit> {
        let m = self.steps.m.clone();
        let mut known = self.rings()?;
        let mut number = 0;
        loop {
            if number == known.len() {
                assert!(
                    self.grow()?,
                    "no state of the goal is reachable; please report this"
                );
                known.push(self.last.clone());
            }
            let here = m.and(&known[number], goal)?;
            if !m.is_false(&here) {
                known.truncate(number);
                return Ok((known, here));
            }
            number += 1;
        }
    }

    /// Like [`Self::grow`], with the work recorded in the allowance of a side search.
    pub fn grow_with(&mut self, allowance: &mut Allowance) -> Result<bool, Limit> {
        let before = self.steps.m.work();
        let more = self.grow()?;
        allowance.add(self.steps.m.work() - before);
        Ok(more)
    }

    /// Whether one of the steps `bad` that `last` allows begins in a reachable state. Going forward
    /// from the reachable states, this is known only once they are complete; the states in which
    /// such a step begins are a search beside it.
    pub fn meets_step(&mut self, last: &Steps<K>, bad: &K::Function) -> Result<bool, Limit> {
        let m = self.steps.m.clone();
        let mut allowance = Allowance::new();
        let mut unexamined = self.all.clone();
        loop {
            if allowance.is_due() {
                // Without `last.states`: an invariant that only the last step keeps does not
                // restrict the states before that step.
                if let Some(from) = allowance.run(last, |last| last.before_any(bad))? {
                    return self.meets(&from);
                }
            }
            let before = m.work();
            let after = last.after(&m.and(&unexamined, bad)?)?;
            allowance.add(m.work() - before);
            if !m.is_false(&after) {
                return Ok(true);
            }
            if !self.grow_with(&mut allowance)? {
                return Ok(false);
            }
            unexamined = self.last.clone();
        }
    }

    /// Whether a state of `goal` is reachable.
    pub fn meets(&mut self, goal: &K::Function) -> Result<bool, Limit> {
        let m = self.steps.m.clone();
        let is_met = |states: &K::Function| -> Result<bool, Limit> {
            Ok(!m.is_false(&m.and(states, goal)?))
        };
        if is_met(&self.all)? {
            return Ok(true);
        }
        let mut backward = BackwardSearch::new(goal);
        let mut allowance = Allowance::new();
        loop {
            if allowance.is_due() && !self.complete {
                match backward.step(&self.steps, &mut allowance)? {
                    Some(false) => return Ok(false),
                    Some(true) if backward.meets(&m, &self.all)? => return Ok(true),
                    Some(true) | None => {}
                }
                continue;
            }
            if !self.grow_with(&mut allowance)? {
                return Ok(false);
            }
            if is_met(&self.last)? {
                return Ok(true);
            }
        }
    }
}
