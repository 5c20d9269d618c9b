//! Searches beside the exploration of the reachable states, which answer some queries sooner: back
//! from the states in question, and for cycles among all states.
//!
//! Most queries of a proof find no run. The exploration shows that only once it is complete, which
//! can take a hundred steps. If no state at all leads to a violation, or no cycle exists even among
//! unreachable states, a few steps are enough; but on other queries, unreachable states make the
//! same search far more expensive than the exploration. So the two take turns: a side search may
//! take as much work as the exploration has taken so far. One that needs more is interrupted, and
//! continues from its last complete step once it may take twice as much.

use super::fair;
use super::steps::Steps;
use crate::symbolic::{Kernel, Limit};

/// Work that a side search may take before the exploration has taken any.
const FIRST_WORK: u64 = 100_000;

/// Factor by which the work of an interrupted side search may grow before it continues.
const REPEAT_FACTOR: u64 = 2;

/// Decides when a side search may continue.
#[derive(Debug)]
pub struct Allowance {
    /// Work of the exploration.
    exploration: u64,
    /// Work that the exploration has to reach before the side search continues.
    due: u64,
}

impl Allowance {
    /// Starts with [`FIRST_WORK`].
    pub fn new() -> Self {
        Self {
            exploration: FIRST_WORK,
            due: 0,
        }
    }

    /// Records work of the exploration.
    pub fn add(&mut self, work: u64) {
        self.exploration += work;
    }

    /// Whether the side search may continue.
    pub fn is_due(&self) -> bool {
        self.due <= self.exploration
    }

    /// Ends the side search: it is not due again.
    pub fn end(&mut self) {
        self.due = u64::MAX;
    }

    /// Runs a part of the side search on a kernel with limited work. Returns `None` if it was
    /// interrupted; it is then due again after more work of the exploration.
    pub fn run<K: Kernel, T>(
        &mut self,
        steps: &Steps<K>,
        part: impl FnOnce(&Steps<K>) -> Result<T, Limit>,
    ) -> Result<Option<T>, Limit> {
        let m = &steps.m;
        let before = m.work();
        match part(&steps.on(m.with_work(self.exploration))) {
            Ok(found) => {
                self.due += m.work() - before;
                Ok(Some(found))
            }
            Err(Limit::Work(most)) if m.limits().max_work != Some(most) => {
                self.due = REPEAT_FACTOR * self.exploration;
                Ok(None)
            }
            // Without the unreachable states, there may be enough room.
            Err(Limit::Memory | Limit::Nodes(_)) => {
                self.end();
                Ok(None)
            }
            Err(limit) => Err(limit),
        }
    }
}

/// The states that lead to a goal, as far as they are known.
#[derive(Debug)]
pub struct BackwardSearch<K: Kernel> {
    /// The states found last.
    last: K::Function,
    /// All states found so far.
    all: K::Function,
}

impl<K: Kernel> BackwardSearch<K> {
    /// Starts from the goal.
    pub fn new(goal: &K::Function) -> Self {
        Self {
            last: goal.clone(),
            all: goal.clone(),
        }
    }

    /// Goes one step back. Returns whether there are further states, or `None` if the step was
    /// interrupted.
    pub fn step(
        &mut self,
        steps: &Steps<K>,
        allowance: &mut Allowance,
    ) -> Result<Option<bool>, Limit> {
        let found = allowance.run(steps, |steps| {
            let m = &steps.m;
            let new = m.and_not(&steps.before(&self.last)?, &self.all)?;
            let all = m.or(&self.all, &new)?;
            Ok((new, all))
        })?;
        let Some((new, all)) = found else {
            return Ok(None);
        };
        let more = !steps.m.is_false(&new);
        (self.last, self.all) = (new, all);
        steps.m.safe_point()?;
        Ok(Some(more))
    }

    /// Whether one of the states found last is in `states`.
    pub fn meets(&self, m: &K, states: &K::Function) -> Result<bool, Limit> {
        Ok(!m.is_false(&m.and(&self.last, states)?))
    }
}

/// Narrows a set of states to those, even unreachable ones, from which an infinite run meets all of
/// `again` infinitely often. Returns whether none is left, or `None` if the search was interrupted;
/// it then continues with the set.
pub fn excludes_cycle<K: Kernel>(
    steps: &Steps<K>,
    states: &mut K::Function,
    again: &[K::Function],
    allowance: &mut Allowance,
) -> Result<Option<bool>, Limit> {
    let done = allowance.run(steps, |steps| fair::narrow_to_fair(steps, states, again))?;
    Ok(done.map(|()| steps.m.is_false(states)))
}
