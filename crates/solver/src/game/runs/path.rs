//! Extracts a run in plain values from sets of states: back along the rings to the start, and round
//! a cycle that meets everything.
//!
//! The cycle is searched where there is no way out: as long as states can be reached from a fair
//! state that do not lead back to it, the search moves on to one of them. After that, everything
//! reachable leads back, and every justice is met on the way.

use super::Lasso;
use super::rule_encoder::{ReachableStates, Steps};
use crate::symbolic::{Encoding, Kernel, Limit};
use linewright_core::gr1::{Time, VarId};
use std::collections::BTreeSet;

/// Conversion of states to values.
pub struct Path<'a> {
    /// Bits of the variables.
    pub encoding: &'a Encoding,
    /// Variables that occur.
    pub variables: &'a BTreeSet<VarId>,
    /// Values for all other variables.
    pub smallest: &'a [i64],
}

/// A state: its values, and the function that holds only there (with respect to the variables that
/// occur).
pub type State<F> = (Vec<i64>, F);

impl Path<'_> {
    /// Some state of a set.
    pub fn state<K: Kernel>(
        &self,
        m: &K,
        states: &K::Function,
    ) -> Result<Option<State<K::Function>>, Limit> {
        let Some(bits) = m.witness(states) else {
            return Ok(None);
        };
        let mut values = self.smallest.to_vec();
        let mut literals = Vec::new();
        for v in self.variables {
            values[v.index()] = self.encoding.value(*v, Time::Now, &bits);
            let own = self.encoding.bits(*v, Time::Now);
            literals.extend(own.map(|bit| (bit, bits[bit.index()])));
        }
        Ok(Some((values, m.cube(&literals)?)))
    }

    fn some<K: Kernel>(&self, m: &K, states: &K::Function) -> Result<State<K::Function>, Limit> {
        let state = self.state(m, states)?;
        Ok(state.expect("a set with a state in it; please report this"))
    }

    /// A run from step 0 to a state of `goal`, which lies in this ring.
    pub fn back_to_start<K: Kernel>(
        &self,
        reached: &ReachableStates<K>,
        ring: usize,
        goal: &K::Function,
    ) -> Result<Vec<State<K::Function>>, Limit> {
        let m = &reached.steps.m;
        let mut run = vec![self.some(m, goal)?];
        for ring in reached.rings[..ring].iter().rev() {
            let (_, last) = &run[run.len() - 1];
            let before = m.and(ring, &reached.steps.before(last)?)?;
            run.push(self.some(m, &before)?);
        }
        run.reverse();
        Ok(run)
    }

    /// A shortest way of at least one step from a state into `goal`, within a set of states. The
    /// state itself is omitted. `None` if there is no way.
    fn way<K: Kernel>(
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
                let mut way = vec![self.some(m, &here)?];
                for ring in rings.iter().rev().skip(1) {
                    let (_, last) = &way[way.len() - 1];
                    let before = m.and(ring, &steps.before(last)?)?;
                    way.push(self.some(m, &before)?);
                }
                way.reverse();
                return Ok(Some(way));
            }
            let after = m.and(within, &steps.after(last)?)?;
            let new = m.and_not(&after, &seen)?;
            seen = m.or(&seen, &new)?;
            rings.push(new);
        }
    }

    /// Everything that can be reached from a state within a set, by steps in this direction; the
    /// state itself only if it recurs.
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

    /// A run into the fair states and round a cycle among them that meets all justice.
    pub fn lasso<K: Kernel>(
        &self,
        reached: &ReachableStates<K>,
        steps: &Steps<K>,
        fair: &K::Function,
        again: &[K::Function],
    ) -> Result<Lasso, Limit> {
        let m = &steps.m;
        let mut first = None;
        for (place, ring) in reached.rings.iter().enumerate() {
            let here = m.and(ring, fair)?;
            if !m.is_false(&here) {
                first = Some((place, here));
                break;
            }
        }
        let (ring, here) = first.expect("fair states are within reach; please report this");
        let run = self.back_to_start(reached, ring, &here)?;
        let mut prefix: Vec<State<K::Function>> = run;

        // Moves on to states that cannot be left for good.
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
            let way = self.way(steps, &at, fair, &away)?;
            prefix.extend(way.expect("what can be reached; please report this"));
        }
        let start = prefix
            .pop()
            .expect("at least one state; please report this");
        component = m.or(&component, &start.1)?;

        let mut cycle = vec![start.clone()];
        for justice in again {
            let met = m.and(justice, &m.prime(&component)?)?;
            let from = m.and(&component, &steps.before_step(&met)?)?;
            let (_, at) = &cycle[cycle.len() - 1];
            if m.is_false(&m.and(at, &from)?) {
                let at = at.clone();
                let way = self.way(steps, &at, &component, &from)?;
                cycle.extend(way.expect("justice within reach; please report this"));
            }
            // The step that meets it; nothing more is needed if the state alone does.
            let (_, at) = &cycle[cycle.len() - 1];
            let by_state = m.is_false(&m.and_not(at, justice)?);
            if !by_state {
                let at = at.clone();
                let on = steps.only(justice)?;
                let next = m.and(&component, &on.after(&at)?)?;
                cycle.push(self.some(m, &next)?);
            }
        }
        let (_, at) = &cycle[cycle.len() - 1];
        let at = at.clone();
        let way = self.way(steps, &at, &component, &start.1)?;
        let mut way = way.expect("a way back; please report this");
        way.pop();
        cycle.extend(way);
        let values = |states: Vec<State<K::Function>>| states.into_iter().map(|s| s.0).collect();
        Ok(Lasso {
            prefix: values(prefix),
            cycle: values(cycle),
        })
    }
}
