//! Extracts runs as values from sets of states: back along the rings to the start, and around a
//! cycle that meets all justice.
//!
//! The cycle is searched for in a component that cannot be left. As long as the current fair state
//! reaches fair states that do not lead back to it, the search moves on to one of them. In the
//! final component, every state leads back, and every justice formula is met somewhere.

use super::Lasso;
use super::reached::ReachableStates;
use super::steps::Steps;
use crate::symbolic::{Encoding, Kernel, Limit};
use linewright_core::gr1::{Time, VarId};
use std::collections::BTreeSet;

/// Converts states to values.
pub struct Path<'a> {
    /// Encoding of the variables.
    pub encoding: &'a Encoding,
    /// Variables that the query mentions.
    pub variables: &'a BTreeSet<VarId>,
    /// Smallest value of every variable; used for those that the query does not mention.
    pub smallest: Vec<i64>,
}

/// A state: the values of all variables, and the function over the mentioned variables that holds
/// only in this state.
pub type State<F> = (Vec<i64>, F);

impl Path<'_> {
    /// Returns some state of a set; `None` if it is empty.
    pub fn state<K: Kernel>(
        &self,
        m: &K,
        states: &K::Function,
    ) -> Result<Option<State<K::Function>>, Limit> {
        let Some(bits) = m.witness(states) else {
            return Ok(None);
        };
        let mut values = self.smallest.clone();
        let mut literals = Vec::new();
        for v in self.variables {
            values[v.index()] = self.encoding.value(*v, Time::Now, &bits);
            let own = self.encoding.bits(*v, Time::Now);
            literals.extend(own.map(|bit| (bit, bits[bit.index()])));
        }
        Ok(Some((values, m.cube(&literals)?)))
    }

    /// Returns some state of a nonempty set.
    fn some<K: Kernel>(&self, m: &K, states: &K::Function) -> Result<State<K::Function>, Limit> {
        let state = self.state(m, states)?;
        Ok(state.expect("the set of states is empty; please report this"))
    }

    /// Returns a shortest run from step 0 to a state of `goal`.
    ///
    /// # Panics
    /// When no state of the goal is reachable.
    pub fn run_to<K: Kernel>(
        &self,
        reached: &mut ReachableStates<K>,
        goal: &K::Function,
    ) -> Result<Vec<State<K::Function>>, Limit> {
        let (rings, here) = reached.rings_to(goal)?;
        let m = &reached.steps.m;
        let mut run = vec![self.some(m, &here)?];
        for ring in rings.iter().rev() {
            let (_, last) = &run[run.len() - 1];
            let before = m.and(ring, &reached.steps.before(last)?)?;
            run.push(self.some(m, &before)?);
        }
        run.reverse();
        Ok(run)
    }

    /// Returns a shortest path of at least one step from a state into `goal` within a set of
    /// states, without the first state; `None` if no path exists.
    fn shortest_path<K: Kernel>(
        &self,
        steps: &Steps<K>,
        from: &K::Function,
        within: &K::Function,
        goal: &K::Function,
    ) -> Result<Option<Vec<State<K::Function>>>, Limit> {
        let m = &steps.m;
        let mut rings = vec![m.and(within, &steps.after(from)?)?];
        let mut seen = rings[0].clone();
        loop {
            let last = &rings[rings.len() - 1];
            if m.is_false(last) {
                return Ok(None);
            }
            let here = m.and(last, goal)?;
            if !m.is_false(&here) {
                let mut path = vec![self.some(m, &here)?];
                for ring in rings.iter().rev().skip(1) {
                    let (_, last) = &path[path.len() - 1];
                    let before = m.and(ring, &steps.before(last)?)?;
                    path.push(self.some(m, &before)?);
                }
                path.reverse();
                return Ok(Some(path));
            }
            let after = m.and(within, &steps.after(last)?)?;
            let new = m.and_not(&after, &seen)?;
            seen = m.or(&seen, &new)?;
            rings.push(new);
        }
    }

    /// Returns the states of a set that are reachable from a state by steps within the set, or by
    /// backward steps if `back`. Contains the state itself only if it lies on a cycle.
    fn closure<K: Kernel>(
        steps: &Steps<K>,
        from: &K::Function,
        within: &K::Function,
        back: bool,
    ) -> Result<K::Function, Limit> {
        let m = &steps.m;
        let one = |set: &K::Function| {
            let set = if back {
                steps.before(set)
            } else {
                steps.after(set)
            };
            m.and(within, &set?)
        };
        let mut all = one(from)?;
        let mut new = all.clone();
        while !m.is_false(&new) {
            new = m.and_not(&one(&new)?, &all)?;
            all = m.or(&all, &new)?;
        }
        Ok(all)
    }

    /// Returns a run that leads into the fair states and then follows a cycle within them that
    /// meets all of `again`.
    pub fn lasso<K: Kernel>(
        &self,
        reached: &mut ReachableStates<K>,
        steps: &Steps<K>,
        fair: &K::Function,
        again: &[K::Function],
    ) -> Result<Lasso, Limit> {
        let m = &steps.m;
        let mut prefix = self.run_to(reached, fair)?;

        // Moves on until all reachable fair states lead back.
        let mut component;
        loop {
            let (_, at) = &prefix[prefix.len() - 1];
            let ahead = Self::closure(steps, at, fair, false)?;
            let back = Self::closure(steps, at, fair, true)?;
            let away = m.and_not(&ahead, &back)?;
            if m.is_false(&away) {
                component = ahead;
                break;
            }
            let at = at.clone();
            let path = self.shortest_path(steps, &at, fair, &away)?;
            prefix.extend(path.expect("no path to a reachable state; please report this"));
        }
        let start = prefix
            .pop()
            .expect("the run has no state; please report this");
        component = m.or(&component, &start.1)?;

        let mut cycle = vec![start.clone()];
        for justice in again {
            let met = m.and(justice, &m.prime(&component)?)?;
            let from = m.and(&component, &steps.before_step(&met)?)?;
            let (_, at) = &cycle[cycle.len() - 1];
            if m.is_false(&m.and(at, &from)?) {
                let at = at.clone();
                let path = self.shortest_path(steps, &at, &component, &from)?;
                cycle.extend(path.expect("no path to a justice; please report this"));
            }
            // Adds the step that meets the justice formula, unless the current values alone meet
            // it.
            let (_, at) = &cycle[cycle.len() - 1];
            let by_state = m.is_false(&m.and_not(at, justice)?);
            if !by_state {
                let at = at.clone();
                let on = steps.only(justice);
                let next = m.and(&component, &on.after(&at)?)?;
                cycle.push(self.some(m, &next)?);
            }
        }
        let (_, at) = &cycle[cycle.len() - 1];
        let at = at.clone();
        let path = self.shortest_path(steps, &at, &component, &start.1)?;
        let mut path = path.expect("no path back to the start of the cycle; please report this");
        path.pop();
        cycle.extend(path);
        let values = |states: Vec<State<K::Function>>| states.into_iter().map(|s| s.0).collect();
        Ok(Lasso {
            prefix: values(prefix),
            cycle: values(cycle),
        })
    }
}
